//! The topology of one cell: its crossing edges joined into loops.
//!
//! Corners are numbered by the bits x + 2y + 4z. Edge `4a + b + 2c` runs along
//! axis a, at the given bits of the next two axes in cyclic order; face
//! `2a + s` is normal to axis a on side s. Across every face with two
//! crossings runs one arc of the surface, across one with four (an ambiguous
//! face, its corners alternating) two. The arcs close into loops; every loop
//! is one vertex of the mesh.

/// The axes after `axis` in cyclic order.
pub(super) const fn next_axes(axis: usize) -> (usize, usize) {
    ((axis + 1) % 3, (axis + 2) % 3)
}

/// The edge along `axis` at the given bits of the next two axes.
const fn edge(axis: usize, bit_b: usize, bit_c: usize) -> usize {
    4 * axis + bit_b + 2 * bit_c
}

/// The corner at which an edge starts (its end is at bit 1 of its axis).
pub(super) const fn edge_start(edge: usize) -> usize {
    let axis = edge / 4;
    let (b, c) = next_axes(axis);
    (edge & 1) << b | (edge >> 1 & 1) << c
}

/// The four edges of a face in cyclic order, starting with the one between
/// the corners (0,0) and (1,0) of the next two axes.
pub(super) const fn face_edges(face: usize) -> [usize; 4] {
    let (axis, side) = (face / 2, face & 1);
    let (b, c) = next_axes(axis);
    // An edge along b is placed by the bits of c and `axis`, in that order;
    // one along c by those of `axis` and b.
    [
        edge(b, 0, side),
        edge(c, side, 1),
        edge(b, 1, side),
        edge(c, side, 0),
    ]
}

/// The corners of a face in the same order: (0,0), (1,0), (1,1), (0,1).
pub(super) const fn face_corners(face: usize) -> [usize; 4] {
    let (axis, side) = (face / 2, face & 1);
    let (b, c) = next_axes(axis);
    let base = side << axis;
    [base, base | 1 << b, base | 1 << b | 1 << c, base | 1 << c]
}

/// Whether the corners of a face alternate.
pub(super) const fn is_ambiguous(mask: u8, face: usize) -> bool {
    let corners = face_corners(face);
    let a = mask >> corners[0] & 1;
    let b = mask >> corners[1] & 1;
    let c = mask >> corners[2] & 1;
    let d = mask >> corners[3] & 1;
    a == c && b == d && a != b
}

/// The loops of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Loops {
    /// How many there are; at most 4.
    pub count: u8,
    /// The crossing edges, a bit each.
    pub edges: u16,
    /// The loop of each crossing edge, two bits each.
    of_edge: u32,
}

impl Loops {
    /// Which loop a crossing edge belongs to.
    pub const fn of(&self, edge: usize) -> usize {
        (self.of_edge >> (2 * edge) & 3) as usize
    }

    /// The edges of one loop, a bit each.
    pub fn edges_of(&self, index: usize) -> u16 {
        (0..12)
            .filter(|&edge| self.edges >> edge & 1 == 1 && self.of(edge) == index)
            .fold(0, |bits, edge| bits | 1 << edge)
    }
}

/// On a face with four crossings, the edges that each edge of the cyclic
/// order is joined to: by arcs that cut off the inside corners (`joined`
/// false) or the outside ones (`joined` true: the inside corners connect).
pub(super) const fn ambiguous_partner(first_corner_inside: bool, joined: bool, i: usize) -> usize {
    // Corner k lies between edges k - 1 and k. Cutting off the even corners
    // pairs edges (3,0) and (1,2), cutting off the odd ones (0,1) and (2,3).
    let cut_even = first_corner_inside != joined;
    if cut_even {
        [3, 2, 1, 0][i]
    } else {
        [1, 0, 3, 2][i]
    }
}

/// Traces the loops of a cell with the given inside corners; bit f of
/// `joined` tells how the ambiguous face f is decided.
pub(super) const fn trace(mask: u8, joined: u8) -> Loops {
    const NONE: u8 = 255;
    // For each edge the partner on each of its two faces, in face order.
    let mut partners = [[NONE; 2]; 12];
    let mut edges = 0u16;
    let mut face = 0;
    while face < 6 {
        let face_edges = face_edges(face);
        let corners = face_corners(face);
        let mut crossing = [false; 4];
        let mut count = 0;
        let mut i = 0;
        while i < 4 {
            crossing[i] = (mask >> corners[i] ^ mask >> corners[(i + 1) % 4]) & 1 == 1;
            count += crossing[i] as usize;
            i += 1;
        }
        i = 0;
        while i < 4 {
            if crossing[i] {
                let partner = if count == 4 {
                    let first_inside = mask >> corners[0] & 1 == 1;
                    ambiguous_partner(first_inside, joined >> face & 1 == 1, i)
                } else {
                    let mut j = (i + 1) % 4;
                    while !crossing[j] {
                        j = (j + 1) % 4;
                    }
                    j
                };
                let e = face_edges[i];
                let slot = (partners[e][0] != NONE) as usize;
                partners[e][slot] = face_edges[partner] as u8;
                edges |= 1 << e;
            }
            i += 1;
        }
        face += 1;
    }
    let mut of_edge = 0u32;
    let mut seen = 0u16;
    let mut count = 0u8;
    let mut start = 0;
    while start < 12 {
        if edges >> start & 1 == 1 && seen >> start & 1 == 0 {
            // Two edges of a cell share at most one face, so the next edge is
            // whichever partner we did not come from.
            let mut previous = partners[start][0] as usize;
            let mut current = start;
            loop {
                seen |= 1 << current;
                of_edge |= (count as u32) << (2 * current);
                let [p, q] = partners[current];
                let next = if p as usize == previous { q } else { p } as usize;
                previous = current;
                current = next;
                if current == start {
                    break;
                }
            }
            count += 1;
        }
        start += 1;
    }
    Loops {
        count,
        edges,
        of_edge,
    }
}

