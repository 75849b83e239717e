//! Faces that bend both ways and come to many triangles: they are cut into large
//! ones of like size, nearly flat, which are then tessellated in one step.

use rustc_hash::FxHashMap;

use super::fill::{Tessellator, rows_of};
use super::fine::{Fine, INNER};
use super::grow::Grower;
use super::half_edges::{HalfEdges, NONE, first_of, halves_of, triangle_of};
use super::piece::Piece;
use super::region::Way;
use super::smooth::smooth;
use crate::control::Control;
use crate::error::Error;
use crate::program::SurfaceId;

/// An edge is tessellated into no more chords than about this. Tunes counts only.
const MOST_CHORDS: f64 = 12.0;

/// A surface turns by no more than about this along an edge that is
/// tessellated. Tunes counts only.
const MOST_TURN: f64 = 0.5;

/// Into how many parts an edge that comes to so many chords, along which its
/// surface turns so far, should be cut before it is tessellated.
fn parts_of(chords: f64, turn: f64) -> f64 {
    let parts = (chords / MOST_CHORDS).max(turn / MOST_TURN);
    if chords < FEWEST_CHORDS_OF_EDGE * parts {
        chords
    } else {
        parts
    }
}

/// Faces whose edges are tessellated into fewer chords may as well be cut up one
/// by one. Tunes counts only.
const FEWEST_CHORDS: f64 = 3.0;

/// The same for single edges of faces that are tessellated: clearly fewer, as all of
/// a face may come to about the same, and must not be cut up after all. Tunes counts only.
const FEWEST_CHORDS_OF_EDGE: f64 = 2.0;

impl Grower<'_, '_> {
    /// Tessellates the faces that bend both ways, once their triangles are all
    /// of like size and small enough to be nearly flat. Those where that folds
    /// a triangle are left to be cut one by one. Nobody knows how often that is:
    /// each try tells that less is left to do by the same share.
    pub(super) fn finish_curved_faces(
        &mut self,
        control: &Control,
        tell: &impl Fn(f64),
    ) -> Result<(), Error> {
        const OF_TRY: f64 = 0.2;
        let mut left = 1.0;
        let mut tell = || {
            left *= 1.0 - OF_TRY;
            tell(1.0 - left);
        };
        self.choose();
        while self.mesh.regions.iter().any(|r| r.way == Way::AtOnce) {
            let before = (self.mesh.clone(), self.pieces.clone(), self.stuck.clone());
            let mut failed = self.try_at_once(control, &mut tell)?;
            if failed.is_empty() {
                failed = self.note_fine_edges();
            }
            if failed.is_empty() {
                for region in &mut self.mesh.regions {
                    if region.way == Way::AtOnce {
                        region.way = Way::Done;
                    }
                }
                break;
            }
            (*self.mesh, self.pieces, self.stuck) = before;
            self.fine = Fine::default();
            for region in &mut self.mesh.regions {
                if failed.contains(&region.surface) {
                    region.way = Way::OneByOne;
                }
            }
        }
        Ok(())
    }

    /// Lets the mesh know which of its vertices small triangles join; returns the
    /// surfaces of those that join two that are joined by another face.
    fn note_fine_edges(&mut self) -> Vec<SurfaceId> {
        let mut doubled = Vec::new();
        for subdivision in &self.fine.subdivisions {
            for &[a, b, c] in &subdivision.triangles {
                for edge in [[a, b], [b, c], [c, a]] {
                    let is_on_rim = edge.iter().all(|&vertex| vertex < INNER);
                    if is_on_rim && !self.mesh.fine_edges.insert(edge) {
                        doubled.push(self.mesh.surface_id(first_of(subdivision.large)));
                    }
                }
            }
        }
        doubled
    }

