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

/// With as many digits as the bound lets be known, and one digit of the bound, rounded up;
/// all there are, if it is 0 or not finite. Numbers of less than 1e-4, and from 1e15 on, are told with
/// an exponent.
///
/// ```
/// use csg::brep::Bounded;
///
/// let volume = Bounded { value: 0.709_425_518_258_427, error: 1.21e-13 };
/// assert_eq!(volume.to_string(), "0.7094255182584 ± 2e-13");
/// let tiny = Bounded { value: 4.188_790_204_786_39e-36, error: 4.8e-49 };
/// assert_eq!(tiny.to_string(), "4.1887902047864e-36 ± 5e-49");
/// ```
impl fmt::Display for Bounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Nothing has no sign.
        let Self { value, error } = *self;
        let is_plain = |number: f64| number == 0.0 || (1e-4..1e15).contains(&number.abs());
        if !(error > 0.0 && error.is_finite()) {
            return match is_plain(value) || !value.is_finite() {
                true => write!(f, "{}", value + 0.0),
                false => write!(f, "{value:e}"),
            };
        }
        let (digit, power) = digit_above(error);
        let decimals = (-power).max(0) as usize;
        let told = format!("{value:.decimals$}");
        let is_nothing = told.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
        let has_exponent = !is_nothing && !is_plain(value);
        let told = if has_exponent {
            let leading = exponent(&format!("{value:e}"));
            let digits = (leading - power).max(0) as usize;
            format!("{value:.digits$e}")
        } else if is_nothing && decimals > 17 {
            "0".to_owned()
        } else {
            told.trim_start_matches(if is_nothing { "-" } else { "" })
                .to_owned()
        };
        if (-4..15).contains(&power) && !has_exponent {
            let bound = f64::from(digit) * elementary::pow(10f64, f64::from(power));
            write!(f, "{told} ± {bound:.decimals$}")
        } else {
            write!(f, "{told} ± {digit}e{power}")
        }
    }
}

/// The least digit and power of ten whose product is no less than a number, which is above 0.
fn digit_above(number: f64) -> (u32, i32) {
    // (As few decimal digits as tell the number: powers of ten are not exact.)
    let told = format!("{number:e}");
    let power = exponent(&told);
    let first = told.bytes().next().map_or(0, |byte| u32::from(byte - b'0'));
    let mantissa = told.split('e').next().unwrap_or_default();
    let is_more = mantissa
        .bytes()
        .skip(1)
        .any(|byte| matches!(byte, b'1'..=b'9'));
    match first + u32::from(is_more) {
        10 => (1, power + 1),
        digit => (digit, power),
    }
}

/// The exponent of a number that is told with one.
fn exponent(told: &str) -> i32 {
    let exponent = told.rsplit('e').next();
    exponent.and_then(|e| e.parse().ok()).unwrap_or_default()
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
        assert_eq!(told(-0.0, 0.0), "0");
    }

    #[test]
    fn small_and_large_numbers_have_as_many_digits_as_others() {
        let told = |value, error| Bounded { value, error }.to_string();
        assert_eq!(told(4.188_790_2e-36, 3e-43), "4.1887902e-36 ± 3e-43");
        assert_eq!(told(-4.188_790_2e-36, 3e-40), "-4.1888e-36 ± 3e-40");
        assert_eq!(told(3e-40, 2e-36), "0 ± 2e-36");
        assert_eq!(told(-3e-26, 1e-25), "0 ± 1e-25");
        assert_eq!(told(3.665_19e36, 5e29), "3.6651900e36 ± 5e29");
        assert_eq!(told(1.335_176_9e25, 2e12), "1.3351769000000e25 ± 2e12");
        assert_eq!(told(1.5e20, 9.6e20), "2e20 ± 1e21");
        assert_eq!(told(0.000_123_456, 1e-7), "0.0001235 ± 1e-7");
        assert_eq!(told(0.000_012_345_6, 1e-8), "1.235e-5 ± 1e-8");
        assert_eq!(told(0.5, 3e-20), "0.50000000000000000000 ± 3e-20");
        assert_eq!(told(5e-324, 0.0), "5e-324");
        assert_eq!(told(5e-324, 5e-324), "5e-324 ± 5e-324");
        assert_eq!(told(-1.25e300, 0.0), "-1.25e300");
        assert_eq!(told(f64::NAN, 0.0), "NaN");
    }

    /// What is told holds what is known, whatever the numbers are.
    #[test]
    fn what_is_told_is_no_narrower_than_the_bound() {
        for k in 1..4000_i32 {
            let value =
                elementary::sin(f64::from(k)) * elementary::pow(10.0, f64::from(k % 61 - 30));
            let error = value.abs() * elementary::pow(10.0, f64::from(-(k % 13)));
            let told = Bounded { value, error }.to_string();
            let mut parts = told
                .split(" ± ")
                .map(|part| part.parse::<f64>().expect("a number"));
            let (number, bound) = (
                parts.next().expect("a value"),
                parts.next().expect("a bound"),
            );
            assert!(
                bound >= error * (1.0 - 1e-15) && bound <= 10.0 * error,
                "{told}: {error}"
            );
            // Half a digit of the bound is lost at most.
            assert!(
                (number - value).abs() <= 0.500_001 * bound,
                "{told}: {value}"
            );
        }
    }
}
