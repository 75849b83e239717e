//! What the program alone says of single places, and how far they are from a mesh.

use glam::DVec3;

use crate::mesh::Mesh;
use crate::program::{Cell, Named, Program, Pruner};

/// Of the tolerance: how far from a triangle the solid is asked for on both sides.
pub(super) const BESIDE: f64 = 1.5;

/// What is asked about single places: with a program that is copied only when there is
/// one.
pub(super) struct Proof<'a> {
    pub program: &'a Program,
    pub tolerance: f64,
    pub unseen: f64,
    pub shortest: f64,
    pub root: Option<Cell>,
    pub pruner: Pruner,
    pub pruned: Cell,
}

impl Proof<'_> {
    /// Whether all points within the tolerance of a place are inside, or all outside.
    pub fn is_all(&mut self, place: DVec3, is_inside: bool) -> bool {
        self.prune(place, self.tolerance);
        self.pruned.constant() == Some(is_inside)
    }

    /// Whether neither the wall nor the gap at two points is so thin that it may be lost.
    pub fn is_thick(&mut self, points: [DVec3; 2]) -> bool {
        points.into_iter().all(|point| {
            self.prune(point, self.unseen);
            self.pruned.constant().is_some()
        })
    }

    /// Whether the boundary is farther than the tolerance from a place of a triangle, or
    /// the solid lies before the triangle and not behind it.
    pub fn is_misplaced(&mut self, place: DVec3, normal: DVec3) -> bool {
        self.prune(place, self.tolerance);
        if self.pruned.constant().is_some() {
            return true;
        }
        let beside = BESIDE * self.tolerance;
        self.prune(place, beside);
        let [before, behind] = [beside, -beside].map(|t| self.program.contains(place + t * normal));
        let is_one = match (&self.pruned.surfaces[..], self.program.outline()) {
            (&[only], Some(outline)) => matches!(outline.named(only), Named::Surface(_)),
            (surfaces, _) => surfaces.len() == 1,
        };
        is_one && before && !behind
    }

    /// What of the program is left within a distance of a place.
    fn prune(&mut self, place: DVec3, distance: f64) {
        let half = DVec3::splat(distance);
        if let Some(outline) = self.program.outline() {
            let side = |name: u32| outline.side_of_box(name, place, half);
            let cell = outline.cell();
            return cell.prune_by(side, &mut self.pruner, &mut self.pruned);
        }
        let root = self.root.get_or_insert_with(|| self.program.root_cell());
        let surfaces = self.program.surfaces();
        root.prune_into(surfaces, place, half, &mut self.pruner, &mut self.pruned);
    }
}

/// How far a place is from a mesh; infinitely from an empty one.
pub(super) fn distance(mesh: &Mesh, place: DVec3) -> f64 {
    let triangles = (0..mesh.triangles.len()).map(|index| mesh.corners(index));
    let distances = triangles.map(|corners| from_triangle(corners, place));
    distances.fold(f64::INFINITY, f64::min)
}

/// From the face where the place is above it, else from the nearest edge.
fn from_triangle(corners: [DVec3; 3], place: DVec3) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let edges = [(a, b), (b, c), (c, a)];
    let is_above = |&(from, to): &(DVec3, DVec3)| normal.cross(to - from).dot(place - from) >= 0.0;
    if normal != DVec3::ZERO && edges.iter().all(is_above) {
        return ((place - a).dot(normal) / normal.length()).abs();
    }
    let from_edge = |(from, to): (DVec3, DVec3)| {
        let along = to - from;
        let share = (place - from).dot(along) / along.length_squared();
        // (Without a length it is NaN, and so is what comes of it: no edge.)
        (from + along * share.clamp(0.0, 1.0)).distance(place)
    };
    edges
        .map(from_edge)
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}
