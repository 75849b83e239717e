//! Elementary functions in lanes, made of exact operations only.

use super::{FloatLanes, IntLanes, Lanes, MaskLanes};

/// 2^x for |x| <= 126, to about 2e-7 relative: the nearest whole power, times
/// a minimax polynomial for the rest (in Estrin's form, whose products do not
/// wait for each other).
#[inline(always)]
pub fn exp2<S: Lanes>(s: S, x: S::F) -> S::F {
    let x = x.max(s.f(-126.0)).min(s.f(126.0));
    let whole = x.round();
    let t = x - whole.to_float();
    let t2 = t * t;
    let low = (s.f(1.0) + s.f(std::f32::consts::LN_2) * t)
        + (s.f(0.240_226_46) + s.f(0.055_503_286) * t) * t2;
    let high = (s.f(0.009_618_489) + s.f(0.001_339_993_1) * t) + s.f(0.000_153_458_08) * t2;
    let p = low + high * (t2 * t2);
    p * (whole + s.i(127)).shl::<23>().bits_to_float()
}

/// log2(x) for normal x > 0, to 2e-7 and half a unit in the last place: the
/// exponent, plus a minimax polynomial for the mantissa, taken into
/// sqrt(1/2)..sqrt(2).
#[inline(always)]
pub fn log2<S: Lanes>(s: S, x: S::F) -> S::F {
    // Bits of sqrt(1/2): moves the exponent where the mantissa passes sqrt(2).
    let offset = s.i(0x3f35_04f3);
    let bits = x.to_bits();
    let exponent = (bits - offset).shr::<23>();
    let t = (bits - exponent.shl::<23>()).bits_to_float() - s.f(1.0);
    let t2 = t * t;
    let t4 = t2 * t2;
    let p0 = (s.f(1.442_694_9) - s.f(0.721_347_15) * t)
        + (s.f(0.480_922_52) - s.f(0.360_721_2) * t) * t2;
    let p4 = (s.f(0.287_656_66) - s.f(0.238_519_5) * t)
        + (s.f(0.217_379_66) - s.f(0.210_302_93) * t) * t2;
    let p = (p0 + p4 * t4) + s.f(0.125_411_24) * (t4 * t4);
    p * t + exponent.to_float()
}

/// x^y for x >= 0; 0 for x below the smallest normal number.
#[inline(always)]
pub fn pow<S: Lanes>(s: S, x: S::F, y: S::F) -> S::F {
    let tiny = s.f(f32::MIN_POSITIVE);
    let power = exp2(s, log2(s, x.max(tiny)) * y);
    x.lt(tiny).select_f(s.f(0.0), power)
}

/// Encodes linear light in 0..=1 (clamped) as sRGB in 0..=255, to 0.02: a
/// minimax polynomial of the square root, which is far smoother at the dark
/// end than the curve itself.
#[inline(always)]
pub fn linear_to_srgb_byte<S: Lanes>(s: S, linear: S::F) -> S::F {
    let x = linear.max(s.f(0.0)).min(s.f(1.0));
    let u = x.sqrt();
    let u2 = u * u;
    let low =
        (s.f(-11.164_588) + s.f(414.098_75) * u) + (s.f(-618.554_44) + s.f(1_664.618) * u) * u2;
    let high =
        (s.f(-3_011.993_4) + s.f(3_274.842_8) * u) + (s.f(-1_926.990_6) + s.f(470.162_05) * u) * u2;
    let curve = low + high * (u2 * u2);
    x.le(s.f(0.003_130_8))
        .select_f(x * s.f(12.92 * 255.0), curve)
}

#[cfg(test)]
mod tests {
    use super::super::{Kernel, LANES, Level};
    use super::*;

    struct Functions([f32; LANES], f32);

    impl Kernel for Functions {
        type Output = [[f32; LANES]; 4];
        #[inline(always)]
        fn run<S: Lanes>(self, s: S) -> Self::Output {
            let x = s.load_f(&self.0);
            let mut out = [[0.0; LANES]; 4];
            exp2(s, x).store(&mut out[0]);
            log2(s, x.max(s.f(1e-30))).store(&mut out[1]);
            pow(s, x.max(s.f(0.0)), s.f(self.1)).store(&mut out[2]);
            linear_to_srgb_byte(s, x).store(&mut out[3]);
            out
        }
    }

    /// Against the standard library, at every level.
    #[test]
    fn functions_are_accurate_and_alike_at_every_level() {
        for step in 0..4000 {
            let input: [f32; LANES] =
                std::array::from_fn(|k| (step * LANES + k) as f32 / 32_000.0 - 0.5);
            let y = 1.0 + (step % 50) as f32;
            let expected = Level::PORTABLE.run(Functions(input, y));
            for (k, x) in input.into_iter().enumerate() {
                let relative = |got: f32, exact: f64| (f64::from(got) / exact - 1.0).abs();
                let x64 = f64::from(x);
                assert!(relative(expected[0][k], x64.exp2()) < 3e-7, "2^{x}");
                if x > 0.0 {
                    assert!(
                        (f64::from(expected[1][k]) - x64.log2()).abs()
                            < 2e-7 + 6e-8 * x64.log2().abs(),
                        "log2 {x}"
                    );
                    let power = f64::from(expected[2][k]) - x64.powf(f64::from(y));
                    assert!(
                        power.abs() < 4e-6 * x64.powf(f64::from(y)).max(1e-3),
                        "{x}^{y}: {power}"
                    );
                }
                if (0.0..=1.0).contains(&x) {
                    let exact = csg::color::linear_to_srgb(x) * 255.0;
                    assert!((expected[3][k] - exact).abs() < 0.02, "sRGB {x}");
                }
            }
            for level in Level::all() {
                let got = level.run(Functions(input, y));
                assert_eq!(
                    got.map(|a| a.map(f32::to_bits)),
                    expected.map(|a| a.map(f32::to_bits))
                );
            }
        }
    }
}
