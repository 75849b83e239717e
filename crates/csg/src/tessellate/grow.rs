//! Cuts up edges until the mesh is as near to its surfaces as asked, coarse to
//! fine.
//!
//! Curves know beforehand into how many chords they are going to be cut. In
//! every round the pieces of more than 2^k chords are halved, and the edges
//! inside faces that bend both ways so much that they will need more than 2^k;
//! then edges are flipped, and k is one less. So all edges are of like size at
//! all times, few flips are needed, and the last round ends with as many chords
//! as the tolerance asks for, not with the next power of two. Edges inside
//! developable faces wait until the end, when hardly one is left to be cut.
//! Faces that bend both ways and come to many triangles are left to
//! [`super::patches`].

mod contacts;
mod insert;
mod measure;

use crate::elementary;
use glam::DVec3;

use super::alongside::align;
use super::chains::{Division, chains, divide, move_vertices};
use super::deviation;
use super::fine::Fine;
use super::flips::Waiting;
use super::goal::Goal;
use super::half_edges::{HalfEdges, Kind, NONE, first_of, halves_of, triangle_of};
use super::outcome::{Outcome, Unkept};
use super::piece::Piece;
use super::region::{Bend, Way};
use super::side::{Side, splits_well};
use super::surfaced::BYTES_PER_TRIANGLE;
use crate::control::Control;
use crate::error::Error;

pub(super) struct Grower<'m, 's> {
    pub(super) mesh: &'m mut HalfEdges<'s>,
    pub(super) goal: &'m Goal,
    /// How near a point must come to its surfaces.
    pub(super) precision: f64,
    pub(super) pieces: Vec<Piece>,
    /// Edges to be looked at for flipping.
    pub(super) waiting: Waiting,
    /// Edges whose triangles changed since they were looked at.
    changed: Vec<u32>,
    /// Vertices that lie on chords, and where they ought to be.
    pub(super) stuck: Vec<(u32, DVec3)>,
    /// Those that were put there nevertheless.
    put: Vec<u32>,
    /// Vertices at which chords of curves were cut, to be measured once all are in place.
    cut: Vec<u32>,
    /// What could not be done.
    pub outcome: Outcome,
    /// The triangles of the faces that are done.
    pub fine: Fine,
}

/// Shares of refining a part, about as long as they take: where that is begun, where its curves
/// are divided, and its faces filled, halved and cut.
pub(super) const BEGUN: f64 = 0.05;
const DIVIDED: f64 = 0.15;
const FILLED: f64 = 0.75;
const HALVED: f64 = 0.85;
const CUT: f64 = 0.9;

/// Twice as many vertices may come as triangles that are too far off, and
/// round after round they become fewer.
const MOST_ROUNDS: usize = 12;

impl<'m, 's> Grower<'m, 's> {
    pub fn new(mesh: &'m mut HalfEdges<'s>, goal: &'m Goal, precision: f64) -> Self {
        Self {
            mesh,
            goal,
            precision,
            pieces: Vec::new(),
            fine: Fine::default(),
            waiting: Waiting::default(),
            changed: Vec::new(),
            stuck: Vec::new(),
            put: Vec::new(),
            cut: Vec::new(),
            outcome: Outcome::default(),
        }
    }

    /// Tells what share of refining is done.
    pub fn run(&mut self, control: &Control, tell: &impl Fn(f64)) -> Result<(), Error> {
        self.measure_straight_edges();
        self.measure_curves();
        self.check_size(control)?;
        self.flip_everything();
        tell(DIVIDED);
        self.finish_curved_faces(control, &|share| tell(DIVIDED + (FILLED - DIVIDED) * share))?;
        tell(FILLED);
        self.halve_all(control, Self::chords_of_piece, Self::chords_of_curved)?;
        tell(HALVED);
        self.put_stuck();
        let far = self.halve_developable();
        let far = self.cut_far_triangles(far, control)?;
        tell(CUT);
        self.free_stuck();
        self.settle(far);
        for subdivision in &self.fine.subdivisions {
            let surface = self.mesh.surface_id(first_of(subdivision.large));
            let promised = self.goal.promised;
            self.outcome.note(
                subdivision.deviation,
                subdivision.farthest,
                &[surface],
                promised,
            );
        }
        Ok(())
    }

