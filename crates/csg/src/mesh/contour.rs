//! Whether a closed polygon in the plane is simple, decided exactly.

use std::ops::Range;

use glam::DVec2;

use super::predicates::turn;

/// 1 for a polygon that runs counter-clockwise, -1 for one that runs clockwise, none if it
/// is not simple: if sides meet that are not neighbours. (If neighbours overlap, one of
/// them meets the other's next one.)
///
/// n log n for ordinary ones of n corners. The nodes are a buffer.
pub(super) fn orientation(corners: &[DVec2], nodes: &mut Vec<Side>) -> Option<i8> {
    let count = corners.len();
    if count < 3 {
        return None;
    }
    let lowest = (0..count).reduce(|low, k| {
        if is_left(corners[k], corners[low]) {
            k
        } else {
            low
        }
    })?;
    let orientation = turn([
        corners[(lowest + count - 1) % count],
        corners[lowest],
        corners[(lowest + 1) % count],
    ]);
    let chain = Chain::new(corners, nodes);
    (orientation != 0 && !chain.meets_itself(1)).then_some(orientation)
}

/// Or below if it is neither left nor right.
fn is_left(a: DVec2, b: DVec2) -> bool {
    (a.x, a.y) < (b.x, b.y)
}

/// Sides in a leaf. Tunes speed only.
const LEAF: usize = 4;

/// Successive sides of the polygon in a box.
#[derive(Clone, Copy)]
pub(super) struct Side {
    low: DVec2,
    high: DVec2,
    /// The ways in which all of them run: bits for right, left, up and down.
    ways: u8,
}

impl Side {
    const NONE: Self = Self {
        low: DVec2::INFINITY,
        high: DVec2::NEG_INFINITY,
        ways: 15,
    };

    fn new(a: DVec2, b: DVec2) -> Self {
        let way = |a: f64, b: f64| u8::from(a < b) | u8::from(a > b) << 1;
        Self {
            low: a.min(b),
            high: a.max(b),
            ways: way(a.x, b.x) | way(a.y, b.y) << 2,
        }
    }

    fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            ways: self.ways & other.ways,
        }
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// The polygon with a binary tree of boxes over its sides.
struct Chain<'a> {
    corners: &'a [DVec2],
    /// Node `k` has the children `2k` and `2k + 1`, the root is 1, and the leaves are
    /// the last half: leaf `i` holds the sides `LEAF * i ..`.
    nodes: &'a [Side],
}

impl<'a> Chain<'a> {
    fn new(corners: &'a [DVec2], nodes: &'a mut Vec<Side>) -> Self {
        let count = corners.len();
        let leaves = count.div_ceil(LEAF).next_power_of_two();
        nodes.clear();
        nodes.resize(2 * leaves, Side::NONE);
        for k in 0..count {
            let node = &mut nodes[leaves + k / LEAF];
            *node = node.union(Side::new(corners[k], corners[(k + 1) % count]));
        }
        for node in (1..leaves).rev() {
            nodes[node] = nodes[2 * node].union(nodes[2 * node + 1]);
        }
        Self { corners, nodes }
    }

    /// Whether sides of a node meet that are not neighbours.
    fn meets_itself(&self, node: usize) -> bool {
        // A chain that runs all one way does not.
        if self.nodes[node].ways != 0 {
            return false;
        }
        if self.is_leaf(node) {
            let mut sides = self.sides(node);
            let end = sides.end;
            return sides.any(|a| (a + 1..end).any(|b| self.meet(a, b)));
        }
        let (left, right) = (2 * node, 2 * node + 1);
        self.meets_itself(left) || self.meets_itself(right) || self.meets(left, right)
    }

    /// Whether sides of two nodes meet that are not neighbours.
    fn meets(&self, first: usize, second: usize) -> bool {
        let (one, other) = (&self.nodes[first], &self.nodes[second]);
        let is_monotone = second == first + 1 && one.ways & other.ways != 0;
        if is_monotone || !one.overlaps(other) {
            return false;
        }
        if self.is_leaf(first) {
            let mut sides = self.sides(first);
            return sides.any(|a| self.sides(second).any(|b| self.meet(a, b)));
        }
        [2 * first, 2 * first + 1]
            .into_iter()
            .any(|a| self.meets(a, 2 * second) || self.meets(a, 2 * second + 1))
    }

    /// Whether two sides meet that are not neighbours.
    fn meet(&self, first: usize, second: usize) -> bool {
        let next = |k: usize| {
            if k + 1 == self.corners.len() {
                0
            } else {
                k + 1
            }
        };
        if next(first) == second || next(second) == first {
            return false;
        }
        let [a, b, c, d] = [first, next(first), second, next(second)].map(|k| self.corners[k]);
        Side::new(a, b).overlaps(&Side::new(c, d))
            && turn([a, b, c]) * turn([a, b, d]) <= 0
            && turn([c, d, a]) * turn([c, d, b]) <= 0
    }

    fn is_leaf(&self, node: usize) -> bool {
        node >= self.nodes.len() / 2
    }

    fn sides(&self, leaf: usize) -> Range<usize> {
        let start = (leaf - self.nodes.len() / 2) * LEAF;
        start.min(self.corners.len())..(start + LEAF).min(self.corners.len())
    }
}
