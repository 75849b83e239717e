//! Space cut into boxes until only few planes matter in each.

use glam::DVec3;

use crate::control::{Control, Stage};
use crate::error::Error;
use crate::numeric::tolerance::COORDINATE;
use crate::program::{Cell, Pruner, Surface};

/// A box, half-open, with the program pruned to it. The boxes of one scene
/// share their coordinates to the bit, so that they partition every line.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    pub low: DVec3,
    pub high: DVec3,
    pub cell: Cell,
}

impl Block {
    pub fn center(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    /// Whether a point is in this block and in no neighbour.
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.low).all() && point.cmplt(self.high).all()
    }

    /// The planes of its six sides.
    pub fn sides(&self) -> impl Iterator<Item = Surface> {
        [self.low, self.high]
            .into_iter()
            .flat_map(|corner| DVec3::AXES.map(|axis| Surface::plane(corner * axis, axis)))
    }
}

/// So few planes are not worth another cut: the time that a block takes grows
/// with the third power of their number, but most is spent on cutting then. Tunes speed only.
const FEW_PLANES: usize = 20;

/// A block is cut no further after so many cuts in halves along every axis that
/// took next to no plane away: all of them pass near one point.
const MOST_VAIN_CUTS: u32 = 3;

/// No block is smaller than this share of the scene.
const MOST_CUTS: u32 = 40;

/// How many blocks were looked at, and how many of them were constant.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub visited: u64,
    pub pruned: u64,
}

/// Progress is told by boxes of so many cuts.
const CUTS_TOLD: u32 = 3;

/// Cuts the box around the whole scene.
pub(super) fn cut(
    surfaces: &[Surface],
    root: &Block,
    control: &Control,
) -> Result<(Vec<Block>, Counts), Error> {
    let mut cutter = Cutter {
        surfaces,
        control,
        stage: control.stage(1 << (3 * CUTS_TOLD), 0.0, 0.2),
        // Looks are told by toggling single literals.
        pruner: Pruner::literal_by_literal(),
        blocks: Vec::new(),
        counts: Counts::default(),
    };
    let mut pruned = Cell::default();
    cutter.prune(&root.cell, root.low, root.high, &mut pruned);
    let root = Block {
        cell: pruned,
        ..*root
    };
    cutter.descend(root, 0, 0)?;
    Ok((cutter.blocks, cutter.counts))
}

struct Cutter<'a> {
    surfaces: &'a [Surface],
    control: &'a Control,
    stage: Stage<'a>,
    pruner: Pruner,
    blocks: Vec<Block>,
    counts: Counts,
}

impl Cutter<'_> {
    fn prune(&mut self, cell: &Cell, low: DVec3, high: DVec3, out: &mut Cell) {
        let center = 0.5 * (low + high);
        // Rounded outward: a plane that touches a face matters on both sides.
        let slack = COORDINATE * (low.abs() + high.abs());
        let half = 0.5 * (high - low) + slack;
        cell.prune_into(self.surfaces, center, half, &mut self.pruner, out);
        self.counts.visited += 1;
        self.counts.pruned += u64::from(out.constant().is_some());
    }

    fn descend(&mut self, block: Block, cuts: u32, vain: u32) -> Result<(), Error> {
        self.control.spend(1, 0)?;
        let planes = block.cell.surfaces.len();
        let is_last = planes <= FEW_PLANES || vain == MOST_VAIN_CUTS || cuts == MOST_CUTS;
        let is_constant = block.cell.constant().is_some();
        if cuts == CUTS_TOLD || cuts < CUTS_TOLD && (is_constant || is_last) {
            self.stage.add(1 << (3 * (CUTS_TOLD - cuts)));
        }
        if is_constant {
            return Ok(());
        }
        if is_last {
            let bytes = size_of::<Block>() + block.cell.bytes();
            self.blocks.push(block);
            return self.control.spend(0, bytes as u64);
        }
        let middle = 0.5 * (block.low + block.high);
        for octant in 0..8 {
            let (mut low, mut high) = (block.low, block.high);
            for axis in 0..3 {
                if octant >> axis & 1 == 0 {
                    high[axis] = middle[axis];
                } else {
                    low[axis] = middle[axis];
                }
            }
            let mut cell = Cell::default();
            self.prune(&block.cell, low, high, &mut cell);
            let is_vain = 8 * cell.surfaces.len() > 7 * planes;
            let part = Block { low, high, cell };
            self.descend(part, cuts + 1, if is_vain { vain + 1 } else { 0 })?;
        }
        Ok(())
    }
}
