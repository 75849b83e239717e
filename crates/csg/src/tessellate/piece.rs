//! What is left to be cut of a curve.

/// A stretch of a curve that is still one edge: the vertices that are going to
/// cut it up, in its half-edge's direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub first: u32,
    pub count: u32,
}
