//! The edges of a polyhedral solid: the lines in which planes meet, cut up by
//! the other planes, and which faces meet along each piece.

use crate::elementary;
use rustc_hash::FxHashSet;
use smallvec::SmallVec;

use super::block::Block;
use super::ids::Position;
use super::line::Line;
use super::piece::{CurveId, Piece};
use super::regions::{Candidate, Finder, merge};
use super::scene::{Plane, Scene};
use super::sectors::{HalfPlane, Sectors, Wedges, emit};
use super::triple::crossing_blur;
use crate::program::{Ends, Given, SurfaceId};
use crate::undecided::{Stop, Why};

/// Finds the edges in blocks. Holds scratch memory.
#[derive(Default)]
pub(super) struct Tracer {
    finder: Finder,
    candidates: Vec<Candidate>,
    sectors: Sectors,
    /// Positions of the planes through the line, but for the first two.
    others: SmallVec<[Position; 4]>,
    /// Beside polyhedra: the pairs of candidates that are no given edges.
    lines: FxHashSet<[Position; 2]>,
}

/// In blocks of no more planes every pair of them is traced: it takes less time
/// than finding out which pairs meet on the boundary, and loses no edges of slivers
/// thinner than the finder tells from nothing.
const ALL_PAIRS: usize = 32;

/// Where planes of faces beside each other cross lines at smaller sines, the places are
/// found by the given edges. Less than half a digit is lost without.
const NEARLY_ALONG: f64 = 0.3;

fn everywhere(pair: [Position; 2]) -> Candidate {
    Candidate {
        pair,
        start: f64::NEG_INFINITY,
        end: f64::INFINITY,
        edge: None,
    }
}

/// How a given edge is to a plane of its polyhedron.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Along {
    /// On one side: whether that is inside.
    Beside(bool),
    Across,
    Through,
}

pub(super) fn side_of_edge(
    scene: &Scene<'_>,
    given: &Given,
    edge: Ends,
    plane: SurfaceId,
) -> Along {
    let [from, to] = edge.map(|vertex| {
        let is_corner = given.has_vertex(plane, vertex);
        let value = scene.plane(plane).value(given.vertex(vertex));
        // As when the formula was made.
        let is_on = is_corner || value.abs() <= given.slack();
        if is_on { 0.0 } else { value }
    });
    if from == 0.0 && to == 0.0 {
        Along::Through
    } else if from * to < 0.0 {
        Along::Across
    } else {
        Along::Beside(from + to <= 0.0)
    }
}

/// Whether faces on two surfaces may meet along a line that is no given edge: not if they are of
/// one polyhedron, or those of one on one side of the other.
fn may_meet(scene: &Scene<'_>, given: &Given, one: SurfaceId, other: SurfaceId) -> bool {
    /// Of more vertices it is not told.
    const FEW: usize = 8;
    if given.are_of_one(one, other) {
        return false;
    }
    if !(given.is_of_polyhedron(one) && given.is_of_polyhedron(other)) {
        return true;
    }
    let slack = MARGIN * scene.weld + given.slack();
    [(one, other), (other, one)]
        .into_iter()
        .all(|(plane, face)| {
            let corners = given.vertices_on(face);
            let plane = scene.plane(plane);
            let none = (f64::INFINITY, f64::NEG_INFINITY);
            let (low, high) = corners.iter().take(FEW).fold(none, |(low, high), &corner| {
                let value = plane.value(given.vertex(corner));
                (low.min(value), high.max(value))
            });
            corners.len() > FEW || (low <= slack && high >= -slack)
        })
}

/// Lines are traced beyond where they may carry edges by so many times the
/// distance below which points are one.
const MARGIN: f64 = 100.0;

