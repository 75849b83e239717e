//! Sixteen lanes in pairs of AVX2 registers.

use std::arch::x86_64::{
    __m128, __m128i, __m256, __m256d, __m256i, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ,
};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use pulp::cast;
use pulp::x86::V3;

use crate::simd::{DoubleLanes, FloatLanes, IntLanes, LANES, Lanes, MaskLanes, triple};

#[derive(Clone, Copy)]
pub struct F3(V3, [__m256; 2]);
#[derive(Clone, Copy)]
pub struct D3(V3, [__m256d; 4]);
#[derive(Clone, Copy)]
pub struct I3(V3, [__m256i; 2]);
/// All bits of a lane set, or none.
#[derive(Clone, Copy)]
pub struct M3(V3, [__m256i; 2]);

/// Lane numbers as bits, to compare masks with.
const LANE_BITS: [i32; LANES] = {
    let mut bits = [0; LANES];
    let mut k = 0;
    while k < LANES {
        bits[k] = 1 << k;
        k += 1;
    }
    bits
};

impl Lanes for V3 {
    type F = F3;
    type I = I3;
    type D = D3;
    type M = M3;

    #[inline(always)]
    fn f(self, value: f32) -> F3 {
        F3(self, [self.avx._mm256_set1_ps(value); 2])
    }
    #[inline(always)]
    fn i(self, value: i32) -> I3 {
        I3(self, [self.avx._mm256_set1_epi32(value); 2])
    }
    #[inline(always)]
    fn load_f(self, values: &[f32; LANES]) -> F3 {
        F3(self, cast(*values))
    }
    #[inline(always)]
    fn d(self, value: f64) -> D3 {
        D3(self, [self.avx._mm256_set1_pd(value); 4])
    }
    #[inline(always)]
    fn load_d(self, values: &[f64; LANES]) -> D3 {
        D3(self, cast(*values))
    }
    #[inline(always)]
    fn load_i(self, values: &[i32; LANES]) -> I3 {
        I3(self, cast(*values))
    }
    #[inline(always)]
    fn columns(self, rows: &[[f32; 4]; LANES]) -> [F3; 3] {
        let f = self.avx;
        let rows: [__m256; 8] = cast(*rows);
        // Of eight rows each: rows k and k + 4 side by side, then the columns
        // of four rows in both halves.
        let half = |k: usize| {
            let [a, b] = [rows[k], rows[k + 1]];
            let [c, d] = [rows[k + 2], rows[k + 3]];
            let row0 = f._mm256_permute2f128_ps::<0x20>(a, c);
            let row1 = f._mm256_permute2f128_ps::<0x31>(a, c);
            let row2 = f._mm256_permute2f128_ps::<0x20>(b, d);
            let row3 = f._mm256_permute2f128_ps::<0x31>(b, d);
            let low = f._mm256_unpacklo_ps(row0, row1);
            let high = f._mm256_unpacklo_ps(row2, row3);
            let third = f._mm256_unpackhi_ps(row0, row1);
            let last = f._mm256_unpackhi_ps(row2, row3);
            [
                f._mm256_shuffle_ps::<0x44>(low, high),
                f._mm256_shuffle_ps::<0xee>(low, high),
                f._mm256_shuffle_ps::<0x44>(third, last),
            ]
        };
        let (first, second) = (half(0), half(4));
        triple!(|K| F3(self, [first[K], second[K]]))
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> M3 {
        let lanes = self.load_i(&LANE_BITS);
        (self.i(bits.cast_signed()) & lanes).eq(lanes)
    }
}

macro_rules! operator3 {
    ($type:ident, $trait:ident, $method:ident, $set:ident, $instruction:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let [a, b] = self.1;
                let [c, d] = other.1;
                let set = self.0.$set;
                Self(self.0, [set.$instruction(a, c), set.$instruction(b, d)])
            }
        }
    };
}

