//! Does the solid really change across the surfaces of a vertex?
//!
//! For every combination of sides of a vertex's own surfaces, the others as
//! they are at the vertex, the formula tells whether the solid is there: a
//! truth table of up to eight bits. A surface that makes no difference in it
//! has no face at the vertex. Tables of 64 vertices are found in one pass over
//! the formula, a byte each.

use glam::DVec3;

use super::scene::Scene;
use crate::program::{Cell, Formula, Operand, Operation};

/// Vertices tested together.
pub(super) const LANES: usize = 64;

/// Per assignment of three variables, a bit each, the value of the k-th.
const VARIABLES: [u8; 3] = [0xaa, 0xcc, 0xf0];

type Bytes = [u8; LANES];

/// Signs of all surfaces at a batch of vertices; its memory is reused from
/// batch to batch.
pub(super) struct Tests {
    signs: Vec<Bytes>,
    gates: Vec<Bytes>,
    /// Vertices that lie on some other surface, too, or on too many.
    undecided: u64,
    /// For each vertex how many other surfaces it lies on.
    on_surfaces: Bytes,
}

/// The truth tables, where they were found.
pub(super) struct Verdicts {
    tables: Bytes,
    undecided: u64,
}

impl Default for Tests {
    fn default() -> Self {
        Self {
            signs: Vec::new(),
            gates: Vec::new(),
            undecided: 0,
            on_surfaces: [0; LANES],
        }
    }
}

impl Tests {
    /// Starts a batch: up to [`LANES`] points.
    #[inline(always)]
    pub fn begin(&mut self, points: impl Iterator<Item = DVec3>, scene: &Scene<'_>, cell: &Cell) {
        /// A whole number of vectors of whatever width.
        const WHOLE: usize = 8;
        let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut count = 0;
        for (lane, point) in points.enumerate() {
            (x[lane], y[lane], z[lane]) = (point.x, point.y, point.z);
            count = lane + 1;
        }
        let lanes = count.next_multiple_of(WHOLE).min(LANES);
        let limit = scene.tolerance * scene.tolerance;
        self.undecided = 0;
        self.on_surfaces = [0; LANES];
        self.signs.resize(cell.surfaces.len(), [0; LANES]);
        for (&id, signs) in cell.surfaces.iter().zip(&mut self.signs) {
            let surface = &scene.surfaces[id as usize];
            let anchor = surface.anchor();
            let g = surface.linear;
            let [xx, yy, zz, xy, yz, zx] = surface.quadratic;
            let (xy, yz, zx) = (0.5 * xy, 0.5 * yz, 0.5 * zx);
            for lane in 0..lanes {
                let (dx, dy, dz) = (x[lane] - anchor.x, y[lane] - anchor.y, z[lane] - anchor.z);
                let hx = xx * dx + (xy * dy + zx * dz);
                let hy = yy * dy + (yz * dz + xy * dx);
                let hz = zz * dz + (zx * dx + yz * dy);
                let f = (hx + g.x) * dx + (hy + g.y) * dy + (hz + g.z) * dz + surface.constant;
                let (gx, gy, gz) = (2.0 * hx + g.x, 2.0 * hy + g.y, 2.0 * hz + g.z);
                let square = gx * gx + gy * gy + gz * gz;
                signs[lane] = if f <= 0.0 { 0xff } else { 0 };
                self.on_surfaces[lane] += u8::from(f * f <= limit * square);
            }
        }
    }

    /// Lets the vertex's own surfaces take both sides.
    #[inline(always)]
    pub fn free(&mut self, lane: usize, surfaces: &[u16]) {
        if surfaces.len() > VARIABLES.len() || usize::from(self.on_surfaces[lane]) > surfaces.len()
        {
            self.undecided |= 1 << lane;
            return;
        }
        for (&surface, variable) in surfaces.iter().zip(VARIABLES) {
            self.signs[usize::from(surface)][lane] = variable;
        }
    }

    #[inline(always)]
    pub fn evaluate(&mut self, formula: &Formula) -> Verdicts {
        let mut gates = std::mem::take(&mut self.gates);
        gates.clear();
        for gate in formula.gates() {
            let is_and = gate.operation == Operation::And;
            let mut value = [if is_and { 0xff } else { 0 }; LANES];
            for &operand in formula.operands_of(gate) {
                let (bytes, flip) = self.operand(formula, operand, &gates);
                for (v, b) in value.iter_mut().zip(bytes) {
                    let operand = b ^ flip;
                    *v = if is_and { *v & operand } else { *v | operand };
                }
            }
            gates.push(value);
        }
        let (bytes, flip) = self.operand(formula, formula.root(), &gates);
        let tables = bytes.map(|b| b ^ flip);
        self.gates = gates;
        Verdicts {
            tables,
            undecided: self.undecided,
        }
    }

    #[inline(always)]
    fn operand<'a>(
        &'a self,
        formula: &Formula,
        operand: Operand,
        gates: &'a [Bytes],
    ) -> (&'a Bytes, u8) {
        const NOTHING: Bytes = [0; LANES];
        match operand {
            Operand::Constant(value) => (&NOTHING, if value { 0xff } else { 0 }),
            Operand::Literal(i) => {
                let literal = formula.literals()[i as usize];
                let flip = if literal.outside { 0xff } else { 0 };
                (&self.signs[literal.surface as usize], flip)
            }
            Operand::Gate(i) => (&gates[i as usize], 0),
        }
    }
}

impl Verdicts {
    /// Whether the solid changes across each of the first `surfaces` surfaces
    /// of the vertex; `None` if the test could not tell.
    #[inline(always)]
    pub fn get(&self, lane: usize, surfaces: usize) -> Option<bool> {
        if self.undecided >> lane & 1 == 1 {
            return None;
        }
        let table = self.tables[lane];
        let changes = |(k, variable): (usize, &u8)| (table ^ table >> (1 << k)) & !variable != 0;
        Some(VARIABLES.iter().enumerate().take(surfaces).all(changes))
    }
}
