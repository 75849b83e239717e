//! Cohen–Sutherland line clipping against a rectangle.
//!
//! The plane falls into nine regions with four-bit outcodes:
//!
//! ```text
//!   1001 | 1000 | 1010        bit 0: left of the rectangle
//!   -----+------+-----        bit 1: right of it
//!   0001 | 0000 | 0010        bit 2: below it
//!   -----+------+-----        bit 3: above it
//!   0101 | 0100 | 0110
//! ```
//!
//! The codes a, b of the two ends decide: a | b = 0, accept; a & b ≠ 0,
//! reject; otherwise cut off the part of an outside end beyond one of the
//! lines it is outside of, and decide again (Newman, Sproull, *Principles of
//! Interactive Computer Graphics*, 2nd ed., 5-1).

use glam::DVec2;

/// A closed rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Lower left corner.
    pub low: DVec2,
    /// Upper right corner.
    pub high: DVec2,
}

/// Left of the rectangle.
pub const LEFT: u8 = 1;
/// Right of the rectangle.
pub const RIGHT: u8 = 2;
/// Below the rectangle.
pub const BELOW: u8 = 4;
/// Above the rectangle.
pub const ABOVE: u8 = 8;

/// What the outcodes of a segment's ends decide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Both ends are inside.
    Accept,
    /// Both ends are outside of the same line.
    Reject,
    /// Neither: the segment has to be cut.
    Cut,
}

impl Rectangle {
    /// The four-bit outcode of a point; 0 inside and on the boundary.
    #[must_use]
    pub fn outcode(&self, p: DVec2) -> u8 {
        let horizontal = if p.x < self.low.x {
            LEFT
        } else if p.x > self.high.x {
            RIGHT
        } else {
            0
        };
        let vertical = if p.y < self.low.y {
            BELOW
        } else if p.y > self.high.y {
            ABOVE
        } else {
            0
        };
        horizontal | vertical
    }

    /// The part of a segment inside the rectangle; `None` if there is none or
    /// an end is not finite.
    #[must_use]
    pub fn clip(&self, mut a: DVec2, mut b: DVec2) -> Option<(DVec2, DVec2)> {
        if !(a.is_finite() && b.is_finite()) {
            return None;
        }
        // Each cut puts an end onto one of the four lines for good.
        for _ in 0..5 {
            let (code_a, code_b) = (self.outcode(a), self.outcode(b));
            match decide(code_a, code_b) {
                Decision::Accept => return Some((a, b)),
                Decision::Reject => return None,
                Decision::Cut if code_a != 0 => a = self.cut(a, b, code_a),
                Decision::Cut => b = self.cut(b, a, code_b),
            }
        }
        None
    }

    /// Moves the end `p`, of code `code`, along the segment to `q` onto a
    /// line it is outside of.
    fn cut(&self, p: DVec2, q: DVec2, code: u8) -> DVec2 {
        let (axis, limit) = match code {
            _ if code & LEFT != 0 => (0, self.low.x),
            _ if code & RIGHT != 0 => (0, self.high.x),
            _ if code & BELOW != 0 => (1, self.low.y),
            _ => (1, self.high.y),
        };
        let t = (limit - p[axis]) / (q[axis] - p[axis]);
        let mut cut = p + (q - p) * t;
        cut[axis] = limit;
        cut
    }
}

/// The decision table.
#[must_use]
pub fn decide(a: u8, b: u8) -> Decision {
    if a | b == 0 {
        Decision::Accept
    } else if a & b != 0 {
        Decision::Reject
    } else {
        Decision::Cut
    }
}
