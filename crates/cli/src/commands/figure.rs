//! Numbers as they are told: with their bounds, and no digits beyond.

use std::fmt;

use csg::brep::Bounded;
use serde::Serialize;

/// A number and where it is known to lie.
#[derive(Clone, Copy, Debug, Serialize)]
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

    /// As far as it is off, if that is known.
    fn error(&self) -> Option<f64> {
        Some(0.5 * (self.upper? - self.lower?)).filter(|error| *error > 0.0)
    }
}

impl From<Bounded> for Figure {
    fn from(bounded: Bounded) -> Self {
        Self::within(bounded.value, Some(bounded.error))
    }
}

/// With as many decimals as the bound lets be known, and the bound; all there are, if none is
/// known.
impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(error) = self.error() else {
            return write!(f, "{}", self.value);
        };
        // One digit of the bound, rounded up.
        let power = error.log10().floor();
        let decimals = (-power).clamp(0.0, 17.0) as usize;
        let unit = 10f64.powf(power);
        let rounded = (error / unit).ceil();
        let bound = if power < -4.0 {
            format!("{rounded}e{power}")
        } else {
            format!("{:.decimals$}", rounded * unit)
        };
        // Nothing has no sign.
        let value = if self.value.abs() < error {
            0.0
        } else {
            self.value
        };
        write!(f, "{value:.decimals$} ± {bound}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_end_where_the_bound_begins() {
        let told = |value, error| Figure::within(value, error).to_string();
        assert_eq!(
            told(0.709_425_518_258_427, Some(1.21e-13)),
            "0.7094255182584 ± 2e-13"
        );
        assert_eq!(told(4.56789, Some(0.0123)), "4.57 ± 0.02");
        assert_eq!(told(1234.567, Some(37.0)), "1235 ± 40");
        assert_eq!(told(-1e-17, Some(3e-13)), "0.0000000000000 ± 3e-13");
        assert_eq!(told(2.5, None), "2.5");
        assert_eq!(told(2.5, Some(f64::INFINITY)), "2.5");
        assert_eq!(told(0.0, Some(0.0)), "0");
    }
}
