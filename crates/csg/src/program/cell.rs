//! Cells: boxes with the program pruned to what still varies inside them.

use glam::DVec3;

use super::formula::{Formula, Gate, Literal, Operand};
use crate::surface::{Bounds, Side, Surface, SurfaceId, half_space_bounds};

/// What is left of a program inside a box: the surfaces that may cross it
/// (ids into the program's list) and the formula over them, whose literals
/// name surfaces by position in [`Cell::surfaces`].
#[derive(Clone, Debug, Default)]
pub struct Cell {
    /// Surfaces that still matter, ascending.
    pub surfaces: Vec<u32>,
    /// The formula over them.
    pub formula: Formula,
}

/// Scratch memory of [`Cell::prune_into`]: kept between calls, so that
/// pruning allocates nothing once it is warm.
#[derive(Debug, Default)]
pub struct Pruner {
    sides: Vec<Side>,
    /// What each gate comes to: itself, one of its operands, or a constant.
    resolved: Vec<Operand>,
    /// The gate that each half-space (2 surface + outside) was last met in.
    met_in: Vec<u32>,
    live_gates: Vec<bool>,
    keeps_complements: bool,
    /// New index of each literal, surface and gate, or `UNUSED`.
    literal_index: Vec<u32>,
    surface_index: Vec<u32>,
    gate_index: Vec<u32>,
}

const UNUSED: u32 = u32::MAX;

impl Pruner {
    /// A pruner that puts constants in and does nothing else: the shortened
    /// formula has the given one's value for every assignment to its literals,
    /// even one under which a surface's two half-spaces overlap.
    pub(crate) fn literal_by_literal() -> Self {
        Self {
            keeps_complements: true,
            ..Self::default()
        }
    }
}

impl Cell {
    /// What it holds besides itself, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.surfaces) + self.formula.bytes()
    }

    /// The surfaces that still matter, ascending.
    pub(crate) fn ids(&self) -> impl ExactSizeIterator<Item = SurfaceId> + DoubleEndedIterator {
        self.surfaces.iter().map(|&id| SurfaceId(id))
    }

    /// The surface of a literal of its formula.
    pub(crate) fn surface_of(&self, literal: &Literal) -> SurfaceId {
        SurfaceId(self.surfaces[literal.surface as usize])
    }

    /// Where a surface is in its list, if it matters in it.
    pub(crate) fn position_of(&self, surface: u32) -> Option<u32> {
        let place = self.surfaces.binary_search(&surface);
        place.ok().map(|place| place as u32)
    }

    /// The constant the cell comes to, if nothing varies in it any more.
    #[must_use]
    pub fn constant(&self) -> Option<bool> {
        match self.formula.root {
            Operand::Constant(value) => Some(value),
            _ => None,
        }
    }

    /// Prunes this cell to the box of the given centre and half extents:
    /// every surface is proven inside, outside or crossing, and the formula
    /// shortened accordingly. Linear in the size of the cell.
    pub fn prune_into(
        &self,
        all: &[Surface],
        center: DVec3,
        half: DVec3,
        pruner: &mut Pruner,
        out: &mut Self,
    ) {
        let side = |id: u32| all[id as usize].side_of_box(center, half);
        self.prune_by(side, pruner, out);
    }

    /// The same with the surfaces' reaches at hand, by which most of many small
    /// ones are found to be elsewhere.
    pub(crate) fn prune_reaching_into(
        &self,
        (all, reaches): (&[Surface], &[Reach]),
        center: DVec3,
        half: DVec3,
        pruner: &mut Pruner,
        out: &mut Self,
    ) {
        let (low, high) = (center - half, center + half);
        let low = low.to_array().map(|v| (v as f32).next_down());
        let high = high.to_array().map(|v| (v as f32).next_up());
        let side = |id: u32| {
            let reach = &reaches[id as usize];
            if reach.misses(low, high) {
                reach.beyond
            } else if reach.is_within(low, high) {
                Side::Crossing
            } else {
                all[id as usize].side_of_box(center, half)
            }
        };
        self.prune_by(side, pruner, out);
    }

    /// The same by the sides that are told of each surface.
    pub(crate) fn prune_by(&self, side: impl Fn(u32) -> Side, pruner: &mut Pruner, out: &mut Self) {
        let mut sides = std::mem::take(&mut pruner.sides);
        sides.clear();
        sides.extend(self.surfaces.iter().map(|&id| side(id)));
        self.restrict_into(&sides, pruner, out);
        pruner.sides = sides;
    }

    /// Shortens the formula for known sides (one per surface of this cell).
    pub fn restrict_into(&self, sides: &[Side], pruner: &mut Pruner, out: &mut Self) {
        let formula = &self.formula;
        out.surfaces.clear();
        out.formula.literals.clear();
        out.formula.gates.clear();
        out.formula.operands.clear();

        let literal_value = |i: u32| {
            let literal = formula.literals[i as usize];
            match sides[literal.surface as usize] {
                Side::Inside => Operand::Constant(!literal.outside),
                Side::Outside => Operand::Constant(literal.outside),
                Side::Crossing => Operand::Literal(i),
            }
        };
        let resolved = &mut pruner.resolved;
        resolved.clear();
        let met_in = &mut pruner.met_in;
        met_in.clear();
        met_in.resize(2 * self.surfaces.len(), UNUSED);
        let resolve = |operand, resolved: &[Operand]| match operand {
            Operand::Constant(_) => operand,
            Operand::Literal(i) => literal_value(i),
            Operand::Gate(i) => resolved[i as usize],
        };
        for (index, gate) in formula.gates.iter().enumerate() {
            let absorbing = gate.operation.absorbing();
            let mut kept = 0;
            let mut only = Operand::Constant(!absorbing);
            for &operand in formula.operands_of(gate) {
                match resolve(operand, resolved) {
                    Operand::Constant(value) if value == absorbing => {
                        (kept, only) = (0, Operand::Constant(absorbing));
                        break;
                    }
                    Operand::Constant(_) => {}
                    varying => {
                        kept += 1;
                        only = varying;
                        if let Operand::Literal(i) = varying {
                            let literal = formula.literals[i as usize];
                            let slot = 2 * literal.surface as usize + usize::from(literal.outside);
                            met_in[slot] = index as u32;
                            if met_in[slot ^ 1] == index as u32 && !pruner.keeps_complements {
                                // S or not-S is everything, S and not-S nothing.
                                (kept, only) = (0, Operand::Constant(absorbing));
                                break;
                            }
                        }
                    }
                }
            }
            resolved.push(if kept > 1 {
                Operand::Gate(index as u32)
            } else {
                only
            });
        }
        let root = resolve(formula.root, resolved);
        if let Operand::Constant(_) = root {
            out.formula.root = root;
            return;
        }

        // Users come after operands: one backward pass finds what is in use.
        pruner.literal_index.clear();
        pruner.literal_index.resize(formula.literals.len(), UNUSED);
        pruner.surface_index.clear();
        pruner.surface_index.resize(self.surfaces.len(), UNUSED);
        pruner.live_gates.clear();
        pruner.live_gates.resize(formula.gates.len(), false);
        let literal_index = &mut pruner.literal_index;
        let surface_index = &mut pruner.surface_index;
        let live = &mut pruner.live_gates;
        let mut mark = |operand, live: &mut [bool]| match operand {
            Operand::Constant(_) => {}
            Operand::Literal(i) => {
                literal_index[i as usize] = 0;
                surface_index[formula.literals[i as usize].surface as usize] = 0;
            }
            Operand::Gate(i) => live[i as usize] = true,
        };
        mark(root, live);
        for (index, gate) in formula.gates.iter().enumerate().rev() {
            if live[index] {
                for &operand in formula.operands_of(gate) {
                    mark(resolve(operand, resolved), live);
                }
            }
        }

        for (index, &id) in surface_index.iter_mut().zip(&self.surfaces) {
            if *index != UNUSED {
                *index = out.surfaces.len() as u32;
                out.surfaces.push(id);
            }
        }
        for (index, literal) in literal_index.iter_mut().zip(&formula.literals) {
            if *index != UNUSED {
                *index = out.formula.literals.len() as u32;
                out.formula.literals.push(Literal {
                    surface: surface_index[literal.surface as usize],
                    ..*literal
                });
            }
        }
        pruner.gate_index.clear();
        pruner.gate_index.resize(formula.gates.len(), UNUSED);
        let gate_index = &mut pruner.gate_index;
        let renumber = |operand, gate_index: &[u32]| match operand {
            Operand::Constant(_) => operand,
            Operand::Literal(i) => Operand::Literal(literal_index[i as usize]),
            Operand::Gate(i) => Operand::Gate(gate_index[i as usize]),
        };
        for (index, gate) in formula.gates.iter().enumerate() {
            if !live[index] {
                continue;
            }
            let start = out.formula.operands.len() as u32;
            for &operand in formula.operands_of(gate) {
                match resolve(operand, resolved) {
                    Operand::Constant(_) => {}
                    varying => out.formula.operands.push(renumber(varying, gate_index)),
                }
            }
            gate_index[index] = out.formula.gates.len() as u32;
            out.formula.gates.push(Gate {
                operation: gate.operation,
                start,
                end: out.formula.operands.len() as u32,
            });
        }
        out.formula.root = renumber(root, gate_index);
    }
}

