//! The walk: from the box of all bricks, halved and pruned, to those in which
//! something varies.
//!
//! All bricks of the box, walked or not, have a place in one order, in which
//! meshes have their vertices and triangles. It follows from the lattice
//! alone: whoever walks some of them knows where these stand in the whole.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::UVec3;
use rayon::iter::{self, Either};
use rayon::prelude::*;

use super::lattice::{CELLS, Lattice};
use super::part::Part;
use super::place::Placer;
use super::scene::Scene;
use crate::control::Control;
use crate::program::{Cell, Pruner};

/// Bricks from `from` to before `to`, with the program pruned to their box.
pub(super) struct Block {
    from: UVec3,
    to: UVec3,
    /// The number of its first brick.
    pub first: u64,
    cell: Cell,
}

/// About what is held at a time for each vertex and what becomes of it.
const BYTES_PER_VERTEX: usize = 150;

/// At most this many blocks along each axis are handed out to threads; a
/// constant, so that the order of the output is one, too.
const BLOCKS_ALONG: u32 = 8;

/// Which bricks to walk: ranges of their numbers, ascending and apart.
#[derive(Clone, Debug)]
pub(super) struct Wanted(Vec<Range<u64>>);

impl Wanted {
    /// Every brick.
    pub fn all() -> Self {
        Self::range(0..u64::MAX)
    }

    /// One after another.
    pub fn range(numbers: Range<u64>) -> Self {
        Self(vec![numbers])
    }

    /// These, each in ascending order.
    pub fn each(numbers: impl IntoIterator<Item = u64>) -> Self {
        Self(numbers.into_iter().map(|n| n..n + 1).collect())
    }

    pub fn is_empty(&self) -> bool {
        self.0.iter().all(Range::is_empty)
    }

    /// How many of the bricks are wanted.
    fn count_in(&self, numbers: &Range<u64>) -> u64 {
        let from = self.0.partition_point(|range| range.end <= numbers.start);
        let ranges = self.0[from..].iter();
        ranges
            .take_while(|range| range.start < numbers.end)
            .map(|range| range.end.min(numbers.end) - range.start.max(numbers.start))
            .sum()
    }
}

const CELLS_IN_BRICK: u64 = (CELLS * CELLS * CELLS) as u64;

fn bricks_in(from: UVec3, to: UVec3) -> u64 {
    let bricks = (to - from).as_u64vec3();
    bricks.x * bricks.y * bricks.z
}

/// The halves of a range of bricks along every axis longer than one.
fn children(from: UVec3, to: UVec3) -> impl DoubleEndedIterator<Item = (UVec3, UVec3)> {
    let middle = from + (to - from + 1) / 2;
    (0..8u32).filter_map(move |octant| {
        let upper = UVec3::new(octant & 1, octant >> 1 & 1, octant >> 2);
        let pick = |axis: usize| {
            if upper[axis] == 0 {
                (from[axis], middle[axis])
            } else {
                (middle[axis], to[axis])
            }
        };
        let [x, y, z] = [pick(0), pick(1), pick(2)];
        let (from, to) = (UVec3::new(x.0, y.0, z.0), UVec3::new(x.1, y.1, z.1));
        from.cmplt(to).all().then_some((from, to))
    })
}

/// Whether bricks are few enough to be one block.
fn is_block(lattice: &Lattice, from: UVec3, to: UVec3) -> bool {
    let largest = lattice.bricks.max_element().div_ceil(BLOCKS_ALONG);
    (to - from).max_element() <= largest
}

/// How many bricks there are.
pub(super) fn count(lattice: &Lattice) -> u64 {
    bricks_in(UVec3::ZERO, lattice.bricks)
}

/// The number of a brick: blocks come in the order in which boxes are halved,
/// the bricks of a block in the reverse of it.
pub(super) fn number_of(lattice: &Lattice, position: UVec3) -> u64 {
    let (mut from, mut to) = (UVec3::ZERO, lattice.bricks);
    let mut number = 0;
    while to - from != UVec3::ONE {
        let mut halves: Vec<_> = children(from, to).collect();
        if is_block(lattice, from, to) {
            halves.reverse();
        }
        for half in halves {
            (from, to) = half;
            if position.cmpge(from).all() && position.cmplt(to).all() {
                break;
            }
            number += bricks_in(from, to);
        }
    }
    number
}

