//! Points and colours as they are written on the command line.

use csg::Color;
use glam::DVec3;

/// Three finite numbers with commas between them.
pub(super) fn point(text: &str) -> Option<DVec3> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|number| number.trim().parse())
        .collect::<Result<_, _>>()
        .ok()?;
    let [x, y, z] = numbers[..] else {
        return None;
    };
    Some(DVec3::new(x, y, z)).filter(|point| point.is_finite())
}

/// Six hexadecimal digits, sRGB.
pub(super) fn color(text: &str) -> Result<Color, String> {
    let fault = || "give six hexadecimal digits, like ffffff".to_owned();
    if text.len() != 6 || !text.bytes().all(|b| b.is_ascii_hexdigit()) {
        return Err(fault());
    }
    let value = u32::from_str_radix(text, 16).map_err(|_| fault())?;
    let [_, r, g, b] = value.to_be_bytes();
    Ok(Color::from_srgb([r, g, b].map(|c| f32::from(c) / 255.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors() {
        assert_eq!(color("ff0000"), Ok(Color::from_srgb([1.0, 0.0, 0.0])));
        for faulty in ["", "fff", "gg0000", "+f0000", "ff00000"] {
            assert!(color(faulty).is_err(), "{faulty}");
        }
    }
}
