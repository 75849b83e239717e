//! The mesh while it changes: triangles as triples of half-edges.
//!
//! Half-edges 4t, 4t + 1 and 4t + 2 run around triangle t; each knows the
//! vertex it leaves and its twin, which runs along the same edge the other way
//! in the neighbouring triangle. Splitting, flipping and removing keep the mesh
//! closed, oriented and manifold.

mod build;
mod changes;
mod contacts;
mod pairing;

use glam::DVec3;
use rustc_hash::FxHashSet;

pub(super) use self::pairing::{NONE, first_of, halves_of, next, previous, triangle_of};

use self::pairing::Half;
use super::contacts::Contacts;
use super::region::Region;
use super::shape::faces_in;
use crate::arrangement::Borders;
use crate::program::{Surface, SurfaceId};

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
    /// How near points must come to their surfaces.
    pub precision: f64,
}

impl<'a> HalfEdges<'a> {
    /// The vertices that an edge joins, in ascending order.
    #[inline(always)]
    pub fn ends(&self, half: u32) -> [u32; 2] {
        let [a, b] = [self.origin(half), self.target(half)];
        [a.min(b), a.max(b)]
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
    pub fn surface_id(&self, half: u32) -> SurfaceId {
        self.region(half).surface
    }

    #[inline(always)]
    pub fn surface(&self, half: u32) -> &'a Surface {
        &self.surfaces[self.surface_id(half)]
    }

    /// The surfaces on whose curve an edge is: those on both sides of it, and on a
    /// border within one surface another one. Twice the same one if it is on none,
    /// or on none that is known.
    #[inline(always)]
    pub fn curve(&self, half: u32) -> [SurfaceId; 2] {
        let one = self.surface_id(half);
        if !self.is_feature(half) {
            return [one; 2];
        }
        let other = self.surface_id(self.twin(half));
        if one != other || self.borders.is_empty() {
            return [one, other];
        }
        let other = self.borders.get(&self.ends(half));
        [one, other.copied().unwrap_or(one)]
    }

    #[inline(always)]
    pub fn curve_surfaces(&self, half: u32) -> [&'a Surface; 2] {
        self.curve(half).map(|id| &self.surfaces[id])
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

    /// Whether a triangle faces against the rest of its face.
    pub fn is_folded(&self, triangle: u32) -> bool {
        let half = first_of(triangle);
        !self.is_gone(triangle)
            && faces_in(
                self.surface(half),
                self.region(half),
                self.corners(triangle),
            )
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
}
