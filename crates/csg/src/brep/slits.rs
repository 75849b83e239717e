//! Where faces that others touch from within along a curve go on across it.
//!
//! A solid that touches itself in a curve has an edge there for each of its parts. If these are sides
//! of one face, a slit in it, the face may as well go on, and the faces that touch it meet each other:
//! a boundary, too, of the same points, with as many edges less. What was one shell may be several
//! then, a body and a void that touches it. Which of them is the void others tell by vertices that are
//! off the body; where there are none, slits stay.

use std::mem::replace;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::patches::Curves;
use crate::arrangement::{Arrangement, HalfEdgeId, VertexId};
use crate::numeric::Groups;
use crate::numeric::tolerance::WELD;

/// Closes the slits within faces: half-edges there and back between the same places along curves that
/// are one become twins, and so do their twins. Of each half-edge its region is given, and of those that
/// are edges the face.
pub(super) fn close(
    all: &mut Arrangement,
    curves: &Curves,
    size: f64,
    region_of: &[u32],
    face_of: impl Fn(HalfEdgeId) -> Option<u32>,
) {
    let pairs = pairs(all, curves, WELD * size, face_of);
    if pairs.is_empty() {
        return;
    }
    let slit = (all.half_edges.clone(), all.points.clone());
    for [half, back] in pairs {
        let [one, other] = [half, back].map(|half| all.at(half).twin);
        for [a, b] in [[half, back], [one, other]] {
            all.half_edges[a.index()].twin = b;
            all.half_edges[b.index()].twin = a;
        }
    }
    number_vertices(all);
    if !have_own_vertices(all, region_of) {
        (all.half_edges, all.points) = slit;
    }
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

/// Whether each shell has a vertex at a place where no other one has.
fn have_own_vertices(all: &Arrangement, region_of: &[u32]) -> bool {
    let count = region_of.iter().max().map_or(0, |last| last + 1);
    let mut shells = Groups::new(count as usize);
    for half in all.halves() {
        shells.join([half, all.at(half).twin].map(|half| region_of[half.index()]));
    }
    let mut at: FxHashMap<[u64; 3], FxHashSet<u32>> = FxHashMap::default();
    for half in all.halves() {
        let place = place(all.points[all.at(half).from.index()]);
        let shell = shells.first(region_of[half.index()]);
        at.entry(place).or_default().insert(shell);
    }
    let alone = at.values().filter(|shells| shells.len() == 1);
    let alone: FxHashSet<u32> = alone.flatten().copied().collect();
    all.halves()
        .all(|half| alone.contains(&shells.first(region_of[half.index()])))
}

/// A point by its coordinates: those of vertices at one place are the same.
fn place(point: DVec3) -> [u64; 3] {
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
fn number_vertices(all: &mut Arrangement) {
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
