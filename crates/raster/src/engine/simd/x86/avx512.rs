//! Sixteen lanes in one AVX-512 register.

use std::arch::x86_64::{
    __m256, __m256i, __m512, __m512d, __m512i, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ,
};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use pulp::cast;
use pulp::x86::V4;

use crate::simd::{DoubleLanes, FloatLanes, IntLanes, LANES, Lanes, MaskLanes};

#[derive(Clone, Copy)]
pub struct F4(V4, __m512);
#[derive(Clone, Copy)]
pub struct D4(V4, [__m512d; 2]);
#[derive(Clone, Copy)]
pub struct I4(V4, __m512i);
#[derive(Clone, Copy)]
pub struct M4(V4, u16);

/// Where columns 0 and 1 of eight rows of four are, and column 2 (twice).
const FIRST_COLUMNS: [i32; LANES] = [0, 4, 8, 12, 16, 20, 24, 28, 1, 5, 9, 13, 17, 21, 25, 29];
const THIRD_COLUMN: [i32; LANES] = [2, 6, 10, 14, 18, 22, 26, 30, 2, 6, 10, 14, 18, 22, 26, 30];

impl Lanes for V4 {
    type F = F4;
    type I = I4;
    type D = D4;
    type M = M4;

    #[inline(always)]
    fn f(self, value: f32) -> F4 {
        F4(self, self.avx512f._mm512_set1_ps(value))
    }
    #[inline(always)]
    fn i(self, value: i32) -> I4 {
        I4(self, self.avx512f._mm512_set1_epi32(value))
    }
    #[inline(always)]
    fn load_f(self, values: &[f32; LANES]) -> F4 {
        F4(self, cast(*values))
    }
    #[inline(always)]
    fn d(self, value: f64) -> D4 {
        D4(self, [self.avx512f._mm512_set1_pd(value); 2])
    }
    #[inline(always)]
    fn load_d(self, values: &[f64; LANES]) -> D4 {
        D4(self, cast(*values))
    }
    #[inline(always)]
    fn load_i(self, values: &[i32; LANES]) -> I4 {
        I4(self, cast(*values))
    }
    #[inline(always)]
    fn columns(self, rows: &[[f32; 4]; LANES]) -> [F4; 3] {
        let f = self.avx512f;
        let rows: [__m512; 4] = cast(*rows);
        // Columns 0 and 1 of eight rows, then column 2.
        let (first, third) = (cast(FIRST_COLUMNS), cast(THIRD_COLUMN));
        let pick =
            |of, half: usize| f._mm512_permutex2var_ps(rows[2 * half], of, rows[2 * half + 1]);
        let (low, high) = (pick(first, 0), pick(first, 1));
        [
            F4(self, f._mm512_shuffle_f32x4::<0x44>(low, high)),
            F4(self, f._mm512_shuffle_f32x4::<0xee>(low, high)),
            F4(
                self,
                f._mm512_shuffle_f32x4::<0x44>(pick(third, 0), pick(third, 1)),
            ),
        ]
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> M4 {
        M4(self, bits as u16)
    }
}

macro_rules! operator4 {
    ($type:ident, $trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.0.avx512f.$instruction(self.1, other.1))
            }
        }
    };
}

operator4!(F4, Add, add, _mm512_add_ps);
operator4!(F4, Sub, sub, _mm512_sub_ps);
operator4!(F4, Mul, mul, _mm512_mul_ps);
operator4!(F4, Div, div, _mm512_div_ps);
operator4!(I4, Add, add, _mm512_add_epi32);
operator4!(I4, Sub, sub, _mm512_sub_epi32);
operator4!(I4, Mul, mul, _mm512_mullo_epi32);
operator4!(I4, BitAnd, bitand, _mm512_and_si512);
operator4!(I4, BitOr, bitor, _mm512_or_si512);

operator_d!(D4, Add, add, avx512f, _mm512_add_pd, 0 1);
operator_d!(D4, Sub, sub, avx512f, _mm512_sub_pd, 0 1);
operator_d!(D4, Mul, mul, avx512f, _mm512_mul_pd, 0 1);
operator_d!(D4, Div, div, avx512f, _mm512_div_pd, 0 1);

