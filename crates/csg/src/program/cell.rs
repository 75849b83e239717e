//! Cells: boxes with the program pruned to what still varies inside them.

use glam::DVec3;

use super::formula::{Formula, Gate, Literal, Operand};
use super::surface::{Side, Surface};

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
    /// New index of each literal, surface and gate, or `UNUSED`.
    literal_index: Vec<u32>,
    surface_index: Vec<u32>,
    gate_index: Vec<u32>,
}

const UNUSED: u32 = u32::MAX;

impl Cell {
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
        let mut sides = std::mem::take(&mut pruner.sides);
        sides.clear();
        sides.extend(
            self.surfaces
                .iter()
                .map(|&id| all[id as usize].side_of_box(center, half)),
        );
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
                            if met_in[slot ^ 1] == index as u32 {
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

/// The corner of the cube ±1 that octant `octant` (bit 0 for x) lies towards.
pub(crate) fn octant_offset(octant: u8) -> DVec3 {
    let side = |bit: u8| if octant >> bit & 1 == 0 { -1.0 } else { 1.0 };
    DVec3::new(side(0), side(1), side(2))
}