impl Tracer {
    /// Appends all pieces of edges in a block. Undecided if more planes than can be
    /// told apart have one line in common.
    pub fn trace(
        &mut self,
        scene: &Scene<'_>,
        block: &Block,
        pieces: &mut Vec<Piece>,
    ) -> Result<(), Stop> {
        self.sectors.enter(scene, block);
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.clear();
        if let Some(given) = scene.given {
            self.find_beside(scene, given, block, &mut candidates);
            // Along a line of two planes of one polyhedron only its edges lead.
            candidates.retain(|Candidate { pair, edge, .. }| {
                let [one, other] = pair.map(|position| block.id(position));
                edge.is_some() || !given.are_of_one(one, other)
            });
            let lines = candidates.iter().filter(|line| line.edge.is_none());
            self.lines.clear();
            self.lines.extend(lines.map(|line| line.pair));
        } else if block.cell.surfaces.len() <= ALL_PAIRS {
            candidates.extend(block.pairs().map(everywhere));
        } else {
            self.finder.find(scene, block, &mut candidates);
            self.name_all(scene, block, &mut candidates);
        }
        let traced = candidates.iter().try_for_each(|candidate| {
            scene.go_on()?;
            self.trace_line(scene, block, candidate, pieces)
        });
        self.candidates = candidates;
        traced
    }

    /// Appends the candidates of a block beside polyhedra: the given edges of these, and
    /// lines of all other planes.
    fn find_beside(
        &mut self,
        scene: &Scene<'_>,
        given: &Given,
        block: &Block,
        candidates: &mut Vec<Candidate>,
    ) {
        let others = || {
            block
                .surfaces()
                .filter(|&(_, id)| !given.is_of_polyhedron(id))
        };
        let is_many = others().count() > ALL_PAIRS;
        if is_many {
            for (position, _) in others() {
                self.finder.find_on(scene, block, position, candidates);
            }
            self.name_all(scene, block, candidates);
        }
        for pair in block.pairs() {
            let [one, other] = pair.map(|position| block.id(position));
            if given.are_of_one(one, other) {
                let edges = given.edges_of([one, other]).iter();
                candidates.extend(edges.map(|&ends| Candidate {
                    edge: Some(ends),
                    ..everywhere(pair)
                }));
            } else if given.is_of_polyhedron(one) && given.is_of_polyhedron(other) {
                if may_meet(scene, given, one, other) {
                    candidates.push(everywhere(pair));
                }
            } else if !is_many {
                candidates.push(everywhere(pair));
            }
        }
    }

    /// Makes one candidate of all on the same line, named by the first two planes.
    fn name_all(&mut self, scene: &Scene<'_>, block: &Block, candidates: &mut Vec<Candidate>) {
        merge(candidates);
        for candidate in &mut *candidates {
            self.name_by_first_pair(scene, block, candidate);
        }
        merge(candidates);
    }

    /// Names a line by the first two of all planes through it.
    fn name_by_first_pair(&mut self, scene: &Scene<'_>, block: &Block, candidate: &mut Candidate) {
        let pair = candidate.pair;
        let Some(mut line) = Line::of_pair(scene, block, pair) else {
            return;
        };
        if !line.clip(block.low, block.high) {
            return;
        }
        let mut through = block.surfaces().filter(|&(position, id)| {
            pair.contains(&position) || line.lies_in(scene, scene.plane(id))
        });
        let (Some((one, _)), Some((other, _))) = (through.next(), through.next()) else {
            return;
        };
        let first = [one, other];
        if first == pair {
            return;
        }
        if let Some(same) = Line::of_pair(scene, block, first) {
            let ends = [candidate.start, candidate.end].map(|t| same.along(line.at(t)));
            *candidate = Candidate {
                pair: first,
                start: ends[0].min(ends[1]),
                end: ends[0].max(ends[1]),
                edge: None,
            };
        }
    }

    /// Traces a line where it may carry edges, and everywhere if they turn out
    /// to go on beyond.
    fn trace_line(
        &mut self,
        scene: &Scene<'_>,
        block: &Block,
        candidate: &Candidate,
        pieces: &mut Vec<Piece>,
    ) -> Result<(), Stop> {
        let pair = candidate.pair;
        let edge = candidate.edge.zip(scene.given);
        let line = match edge {
            Some((ends, given)) => Line::along_edge(scene, block, pair, given, ends),
            None => Line::of_pair(scene, block, pair),
        };
        let Some(mut line) = line else {
            return Ok(());
        };
        if !line.clip(block.low, block.high) || !self.cross(scene, block, &line, candidate) {
            return Ok(());
        }
        self.sort_around(scene, block, &line, pair);
        if self.sectors.around.len() > 64 {
            return Err(Stop::undecided(Why::Order, line.at(line.start)));
        }
        let margin = MARGIN * scene.weld;
        let within = [candidate.start - margin, candidate.end + margin];
        let before = pieces.len();
        if !self.trace_within(scene, block, &line, pair, within, pieces) {
            pieces.truncate(before);
            let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
            self.trace_within(scene, block, &line, pair, everywhere, pieces);
        }
        Ok(())
    }