impl DoubleLanes<V4> for D4 {
    #[inline(always)]
    fn store(self, values: &mut [f64; LANES]) {
        *values = cast(self.1);
    }
    #[inline(always)]
    fn round(self) -> I4 {
        let (f, [a, b]) = (self.0.avx512f, self.1);
        let halves: [__m256i; 2] = [f._mm512_cvtpd_epi32(a), f._mm512_cvtpd_epi32(b)];
        I4(self.0, cast(halves))
    }
    #[inline(always)]
    fn to_single(self) -> F4 {
        let (f, [a, b]) = (self.0.avx512f, self.1);
        let halves: [__m256; 2] = [f._mm512_cvtpd_ps(a), f._mm512_cvtpd_ps(b)];
        F4(self.0, cast(halves))
    }
}

impl BitAnd for M4 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0, self.1 & other.1)
    }
}
impl BitOr for M4 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0, self.1 | other.1)
    }
}
impl Not for M4 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0, !self.1)
    }
}

impl FloatLanes<V4> for F4 {
    #[inline(always)]
    fn store(self, values: &mut [f32; LANES]) {
        *values = cast(self.1);
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0, self.0.avx512f._mm512_min_ps(self.1, other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0, self.0.avx512f._mm512_max_ps(self.1, other.1))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0, self.0.avx512f._mm512_sqrt_ps(self.1))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M4 {
        let f = self.0.avx512f;
        M4(self.0, f._mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.1, other.1))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M4 {
        let f = self.0.avx512f;
        M4(self.0, f._mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.1, other.1))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M4 {
        let f = self.0.avx512f;
        M4(self.0, f._mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.1, other.1))
    }
    #[inline(always)]
    fn round(self) -> I4 {
        I4(self.0, self.0.avx512f._mm512_cvtps_epi32(self.1))
    }
    #[inline(always)]
    fn to_bits(self) -> I4 {
        I4(self.0, cast(self.1))
    }
    #[inline(always)]
    fn to_double(self) -> D4 {
        let f = self.0.avx512f;
        let [a, b]: [__m256; 2] = cast(self.1);
        D4(self.0, [f._mm512_cvtps_pd(a), f._mm512_cvtps_pd(b)])
    }
}

impl IntLanes<V4> for I4 {
    #[inline(always)]
    fn store(self, values: &mut [i32; LANES]) {
        *values = cast(self.1);
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0, self.0.avx512f._mm512_min_epi32(self.1, other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0, self.0.avx512f._mm512_max_epi32(self.1, other.1))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M4 {
        let f = self.0.avx512f;
        M4(self.0, f._mm512_cmplt_epi32_mask(self.1, other.1))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M4 {
        let f = self.0.avx512f;
        M4(self.0, f._mm512_cmpeq_epi32_mask(self.1, other.1))
    }
    #[inline(always)]
    fn shr<const N: i32>(self) -> Self {
        let f = self.0.avx512f;
        Self(self.0, f._mm512_srav_epi32(self.1, f._mm512_set1_epi32(N)))
    }
    #[inline(always)]
    fn shl<const N: i32>(self) -> Self {
        let f = self.0.avx512f;
        Self(self.0, f._mm512_sllv_epi32(self.1, f._mm512_set1_epi32(N)))
    }
    #[inline(always)]
    fn to_float(self) -> F4 {
        F4(self.0, self.0.avx512f._mm512_cvtepi32_ps(self.1))
    }
    #[inline(always)]
    fn to_double(self) -> D4 {
        let f = self.0.avx512f;
        let [a, b]: [__m256i; 2] = cast(self.1);
        D4(self.0, [f._mm512_cvtepi32_pd(a), f._mm512_cvtepi32_pd(b)])
    }
    #[inline(always)]
    fn bits_to_float(self) -> F4 {
        F4(self.0, cast(self.1))
    }
}

impl MaskLanes<V4> for M4 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.1)
    }
    #[inline(always)]
    fn select_f(self, yes: F4, no: F4) -> F4 {
        let f = self.0.avx512f;
        F4(self.0, f._mm512_mask_blend_ps(self.1, no.1, yes.1))
    }
    #[inline(always)]
    fn select_i(self, yes: I4, no: I4) -> I4 {
        let f = self.0.avx512f;
        I4(self.0, f._mm512_mask_blend_epi32(self.1, no.1, yes.1))
    }
}