    /// Cuts sides at points of their surfaces or curves, and measures what comes of
    /// it; whether anything was cut.
    pub(super) fn cut_sides(&mut self, sides: &[Side]) -> bool {
        self.changed.clear();
        self.cut_all(sides);
        let is_cut = !self.changed.is_empty();
        self.flip();
        self.free_stuck();
        let changed = self.flip_and_take_changed();
        self.settle(changed);
        is_cut
    }

    /// Cuts sides.
    fn cut_all(&mut self, sides: &[Side]) {
        for side in sides {
            if let Some(vertex) = self.cut_side(side)
                && side.kind != Kind::Face
            {
                self.cut.push(vertex);
            }
        }
    }

    /// Cuts a side at a point of its surface or curve; the vertex there.
    pub(super) fn cut_side(&mut self, side: &Side) -> Option<u32> {
        let [from, to] = side.ends;
        let ends_there = |&half: &u32| self.mesh.target(half) == to;
        let half = self.mesh.around(from).find(ends_there)?;
        if side.kind == Kind::Face && !splits_well(self.mesh, half, side.target) {
            return None;
        }
        let vertex = self.mesh.add_vertex(side.target, side.kind);
        self.insert(half, vertex, None);
        self.mesh.contacts.cut(side.ends, vertex);
        Some(vertex)
    }

    /// An error if there are more triangles, with those that the points of
    /// curves will make, than allowed.
    pub(super) fn check_size(&self, control: &Control) -> Result<(), Error> {
        let waiting: u32 = self.pieces.iter().map(|piece| piece.count).sum();
        let triangles = self.mesh.triangle_count() as usize - self.mesh.free.len();
        let triangles = triangles + 2 * waiting as usize;
        control.check_triangles(triangles)?;
        control.check_memory(BYTES_PER_TRIANGLE * triangles)
    }

    /// Finds the points that every edge along a curve needs.
    pub(super) fn measure_curves(&mut self) {
        let mut left = chains(self.mesh);
        if self.goal.keeps_vertices {
            left = left.concat().into_iter().map(|half| vec![half]).collect();
        }
        let divided = left
            .iter()
            .map(|chain| divide(self.mesh, chain, self.goal, self.precision));
        let mut divisions: Vec<Option<Division>> = divided.collect();
        align(self.mesh, &left, &mut divisions, self.goal);
        let mut divisions = divisions.into_iter();
        left.retain(|chain| {
            let division = divisions.next().flatten();
            !division.is_some_and(|division| self.cut_into(chain, &division))
        });
        if left.is_empty() {
            return;
        }
        // Well-shaped triangles are in no vertex's way along its curve. Flips leave the
        // edges of chains alone, but give them other half-edges.
        let ends_of = |&half: &u32| [self.mesh.origin(half), self.mesh.target(half)];
        let ends = left.iter().map(|chain| chain.iter().map(ends_of).collect());
        let left: Vec<Vec<[u32; 2]>> = ends.collect();
        self.flip_everything();
        for ends in left {
            let chain = ends.iter().map(|&ends| self.mesh.between(ends)).collect();
            let Some(chain): Option<Vec<u32>> = chain else {
                continue;
            };
            if self.cut_up(&chain) {
                continue;
            }
            for half in chain {
                if !self.cut_up(&[half]) {
                    let ends = [self.mesh.origin(half), self.mesh.target(half)];
                    let [p, q] = ends.map(|v| self.mesh.at(v));
                    let middle = 0.5 * (p + q);
                    let bound = deviation::of_chord(self.mesh.curve_surfaces(half), p, q);
                    // A chord that is near enough as it is need not be cut.
                    if bound > self.goal.promised || self.goal.angle.is_some() {
                        self.outcome.unkept.push((Unkept::Lost, middle));
                    }
                    // A smaller tolerance would not help.
                    self.outcome.note(bound, middle, &[], self.goal.promised);
                }
            }
        }
    }