    /// Traces the stretches between two places; false if edges go on beyond.
    fn trace_within(
        &mut self,
        scene: &Scene<'_>,
        block: &Block,
        line: &Line,
        pair: [Position; 2],
        [start, end]: [f64; 2],
        pieces: &mut Vec<Piece>,
    ) -> bool {
        let sectors = self.sectors.around.len();
        let first = self.sectors.crossings.partition_point(|&(t, _)| t < start);
        let last = self.sectors.crossings.partition_point(|&(t, _)| t <= end);
        // Stretches between crossings, as many at once as fit into a word.
        let at_once = 64 / sectors;
        let curve = CurveId::first_of(pair.map(|position| block.id(position)));
        let mut open = Wedges::new();
        let mut from = (line.start, line.at(line.start));
        for batch in (first..=last).step_by(at_once) {
            let count = at_once.min(last + 1 - batch);
            let result = self.sectors.evaluate(block, batch, count);
            for k in 0..count {
                let stretch = batch + k;
                let wedges = self.sectors.wedges(block, scene, result, k, |_| 0);
                if stretch == first {
                    if start > line.start && !wedges.is_empty() {
                        return false;
                    }
                    open = wedges;
                } else if (wedges != open || self.is_shared(scene, stretch - 1))
                    && let (t, Some(crossing)) = self.sectors.crossings[stretch - 1]
                {
                    let ids = [pair[0], pair[1], crossing].map(|position| block.id(position));
                    let here = (t, scene.common_point(ids));
                    emit(&open, curve, [from, here], [false; 2], pieces);
                    (open, from) = (wedges, here);
                }
            }
        }
        if end < line.end && !open.is_empty() {
            return false;
        }
        let last = (line.end, line.at(line.end));
        emit(&open, curve, [from, last], [false; 2], pieces);
        true
    }

