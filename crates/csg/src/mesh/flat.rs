//! Flat triangles of a triangulation, whose third corner is on their longest side but for
//! rounding: edges are flipped until there are none.

use glam::DVec2;
use rustc_hash::{FxHashMap, FxHashSet};

use super::predicates::orient;

/// A triangle whose longest side comes first, and how high it is above that.
struct Flat {
    corners: [u32; 3],
    height: f64,
}

/// Flips the longest edges of triangles that are lower than a tolerance, but those of the contours
/// around all. Points are told by the names of corners, some of them more than once.
pub(super) fn flip_flat<'a>(
    triangles: &mut [[u32; 3]],
    points: impl Iterator<Item = (u32, DVec2)>,
    contours: impl Iterator<Item = &'a [(DVec2, u32)]>,
    tolerance: f64,
) {
    let points: FxHashMap<u32, DVec2> = points.collect();
    let flat = |corners: [u32; 3]| {
        let turned = [0, 1, 2].map(|k| [0, 1, 2].map(|i| corners[(k + i) % 3]));
        let length = |[a, b, _]: &[u32; 3]| points[a].distance(points[b]);
        let longer = |a: &[u32; 3], b: &[u32; 3]| length(a).total_cmp(&length(b));
        let corners = turned.into_iter().max_by(longer).unwrap_or(corners);
        let [a, b, c] = corners.map(|name| points[&name]);
        Flat {
            corners,
            height: orient(a, b, c) / a.distance(b),
        }
    };
    let mut left_of: FxHashMap<[u32; 2], usize> = FxHashMap::default();
    for (k, &corners) in triangles.iter().enumerate() {
        left_of.extend(sides(corners).map(|side| (side, k)));
    }
    let around = contours.flat_map(|contour| {
        let next = contour.iter().cycle().skip(1);
        contour.iter().zip(next).map(|(a, b)| [a.1, b.1])
    });
    let around: FxHashSet<[u32; 2]> = around.collect();
    // What cannot be flipped may be, once its neighbour was. The heights of all, in ascending
    // order, only grow, so that this ends.
    let mut has_flipped = true;
    while has_flipped {
        has_flipped = false;
        for one in 0..triangles.len() {
            let Flat { corners, height } = flat(triangles[one]);
            let [a, b, c] = corners;
            if height > tolerance || around.contains(&[a, b]) {
                continue;
            }
            let Some(&other) = left_of.get(&[b, a]) else {
                continue;
            };
            let opposite = triangles[other].into_iter().find(|&k| k != a && k != b);
            let Some(d) = opposite.filter(|&d| !left_of.contains_key(&[c, d])) else {
                continue;
            };
            let flipped = [[a, d, c], [d, b, c]];
            let [first, second] = flipped.map(|corners| flat(corners).height);
            let before = height.min(flat(triangles[other]).height);
            if first.min(second) <= before || left_of.contains_key(&[d, c]) {
                continue;
            }
            has_flipped = true;
            for side in [[a, b], [b, a]] {
                left_of.remove(&side);
            }
            for (k, corners) in [one, other].into_iter().zip(flipped) {
                triangles[k] = corners;
                left_of.extend(sides(corners).map(|side| (side, k)));
            }
        }
    }
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}
