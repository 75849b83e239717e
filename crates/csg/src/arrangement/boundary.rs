//! The boundary as half-edges: pieces of edges linked to the contours of faces.
//!
//! Each half-edge has its twin on the other face by construction, and every
//! contour closes; so the surface is closed, oriented and manifold whatever the
//! coordinates are. Where faces touch along an edge or at a point, contours keep
//! to their own sector of the face, and twins to their own wedge of the solid.

use std::mem::replace;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::contacts::Contact;
use super::ids::{FaceId, HalfEdgeId, VertexId};
use super::picture::Slits;
use super::piece::{CurveId, Piece, Side};
use super::scene::Scene;
use super::weld::{Welded, weld};
use crate::mesh::triangulate::is_surrounded;
use crate::program::{Surface, SurfaceId};
use crate::undecided::{Stop, Why};

/// For edges between faces of one surface that look different, by their ends in
/// ascending order, the other surface on whose curve they are.
pub(crate) type Borders = FxHashMap<[u32; 2], SurfaceId>;

/// A half-edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfEdge {
    /// The vertex it starts from.
    pub from: VertexId,
    pub twin: HalfEdgeId,
    /// Its neighbours along the contour, once that is linked.
    pub next: HalfEdgeId,
    pub previous: HalfEdgeId,
    pub face: FaceId,
    /// Whether it was taken out.
    pub is_removed: bool,
    /// The curve that it is a piece of.
    pub curve: CurveId,
    /// Where on that it starts and ends, but for rounding; along lines it may go on.
    pub places: [f64; 2],
    /// Whether it starts where it may as well go on backwards.
    pub goes_back: bool,
}

/// Whether it is the look of one surface that changes between two faces.
fn is_border([one, other]: [&Side; 2]) -> bool {
    one.plane == other.plane && one.look != other.look
}

/// Contours of all faces.
#[derive(Debug, Default)]
pub(super) struct Boundary {
    pub points: Vec<DVec3>,
    pub half_edges: Vec<HalfEdge>,
    pub faces: Vec<Side>,
}

impl Boundary {
    /// Links pieces; undecided if they do not close, where rounding made blocks and
    /// lines disagree.
    ///
    /// Contacts are moved to the vertices at the same places.
    pub fn link(
        scene: &Scene<'_>,
        pieces: &[Piece],
        contacts: &mut [Contact],
    ) -> Result<Self, Stop> {
        let mut all = Self::default();
        let Welded { points, ends } = weld(scene, pieces, contacts)?;
        all.points = points;
        let mut face_of: FxHashMap<Side, FaceId> = FxHashMap::default();
        all.half_edges.reserve(2 * pieces.len());
        for (piece, [from, to]) in pieces.iter().zip(ends) {
            scene.go_on()?;
            if from == to {
                continue;
            }
            let halves = [0, 1].map(|k| HalfEdgeId(all.half_edges.len() as u32 + k));
            let [start, end] = piece.places;
            let ways = [(from, [start, end]), (to, [end, start])];
            let ways = piece.sides.iter().zip(ways).zip(piece.goes_on);
            for (k, ((side, (from, places)), goes_back)) in ways.enumerate() {
                let face = *face_of.entry(*side).or_insert_with(|| {
                    all.faces.push(*side);
                    FaceId(all.faces.len() as u32 - 1)
                });
                all.half_edges.push(HalfEdge {
                    from,
                    twin: halves[1 - k],
                    next: halves[k],
                    previous: halves[k],
                    face,
                    is_removed: false,
                    curve: piece.curve,
                    places,
                    goes_back,
                });
            }
        }
        all.link_contours(scene)?;
        all.simplify(scene)?;
        Ok(all)
    }

    pub fn at(&self, half_edge: HalfEdgeId) -> &HalfEdge {
        &self.half_edges[half_edge.index()]
    }

    fn at_mut(&mut self, half_edge: HalfEdgeId) -> &mut HalfEdge {
        &mut self.half_edges[half_edge.index()]
    }

    pub fn point(&self, vertex: VertexId) -> DVec3 {
        self.points[vertex.index()]
    }

    /// Of the face on its left.
    pub fn side(&self, half_edge: HalfEdgeId) -> &Side {
        &self.faces[self.at(half_edge).face.index()]
    }

    /// All half-edges but those that were taken out.
    pub fn halves(&self) -> impl Iterator<Item = HalfEdgeId> {
        let all = HalfEdgeId::all(self.half_edges.len());
        all.filter(|&half_edge| !self.at(half_edge).is_removed)
    }

    /// One half of each edge.
    pub fn edges(&self) -> impl Iterator<Item = HalfEdgeId> {
        self.halves().filter(|&half| half < self.at(half).twin)
    }

