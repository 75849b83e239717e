//! Triangles that come, go and change.

use glam::DVec3;

use super::pairing::Half;
use super::{HalfEdges, Kind, NONE, halves_of, next, previous};

impl HalfEdges<'_> {
    /// A triangle is no more.
    pub fn discard(&mut self, triangle: u32) {
        for half in halves_of(triangle) {
            self.set_origin(half, NONE);
        }
        self.free.push(triangle);
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
