//! How far what is made strays: noted in the outcome.

use glam::DVec3;
use smallvec::SmallVec;

use super::Grower;
use crate::program::SurfaceId;
use crate::tessellate::deviation;
use crate::tessellate::half_edges::{first_of, triangle_of};
use crate::tessellate::outcome::Unkept;
use crate::tessellate::region::{Bend, Way};

impl Grower<'_, '_> {
    /// Measures the edges between planes and those along which the solid touches
    /// itself, which stay as they are.
    pub(super) fn measure_straight_edges(&mut self) {
        let mesh = &*self.mesh;
        let is_straight = |half: u32| mesh.curve_surfaces(half).iter().all(|s| s.is_plane());
        let edges = mesh.edges().filter(|&half| mesh.is_feature(half));
        let edges = edges.filter(|&half| is_straight(half) || mesh.is_contact(half));
        self.measure_chords(edges.collect());
    }

    /// Measures the chords of a curve that end in a vertex.
    fn measure_chords_at(&mut self, vertex: u32) {
        let mesh = &*self.mesh;
        let chords = mesh.around(vertex).filter(|&half| mesh.is_feature(half));
        self.measure_chords(chords.collect());
    }

    /// Measures all triangles and edges of a mesh.
    pub(in crate::tessellate) fn measure_everything(&mut self) {
        for triangle in 0..self.mesh.triangle_count() {
            self.measure(triangle);
        }
        let mesh = &*self.mesh;
        let edges = mesh.edges().filter(|&half| mesh.is_feature(half));
        self.measure_chords(edges.collect());
    }

    fn measure_chords(&mut self, chords: SmallVec<[u32; 8]>) {
        let mesh = &*self.mesh;
        for half in chords {
            let [p, q] = [half, mesh.twin(half)].map(|side| mesh.at(mesh.origin(side)));
            let bound = deviation::of_chord(mesh.curve_surfaces(half), p, q);
            let pair = mesh.curve(half);
            let promised = self.goal.promised;
            self.outcome.note(bound, p.midpoint(q), &pair, promised);
        }
    }

    /// Whether a triangle is as near to its surface as the tolerance: then it is
    /// measured, and one that was changed later may have been.
    pub(super) fn note_if_near(&mut self, triangle: u32) -> bool {
        let region = self.mesh.region(first_of(triangle));
        // Those in planes are as near as their edges.
        if self.mesh.is_gone(triangle) || region.bend == Bend::Flat || region.way == Way::Done {
            return true;
        }
        let surface = &self.mesh.surfaces[region.surface];
        let corners = self.mesh.corners(triangle);
        let tolerance = self.goal.tolerance_on(region.surface);
        let is_within =
            |distance| deviation::is_within(surface, region.shrinkage, corners, distance);
        // Most are nearer than the farthest one so far.
        if is_within(self.outcome.deviation.min(tolerance)) {
            return true;
        }
        let mut bound = region.bound(surface, corners);
        // Neither proof is the better one everywhere.
        if bound > tolerance && is_within(tolerance) {
            bound = tolerance;
        }
        if bound <= tolerance {
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let surface = self.mesh.surface_id(first_of(triangle));
            self.outcome
                .note(bound, middle, &[surface], self.goal.promised);
        }
        bound <= tolerance
    }

    /// Bounds the distance of a triangle, however far it is.
    fn measure(&mut self, triangle: u32) {
        if self.note_if_near(triangle) {
            return;
        }
        let region = self.mesh.region(first_of(triangle));
        let surface = &self.mesh.surfaces[region.surface];
        let corners = self.mesh.corners(triangle);
        let promised = self.goal.promised;
        let bound = if deviation::is_within(surface, region.shrinkage, corners, promised) {
            promised
        } else {
            region.bound(surface, corners)
        };
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        // A smaller tolerance would not bring its corners to the surface.
        let is_off = |&corner: &DVec3| deviation::first_order(surface, corner) >= promised;
        let tighter = (!corners.iter().any(is_off)).then_some(region.surface);
        self.outcome
            .note(bound, middle, tighter.as_slice(), promised);
    }

    /// Puts vertices that are stuck on their surfaces, all at once, as some are in each other's
    /// way. Chords beside those that fold triangles so, even after flips, are cut beforehand.
    pub(super) fn put_stuck(&mut self) {
        if self.stuck.is_empty() {
            return;
        }
        let stuck = std::mem::take(&mut self.stuck);
        let before: Vec<DVec3> = stuck.iter().map(|&(v, _)| self.mesh.at(v)).collect();
        self.put_all(&stuck);
        let folds = |vertex: u32| {
            let mut around = self.mesh.around(vertex);
            around.any(|half| self.mesh.is_folded(triangle_of(half)))
        };
        let folding: Vec<usize> = (0..stuck.len()).filter(|&k| folds(stuck[k].0)).collect();
        if folding.is_empty() {
            return;
        }
        for k in folding {
            let (vertex, place) = stuck[k];
            self.mesh.positions[vertex as usize] = before[k];
            self.stuck.push((vertex, place));
        }
        self.cut_beside_stuck();
        let stuck = std::mem::take(&mut self.stuck);
        self.put_all(&stuck);
    }

    fn put_all(&mut self, stuck: &[(u32, DVec3)]) {
        for &(vertex, place) in stuck {
            self.mesh.positions[vertex as usize] = place;
            self.put.push(vertex);
            self.touch(vertex);
        }
        self.flip();
    }

    /// Puts vertices that are stuck on their surfaces, and measures triangles, and chords that
    /// were cut.
    pub(super) fn settle(&mut self, mut far: Vec<u32>) {
        self.put_stuck();
        if !self.put.is_empty() {
            let mut put = std::mem::take(&mut self.put);
            put.sort_unstable();
            put.dedup();
            for vertex in put {
                let place = self.mesh.at(vertex);
                let around = self.mesh.around(vertex);
                let folded = around.filter(|&half| self.mesh.is_folded(triangle_of(half)));
                let surfaces: Vec<SurfaceId> =
                    folded.map(|half| self.mesh.surface_id(half)).collect();
                if !surfaces.is_empty() {
                    self.outcome.unkept.push((Unkept::Folded, place));
                    self.outcome.tighter.extend(surfaces);
                }
            }
            far = (0..self.mesh.triangle_count()).collect();
        }
        for triangle in far {
            self.measure(triangle);
        }
        for vertex in std::mem::take(&mut self.cut) {
            self.measure_chords_at(vertex);
        }
    }
}
