//! Pieces of conics as rational curves of degree two, by three control points: points times their
//! weights, and weights. Where these are positive, the piece is within the triangle of the points.

use glam::{DVec3, DVec4};

use crate::elementary;

/// Of point + (t a + t² b) / (1 + l t + k t²): values of its polar form.
pub(crate) fn of_parabola(
    [point, a, b]: [DVec3; 3],
    [l, k]: [f64; 2],
    [from, to]: [f64; 2],
) -> [DVec4; 3] {
    let polar = |s: f64, t: f64| {
        let (mean, product) = (0.5 * (s + t), s * t);
        let weight = 1.0 + l * mean + k * product;
        (weight * point + mean * a + product * b).extend(weight)
    };
    [polar(from, from), polar(from, to), polar(to, to)]
}

/// Of center + cosh t a + sinh t b: the tangents at m - h and m + h meet at
/// center + (cosh m a + sinh m b) / cosh h, and the weight of that is cosh h.
pub(crate) fn of_hyperbola([center, a, b]: [DVec3; 3], range: [f64; 2]) -> [DVec4; 3] {
    let at = |t: f64| elementary::cosh(t) * a + elementary::sinh(t) * b;
    let weight = elementary::cosh(0.5 * (range[1] - range[0]));
    of_ends(center, at, weight, range)
}

/// The same of center + cos t a + sin t b; none of half of the ellipse or more.
pub(crate) fn of_ellipse([center, a, b]: [DVec3; 3], range: [f64; 2]) -> Option<[DVec4; 3]> {
    let at = |t: f64| {
        let (sin, cos) = elementary::sin_cos(t);
        cos * a + sin * b
    };
    let (_, weight) = elementary::sin_cos(0.5 * (range[1] - range[0]));
    (weight > 0.0 && range[1] - range[0] < 3.0).then(|| of_ends(center, at, weight, range))
}

fn of_ends(
    center: DVec3,
    at: impl Fn(f64) -> DVec3,
    weight: f64,
    [from, to]: [f64; 2],
) -> [DVec4; 3] {
    let middle = weight * center + at(0.5 * (from + to));
    let [from, to] = [from, to].map(|t| (center + at(t)).extend(1.0));
    [from, middle.extend(weight), to]
}