    /// Finds where the other planes cross the line, in order, and those that
    /// contain it. False if the line is another pair's to trace.
    fn cross(
        &mut self,
        scene: &Scene<'_>,
        block: &Block,
        line: &Line,
        candidate: &Candidate,
    ) -> bool {
        let pair = candidate.pair;
        let own = pair.map(|position| block.id(position));
        self.sectors.crossings.clear();
        self.others.clear();
        self.sectors.inside.clear();
        for (position, id) in block.surfaces() {
            if pair.contains(&position) {
                self.sectors.inside.push(true);
                continue;
            }
            let plane = scene.plane(id);
            let edge = candidate.edge.zip(scene.given);
            let edge = edge.filter(|(_, given)| given.are_of_one(id, own[0]));
            let side = edge.map(|(edge, given)| side_of_edge(scene, given, edge, id));
            if let Some(Along::Beside(is_inside)) = side {
                self.sectors.inside.push(is_inside);
                continue;
            }
            let is_through = match side {
                Some(side) => side == Along::Through,
                None => line.lies_in(scene, plane),
            };
            if is_through {
                if scene.given.is_none() && position < pair[1] {
                    return false;
                }
                self.others.push(position);
                self.sectors.inside.push(true);
                continue;
            }
            let slope = plane.normal.dot(line.direction);
            let value = plane.value(line.point);
            let (first, last) = (value + slope * line.start, value + slope * line.end);
            let at = match scene.given {
                Some(given) if slope.abs() < NEARLY_ALONG && given.is_beside(id, own) => {
                    line.along(scene.common_point([own[0], own[1], id]))
                }
                _ => -value / slope,
            };
            if line.start < at && at < line.end {
                self.sectors.crossings.push((at, Some(position)));
                self.sectors.inside.push(slope > 0.0);
            } else {
                self.sectors.inside.push(first + last <= 0.0);
            }
        }
        self.sectors
            .crossings
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        if scene.given.is_none() {
            self.put_in_order(scene, block, line, pair);
            return true;
        }
        if self.others.is_empty() {
            return true;
        }
        // Of several planes through a line the first two that are looked at trace it, and a
        // polyhedron's own edges, where there are none.
        let others = self.others.iter().copied();
        let mut through: SmallVec<[Position; 8]> = pair.into_iter().chain(others).collect();
        through.sort_unstable();
        let mut pairs = (1..through.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let first = pairs.find(|&(a, b)| self.lines.contains(&[through[a], through[b]]));
        match first {
            Some((a, b)) => [through[a], through[b]] == pair,
            None => true,
        }
    }

    /// Puts crossings that rounding may have exchanged in the order in which they are.
    fn put_in_order(&mut self, scene: &Scene<'_>, block: &Block, line: &Line, pair: [Position; 2]) {
        let own = pair.map(|position| scene.plane(block.id(position)));
        let sine = own[0].normal.cross(own[1].normal).length();
        let crossings = &mut self.sectors.crossings;
        let plane = |position: Option<Position>| position.map(|p| scene.plane(block.id(p)));
        let blur = |&(_, position): &(f64, Option<Position>)| {
            plane(position).map_or(0.0, |plane| {
                let slope = plane.normal.dot(line.direction);
                crossing_blur(scene.rounding, sine * slope)
            })
        };
        let mut blurs: SmallVec<[f64; 32]> = crossings.iter().map(blur).collect();
        let mut is_changed = false;
        for first in 1..crossings.len() {
            for k in (1..=first).rev() {
                let [before, after] = [crossings[k - 1], crossings[k]];
                let may_be_exchanged = (after.0 - before.0).abs() <= blurs[k - 1] + blurs[k];
                let planes = plane(before.1).zip(plane(after.1));
                let planes = planes.filter(|_| may_be_exchanged);
                if !planes.is_some_and(|(p, q)| Plane::order_along(own, [p, q]).is_gt()) {
                    break;
                }
                crossings.swap(k - 1, k);
                blurs.swap(k - 1, k);
                is_changed = true;
            }
        }
        if is_changed {
            let mut last = f64::NEG_INFINITY;
            for (at, _) in crossings {
                *at = at.max(last);
                last = *at;
            }
        }
    }

    /// Whether another plane crosses at the same place: other edges may touch
    /// the line there though none ends.
    fn is_shared(&self, scene: &Scene<'_>, crossing: usize) -> bool {
        let near = |other: usize| {
            let gap = |&(t, _): &(f64, _)| (t - self.sectors.crossings[crossing].0).abs();
            self.sectors
                .crossings
                .get(other)
                .is_some_and(|c| gap(c) <= scene.weld)
        };
        near(crossing + 1) || near(crossing.wrapping_sub(1))
    }

    /// The half-planes around the line, counter-clockwise about its direction.
    /// The sector before the first is inside of every plane through the line
    /// whose outer half comes first.
    fn sort_around(&mut self, scene: &Scene<'_>, block: &Block, line: &Line, pair: [Position; 2]) {
        self.sectors.around.clear();
        if self.others.is_empty() {
            // The direction is the cross product of their normals.
            self.sectors
                .around
                .extend_from_slice(&HalfPlane::of_pair(pair));
            return;
        }
        let normal = |at: Position| scene.plane(block.id(at)).normal;
        // The half from which the normal points counter-clockwise.
        let outer = |at: Position| normal(at).cross(line.direction);
        let x = outer(pair[0]).normalize_or_zero();
        let y = line.direction.cross(x);
        let mut half_planes: SmallVec<[(f64, HalfPlane); 8]> = SmallVec::new();
        for &at in pair.iter().chain(&self.others) {
            let angle = if at == pair[0] {
                0.0
            } else {
                elementary::atan2(outer(at).dot(y), outer(at).dot(x))
            };
            let opposite = if angle > 0.0 {
                angle - std::f64::consts::PI
            } else {
                angle + std::f64::consts::PI
            };
            half_planes.extend([angle, opposite].into_iter().zip(HalfPlane::both(at)));
        }
        half_planes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.sectors
            .around
            .extend(half_planes.into_iter().map(|(_, h)| h));
    }
}