    /// Tessellates the chosen faces; returns the surfaces of those where that
    /// folds a triangle. Tells of every try.
    fn try_at_once(
        &mut self,
        control: &Control,
        tell: &mut impl FnMut(),
    ) -> Result<Vec<SurfaceId>, Error> {
        const MOST_TRIES: usize = 2;
        self.halve_all(control, Self::parts_of_piece, Self::parts_of_edge)?;
        smooth(self.mesh, &mut self.waiting);
        self.cut_triangles(control, Self::is_hardly_far)?;
        let mut tries = 0;
        loop {
            control.check()?;
            self.fine = Tessellator::new(self.mesh, self.goal).run(&self.pieces, control, tell)?;
            tries += 1;
            let subdivisions = self
                .fine
                .subdivisions
                .iter()
                .filter(|subdivision| subdivision.is_folded);
            let folded: Vec<u32> = subdivisions.map(|subdivision| subdivision.large).collect();
            if !folded.is_empty() && tries < MOST_TRIES {
                for triangle in folded {
                    self.cut_folded(triangle);
                }
                self.flip();
                self.free_stuck();
                continue;
            }
            let around = |&(vertex, _): &(u32, _)| self.mesh.around(vertex);
            let stuck = self.stuck.iter().flat_map(around);
            let stuck = stuck.filter(|&half| is_at_once(self.mesh, half));
            let folded = folded.into_iter().map(first_of);
            let surface = |half| self.mesh.surface_id(half);
            return Ok(folded.chain(stuck).map(surface).collect());
        }
    }

    /// Chooses the faces that are to be tessellated: those of surfaces that
    /// turn little along a chord.
    fn choose(&mut self) {
        // The chords of all edges, and how far the surface turns along them: of each face,
        // and of each surface.
        let mut sums = vec![(0.0, 0.0); self.mesh.regions.len()];
        // Where the solid touches itself edges are to stay as they are.
        let mut has_contacts = vec![false; self.mesh.regions.len()];
        for half in self.mesh.halves() {
            let region = self.mesh.region_index(triangle_of(half)) as usize;
            if self.mesh.is_contact(half) {
                has_contacts[region] = true;
            }
            if self.mesh.region(half).bend.is_twice() {
                let (chords, turn) = (self.chords_of(half, false), self.turn(half));
                let sum = &mut sums[region];
                *sum = (sum.0 + chords, sum.1 + turn);
            }
        }
        let mut of_surface: FxHashMap<SurfaceId, (f64, f64)> = FxHashMap::default();
        for (region, (chords, turn)) in self.mesh.regions.iter().zip(sums) {
            let sum = of_surface.entry(region.surface).or_default();
            *sum = (sum.0 + chords, sum.1 + turn);
        }
        for (region, has_contacts) in self.mesh.regions.iter_mut().zip(has_contacts) {
            let (chords, turn) = of_surface[&region.surface];
            if !has_contacts && region.bend.is_twice() && chords * MOST_TURN > FEWEST_CHORDS * turn
            {
                region.way = Way::AtOnce;
            }
        }
    }

    /// Cuts up a triangle that cannot be filled without a fold.
    fn cut_folded(&mut self, triangle: u32) {
        for half in halves_of(triangle) {
            let piece = self.mesh.piece(half);
            if piece != NONE && self.pieces[piece as usize].count > 0 {
                self.halve_piece(piece as usize);
                return;
            }
        }
        let length = |half: u32| {
            let ends = [self.mesh.origin(half), self.mesh.target(half)].map(|v| self.mesh.at(v));
            ends[0].distance_squared(ends[1])
        };
        let sides = halves_of(triangle);
        let longest = sides.max_by(|&a, &b| length(a).total_cmp(&length(b)));
        if let Some(half) = longest
            && !self.mesh.is_on_curve(half)
        {
            self.cut(half, 2.0);
        }
    }

    /// Into how many edges one inside a face that is to be tessellated should
    /// be cut before; 0 for others.
    fn parts_of_edge(&self, half: u32) -> f64 {
        if !is_at_once(self.mesh, half) {
            return 0.0;
        }
        parts_of(self.chords_of(half, false), self.turn(half))
    }