operator3!(F3, Add, add, avx, _mm256_add_ps);
operator3!(F3, Sub, sub, avx, _mm256_sub_ps);
operator3!(F3, Mul, mul, avx, _mm256_mul_ps);
operator3!(F3, Div, div, avx, _mm256_div_ps);
operator3!(I3, Add, add, avx2, _mm256_add_epi32);
operator3!(I3, Sub, sub, avx2, _mm256_sub_epi32);
operator3!(I3, Mul, mul, avx2, _mm256_mullo_epi32);
operator3!(I3, BitAnd, bitand, avx2, _mm256_and_si256);
operator3!(I3, BitOr, bitor, avx2, _mm256_or_si256);
operator3!(M3, BitAnd, bitand, avx2, _mm256_and_si256);
operator3!(M3, BitOr, bitor, avx2, _mm256_or_si256);
operator_d!(D3, Add, add, avx, _mm256_add_pd, 0 1 2 3);
operator_d!(D3, Sub, sub, avx, _mm256_sub_pd, 0 1 2 3);
operator_d!(D3, Mul, mul, avx, _mm256_mul_pd, 0 1 2 3);
operator_d!(D3, Div, div, avx, _mm256_div_pd, 0 1 2 3);

impl Not for M3 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        let ones = self.0.avx._mm256_set1_epi32(-1);
        let xor = self.0.avx2;
        Self(
            self.0,
            [
                xor._mm256_xor_si256(self.1[0], ones),
                xor._mm256_xor_si256(self.1[1], ones),
            ],
        )
    }
}

impl F3 {
    #[inline(always)]
    fn pair(self, other: Self, f: impl Fn(__m256, __m256) -> __m256) -> Self {
        Self(self.0, [f(self.1[0], other.1[0]), f(self.1[1], other.1[1])])
    }
    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(__m256, __m256) -> __m256) -> M3 {
        let [low, high] = self.pair(other, f).1;
        M3(self.0, [cast(low), cast(high)])
    }
}

impl I3 {
    #[inline(always)]
    fn pair(self, other: Self, f: impl Fn(__m256i, __m256i) -> __m256i) -> Self {
        Self(self.0, [f(self.1[0], other.1[0]), f(self.1[1], other.1[1])])
    }
}

impl DoubleLanes<V3> for D3 {
    #[inline(always)]
    fn store(self, values: &mut [f64; LANES]) {
        *values = cast(self.1);
    }
    #[inline(always)]
    fn round(self) -> I3 {
        let (f, [a, b, c, d]) = (self.0.avx, self.1);
        let quarters: [__m128i; 4] = [
            f._mm256_cvtpd_epi32(a),
            f._mm256_cvtpd_epi32(b),
            f._mm256_cvtpd_epi32(c),
            f._mm256_cvtpd_epi32(d),
        ];
        I3(self.0, cast(quarters))
    }
    #[inline(always)]
    fn to_single(self) -> F3 {
        let (f, [a, b, c, d]) = (self.0.avx, self.1);
        let quarters: [__m128; 4] = [
            f._mm256_cvtpd_ps(a),
            f._mm256_cvtpd_ps(b),
            f._mm256_cvtpd_ps(c),
            f._mm256_cvtpd_ps(d),
        ];
        F3(self.0, cast(quarters))
    }
}

