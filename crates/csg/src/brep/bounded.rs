//! Numbers with bounds on their errors.

use crate::elementary;
use std::fmt;

/// A number that is known to within a bound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounded {
    /// The number.
    pub value: f64,
    /// It is off by no more: by what refining it once more changed, and rounding.
    pub error: f64,
}

impl Bounded {
    /// The least that it may be.
    #[must_use]
    pub fn lower(&self) -> f64 {
        self.value - self.error
    }

    /// The most that it may be.
    #[must_use]
    pub fn upper(&self) -> f64 {
        self.value + self.error
    }
}

/// With as many decimals as the bound lets be known, and one digit of the bound, rounded up;
/// all there are, if it is 0 or not finite.
///
/// ```
/// use csg::brep::Bounded;
///
/// let volume = Bounded { value: 0.709_425_518_258_427, error: 1.21e-13 };
/// assert_eq!(volume.to_string(), "0.7094255182584 ± 2e-13");
/// ```
impl fmt::Display for Bounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { value, error } = *self;
        if !(error > 0.0 && error.is_finite()) {
            return write!(f, "{value}");
        }
        let rounded_at = |power| (error / elementary::pow(10f64, power)).ceil();
        let mut power = elementary::log10(error).floor();
        if rounded_at(power) >= 10.0 {
            power += 1.0;
        }
        let rounded = rounded_at(power);
        let decimals = (-power).clamp(0.0, 17.0) as usize;
        let bound = if power < -4.0 {
            format!("{rounded}e{power}")
        } else {
            format!("{:.decimals$}", rounded * elementary::pow(10f64, power))
        };
        let told = format!("{value:.decimals$}");
        // Nothing has no sign.
        let is_nothing = told.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
        let told = told.trim_start_matches(if is_nothing { "-" } else { "" });
        write!(f, "{told} ± {bound}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_end_where_the_bound_begins() {
        let told = |value, error| Bounded { value, error }.to_string();
        assert_eq!(
            told(0.709_425_518_258_427, 1.21e-13),
            "0.7094255182584 ± 2e-13"
        );
        assert_eq!(told(4.56789, 0.0123), "4.57 ± 0.02");
        assert_eq!(told(1234.567, 37.0), "1235 ± 40");
        assert_eq!(told(-1e-17, 3e-13), "0.0000000000000 ± 3e-13");
        assert_eq!(told(1.0, 9.6e-14), "1.0000000000000 ± 1e-13");
        assert_eq!(told(1.0, 0.96), "1 ± 1");
        assert_eq!(told(209.6, 371.0), "210 ± 400");
        assert_eq!(told(2.5, f64::INFINITY), "2.5");
        assert_eq!(told(0.0, 0.0), "0");
    }
}