    /// A half-edge and its twin.
    pub fn both(&self, half_edge: HalfEdgeId) -> [HalfEdgeId; 2] {
        [half_edge, self.at(half_edge).twin]
    }

    /// The faces on both sides of an edge.
    pub fn faces_of(&self, half_edge: HalfEdgeId) -> [FaceId; 2] {
        self.both(half_edge).map(|half| self.at(half).face)
    }

    /// The vertices that a half-edge leads from and to.
    pub fn ends(&self, half_edge: HalfEdgeId) -> [VertexId; 2] {
        self.both(half_edge).map(|half| self.at(half).from)
    }

    /// The points of these.
    pub fn chord(&self, half_edge: HalfEdgeId) -> [DVec3; 2] {
        self.ends(half_edge).map(|vertex| self.point(vertex))
    }

    pub fn join(&mut self, half_edge: HalfEdgeId, next: HalfEdgeId) {
        self.at_mut(half_edge).next = next;
        self.at_mut(next).previous = half_edge;
    }

    fn make_twins(&mut self, a: HalfEdgeId, b: HalfEdgeId) {
        self.at_mut(a).twin = b;
        self.at_mut(b).twin = a;
    }

    fn remove(&mut self, half_edge: HalfEdgeId) {
        self.at_mut(half_edge).is_removed = true;
    }

