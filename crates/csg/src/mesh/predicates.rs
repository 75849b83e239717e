//! On which side of what a point lies, decided exactly (Shewchuk's adaptive
//! predicates), short of underflow and overflow.

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D};

/// The corners of a triangle.
pub(crate) type Triangle = [DVec3; 3];

/// Which side of the plane through a, b and c the point d is on: 1 for the
/// side from which they are counter-clockwise, 0 for the plane itself.
pub(crate) fn side([a, b, c]: Triangle, d: DVec3) -> i8 {
    let [a, b, c, d] = [a, b, c, d].map(|p| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    });
    // (Shewchuk's predicate is positive below the plane.)
    sign(-robust::orient3d(a, b, c, d))
}

/// Whether a, b and c turn counter-clockwise (1), not at all, or clockwise.
#[inline]
pub(super) fn turn([a, b, c]: [DVec2; 3]) -> i8 {
    sign(orient(a, b, c))
}

#[inline]
fn sign(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}

/// A point seen along an axis: from its positive end, the next two axes pointing right
/// and up.
#[inline(always)]
pub(crate) fn flat(p: DVec3, axis: usize) -> DVec2 {
    match axis {
        0 => DVec2::new(p.y, p.z),
        1 => DVec2::new(p.z, p.x),
        _ => DVec2::new(p.x, p.y),
    }
}

/// A triangle seen along an axis.
#[inline(always)]
pub(super) fn flattened([a, b, c]: Triangle, axis: usize) -> [DVec2; 3] {
    [flat(a, axis), flat(b, axis), flat(c, axis)]
}

/// Twice the area of a triangle, positive if it is counter-clockwise: exact in sign.
#[inline]
pub(crate) fn orient(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let coordinate = |p: DVec2| Coord { x: p.x, y: p.y };
    robust::orient2d(coordinate(a), coordinate(b), coordinate(c))
}
