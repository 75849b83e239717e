//! Vertices side by side: parts triangles that run through each other next to where
//! their surfaces touch.
//!
//! There the gap between the surfaces grows as the square of the distance, and so
//! does what triangles stray with their size: those that are as large as they are far
//! from the contact may cross however small they are. Not so where both surfaces have
//! their vertices in the same places: then the gap between the triangles is at each
//! point about the mean of those at the corners.

use glam::DVec3;

use super::half_edges::{HalfEdges, Kind, first_of, halves_of};
use super::side::{Side, cut_of, splits_well};

/// Sides of two triangles, with points beside corners of the other triangle which are
/// between a triangle and its surface; if there are none, beside the points where
/// sides of one run through the other.
pub(super) fn sides_beside(mesh: &HalfEdges<'_>, pair: [u32; 2], precision: f64) -> Vec<Side> {
    let [one, other] = pair;
    let both_ways = [[one, other], [other, one]];
    let mut sides = Vec::new();
    for [triangle, other] in both_ways {
        for corner in mesh.corners(other) {
            if is_below(mesh, triangle, corner) {
                sides.extend(side_of_triangle(mesh, triangle, corner));
            }
        }
    }
    if !sides.is_empty() {
        return sides;
    }
    for [triangle, other] in both_ways {
        for half in halves_of(triangle) {
            if let Some((share, point)) = piercing(mesh, half, other) {
                sides.extend(side_of_triangle(mesh, other, point));
                if INNER.contains(&share) {
                    sides.extend(cut_of(mesh, half, point, precision));
                }
            }
        }
    }
    sides
}

/// Shares of a side next to which it may be cut.
const INNER: std::ops::Range<f64> = 0.05..0.95;

/// Whether a point is between a triangle's plane and its surface.
fn is_below(mesh: &HalfEdges<'_>, triangle: u32, point: DVec3) -> bool {
    let surface = mesh.surface(first_of(triangle));
    let corners @ [a, _, _] = mesh.corners(triangle);
    let normal = normal(corners);
    let along = normal.dot(surface.gradient(a)).signum();
    along * normal.dot(point - a) * surface.value(point) < 0.0
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The barycentric coordinates of a point next to a triangle.
fn weights(corners: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let [a, b, c] = corners;
    let normal = normal(corners);
    let weight = |p: DVec3, q: DVec3| normal.dot((q - p).cross(point - p));
    [weight(b, c), weight(c, a), weight(a, b)].map(|w| w / normal.length_squared())
}

/// The side of a triangle that is nearest to a point inside of it of those that can
/// be cut at the point of the surface next to it.
fn side_of_triangle(mesh: &HalfEdges<'_>, triangle: u32, near: DVec3) -> Option<Side> {
    /// Of the points' barycentric coordinates: farther from corners and sides.
    const LEAST: f64 = 0.02;
    let half = first_of(triangle);
    let target = mesh.region(half).project(mesh.surface(half), near)?;
    let weights = weights(mesh.corners(triangle), target);
    if weights.iter().any(|w| !(LEAST..INNER.end).contains(w)) {
        return None;
    }
    // Opposite to the corners.
    let halves = [1, 2, 0].map(|k| first_of(triangle) + k);
    let may_be_cut = |&(_, half): &(f64, u32)| {
        let is_inside = mesh.surface_id(half) == mesh.surface_id(mesh.twin(half))
            && !mesh.is_feature(half)
            && !mesh.is_contact(half);
        is_inside && splits_well(mesh, half, target)
    };
    let sides = weights.into_iter().zip(halves).filter(may_be_cut);
    let (_, nearest) = sides.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Side {
        ends: mesh.ends(nearest),
        target,
        kind: Kind::Face,
    })
}

/// Where an edge runs through a triangle: after which share of its length, and the
/// point.
fn piercing(mesh: &HalfEdges<'_>, half: u32, triangle: u32) -> Option<(f64, DVec3)> {
    let corners @ [a, _, _] = mesh.corners(triangle);
    let [p, q] = [mesh.origin(half), mesh.target(half)].map(|v| mesh.at(v));
    let normal = normal(corners);
    let [from, to] = [p, q].map(|end| normal.dot(end - a));
    if from * to >= 0.0 {
        return None;
    }
    let share = from / (from - to);
    let point = p.lerp(q, share);
    let is_inside = weights(corners, point).iter().all(|&w| w >= 0.0);
    is_inside.then_some((share, point))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate::separate::tests::spheres;

    /// Small triangles of one sphere above a large triangle of another one, but below
    /// that sphere.
    #[test]
    fn a_triangle_is_cut_beside_the_corners_between_it_and_its_surface() {
        let (surfaced, surfaces) = spheres([1.0, 0.97], DVec3::ZERO, [1, 3]);
        let mesh = HalfEdges::new(&surfaced, &surfaces).expect("closed");
        let large = surfaced.triangles[0];
        let middle = DVec3::ONE.normalize();
        let is = |p: DVec3, q: DVec3| p.distance(q) < 1e-14;
        let mut count = 0;
        for (small, corners) in (8..).zip(&surfaced.triangles[8..]) {
            let places = corners.map(|c| surfaced.positions[c as usize].normalize());
            if !places.iter().any(|&p| is(p, middle)) {
                continue;
            }
            count += 1;
            let sides = sides_beside(&mesh, [0, small], 1e-12);
            assert!(sides.iter().any(|side| is(side.target, middle)));
            for side in sides {
                assert!(places.iter().any(|&p| is(p, side.target)));
                assert!(side.ends.iter().all(|end| large.contains(end)));
            }
        }
        assert_eq!(count, 6);
    }
}