    /// The surfaces on whose curve an edge is; none where a face goes on across it
    /// from what is left of one thinner than rounding.
    pub fn surfaces_of<'a>(
        &self,
        scene: &'a Scene<'_>,
        half_edge: HalfEdgeId,
    ) -> Option<[&'a Surface; 2]> {
        let HalfEdge { twin, curve, .. } = *self.at(half_edge);
        let [first, second] = self.both(half_edge).map(|half| self.side(half));
        let surface = scene.surface(first.plane);
        if first.plane != second.plane {
            return Some([surface, scene.surface(second.plane)]);
        }
        if first.shares_patch(second) {
            // Where its look changes, or other faces touch it.
            let pair = curve.pair().filter(|_| curve == self.at(twin).curve);
            return pair.map(|pair| pair.map(|id| scene.surface(id)));
        }
        let frame = scene.frame(first.plane)?;
        let bit = (first.patch ^ second.patch).trailing_zeros() as usize;
        frame.planes().nth(bit).map(|seam| [surface, seam])
    }

    /// The edges where the look of a surface changes, by the numbers of their
    /// vertices in fans.
    pub fn borders(&self) -> Borders {
        let is_border = |&half_edge: &HalfEdgeId| {
            let both = self.both(half_edge);
            let [one, other] = both.map(|half| self.at(half).curve);
            is_border(both.map(|half| self.side(half))) && one == other
        };
        let halves: Vec<HalfEdgeId> = self.halves().filter(is_border).collect();
        if halves.is_empty() {
            return Borders::default();
        }
        let (fan_of, _) = self.fans();
        let border = |half_edge: HalfEdgeId| {
            let surface = self.side(half_edge).plane;
            let mut others = self.at(half_edge).curve.surfaces();
            let other = others.find(|&id| id != surface)?;
            let mut ends = self.both(half_edge).map(|half| fan_of[half.index()]);
            ends.sort_unstable();
            Some((ends, other))
        };
        halves.into_iter().filter_map(border).collect()
    }

    /// Takes out vertices at which an edge goes straight on, faces of two
    /// corners, and edges with the same face on both sides.
    ///
    /// A vertex on a straight edge stays if other edges touch it there, where
    /// faces may be pinched between the two; so does an edge within a face that
    /// others touch.
    fn simplify(&mut self, scene: &Scene<'_>) -> Result<(), Stop> {
        let mut leaving = vec![0u32; self.points.len()];
        for half_edge in &self.half_edges {
            leaving[half_edge.from.index()] += 1;
        }
        let halves = HalfEdgeId::all(self.half_edges.len());
        let mut pending: Vec<HalfEdgeId> = halves.rev().collect();
        while let Some(half_edge) = pending.pop() {
            scene.go_on()?;
            let HalfEdge {
                from,
                twin,
                next,
                previous,
                is_removed,
                ..
            } = *self.at(half_edge);
            if is_removed {
                continue;
            }
            let is_alone = |half: HalfEdgeId| leaving[self.at(half).from.index()] == 1;
            if next == half_edge || next == twin && previous == twin {
                // Nothing but this edge.
                let is_touched = next == twin && !(is_alone(half_edge) && is_alone(twin));
                if is_touched && self.lies_within_face(scene, half_edge) {
                    continue;
                }
                let HalfEdge { next, previous, .. } = *self.at(twin);
                if next != half_edge && next != twin {
                    self.join(previous, next);
                    pending.extend([previous, next]);
                }
                self.remove(half_edge);
                self.remove(twin);
                continue;
            }
            if previous == next {
                if self.is_lens(scene, half_edge) || self.lies_within_face(scene, half_edge) {
                    continue;
                }
                // A face of two corners.
                let other = self.at(next).twin;
                self.make_twins(twin, other);
                self.remove(half_edge);
                self.remove(next);
                pending.extend([twin, other, self.at(twin).next, self.at(other).next]);
                continue;
            }
            let around = self.at(previous).twin;
            if around == half_edge {
                // The end of a spike.
                if !is_alone(half_edge) {
                    continue;
                }
                let (before, after) = (self.at(previous).previous, next);
                self.join(before, after);
                self.remove(half_edge);
                self.remove(previous);
                pending.extend([before, after]);
                continue;
            }
            let opposite = self.at(around).previous;
            if self.at(opposite).twin == half_edge
                && leaving[from.index()] == 2
                && (self.goes_on(half_edge) || self.goes_straight(scene, half_edge))
            {
                // Two edges and two faces meet here, in one line or curve.
                self.lengthen(previous, half_edge);
                self.lengthen(opposite, around);
                self.join(previous, next);
                let after = self.at(around).next;
                self.join(opposite, after);
                self.make_twins(previous, opposite);
                self.remove(half_edge);
                self.remove(around);
                pending.extend([previous, next, opposite, after]);
            }
        }
        Ok(())
    }

    /// Lets a half-edge end on its curve where the one behind it does.
    fn lengthen(&mut self, half_edge: HalfEdgeId, next: HalfEdgeId) {
        let HalfEdge { curve, places, .. } = *self.at(next);
        let joined = self.at_mut(half_edge);
        if joined.curve == curve {
            // (There may be a turn between the two.)
            joined.places[1] += places[1] - places[0];
        }
    }

    /// Whether an edge may be one with that before it along the same curve.
    fn goes_on(&self, half_edge: HalfEdgeId) -> bool {
        let HalfEdge { previous, twin, .. } = *self.at(half_edge);
        let [before, around] = [previous, self.at(twin).next].map(|half| self.at(half));
        let here = self.at(half_edge);
        here.goes_back
            && around.goes_back
            && before.curve == here.curve
            && before.from != self.at(twin).from
    }

    /// Whether a face of two corners is one between two curves, wider than rounding: each is
    /// off the other one there where it is halfway.
    fn is_lens(&self, scene: &Scene<'_>, half_edge: HalfEdgeId) -> bool {
        let edges = [half_edge, self.at(half_edge).next];
        let is_off = |[one, other]: [HalfEdgeId; 2]| {
            let at = self.halfway(scene, one);
            let beside = at.and_then(|at| Some((at, self.on_curve(scene, other, at)?)));
            beside.is_some_and(|(at, beside)| at.distance(beside) > scene.near)
        };
        is_off(edges) && is_off([edges[1], edges[0]])
    }

    /// Whether the middle of an edge lies within other contours of its face: then
    /// two edges between the same vertices are a slit, along which other faces
    /// touch it, and else all that is left of a face thinner than rounding.
    fn lies_within_face(&self, scene: &Scene<'_>, half_edge: HalfEdgeId) -> bool {
        let HalfEdge { face, next, .. } = *self.at(half_edge);
        let side = self.side(half_edge);
        let flat = |vertex: VertexId| scene.flatten(side, self.point(vertex));
        let [a, b] = [half_edge, next].map(|half| flat(self.at(half).from));
        let others = self
            .halves()
            .filter(|&other| other != half_edge && other != next)
            .filter(|&other| self.at(other).face == face)
            .map(|other| self.ends(other).map(flat));
        is_surrounded(others, 0.5 * (a + b))
    }

    /// Whether an edge goes on in the direction of the one before it. It does
    /// between faces of two planes, but borders of looks turn within one.
    fn goes_straight(&self, scene: &Scene<'_>, half_edge: HalfEdgeId) -> bool {
        let before = self.at(self.at(half_edge).previous).from;
        let [from, to] = self.ends(half_edge);
        let [a, b, c] = [before, from, to].map(|vertex| self.point(vertex));
        let off = (b - a).cross(c - b).length();
        before != to && off <= scene.weld * (c - a).length()
    }

    /// For each half-edge the number of the vertex of the finished mesh that it
    /// starts from: each point once for every fan of faces around it. And the
    /// points of these vertices.
    pub fn fans(&self) -> (Vec<u32>, Vec<VertexId>) {
        let mut fan_of = vec![0; self.half_edges.len()];
        let mut seen = vec![false; self.half_edges.len()];
        let mut point_of = Vec::with_capacity(self.points.len());
        for start in self.halves() {
            if seen[start.index()] {
                continue;
            }
            let mut at = start;
            while !replace(&mut seen[at.index()], true) {
                fan_of[at.index()] = point_of.len() as u32;
                at = self.at(self.at(at).previous).twin;
            }
            point_of.push(self.at(start).from);
        }
        (fan_of, point_of)
    }

    /// Splits edges that have both vertices in common by vertices in the middles of
    /// their curves, those along the same curve at the same point; undecided where one
    /// cannot be found.
    pub fn split_double_edges(&mut self, scene: &Scene<'_>) -> Result<(), Stop> {
        let (fan_of, _) = self.fans();
        // One half of each edge, with its ends.
        let mut edges: Vec<([u32; 2], HalfEdgeId)> = Vec::with_capacity(fan_of.len() / 2);
        edges.extend(self.edges().map(|half_edge| {
            let mut ends = self.both(half_edge).map(|half| fan_of[half.index()]);
            ends.sort_unstable();
            (ends, half_edge)
        }));
        edges.sort_unstable();
        let doubled = edges.chunk_by(|a, b| a.0 == b.0).filter(|e| e.len() > 1);
        let doubled: Vec<HalfEdgeId> = doubled.flatten().map(|edge| edge.1).collect();
        if !doubled.is_empty() {
            let at = self.point(self.at(doubled[0]).from);
            let split = self.split(scene, &doubled);
            split.ok_or(Stop::undecided(Why::Edge, at))?;
        }
        Ok(())
    }

    /// One half of each edge along a curve that joins two vertices, by their
    /// numbers in fans.
    pub fn curves_between(&self, scene: &Scene<'_>, pairs: &[[u32; 2]]) -> Vec<HalfEdgeId> {
        if pairs.is_empty() {
            return Vec::new();
        }
        let (fan_of, _) = self.fans();
        let both_ways = pairs.iter().flat_map(|&[a, b]| [[a, b], [b, a]]);
        let pairs: FxHashSet<[u32; 2]> = both_ways.collect();
        let joins = |&half_edge: &HalfEdgeId| {
            pairs.contains(&self.both(half_edge).map(|half| fan_of[half.index()]))
                && self
                    .surfaces_of(scene, half_edge)
                    .is_some_and(|s| !s.iter().all(|s| s.is_plane()))
        };
        self.edges().filter(joins).collect()
    }

    /// Puts a vertex on an edge, at a place on the curve of each half.
    pub fn split_at(&mut self, half_edge: HalfEdgeId, point: DVec3, places: [f64; 2]) {
        let both = self.both(half_edge);
        let middle = VertexId(self.points.len() as u32);
        self.points.push(point);
        let rests = [0, 1].map(|k| HalfEdgeId(self.half_edges.len() as u32 + k));
        for ((half, rest), place) in both.into_iter().zip(rests).zip(places) {
            let whole = *self.at(half);
            self.half_edges.push(HalfEdge {
                from: middle,
                places: [place, whole.places[1]],
                goes_back: false,
                ..whole
            });
            self.at_mut(half).places[1] = place;
            self.join(rest, whole.next);
            self.join(half, rest);
        }
        self.make_twins(both[0], rests[1]);
        self.make_twins(both[1], rests[0]);
    }

    /// Edges with one face on both sides, by the numbers of their vertices in fans.
    pub fn slits(&self, fan_of: &[u32]) -> Slits {
        let is_slit = |&half: &HalfEdgeId| {
            let [face, other] = self.faces_of(half);
            face == other
        };
        let slits = self.halves().filter(is_slit);
        slits
            .map(|half| self.both(half).map(|half| fan_of[half.index()]))
            .collect()
    }

    /// The contours, by face: for each face its half-edges in runs.
    pub fn contours(&self) -> Vec<Vec<Vec<HalfEdgeId>>> {
        let mut of_face = vec![Vec::new(); self.faces.len()];
        let mut seen = vec![false; self.half_edges.len()];
        for start in self.halves() {
            if seen[start.index()] {
                continue;
            }
            let count = std::iter::successors(Some(start), |&at| Some(self.at(at).next));
            let count = 1 + count.skip(1).take_while(|&at| at != start).count();
            let mut contour = Vec::with_capacity(count);
            let mut at = start;
            while !replace(&mut seen[at.index()], true) {
                contour.push(at);
                at = self.at(at).next;
            }
            of_face[self.at(start).face.index()].push(contour);
        }
        of_face
    }
}
