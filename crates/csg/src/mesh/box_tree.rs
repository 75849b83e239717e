//! A bounding volume hierarchy of axis-aligned boxes, to find the pairs that
//! overlap.

use glam::DVec3;
use rayon::prelude::*;

/// An axis-aligned box by its least and greatest corner.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
}

impl Bounds {
    /// Overlaps nothing.
    const EMPTY: Self = Self {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
    };

    /// The smallest box around some points.
    pub(super) fn around(points: &[DVec3]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, &p| Self {
            low: bounds.low.min(p),
            high: bounds.high.max(p),
        })
    }

    fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// Whether the closed boxes have a point in common.
    fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// Boxes in a leaf.
const LEAF: usize = 4;
/// Subtrees of fewer leaves are searched by one task.
const SERIAL_LEAVES: usize = 64;

/// A complete binary tree over the boxes, sorted along a Morton curve.
pub(super) struct BoxTree {
    /// Node `k` has the children `2k` and `2k + 1`, the root is 1, and the
    /// leaves are the last half.
    nodes: Vec<Bounds>,
    /// Leaf `i` holds the entries `LEAF * i ..`; each is a box and its index.
    entries: Vec<(Bounds, u32)>,
}

impl BoxTree {
    /// Sorts the boxes and their indices into a tree: n log n.
    pub(super) fn new(boxes: &[(Bounds, u32)]) -> Self {
        let whole = boxes
            .iter()
            .fold(Bounds::EMPTY, |whole, entry| whole.union(entry.0));
        // (By place in the input too, so that the order is the same every time.)
        let mut order: Vec<(u64, u32)> = boxes
            .par_iter()
            .zip(0..boxes.len() as u32)
            .map(|((bounds, _), place)| (morton(bounds, &whole), place))
            .collect();
        order.par_sort_unstable();
        let entries: Vec<(Bounds, u32)> = order
            .par_iter()
            .map(|&(_, place)| boxes[place as usize])
            .collect();
        let leaves = entries.len().div_ceil(LEAF).next_power_of_two();
        let mut nodes = vec![Bounds::EMPTY; 2 * leaves];
        for (leaf, boxes) in entries.chunks(LEAF).enumerate() {
            nodes[leaves + leaf] = boxes
                .iter()
                .fold(Bounds::EMPTY, |all, entry| all.union(entry.0));
        }
        for node in (1..leaves).rev() {
            nodes[node] = nodes[2 * node].union(nodes[2 * node + 1]);
        }
        Self { nodes, entries }
    }

    /// All pairs of overlapping boxes that pass the test, as their indices,
    /// the lower first; in ascending order.
    pub(super) fn pairs(&self, test: &(impl Fn(u32, u32) -> bool + Sync)) -> Vec<[u32; 2]> {
        let mut pairs = self.within(1, test);
        pairs.par_sort_unstable();
        pairs
    }

    /// The pairs of boxes below one node.
    fn within(&self, node: usize, test: &(impl Fn(u32, u32) -> bool + Sync)) -> Vec<[u32; 2]> {
        let mut pairs = Vec::new();
        if self.is_leaf(node) {
            let entries = self.entries_of(node);
            for (number, first) in entries.iter().enumerate() {
                for second in &entries[number + 1..] {
                    try_pair(first, second, test, &mut pairs);
                }
            }
            return pairs;
        }
        let (left, right) = (2 * node, 2 * node + 1);
        let search = |part: usize| match part {
            0 => self.within(left, test),
            1 => self.within(right, test),
            _ => {
                let mut pairs = Vec::new();
                self.between(left, right, test, &mut pairs);
                pairs
            }
        };
        if self.leaves_below(node) < SERIAL_LEAVES {
            (0..3).for_each(|part| pairs.append(&mut search(part)));
        } else {
            let (mut a, (mut b, mut c)) =
                rayon::join(|| search(0), || rayon::join(|| search(1), || search(2)));
            for part in [&mut a, &mut b, &mut c] {
                pairs.append(part);
            }
        }
        pairs
    }

    /// The pairs with one box below each of two nodes of the same level.
    fn between(
        &self,
        first: usize,
        second: usize,
        test: &(impl Fn(u32, u32) -> bool + Sync),
        pairs: &mut Vec<[u32; 2]>,
    ) {
        if !self.nodes[first].overlaps(&self.nodes[second]) {
            return;
        }
        if self.is_leaf(first) {
            for one in self.entries_of(first) {
                for other in self.entries_of(second) {
                    try_pair(one, other, test, pairs);
                }
            }
            return;
        }
        for a in [2 * first, 2 * first + 1] {
            for b in [2 * second, 2 * second + 1] {
                self.between(a, b, test, pairs);
            }
        }
    }

    fn is_leaf(&self, node: usize) -> bool {
        node >= self.nodes.len() / 2
    }

    fn leaves_below(&self, node: usize) -> usize {
        (self.nodes.len() / 2) >> node.ilog2()
    }

    fn entries_of(&self, leaf: usize) -> &[(Bounds, u32)] {
        let start = (leaf - self.nodes.len() / 2) * LEAF;
        let end = (start + LEAF).min(self.entries.len());
        self.entries.get(start..end).unwrap_or_default()
    }
}

fn try_pair(
    (bounds, index): &(Bounds, u32),
    (other_bounds, other): &(Bounds, u32),
    test: &impl Fn(u32, u32) -> bool,
    pairs: &mut Vec<[u32; 2]>,
) {
    let pair = [*index.min(other), *index.max(other)];
    if bounds.overlaps(other_bounds) && test(pair[0], pair[1]) {
        pairs.push(pair);
    }
}

/// The place of a box's centre along a Morton curve: the bits of its three
/// coordinates, 21 each, interleaved.
fn morton(bounds: &Bounds, whole: &Bounds) -> u64 {
    let size = whole.high - whole.low;
    let place = (bounds.low.midpoint(bounds.high) - whole.low) / size;
    place.to_array().into_iter().fold(0, |code, coordinate| {
        // (A flat direction is NaN, which becomes 0.)
        let cell = (coordinate * f64::from(1 << 21)) as u64;
        code << 1 | spread(cell.min((1 << 21) - 1))
    })
}

/// Puts two zeros after each of the low 21 bits.
fn spread(bits: u64) -> u64 {
    let mut x = bits;
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}
