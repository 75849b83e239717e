//! Where a mesh runs through itself, decided exactly.

use glam::{DVec2, DVec3, Vec3Swizzles};
use rayon::prelude::*;
use robust::{Coord, Coord3D};

use super::box_tree::{Bounds, BoxTree};
use super::star::usable;
use crate::mesh::Mesh;

impl Mesh {
    /// The pairs of triangles that run through each other or overlap in
    /// area, as triangle indices, the lower first, in ascending order.
    ///
    /// Contact is not intersection as long as the triangles share only single
    /// points (a vertex, or a vertex on a face) or lie edge on edge (in whole
    /// or in part, with the same vertices or with vertices of their own):
    /// solids that touch there are still simple. An edge that lies in the
    /// other triangle's face, and faces that overlap, are intersections.
    ///
    /// The answer is exact for the coordinates as they are (Shewchuk's
    /// adaptive predicates in the test of Guigue and Devillers, *Fast and
    /// Robust Triangle-Triangle Overlap Test Using Orientation Predicates*,
    /// 2003), short of underflow. Triangles that name no three different
    /// vertices, are not finite or have no area are passed over.
    ///
    /// n log n for n triangles of similar size, in parallel; the same for any
    /// number of threads.
    #[must_use]
    pub fn self_intersections(&self) -> Vec<[u32; 2]> {
        let boxes: Vec<(Bounds, u32)> = (0..self.triangles.len().min(u32::MAX as usize))
            .into_par_iter()
            .filter(|&index| usable(&self.triangles[index], self.positions.len()))
            .map(|index| (self.corners(index), index as u32))
            .filter(|(corners, _)| corners.iter().all(|c| c.is_finite()) && has_area(corners))
            .map(|(corners, index)| (Bounds::around(&corners), index))
            .collect();
        BoxTree::new(&boxes).pairs(&|first, second| {
            intersect(self.corners(first as usize), self.corners(second as usize))
        })
    }
}

type Triangle = [DVec3; 3];

/// Which side of the plane through a, b and c the point d is on: 1 for the
/// side from which they are counter-clockwise, 0 for the plane itself. Exact.
fn side([a, b, c]: [DVec3; 3], d: DVec3) -> i8 {
    let [a, b, c, d] = [a, b, c, d].map(|p| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    });
    // (Shewchuk's predicate is positive below the plane.)
    sign(-robust::orient3d(a, b, c, d))
}

/// Whether a, b and c turn counter-clockwise (1), not at all, or clockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> i8 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    sign(robust::orient2d(a, b, c))
}

fn sign(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}

/// The projections along the axes.
const PROJECTIONS: [fn(DVec3) -> DVec2; 3] = [|p| p.yz(), |p| p.zx(), |p| p.xy()];

/// The first projection in which the triangle has an area.
fn projection([a, b, c]: &Triangle) -> Option<fn(DVec3) -> DVec2> {
    PROJECTIONS
        .into_iter()
        .find(|along| turn(along(*a), along(*b), along(*c)) != 0)
}

fn has_area(triangle: &Triangle) -> bool {
    projection(triangle).is_some()
}

/// Whether two triangles with area intersect in the sense of
/// [`Mesh::self_intersections`].
fn intersect(mut first: Triangle, mut second: Triangle) -> bool {
    if clearly_apart(&first, &second) {
        return false;
    }
    let sides = |of: &Triangle, plane: &Triangle| {
        of.map(|p| {
            if plane.contains(&p) {
                0
            } else {
                side(*plane, p)
            }
        })
    };
    let first_sides = sides(&first, &second);
    if first_sides == [0; 3] {
        return overlap_in_plane(&first, &second);
    }
    let Some(first_apex) = apex(first_sides) else {
        return false;
    };
    let second_sides = sides(&second, &first);
    let Some(second_apex) = apex(second_sides) else {
        return false;
    };
    let edge_in_plane = |sides: [i8; 3]| sides.iter().filter(|&&s| s == 0).count() == 2;
    if edge_in_plane(first_sides) && edge_in_plane(second_sides) {
        // Both meet the planes' common line in an edge: edge on edge at most.
        return false;
    }
    // Bring each apex to the front and above the other's plane.
    first.rotate_left(first_apex);
    second.rotate_left(second_apex);
    if first_sides[first_apex] < 0 {
        second.swap(1, 2);
    }
    if second_sides[second_apex] < 0 {
        first.swap(1, 2);
    }
    // The planes' common line meets each triangle in a segment from its edge
    // pq to its edge pr: do the two segments overlap in more than a point?
    let [p1, q1, r1] = first;
    let [p2, q2, r2] = second;
    side([p1, q1, p2], q2) < 0 && side([p1, r1, r2], p2) < 0
}

