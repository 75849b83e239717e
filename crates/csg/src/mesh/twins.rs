//! Which triangles lie side by side.

use rustc_hash::FxHashMap;

/// No half-edge.
pub(super) const NONE: u32 = u32::MAX;

/// For each half-edge `3 * triangle + side`, from a triangle's corner `side` to its next
/// one, another one that runs the other way along the same edge, each of one other;
/// [`NONE`] if there is none.
///
/// Linear. Only of the triangles that are used: those have three different vertices.
pub(super) fn twins(triangles: &[[u32; 3]], is_used: impl Fn(usize) -> bool) -> Vec<u32> {
    /// Half-edges at a vertex that are looked at one by one: of more, as at the middle of a fan, the
    /// rest is looked up. Tunes speed only.
    const MOST: usize = 32;
    /// Vertices for each triangle.
    const WIDEST: usize = 16;
    let origins = triangles.as_flattened();
    let targets: Vec<u32> = triangles.iter().flat_map(|&[a, b, c]| [b, c, a]).collect();
    let halves = origins.len();
    let (mut lowest, mut highest) = (usize::MAX, 0);
    for (_, triangle) in triangles.iter().enumerate().filter(|&(t, _)| is_used(t)) {
        for &vertex in triangle {
            lowest = lowest.min(vertex as usize);
            highest = highest.max(vertex as usize);
        }
    }
    if lowest > highest || highest - lowest >= WIDEST * triangles.len() {
        // (Few of the triangles are neighbours.)
        return vec![NONE; halves];
    }
    // Half-edges without a twin so far are in lists at the lower of their vertices: the next
    // one stands in the place of the twin.
    let mut first = vec![NONE; highest - lowest + 1];
    let mut twins = vec![NONE; halves];
    let used = (0..triangles.len()).filter(|&triangle| is_used(triangle));
    for half in used.flat_map(|triangle| 3 * triangle..3 * triangle + 3) {
        let [from, to] = [origins[half], targets[half]];
        let list = &mut first[from.min(to) as usize - lowest];
        let (mut before, mut other) = (NONE, *list);
        let mut left = MOST;
        while other != NONE && left > 0 {
            if targets[other as usize] == from && origins[other as usize] == to {
                break;
            }
            (before, other) = (other, twins[other as usize]);
            left -= 1;
        }
        if other == NONE || left == 0 {
            twins[half] = std::mem::replace(list, half as u32);
            continue;
        }
        let after = std::mem::replace(&mut twins[other as usize], half as u32);
        twins[half] = other;
        if before == NONE {
            *list = after;
        } else {
            twins[before as usize] = after;
        }
    }
    let mut left: Vec<u32> = Vec::new();
    let mut waiting: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for mut half in first {
        left.clear();
        while half != NONE {
            left.push(half);
            half = std::mem::replace(&mut twins[half as usize], NONE);
        }
        if left.len() <= MOST {
            continue;
        }
        waiting.clear();
        for &half in &left {
            let [from, to] = [origins[half as usize], targets[half as usize]];
            if let Some(other) = waiting.remove(&[to, from]) {
                (twins[half as usize], twins[other as usize]) = (other, half);
            } else {
                waiting.entry([from, to]).or_insert(half);
            }
        }
    }
    twins
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every half-edge as its ends.
    fn ends(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
        let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
        triangles.iter().flat_map(sides).collect()
    }

    #[test]
    fn half_edges_that_run_against_each_other_are_paired() {
        // A grid, open at its rim; a book of five pages; two triangles that agree; a wide fan.
        let mut triangles = Vec::new();
        for (x, y) in (0..36).map(|k| (k % 6, k / 6)) {
            let corner = 100 + 7 * y + x;
            triangles.push([corner, corner + 1, corner + 8]);
            triangles.push([corner, corner + 8, corner + 7]);
        }
        triangles.extend([[0, 1, 2], [1, 0, 3], [0, 1, 4], [1, 0, 5], [0, 1, 6]]);
        triangles.extend([[7, 8, 9], [7, 8, 10]]);
        triangles.extend((0..600).map(|k| [20, 200 + k, 201 + k]));
        for step in [1, 31, 47] {
            let count = triangles.len();
            let shuffled: Vec<_> = (0..count).map(|k| triangles[k * step % count]).collect();
            let (ends, twins) = (ends(&shuffled), twins(&shuffled, |_| true));
            for (half, &twin) in twins.iter().enumerate() {
                let [from, to] = ends[half];
                let count = |way: [u32; 2]| ends.iter().filter(|&&e| e == way).count();
                if twin == NONE {
                    assert!(count([to, from]) < count([from, to]), "{from} to {to}");
                } else {
                    assert_eq!(ends[twin as usize], [to, from]);
                    assert_eq!(twins[twin as usize] as usize, half);
                }
            }
            let paired = twins.iter().filter(|&&twin| twin != NONE).count();
            assert_eq!(paired, 2 * (3 * 36 - 12) + 4 + 2 * 599);
        }
    }

    #[test]
    fn triangles_of_far_vertices_are_alone() {
        assert_eq!(twins(&[], |_| true), []);
        assert_eq!(twins(&[[0, 1, 9], [1, 0, 2]], |_| false), [NONE; 6]);
        assert_eq!(twins(&[[0, 1, 1000], [1, 0, 2]], |_| true), [NONE; 6]);
    }
}