/// What a cell without ambiguous faces looks like, by its inside corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pattern {
    pub loops: Loops,
    /// The ambiguous faces, a bit each.
    pub ambiguous: u8,
    /// Whether the one loop and no ambiguous face make it a simple cell.
    pub simple: bool,
    /// The mean of the crossed edges' middles, in cells from the lowest corner.
    pub middle: [f64; 3],
}

/// All 256 patterns.
pub(super) static PATTERNS: [Pattern; 256] = {
    let empty = Pattern {
        loops: trace(0, 0),
        ambiguous: 0,
        simple: false,
        middle: [0.0; 3],
    };
    let mut patterns = [empty; 256];
    let mut mask = 0;
    while mask < 256 {
        let loops = trace(mask as u8, 0);
        let mut ambiguous = 0;
        let mut face = 0;
        while face < 6 {
            ambiguous |= (is_ambiguous(mask as u8, face) as u8) << face;
            face += 1;
        }
        let mut sum = [0.0; 3];
        let mut e = 0;
        while e < 12 {
            if loops.edges >> e & 1 == 1 {
                let mut axis = 0;
                while axis < 3 {
                    let along = axis == e / 4;
                    let start = (edge_start(e) >> axis & 1) as f64;
                    sum[axis] += if along { 0.5 } else { start };
                    axis += 1;
                }
            }
            e += 1;
        }
        let count = loops.edges.count_ones() as f64;
        patterns[mask] = Pattern {
            loops,
            ambiguous,
            simple: ambiguous == 0 && loops.count == 1,
            middle: [sum[0] / count, sum[1] / count, sum[2] / count],
        };
        mask += 1;
    }
    patterns
};

#[cfg(test)]
mod tests {
    use super::*;

    /// All decisions of the ambiguous faces of a mask.
    fn decisions(mask: u8) -> impl Iterator<Item = u8> {
        let faces = PATTERNS[mask as usize].ambiguous;
        (0..64u8).filter(move |joined| joined & !faces == 0)
    }

    #[test]
    fn edges_faces_and_corners_fit_together() {
        for face in 0..6 {
            let corners = face_corners(face);
            for (i, &e) in face_edges(face).iter().enumerate() {
                let start = edge_start(e);
                let end = start | 1 << (e / 4);
                let mut expected = [corners[i], corners[(i + 1) % 4]];
                expected.sort_unstable();
                assert_eq!([start, end], expected, "face {face} edge {e}");
            }
        }
    }

    #[test]
    fn every_crossing_is_in_one_loop_of_at_least_three() {
        for mask in 0..=255u8 {
            for joined in decisions(mask) {
                let loops = trace(mask, joined);
                let mut all = 0;
                for index in 0..loops.count as usize {
                    let edges = loops.edges_of(index);
                    assert!(edges.count_ones() >= 3, "{mask:08b} {joined:06b}");
                    assert_eq!(all & edges, 0);
                    all |= edges;
                }
                assert_eq!(all, loops.edges);
                for e in 0..12 {
                    let start = edge_start(e);
                    let end = start | 1 << (e / 4);
                    let crosses = (mask >> start ^ mask >> end) & 1 == 1;
                    assert_eq!(crosses, loops.edges >> e & 1 == 1);
                }
            }
        }
    }

    #[test]
    fn loop_counts_of_known_cases() {
        assert_eq!(trace(0b0000_0001, 0).count, 1);
        assert_eq!(trace(0b0000_1111, 0).count, 1);
        // Opposite corners of the cube.
        assert_eq!(trace(0b1000_0001, 0).count, 2);
        // Opposite corners of the bottom face, apart or joined.
        assert_eq!(trace(0b0000_1001, 0).count, 2);
        assert_eq!(trace(0b0000_1001, 0b01_0000).count, 1);
        // The checkerboard, everything apart or everything joined.
        assert_eq!(trace(0b0110_1001, 0).count, 4);
        assert_eq!(trace(0b0110_1001, 0b11_1111).count, 4);
    }
}