/// The corner that is strictly on one side of a plane while the other two are
/// not on that side; none if the triangle meets the plane in a point at most.
fn apex(sides: [i8; 3]) -> Option<usize> {
    (0..3).find(|&i| sides[i] != 0 && (1..3).all(|k| sides[i] * sides[(i + k) % 3] <= 0))
}

/// Whether two triangles in one plane overlap in more than edges and points:
/// no edge of either may have the other wholly on its outer side.
fn overlap_in_plane(first: &Triangle, second: &Triangle) -> bool {
    let Some(along) = projection(first) else {
        return false;
    };
    let flat = |triangle: &Triangle| triangle.map(along);
    let separates = |[a, b, c]: [DVec2; 3], other: [DVec2; 3]| {
        let inner = turn(a, b, c);
        [[a, b], [b, c], [c, a]]
            .into_iter()
            .any(|[from, to]| other.iter().all(|&p| turn(from, to, p) * inner <= 0))
    };
    let (first, second) = (flat(first), flat(second));
    !separates(first, second) && !separates(second, first)
}

/// A quick way to tell most neighbours apart without exact arithmetic, which
/// is slow just where it is needed most often: between triangles of one plane
/// that share corners. True only if it is certain that the triangles meet in
/// no more than points and common edges.
fn clearly_apart(first: &Triangle, second: &Triangle) -> bool {
    [(first, second), (second, first)]
        .into_iter()
        .any(|(one, other)| {
            let [a, b, c] = *one;
            // One's own plane, then a plane through each of its edges, upright.
            if keeps_off([a, b, c], one, other, None) {
                return true;
            }
            let normal = (b - a).cross(c - a);
            let size = (b - a).abs().max_element() / normal.abs().max_element();
            let up = normal * size;
            [(a, b, c), (b, c, a), (c, a, b)]
                .into_iter()
                .any(|(from, to, third)| keeps_off([from, to, from + up], one, other, Some(third)))
        })
}

/// Whether all corners of the other triangle are clearly on one side of the
/// plane, but for those they share that lie in the plane; and, if a third
/// corner of one's own is given, that one on the other side.
///
/// The plane goes through two or all three corners of `one`, exactly.
fn keeps_off(plane: [DVec3; 3], one: &Triangle, other: &Triangle, third: Option<DVec3>) -> bool {
    let mut seen = third.map_or(0, |third| -clear_side(plane, third));
    if third.is_some() && seen == 0 {
        return false;
    }
    let in_plane = |p: &DVec3| one.contains(p) && third != Some(*p);
    let agrees = other.iter().filter(|p| !in_plane(p)).all(|&p| {
        let side = clear_side(plane, p);
        let agrees = side != 0 && (seen == 0 || seen == side);
        seen = side;
        agrees
    });
    // (A triangle with the same three corners has been on no side yet.)
    agrees && seen != 0
}

/// [`side`] in plain arithmetic, or 0 where rounding could turn it: the first
/// stage of Shewchuk's predicate with its error bound.
fn clear_side([a, b, c]: [DVec3; 3], d: DVec3) -> i8 {
    const BOUND: f64 = (7.0 + 56.0 * (f64::EPSILON / 2.0)) * (f64::EPSILON / 2.0);
    let (a, b, c) = (a - d, b - d, c - d);
    let (plus, minus) = (b.yzx() * c.zxy(), b.zxy() * c.yzx());
    let determinant = a.dot(plus - minus);
    let permanent = a.abs().dot(plus.abs() + minus.abs());
    if determinant.abs() > BOUND * permanent {
        sign(-determinant)
    } else {
        0
    }
}
