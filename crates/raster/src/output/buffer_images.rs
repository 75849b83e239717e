//! Pictures of what buffers hold.

use glam::Vec3;

use crate::buffers::Buffer;
use crate::image::Image;

/// Depth as a grey picture: white near, dark far, between the least and the
/// greatest depth that occur; transparent where there is nothing.
#[must_use]
pub fn depth_image(depth: &Buffer<f32>) -> Image {
    let drawn = || depth.values.iter().copied().filter(|&d| d < 1.0);
    let (low, high) = drawn().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), d| {
        (low.min(d), high.max(d))
    });
    let range = (high - low).max(f32::MIN_POSITIVE);
    to_image(depth, |d| {
        let grey = (255.0 - 215.0 * (d - low) / range).round() as u8;
        if d < 1.0 {
            [grey, grey, grey, 255]
        } else {
            [0; 4]
        }
    })
}

/// Normals as colours: (n + 1) / 2 in red, green and blue, not gamma-encoded;
/// transparent where there is nothing.
#[must_use]
pub fn normal_image(normals: &Buffer<Vec3>) -> Image {
    to_image(normals, |n| {
        if n == Vec3::ZERO {
            return [0; 4];
        }
        let [r, g, b] = n
            .to_array()
            .map(|c| (c.midpoint(1.0) * 255.0).round().clamp(0.0, 255.0) as u8);
        [r, g, b, 255]
    })
}

/// Numbers (of surfaces or triangles) as well separated colours; transparent
/// where there is none.
#[must_use]
pub fn id_image(ids: &Buffer<Option<u32>>) -> Image {
    to_image(ids, |id| {
        id.map_or([0; 4], |id| {
            // Fibonacci hashing spreads neighbouring numbers over all hues.
            let hash = (id + 1).wrapping_mul(0x9e37_79b9);
            let [a, b, c, _] = hash.to_be_bytes();
            let bright = |v: u8| 64 + v / 4 * 3;
            [bright(a), bright(b), bright(c), 255]
        })
    })
}

fn to_image<T: Copy>(buffer: &Buffer<T>, colour: impl Fn(T) -> [u8; 4]) -> Image {
    Image {
        width: buffer.width,
        height: buffer.height,
        pixels: buffer.values.iter().map(|&v| colour(v)).collect(),
    }
}
