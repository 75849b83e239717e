//! The mesh while it changes: triangles as triples of half-edges.
//!
//! Half-edges 4t, 4t + 1 and 4t + 2 run around triangle t; each knows the
//! vertex it leaves and its twin, which runs along the same edge the other way
//! in the neighbouring triangle. Splitting, flipping and removing keep the mesh
//! closed, oriented and manifold.

use std::ops::Range;

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::Surfaced;
use super::contacts::Contacts;
use super::regions::{Region, regions};
use crate::evaluation::Borders;
use crate::program::Surface;

/// No half-edge, no vertex, no curve.
pub(super) const NONE: u32 = u32::MAX;

/// One side of an edge. Every fourth one is none, so that a triangle's are found
/// without a division.
#[derive(Clone, Copy, Debug)]
struct Half {
    /// The vertex it leaves; [`NONE`] in a triangle that is gone.
    origin: u32,
    twin: u32,
    /// The piece of a curve that the edge stands for, if there is any left to
    /// be cut up.
    piece: u32,
    /// The face of its triangle.
    region: u32,
}

impl Half {
    /// The half-edges of a triangle.
    fn of_triangle([a, b, c]: [u32; 3], region: u32) -> [Self; 4] {
        [a, b, c, NONE].map(|origin| Self {
            origin,
            twin: NONE,
            piece: NONE,
            region,
        })
    }
}

/// Where a vertex may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Anywhere on its surface.
    Face,
    /// Along the curve in which its two surfaces meet.
    Curve,
    /// Nowhere: the end of a curve, or an apex, on a curve or not.
    Corner,
    /// The vertex is gone.
    Gone,
}

#[derive(Clone)]
pub(super) struct HalfEdges<'a> {
    pub surfaces: &'a [Surface],
    pub regions: Vec<Region>,
    pub positions: Vec<DVec3>,
    pub kinds: Vec<Kind>,
    /// For each vertex a half-edge that leaves it.
    pub leaving: Vec<u32>,
    halves: Vec<Half>,
    /// For each piece of a curve its half-edge in the piece's direction.
    pub piece_halves: Vec<u32>,
    /// Triangles that are gone.
    pub free: Vec<u32>,
    /// Edges between its vertices that only the small triangles of faces have
    /// that are done, both ways.
    pub fine_edges: FxHashSet<[u32; 2]>,
    /// Edges along which the solid touches itself.
    pub contacts: Contacts,
    /// For edges between faces of one surface, by their ends in ascending order, the
    /// other surface on whose curve they are, where it is known; and for some that
    /// are no more.
    pub borders: Borders,
}

#[inline(always)]
pub(super) const fn next(half: u32) -> u32 {
    if half & 3 == 2 { half - 2 } else { half + 1 }
}

#[inline(always)]
pub(super) const fn previous(half: u32) -> u32 {
    if half & 3 == 0 { half + 2 } else { half - 1 }
}

/// The triangle that a half-edge runs around.
#[inline(always)]
pub(super) const fn triangle_of(half: u32) -> u32 {
    half >> 2
}

/// The first half-edge of a triangle.
#[inline(always)]
pub(super) const fn first_of(triangle: u32) -> u32 {
    triangle << 2
}

/// The half-edges of a triangle.
#[inline(always)]
pub(super) const fn halves_of(triangle: u32) -> Range<u32> {
    first_of(triangle)..first_of(triangle) + 3
}

/// Half-edges with their twins; `None` if the triangles are no closed, oriented
/// 2-manifold.
fn pair_up(vertices: usize, triangles: &[[u32; 3]]) -> Option<Vec<Half>> {
    // The half-edges that leave every vertex, and where to, by counting.
    let mut starts = vec![0u32; vertices + 2];
    for &origin in triangles.as_flattened() {
        *starts.get_mut(origin as usize + 2)? += 1;
    }
    for v in 2..starts.len() {
        starts[v] += starts[v - 1];
    }
    let mut leaving = vec![(0, 0); 3 * triangles.len()];
    for (triangle, &[a, b, c]) in (0u32..).zip(triangles) {
        for (half, (from, to)) in halves_of(triangle).zip([(a, b), (b, c), (c, a)]) {
            let slot = &mut starts[from as usize + 1];
            leaving[*slot as usize] = (to, half);
            *slot += 1;
        }
    }
    let mut halves = Vec::with_capacity(4 * triangles.len());
    for &corners in triangles {
        halves.extend(Half::of_triangle(corners, NONE));
    }
    for (from, ends) in (0u32..).zip(starts[..=vertices].windows(2)) {
        for &(to, half) in &leaving[ends[0] as usize..ends[1] as usize] {
            if from >= to {
                continue;
            }
            let back = starts[to as usize] as usize..starts[to as usize + 1] as usize;
            let mut twins = leaving[back].iter().filter(|(target, _)| *target == from);
            let &(_, twin) = twins.next()?;
            if twins.next().is_some() || halves[twin as usize].twin != NONE {
                return None;
            }
            halves[half as usize].twin = twin;
            halves[twin as usize].twin = half;
        }
    }
    let is_paired = |half: &Half| half.origin == NONE || half.twin != NONE;
    halves.iter().all(is_paired).then_some(halves)
}

