//! Space cut into boxes until only few planes matter in each.

use glam::DVec3;

use super::block::Block;
use crate::control::{Control, Stage};
use crate::error::Error;
use crate::numeric::tolerance::COORDINATE;
use crate::program::{
    Cell, Crown, Given, Narrowed, Narrower, Program, Pruner, Side, Surface, SurfaceId,
};

/// So few planes are not worth another cut: the time that a block takes grows
/// with the third power of their number, but most is spent on cutting then. Tunes speed only.
const FEW_PLANES: usize = 20;

/// A block is cut no further after so many cuts in halves along every axis that
/// took next to no plane away: all of them pass near one point.
const MOST_VAIN_CUTS: u32 = 3;

/// Of formulas of more gates both halves of a box are worked on at once, if it was not halved
/// more often. Tunes speed only.
const MANY_GATES: usize = 8000;
const FEW_HALVINGS: u32 = 14;

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

/// Blocks end so little beyond walls, of the scene: these are within a block then, and next to
/// nothing else that is beyond them. Tunes speed only.
const BEYOND_WALLS: f64 = 1e-7;

/// Cuts the box around a program's whole scene; its surfaces are told as they lie there. Of some
/// programs only the rest is meant.
pub(super) fn cut(
    (program, surfaces, rest): (&Program, &[Surface], Option<&Cell>),
    given: Option<&Given>,
    [low, high]: [DVec3; 2],
    control: &Control,
) -> Result<(Vec<Block>, Counts), Error> {
    let beyond = match given {
        Some(given) if given.are_walls() => BEYOND_WALLS * (high - low).max_element(),
        _ => 0.0,
    };
    let cutter = Cutter {
        program,
        surfaces,
        rest,
        given,
        beyond,
        control,
        stage: &control.stage(1 << (3 * CUTS_TOLD), 0.0, 0.2),
        // Looks are told by toggling single literals.
        pruner: Pruner::literal_by_literal(),
        narrower: Narrower::default(),
        blocks: Vec::new(),
        counts: Counts::default(),
    };
    cutter.cut(low, high)
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
    program: &'a Program,
    surfaces: &'a [Surface],
    rest: Option<&'a Cell>,
    given: Option<&'a Given>,
    /// How far beyond walls blocks end.
    beyond: f64,
    control: &'a Control,
    stage: &'a Stage<'a>,
    pruner: Pruner,
    narrower: Narrower,
    blocks: Vec<Block>,
    counts: Counts,
}

impl Cutter<'_> {
    fn cut(mut self, low: DVec3, high: DVec3) -> Result<(Vec<Block>, Counts), Error> {
        let units = 1 << (3 * CUTS_TOLD);
        match self.given {
            Some(given) => {
                let crown = Crown::of(self.program.formula());
                self.halve((given, &crown), [low, high], 0, units)?;
            }
            None => {
                let mut cell = Cell::default();
                match self.rest {
                    Some(rest) => self.prune(rest, low, high, &mut cell),
                    None => self.prune(&self.program.root_cell(), low, high, &mut cell),
                }
                let way = Way {
                    cuts: 0,
                    vain: 0,
                    is_told: true,
                };
                self.descend(Block::new([low, high], cell), way)?;
            }
        }
        Ok((self.blocks, self.counts))
    }

    /// Cuts a box where polyhedra were, of which no more is looked at than what is above the
    /// next cuts: that takes no longer the more there is in the box. Progress is told by so
    /// many units.
    fn halve(
        &mut self,
        (given, crown): (&Given, &Crown),
        [low, high]: [DVec3; 2],
        halvings: u32,
        units: u64,
    ) -> Result<(), Error> {
        self.control.spend(1, 0)?;
        let surfaces = self.surfaces;
        let (center, half) = rounded_outward(low, high);
        let beyond = self.beyond;
        let side = |id: u32| {
            let surface = &surfaces[id as usize];
            if !given.is_cut(SurfaceId(id)) || given.are_walls() {
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
        let formula = self.program.formula();
        let mut cell = Cell::default();
        let is_cut = |id: u32| {
            given.is_cut(SurfaceId(id)) && {
                let (axis, at) = coordinate(&surfaces[id as usize]);
                low[axis] < at + beyond && at + beyond < high[axis]
            }
        };
        let narrowed = self
            .narrower
            .narrow(formula, crown, side, is_cut, &mut cell);
        self.counts.visited += 1;
        let Narrowed::Cut(cut, crown) = &narrowed else {
            self.stage.add(units);
            if matches!(narrowed, Narrowed::Constant(_)) {
                self.counts.pruned += 1;
                return Ok(());
            }
            let way = Way {
                cuts: 0,
                vain: 0,
                is_told: false,
            };
            return self.descend(Block::new([low, high], cell), way);
        };
        let (axis, at) = coordinate(&surfaces[*cut as usize]);
        let at = at + beyond;
        let (mut below, mut above) = ([low, high], [low, high]);
        (below[1][axis], above[0][axis]) = (at, at);
        // (Boxes of less than a unit are not told.)
        let (halvings, units) = (halvings + 1, units / 2);
        if formula.gates().len() < MANY_GATES || halvings > FEW_HALVINGS {
            self.halve((given, crown), below, halvings, units)?;
            return self.halve((given, crown), above, halvings, units);
        }
        let mut other = Self {
            pruner: Pruner::literal_by_literal(),
            narrower: Narrower::default(),
            blocks: Vec::new(),
            counts: Counts::default(),
            ..*self
        };
        let halves = rayon::join(
            || self.halve((given, crown), below, halvings, units),
            || other.halve((given, crown), above, halvings, units),
        );
        self.blocks.append(&mut other.blocks);
        self.counts.visited += other.counts.visited;
        self.counts.pruned += other.counts.pruned;
        halves.0.and(halves.1)
    }

    fn prune(&mut self, cell: &Cell, low: DVec3, high: DVec3, out: &mut Cell) {
        let (center, half) = rounded_outward(low, high);
        cell.prune_into(self.surfaces, center, half, &mut self.pruner, out);
        self.counts.visited += 1;
        self.counts.pruned += u64::from(out.constant().is_some());
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
        // Where faces of polyhedra are few, or all pass near one point, is known already.
        let others = match self.given {
            None => planes,
            Some(given) => {
                let ids = block.cell.ids();
                ids.filter(|&id| !given.has_faces(id)).count()
            }
        };
        let is_last = others <= FEW_PLANES || vain == MOST_VAIN_CUTS || cuts == MOST_CUTS;
        if is_told && (cuts == CUTS_TOLD || is_constant || is_last) {
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
        for octant in 0..8 {
            let mut part = block.octant(octant);
            self.prune(&block.cell, part.low, part.high, &mut part.cell);
            let is_vain = 8 * part.cell.surfaces.len() > 7 * planes;
            let way = Way {
                cuts: cuts + 1,
                vain: if is_vain { vain + 1 } else { 0 },
                is_told: is_told && cuts < CUTS_TOLD,
            };
            self.descend(part, way)?;
        }
        Ok(())
    }
}

/// The centre and the half extents of a box, rounded outward: a plane that touches a face
/// matters on both sides.
fn rounded_outward(low: DVec3, high: DVec3) -> (DVec3, DVec3) {
    let slack = COORDINATE * (low.abs() + high.abs());
    (0.5 * (low + high), 0.5 * (high - low) + slack)
}

/// The axis that a plane is across, and where it crosses that.
fn coordinate(plane: &Surface) -> (usize, f64) {
    let axis = plane.linear.abs().max_position();
    (axis, plane.anchor[axis])
}