/// The blocks in which something varies and some brick is wanted, in a fixed
/// order; and how many cells of wanted bricks are in none.
pub(super) fn blocks(scene: &Scene<'_>, root: &Cell, wanted: &Wanted) -> (Vec<Block>, u64) {
    let lattice = &scene.lattice;
    let is_small = |block: &Block| is_block(lattice, block.from, block.to);
    let outside = AtomicU64::new(0);
    let varying = |above: &Cell, first, (from, to), pruner: &mut Pruner| {
        let numbers = first..first + bricks_in(from, to);
        let bricks = wanted.count_in(&numbers);
        if bricks == 0 {
            return None;
        }
        let (center, half) = lattice.bricks_box(from, to);
        let mut cell = Cell::default();
        above.prune_reaching_into(scene.table(), center, half, pruner, &mut cell);
        if cell.constant().is_some() {
            outside.fetch_add(bricks * CELLS_IN_BRICK, Ordering::Relaxed);
            return None;
        }
        Some(Block {
            from,
            to,
            first,
            cell,
        })
    };
    let all = (UVec3::ZERO, lattice.bricks);
    let whole = varying(root, 0, all, &mut Pruner::default());
    let mut blocks: Vec<Block> = whole.into_iter().collect();
    while !blocks.iter().all(is_small) {
        let halves = blocks.into_par_iter().flat_map(|block| {
            if is_small(&block) {
                return Either::Left(iter::once(block));
            }
            let mut first = block.first;
            let halves = children(block.from, block.to).map(|(from, to)| {
                let start = first;
                first += bricks_in(from, to);
                (start, (from, to))
            });
            let halves: Vec<_> = halves.collect();
            let halves = halves
                .into_par_iter()
                .map_init(Pruner::default, move |pruner, (first, half)| {
                    varying(&block.cell, first, half, pruner)
                });
            Either::Right(halves.flatten_iter())
        });
        blocks = halves.collect();
    }
    (blocks, outside.into_inner())
}

/// One worker: walks the bricks of a block, its scratch memory reused.
#[derive(Default)]
pub(super) struct Walker {
    levels: Vec<Cell>,
    pruner: Pruner,
    placer: Placer,
    pending: Vec<(UVec3, UVec3, usize)>,
    /// What the block leaves behind.
    pub part: Part,
}

/// The work on one block, compiled for every SIMD level: what is inlined here
/// runs on vectors as wide as the machine's.
pub(super) struct WalkBlock<'a, 's> {
    pub walker: &'a mut Walker,
    pub scene: &'a Scene<'s>,
    pub block: &'a Block,
    pub wanted: &'a Wanted,
    pub control: &'a Control,
}

impl pulp::WithSimd for WalkBlock<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        self.walk(simd);
    }
}

impl WalkBlock<'_, '_> {
    #[inline(always)]
    fn walk<S: pulp::Simd>(self, simd: S) {
        let Self {
            walker,
            scene,
            block,
            wanted,
            control,
        } = self;
        let part = &mut walker.part;
        part.clear();
        part.first = block.first;
        walker.pending.clear();
        walker.pending.push((block.from, block.to, 0));
        let mut next = block.first;
        while let Some((from, to, level)) = walker.pending.pop() {
            if control.check().is_err() {
                return;
            }
            let numbers = next..next + bricks_in(from, to);
            let bricks = wanted.count_in(&numbers);
            if bricks == 0 {
                next = numbers.end;
                continue;
            }
            if walker.levels.len() <= level {
                walker.levels.resize_with(level + 1, Cell::default);
            }
            let (above, below) = walker.levels.split_at_mut(level);
            let cell = if let Some(parent) = above.last() {
                let (center, half) = scene.lattice.bricks_box(from, to);
                let cell = &mut below[0];
                parent.prune_reaching_into(scene.table(), center, half, &mut walker.pruner, cell);
                cell
            } else {
                below[0].clone_from(&block.cell);
                &mut below[0]
            };
            if cell.constant().is_some() {
                part.cells_pruned += bricks * CELLS_IN_BRICK;
                next = numbers.end;
            } else if to - from == UVec3::ONE {
                next = numbers.end;
                let before = part.vertices.len();
                walker.placer.brick(simd, scene, cell, from, part);
                let bytes = BYTES_PER_VERTEX * (part.vertices.len() - before);
                if control.spend(CELLS_IN_BRICK, bytes as u64).is_err() {
                    return;
                }
            } else {
                let halves = children(from, to).map(|(from, to)| (from, to, level + 1));
                walker.pending.extend(halves);
            }
        }
    }
}
