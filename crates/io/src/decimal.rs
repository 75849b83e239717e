//! Decimal numbers in text, eight digits at a time and rounded exactly.
//!
//! Text formats are mostly numbers, and reading one is mostly finding out how
//! long it is: a byte at a time that takes a branch for each, mispredicted at
//! the end of every number. Here eight bytes are looked at as one word.

/// Powers of ten that fit 64 bits.
const POWERS: [u64; 20] = {
    let mut powers = [1; 20];
    let mut k = 1;
    while k < 20 {
        powers[k] = powers[k - 1] * 10;
        k += 1;
    }
    powers
};

/// Most digits of a whole number that always fits 64 bits.
const MOST_DIGITS: usize = 19;

/// The number that `text` begins with, rounded to nearest, and how many bytes
/// it takes. `None` where there is none, or one that is seldom seen (a plus
/// sign in front, more than 19 digits, or an exponent that moves the point
/// beyond the last of them or by more than 19 places to the left):
/// [`str::parse`] knows all.
#[inline]
pub(crate) fn number(text: &[u8]) -> Option<(f64, usize)> {
    let negative = text.first() == Some(&b'-');
    let mut at = usize::from(negative);
    let mut mantissa = 0;
    let mut digits = match text.get(at..at + 2) {
        // (Most have one digit before the point: another branch foreseen.)
        Some([digit @ b'0'..=b'9', b'.']) => {
            mantissa = u64::from(digit - b'0');
            at += 1;
            1
        }
        _ => append_digits(text, &mut at, &mut mantissa),
    };
    let mut scale = 0;
    if text.get(at) == Some(&b'.') {
        at += 1;
        let decimals = append_digits(text, &mut at, &mut mantissa);
        digits += decimals;
        scale = decimals as i64;
    }
    if digits == 0 || digits > MOST_DIGITS {
        return None;
    }
    if let Some(b'e' | b'E') = text.get(at) {
        let sign = text.get(at + 1);
        let negative = sign == Some(&b'-');
        at += 1 + usize::from(negative || sign == Some(&b'+'));
        let mut exponent = 0;
        if !(1..=4).contains(&append_digits(text, &mut at, &mut exponent)) {
            return None;
        }
        scale += exponent as i64 * if negative { 1 } else { -1 };
    }
    let divisor = *POWERS.get(usize::try_from(scale).ok()?)?;
    let size = quotient(mantissa, divisor);
    Some((if negative { -size } else { size }, at))
}

/// The whole number that `text` begins with and how many digits it has, if
/// these are at least one and at most 19.
#[inline]
pub(crate) fn whole_number(text: &[u8]) -> Option<(u64, usize)> {
    let (number, digits) = leading_digits(text);
    if digits < 8 {
        return (digits > 0).then_some((number, digits));
    }
    let (mut at, mut number) = (0, 0);
    let digits = append_digits(text, &mut at, &mut number);
    (digits <= MOST_DIGITS).then_some((number, at))
}

/// Appends the digits at a position to a number and goes past them; returns
/// how many they are. (The number is right if all of its digits are no more
/// than [`MOST_DIGITS`].)
#[inline]
fn append_digits(text: &[u8], at: &mut usize, number: &mut u64) -> usize {
    let start = *at;
    loop {
        let (value, count) = leading_digits(text.get(*at..).unwrap_or_default());
        *number = number.wrapping_mul(POWERS[count]).wrapping_add(value);
        // (Eight by name: a branch, which is foreseen, so that the next word
        // is fetched before the count of this one is known.)
        if count == 8 {
            *at += 8;
        } else {
            *at += count;
            return *at - start;
        }
    }
}

/// The number that up to eight leading digits make, and how many there are
/// (Lemire, *Number parsing at a gigabyte per second*, 2021, section 6).
#[inline]
fn leading_digits(text: &[u8]) -> (u64, usize) {
    const ONES: u64 = 0x0101_0101_0101_0101;
    let word = match text.first_chunk() {
        Some(chunk) => u64::from_le_bytes(*chunk),
        None => {
            let mut padded = [0; 8];
            padded[..text.len()].copy_from_slice(text);
            u64::from_le_bytes(padded)
        }
    };
    // A digit's upper half is 3, also after adding 6. (What is carried out of
    // a byte is carried out of one that is no digit, into those after it.)
    let upper = 0xf0 * ONES;
    let other = ((word & upper) | (word.wrapping_add(6 * ONES) & upper) >> 4) ^ (0x33 * ONES);
    let count = other.trailing_zeros() as usize / 8;
    if count == 0 {
        return (0, 0);
    }
    // Zeros in front, then pairs, fours and all eight.
    let digits = (word << (64 - 8 * count)) & (0x0f * ONES);
    let pairs = digits.wrapping_mul(10) + (digits >> 8);
    let even = 0x0000_00ff_0000_00ff;
    let fours = (pairs & even).wrapping_mul(100 + (1_000_000 << 32));
    let eight = fours.wrapping_add(((pairs >> 16) & even).wrapping_mul(1 + (10_000 << 32)));
    (eight >> 32, count)
}

