//! Pieces of conics as rational curves of degree two.

use csg::brep::CurveShape;
use csg::elementary;
use glam::{DVec3, DVec4};

/// Control points of a piece of a hyperbola, a parabola or a conic whose centre is far away:
/// points times their weights, and weights. None of other curves.
pub(crate) fn control(curve: &CurveShape, [from, to]: [f64; 2]) -> Option<[DVec4; 3]> {
    match *curve {
        // Values of the polar form of point + (t a + t² b) / (1 + l t + k t²).
        CurveShape::Conic { point, a, b, l, k } => {
            let polar = |s: f64, t: f64| {
                let (mean, product) = (0.5 * (s + t), s * t);
                let weight = 1.0 + l * mean + k * product;
                let point = weight * point + mean * a + product * b;
                point.extend(weight)
            };
            Some([polar(from, from), polar(from, to), polar(to, to)])
        }
        // The tangents at m - h and m + h meet at center + (cosh m a + sinh m b) / cosh h, and
        // the weight of that is cosh h.
        CurveShape::Hyperbola { center, a, b } => {
            let at = |t: f64| -> DVec3 { elementary::cosh(t) * a + elementary::sinh(t) * b };
            let half = elementary::cosh(0.5 * (to - from));
            let middle = half * center + at(0.5 * (from + to));
            let ends = [from, to].map(|t| (center + at(t)).extend(1.0));
            Some([ends[0], middle.extend(half), ends[1]])
        }
        _ => None,
    }
}