impl<'a> HalfEdges<'a> {
    /// `None` if the triangles are no closed, oriented 2-manifold.
    pub fn new(surfaced: &Surfaced, surfaces: &'a [Surface]) -> Option<Self> {
        let positions = surfaced.positions.clone();
        let halves = pair_up(positions.len(), &surfaced.triangles)?;
        let mut leaving = vec![NONE; positions.len()];
        for (triangle, corners) in (0u32..).zip(&surfaced.triangles) {
            for (half, &origin) in halves_of(triangle).zip(corners) {
                leaving[origin as usize] = half;
            }
        }
        let mut mesh = Self {
            surfaces,
            regions: Vec::new(),
            kinds: vec![Kind::Gone; positions.len()],
            positions,
            leaving,
            halves,
            piece_halves: Vec::new(),
            free: Vec::new(),
            fine_edges: FxHashSet::default(),
            contacts: Contacts::default(),
            borders: surfaced.borders.clone(),
        };
        mesh.regions = regions(&mut mesh, &surfaced.groups, &surfaced.surface_of_group);
        for vertex in 0..mesh.positions.len() as u32 {
            if mesh.leaving[vertex as usize] != NONE {
                mesh.kinds[vertex as usize] = mesh.kind_of(vertex);
            }
        }
        Some(mesh)
    }

    /// The vertices that an edge joins, in ascending order.
    #[inline(always)]
    pub fn ends(&self, half: u32) -> [u32; 2] {
        let [a, b] = [self.origin(half), self.target(half)];
        [a.min(b), a.max(b)]
    }

    fn kind_of(&self, vertex: u32) -> Kind {
        let mut features = [NONE; 2];
        let mut count = 0;
        for half in self.around(vertex) {
            if self.is_feature(half) {
                if count == 2 {
                    return Kind::Corner;
                }
                features[count] = half;
                count += 1;
            }
        }
        match count {
            0 if self.has_apex(self.leaving[vertex as usize], self.at(vertex)) => Kind::Corner,
            0 => Kind::Face,
            2 => {
                let [first, second] = features.map(|half| {
                    let [a, b] = self.curve(half);
                    (a.min(b), a.max(b))
                });
                // A border within one surface of which no more is known is nobody's
                // to move.
                let is_curve = first == second && first.0 != first.1;
                let sides = [features[0], self.twin(features[0])];
                let is_apex = sides
                    .iter()
                    .any(|&half| self.has_apex(half, self.at(vertex)));
                if is_curve && !is_apex {
                    Kind::Curve
                } else {
                    Kind::Corner
                }
            }
            _ => Kind::Corner,
        }
    }

    /// Whether a point is the apex of a half-edge's surface.
    fn has_apex(&self, half: u32, at: DVec3) -> bool {
        let apex = self.surface(half).apex();
        apex.is_some_and(|apex| apex.distance(at) <= 1e-12 * (at.length() + apex.length()))
    }

    #[inline(always)]
    pub fn origin(&self, half: u32) -> u32 {
        self.halves[half as usize].origin
    }

    #[inline(always)]
    pub fn set_origin(&mut self, half: u32, vertex: u32) {
        self.halves[half as usize].origin = vertex;
    }

    #[inline(always)]
    pub fn target(&self, half: u32) -> u32 {
        self.origin(next(half))
    }

    /// The vertex across from a half-edge in its triangle.
    #[inline(always)]
    pub fn apex(&self, half: u32) -> u32 {
        self.origin(previous(half))
    }

    /// The corners of the triangles on both sides of an edge, counter-clockwise from
    /// the vertex that a half-edge leaves: the one across from it comes last.
    #[inline(always)]
    pub fn quad(&self, half: u32) -> [u32; 4] {
        let twin = self.twin(half);
        [
            self.origin(half),
            self.apex(twin),
            self.origin(twin),
            self.apex(half),
        ]
    }