impl FloatLanes<V3> for F3 {
    #[inline(always)]
    fn store(self, values: &mut [f32; LANES]) {
        *values = cast(self.1);
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.pair(other, |a, b| self.0.avx._mm256_min_ps(a, b))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.pair(other, |a, b| self.0.avx._mm256_max_ps(a, b))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let sqrt = self.0.avx;
        Self(
            self.0,
            [
                sqrt._mm256_sqrt_ps(self.1[0]),
                sqrt._mm256_sqrt_ps(self.1[1]),
            ],
        )
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M3 {
        self.compare(other, |a, b| self.0.avx._mm256_cmp_ps::<_CMP_LT_OQ>(a, b))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M3 {
        self.compare(other, |a, b| self.0.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a, b))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M3 {
        self.compare(other, |a, b| self.0.avx._mm256_cmp_ps::<_CMP_EQ_OQ>(a, b))
    }
    #[inline(always)]
    fn round(self) -> I3 {
        let avx = self.0.avx;
        I3(
            self.0,
            [
                avx._mm256_cvtps_epi32(self.1[0]),
                avx._mm256_cvtps_epi32(self.1[1]),
            ],
        )
    }
    #[inline(always)]
    fn to_bits(self) -> I3 {
        I3(self.0, [cast(self.1[0]), cast(self.1[1])])
    }
    #[inline(always)]
    fn to_double(self) -> D3 {
        let f = self.0.avx;
        let [a, b, c, d]: [__m128; 4] = cast(self.1);
        let to = [
            f._mm256_cvtps_pd(a),
            f._mm256_cvtps_pd(b),
            f._mm256_cvtps_pd(c),
            f._mm256_cvtps_pd(d),
        ];
        D3(self.0, to)
    }
}

impl IntLanes<V3> for I3 {
    #[inline(always)]
    fn store(self, values: &mut [i32; LANES]) {
        *values = cast(self.1);
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.pair(other, |a, b| self.0.avx2._mm256_min_epi32(a, b))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.pair(other, |a, b| self.0.avx2._mm256_max_epi32(a, b))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M3 {
        let less = self.pair(other, |a, b| self.0.avx2._mm256_cmpgt_epi32(b, a));
        M3(self.0, less.1)
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M3 {
        let equal = self.pair(other, |a, b| self.0.avx2._mm256_cmpeq_epi32(a, b));
        M3(self.0, equal.1)
    }
    #[inline(always)]
    fn shr<const N: i32>(self) -> Self {
        let n = self.0.i(N);
        self.pair(n, |a, n| self.0.avx2._mm256_srav_epi32(a, n))
    }
    #[inline(always)]
    fn shl<const N: i32>(self) -> Self {
        let n = self.0.i(N);
        self.pair(n, |a, n| self.0.avx2._mm256_sllv_epi32(a, n))
    }
    #[inline(always)]
    fn to_float(self) -> F3 {
        let avx = self.0.avx;
        F3(
            self.0,
            [
                avx._mm256_cvtepi32_ps(self.1[0]),
                avx._mm256_cvtepi32_ps(self.1[1]),
            ],
        )
    }
    #[inline(always)]
    fn to_double(self) -> D3 {
        let f = self.0.avx;
        let [a, b, c, d]: [__m128i; 4] = cast(self.1);
        let to = [
            f._mm256_cvtepi32_pd(a),
            f._mm256_cvtepi32_pd(b),
            f._mm256_cvtepi32_pd(c),
            f._mm256_cvtepi32_pd(d),
        ];
        D3(self.0, to)
    }
    #[inline(always)]
    fn bits_to_float(self) -> F3 {
        F3(self.0, [cast(self.1[0]), cast(self.1[1])])
    }
}

impl MaskLanes<V3> for M3 {
    #[inline(always)]
    fn bits(self) -> u32 {
        let avx = self.0.avx;
        let low = avx._mm256_movemask_ps(cast(self.1[0])).cast_unsigned();
        let high = avx._mm256_movemask_ps(cast(self.1[1])).cast_unsigned();
        low | high << 8
    }
    #[inline(always)]
    fn select_f(self, yes: F3, no: F3) -> F3 {
        let blend = |k: usize| {
            self.0
                .avx
                ._mm256_blendv_ps(no.1[k], yes.1[k], cast(self.1[k]))
        };
        F3(self.0, [blend(0), blend(1)])
    }
    #[inline(always)]
    fn select_i(self, yes: I3, no: I3) -> I3 {
        let blend = |k: usize| self.0.avx2._mm256_blendv_epi8(no.1[k], yes.1[k], self.1[k]);
        I3(self.0, [blend(0), blend(1)])
    }
    #[inline(always)]
    fn update_f(self, yes: F3, old: F3) -> F3 {
        self.update_i(yes.to_bits(), old.to_bits()).bits_to_float()
    }
    #[inline(always)]
    fn update_i(self, yes: I3, old: I3) -> I3 {
        let set = self.0.avx2;
        let merge = |k: usize| {
            let change = set._mm256_xor_si256(yes.1[k], old.1[k]);
            let change = set._mm256_and_si256(change, self.1[k]);
            set._mm256_xor_si256(old.1[k], change)
        };
        I3(self.0, [merge(0), merge(1)])
    }
}
