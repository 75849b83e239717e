//! The names that files give to units of length.

use csg::{LengthUnit, Mesh};

const ALL: [LengthUnit; 6] = [
    LengthUnit::Micrometre,
    LengthUnit::Millimetre,
    LengthUnit::Centimetre,
    LengthUnit::Metre,
    LengthUnit::Inch,
    LengthUnit::Foot,
];

/// The unit's name, as comments and glTF extras give it.
pub(crate) const fn name(unit: LengthUnit) -> &'static str {
    match unit {
        LengthUnit::Micrometre => "micrometre",
        LengthUnit::Millimetre => "millimetre",
        LengthUnit::Centimetre => "centimetre",
        LengthUnit::Metre => "metre",
        LengthUnit::Inch => "inch",
        LengthUnit::Foot => "foot",
    }
}

/// The unit of that name.
pub(crate) fn named(text: &str) -> Option<LengthUnit> {
    ALL.into_iter().find(|&unit| name(unit) == text)
}

/// A unit in nanometres.
const fn in_nanometres(unit: LengthUnit) -> f64 {
    match unit {
        LengthUnit::Micrometre => 1e3,
        LengthUnit::Millimetre => 1e6,
        LengthUnit::Centimetre => 1e7,
        LengthUnit::Metre => 1e9,
        LengthUnit::Inch => 25_400_000.0,
        LengthUnit::Foot => 304_800_000.0,
    }
}

/// How many of the unit `to` one of `from` is, rounded once: 25.4 for millimetres of an inch.
#[must_use]
pub fn unit_ratio(from: LengthUnit, to: LengthUnit) -> f64 {
    in_nanometres(from) / in_nanometres(to)
}

/// Gives a mesh another unit, and its lengths in that. What was converted to a smaller unit and
/// back is off by no more than two roundings.
pub(crate) fn convert(mesh: &mut Mesh, to: LengthUnit) {
    let (up, down) = (unit_ratio(mesh.unit, to), unit_ratio(to, mesh.unit));
    if mesh.unit != to {
        for position in &mut mesh.positions {
            *position = if up >= 1.0 {
                *position * up
            } else {
                *position / down
            };
        }
    }
    mesh.unit = to;
}