    /// The same for a piece of a curve along such a face.
    fn parts_of_piece(&self, index: usize) -> f64 {
        let half = self.mesh.piece_halves[index];
        let chords = f64::from(self.pieces[index].count + 1);
        let sides = [half, self.mesh.twin(half)];
        let open = sides
            .into_iter()
            .filter(|&side| is_at_once(self.mesh, side));
        let turn = open.map(|side| self.turn(side)).reduce(f64::max);
        turn.map_or(0.0, |turn| {
            parts_of(chords, turn.max(self.turn_of_piece(index)))
        })
    }

    /// How far the curve turns along a piece.
    fn turn_of_piece(&self, index: usize) -> f64 {
        let Piece { first, count } = self.pieces[index];
        let half = self.mesh.piece_halves[index];
        let ends = [self.mesh.origin(half), self.mesh.target(half)];
        let direction =
            |from: u32, to: u32| (self.mesh.at(to) - self.mesh.at(from)).normalize_or_zero();
        if count == 0 {
            return 0.0;
        }
        let last = first + count - 1;
        direction(ends[0], first).distance(direction(last, ends[1]))
    }

    /// How far the surface of a half-edge turns along it, about in radians.
    fn turn(&self, half: u32) -> f64 {
        let ends = [self.mesh.origin(half), self.mesh.target(half)];
        let ends = ends.map(|v| self.mesh.at(v));
        self.mesh.region(half).turn(self.mesh.surface(half), ends)
    }

    /// Whether a triangle is to be tessellated and needs more rows than one, but
    /// not nearly two.
    fn is_hardly_far(&self, triangle: u32) -> bool {
        /// Tunes counts only.
        const NOT_NEARLY_TWO: f64 = 1.6;
        let sides = halves_of(triangle);
        is_at_once(self.mesh, first_of(triangle))
            && sides.into_iter().all(|side| self.mesh.piece(side) == NONE)
            && (1.0..NOT_NEARLY_TWO).contains(&rows_of(self.mesh, triangle, self.goal).next_down())
    }
}

/// Whether the face of a half-edge is to be tessellated.
fn is_at_once(mesh: &HalfEdges<'_>, half: u32) -> bool {
    mesh.region(half).way == Way::AtOnce
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::tessellate::half_edges::HalfEdges;
    use crate::tessellate::separate::tests::{goal, half_ball};

    /// The new vertices after the first triangle of half a ball, with its top moved,
    /// was cut up; and how many points of curves wait to become vertices, before and
    /// after.
    fn cut_up(top: DVec3, has_pieces: bool) -> (Vec<DVec3>, [u32; 2]) {
        let (mut surfaced, surfaces) = half_ball();
        surfaced.positions[4] = top.normalize();
        let mut mesh = HalfEdges::new(&surfaced, &surfaces).expect("closed");
        let goal = goal(0.01);
        let mut grower = Grower::new(&mut mesh, &goal, 1e-12);
        if has_pieces {
            grower.measure_curves();
        }
        let waiting = |grower: &Grower<'_, '_>| grower.pieces.iter().map(|p| p.count).sum();
        let before = waiting(&grower);
        grower.cut_folded(0);
        let after = waiting(&grower);
        let is_new = |&v: &u32| mesh.leaving[v as usize] != NONE;
        let new = (surfaced.positions.len() as u32..mesh.positions.len() as u32).filter(is_new);
        (new.map(|v| mesh.at(v)).collect(), [before, after])
    }

    #[test]
    fn a_triangle_that_is_folded_is_cut_on_a_curve_or_else_in_its_longest_side() {
        // Farther from the first corner than from the second.
        let top = DVec3::new(-0.1, 0.1, 1.0);
        let (new, [before, after]) = cut_up(top, true);
        assert_eq!((new.len(), after), (1, before - 1));
        assert!(new[0].z.abs() < 1e-12 && new[0].x > 0.0 && new[0].y > 0.0);
        let (new, waiting) = cut_up(top, false);
        let middle = (DVec3::X + top.normalize()).normalize();
        assert_eq!((new.len(), waiting), (1, [0; 2]));
        assert!(new[0].distance(middle) < 1e-12, "{new:?}");
        // Along a curve that is one chord nothing can be cut.
        let (new, _) = cut_up(DVec3::new(0.6, 0.6, 0.53), false);
        assert_eq!(new, []);
    }
}