/// n / d, d at least 1, to the nearest double, ties to even.
#[inline]
fn quotient(n: u64, d: u64) -> f64 {
    // Both are exact in double precision (as powers of ten up to 22 are), and
    // division rounds once (Clinger, *How to read floating point numbers
    // accurately*, 1990).
    if n < 1 << 53 {
        return n as f64 / d as f64;
    }
    // A quotient of 63 or 64 bits, the last of which says whether anything is
    // left over, rounds as the true one does.
    let (shift_n, shift_d) = (n.leading_zeros(), d.leading_zeros());
    let (n, d) = (u128::from(n << shift_n) << 63, u128::from(d << shift_d));
    let whole = n / d;
    let bits = whole as u64 | u64::from(whole * d != n);
    let exponent = 1023 - 63 - u64::from(shift_n) + u64::from(shift_d);
    bits as f64 * f64::from_bits(exponent << 52)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// What is read is what the standard library reads.
    fn agrees(text: &str) -> bool {
        let found = number(text.as_bytes()).expect("a plain number");
        let length = text.len();
        let expected: f64 = text.parse().expect("a number");
        (found.0.to_bits(), found.1) == (expected.to_bits(), length)
    }

    #[test]
    fn plain_numbers() {
        let cases = [
            "0",
            "-0",
            "7",
            "-12.5",
            ".5",
            "5.",
            "0.1",
            "1e5x",
            "123456789012345678",
            "9007199254740993",
            "9007199254740992.5",
            "0.3333333333333333",
            "1.7976931348623157e-3",
            "8.5065080835204e-05",
            "18014398509481986e-1",
            "1.234560e+00",
            "-12.5E+1",
            "0.000000000000000001",
            ".0000000000000000001",
            "9999999999999999999",
            "9999999999999999999e-19",
            "4e-0019",
        ];
        for case in cases {
            let text = case.trim_end_matches('x');
            if text == "1e5" {
                assert_eq!(number(case.as_bytes()), None);
            } else {
                assert!(agrees(text), "{text}");
            }
        }
        assert_eq!(number(b"12.50 7"), Some((12.5, 5)));
        assert_eq!(number(b"3//4"), Some((3.0, 1)));
        assert_eq!(whole_number(b"1234567890/1"), Some((1_234_567_890, 10)));
    }

    #[test]
    fn others_are_left_to_the_standard_library() {
        let others = [
            "",
            "-",
            ".",
            "+1",
            "inf",
            "nan",
            "x1",
            "1e",
            "1e-",
            "1e+",
            "1e+-1",
            "1e400",
            "1e30",
            "5e-324",
            "1e-20",
            "e5",
            "12345678901234567890",
            "0.00000000000000000001",
            "1e-99999",
        ];
        for other in others {
            assert_eq!(number(other.as_bytes()), None, "{other}");
        }
        for other in ["", "-1", "/", "12345678901234567890"] {
            assert_eq!(whole_number(other.as_bytes()), None, "{other}");
        }
    }

    proptest! {
        #[test]
        fn rounded_as_by_the_standard_library(
            mantissa in 0..10_000_000_000_000_000_000u64,
            drop in 0..19u32,
            point in 0..19usize,
            sign: bool,
        ) {
            let digits = (mantissa / 10u64.pow(drop)).to_string();
            let point = point.min(digits.len());
            let (whole, decimals) = digits.split_at(point);
            let sign = if sign { "-" } else { "" };
            let text = format!("{sign}{whole}.{decimals}");
            prop_assert!(agrees(&text), "{text}");
        }

        /// Halfway between doubles, and next to that.
        #[test]
        fn ties_go_to_even(mantissa in 1u64 << 52..1 << 53, shift in 1..=9u32, off in -1..=1i64) {
            let tie = (2 * mantissa + 1) << (shift - 1);
            let text = tie.wrapping_add_signed(off).to_string();
            prop_assert!(agrees(&text), "{text}");
        }

        #[test]
        fn shortest_digits_return(number in -1e6..1e6f64) {
            let text = number.to_string();
            prop_assume!(text.trim_start_matches(['-', '.', '0']).len() <= 19);
            prop_assert_eq!(super::number(text.as_bytes()).map(|n| n.0), Some(number));
        }

        #[test]
        fn any_bytes_do(text: Vec<u8>) {
            if let Some((value, length)) = number(&text) {
                let text = std::str::from_utf8(&text[..length]).expect("digits");
                prop_assert_eq!(text.parse(), Ok(value));
            }
        }
    }
}
