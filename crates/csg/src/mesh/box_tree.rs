//! A bounding volume hierarchy of axis-aligned boxes, to find the pairs that
//! overlap.

use glam::DVec3;
use rayon::prelude::*;

/// An axis-aligned box by its least and greatest corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
}

impl Bounds {
    /// Overlaps nothing.
    pub(crate) const EMPTY: Self = Self {
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

    pub(super) fn around_all(boxes: impl Iterator<Item = Self>) -> Self {
        boxes.fold(Self::EMPTY, Self::union)
    }

    pub(super) fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// The square of the distance to a point, 0 inside.
    fn distance_squared(&self, point: DVec3) -> f64 {
        let beyond = (self.low - point).max(point - self.high).max(DVec3::ZERO);
        beyond.length_squared()
    }

    /// Whether the closed boxes have a point in common.
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        // (In one go: which of them decides is hard to foresee.)
        (self.low.x <= other.high.x)
            & (self.low.y <= other.high.y)
            & (self.low.z <= other.high.z)
            & (other.low.x <= self.high.x)
            & (other.low.y <= self.high.y)
            & (other.low.z <= self.high.z)
    }
}

/// The box of something in a sheet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boxed {
    pub bounds: Bounds,
    /// What is in the box.
    pub index: u32,
    pub sheet: u32,
    /// Across which axes it stands on planes, a bit each: what lies in such a plane, and has it on
    /// one side, makes no pair with it.
    pub stands: u8,
}

/// Whether boxes are told apart although they overlap: all of the one is in a plane across an axis, on
/// which all of the other one stands.
fn is_stood_on(plane: &Bounds, other: &Bounds, stands: u8) -> bool {
    let stood_on = |axis: usize| {
        let at = plane.low[axis];
        at == plane.high[axis] && (other.low[axis] >= at || other.high[axis] <= at)
    };
    (0..3).any(|axis| stands >> axis & 1 == 1 && stood_on(axis))
}

/// Boxes in a leaf. Tunes speed only.
const LEAF: usize = 4;
/// Subtrees of fewer leaves are searched by one task.
const SERIAL_LEAVES: usize = 64;

/// So many subtrees, a power of two, are told of when they are searched.
pub(super) const TOLD: usize = 64;

/// Of a node with boxes of several sheets.
const SEVERAL: u32 = u32::MAX;

/// A complete binary tree over boxes in a row.
#[derive(Debug)]
pub(crate) struct BoxTree {
    /// Node `k` has the children `2k` and `2k + 1`, the root is 1, and the
    /// leaves are the last half.
    nodes: Vec<Node>,
    /// Leaf `i` holds the entries `LEAF * i ..`.
    entries: Vec<Boxed>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// The only one below, or [`SEVERAL`].
    sheet: u32,
    /// Across which axes all below stands.
    stands: u8,
}

impl Node {
    fn join(nodes: impl Iterator<Item = Self>) -> Self {
        nodes
            .reduce(|one, other| Self {
                bounds: one.bounds.union(other.bounds),
                sheet: if one.sheet == other.sheet {
                    one.sheet
                } else {
                    SEVERAL
                },
                stands: one.stands & other.stands,
            })
            .unwrap_or(Self {
                bounds: Bounds::EMPTY,
                sheet: SEVERAL,
                stands: 0,
            })
    }
}

impl BoxTree {
    /// Of boxes in an order in which those that follow each other are near each other and
    /// those of a sheet together.
    pub(crate) fn new(entries: Vec<Boxed>) -> Self {
        let leaves = entries.len().div_ceil(LEAF).next_power_of_two();
        let mut nodes = vec![Node::join([].into_iter()); 2 * leaves];
        for (leaf, boxes) in entries.chunks(LEAF).enumerate() {
            nodes[leaves + leaf] = Node::join(boxes.iter().map(|entry| Node {
                bounds: entry.bounds,
                sheet: entry.sheet,
                stands: entry.stands,
            }));
        }
        for node in (1..leaves).rev() {
            nodes[node] = Node::join([nodes[2 * node], nodes[2 * node + 1]].into_iter());
        }
        Self { nodes, entries }
    }

