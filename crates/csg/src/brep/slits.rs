//! Where faces that others touch from within along a curve go on across it.
//!
//! A solid that touches itself in a curve has an edge there for each of its parts. If these are sides
//! of one face, a slit in it, the face may as well go on, and the faces that touch it meet each other:
//! a boundary, too, of the same points, with as many edges less. What was one shell may be several
//! then, a body and a void that touches it.

use std::mem::replace;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::patches::Curves;
use crate::arrangement::{Arrangement, HalfEdgeId, VertexId};
use crate::numeric::tolerance::WELD;

/// Closes the slits within faces: half-edges there and back between the same places along curves that
/// are one become twins, and so do their twins. Of each half-edge that is an edge the face is given.
pub(super) fn close(
    all: &mut Arrangement,
    curves: &Curves,
    size: f64,
    face_of: impl Fn(HalfEdgeId) -> Option<u32>,
) {
    let pairs = pairs(all, curves, WELD * size, face_of);
    if pairs.is_empty() {
        return;
    }
    for [half, back] in pairs {
        let [one, other] = [half, back].map(|half| all.at(half).twin);
        for [a, b] in [[half, back], [one, other]] {
            all.half_edges[a.index()].twin = b;
            all.half_edges[b.index()].twin = a;
        }
    }
    number_vertices(all);
}

/// The half-edges on both sides of slits.
fn pairs(
    all: &Arrangement,
    curves: &Curves,
    off: f64,
    face_of: impl Fn(HalfEdgeId) -> Option<u32>,
) -> Vec<[HalfEdgeId; 2]> {
    let mut pairs = Vec::new();
    let mut ways: FxHashMap<(u32, [[u64; 3]; 2]), Vec<HalfEdgeId>> = FxHashMap::default();
    for half in all.halves() {
        let Some(face) = face_of(half) else {
            continue;
        };
        let [from, to] = all.chord(all.at(half)).map(place);
        let back = ways.get_mut(&(face, [to, from])).and_then(|back| {
            let are_one = |&other: &HalfEdgeId| are_one(all, curves, [half, other], off);
            let index = back.iter().position(are_one)?;
            Some(back.swap_remove(index))
        });
        match back {
            Some(back) => pairs.push([half, back]),
            None => ways.entry((face, [from, to])).or_default().push(half),
        }
    }
    pairs
}

/// A point by its coordinates: those of vertices at one place are the same.
pub(super) fn place(point: DVec3) -> [u64; 3] {
    // (Zeros differ in their signs.)
    point.to_array().map(|x| (x + 0.0).to_bits())
}

/// Whether half-edges there and back between the same places are in one place.
fn are_one(all: &Arrangement, curves: &Curves, halves: [HalfEdgeId; 2], off: f64) -> bool {
    let [one, other] = halves.map(|half| all.at(half));
    let [curve, along] = halves.map(|half| {
        let curve = curves.of_half_edge[half.index()];
        &curves.all[curve as usize]
    });
    let [middle, opposite] = [one, other].map(|half| 0.5 * (half.places[0] + half.places[1]));
    let point = curve.at(middle);
    let is_both_ways = one.twin != halves[1] && one.from != all.at(one.twin).from;
    let opposite = if one.curve == other.curve {
        Some(opposite)
    } else {
        along.place(point)
    };
    is_both_ways && opposite.is_some_and(|at| along.at(at).distance(point) <= off)
}

/// Vertices anew: each point once for every fan of faces around it.
pub(super) fn number_vertices(all: &mut Arrangement) {
    let count = all.half_edges.len();
    let mut previous = vec![HalfEdgeId(0); count];
    for half in all.halves() {
        previous[all.at(half).next.index()] = half;
    }
    let mut is_seen = vec![false; count];
    let mut points = Vec::with_capacity(all.points.len());
    for start in all.halves() {
        if is_seen[start.index()] {
            continue;
        }
        let vertex = VertexId(points.len() as u32);
        points.push(all.points[all.at(start).from.index()]);
        let mut at = start;
        while !replace(&mut is_seen[at.index()], true) {
            all.half_edges[at.index()].from = vertex;
            at = all.at(previous[at.index()]).twin;
        }
    }
    all.points = points;
}

#[cfg(test)]
mod tests {
    use crate::{BoundaryOptions, Program, Solid};

    /// Shells, their handles, bodies and faces of a solid, with slits and without, whose volume does
    /// not depend on them.
    fn counts(solid: &Solid) -> [[usize; 4]; 2] {
        let program = Program::lower(solid).expect("valid");
        let [slit, whole] = [
            BoundaryOptions::new(),
            BoundaryOptions::new().cut_at_seams(),
        ]
        .map(|options| program.boundary(&options).expect("a boundary"));
        let [one, other] = [&slit, &whole].map(|brep| brep.measure().volume);
        let off = (one.value - other.value).abs();
        assert!(off <= one.error + other.error, "{one:?} {other:?}");
        let inner: f64 = whole.shells().map(|shell| shell.volume().value).sum();
        assert!((inner - other.value).abs() <= 1e-12 * other.value);
        [slit, whole].map(|brep| {
            let handles = brep.shells().map(|shell| shell.genus()).sum();
            let (shells, bodies) = (brep.shells().len(), brep.bodies().len());
            [shells, handles, bodies, brep.faces().len()]
        })
    }

    #[test]
    fn faces_go_on_where_others_touch_them() {
        // The flat end of a hole touches the bore: it is parted there, or whole.
        let pipe = Solid::cylinder(3.0, -9.0..9.0) - Solid::cylinder(2.0, -10.0..10.0);
        let hole = Solid::cylinder(1.0, 2.0..6.0).rotate_x(-0.5 * std::f64::consts::PI);
        assert_eq!(counts(&(pipe - hole)), [[1, 2, 1, 7], [1, 1, 1, 6]]);
        // A void that touches the top along a line, with corners off it, is a shell of its own.
        let block = Solid::cuboid([4.0, 4.0, 2.0]);
        let rod = Solid::cuboid([2.0, 1.0, 1.0]).rotate_x(0.25 * std::f64::consts::PI);
        let rod = rod.translate([0.0, 0.0, 1.0 - 0.5f64.sqrt()]);
        assert_eq!(counts(&(&block - rod)), [[1, 0, 1, 12], [2, 0, 1, 12]]);
        // One with all corners on faces, too.
        let prism = Solid::cuboid([0.6, 0.8, 1.0]);
        let round = Solid::cylinder(0.5, -2.0..2.0);
        assert_eq!(counts(&(round - prism)), [[1, 3, 1, 9], [2, 0, 1, 9]]);
    }
}
