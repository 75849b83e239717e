//! Points and colours as they are written on the command line.

use csg::Color;
use glam::DVec3;

/// So many finite numbers with commas between them.
pub(super) fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers = text.split(',').map(|number| number.trim().parse());
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().ok()?;
    let all_finite = numbers.iter().all(|number| number.is_finite());
    numbers.try_into().ok().filter(|_| all_finite)
}

/// Three finite numbers with commas between them.
pub(super) fn point(text: &str) -> Option<DVec3> {
    numbers(text).map(DVec3::from_array)
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
