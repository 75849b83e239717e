//! Elementary functions that are the same, to the last bit, on every machine.
//!
//! Sums, products, quotients and square roots are rounded as IEEE 754 says, wherever a program
//! runs; sines and powers are what the system's library makes of them. These are the functions
//! of the crate `libm` (a port of musl's; errors below one unit in the last place), so that a
//! model has the same vertices on all systems and in a browser. In this crate, `io` and `view`
//! Clippy refuses the standard library's (`clippy.toml`).

use glam::{DMat3, DVec2, DVec3};

macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident = $of:ident ($($argument:ident),+);)+) => {
        $(
            $(#[$doc])*
            #[must_use]
            #[inline]
            pub fn $name($($argument: f64),+) -> f64 {
                libm::$of($($argument),+)
            }
        )+
    };
}

functions! {
    /// The sine of an angle in radians.
    sin = sin(x);
    /// The cosine of an angle in radians.
    cos = cos(x);
    /// The tangent of an angle in radians.
    tan = tan(x);
    /// The angle in -π/2..=π/2 that has this sine; NaN beyond -1..=1.
    asin = asin(x);
    /// The angle in 0..=π that has this cosine; NaN beyond -1..=1.
    acos = acos(x);
    /// The angle in -π/2..=π/2 that has this tangent.
    atan = atan(x);
    /// The angle of the direction (x, y), in -π..=π.
    atan2 = atan2(y, x);
    /// The hyperbolic sine.
    sinh = sinh(x);
    /// The hyperbolic cosine.
    cosh = cosh(x);
    /// The inverse of the hyperbolic sine.
    asinh = asinh(x);
    /// The inverse of the hyperbolic cosine; NaN below 1.
    acosh = acosh(x);
    /// The inverse of the hyperbolic tangent; NaN beyond -1..=1.
    atanh = atanh(x);
    /// 2 to the power of `x`.
    exp2 = exp2(x);
    /// The logarithm to the base e; NaN below 0.
    ln = log(x);
    /// The logarithm to the base 2; NaN below 0.
    log2 = log2(x);
    /// The logarithm to the base 10; NaN below 0.
    log10 = log10(x);
    /// `x` to the power of `y`.
    pow = pow(x, y);
    /// The length of (x, y), without overflow on the way.
    hypot = hypot(x, y);
}

/// Sine and cosine of an angle in radians.
#[must_use]
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// The direction at an angle in radians from the x axis.
#[must_use]
pub fn direction(angle: f64) -> DVec2 {
    let (sin, cos) = sin_cos(angle);
    DVec2::new(cos, sin)
}

/// The angle in radians between two directions, in 0..=π.
#[must_use]
pub fn angle_between(a: DVec3, b: DVec3) -> f64 {
    let cosine = a.dot(b) / (a.length_squared() * b.length_squared()).sqrt();
    acos(cosine.clamp(-1.0, 1.0))
}

/// The angle in radians by which one direction turns to another, in -π..=π.
#[must_use]
pub fn turn(from: DVec2, to: DVec2) -> f64 {
    let cosine = from.dot(to) / (from.length_squared() * to.length_squared()).sqrt();
    acos(cosine.clamp(-1.0, 1.0)) * from.perp_dot(to).signum()
}

/// The rotation about the x axis by an angle in radians.
#[must_use]
pub fn rotation_x(angle: f64) -> DMat3 {
    let (sin, cos) = sin_cos(angle);
    DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.0, cos, sin),
        DVec3::new(0.0, -sin, cos),
    )
}

/// The rotation about the y axis by an angle in radians.
#[must_use]
pub fn rotation_y(angle: f64) -> DMat3 {
    let (sin, cos) = sin_cos(angle);
    DMat3::from_cols(
        DVec3::new(cos, 0.0, -sin),
        DVec3::Y,
        DVec3::new(sin, 0.0, cos),
    )
}

/// The rotation about the z axis by an angle in radians.
#[must_use]
pub fn rotation_z(angle: f64) -> DMat3 {
    let (sin, cos) = sin_cos(angle);
    DMat3::from_cols(
        DVec3::new(cos, sin, 0.0),
        DVec3::new(-sin, cos, 0.0),
        DVec3::Z,
    )
}