    /// Finds the points for the edges of a chain.
    fn cut_up(&mut self, chain: &[u32]) -> bool {
        let division = divide(self.mesh, chain, self.goal, self.precision);
        division.is_some_and(|division| self.cut_into(chain, &division))
    }

    /// The same where they are known.
    fn cut_into(&mut self, chain: &[u32], division: &Division) -> bool {
        if !move_vertices(self.mesh, chain, division) {
            return false;
        }
        let promised = self.goal.promised;
        let pair = self.mesh.curve(chain[0]);
        self.outcome
            .note(division.deviation, division.farthest, &pair, promised);
        let mut first = self.mesh.positions.len() as u32;
        for &point in &division.points {
            self.mesh.add_vertex(point, Kind::Curve);
        }
        let mut before = 0;
        for (&half, &end) in chain.iter().zip(&division.ends) {
            let count = end - before - 1;
            let ends = [self.mesh.origin(half), self.mesh.target(half)];
            let through = (first..first + count).chain([ends[1]]);
            self.mesh
                .carry_border(ends, [ends[0]].into_iter().chain(through));
            self.add_piece(half, Piece { first, count });
            first += end - before;
            before = end;
        }
        true
    }

    fn flip_everything(&mut self) {
        for half in self.mesh.edges() {
            self.waiting.push(half);
        }
        self.waiting.flip_all(self.mesh, |_| {});
    }

    /// Halves the pieces of curves and the edges inside faces that bend both ways
    /// that should become more than 2^k parts, for all k down to 0.
    pub(super) fn halve_all(
        &mut self,
        control: &Control,
        of_piece: impl Fn(&Self, usize) -> f64,
        of_edge: impl Fn(&Self, u32) -> f64,
    ) -> Result<(), Error> {
        let pieces = (0..self.pieces.len()).map(|index| of_piece(self, index));
        let mut most = pieces.fold(1.0, f64::max);
        // No others have edges inside that are asked for.
        let mut faces = self.mesh.regions.iter();
        let has_curved = faces.any(|r| r.bend.is_twice() && r.way != Way::Done);
        if has_curved {
            most = self
                .mesh
                .halves()
                .map(|half| of_edge(self, half))
                .fold(most, f64::max);
        }
        // More than 2^levels parts are asked of none.
        let levels = elementary::log2(most).ceil().clamp(1.0, 40.0) as u32;
        for level in (0..levels).rev() {
            self.check_size(control)?;
            let most = elementary::exp2(f64::from(level));
            self.halve_pieces(most, &of_piece);
            if has_curved {
                self.halve_edges(self.mesh.edges().collect(), most, &of_edge);
            }
            self.free_stuck();
        }
        Ok(())
    }

    fn chords_of_piece(&self, index: usize) -> f64 {
        f64::from(self.pieces[index].count + 1)
    }

    /// How many chords an edge inside a face that bends both ways should become.
    fn chords_of_curved(&self, half: u32) -> f64 {
        if self.mesh.region(half).way == Way::OneByOne {
            self.chords_of(half, false)
        } else {
            0.0
        }
    }

    /// How many chords an edge inside a developable face should become.
    fn chords_of_developable(&self, half: u32) -> f64 {
        if self.mesh.region(half).bend == Bend::Single {
            self.chords_of(half, true)
        } else {
            0.0
        }
    }

