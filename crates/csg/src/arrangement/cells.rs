//! Space cut into boxes until only few planes matter in each.

use glam::DVec3;

use crate::control::{Control, Stage};
use crate::error::Error;
use crate::numeric::tolerance::COORDINATE;
use crate::program::{Cell, Given, Operand, Pruner, Side, Surface};

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

/// Of blocks with more planes both halves are worked on at once. Tunes speed only.
const MANY_PLANES: usize = 1000;

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
    given: Option<&Given>,
    root: &Block,
    control: &Control,
) -> Result<(Vec<Block>, Counts), Error> {
    let mut cutter = Cutter {
        surfaces,
        given,
        control,
        stage: &control.stage(1 << (3 * CUTS_TOLD), 0.0, 0.2),
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
    let way = Way {
        cuts: 0,
        vain: 0,
        is_told: true,
    };
    cutter.descend(root, way)?;
    Ok((cutter.blocks, cutter.counts))
}

/// How a block came about.
#[derive(Clone, Copy)]
struct Way {
    /// Cuts in halves along every axis.
    cuts: u32,
    /// The last of these that took next to no plane away.
    vain: u32,
    /// Whether progress is told of its parts.
    is_told: bool,
}

struct Cutter<'a> {
    surfaces: &'a [Surface],
    given: Option<&'a Given>,
    control: &'a Control,
    stage: &'a Stage<'a>,
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
        match self.given {
            None => cell.prune_into(self.surfaces, center, half, &mut self.pruner, out),
            Some(given) => {
                let side = |id: u32| {
                    let surface = &self.surfaces[id as usize];
                    if !given.is_cut(id) {
                        return surface.side_of_box(center, half);
                    }
                    // Blocks end there: on neither side it matters any more.
                    let (axis, at) = coordinate(surface);
                    let is_below = high[axis] <= at;
                    if !is_below && low[axis] < at {
                        Side::Crossing
                    } else if is_below == (surface.linear[axis] > 0.0) {
                        Side::Inside
                    } else {
                        Side::Outside
                    }
                };
                cell.prune_by(side, &mut self.pruner, out);
            }
        }
        self.counts.visited += 1;
        self.counts.pruned += u64::from(out.constant().is_some());
    }

    /// The plane nearest to the formula's root that only parts space.
    fn cut_of(&self, cell: &Cell) -> Option<u32> {
        let given = self.given?;
        let formula = &cell.formula;
        let gates = formula.gates().iter().rev();
        let operands = gates.flat_map(|gate| formula.operands_of(gate));
        let surfaces = operands.filter_map(|&operand| match operand {
            Operand::Literal(i) => Some(formula.literals()[i as usize].surface),
            _ => None,
        });
        surfaces
            .map(|position| cell.surfaces[position as usize])
            .find(|&id| given.is_cut(id))
    }

    /// Goes on with what of a block is below a coordinate along an axis, or above.
    fn half(
        &mut self,
        block: &Block,
        (axis, at): (usize, f64),
        half: usize,
        way: Way,
    ) -> Result<(), Error> {
        let (mut low, mut high) = (block.low, block.high);
        if half == 0 {
            high[axis] = at;
        } else {
            low[axis] = at;
        }
        let mut cell = Cell::default();
        self.prune(&block.cell, low, high, &mut cell);
        self.descend(Block { low, high, cell }, way)
    }

    fn descend(&mut self, block: Block, way: Way) -> Result<(), Error> {
        self.control.spend(1, 0)?;
        let Way {
            cuts,
            vain,
            is_told,
        } = way;
        let planes = block.cell.surfaces.len();
        let is_constant = block.cell.constant().is_some();
        let cut = self.cut_of(&block.cell);
        // Where faces of polyhedra are few, or all pass near one point, is known already.
        let others = match self.given {
            None => planes,
            Some(given) => {
                let ids = block.cell.surfaces.iter();
                ids.filter(|&&id| !given.has_faces(id)).count()
            }
        };
        let is_last = others <= FEW_PLANES || vain == MOST_VAIN_CUTS || cuts == MOST_CUTS;
        let is_last = cut.is_none() && is_last;
        if is_told && (cuts == CUTS_TOLD || is_constant || is_last || cut.is_some()) {
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
        if let Some(cut) = cut {
            let cut = coordinate(&self.surfaces[cut as usize]);
            let is_told = false;
            let way = Way { is_told, ..way };
            if planes < MANY_PLANES {
                self.half(&block, cut, 0, way)?;
                return self.half(&block, cut, 1, way);
            }
            let mut other = Self {
                pruner: Pruner::literal_by_literal(),
                blocks: Vec::new(),
                counts: Counts::default(),
                ..*self
            };
            let halves = rayon::join(
                || self.half(&block, cut, 0, way),
                || other.half(&block, cut, 1, way),
            );
            self.blocks.append(&mut other.blocks);
            self.counts.visited += other.counts.visited;
            self.counts.pruned += other.counts.pruned;
            return halves.0.and(halves.1);
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
            let part = Way {
                cuts: cuts + 1,
                vain: if is_vain { vain + 1 } else { 0 },
                is_told: is_told && cuts < CUTS_TOLD,
            };
            self.descend(Block { low, high, cell }, part)?;
        }
        Ok(())
    }
}

/// The axis that a plane is across, and where it crosses that.
fn coordinate(plane: &Surface) -> (usize, f64) {
    let axis = plane.linear.abs().max_position();
    (axis, plane.anchor[axis])
}
