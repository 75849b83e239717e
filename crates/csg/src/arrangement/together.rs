//! Which surfaces of a block matter in one place: only these have edges in common.

use glam::DVec3;

use super::block::Block;
use super::scene::Scene;
use crate::program::{Cell, Pruner, SurfaceId};

/// Of no more surfaces it takes longer to tell which matter together than to look at all pairs.
/// Tunes speed only.
const FEW: usize = 8;

/// Parts of a block are halved no further where so few surfaces matter, or after so many
/// halvings, or so many in vain: all of them are near one place. Tunes speed only.
const FEW_IN_PART: usize = 5;
const MOST_HALVINGS: usize = 9;
const MOST_VAIN: usize = 3;

/// The pairs of surfaces of a block that matter in one of the small parts that it is cut into.
/// Holds scratch memory.
pub(super) struct Together {
    /// All of the block, ascending.
    ids: Vec<u32>,
    /// Whether all pairs are told to do so, without looking.
    is_any: bool,
    /// For each of them a bit for each of all.
    rows: Vec<u64>,
    /// So many for each.
    words: usize,
    /// What is left after so many halvings.
    cells: Vec<Cell>,
    pruner: Pruner,
}

impl Default for Together {
    fn default() -> Self {
        Self {
            ids: Vec::new(),
            is_any: true,
            rows: Vec::new(),
            words: 0,
            cells: Vec::new(),
            // Looks are told by toggling single literals.
            pruner: Pruner::literal_by_literal(),
        }
    }
}

impl Together {
    /// Forgets another block.
    pub fn enter(&mut self, scene: &Scene<'_>, block: &Block) {
        let count = block.cell.surfaces.len();
        self.is_any = count <= FEW;
        if self.is_any {
            return;
        }
        self.ids.clone_from(&block.cell.surfaces);
        self.words = count.div_ceil(64);
        self.rows.clear();
        self.rows.resize(count * self.words, 0);
        self.halve(scene, &block.cell, [block.low, block.high], 0, 0);
    }

    /// Whether two surfaces of the block matter in one place.
    pub fn are(&self, one: SurfaceId, other: SurfaceId) -> bool {
        let place = |id: SurfaceId| self.ids.binary_search(&id.0);
        self.is_any
            || place(one).is_ok_and(|one| {
                place(other).is_ok_and(|other| {
                    self.rows[one * self.words + other / 64] >> (other % 64) & 1 == 1
                })
            })
    }

    fn halve(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        [low, high]: [DVec3; 2],
        halvings: usize,
        vain: usize,
    ) {
        if cell.constant().is_some() {
            return;
        }
        let count = cell.surfaces.len();
        if count <= FEW_IN_PART || halvings == MOST_HALVINGS || vain == MOST_VAIN {
            self.add(cell);
            return;
        }
        let axis = (high - low).max_position();
        let middle = 0.5 * (low[axis] + high[axis]);
        if self.cells.len() == halvings {
            self.cells.push(Cell::default());
        }
        let mut part = std::mem::take(&mut self.cells[halvings]);
        for is_upper in [false, true] {
            let mut ends = [low, high];
            ends[usize::from(!is_upper)][axis] = middle;
            let [low, high] = ends;
            let half = 0.5 * (high - low) + 2.0 * scene.near;
            let center = 0.5 * (low + high);
            cell.prune_into(scene.surfaces, center, half, &mut self.pruner, &mut part);
            let is_vain = 8 * part.surfaces.len() > 7 * count;
            let vain = if is_vain { vain + 1 } else { 0 };
            self.halve(scene, &part, ends, halvings + 1, vain);
        }
        self.cells[halvings] = part;
    }

    /// All pairs that matter in a part.
    fn add(&mut self, part: &Cell) {
        for &one in &part.surfaces {
            let Ok(row) = self.ids.binary_search(&one) else {
                continue;
            };
            // (Both lists are ascending.)
            let mut place = 0;
            for &other in &part.surfaces {
                while self.ids[place] < other {
                    place += 1;
                }
                self.rows[row * self.words + place / 64] |= 1 << (place % 64);
            }
        }
    }
}
