//! Units of lengths by their symbols.

use csg::LengthUnit;
use pyo3::prelude::*;

use crate::arguments::word;

const SYMBOLS: [(&str, LengthUnit); 6] = [
    ("um", LengthUnit::Micrometre),
    ("mm", LengthUnit::Millimetre),
    ("cm", LengthUnit::Centimetre),
    ("m", LengthUnit::Metre),
    ("in", LengthUnit::Inch),
    ("ft", LengthUnit::Foot),
];

pub(crate) fn named(symbol: &str) -> PyResult<LengthUnit> {
    word("unit", symbol, &SYMBOLS)
}

pub(crate) fn symbol(unit: LengthUnit) -> &'static str {
    let found = SYMBOLS.iter().find(|(_, known)| *known == unit);
    found.map_or("mm", |(symbol, _)| symbol)
}