    #[inline(always)]
    pub fn twin(&self, half: u32) -> u32 {
        self.halves[half as usize].twin
    }

    /// The piece of a curve that an edge stands for, if there is any left to be cut
    /// up.
    #[inline(always)]
    pub fn piece(&self, half: u32) -> u32 {
        self.halves[half as usize].piece
    }

    #[inline(always)]
    pub fn set_piece(&mut self, half: u32, piece: u32) {
        self.halves[half as usize].piece = piece;
    }

    #[inline(always)]
    pub fn at(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    #[inline(always)]
    pub fn region(&self, half: u32) -> &Region {
        &self.regions[self.halves[half as usize].region as usize]
    }

    /// The region of a triangle, by number.
    #[inline(always)]
    pub fn region_index(&self, triangle: u32) -> u32 {
        self.halves[first_of(triangle) as usize].region
    }

    #[inline(always)]
    pub fn set_region(&mut self, triangle: u32, region: u32) {
        for half in halves_of(triangle) {
            self.halves[half as usize].region = region;
        }
    }

    #[inline(always)]
    pub fn surface_index(&self, half: u32) -> u32 {
        self.region(half).surface
    }

    #[inline(always)]
    pub fn surface(&self, half: u32) -> &'a Surface {
        &self.surfaces[self.surface_index(half) as usize]
    }

    /// The surfaces on whose curve an edge is: those on both sides of it, and on a
    /// border within one surface another one. Twice the same one if it is on none,
    /// or on none that is known.
    #[inline(always)]
    pub fn curve(&self, half: u32) -> [u32; 2] {
        let one = self.surface_index(half);
        if !self.is_feature(half) {
            return [one; 2];
        }
        let other = self.surface_index(self.twin(half));
        if one != other || self.borders.is_empty() {
            return [one, other];
        }
        let other = self.borders.get(&self.ends(half));
        [one, other.copied().unwrap_or(one)]
    }

    #[inline(always)]
    pub fn curve_surfaces(&self, half: u32) -> [&'a Surface; 2] {
        self.curve(half).map(|index| &self.surfaces[index as usize])
    }

    #[inline(always)]
    pub fn is_on_curve(&self, half: u32) -> bool {
        let [one, other] = self.curve(half);
        one != other
    }

    /// Lets the border along an edge, if it is one, go through these vertices.
    pub fn carry_border(&mut self, [a, b]: [u32; 2], through: impl IntoIterator<Item = u32>) {
        if self.borders.is_empty() {
            return;
        }
        let Some(&other) = self.borders.get(&[a.min(b), a.max(b)]) else {
            return;
        };
        let mut through = through.into_iter();
        let mut before = through.next();
        for vertex in through {
            let from = before.replace(vertex).unwrap_or(vertex);
            self.borders
                .insert([from.min(vertex), from.max(vertex)], other);
        }
    }

    /// Whether an edge separates two regions.
    #[inline(always)]
    pub fn is_feature(&self, half: u32) -> bool {
        let Half { twin, region, .. } = self.halves[half as usize];
        self.halves[twin as usize].region != region
    }

    #[inline(always)]
    pub fn triangle(&self, triangle: u32) -> [u32; 3] {
        let half = first_of(triangle);
        [
            self.origin(half),
            self.origin(half + 1),
            self.origin(half + 2),
        ]
    }

