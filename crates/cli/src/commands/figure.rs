//! Numbers as they are told: with their bounds, and no digits beyond.

use std::fmt;

use csg::brep::Bounded;
use serde::Serialize;

/// A number and where it is known to lie.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Figure {
    value: f64,
    /// Null where no bound is known.
    lower: Option<f64>,
    upper: Option<f64>,
}

impl Figure {
    /// Known to within `error`, if that is known.
    pub(crate) fn within(value: f64, error: Option<f64>) -> Self {
        // JSON knows no infinity.
        let error = error.filter(|error| error.is_finite());
        Self {
            value,
            lower: error.map(|error| value - error),
            upper: error.map(|error| value + error),
        }
    }

    /// Whether it is known to be 0.
    pub(crate) fn is_nothing(&self) -> bool {
        self.value == 0.0 && self.error().is_none() && self.upper.is_some()
    }

    /// As it was made, of whatever it is a figure.
    pub(crate) fn value(&self) -> f64 {
        self.value
    }

    /// The number with the digits that it is told with: those that the bound lets be known.
    pub(crate) fn told(&self) -> f64 {
        let told = self.to_string();
        let number = told
            .split(' ')
            .next()
            .and_then(|number| number.parse().ok());
        number.unwrap_or(self.value)
    }

    /// A bound on how far [`Figure::told`] is off, of two digits; 0 where no bound is known.
    pub(crate) fn error_told(&self) -> f64 {
        let error = self.error().unwrap_or(0.0);
        let bound = at_most(error + (self.told() - self.value).abs(), 2);
        bound.parse().unwrap_or(error)
    }

    /// As far as it is off, if that is known.
    pub(crate) fn error(&self) -> Option<f64> {
        Some(0.5 * (self.upper? - self.lower?)).filter(|error| *error > 0.0)
    }
}

/// A number rounded to so many digits.
fn rounded(number: f64, digits: usize) -> f64 {
    let rounded: f64 = format!("{number:.*e}", digits - 1)
        .parse()
        .unwrap_or(number);
    // Nothing has no sign.
    rounded + 0.0
}

/// A number with so many digits at most.
pub(crate) fn short(number: f64, digits: usize) -> String {
    let rounded = rounded(number, digits);
    if rounded != 0.0 && !(1e-5..1e15).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

/// A place of something of a size, as it is told: see [`coordinate`].
pub(crate) fn place(at: [f64; 3], size: f64, digits: usize) -> String {
    at.map(|x| short(coordinate(x, size, digits), digits))
        .join(" ")
}

/// A coordinate of something of a size, rounded: one that is less than rounding is nothing.
pub(crate) fn coordinate(x: f64, size: f64, digits: usize) -> f64 {
    let clean = if x.abs() < 1e-12 * size { 0.0 } else { x };
    rounded(clean, digits)
}

/// A bound from above: no digit less than it is.
pub(crate) fn at_most(number: f64, digits: usize) -> String {
    let unit = 10f64.powf(number.abs().log10().floor() - (digits - 1) as f64);
    let above = (number / unit).ceil() * unit;
    short(
        if unit > 0.0 && unit.is_finite() {
            above
        } else {
            number
        },
        digits,
    )
}

impl From<Bounded> for Figure {
    fn from(bounded: Bounded) -> Self {
        Self::within(bounded.value, Some(bounded.error))
    }
}

/// With as many digits as the bound lets be known, and the bound; all there are, if none is
/// known.
impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.value;
        let error = self.error().unwrap_or(0.0);
        write!(f, "{}", Bounded { value, error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_with_no_more_digits_than_are_asked_for() {
        assert_eq!(short(0.002_000_000_000_000_003_5, 6), "0.002");
        assert_eq!(short(-0.0, 3), "0");
        assert_eq!(short(123_456.789, 9), "123456.789");
        assert_eq!(short(1.234e-9, 3), "1.23e-9");
        assert_eq!(at_most(0.001_234_1, 3), "0.00124");
        assert_eq!(at_most(0.5, 3), "0.5");
        assert_eq!(at_most(0.0, 3), "0");
    }

    #[test]
    fn coordinates_that_are_rounding_are_told_as_nothing() {
        assert_eq!(place([-8.88e-16, 1.0, 0.25], 1.0, 6), "0 1 0.25");
        assert_eq!(
            place([-8.88e-16, 1e-15, 0.0], 1e-15, 3),
            "-8.88e-16 1e-15 0"
        );
    }

    #[test]
    fn figures_without_bounds_have_all_digits() {
        assert_eq!(Figure::within(2.5, None).to_string(), "2.5");
        assert_eq!(Figure::within(2.5e-12, None).to_string(), "2.5e-12");
        assert_eq!(Figure::within(2.5, Some(f64::INFINITY)).to_string(), "2.5");
        assert_eq!(
            Figure::within(4.56789, Some(0.0123)).to_string(),
            "4.57 ± 0.02"
        );
    }
}