/// A box outside of which f has one sign, as far as it is easily told: a small
/// sphere far away is recognised in a fraction of the time, and memory, that
/// its [`Side`] takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    /// In single precision, rounded outward; infinite where nothing is known.
    low: [f32; 3],
    high: [f32; 3],
    /// The side of everything outside of the box.
    beyond: Side,
}

impl Reach {
    pub fn of(surface: &Surface) -> Self {
        let inside = half_space_bounds(surface);
        let outside = half_space_bounds(&surface.negated());
        let is_bound = |b: &Bounds| b.min.is_finite() || b.max.is_finite();
        let (bounds, beyond) = if is_bound(&outside) && !is_bound(&inside) {
            (outside, Side::Inside)
        } else {
            (inside, Side::Outside)
        };
        Self {
            low: bounds.min.to_array().map(|v| (v as f32).next_down()),
            high: bounds.max.to_array().map(|v| (v as f32).next_up()),
            beyond,
        }
    }

    /// The side on which all points of the given z lie, where that is easily
    /// told.
    #[inline]
    pub fn side_of_layer(&self, z: f64) -> Option<Side> {
        let misses = (z < f64::from(self.low[2])) | (z > f64::from(self.high[2]));
        misses.then_some(self.beyond)
    }

    /// Whether a box has no point in common with this one.
    #[inline]
    fn misses(&self, low: [f32; 3], high: [f32; 3]) -> bool {
        let apart = |a: usize| (low[a] > self.high[a]) | (high[a] < self.low[a]);
        apart(0) | apart(1) | apart(2)
    }

    /// Whether a box holds all of this one, and so points on both sides.
    #[inline]
    fn is_within(&self, low: [f32; 3], high: [f32; 3]) -> bool {
        let holds = |a: usize| (low[a] < self.low[a]) & (high[a] > self.high[a]);
        holds(0) & holds(1) & holds(2)
    }
}
