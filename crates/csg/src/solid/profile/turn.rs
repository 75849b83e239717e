//! Directions that divide a turn.

use crate::elementary;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use glam::DVec2;

/// (cos, sin) of k/n of a turn. The turn is reduced to an eighth in whole
/// numbers first: multiples of 45° and mirror images come out exactly so.
#[must_use]
pub fn turn(k: usize, n: usize) -> DVec2 {
    let (k, n) = (k as u64 % n as u64, n as u64);
    let eighth = 8 * k / n;
    // The angle from the nearest multiple of a quarter turn, in 1/8n turns.
    let quarter = eighth.div_ceil(2);
    let rest = (8 * k) as i64 - (2 * quarter * n) as i64;
    let (sin, cos) = if rest.unsigned_abs() == n {
        (FRAC_1_SQRT_2.copysign(rest as f64), FRAC_1_SQRT_2)
    } else {
        elementary::sin_cos(rest as f64 * TAU / (8.0 * n as f64))
    };
    match quarter % 4 {
        0 => DVec2::new(cos, sin),
        1 => DVec2::new(-sin, cos),
        2 => DVec2::new(-cos, -sin),
        _ => DVec2::new(sin, -cos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_right_and_symmetric() {
        for n in 1..=97 {
            for k in 0..n {
                // Its angle alone is rounded by up to 1e-15.
                let (sin, cos) = (TAU * k as f64 / n as f64).sin_cos();
                let found = turn(k, n);
                assert!(
                    found.abs_diff_eq(DVec2::new(cos, sin), 2e-15),
                    "{k}/{n}: {found}"
                );
                let mirrored = turn((n - k) % n, n);
                assert_eq!((found.x, found.y), (mirrored.x, -mirrored.y), "{k}/{n}");
            }
        }
        assert_eq!(turn(3, 4), DVec2::new(0.0, -1.0));
        assert_eq!(turn(1, 8).x, turn(1, 8).y);
    }
}