    /// The places of a triangle's corners.
    #[inline(always)]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        let [a, b, c] = self.triangle(triangle);
        [self.at(a), self.at(b), self.at(c)]
    }

    pub fn is_gone(&self, triangle: u32) -> bool {
        self.origin(first_of(triangle)) == NONE
    }

    pub fn triangle_count(&self) -> u32 {
        triangle_of(self.end_of_halves())
    }

    /// More than any half-edge's number.
    pub fn end_of_halves(&self) -> u32 {
        self.halves.len() as u32
    }

    /// The half-edges of all triangles that are not gone.
    pub fn halves(&self) -> impl Iterator<Item = u32> + '_ {
        let halves = (0u32..).zip(&self.halves);
        let left = halves.filter(|(_, half)| half.origin != NONE);
        left.map(|(half, _)| half)
    }

    /// One half of every edge.
    pub fn edges(&self) -> impl Iterator<Item = u32> + '_ {
        self.halves().filter(|&half| half < self.twin(half))
    }

    /// A triangle is no more.
    pub fn discard(&mut self, triangle: u32) {
        for half in halves_of(triangle) {
            self.set_origin(half, NONE);
        }
        self.free.push(triangle);
    }

    /// The half-edges that leave a vertex, counter-clockwise.
    #[inline]
    pub fn around(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.leaving[vertex as usize];
        let mut half = first;
        let mut done = first == NONE;
        std::iter::from_fn(move || {
            if done {
                return None;
            }
            let here = half;
            half = self.twin(previous(here));
            done = half == first;
            Some(here)
        })
    }

    /// Whether an edge joins two vertices. Takes as long as the smaller number of
    /// edges at one of them.
    pub fn are_joined(&self, from: u32, to: u32) -> bool {
        let firsts = [from, to].map(|vertex| self.leaving[vertex as usize]);
        if firsts.contains(&NONE) {
            return false;
        }
        let [mut there, mut back] = firsts;
        loop {
            let twins = [there, back].map(|half| self.twin(half));
            if self.origin(twins[0]) == to || self.origin(twins[1]) == from {
                return true;
            }
            [there, back] = twins.map(next);
            if there == firsts[0] || back == firsts[1] {
                break;
            }
        }
        !self.fine_edges.is_empty() && self.fine_edges.contains(&[from, to])
    }

    /// Makes two half-edges twins.
    #[inline(always)]
    pub fn join(&mut self, a: u32, b: u32) {
        self.halves[a as usize].twin = b;
        self.halves[b as usize].twin = a;
    }

    /// Gives the twin and the piece of one half-edge to another.
    #[inline(always)]
    fn hand_over(&mut self, from: u32, to: u32) {
        let (twin, piece) = (self.twin(from), self.piece(from));
        self.join(to, twin);
        self.set_piece(to, piece);
        self.set_piece(from, NONE);
        if piece != NONE && self.piece_halves[piece as usize] == from {
            self.piece_halves[piece as usize] = to;
        }
    }

    /// Splits an edge at a new vertex: two triangles become four.
    ///
    /// ```text
    ///      c               c
    ///     / \            / | \
    ///    u - w    →     u- x -w
    ///     \ /            \ | /
    ///      d               d
    /// ```
    /// `half`, u → w, becomes u → x, where x is in no triangle yet. Returns the
    /// half-edge x → w.
    pub fn split(&mut self, half: u32, x: u32) -> u32 {
        let twin = self.twin(half);
        let ends = [self.origin(half), self.origin(twin)];
        self.carry_border(ends, [ends[0], x, ends[1]]);
        let (n, p) = (next(half), previous(half));
        let (tn, tp) = (next(twin), previous(twin));
        let (c, w, d) = (self.origin(p), self.origin(n), self.origin(tp));
        let b = self.end_of_halves();
        let e = b + 4;
        for (side, corners) in [(half, [x, w, c]), (twin, [w, x, d])] {
            let region = self.halves[side as usize].region;
            self.halves.extend(Half::of_triangle(corners, region));
        }
        self.hand_over(n, b + 1);
        self.hand_over(tp, e + 2);
        self.set_origin(n, x);
        self.set_origin(twin, x);
        self.join(n, b + 2);
        self.join(tp, e + 1);
        self.join(b, e);
        self.leaving[x as usize] = b;
        self.leaving[w as usize] = b + 1;
        debug_assert!(self.origin(tn) == self.target(twin));
        b
    }

    /// Adds a vertex that is in no triangle yet.
    pub fn add_vertex(&mut self, position: DVec3, kind: Kind) -> u32 {
        self.positions.push(position);
        self.kinds.push(kind);
        self.leaving.push(NONE);
        self.positions.len() as u32 - 1
    }

    /// Turns the edge between two triangles: a → b becomes d → c.
    ///
    /// ```text
    ///      c               c
    ///     / \            / | \
    ///    a - b    →     a  |  b
    ///     \ /            \ | /
    ///      d               d
    /// ```
    /// Whether that may be is for the caller to know.
    pub fn flip(&mut self, half: u32) {
        let twin = self.twin(half);
        let (n, p) = (next(half), previous(half));
        let (tn, tp) = (next(twin), previous(twin));
        let (a, b) = (self.origin(half), self.origin(twin));
        let (c, d) = (self.origin(p), self.origin(tp));
        self.hand_over(tp, half);
        self.hand_over(p, twin);
        self.set_origin(half, d);
        self.set_origin(twin, c);
        self.join(p, tp);
        self.leaving[a as usize] = tn;
        self.leaving[b as usize] = n;
        debug_assert!(self.target(p) == d && self.target(tp) == c);
    }
}
