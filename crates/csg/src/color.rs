//! Colours: linear RGBA inside, sRGB only where a name says so.

use crate::elementary;
use serde::{Deserialize, Serialize};

/// A colour in linear RGB with straight (not premultiplied) opacity; every
/// component in 0..=1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Color {
    /// Linear red, green and blue.
    pub rgb: [f32; 3],
    /// Opacity: 1 is opaque.
    pub alpha: f32,
}

impl Color {
    /// An opaque colour from linear components in 0..=1.
    #[must_use]
    pub const fn from_linear(rgb: [f32; 3]) -> Self {
        Self { rgb, alpha: 1.0 }
    }

    /// An opaque colour from sRGB-encoded components in 0..=1, as colour
    /// pickers and style sheets give them.
    #[must_use]
    pub fn from_srgb(rgb: [f32; 3]) -> Self {
        Self::from_linear(rgb.map(srgb_to_linear))
    }

    /// The same colour with another opacity.
    #[must_use]
    pub const fn with_alpha(self, alpha: f32) -> Self {
        Self { alpha, ..self }
    }

    /// The sRGB-encoded components in 0..=1.
    #[must_use]
    pub fn to_srgb(self) -> [f32; 3] {
        self.rgb.map(linear_to_srgb)
    }
}

/// Decodes one sRGB component (IEC 61966-2-1).
#[must_use]
pub fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        power((encoded + 0.055) / 1.055, 2.4)
    }
}

/// Encodes one linear component as sRGB (IEC 61966-2-1).
#[must_use]
pub fn linear_to_srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * power(linear, 1.0 / 2.4) - 0.055
    }
}

fn power(x: f32, y: f64) -> f32 {
    elementary::pow(f64::from(x), y) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trips() {
        for i in 0..=255u8 {
            let encoded = f32::from(i) / 255.0;
            let back = linear_to_srgb(srgb_to_linear(encoded));
            assert!((back - encoded).abs() < 1e-6, "{i}: {back}");
        }
        // IEC 61966-2-1's mid grey.
        assert!((srgb_to_linear(0.5) - 0.214_041).abs() < 1e-6);
    }
}
