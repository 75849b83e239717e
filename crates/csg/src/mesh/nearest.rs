//! What of a mesh is nearest to points.

use glam::DVec3;
use rayon::prelude::*;

use super::box_tree::{Bounds, BoxTree, Boxed, along_curve};
use crate::mesh::Mesh;

/// What of a mesh is nearest to a point ([`Mesh::nearest`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshNearest {
    /// How far it is, at least 0.
    pub distance: f64,
    /// Where it is.
    pub point: DVec3,
    /// The triangle it is on.
    pub triangle: u32,
}

impl Mesh {
    /// The nearest point of this mesh's triangles to each of some points, exact but for rounding;
    /// `None` if there are no triangles. Of triangles that are as near any may be named, always the same.
    ///
    /// n log n steps for n triangles, and about log n for each point, in parallel.
    #[must_use]
    pub fn nearest(&self, points: &[DVec3]) -> Option<Vec<MeshNearest>> {
        if self.triangles.is_empty() {
            return None;
        }
        let tree = self.triangle_tree();
        let nearest = |&point: &DVec3| {
            let measure = |triangle: u32| to_triangle(point, self.corners(triangle as usize)).0;
            let (triangle, _) = tree.nearest(point, None, measure).unwrap_or_default();
            let (distance, point) = to_triangle(point, self.corners(triangle as usize));
            MeshNearest {
                distance,
                point,
                triangle,
            }
        };
        Some(points.par_iter().with_min_len(64).map(nearest).collect())
    }

    /// Its triangles, each a sheet of its own.
    pub(super) fn triangle_tree(&self) -> BoxTree {
        let bounds = |index: usize| Bounds::around(&self.corners(index));
        let order = along_curve((0..self.triangles.len()).map(bounds));
        let entries = order.into_iter().map(|index| Boxed {
            bounds: bounds(index as usize),
            index,
            sheet: index,
            stands: 0,
        });
        BoxTree::new(entries.collect())
    }
}

/// How far a point is from a triangle, and which of its points is nearest (Ericson, *Real-Time
/// Collision Detection*, 2005, 5.1.5).
#[inline]
pub(super) fn to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> (f64, DVec3) {
    let to_segment = |from: DVec3, to: DVec3| {
        let side = to - from;
        let share = (point - from).dot(side) / side.length_squared();
        // (Not a number if it has no length.)
        let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
        let nearest = from + share * side;
        (point.distance(nearest), nearest)
    };
    let (u, v) = (b - a, c - a);
    let normal = u.cross(v);
    let square = normal.length_squared();
    let p = point - a;
    let (along_v, along_u) = (u.cross(p).dot(normal), p.cross(v).dot(normal));
    if square > 0.0 && along_u >= 0.0 && along_v >= 0.0 && along_u + along_v <= square {
        let height = p.dot(normal);
        let nearest = a + (along_u / square) * u + (along_v / square) * v;
        return (height.abs() / square.sqrt(), nearest);
    }
    let [first, second, third] = [to_segment(a, b), to_segment(b, c), to_segment(c, a)];
    let nearer = |one: (f64, DVec3), other: (f64, DVec3)| if other.0 < one.0 { other } else { one };
    nearer(nearer(first, second), third)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of points of the triangle is nearest where it should be.
    #[test]
    fn distances_to_triangles() {
        let triangle = [
            DVec3::new(0.0, 0.0, 1.0),
            DVec3::new(2.0, 0.5, 0.0),
            DVec3::new(0.5, 1.5, -1.0),
        ];
        let [a, b, c] = triangle;
        let sampled = |point: DVec3| {
            let mut least = f64::INFINITY;
            for i in 0..=200 {
                for j in 0..=200 - i {
                    let (s, t) = (f64::from(i) / 200.0, f64::from(j) / 200.0);
                    let on = a + s * (b - a) + t * (c - a);
                    least = least.min(on.distance(point));
                }
            }
            least
        };
        for k in 0..60 {
            let t = f64::from(k);
            let point = 2.0 * DVec3::new((1.1 * t).cos(), (1.7 * t).sin(), (2.3 * t).cos());
            let ((found, on), wanted) = (to_triangle(point, triangle), sampled(point));
            assert!((on.distance(point) - found).abs() < 1e-12, "{point} {on}");
            assert!(to_triangle(on, triangle).0 < 1e-12, "{point} {on}");
            assert!(
                found <= wanted + 1e-12 && wanted < found + 0.015,
                "{point} {found} {wanted}"
            );
        }
        let needle = [a, b, a.lerp(b, 0.3)];
        assert!((to_triangle(a, needle).0).abs() < 1e-15);
        assert!((to_triangle(a + DVec3::Z, [a; 3]).0 - 1.0).abs() < 1e-15);
    }
}
