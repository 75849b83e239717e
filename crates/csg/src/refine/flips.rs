//! Edge flips: triangles as round as can be in the metric of how their surface
//! bends.
//!
//! In a plane and on a sphere that is the Delaunay triangulation (Lawson,
//! *Software for C1 Surface Interpolation*, 1977). On a cylinder, where only
//! the way around counts, the vertices of two borders are joined to those
//! nearest in angle, so that no triangle spans more of it than one chord does.

use super::half_edges::{HalfEdges, next, previous};
use super::regions::{Bend, Region, Way, metric};
use super::shape::faces_out_in_the_middle;

/// Flips all edges on the stack, and the neighbours of what was flipped, until
/// none would be better flipped.
pub(super) fn flip_all(mesh: &mut HalfEdges<'_>, stack: &mut Vec<u32>) {
    // Flipping makes the smallest angles grow but for rounding: this many are
    // never needed.
    let mut left = 200 + 40 * stack.len();
    while let Some(half) = stack.pop() {
        if left > 0 && flip_if_better(mesh, half) {
            left -= 1;
            let twin = mesh.twin(half);
            stack.extend([half, next(half), twin, next(twin)]);
        }
    }
}

/// The same; both sides of every flipped edge are added to `changed`.
pub(super) fn flip_and_note(
    mesh: &mut HalfEdges<'_>,
    stack: &mut Vec<u32>,
    changed: &mut Vec<u32>,
) {
    let mut left = 200 + 40 * stack.len();
    while let Some(half) = stack.pop() {
        if left > 0 && flip_if_better(mesh, half) {
            left -= 1;
            let twin = mesh.twin(half);
            stack.extend([half, next(half), twin, next(twin)]);
            changed.extend([previous(half), previous(twin)]);
        }
    }
}

#[inline]
fn flip_if_better(mesh: &mut HalfEdges<'_>, half: u32) -> bool {
    let flips = !mesh.is_feature(half)
        && !mesh.is_contact(half)
        && mesh.region(half).way != Way::Done
        && is_better_flipped(mesh, half)
        && may_flip(mesh, half);
    if flips {
        mesh.flip(half);
    }
    flips
}

/// A tie but for rounding is no reason to flip.
const CLEARLY: f64 = 1e-9;

/// Whether the angles across from the edge add up to more than π.
#[inline]
fn is_better_flipped(mesh: &HalfEdges<'_>, half: u32) -> bool {
    let twin = mesh.twin(half);
    let surface = mesh.surface(half);
    let Region { bend, outward, .. } = *mesh.region(half);
    let a = mesh.at(mesh.origin(half));
    let b = mesh.at(mesh.origin(twin));
    let c = mesh.at(mesh.apex(half));
    let d = mesh.at(mesh.apex(twin));
    if bend == Bend::Double {
        // The circles of the metric are the sections by planes, as on a sphere:
        // the edges of the convex hull are the right ones.
        let normal = (b - a).cross(c - a);
        let convex = outward * surface.curvature_along(b - a);
        let above = normal.dot(d - a) * convex.signum();
        let scale = normal.length_squared() * (d - a).length_squared();
        return above > 0.0 && above * above > CLEARLY * CLEARLY * scale;
    }
    let ab = metric(surface, bend, b - a);
    // Twice the product of the sides and the cosine, and the sides' squares.
    let angle = |ca: f64, cb: f64| (ca + cb - ab, 4.0 * ca * cb);
    let (at_c, sides_c) = angle(metric(surface, bend, a - c), metric(surface, bend, b - c));
    let (at_d, sides_d) = angle(metric(surface, bend, a - d), metric(surface, bend, b - d));
    // The cosines' squares with their signs, over a common denominator: their sum is
    // compared without a branch, as nobody could tell beforehand which way it goes.
    let (c2, d2) = (at_c * at_c.abs() * sides_d, at_d * at_d.abs() * sides_c);
    c2 + d2 < -CLEARLY * c2.max(d2)
}

/// Whether the flipped edge would leave the mesh manifold and unfolded.
fn may_flip(mesh: &HalfEdges<'_>, half: u32) -> bool {
    let twin = mesh.twin(half);
    let (c, d) = (mesh.apex(half), mesh.apex(twin));
    let (at_a, at_b) = (mesh.at(mesh.origin(half)), mesh.at(mesh.origin(twin)));
    let (at_c, at_d) = (mesh.at(c), mesh.at(d));
    let (surface, region) = (mesh.surface(half), mesh.region(half));
    faces_out_in_the_middle(surface, region, [at_d, at_b, at_c])
        && faces_out_in_the_middle(surface, region, [at_c, at_a, at_d])
        && !mesh.are_joined(c, d)
}
