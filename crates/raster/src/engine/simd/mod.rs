//! Sixteen lanes of arithmetic, at one of three levels chosen at run time.
//!
//! Kernels are written once over [`Lanes`] and run by [`Level::run`] on
//! AVX-512 (one register), AVX2 (two registers) or portable arrays. Every
//! operation is an IEEE 754 or two's complement operation with one defined
//! result (no fused multiply-add, no approximate reciprocals), so all levels
//! give the same bytes.
//!
//! The instruction sets come from `pulp`, whose tokens prove at run time that
//! the processor has them; nothing here is unsafe. (`fearless_simd` asks for
//! more of AVX-512 than the first server generations have, `wide` chooses at
//! compile time. The portable arrays, compiled for AVX2 by `pulp`, take 1.2 to
//! 2.1 times as long for a frame as AVX2's own lanes, with 4x MSAA 1.6 to 2.1
//! times: these are worth their lines.)

pub mod math;
mod portable;
pub mod vector;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

pub use portable::Portable;

/// An array of three vectors, element by element. Inside kernels this takes
/// the place of `array::map` and `array::from_fn`, whose inner closures the
/// compiler may leave as functions without the level's instructions.
macro_rules! triple {
    (|$k:ident| $value:expr) => {
        [
            {
                const $k: usize = 0;
                $value
            },
            {
                const $k: usize = 1;
                $value
            },
            {
                const $k: usize = 2;
                $value
            },
        ]
    };
}
pub(crate) use triple;

/// Number of lanes.
pub const LANES: usize = 16;

/// 0 to 15.
pub const LANE_NUMBERS: [f32; LANES] = [
    0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
];

/// A level of instruction set: makes vectors of [`LANES`] lanes.
pub trait Lanes: Copy + Send + Sync + 'static {
    /// 32-bit floats.
    type F: FloatLanes<Self>;
    /// 32-bit integers.
    type I: IntLanes<Self>;
    /// 64-bit floats.
    type D: DoubleLanes<Self>;
    /// One truth value a lane.
    type M: MaskLanes<Self>;

    /// The same float in all lanes.
    fn f(self, value: f32) -> Self::F;
    /// The same integer in all lanes.
    fn i(self, value: i32) -> Self::I;
    /// Floats from memory.
    fn load_f(self, values: &[f32; LANES]) -> Self::F;
    /// The same double in all lanes.
    fn d(self, value: f64) -> Self::D;
    /// Doubles from memory.
    fn load_d(self, values: &[f64; LANES]) -> Self::D;
    /// Integers from memory.
    fn load_i(self, values: &[i32; LANES]) -> Self::I;
    /// The first three columns of 16 rows: lane k is from row k.
    fn columns(self, rows: &[[f32; 4]; LANES]) -> [Self::F; 3];
    /// Lane k is true where bit k is set.
    fn mask(self, bits: u32) -> Self::M;
}

/// Floats in lanes.
pub trait FloatLanes<S: Lanes>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// To memory.
    fn store(self, values: &mut [f32; LANES]);
    /// `if self < other { self } else { other }`.
    fn min(self, other: Self) -> Self;
    /// `if self > other { self } else { other }`.
    fn max(self, other: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// `self < other`; false for NaN.
    fn lt(self, other: Self) -> S::M;
    /// `self <= other`; false for NaN.
    fn le(self, other: Self) -> S::M;
    /// `self == other`; false for NaN.
    fn eq(self, other: Self) -> S::M;
    /// Nearest integer, ties to even; for |self| < 2^31.
    fn round(self) -> S::I;
    /// The bit pattern.
    fn to_bits(self) -> S::I;
    /// The same number in 64 bits.
    fn to_double(self) -> S::D;
}

/// Doubles in lanes.
pub trait DoubleLanes<S: Lanes>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// To memory.
    fn store(self, values: &mut [f64; LANES]);
    /// Nearest integer, ties to even; for |self| < 2^31.
    fn round(self) -> S::I;
    /// Rounded to 32 bits.
    fn to_single(self) -> S::F;
}

