//! Points, planes, lengths and colours as they are written on the command line.

use std::convert::Infallible;
use std::ops::RangeInclusive;

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

/// A plane as it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WrittenPlane {
    /// Across it, of any length.
    pub(super) normal: DVec3,
    /// On it.
    pub(super) point: DVec3,
    /// Whether it was written by an axis, as in `y=0`.
    pub(super) is_by_axis: bool,
}

/// A plane across an axis, or by a direction and a point.
pub(super) fn plane(text: &str) -> Result<WrittenPlane, String> {
    let plane = match text.split_once('=') {
        Some((axis, position)) => {
            let (axis, sign) = match axis.trim().strip_prefix('-') {
                Some(axis) => (axis, -1.0),
                None => (axis.trim(), 1.0),
            };
            let axis = match axis {
                "x" | "X" => Some(DVec3::X),
                "y" | "Y" => Some(DVec3::Y),
                "z" | "Z" => Some(DVec3::Z),
                _ => None,
            };
            let position = position.trim().parse().ok().filter(|p: &f64| p.is_finite());
            axis.zip(position).map(|(axis, position)| WrittenPlane {
                normal: axis * sign,
                point: axis * position,
                is_by_axis: true,
            })
        }
        None => text.split_once(':').and_then(|(normal, at)| {
            let normal = point(normal).filter(|n| *n != DVec3::ZERO)?;
            Some(WrittenPlane {
                normal,
                point: point(at)?,
                is_by_axis: false,
            })
        }),
    };
    plane.ok_or_else(|| "give a plane like y=0 or -z=2.5, or 1,1,0:0,0,0".into())
}

/// Reads whole numbers of a range.
pub(crate) fn whole<T: TryFrom<u64> + Clone>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.trim().parse().ok();
        let number = number.filter(|number| range.contains(number));
        let (least, most) = (range.start(), range.end());
        number
            .and_then(|number| T::try_from(number).ok())
            .ok_or_else(|| match *most {
                u64::MAX => format!("give a whole number from {least}"),
                most => format!("give a whole number from {least} to {most}"),
            })
    }
}

/// A length above 0.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    match text.trim().parse() {
        Ok(length) if length > 0.0 && length < f64::INFINITY => Ok(length),
        _ => Err("give a length above 0, in the model's unit".into()),
    }
}

/// A distance from the eye.
pub(super) fn depth(text: &str) -> Result<f64, String> {
    match text.trim().parse() {
        Ok(depth) if (0.0..f64::INFINITY).contains(&depth) => Ok(depth),
        _ => Err("give a distance from the eye, in the model's unit: above 0, or 0 for the near plane of a parallel projection".into()),
    }
}

/// An angle in degrees between the least and a half turn.
pub(crate) fn angle(text: &str) -> Result<f64, String> {
    match text.trim().parse() {
        Ok(degrees) if degrees > 0.0 && degrees <= 180.0 => Ok(degrees),
        _ => Err("give an angle above 0 and up to 180 degrees".into()),
    }
}

/// A colour as style sheets write it, sRGB: `#ffffff`, with or without the `#`, `white`,
/// `rgb(255, 255, 255)`.
pub(super) fn color(text: &str) -> Result<Color, String> {
    let parsed = csscolorparser::parse(text).map_err(
        |_| "give a colour like #ffffff, white or rgb(255,255,255), as style sheets have them",
    )?;
    Ok(Color::from_srgb([parsed.r, parsed.g, parsed.b]).with_alpha(parsed.a))
}

/// OpenSCAD's colour schemes are not known here.
pub(super) fn scheme(_: &str) -> Result<Infallible, String> {
    Err("colour schemes are OpenSCAD's alone: give --background, and colours in the model".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors() {
        let red = Ok(Color::from_srgb([1.0, 0.0, 0.0]));
        for text in ["ff0000", "#ff0000", "#F00", "red", "Red", "rgb(255,0,0)"] {
            assert_eq!(color(text), red, "{text}");
        }
        for faulty in ["", "gg0000", "+f0000", "ff00000", "reddish"] {
            assert!(color(faulty).is_err(), "{faulty}");
        }
    }

    #[test]
    fn planes() {
        let cases = [
            ("y=0", DVec3::Y, DVec3::ZERO),
            ("-z=2.5", DVec3::NEG_Z, DVec3::new(0.0, 0.0, 2.5)),
            (
                "1,1,0:3,4,5",
                DVec3::new(1.0, 1.0, 0.0),
                DVec3::new(3.0, 4.0, 5.0),
            ),
        ];
        for (text, normal, point) in cases {
            let is_by_axis = text.contains('=');
            let wanted = WrittenPlane {
                normal,
                point,
                is_by_axis,
            };
            assert_eq!(plane(text), Ok(wanted));
        }
        for faulty in ["", "y", "w=1", "y=", "y=nan", "0,0,0:1,1,1", "1,2:3,4,5"] {
            assert!(plane(faulty).is_err(), "{faulty}");
        }
    }

    #[test]
    fn lengths_and_angles() {
        assert_eq!(length("0.5"), Ok(0.5));
        assert_eq!(angle("180"), Ok(180.0));
        let cells = whole::<u32>(1..=65536);
        assert_eq!(cells("65536"), Ok(65536));
        for faulty in ["0", "1.5", "-1", "65537", "1e3", ""] {
            let said = cells(faulty).expect_err(faulty);
            assert_eq!(said, "give a whole number from 1 to 65536");
        }
        for faulty in ["0", "-1", "inf", "nan", "1mm", ""] {
            assert!(length(faulty).is_err(), "{faulty}");
        }
        for faulty in ["0", "-1", "181", "nan", ""] {
            assert!(angle(faulty).is_err(), "{faulty}");
        }
    }
}
