//! A cell's formula as a scalar field: minimum and maximum of first-order
//! distances, whose sign is exactly the truth of the formula.

use glam::DVec3;

use crate::program::{Cell, Operand, Operation, Surface};

/// Samples in a row.
pub(super) const ROW: usize = 16;
type Row = [f32; ROW];

/// Distances are clamped to this many cells: beyond the neighbouring sample
/// they do not matter.
const FARTHEST: f64 = 8.0;
/// And away from zero, whose sign would be nobody's: a point with f = 0
/// counts as inside f <= 0.
const NEAREST: f64 = 1e-6;

/// The scratch memory of [`Field::fill_row`].
#[derive(Debug, Default)]
pub(super) struct Scratch {
    surfaces: Vec<Row>,
    gates: Vec<Row>,
}

/// The field of one cell of the program.
pub(super) struct Field<'a> {
    pub(super) all: &'a [Surface],
    pub(super) cell: &'a Cell,
    /// Unit of the distances: the side of a lattice cell.
    pub(super) unit: f64,
}

impl Field<'_> {
    /// Fills `out` with the field at the points (x[i], y, z): negative inside.
    pub(super) fn fill_row(
        &self,
        x: &[f64; ROW],
        y: f64,
        z: f64,
        scratch: &mut Scratch,
        out: &mut Row,
    ) {
        let formula = &self.cell.formula;
        scratch.surfaces.clear();
        for &id in &self.cell.surfaces {
            let mut row = [0.0; ROW];
            distances(&self.all[id as usize], x, y, z, self.unit, &mut row);
            scratch.surfaces.push(row);
        }
        scratch.gates.clear();
        for gate in formula.gates() {
            let intersection = gate.operation == Operation::And;
            // The value that decides nothing.
            let mut result = [if intersection { f32::MIN } else { f32::MAX }; ROW];
            for &operand in formula.operands_of(gate) {
                let (row, sign) = self.operand(operand, scratch);
                for (result, value) in result.iter_mut().zip(row) {
                    let value = value * sign;
                    let replace = if intersection {
                        value > *result
                    } else {
                        value < *result
                    };
                    *result = if replace { value } else { *result };
                }
            }
            scratch.gates.push(result);
        }
        let (row, sign) = self.operand(formula.root(), scratch);
        for (out, value) in out.iter_mut().zip(row) {
            *out = value * sign;
        }
    }

    /// An operand's row, and the sign to take it with.
    fn operand<'a>(&self, operand: Operand, scratch: &'a Scratch) -> (&'a Row, f32) {
        const INSIDE: Row = [-(FARTHEST as f32); ROW];
        match operand {
            Operand::Constant(true) => (&INSIDE, 1.0),
            Operand::Constant(false) => (&INSIDE, -1.0),
            Operand::Literal(i) => {
                let literal = self.cell.formula.literals()[i as usize];
                let sign = if literal.outside { -1.0 } else { 1.0 };
                (&scratch.surfaces[literal.surface as usize], sign)
            }
            Operand::Gate(i) => (&scratch.gates[i as usize], 1.0),
        }
    }
}

/// f / |∇f| along a row, in units of `unit`, clamped; negative exactly where
/// [`Surface::value`] is not positive.
fn distances(surface: &Surface, x: &[f64; ROW], y: f64, z: f64, unit: f64, out: &mut Row) {
    let [a, b, c] = surface.row(y, z);
    let anchor = surface.anchor().x;
    let signed = |f: f64, distance: f64| {
        let size = distance.abs().clamp(NEAREST, FARTHEST);
        (if f <= 0.0 { -size } else { size }) as f32
    };
    if surface.is_plane() {
        for (out, &x) in out.iter_mut().zip(x) {
            let dx = x - anchor;
            let f = (a * dx + b) * dx + c;
            *out = signed(f, f / unit);
        }
        return;
    }
    // The gradient is linear along the row.
    let start = surface.gradient(DVec3::new(anchor, y, z));
    let [xx, _, _, xy, _, zx] = surface.quadratic;
    for (out, &x) in out.iter_mut().zip(x) {
        let dx = x - anchor;
        let f = (a * dx + b) * dx + c;
        let gx = 2.0 * xx * dx + start.x;
        let gy = xy * dx + start.y;
        let gz = zx * dx + start.z;
        let slope = (gx * gx + gy * gy + gz * gz).sqrt() * unit;
        // At an apex both vanish; the clamp takes care of what follows.
        *out = signed(f, f / (slope + f64::MIN_POSITIVE));
    }
}

/// The first-order distance of `point` from a surface.
pub(super) fn distance(surface: &Surface, point: DVec3) -> f64 {
    let slope = surface.gradient(point).length();
    surface.value(point).abs() / (slope + f64::MIN_POSITIVE)
}