    /// How many chords an edge inside a face should become; 0 where that is
    /// not to be asked.
    #[inline]
    pub(super) fn chords_of(&self, half: u32, developable: bool) -> f64 {
        let region = self.mesh.region(half);
        match region.bend {
            Bend::Single if developable => {}
            Bend::Flat | Bend::Single => return 0.0,
            Bend::Double | Bend::Saddle => {}
        }
        if self.mesh.is_on_curve(half) || self.mesh.is_contact(half) {
            return 0.0;
        }
        let surface = self.mesh.surface(half);
        let p = self.mesh.at(self.mesh.origin(half));
        let q = self.mesh.at(self.mesh.target(half));
        // Across a developable face edges are as long as the chords of curves,
        // which are the longest that the tolerance allows.
        let aim = if developable {
            self.goal.tolerance_on(region.surface)
        } else {
            self.goal.aim_on(region.surface)
        };
        let for_distance = if let Some(round) = &region.round {
            (round.sag(surface, [p, q]) / aim).sqrt()
        } else {
            // The middle may lie on an axis, where there is no gradient.
            let ends = surface
                .gradient(p)
                .length()
                .max(surface.gradient(q).length());
            let gradient = surface.gradient(0.5 * (p + q)).length().max(0.2 * ends);
            let sag = 0.125 * surface.curvature_along(q - p).abs();
            (sag / (aim * gradient)).sqrt()
        };
        match self.goal.angle {
            None => for_distance,
            Some(angle) => {
                let turn = elementary::angle_between(surface.gradient(p), surface.gradient(q));
                for_distance.max(turn / angle)
            }
        }
    }

    /// Halves the pieces of curves that should become more than `most` parts.
    fn halve_pieces(&mut self, most: f64, parts: impl Fn(&Self, usize) -> f64) {
        self.changed.clear();
        let mut index = 0;
        while index < self.pieces.len() {
            // What is left of it may still be too long.
            if self.pieces[index].count > 0 && parts(self, index) > most {
                self.halve_piece(index);
            } else {
                index += 1;
            }
        }
        self.flip();
    }

    pub(super) fn halve_piece(&mut self, index: usize) {
        let Piece { first, count } = self.pieces[index];
        let half = self.mesh.piece_halves[index];
        let before = count / 2;
        self.pieces[index].count = before;
        if before == 0 {
            self.mark(half, NONE);
        }
        let on = Piece {
            first: first + before + 1,
            count: count - before - 1,
        };
        self.insert(half, first + before, Some(on));
    }

    /// Lets an edge stand for a piece.
    fn mark(&mut self, half: u32, piece: u32) {
        for side in [half, self.mesh.twin(half)] {
            self.mesh.set_piece(side, piece);
        }
    }

    /// Makes an edge stand for a new piece.
    fn add_piece(&mut self, half: u32, piece: Piece) {
        if piece.count > 0 {
            self.mark(half, self.pieces.len() as u32);
            self.pieces.push(piece);
            self.mesh.piece_halves.push(half);
        }
    }

    /// Halves those edges inside faces that should become more than `most` parts, and
    /// what comes of that.
    fn halve_edges(&mut self, edges: Vec<u32>, most: f64, parts: impl Fn(&Self, u32) -> f64) {
        self.changed = edges;
        let mut round = 0..0;
        for _ in 0..MOST_ROUNDS {
            round = round.end..self.changed.len();
            if round.is_empty() {
                break;
            }
            for index in round.clone() {
                let half = self.changed[index];
                if half > self.mesh.twin(half) || self.mesh.is_gone(triangle_of(half)) {
                    continue;
                }
                let wanted = parts(self, half);
                // What is cut evenly comes out a hair too long.
                if wanted > most * (1.0 + 1e-3) {
                    self.cut(half, wanted);
                }
            }
            self.flip();
        }
    }

    /// Halves edges inside developable faces: if no angle is asked for, only those of
    /// triangles that are too far off. Returns the triangles that may still be; the
    /// others are measured.
    fn halve_developable(&mut self) -> Vec<u32> {
        let all = 0..self.mesh.triangle_count();
        let is_far = |&triangle: &u32| !self.note_if_near(triangle);
        let mut triangles: Vec<u32> = all.filter(is_far).collect();
        let edges = if self.goal.angle.is_some() {
            self.mesh.edges().collect()
        } else {
            let sides = triangles.iter().flat_map(|&triangle| halves_of(triangle));
            sides.map(|side| side.min(self.mesh.twin(side))).collect()
        };
        self.halve_edges(edges, 1.0, Self::chords_of_developable);
        self.free_stuck();
        triangles.extend(self.flip_and_take_changed());
        triangles.sort_unstable();
        triangles.dedup();
        triangles
    }

