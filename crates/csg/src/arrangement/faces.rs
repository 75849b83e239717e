//! Which surfaces of a block may carry faces, and what matters on each: mostly far
//! less than in all of the block.

use super::block::Block;
use super::scene::Scene;
use super::together::Together;
use crate::program::{Pruner, SurfaceId};

/// The surfaces of a block that may carry faces: those that matter in a box around
/// themselves. Holds scratch memory.
pub(super) struct Faces {
    /// Ascending.
    carriers: Vec<SurfaceId>,
    /// For each of them, and more, the block with only what matters on it, or touches
    /// it.
    blocks: Vec<Block>,
    together: Together,
    pruner: Pruner,
}

impl Default for Faces {
    fn default() -> Self {
        Self {
            carriers: Vec::new(),
            blocks: Vec::new(),
            together: Together::default(),
            // Looks are told by toggling single literals.
            pruner: Pruner::literal_by_literal(),
        }
    }
}

impl Faces {
    /// Forgets another block.
    pub fn enter(&mut self, scene: &Scene<'_>, block: &Block) {
        self.carriers.clear();
        for id in block.cell.ids() {
            let own = scene.surface(id).own_bounds();
            let low = own.min.max(block.low);
            let high = own.max.min(block.high);
            let half = 0.5 * (high - low) + 2.0 * scene.near;
            if half.min_element() < 0.0 {
                continue;
            }
            let index = self.carriers.len();
            if self.blocks.len() == index {
                self.blocks.push(Block::default());
            }
            let part = &mut self.blocks[index];
            (part.low, part.high, part.spans) = (block.low, block.high, block.spans);
            let center = 0.5 * (low + high);
            let pruner = &mut self.pruner;
            let whole = &block.cell;
            whole.prune_into(scene.surfaces, center, half, pruner, &mut part.cell);
            if part.position_of(id).is_some() {
                self.carriers.push(id);
            }
        }
        self.together.enter(scene, block);
    }

    /// All of them in ascending order.
    pub fn carriers(&self) -> &[SurfaceId] {
        &self.carriers
    }

    /// The surfaces after one that may meet it on the boundary, ascending.
    pub fn beside(&self, one: SurfaceId) -> impl Iterator<Item = SurfaceId> {
        let block = self.block_of(one).into_iter();
        let ids = block.flat_map(|block| block.cell.ids());
        ids.filter(move |&other| one < other && self.together.are(one, other))
    }

    /// Whether two surfaces may meet on the boundary.
    pub fn are_beside(&self, one: SurfaceId, other: SurfaceId) -> bool {
        let [one, other] = [one.min(other), one.max(other)];
        let block = self.block_of(one);
        block.is_some_and(|block| block.position_of(other).is_some())
            && self.together.are(one, other)
    }

    fn block_of(&self, id: SurfaceId) -> Option<&Block> {
        let index = self.carriers.binary_search(&id).ok()?;
        Some(&self.blocks[index])
    }

    /// Each with the block with only what matters on it.
    pub fn iter(&self) -> impl Iterator<Item = (SurfaceId, &Block)> {
        self.carriers.iter().copied().zip(&self.blocks)
    }
}
