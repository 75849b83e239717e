//! Which lines of a block can carry edges, and where: of all pairs of planes
//! only few meet on the boundary.
//!
//! The part of each plane that lies in the block is a convex polygon; it is
//! split by planes that still matter on it, and the formula pruned to the
//! pieces, until on each the plane is boundary throughout or nowhere (the
//! partial evaluation of Thibault and Naylor, *Set Operations on Polyhedra
//! Using Binary Space Partitioning Trees*, 1987, in two dimensions). Where it
//! may be boundary, the sides of the piece lie on lines that may be edges.

use glam::DVec3;
use smallvec::SmallVec;

use super::block::Block;
use super::ids::Position;
use super::line::Line;
use super::scene::Scene;
use crate::program::{Cell, Ends, Operand, Pruner, Side as Half, SurfaceId};

/// A stretch of the line common to two planes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// The lesser position first.
    pub pair: [Position; 2],
    pub start: f64,
    pub end: f64,
    /// The given edge that it is, if it is one.
    pub edge: Option<Ends>,
}

/// A corner, and the plane that the side from it to the next lies on; none of a side of
/// the block.
type Corner = (DVec3, Option<SurfaceId>);
type Polygon = SmallVec<[Corner; 12]>;

/// Finds candidates. Holds scratch memory.
pub(super) struct Finder {
    pruner: Pruner,
    pending: Vec<(Polygon, Cell)>,
    spare: Vec<Cell>,
    halves: Vec<Half>,
    /// Planes that the piece in work lies in, which cannot split it.
    along: Vec<SurfaceId>,
}

impl Default for Finder {
    fn default() -> Self {
        Self {
            pruner: Pruner::literal_by_literal(),
            pending: Vec::new(),
            spare: Vec::new(),
            halves: Vec::new(),
            along: Vec::new(),
        }
    }
}

impl Finder {
    /// Appends the candidates of a block, each once or more often.
    pub fn find(&mut self, scene: &Scene<'_>, block: &Block, found: &mut Vec<Candidate>) {
        for position in Position::all(block.cell.surfaces.len()) {
            self.find_on(scene, block, position, found);
        }
    }

    /// Appends the candidates on one plane.
    pub fn find_on(
        &mut self,
        scene: &Scene<'_>,
        block: &Block,
        position: Position,
        found: &mut Vec<Candidate>,
    ) {
        let plane = block.id(position);
        let Some(whole) = section(scene, block, plane) else {
            return;
        };
        let mut cell = self.spare.pop().unwrap_or_default();
        cell.clone_from(&block.cell);
        self.pending.clear();
        self.pending.push((whole, cell));
        while let Some((mut piece, cell)) = self.pending.pop() {
            if scene.control.check().is_err() {
                return;
            }
            let mut pruned = self.spare.pop().unwrap_or_default();
            if clip_by_root(scene, &cell, plane, &mut piece) {
                self.prune(scene, &cell, plane, &piece, &mut pruned);
                if pruned.constant().is_none() && pruned.surfaces.contains(&plane.0) {
                    match self.splitter(&pruned, plane) {
                        Some(by) => self.split(scene, &piece, &pruned, by),
                        None => record(scene, block, position, &piece, found),
                    }
                }
            }
            self.spare.extend([cell, pruned]);
        }
    }

    /// Shortens the formula to what varies on a piece of a plane.
    fn prune(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        plane: SurfaceId,
        piece: &Polygon,
        out: &mut Cell,
    ) {
        self.halves.clear();
        self.along.clear();
        for id in cell.ids() {
            let (low, high) = if id == plane {
                (0.0, 0.0)
            } else {
                range(scene, id, piece)
            };
            let is_inside = high <= scene.on_plane && low < -scene.on_plane;
            let is_outside = low >= -scene.on_plane && high > scene.on_plane;
            self.halves.push(match (is_inside, is_outside) {
                (true, _) => Half::Inside,
                (_, true) => Half::Outside,
                _ => Half::Crossing,
            });
            if high - low <= 2.0 * scene.on_plane {
                self.along.push(id);
            }
        }
        cell.restrict_into(&self.halves, &mut self.pruner, out);
    }

    /// The plane to split by: that of the literal nearest to the root.
    fn splitter(&self, cell: &Cell, plane: SurfaceId) -> Option<SurfaceId> {
        let formula = &cell.formula;
        // Gates come after their operands: from the root backwards.
        let gates = formula.gates().iter().rev();
        let operands = gates.flat_map(|gate| formula.operands_of(gate));
        operands
            .filter_map(|&operand| match operand {
                Operand::Literal(i) => Some(cell.surface_of(&formula.literals()[i as usize])),
                _ => None,
            })
            .find(|id| *id != plane && !self.along.contains(id))
    }

    fn split(&mut self, scene: &Scene<'_>, piece: &Polygon, cell: &Cell, by: SurfaceId) {
        for inside in [true, false] {
            let mut part = piece.clone();
            clip(scene, by, inside, &mut part);
            if part.len() < 3 {
                continue;
            }
            let mut copy = self.spare.pop().unwrap_or_default();
            copy.clone_from(cell);
            self.pending.push((part, copy));
        }
    }
}