    /// Of boxes in any order, by their numbers: of one sheet, and standing on nothing.
    pub(crate) fn numbered(boxes: &[Bounds]) -> Self {
        let order = along_curve(boxes.iter().copied()).into_iter();
        let entries = order.map(|index| Boxed {
            bounds: boxes[index as usize],
            index,
            sheet: 0,
            stands: 0,
        });
        Self::new(entries.collect())
    }

    /// All pairs of overlapping boxes of different sheets that pass the test, as their indices,
    /// the lower first; in ascending order; but for those of which one stands on a plane
    /// that the other one is in.
    ///
    /// Tells of each of at most [`TOLD`] parts that it is done, on whatever thread did it.
    pub(super) fn pairs(
        &self,
        test: &(impl Fn(u32, u32) -> bool + Sync),
        tell: &(impl Fn() + Sync),
    ) -> Vec<[u32; 2]> {
        let mut pairs = self.within(1, test, tell);
        pairs.par_sort_unstable();
        pairs
    }

    /// Lets no box stand on planes.
    pub(super) fn stand_on_nothing(&mut self) {
        self.entries.iter_mut().for_each(|entry| entry.stands = 0);
        self.nodes.iter_mut().for_each(|node| node.stands = 0);
    }

    /// Tells of all entries whose boxes overlap another one.
    pub(crate) fn overlapping(&self, bounds: &Bounds, tell: &mut impl FnMut(u32)) {
        let mut waiting = vec![1];
        while let Some(node) = waiting.pop() {
            if !self.nodes[node].bounds.overlaps(bounds) {
                continue;
            }
            if self.is_leaf(node) {
                let entries = self.entries_of(node).iter();
                let entries = entries.filter(|entry| entry.bounds.overlaps(bounds));
                entries.for_each(|entry| tell(entry.index));
            } else {
                waiting.extend([2 * node, 2 * node + 1]);
            }
        }
    }

    /// Whether an entry passes a test, of those whose boxes overlap another one, but for those
    /// of one sheet.
    pub(crate) fn any_overlapping(
        &self,
        but: Option<u32>,
        bounds: &Bounds,
        test: &mut impl FnMut(u32) -> bool,
    ) -> bool {
        let mut waiting = vec![1];
        while let Some(node) = waiting.pop() {
            let is_excepted = but == Some(self.nodes[node].sheet);
            if is_excepted || !self.nodes[node].bounds.overlaps(bounds) {
                continue;
            }
            if !self.is_leaf(node) {
                waiting.extend([2 * node, 2 * node + 1]);
                continue;
            }
            let mut entries = self.entries_of(node).iter();
            let is_met = |entry: &Boxed| but != Some(entry.sheet) && entry.bounds.overlaps(bounds);
            if entries.any(|entry| is_met(entry) && test(entry.index)) {
                return true;
            }
        }
        false
    }

    /// The pairs of boxes below one node.
    fn within(
        &self,
        node: usize,
        test: &(impl Fn(u32, u32) -> bool + Sync),
        tell: &(impl Fn() + Sync),
    ) -> Vec<[u32; 2]> {
        let pairs = self.pairs_within(node, test, tell);
        if (TOLD..2 * TOLD).contains(&node) {
            tell();
        }
        pairs
    }

