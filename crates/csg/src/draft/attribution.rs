//! Which surface a triangle of the draft lies on.

use glam::{DVec3, Vec3};

use super::field::distance;
use crate::program::{Cell, Formula, Literal, Operand, Surface};

/// Finds the surface of one triangle after another, within one cell.
pub(super) struct Attribution<'a> {
    all: &'a [Surface],
    cell: &'a Cell,
    /// Only surfaces within this distance of a triangle come into question.
    reach: f64,
    /// By distance: (distance, index in the cell's list).
    near: Vec<(f64, u32)>,
    truths: Vec<bool>,
    gates: Vec<bool>,
}

/// What is known of one triangle.
pub(super) struct Attributed {
    /// Index of the surface in the program.
    pub(super) surface: u32,
    /// Index of the primitive in the program.
    pub(super) primitive: u32,
    /// Outward unit normals at the corners.
    pub(super) normals: [Vec3; 3],
    /// Whether the solid changes across that surface near the triangle.
    pub(super) clear: bool,
}

impl<'a> Attribution<'a> {
    pub(super) fn new(all: &'a [Surface], cell: &'a Cell, lattice_cell: f64) -> Self {
        Self {
            all,
            cell,
            // A vertex and its surface share a lattice cell, or nearly so.
            reach: 2.0 * lattice_cell,
            near: Vec::new(),
            truths: Vec::new(),
            gates: Vec::new(),
        }
    }

    /// The surface nearest to the triangle's centroid across which the solid
    /// changes there; failing that, the nearest of all. `None` in a cell
    /// without surfaces.
    pub(super) fn of(&mut self, corners: [DVec3; 3]) -> Option<Attributed> {
        let point = (corners[0] + corners[1] + corners[2]) / 3.0;
        let surfaces = &self.cell.surfaces;
        self.near.clear();
        self.near.extend(
            surfaces
                .iter()
                .zip(0..)
                .map(|(&id, index)| (distance(&self.all[id as usize], point), index)),
        );
        self.near
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let nearest = self.near.first()?.1;
        let mut literal = None;
        if surfaces.len() > 1 {
            self.evaluate_literals(point);
            for i in 0..self.near.len() {
                let (distance, index) = self.near[i];
                if distance > self.reach {
                    break;
                }
                literal = self.deciding_literal(index);
                if literal.is_some() {
                    break;
                }
            }
        }
        let clear = literal.is_some() || surfaces.len() == 1;
        let formula = &self.cell.formula;
        let of_surface = |index: u32| {
            let found = formula.literals().iter().find(|l| l.surface == index);
            found.copied()
        };
        let literal = literal.or_else(|| of_surface(nearest))?;
        let id = surfaces[literal.surface as usize];
        let surface = &self.all[id as usize];
        // The formula grows with each literal, so the solid ends where the
        // literal turns false.
        let sign = if literal.outside { -1.0 } else { 1.0 };
        let flat = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize_or(DVec3::Z);
        let normals = corners.map(|corner| {
            let normal = (surface.gradient(corner) * sign).normalize_or(flat);
            // A bevel may face away from the surface it was given to.
            let normal = if normal.dot(flat) > 0.0 { normal } else { flat };
            normal.as_vec3()
        });
        Some(Attributed {
            surface: id,
            primitive: literal.origin,
            normals,
            clear,
        })
    }

    fn evaluate_literals(&mut self, point: DVec3) {
        let (all, cell) = (self.all, self.cell);
        self.truths.clear();
        self.truths.extend(cell.formula.literals().iter().map(|l| {
            let id = cell.surfaces[l.surface as usize];
            (all[id as usize].value(point) <= 0.0) != l.outside
        }));
    }

    /// A literal of the surface at `index` by which the solid changes across
    /// it: one that does so alone if there is one, otherwise any, if all of
    /// the surface's literals together do.
    fn deciding_literal(&mut self, index: u32) -> Option<Literal> {
        let formula = &self.cell.formula;
        let literals = formula.literals();
        let mine = |l: &Literal| l.surface == index;
        let value = evaluate(formula, &self.truths, &mut self.gates);
        for (i, literal) in literals.iter().enumerate().filter(|(_, l)| mine(l)) {
            self.truths[i] = !self.truths[i];
            let changed = evaluate(formula, &self.truths, &mut self.gates) != value;
            self.truths[i] = !self.truths[i];
            if changed {
                return Some(*literal);
            }
        }
        self.flip(index);
        let changed = evaluate(formula, &self.truths, &mut self.gates) != value;
        self.flip(index);
        let first = literals.iter().find(|l| mine(l));
        first.filter(|_| changed).copied()
    }

    /// Flips the truths of all literals of the surface at `index`.
    fn flip(&mut self, index: u32) {
        let literals = self.cell.formula.literals();
        for (truth, literal) in self.truths.iter_mut().zip(literals) {
            *truth ^= literal.surface == index;
        }
    }
}

/// The formula's value for given truths of its literals.
fn evaluate(formula: &Formula, truths: &[bool], gates: &mut Vec<bool>) -> bool {
    let value = |operand, gates: &[bool]| match operand {
        Operand::Constant(value) => value,
        Operand::Literal(i) => truths[i as usize],
        Operand::Gate(i) => gates[i as usize],
    };
    gates.clear();
    for gate in formula.gates() {
        let absorbing = gate.operation.absorbing();
        let mut operands = formula.operands_of(gate).iter();
        let decided = operands.any(|&operand| value(operand, gates) == absorbing);
        gates.push(decided == absorbing);
    }
    value(formula.root(), gates)
}
