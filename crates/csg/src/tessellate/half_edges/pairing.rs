//! Half-edges by number, and which two of them are an edge.

use std::ops::Range;

/// No half-edge, no vertex, no curve.
pub(in super::super) const NONE: u32 = u32::MAX;

/// One side of an edge. Every fourth one is none, so that a triangle's are found
/// without a division.
#[derive(Clone, Copy, Debug)]
pub(super) struct Half {
    /// The vertex it leaves; [`NONE`] in a triangle that is gone.
    pub origin: u32,
    pub twin: u32,
    /// The piece of a curve that the edge stands for, if there is any left to
    /// be cut up.
    pub piece: u32,
    /// The face of its triangle.
    pub region: u32,
}

impl Half {
    /// The half-edges of a triangle.
    #[inline(always)]
    pub fn of_triangle([a, b, c]: [u32; 3], region: u32) -> [Self; 4] {
        let leaving = |origin| Self {
            origin,
            twin: NONE,
            piece: NONE,
            region,
        };
        [leaving(a), leaving(b), leaving(c), leaving(NONE)]
    }
}

#[inline(always)]
pub(in super::super) const fn next(half: u32) -> u32 {
    if half & 3 == 2 { half - 2 } else { half + 1 }
}

#[inline(always)]
pub(in super::super) const fn previous(half: u32) -> u32 {
    if half & 3 == 0 { half + 2 } else { half - 1 }
}

/// The triangle that a half-edge runs around.
#[inline(always)]
pub(in super::super) const fn triangle_of(half: u32) -> u32 {
    half >> 2
}

/// The first half-edge of a triangle.
#[inline(always)]
pub(in super::super) const fn first_of(triangle: u32) -> u32 {
    triangle << 2
}

/// The half-edges of a triangle.
#[inline(always)]
pub(in super::super) const fn halves_of(triangle: u32) -> Range<u32> {
    first_of(triangle)..first_of(triangle) + 3
}

/// Half-edges with their twins; `None` if the triangles are no closed, oriented
/// 2-manifold.
pub(super) fn pair_up(vertices: usize, triangles: &[[u32; 3]]) -> Option<Vec<Half>> {
    let mut halves = Vec::with_capacity(4 * triangles.len());
    for &corners in triangles {
        halves.extend(Half::of_triangle(corners, NONE));
    }
    // All edges between a vertex and higher ones in a list: the last one's first
    // half-edge, and for each its higher end and the one before it.
    let mut last = vec![NONE; vertices];
    let mut listed = vec![(NONE, NONE); halves.len()];
    for (triangle, &[a, b, c]) in (0u32..).zip(triangles) {
        for (half, [from, to]) in halves_of(triangle).zip([[a, b], [b, c], [c, a]]) {
            let high = from.max(to);
            if high as usize >= vertices {
                return None;
            }
            let last = &mut last[from.min(to) as usize];
            let mut other = *last;
            while other != NONE && listed[other as usize].0 != high {
                other = listed[other as usize].1;
            }
            if other == NONE {
                listed[half as usize] = (high, std::mem::replace(last, half));
                continue;
            }
            let twin = &mut halves[other as usize];
            if twin.twin != NONE || twin.origin == from {
                return None;
            }
            twin.twin = half;
            halves[half as usize].twin = other;
        }
    }
    let is_paired = |half: &Half| half.origin == NONE || half.twin != NONE;
    halves.iter().all(is_paired).then_some(halves)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_edges_of_closed_manifolds_alone_are_paired() {
        let closed = [[0, 1, 2], [3, 1, 0], [3, 2, 1], [2, 3, 0]];
        let halves = pair_up(4, &closed).expect("closed");
        for (half, &Half { origin, twin, .. }) in (0u32..).zip(&halves) {
            if origin == NONE {
                assert_eq!((half & 3, twin), (3, NONE));
                continue;
            }
            let back = halves[twin as usize];
            assert_eq!(back.twin, half);
            assert_eq!(back.origin, halves[next(half) as usize].origin);
            assert_eq!(halves[next(twin) as usize].origin, origin);
        }
        let open = &closed[..3];
        let turned = [[0, 2, 1], [3, 1, 0], [3, 2, 1], [2, 3, 0]];
        // Another one on the same edge.
        let doubled = [[4, 1, 0], [4, 5, 1], [5, 4, 0], [0, 1, 5]];
        let doubled = [closed, doubled].concat();
        let flat = [[0, 0, 1], [1, 0, 0]];
        for wrong in [open, &turned, &doubled, &flat] {
            assert!(pair_up(6, wrong).is_none(), "{wrong:?}");
        }
        assert!(pair_up(3, &closed).is_none(), "no such vertex");
    }
}
