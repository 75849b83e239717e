//! What vertices are called from slab to slab: where they are in the lattice.

use glam::UVec3;

use super::super::lattice::CELLS;
use super::super::part::{BrickRecord, Part};

/// Bits of a cell's place along each axis: there are fewer than 2^20 cells.
const ALONG: u32 = 20;
/// Above them: which vertex of the cell.
const KIND: u32 = 3 * ALONG;
/// The first of the kinds that are not loops: the vertices on ambiguous faces.
const FACES: u64 = 8;

/// The key of a vertex of a brick: the cell whose lowest sample it is, and which of its
/// vertices, loop by loop, or of those on its lower faces.
fn key(brick: UVec3, sample: u16, kind: u64) -> u64 {
    let along = |axis: usize| {
        let first = u64::from(brick[axis]) * CELLS as u64;
        (first + u64::from(sample >> (4 * axis) & 15)) << (ALONG * axis as u32)
    };
    kind << KIND | along(0) | along(1) | along(2)
}

/// The axes along which a cell or face is in the last layer of its brick, a bit each.
fn last_layers(sample: u16) -> u32 {
    (0..3).fold(0, |layers, axis| {
        let is_last = sample >> (4 * axis) & 15 == CELLS as u16 - 1;
        layers | u32::from(is_last) << axis
    })
}

/// Calls `visit` for every vertex of a brick, in ascending order: with its
/// place among the brick's, its key, and the axes along which it is in the last
/// layer.
pub(super) fn for_each_vertex(
    part: &Part,
    brick: &BrickRecord,
    mut visit: impl FnMut(u32, u64, u32),
) {
    let place = brick.position;
    let range = |range: &std::ops::Range<u32>| range.start as usize..range.end as usize;
    for (vertex, &sample) in (0..).zip(&part.cells[range(&brick.cells)]) {
        visit(vertex, key(place, sample, 0), last_layers(sample));
    }
    let mut others: Vec<(u32, u16, u64)> = Vec::new();
    for cell in &part.complex[range(&brick.complex)] {
        let loops = 0..u32::from(cell.loops.count);
        others.extend(loops.map(|i| (cell.vertex + i, cell.sample, i.into())));
    }
    for arcs in &part.arcs[range(&brick.arcs)] {
        let (normal, sample) = (u64::from(arcs.face >> 12), arcs.face & 0xfff);
        let arcs = [0, 1].map(|i| (arcs.vertex + i, sample, FACES + 2 * normal + u64::from(i)));
        others.extend(arcs);
    }
    others.sort_unstable();
    for (vertex, sample, kind) in others {
        visit(vertex, key(place, sample, kind), last_layers(sample));
    }
}
