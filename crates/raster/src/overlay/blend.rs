//! Blending of finished pixels, in linear light.

use std::sync::LazyLock;

use csg::Color;
use csg::color::srgb_to_linear;

/// Each sRGB byte in linear light.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| srgb_to_linear(byte as f32 / 255.0)));

/// The linear light of an sRGB byte.
pub(crate) fn decode(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

/// Linear light, clamped to 0..=1, as an sRGB byte: the polynomial of
/// [`linear_to_srgb_byte`](crate::simd::math::linear_to_srgb_byte), right to
/// 0.02 before it is rounded.
pub(crate) fn encode(linear: f32) -> u8 {
    let u = linear.clamp(0.0, 1.0).sqrt();
    let u2 = u * u;
    let low = (-11.164_588 + 414.098_75 * u) + (-618.554_44 + 1_664.618 * u) * u2;
    let high = (-3_011.993_4 + 3_274.842_8 * u) + (-1_926.990_6 + 470.162_05 * u) * u2;
    let curve = low + high * (u2 * u2);
    let byte = if linear <= 0.003_130_8 {
        linear.max(0.0) * (12.92 * 255.0)
    } else {
        curve
    };
    (byte + 0.5) as u8
}

/// A colour of the given opacity over a pixel.
pub(crate) fn over(pixel: [u8; 4], color: Color, alpha: f32) -> [u8; 4] {
    let below = f32::from(pixel[3]) / 255.0 * (1.0 - alpha);
    let opacity = alpha + below;
    let divisor = opacity.max(f32::MIN_POSITIVE);
    let mix = |k: usize| encode((color.rgb[k] * alpha + decode(pixel[k]) * below) / divisor);
    [mix(0), mix(1), mix(2), opacity_byte(opacity)]
}

/// A pixel over a colour of the given opacity.
pub(crate) fn under(pixel: [u8; 4], color: Color, alpha: f32) -> [u8; 4] {
    let above = f32::from(pixel[3]) / 255.0;
    let below = alpha * (1.0 - above);
    let opacity = above + below;
    let divisor = opacity.max(f32::MIN_POSITIVE);
    let mix = |k: usize| encode((decode(pixel[k]) * above + color.rgb[k] * below) / divisor);
    [mix(0), mix(1), mix(2), opacity_byte(opacity)]
}

fn opacity_byte(opacity: f32) -> u8 {
    (opacity.min(1.0) * 255.0 + 0.5) as u8
}
