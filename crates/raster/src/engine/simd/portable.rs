//! Lanes as plain arrays, for any processor.

use std::array::from_fn;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use super::{DoubleLanes, FloatLanes, IntLanes, LANES, Lanes, MaskLanes, triple};

/// The level without instruction set extensions.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

#[derive(Clone, Copy)]
pub struct Floats([f32; LANES]);
#[derive(Clone, Copy)]
pub struct Doubles([f64; LANES]);
#[derive(Clone, Copy)]
pub struct Ints([i32; LANES]);
/// -1 or 0 a lane, which compilers vectorise better than bits.
#[derive(Clone, Copy)]
pub struct Masks([i32; LANES]);

impl Lanes for Portable {
    type F = Floats;
    type I = Ints;
    type D = Doubles;
    type M = Masks;

    #[inline(always)]
    fn f(self, value: f32) -> Floats {
        Floats([value; LANES])
    }
    #[inline(always)]
    fn i(self, value: i32) -> Ints {
        Ints([value; LANES])
    }
    #[inline(always)]
    fn load_f(self, values: &[f32; LANES]) -> Floats {
        Floats(*values)
    }
    #[inline(always)]
    fn d(self, value: f64) -> Doubles {
        Doubles([value; LANES])
    }
    #[inline(always)]
    fn load_d(self, values: &[f64; LANES]) -> Doubles {
        Doubles(*values)
    }
    #[inline(always)]
    fn load_i(self, values: &[i32; LANES]) -> Ints {
        Ints(*values)
    }
    #[inline(always)]
    fn columns(self, rows: &[[f32; 4]; LANES]) -> [Floats; 3] {
        triple!(|K| Floats(from_fn(|k| rows[k][K])))
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Masks {
        Masks(from_fn(|k| -((bits >> k & 1) as i32)))
    }
}

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, |$a:ident, $b:ident| $value:expr) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(from_fn(|k| {
                    let ($a, $b) = (self.0[k], other.0[k]);
                    $value
                }))
            }
        }
    };
}

operator!(Floats, Add, add, |a, b| a + b);
operator!(Floats, Sub, sub, |a, b| a - b);
operator!(Floats, Mul, mul, |a, b| a * b);
operator!(Floats, Div, div, |a, b| a / b);
operator!(Doubles, Add, add, |a, b| a + b);
operator!(Doubles, Sub, sub, |a, b| a - b);
operator!(Doubles, Mul, mul, |a, b| a * b);
operator!(Doubles, Div, div, |a, b| a / b);
operator!(Ints, Add, add, |a, b| a.wrapping_add(b));
operator!(Ints, Sub, sub, |a, b| a.wrapping_sub(b));
operator!(Ints, Mul, mul, |a, b| a.wrapping_mul(b));
operator!(Ints, BitAnd, bitand, |a, b| a & b);
operator!(Ints, BitOr, bitor, |a, b| a | b);
operator!(Masks, BitAnd, bitand, |a, b| a & b);
operator!(Masks, BitOr, bitor, |a, b| a | b);

impl Not for Masks {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|m| !m))
    }
}

impl FloatLanes<Portable> for Floats {
    #[inline(always)]
    fn store(self, values: &mut [f32; LANES]) {
        *values = self.0;
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(from_fn(|k| {
            if self.0[k] < other.0[k] {
                self.0[k]
            } else {
                other.0[k]
            }
        }))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(from_fn(|k| {
            if self.0[k] > other.0[k] {
                self.0[k]
            } else {
                other.0[k]
            }
        }))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Masks {
        Masks(from_fn(|k| -i32::from(self.0[k] < other.0[k])))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Masks {
        Masks(from_fn(|k| -i32::from(self.0[k] <= other.0[k])))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Masks {
        Masks(from_fn(|k| -i32::from(self.0[k] == other.0[k])))
    }
    #[inline(always)]
    fn round(self) -> Ints {
        // Adding 1.5 * 2^23 would do for small values; this holds for all.
        Ints(self.0.map(|v| v.round_ties_even() as i32))
    }
    #[inline(always)]
    fn to_bits(self) -> Ints {
        Ints(self.0.map(|v| v.to_bits().cast_signed()))
    }
    #[inline(always)]
    fn to_double(self) -> Doubles {
        Doubles(self.0.map(f64::from))
    }
}

impl DoubleLanes<Portable> for Doubles {
    #[inline(always)]
    fn store(self, values: &mut [f64; LANES]) {
        *values = self.0;
    }
    #[inline(always)]
    fn round(self) -> Ints {
        Ints(self.0.map(|v| v.round_ties_even() as i32))
    }
    #[inline(always)]
    fn to_single(self) -> Floats {
        Floats(self.0.map(|v| v as f32))
    }
}

impl IntLanes<Portable> for Ints {
    #[inline(always)]
    fn store(self, values: &mut [i32; LANES]) {
        *values = self.0;
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k].min(other.0[k])))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k].max(other.0[k])))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Masks {
        Masks(from_fn(|k| -i32::from(self.0[k] < other.0[k])))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Masks {
        Masks(from_fn(|k| -i32::from(self.0[k] == other.0[k])))
    }
    #[inline(always)]
    fn shr<const N: i32>(self) -> Self {
        Self(self.0.map(|v| v >> N))
    }
    #[inline(always)]
    fn shl<const N: i32>(self) -> Self {
        Self(self.0.map(|v| v << N))
    }
    #[inline(always)]
    fn to_float(self) -> Floats {
        Floats(self.0.map(|v| v as f32))
    }
    #[inline(always)]
    fn to_double(self) -> Doubles {
        Doubles(self.0.map(f64::from))
    }
    #[inline(always)]
    fn bits_to_float(self) -> Floats {
        Floats(self.0.map(|v| f32::from_bits(v.cast_unsigned())))
    }
}

impl MaskLanes<Portable> for Masks {
    #[inline(always)]
    fn bits(self) -> u32 {
        let mut bits = 0;
        for (k, m) in self.0.into_iter().enumerate() {
            bits |= (m.cast_unsigned() & 1) << k;
        }
        bits
    }
    #[inline(always)]
    fn select_f(self, yes: Floats, no: Floats) -> Floats {
        Floats(from_fn(|k| if self.0[k] != 0 { yes.0[k] } else { no.0[k] }))
    }
    #[inline(always)]
    fn select_i(self, yes: Ints, no: Ints) -> Ints {
        Ints(from_fn(|k| if self.0[k] != 0 { yes.0[k] } else { no.0[k] }))
    }
}
