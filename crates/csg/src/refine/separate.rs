//! Separates triangles that run through each other though their surfaces do not: cuts
//! the sides of both that stray most from surfaces and curves, at points of them.
//!
//! All vertices being on the solid's boundary, and all triangles in its topology,
//! the mesh runs through itself no more once it is fine enough there.

use glam::DVec3;

use super::curves::on_curve;
use super::grow::{Grower, project};
use super::half_edges::{HalfEdges, Kind};
use super::tessellate::Fine;
use super::{Goal, Outcome, Surfaced, hand_back};
use crate::program::Surface;

/// Which sides are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Which {
    /// Those that stray most.
    Worst,
    /// Chords of curves, if there are any that stray: of faces that touch along
    /// one, those inside of faces may be as long as the gap takes to open.
    Chords,
}

/// Cuts sides of the pairs of triangles, and notes in `outcome` how far what comes
/// of it strays; false if there is nothing to be cut.
pub(crate) fn separate(
    surfaced: &mut Surfaced,
    surfaces: &[Surface],
    goal: &Goal,
    pairs: &[[u32; 2]],
    which: Which,
    outcome: &mut Outcome,
) -> bool {
    let precision = super::precision(&surfaced.positions);
    let mesh = HalfEdges::new(
        surfaced.positions.clone(),
        &surfaced.triangles,
        &surfaced.groups,
        &surfaced.surface_of_group,
        surfaces,
    );
    let Some(mut mesh) = mesh else {
        return false;
    };
    let mut sides: Vec<Side> = pairs
        .iter()
        .flat_map(|&pair| worst_sides(&mesh, pair, which, precision))
        .collect();
    sides.sort_unstable_by_key(|side| side.ends);
    sides.dedup_by_key(|side| side.ends);
    let mut grower = Grower::new(&mut mesh, goal, precision);
    grower.outcome = std::mem::take(outcome);
    let is_changed = grower.cut_sides(&sides);
    *outcome = std::mem::take(&mut grower.outcome);
    hand_back(&mesh, &Fine::default(), surfaced);
    is_changed
}

/// A side of a triangle, and where it is to be cut.
#[derive(Clone, Copy)]
pub(super) struct Side {
    /// In ascending order.
    pub ends: [u32; 2],
    pub target: DVec3,
    /// Of the vertex there.
    pub kind: Kind,
}

/// The sides of two triangles that stray most.
fn worst_sides(mesh: &HalfEdges<'_>, pair: [u32; 2], which: Which, precision: f64) -> Vec<Side> {
    /// Of the farthest one's distance.
    const FAR: f64 = 0.5;
    /// The same for chords of curves, if they are asked for.
    const NOT_NEAR: f64 = 0.05;
    let halves = pair.iter().flat_map(|&t| 3 * t..3 * t + 3);
    let sides = halves.filter_map(|half| cut_of(mesh, half, precision));
    let mut sides: Vec<(f64, Side)> = sides.filter(|side| side.0 > 100.0 * precision).collect();
    let farthest = sides.iter().map(|side| side.0).fold(0.0, f64::max);
    let is_chord = |side: &(f64, Side)| side.1.kind == Kind::Curve && side.0 >= NOT_NEAR * farthest;
    if which == Which::Chords && sides.iter().any(is_chord) {
        sides.retain(is_chord);
    } else {
        sides.retain(|side| side.0 >= FAR * farthest);
    }
    sides.into_iter().map(|(_, side)| side).collect()
}

/// Where an edge would be cut, and how far its middle is from there.
fn cut_of(mesh: &HalfEdges<'_>, half: u32, precision: f64) -> Option<(f64, Side)> {
    let ends = [mesh.origin(half), mesh.target(half)];
    let [p, q] = ends.map(|v| mesh.at(v));
    let middle = p.midpoint(q);
    let surfaces = [half, mesh.twin(half)].map(|side| mesh.surface(side));
    let (target, kind) = if std::ptr::eq(surfaces[0], surfaces[1]) {
        let kind = if mesh.is_feature(half) {
            Kind::Corner
        } else {
            Kind::Face
        };
        (project(surfaces[0], middle)?, kind)
    } else {
        let reach = 0.5 * p.distance(q);
        (on_curve(surfaces, middle, reach, precision)?, Kind::Curve)
    };
    let [a, b] = ends;
    let ends = [a.min(b), a.max(b)];
    Some((target.distance(middle), Side { ends, target, kind }))
}
