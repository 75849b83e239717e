//! Lanes in AVX-512 registers, and in pairs of AVX2 registers.

use pulp::NullaryFnOnce;

use super::{Kernel, Lanes};

/// A kernel together with the level it runs at.
pub struct At<S, K>(pub S, pub K);

impl<S: Lanes, K: Kernel> NullaryFnOnce for At<S, K> {
    type Output = K::Output;
    #[inline(always)]
    fn call(self) -> K::Output {
        self.1.run(self.0)
    }
}

// An operator of doubles, of which each register is a part.
macro_rules! operator_d {
    ($type:ident, $trait:ident, $method:ident, $set:ident, $instruction:ident, $($part:literal)+) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let (a, b, set) = (self.1, other.1, self.0.$set);
                Self(self.0, [$(set.$instruction(a[$part], b[$part])),+])
            }
        }
    };
}

mod avx2;
mod avx512;