/// The rotation about an axis of length 1 by an angle in radians (Rodrigues' formula).
#[must_use]
pub fn rotation(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = sin_cos(angle);
    let [x, y, z] = axis.to_array();
    let [x_sin, y_sin, z_sin] = (axis * sin).to_array();
    let rest = 1.0 - cos;
    let (xy, xz, yz) = (x * y * rest, x * z * rest, y * z * rest);
    DMat3::from_cols(
        DVec3::new(x * x * rest + cos, xy + z_sin, xz - y_sin),
        DVec3::new(xy - z_sin, y * y * rest + cos, yz + x_sin),
        DVec3::new(xz + y_sin, yz - x_sin, z * z * rest + cos),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Not more than a unit in the last place or two from the system's.
    #[test]
    fn functions_are_what_they_are_called() {
        let near = |ours: f64, theirs: f64, what: &str, x: f64| {
            assert!(
                (ours - theirs).abs() <= 4.0 * f64::EPSILON * theirs.abs(),
                "{what} of {x}: {ours}, not {theirs}"
            );
        };
        for k in -400..400 {
            let x = 0.037 * f64::from(k) + 0.0113;
            near(sin(x), x.sin(), "sin", x);
            near(cos(x), x.cos(), "cos", x);
            near(tan(x), x.tan(), "tan", x);
            near(atan(x), x.atan(), "atan", x);
            near(sinh(x), x.sinh(), "sinh", x);
            near(cosh(x), x.cosh(), "cosh", x);
            near(exp2(x), x.exp2(), "exp2", x);
            near(hypot(x, 1.7), x.hypot(1.7), "hypot", x);
            near(atan2(x, 1.7), x.atan2(1.7), "atan2", x);
            let share = x / 15.0;
            near(asin(share), share.asin(), "asin", share);
            near(acos(share), share.acos(), "acos", share);
            let size = x.abs();
            near(ln(size), size.ln(), "ln", size);
            near(log2(size), size.log2(), "log2", size);
            near(log10(size), size.log10(), "log10", size);
            near(pow(size, 1.3), size.powf(1.3), "pow", size);
            // (The standard library's own formulas for these lose digits.)
            assert!((sinh(asinh(x)) - x).abs() < 1e-13 * size.max(1.0));
            assert!((cosh(acosh(1.0 + size)) - 1.0 - size).abs() < 1e-13 * (1.0 + size));
            assert!((atanh(share) - share.atanh()).abs() < 1e-13);
            assert_eq!(sin_cos(x), (sin(x), cos(x)));
        }
    }

    #[test]
    fn rotations_are_those_of_glam() {
        for k in -20..20 {
            let angle = 0.37 * f64::from(k) + 0.1;
            let axis = DVec3::new(0.3, -0.8, 0.5).normalize();
            let same = |ours: DMat3, theirs: DMat3| assert!(ours.abs_diff_eq(theirs, 1e-15));
            same(rotation_x(angle), DMat3::from_rotation_x(angle));
            same(rotation_y(angle), DMat3::from_rotation_y(angle));
            same(rotation_z(angle), DMat3::from_rotation_z(angle));
            same(rotation(axis, angle), DMat3::from_axis_angle(axis, angle));
            assert!(direction(angle).abs_diff_eq(DVec2::from_angle(angle), 1e-15));
            let (a, b) = (DVec2::new(2.0, 1.0), 3.0 * direction(angle));
            assert!((turn(a, b) - a.angle_to(b)).abs() < 1e-15);
            let (a, b) = (a.extend(0.3), b.extend(-1.0));
            assert!((angle_between(a, b) - a.angle_between(b)).abs() < 1e-15);
        }
    }

    /// Bits of values at places all over, so that another version of the library, or another
    /// machine, is noticed.
    #[test]
    fn bits_are_these() {
        let mut sum = 0u64;
        for k in 1..2000 {
            let x = 0.0137 * f64::from(k);
            for value in [
                sin(x),
                cos(x),
                tan(x),
                atan(x),
                sinh(x),
                cosh(x),
                asinh(x),
                exp2(x),
                ln(x),
                log2(x),
                log10(x),
                pow(x, 0.7),
                hypot(x, 0.9),
                atan2(x, -0.4),
                acosh(1.0 + x),
                asin(x / 28.0),
                acos(x / 28.0),
                atanh(x / 28.0),
            ] {
                sum = sum.rotate_left(5).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ value.to_bits();
            }
        }
        assert_eq!(sum, 0x042f_39f1_f6f3_ea4c, "{sum:#x}");
    }
}
