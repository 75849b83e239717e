//! The names that files give to units of length.

use csg::LengthUnit;

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
