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
        let value = self.value;
        let error = self.error().unwrap_or(0.0);
        write!(f, "{}", Bounded { value, error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_without_bounds_have_all_digits() {
        assert_eq!(Figure::within(2.5, None).to_string(), "2.5");
        assert_eq!(Figure::within(2.5, Some(f64::INFINITY)).to_string(), "2.5");
        assert_eq!(
            Figure::within(4.56789, Some(0.0123)).to_string(),
            "4.57 ± 0.02"
        );
    }
}