/// Integers in lanes; arithmetic wraps.
pub trait IntLanes<S: Lanes>:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
{
    /// To memory.
    fn store(self, values: &mut [i32; LANES]);
    /// The lesser.
    fn min(self, other: Self) -> Self;
    /// The greater.
    fn max(self, other: Self) -> Self;
    /// `self < other`.
    fn lt(self, other: Self) -> S::M;
    /// `self == other`.
    fn eq(self, other: Self) -> S::M;
    /// Arithmetic shift right, 0 < N < 32.
    fn shr<const N: i32>(self) -> Self;
    /// Shift left, 0 < N < 32.
    fn shl<const N: i32>(self) -> Self;
    /// As floats, rounded to nearest.
    fn to_float(self) -> S::F;
    /// As doubles, which hold them exactly.
    fn to_double(self) -> S::D;
    /// The float of that bit pattern.
    fn bits_to_float(self) -> S::F;
}

/// Truth values in lanes.
pub trait MaskLanes<S: Lanes>:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// Bit k is lane k.
    fn bits(self) -> u32;
    /// Lane by lane, `yes` where true, `no` elsewhere.
    fn select_f(self, yes: S::F, no: S::F) -> S::F;
    /// Lane by lane, `yes` where true, `no` elsewhere.
    fn select_i(self, yes: S::I, no: S::I) -> S::I;
    /// [`select_f`](Self::select_f) of a value and what stood in memory, for
    /// storing back there. Compilers turn a plain selection into a masked
    /// store, which takes AMD's processors twenty times as long.
    #[inline(always)]
    fn update_f(self, yes: S::F, old: S::F) -> S::F {
        self.select_f(yes, old)
    }
    /// The same for integers.
    #[inline(always)]
    fn update_i(self, yes: S::I, old: S::I) -> S::I {
        self.select_i(yes, old)
    }
}

/// Something to run at a level. Implementations mark `run` and all it calls
/// `#[inline(always)]`, so that the whole is compiled for the level.
pub trait Kernel {
    /// What it gives.
    type Output;
    /// The work.
    fn run<S: Lanes>(self, s: S) -> Self::Output;
}

/// The level of instruction set to run kernels at.
#[derive(Clone, Copy, Debug)]
pub struct Level(Inner);

#[derive(Clone, Copy, Debug)]
enum Inner {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    #[cfg(target_arch = "x86_64")]
    Avx512(pulp::x86::V4),
}

impl Default for Level {
    fn default() -> Self {
        Self::best()
    }
}

impl Level {
    /// The portable level, which every machine has.
    pub const PORTABLE: Self = Self(Inner::Portable);

    /// The best level this machine has.
    #[must_use]
    pub fn best() -> Self {
        Self::all().last().copied().unwrap_or(Self::PORTABLE)
    }

    /// All levels this machine has, the simplest first.
    #[must_use]
    pub fn all() -> &'static [Self] {
        static ALL: std::sync::OnceLock<Vec<Level>> = std::sync::OnceLock::new();
        ALL.get_or_init(|| {
            #[allow(unused_mut, reason = "other architectures have no more levels")]
            let mut all = vec![Self::PORTABLE];
            #[cfg(target_arch = "x86_64")]
            {
                all.extend(pulp::x86::V3::try_new().map(|token| Self(Inner::Avx2(token))));
                all.extend(pulp::x86::V4::try_new().map(|token| Self(Inner::Avx512(token))));
            }
            all
        })
    }

    /// `portable`, `avx2` or `avx512`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            Inner::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Inner::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Inner::Avx512(_) => "avx512",
        }
    }

    /// Runs a kernel at this level.
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Inner::Portable => kernel.run(Portable),
            #[cfg(target_arch = "x86_64")]
            Inner::Avx2(token) => token.vectorize(x86::At(token, kernel)),
            #[cfg(target_arch = "x86_64")]
            Inner::Avx512(token) => token.vectorize(x86::At(token, kernel)),
        }
    }
}
