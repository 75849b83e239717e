//! Directions that divide a turn.

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
        (rest as f64 * TAU / (8.0 * n as f64)).sin_cos()
    };
    match quarter % 4 {
        0 => DVec2::new(cos, sin),
        1 => DVec2::new(-sin, cos),
        2 => DVec2::new(-cos, -sin),
        _ => DVec2::new(sin, -cos),
    }
}
