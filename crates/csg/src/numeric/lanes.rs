//! Numbers side by side, as many as the machine's vectors hold: formulas on
//! them read like those on single numbers, and round like those in every lane.
//!
//! Loops over arrays are left to the compiler to turn into vectors; where it
//! does not do so reliably, these say it outright.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use pulp::Simd;

/// A real number in every lane.
#[derive(Clone, Copy)]
pub(crate) struct Reals<S: Simd> {
    simd: S,
    pub lanes: S::f64s,
}

/// Whether something holds, in every lane.
#[derive(Clone, Copy)]
pub(crate) struct Bools<S: Simd> {
    simd: S,
    lanes: S::m64s,
}

/// A vector of space in every lane.
pub(crate) type Vectors<S> = [Reals<S>; 3];

impl<S: Simd> Reals<S> {
    #[inline(always)]
    pub fn new(simd: S, lanes: S::f64s) -> Self {
        Self { simd, lanes }
    }

    /// The same number in all lanes.
    #[inline(always)]
    pub fn all(simd: S, value: f64) -> Self {
        Self::new(simd, simd.splat_f64s(value))
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        let sign = Self::all(self.simd, -0.0).lanes;
        let lanes = self.simd.and_f64s(self.simd.not_f64s(sign), self.lanes);
        Self { lanes, ..self }
    }

    #[inline(always)]
    pub fn is_below(self, other: Self) -> Bools<S> {
        Bools {
            simd: self.simd,
            lanes: self.simd.less_than_f64s(self.lanes, other.lanes),
        }
    }

    #[inline(always)]
    pub fn is_at_most(self, other: Self) -> Bools<S> {
        Bools {
            simd: self.simd,
            lanes: self.simd.less_than_or_equal_f64s(self.lanes, other.lanes),
        }
    }

    /// The lesser; `other` where one of them is not a number.
    #[inline(always)]
    pub fn or_less(self, other: Self) -> Self {
        self.is_below(other).select(self, other)
    }

    /// The greater; `self` where one of them is not a number.
    #[inline(always)]
    pub fn or_more(self, other: Self) -> Self {
        self.is_below(other).select(other, self)
    }

    /// The greatest of the lanes and zero.
    #[inline(always)]
    pub fn greatest(self) -> f64 {
        let lanes: &[f64] = bytemuck::cast_slice(std::slice::from_ref(&self.lanes));
        let mut greatest = 0.0;
        for &lane in lanes {
            greatest = if lane > greatest { lane } else { greatest };
        }
        greatest
    }
}

impl<S: Simd> Bools<S> {
    /// One number where it holds, another where not.
    #[inline(always)]
    pub fn select(self, yes: Reals<S>, no: Reals<S>) -> Reals<S> {
        let simd = self.simd;
        let bits = |reals: Reals<S>| simd.transmute_u64s_f64s(reals.lanes);
        let lanes = simd.select_u64s(self.lanes, bits(yes), bits(no));
        Reals::new(simd, simd.transmute_f64s_u64s(lanes))
    }

    /// 1 where it holds, 0 where not.
    #[inline(always)]
    pub fn ones(self) -> S::u64s {
        let (one, zero) = (self.simd.splat_u64s(1), self.simd.splat_u64s(0));
        self.simd.select_u64s(self.lanes, one, zero)
    }
}

macro_rules! operator {
    ($lanes:ident, $operator:ident, $method:ident, $instruction:ident) => {
        impl<S: Simd> $operator for $lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let lanes = self.simd.$instruction(self.lanes, other.lanes);
                Self { lanes, ..self }
            }
        }
    };
}

operator!(Reals, Add, add, add_f64s);
operator!(Reals, Sub, sub, sub_f64s);
operator!(Reals, Mul, mul, mul_f64s);
operator!(Reals, Div, div, div_f64s);
operator!(Bools, BitAnd, bitand, and_m64s);
operator!(Bools, BitOr, bitor, or_m64s);

impl<S: Simd> Not for Bools<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        let lanes = self.simd.not_m64s(self.lanes);
        Self { lanes, ..self }
    }
}

#[inline(always)]
pub(crate) fn plus<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn times<S: Simd>(factor: Reals<S>, a: Vectors<S>) -> Vectors<S> {
    [factor * a[0], factor * a[1], factor * a[2]]
}

#[inline(always)]
pub(crate) fn minus<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn dot<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Reals<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