    pub(super) fn flip(&mut self) {
        let changed = &mut self.changed;
        self.waiting
            .flip_all(self.mesh, |halves| changed.extend(halves));
    }

    /// Cuts an edge inside a face that should become `wanted` chords near its
    /// middle.
    pub(super) fn cut(&mut self, half: u32, wanted: f64) -> bool {
        let chords = (wanted - 1e-3).ceil().max(2.0);
        let share = (0.5 * chords).floor() / chords;
        let [p, q] = [self.mesh.origin(half), self.mesh.target(half)].map(|v| self.mesh.at(v));
        let (surface, region) = (self.mesh.surface(half), self.mesh.region(half));
        let Some(target) = region.project(surface, p.lerp(q, share)) else {
            return false;
        };
        // (On the way from the centre of an ellipsoid there is only one point of it.)
        let is_far = target.distance_squared(0.5 * (p + q)) > 0.49 * p.distance_squared(q);
        if is_far && region.round.is_none() {
            return false;
        }
        let kind = if self.mesh.is_feature(half) {
            Kind::Corner
        } else if splits_well(self.mesh, half, target) {
            Kind::Face
        } else {
            return false;
        };
        let vertex = self.mesh.add_vertex(target, kind);
        self.insert(half, vertex, None);
        true
    }

    /// Cuts triangles in two, whose edges are short enough.
    pub(super) fn cut_triangles(
        &mut self,
        control: &Control,
        is_wanted: impl Fn(&Self, u32) -> bool,
    ) -> Result<(), Error> {
        let mut triangles: Vec<u32> = (0..self.mesh.triangle_count()).collect();
        for _ in 0..MOST_ROUNDS {
            self.check_size(control)?;
            self.changed.clear();
            for &triangle in &triangles {
                if !self.mesh.is_gone(triangle) && is_wanted(self, triangle) {
                    self.cut_triangle(triangle);
                }
            }
            triangles = self.flip_and_take_changed();
            if triangles.is_empty() {
                break;
            }
        }
        Ok(())
    }

    /// Cuts a triangle in two at its longest side inside its face.
    fn cut_triangle(&mut self, triangle: u32) -> bool {
        let region = self.mesh.region(first_of(triangle));
        let length = |half| {
            if region.round.is_none() {
                return self.chords_of(half, true);
            }
            let [p, q] = self.mesh.ends(half).map(|v| self.mesh.at(v));
            self.mesh.surface(half).curvature_along(q - p).abs()
        };
        let longest = halves_of(triangle)
            .filter(|&side| !self.mesh.is_feature(side) && !self.mesh.is_contact(side))
            .max_by(|&a, &b| length(a).total_cmp(&length(b)));
        longest.is_some_and(|side| self.cut(side, 2.0))
    }

    /// Flips edges; the triangles that changed since that list was empty.
    fn flip_and_take_changed(&mut self) -> Vec<u32> {
        self.flip();
        let mut triangles: Vec<u32> = self.changed.iter().map(|&half| triangle_of(half)).collect();
        triangles.sort_unstable();
        triangles.dedup();
        triangles
    }

    /// Cuts those triangles that are farther from their surface than the tolerance,
    /// and what comes of it; returns those that could not be cut. All others are
    /// measured.
    fn cut_far_triangles(
        &mut self,
        mut far: Vec<u32>,
        control: &Control,
    ) -> Result<Vec<u32>, Error> {
        let is_far = |grower: &mut Self, triangle: &u32| !grower.note_if_near(*triangle);
        far.retain(|triangle| is_far(self, triangle));
        let mut stay_far = Vec::new();
        for _ in 0..MOST_ROUNDS {
            if far.is_empty() {
                break;
            }
            self.check_size(control)?;
            self.changed.clear();
            for triangle in far {
                // Neighbours may have been cut since.
                if is_far(self, &triangle) && !self.cut_triangle(triangle) {
                    stay_far.push(triangle);
                }
            }
            far = self.flip_and_take_changed();
            far.retain(|triangle| is_far(self, triangle));
        }
        stay_far.extend(far);
        Ok(stay_far)
    }
}