    fn pairs_within(
        &self,
        node: usize,
        test: &(impl Fn(u32, u32) -> bool + Sync),
        tell: &(impl Fn() + Sync),
    ) -> Vec<[u32; 2]> {
        let mut pairs = Vec::new();
        if self.nodes[node].sheet != SEVERAL {
            return pairs;
        }
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
            0 => self.within(left, test, tell),
            1 => self.within(right, test, tell),
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
        let (one, other) = (&self.nodes[first], &self.nodes[second]);
        let is_one_sheet = one.sheet == other.sheet && one.sheet != SEVERAL;
        if is_one_sheet
            || !one.bounds.overlaps(&other.bounds)
            || is_stood_on(&one.bounds, &other.bounds, other.stands)
            || is_stood_on(&other.bounds, &one.bounds, one.stands)
        {
            return;
        }
        if self.is_leaf(first) {
            let others = self.entries_of(second);
            for entry in self.entries_of(first) {
                if entry.bounds.overlaps(&other.bounds) {
                    for other in others {
                        try_pair(entry, other, test, pairs);
                    }
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

    /// The entry nearest to a point by a measure that is no less than the distance from its
    /// box, and that measure, beginning with one that is known. None of an empty tree.
    pub(super) fn nearest(
        &self,
        point: DVec3,
        known: Option<u32>,
        measure: impl Fn(u32) -> f64,
    ) -> Option<(u32, f64)> {
        let far = |node: usize| self.nodes[node].bounds.distance_squared(point);
        let mut best = known.map(|index| (index, measure(index)));
        let mut waiting = vec![1];
        while let Some(node) = waiting.pop() {
            if best.is_some_and(|(_, least)| far(node) >= least * least) {
                continue;
            }
            if self.is_leaf(node) {
                for entry in self.entries_of(node) {
                    let off = entry.bounds.distance_squared(point);
                    if best.is_some_and(|(_, least)| off >= least * least) {
                        continue;
                    }
                    let distance = measure(entry.index);
                    if best.is_none_or(|(_, least)| distance < least) {
                        best = Some((entry.index, distance));
                    }
                }
                continue;
            }
            // The nearer one first.
            let mut children = [2 * node, 2 * node + 1];
            if far(children[0]) < far(children[1]) {
                children.reverse();
            }
            waiting.extend(children);
        }
        best
    }

    fn is_leaf(&self, node: usize) -> bool {
        node >= self.nodes.len() / 2
    }

    fn leaves_below(&self, node: usize) -> usize {
        (self.nodes.len() / 2) >> node.ilog2()
    }

    fn entries_of(&self, leaf: usize) -> &[Boxed] {
        let start = (leaf - self.nodes.len() / 2) * LEAF;
        let end = (start + LEAF).min(self.entries.len());
        self.entries.get(start..end).unwrap_or_default()
    }
}

#[inline(always)]
fn try_pair(
    one: &Boxed,
    other: &Boxed,
    test: &impl Fn(u32, u32) -> bool,
    pairs: &mut Vec<[u32; 2]>,
) {
    if one.sheet != other.sheet
        && one.bounds.overlaps(&other.bounds)
        && !is_stood_on(&one.bounds, &other.bounds, other.stands)
        && !is_stood_on(&other.bounds, &one.bounds, one.stands)
    {
        let pair = [one.index.min(other.index), one.index.max(other.index)];
        if test(pair[0], pair[1]) {
            pairs.push(pair);
        }
    }
}

/// The order of boxes along a Morton curve through their centres: n log n.
pub(crate) fn along_curve(boxes: impl ExactSizeIterator<Item = Bounds> + Clone) -> Vec<u32> {
    let whole = Bounds::around_all(boxes.clone());
    // The same along all axes: cells of a long row would be as long as it is.
    let scale = CELLS / (whole.high - whole.low).max_element();
    let place = |bounds: Bounds| (bounds.low.midpoint(bounds.high) - whole.low) * scale;
    // The first bits of the code and the number: the order is the same every time.
    let numbers = (boxes.len() as u64).next_power_of_two() - 1;
    let codes = boxes.map(|bounds| morton(place(bounds)) << 1 & !numbers);
    let mut codes: Vec<u64> = (0..)
        .zip(codes)
        .map(|(number, code): (u64, u64)| code | number)
        .collect();
    codes.par_sort_unstable();
    codes
        .into_iter()
        .map(|code| (code & numbers) as u32)
        .collect()
}

/// Cells of a Morton curve along each axis.
const CELLS: f64 = (1 << 21) as f64;

/// The place along a Morton curve: the bits of the three cells, 21 each, interleaved.
fn morton(place: DVec3) -> u64 {
    place.to_array().into_iter().fold(0, |code, cell| {
        // (Of a single point it is NaN, which becomes 0.)
        code << 1 | spread((cell as u64).min((1 << 21) - 1))
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
