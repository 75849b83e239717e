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

use glam::DVec3;

use super::chains::{chains, divide, move_vertices};
use super::flips::{flip_all, flip_and_note};
use super::half_edges::{HalfEdges, Kind, NONE, next};
use super::regions::Bend;
use super::shape::faces_out_in_the_middle;
use super::{Goal, Unkept, deviation};
use crate::control::Control;
use crate::error::Error;
use crate::program::Surface;

/// A stretch of a curve that is still one edge: the points that are going to
/// cut it up, in its half-edge's direction.
#[derive(Clone, Copy, Debug)]
struct Piece {
    first: u32,
    count: u32,
}

pub(super) struct Grower<'m, 's> {
    mesh: &'m mut HalfEdges<'s>,
    goal: &'m Goal,
    /// How near a point must come to its surfaces.
    precision: f64,
    pieces: Vec<Piece>,
    /// The points of all pieces.
    points: Vec<DVec3>,
    /// Edges to be looked at for flipping.
    stack: Vec<u32>,
    /// Edges whose triangles changed since they were looked at.
    changed: Vec<u32>,
    /// Vertices that lie on chords, and where they ought to be.
    stuck: Vec<(u32, DVec3)>,
    pub unkept: Vec<(Unkept, DVec3)>,
}

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
            points: Vec::new(),
            stack: Vec::new(),
            changed: Vec::new(),
            stuck: Vec::new(),
            unkept: Vec::new(),
        }
    }

    pub fn run(&mut self, control: &Control) -> Result<(), Error> {
        self.measure_curves();
        self.flip_everything();
        let longest_piece = self.pieces.iter().map(|p| p.count + 1).max();
        let longest_edge = self.longest_edge();
        let most = f64::from(longest_piece.unwrap_or(1)).max(longest_edge);
        // More than 2^levels chords are asked of no edge.
        let levels = most.log2().ceil().clamp(1.0, 40.0) as u32;
        for level in (0..levels).rev() {
            control.check()?;
            let chords = (f64::from(level)).exp2();
            self.halve_pieces(chords);
            self.halve_edges(chords, false);
            self.free_stuck();
        }
        self.halve_edges(1.0, true);
        self.cut_far_triangles(control)?;
        self.free_stuck();
        for (vertex, place) in std::mem::take(&mut self.stuck) {
            // On its surfaces, whatever it folds.
            self.mesh.positions[vertex as usize] = place;
            self.unkept.push((Unkept::Folded, place));
        }
        Ok(())
    }

    /// Finds the points that every edge along a curve needs.
    fn measure_curves(&mut self) {
        for chain in chains(self.mesh) {
            if self.cut_up(&chain) {
                continue;
            }
            for half in chain {
                if !self.cut_up(&[half]) {
                    let ends = [self.mesh.origin(half), self.mesh.target(half)];
                    let [p, q] = ends.map(|v| self.mesh.at(v));
                    self.unkept.push((Unkept::Lost, 0.5 * (p + q)));
                }
            }
        }
    }

    /// Finds the points for the edges of a chain.
    fn cut_up(&mut self, chain: &[u32]) -> bool {
        let Some(division) = divide(self.mesh, chain, self.goal, self.precision) else {
            return false;
        };
        if !move_vertices(self.mesh, chain, &division) {
            return false;
        }
        let mut first = self.points.len() as u32;
        self.points.extend(&division.points);
        let mut before = 0;
        for (&half, &end) in chain.iter().zip(&division.ends) {
            let count = end - before - 1;
            self.add_piece(half, Piece { first, count });
            first += end - before;
            before = end;
        }
        true
    }

    fn flip_everything(&mut self) {
        for half in 0..self.mesh.halves.len() as u32 {
            if !self.mesh.is_gone(half / 3) && half < self.mesh.twin(half) {
                self.stack.push(half);
            }
        }
        flip_all(self.mesh, &mut self.stack);
    }

    fn longest_edge(&self) -> f64 {
        let halves = 0..self.mesh.halves.len() as u32;
        halves
            .filter(|&half| !self.mesh.is_gone(half / 3))
            .map(|half| self.chords_of(half, false))
            .fold(1.0, f64::max)
    }

    /// How many chords an edge inside a face should become; 0 where that is
    /// not to be asked.
    #[inline]
    fn chords_of(&self, half: u32, developable: bool) -> f64 {
        let region = self.mesh.region(half);
        let share = match region.bend {
            Bend::Single if developable => 1.0,
            Bend::Flat | Bend::Single => return 0.0,
            Bend::Double | Bend::Saddle => 1.0,
        };
        let twin = self.mesh.twin(half);
        if self.mesh.is_feature(half) && region.surface != self.mesh.surface_index(twin) {
            return 0.0;
        }
        let surface = self.mesh.surface(half);
        let p = self.mesh.at(self.mesh.origin(half));
        let q = self.mesh.at(self.mesh.origin(twin));
        let gradient = surface.gradient(0.5 * (p + q)).length();
        let sag = 0.125 * surface.curvature_along(q - p).abs();
        let for_distance = (sag / (share * self.goal.aim() * gradient)).sqrt();
        match self.goal.angle {
            None => for_distance,
            Some(angle) => {
                let turn = surface.gradient(p).angle_between(surface.gradient(q));
                for_distance.max(turn / angle)
            }
        }
    }

    /// Halves the pieces of curves of more than `chords` chords.
    fn halve_pieces(&mut self, chords: f64) {
        let mut index = 0;
        while index < self.pieces.len() {
            let Piece { first, count } = self.pieces[index];
            if f64::from(count + 1) <= chords || count == 0 {
                index += 1;
                continue;
            }
            let half = self.mesh.piece_halves[index];
            let before = count / 2;
            self.pieces[index].count = before;
            if before == 0 {
                self.mark(half, NONE);
            }
            let target = self.points[(first + before) as usize];
            let on = Piece {
                first: first + before + 1,
                count: count - before - 1,
            };
            self.insert(half, target, Kind::Curve, Some(on));
        }
        self.flip();
    }

    /// Lets an edge stand for a piece.
    fn mark(&mut self, half: u32, piece: u32) {
        for side in [half, self.mesh.twin(half)] {
            self.mesh.halves[side as usize].piece = piece;
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

    /// Halves the edges inside faces that should become more than `chords`
    /// chords, and what comes of that.
    fn halve_edges(&mut self, chords: f64, developable: bool) {
        self.changed.clear();
        self.changed.extend(0..self.mesh.halves.len() as u32);
        for _ in 0..MOST_ROUNDS {
            if self.changed.is_empty() {
                break;
            }
            for half in std::mem::take(&mut self.changed) {
                if half > self.mesh.twin(half) || self.mesh.is_gone(half / 3) {
                    continue;
                }
                let is_single = self.mesh.region(half).bend == Bend::Single;
                if is_single != developable {
                    continue;
                }
                let wanted = self.chords_of(half, developable);
                // What is cut evenly comes out a hair too long.
                if wanted > chords * (1.0 + 1e-3) {
                    self.cut(half, wanted);
                }
            }
            self.flip();
        }
    }

    fn flip(&mut self) {
        flip_and_note(self.mesh, &mut self.stack, &mut self.changed);
    }

    /// Cuts an edge inside a face that should become `wanted` chords near its
    /// middle.
    fn cut(&mut self, half: u32, wanted: f64) -> bool {
        let chords = (wanted - 1e-3).ceil().max(2.0);
        let share = (0.5 * chords).floor() / chords;
        let [p, q] = [self.mesh.origin(half), self.mesh.target(half)].map(|v| self.mesh.at(v));
        let Some(target) = project(self.mesh.surface(half), p.lerp(q, share)) else {
            return false;
        };
        if target.distance_squared(0.5 * (p + q)) > 0.49 * p.distance_squared(q) {
            return false;
        }
        if self.mesh.is_feature(half) {
            self.insert(half, target, Kind::Corner, None);
            return true;
        }
        if !self.splits_well(half, target) {
            return false;
        }
        self.insert(half, target, Kind::Face, None);
        true
    }

    /// Cuts the triangles that are farther from their surface than the
    /// tolerance though their edges are not.
    fn cut_far_triangles(&mut self, control: &Control) -> Result<(), Error> {
        let mut triangles: Vec<u32> = (0..self.mesh.triangle_count()).collect();
        for _ in 0..MOST_ROUNDS {
            control.check()?;
            self.changed.clear();
            for &triangle in &triangles {
                if !self.mesh.is_gone(triangle) && self.is_far(triangle) {
                    let longest = (3 * triangle..3 * triangle + 3)
                        .filter(|&side| !self.mesh.is_feature(side))
                        .max_by(|&a, &b| {
                            self.chords_of(a, true).total_cmp(&self.chords_of(b, true))
                        });
                    if let Some(side) = longest {
                        self.cut(side, 2.0);
                    }
                }
            }
            self.flip();
            triangles.clear();
            triangles.extend(self.changed.iter().map(|half| half / 3));
            triangles.sort_unstable();
            triangles.dedup();
            if triangles.is_empty() {
                break;
            }
        }
        Ok(())
    }

    /// Whether a triangle is farther from its surface than the tolerance: by a
    /// bound where an estimate is close to it.
    fn is_far(&self, triangle: u32) -> bool {
        /// Relative error of the estimate, and more, where it is to be trusted.
        const ROUGHLY: f64 = 0.05;
        let surface = self.mesh.surface(3 * triangle);
        if surface.is_plane() {
            return false;
        }
        let corners = self.mesh.corners(triangle);
        let (estimate, turn) = deviation::estimate(surface, corners);
        let excess = estimate / self.goal.tolerance;
        if turn < ROUGHLY && (excess - 1.0).abs() > ROUGHLY {
            return excess > 1.0;
        }
        deviation::of_triangle(surface, corners) > self.goal.tolerance
    }

    /// Whether the four triangles that a split leaves face the right way.
    fn splits_well(&self, half: u32, target: DVec3) -> bool {
        let mesh = &*self.mesh;
        let side_is_good = |half: u32| {
            let (surface, region) = (mesh.surface(half), mesh.region(half));
            let u = mesh.at(mesh.origin(half));
            let w = mesh.at(mesh.target(half));
            let c = mesh.at(mesh.apex(half));
            faces_out_in_the_middle(surface, region, [u, target, c])
                && faces_out_in_the_middle(surface, region, [target, w, c])
        };
        side_is_good(half) && side_is_good(mesh.twin(half))
    }

    /// Splits an edge and brings the new vertex to `target`, which on a face must
    /// split it well; `on` is the piece that the edge beyond it stands for.
    fn insert(&mut self, half: u32, target: DVec3, kind: Kind, on: Option<Piece>) {
        let is_free = kind == Kind::Face || self.splits_well(half, target);
        let place = if is_free {
            target
        } else {
            let [p, q] = [self.mesh.origin(half), self.mesh.target(half)].map(|v| self.mesh.at(v));
            let share = (target - p).dot(q - p) / p.distance_squared(q);
            p.lerp(q, share.clamp(0.05, 0.95))
        };
        let (vertex, rest) = self.mesh.split(half, place, kind);
        if let Some(piece) = on {
            self.add_piece(rest, piece);
        }
        if !is_free && !self.push(vertex, target) {
            self.stuck.push((vertex, target));
        }
        self.touch(vertex);
    }

    /// All edges around a vertex are to be looked at again.
    fn touch(&mut self, vertex: u32) {
        for spoke in self.mesh.around(vertex) {
            self.stack.push(next(spoke));
            self.changed.extend([spoke, self.mesh.twin(spoke)]);
        }
    }

    /// Moves a vertex, flipping the edges that are in its way.
    fn push(&mut self, vertex: u32, target: DVec3) -> bool {
        const MOST_FLIPS: usize = 24;
        for _ in 0..MOST_FLIPS {
            let mesh = &mut *self.mesh;
            let faces = |mesh: &HalfEdges<'_>, half: u32, [b, c]: [u32; 2]| {
                let corners = [target, mesh.at(b), mesh.at(c)];
                faces_out_in_the_middle(mesh.surface(half), mesh.region(half), corners)
            };
            let blocked = mesh
                .around(vertex)
                .map(next)
                .find(|&rim| !faces(mesh, rim, [mesh.origin(rim), mesh.target(rim)]));
            let Some(rim) = blocked else {
                mesh.positions[vertex as usize] = target;
                return true;
            };
            if mesh.is_feature(rim) {
                return false;
            }
            let (b, c) = (mesh.origin(rim), mesh.target(rim));
            let beyond = mesh.apex(mesh.twin(rim));
            if !faces(mesh, rim, [b, beyond])
                || !faces(mesh, rim, [beyond, c])
                || mesh.are_joined(vertex, beyond)
            {
                return false;
            }
            mesh.flip(rim);
        }
        false
    }

    /// Tries again to bring vertices to where they ought to be.
    fn free_stuck(&mut self) {
        let stuck = std::mem::take(&mut self.stuck);
        for (vertex, target) in stuck {
            if self.push(vertex, target) {
                self.touch(vertex);
            } else {
                self.stuck.push((vertex, target));
            }
        }
        self.flip();
    }
}

/// The point of a surface near `start`, by Newton's method along the gradient.
fn project(surface: &Surface, start: DVec3) -> Option<DVec3> {
    const MOST_STEPS: usize = 8;
    let mut point = start;
    for _ in 0..MOST_STEPS {
        let gradient = surface.gradient(point);
        let square = gradient.length_squared();
        let step = surface.value(point) / square * gradient;
        if !step.is_finite() {
            return None;
        }
        point -= step;
        // Its square is what is left.
        if step.length_squared() <= 1e-16 * start.distance_squared(point) {
            break;
        }
    }
    Some(point)
}