/// The part of a plane that lies in a block.
fn section(scene: &Scene<'_>, block: &Block, plane: SurfaceId) -> Option<Polygon> {
    let plane = scene.plane(plane);
    let normal = plane.normal;
    let center = 0.5 * (block.low + block.high);
    let foot = center - plane.value(center) * normal;
    let (u, v) = normal.any_orthonormal_pair();
    let reach = 2.0 * (block.high - block.low).length();
    let mut polygon: Polygon = [u + v, v - u, -u - v, u - v]
        .into_iter()
        .map(|corner| (foot + reach * corner, None))
        .collect();
    for axis in 0..3 {
        for (bound, sign) in [(block.low[axis], -1.0), (block.high[axis], 1.0)] {
            clip_by(&mut polygon, None, |p| {
                sign * (p[axis] - bound) - scene.weld
            });
        }
    }
    (polygon.len() >= 3).then_some(polygon)
}

/// Least and greatest value of a plane on a polygon.
fn range(scene: &Scene<'_>, plane: SurfaceId, polygon: &Polygon) -> (f64, f64) {
    let plane = scene.plane(plane);
    polygon
        .iter()
        .map(|&(point, _)| plane.value(point))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        })
}

/// Clips a piece to the half-spaces that all of the solid lies in, or all of
/// its complement: the literals at the root. False if nothing is left.
fn clip_by_root(scene: &Scene<'_>, cell: &Cell, plane: SurfaceId, piece: &mut Polygon) -> bool {
    let formula = &cell.formula;
    let Operand::Gate(root) = formula.root() else {
        return true;
    };
    let root = &formula.gates()[root as usize];
    for &operand in formula.operands_of(root) {
        let Operand::Literal(i) = operand else {
            continue;
        };
        let literal = &formula.literals()[i as usize];
        let id = cell.surface_of(literal);
        if id == plane {
            continue;
        }
        // Where the literal decides the root nothing changes any more.
        let decides_inside = root.operation.absorbing() != literal.outside;
        clip(scene, id, !decides_inside, piece);
        if piece.len() < 3 {
            return false;
        }
    }
    true
}

/// Keeps the part of a polygon on one side of a plane; all of it if no corner
/// is farther on the other side than rounding.
fn clip(scene: &Scene<'_>, plane: SurfaceId, inside: bool, polygon: &mut Polygon) {
    let by = scene.plane(plane);
    let sign = if inside { 1.0 } else { -1.0 };
    let value = |p: DVec3| sign * by.value(p);
    if polygon.iter().all(|&(p, _)| value(p) <= scene.on_plane) {
        return;
    }
    if polygon.iter().all(|&(p, _)| value(p) >= -scene.on_plane) {
        polygon.clear();
        return;
    }
    clip_by(polygon, Some(plane), value);
}

/// Keeps the part of a polygon where `value` is at most 0 (Sutherland and
/// Hodgman, *Reentrant Polygon Clipping*, 1974).
fn clip_by(polygon: &mut Polygon, label: Option<SurfaceId>, value: impl Fn(DVec3) -> f64) {
    let mut kept = Polygon::new();
    for (k, &(p, side)) in polygon.iter().enumerate() {
        let (q, _) = polygon[(k + 1) % polygon.len()];
        let (at_p, at_q) = (value(p), value(q));
        if at_p <= 0.0 {
            kept.push((p, side));
        }
        if (at_p <= 0.0) != (at_q <= 0.0) {
            let cross = p + at_p / (at_p - at_q) * (q - p);
            // Leaving, the plane's own side begins; entering, the old goes on.
            kept.push((cross, if at_p <= 0.0 { label } else { side }));
        }
    }
    *polygon = kept;
}

fn record(
    scene: &Scene<'_>,
    block: &Block,
    position: Position,
    piece: &Polygon,
    found: &mut Vec<Candidate>,
) {
    for (k, &(from, label)) in piece.iter().enumerate() {
        let Some(other) = label.and_then(|id| block.position_of(id)) else {
            continue;
        };
        let pair = [position.min(other), position.max(other)];
        let Some(line) = Line::of_pair(scene, block, pair) else {
            continue;
        };
        let (to, _) = piece[(k + 1) % piece.len()];
        let (a, b) = (line.along(from), line.along(to));
        found.push(Candidate {
            pair,
            start: a.min(b),
            end: a.max(b),
            edge: None,
        });
    }
}

/// Makes one candidate of all on the same line: everything between them.
pub(super) fn merge(candidates: &mut Vec<Candidate>) {
    candidates.sort_unstable_by_key(|c| c.pair);
    candidates.dedup_by(|next, kept| {
        let is_same = next.pair == kept.pair;
        if is_same {
            kept.start = kept.start.min(next.start);
            kept.end = kept.end.max(next.end);
        }
        is_same
    });
}
