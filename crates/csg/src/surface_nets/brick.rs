//! Bit-parallel classification of one brick.
//!
//! A brick has 16³ samples; sample (x, y, z) is bit x + 16 (y mod 4) of word
//! 4z + y/4, so one word holds four rows, and a step along x, y or z is a shift
//! by one bit, by 16 bits or by four words. Along a row every surface is a 1D
//! quadratic: a sample costs two multiplications and two additions, its sign
//! becomes a bit, and the formula is evaluated as word logic, 64 samples at a
//! time. No fused multiply-add anywhere: the signs must not depend on the
//! machine.

use glam::DVec3;

use super::lattice::SAMPLES;
use super::loops::next_axes;
use crate::program::{Cell, Formula, Operand, Operation, Reach, Side, Surface};

/// One bit per sample.
pub(super) type Mask = [u64; WORDS];
pub(super) const WORDS: usize = SAMPLES * SAMPLES * SAMPLES / 64;

/// The samples that have a neighbour at x + 1.
const HAS_NEXT_X: u64 = 0x7fff_7fff_7fff_7fff;
/// The same for y + 1, in a word that ends a z layer.
const HAS_NEXT_Y: u64 = 0x0000_ffff_ffff_ffff;
/// The first sample of every row in a word.
const EVERY_ROW: u64 = 0x0001_0001_0001_0001;
/// Words per z layer.
const LAYER: usize = 4;

/// The sample coordinates of a brick, in the local frame.
#[derive(Clone, Debug)]
pub(super) struct Samples {
    pub x: [f64; SAMPLES],
    pub y: [f64; SAMPLES],
    pub z: [f64; SAMPLES],
}

impl Samples {
    pub fn point(&self, sample: usize) -> DVec3 {
        DVec3::new(
            self.x[sample & 15],
            self.y[sample >> 4 & 15],
            self.z[sample >> 8],
        )
    }
}

/// The samples with f <= 0. Bit for bit [`Surface::value`]: the coefficients
/// of a layer's rows first, all at once, then every row by Horner's rule;
/// layers beyond the surface's reach are known without.
#[inline(always)]
pub(super) fn surface_signs(surface: &Surface, reach: &Reach, samples: &Samples, signs: &mut Mask) {
    let anchor = surface.anchor();
    let [xx, yy, zz, xy, yz, zx] = surface.quadratic;
    let (mut dx, mut dy) = (samples.x, samples.y);
    for i in 0..SAMPLES {
        dx[i] -= anchor.x;
        dy[i] -= anchor.y;
    }
    let linear = surface.linear;
    if [yy, zz, xy, yz, zx, linear.y, linear.z] == [0.0; 7] {
        // f depends on x alone (what is left out adds zeroes): one row for all.
        let mut bits = 0;
        for (x, dx) in dx.iter().enumerate() {
            let f = (xx * dx + linear.x) * dx + surface.constant;
            bits |= u64::from(f <= 0.0) << x;
        }
        signs.fill(bits * EVERY_ROW);
        return;
    }
    let rows_are_constant = [xx, xy, zx, linear.x] == [0.0; 4];
    for (layer, words) in signs.chunks_exact_mut(LAYER).enumerate() {
        if let Some(side) = reach.side_of_layer(samples.z[layer]) {
            words.fill(if side == Side::Inside { u64::MAX } else { 0 });
            continue;
        }
        let dz = samples.z[layer] - anchor.z;
        let (mut b, mut c) = ([0.0; SAMPLES], [0.0; SAMPLES]);
        for i in 0..SAMPLES {
            let dy = dy[i];
            b[i] = linear.x + (xy * dy + zx * dz);
            c[i] = surface.constant
                + ((yy * dy + yz * dz + linear.y) * dy + (zz * dz + linear.z) * dz);
        }
        if rows_are_constant {
            for (word, c) in words.iter_mut().zip(c.chunks_exact(4)) {
                let mut rows = 0;
                for (row, &c) in c.iter().enumerate() {
                    rows |= if c <= 0.0 { 0xffff << (16 * row) } else { 0 };
                }
                *word = rows;
            }
            continue;
        }
        for (group, word) in words.iter_mut().enumerate() {
            let mut lanes = [0u64; 8];
            for row in 0..4 {
                let (b, c) = (b[4 * group + row], c[4 * group + row]);
                for half in 0..2 {
                    for (lane, bits) in lanes.iter_mut().enumerate() {
                        let x = half * 8 + lane;
                        let f = (xx * dx[x] + b) * dx[x] + c;
                        let bit = 1u64 << (row * 16 + x);
                        *bits |= if f <= 0.0 { bit } else { 0 };
                    }
                }
            }
            *word = lanes.into_iter().fold(0, |all, lane| all | lane);
        }
    }
}

/// The samples inside the solid, from those inside each surface.
#[inline(always)]
pub(super) fn solid_signs(
    formula: &Formula,
    signs: &[Mask],
    gates: &mut Vec<Mask>,
    solid: &mut Mask,
) {
    gates.clear();
    for gate in formula.gates() {
        let is_and = gate.operation == Operation::And;
        let mut value = [if is_and { u64::MAX } else { 0 }; WORDS];
        for &operand in formula.operands_of(gate) {
            let (mask, flip) = operand_mask(formula, operand, signs, gates);
            if is_and {
                for (v, m) in value.iter_mut().zip(mask) {
                    *v &= m ^ flip;
                }
            } else {
                for (v, m) in value.iter_mut().zip(mask) {
                    *v |= m ^ flip;
                }
            }
        }
        gates.push(value);
    }
    let (mask, flip) = operand_mask(formula, formula.root(), signs, gates);
    for (s, m) in solid.iter_mut().zip(mask) {
        *s = m ^ flip;
    }
}

/// The mask of an operand, and what to flip in it.
#[inline(always)]
fn operand_mask<'a>(
    formula: &Formula,
    operand: Operand,
    signs: &'a [Mask],
    gates: &'a [Mask],
) -> (&'a Mask, u64) {
    const NOTHING: Mask = [0; WORDS];
    match operand {
        Operand::Constant(value) => (&NOTHING, if value { u64::MAX } else { 0 }),
        Operand::Literal(i) => {
            let literal = formula.literals()[i as usize];
            let flip = if literal.outside { u64::MAX } else { 0 };
            (&signs[literal.surface as usize], flip)
        }
        Operand::Gate(i) => (&gates[i as usize], 0),
    }
}

/// The lower samples of the lattice edges along x, y and z whose ends differ,
/// and the cells whose corners do.
#[inline(always)]
pub(super) fn changes(mask: &Mask, out: &mut [Mask; 4]) {
    let [x, y, z, cells] = out;
    changes_along(0, mask, x);
    changes_along(1, mask, y);
    changes_along(2, mask, z);
    mixed_cells(mask, cells);
}

/// The lower samples of the lattice edges along `axis` whose ends differ.
#[inline(always)]
pub(super) fn changes_along(axis: usize, mask: &Mask, out: &mut Mask) {
    match axis {
        0 => {
            for (o, m) in out.iter_mut().zip(mask) {
                *o = (m ^ m >> 1) & HAS_NEXT_X;
            }
        }
        1 => {
            for word in 0..WORDS {
                let next = if word % LAYER == LAYER - 1 {
                    0
                } else {
                    mask[word + 1] << 48
                };
                let valid = if word % LAYER == LAYER - 1 {
                    HAS_NEXT_Y
                } else {
                    u64::MAX
                };
                out[word] = (mask[word] ^ (mask[word] >> 16 | next)) & valid;
            }
        }
        _ => {
            for word in 0..WORDS - LAYER {
                out[word] = mask[word] ^ mask[word + LAYER];
            }
            out[WORDS - LAYER..].fill(0);
        }
    }
}

/// The cells (by their lowest sample) whose corners differ in `mask`.
#[inline(always)]
pub(super) fn mixed_cells(mask: &Mask, out: &mut Mask) {
    let (mut any, mut all) = ([0u64; WORDS], [0u64; WORDS]);
    for word in 0..WORDS {
        let m = mask[word];
        any[word] = m | m >> 1;
        all[word] = m & m >> 1;
    }
    let (x_any, x_all) = (any, all);
    for word in 0..WORDS {
        let last = word % LAYER == LAYER - 1;
        let carry = |m: &Mask| if last { 0 } else { m[word + 1] << 48 };
        any[word] |= x_any[word] >> 16 | carry(&x_any);
        all[word] &= x_all[word] >> 16 | carry(&x_all);
    }
    for word in 0..WORDS - LAYER {
        let any = any[word] | any[word + LAYER];
        let all = all[word] & all[word + LAYER];
        let valid = if word % LAYER == LAYER - 1 {
            HAS_NEXT_X & HAS_NEXT_Y
        } else {
            HAS_NEXT_X
        };
        out[word] = any & !all & valid;
    }
    out[WORDS - LAYER..].fill(0);
}

/// The faces normal to `axis` (by their lowest sample) that the brick owns and
/// all of whose edges are crossed; whether there is any. `crossed` is by axis
/// of the edges.
#[inline(always)]
pub(super) fn ambiguous_faces(axis: usize, crossed: &[Mask; 4], faces: &mut Mask) -> bool {
    let (b, c) = next_axes(axis);
    let (mut opposite_b, mut opposite_c) = ([0; WORDS], [0; WORDS]);
    step_down(&crossed[b], c, &mut opposite_b);
    step_down(&crossed[c], b, &mut opposite_c);
    let mut any = 0;
    for word in 0..WORDS {
        faces[word] =
            crossed[b][word] & crossed[c][word] & opposite_b[word] & opposite_c[word] & OWNED[word];
        any |= faces[word];
    }
    any != 0
}

/// The lower samples of all lattice edges along `axis` of the given cells.
#[inline(always)]
pub(super) fn edges_of_cells(axis: usize, cells: &Mask, edges: &mut Mask) {
    let (b, c) = next_axes(axis);
    let mut half = *cells;
    add_step_up(cells, b, &mut half);
    *edges = half;
    add_step_up(&half, c, edges);
}

/// Adds the mask moved one sample up along `axis` to another; it has no
/// samples in the last layer.
#[inline(always)]
fn add_step_up(mask: &Mask, axis: usize, out: &mut Mask) {
    match axis {
        0 => {
            for (out, mask) in out.iter_mut().zip(mask) {
                *out |= mask << 1;
            }
        }
        1 => {
            out[0] |= mask[0] << 16;
            for word in 1..WORDS {
                out[word] |= mask[word] << 16 | mask[word - 1] >> 48;
            }
        }
        _ => {
            for word in LAYER..WORDS {
                out[word] |= mask[word - LAYER];
            }
        }
    }
}

/// The mask moved one sample down along `axis`; what moves in from outside is
/// not specified but where [`OWNED`].
#[inline(always)]
fn step_down(mask: &Mask, axis: usize, out: &mut Mask) {
    match axis {
        0 => {
            for (out, mask) in out.iter_mut().zip(mask) {
                *out = mask >> 1;
            }
        }
        1 => {
            for word in 0..WORDS - 1 {
                out[word] = mask[word] >> 16 | mask[word + 1] << 48;
            }
        }
        _ => out[..WORDS - LAYER].copy_from_slice(&mask[LAYER..]),
    }
}

/// What a brick owns of edges and faces: those that start in the first 15
/// samples of every row, column and layer.
pub(super) const OWNED: Mask = {
    let mut owned = [HAS_NEXT_X; WORDS];
    let mut word = 0;
    while word < WORDS {
        if word % LAYER == LAYER - 1 {
            owned[word] &= HAS_NEXT_Y;
        }
        if word >= WORDS - LAYER {
            owned[word] = 0;
        }
        word += 1;
    }
    owned
};

/// The inside corners of a cell, bit x + 2y + 4z, by its lowest sample.
#[inline(always)]
pub(super) fn corners(mask: &Mask, sample: usize) -> u8 {
    let (word, bit) = (sample >> 6, sample & 63);
    // 64 samples from the cell's own on: its row and the next one start there.
    let from =
        |word: usize| mask[word % WORDS] >> bit | mask[(word + 1) % WORDS] << 1 << (63 - bit);
    let square = |rows: u64| rows & 0b11 | rows >> 14 & 0b1100;
    (square(from(word)) | square(from(word + LAYER)) << 4) as u8
}

/// The rows of samples along x that bound a row of cells, 16 bits each: its
/// own, the next along y, along z, and along both.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam(u64);

impl Beam {
    /// The beams of all rows, by y + 16z; those of the last ones along y and z
    /// bound no cells.
    #[inline(always)]
    pub fn all(mask: &Mask) -> [Self; SAMPLES * SAMPLES] {
        let mut rows = [0; SAMPLES * SAMPLES + SAMPLES + 1];
        for (rows, word) in rows.chunks_exact_mut(4).zip(mask) {
            for (i, row) in rows.iter_mut().enumerate() {
                *row = word >> (16 * i) & 0xffff;
            }
        }
        let mut beams = [Self(0); SAMPLES * SAMPLES];
        for (i, beam) in beams.iter_mut().enumerate() {
            let (next_y, next_z) = (i + 1, i + SAMPLES);
            beam.0 = rows[i] | rows[next_y] << 16 | rows[next_z] << 32 | rows[next_z + 1] << 48;
        }
        beams
    }

    /// [`corners`] of the x-th cell.
    #[inline(always)]
    pub fn corners(self, x: usize) -> u8 {
        const PAIRS: u64 = 0x0003_0003_0003_0003;
        // Brings the pairs together, and nothing else to where they meet.
        const TOGETHER: u64 = 1 << 48 | 1 << 34 | 1 << 20 | 1 << 6;
        ((self.0 >> x & PAIRS).wrapping_mul(TOGETHER) >> 48) as u8
    }
}

/// Whether one sample is set.
#[inline(always)]
pub(super) fn is_set(mask: &Mask, sample: usize) -> bool {
    mask[sample >> 6] >> (sample & 63) & 1 == 1
}

/// Room for what [`expand`] writes, which is up to [`AT_ONCE`] - 1 items more
/// than there are.
pub(super) type List = [u16; WORDS * 64 + AT_ONCE];

/// Bits that [`expand`] takes out of a word before it looks whether there are
/// more: where a surface crosses a brick flatly, four rows have a bit each. Tunes speed only.
const AT_ONCE: usize = 4;

/// Writes an item for every sample of a mask to a list, in ascending order;
/// their number. `item` is given the word, the bit in it (or 64 where an item
/// is written for nothing) and the sample.
#[inline(always)]
pub(super) fn expand(mask: &Mask, list: &mut List, item: impl Fn(usize, u32, u16) -> u16) -> usize {
    let mut count = 0;
    for (word, &bits) in mask.iter().enumerate() {
        let first = (word * 64) as u16;
        let mut bits = bits;
        let mut at = count;
        count += bits.count_ones() as usize;
        while bits != 0 {
            let Some(slots) = list[at..].first_chunk_mut::<AT_ONCE>() else {
                break;
            };
            for slot in slots {
                let bit = bits.trailing_zeros();
                *slot = item(word, bit, first + bit as u16);
                bits &= bits.wrapping_sub(1);
            }
            at += AT_ONCE;
        }
    }
    count
}

/// Calls `visit` for every set bit, in ascending order.
#[inline(always)]
pub(super) fn for_each_set(mask: &Mask, mut visit: impl FnMut(usize)) {
    for (word, &bits) in mask.iter().enumerate() {
        let mut bits = bits;
        while bits != 0 {
            visit(word * 64 + bits.trailing_zeros() as usize);
            bits &= bits - 1;
        }
    }
}

/// Signs and changes of a brick's surfaces and of its solid.
#[derive(Debug)]
pub(super) struct Classified {
    pub signs: Vec<Mask>,
    pub solid: Mask,
    gates: Vec<Mask>,
}

impl Default for Classified {
    fn default() -> Self {
        Self {
            signs: Vec::new(),
            solid: [0; WORDS],
            gates: Vec::new(),
        }
    }
}

impl Classified {
    /// Classifies all samples of a brick; `surfaces` is the whole program's
    /// list in the local frame, with their reaches.
    #[inline(always)]
    pub fn classify(
        &mut self,
        cell: &Cell,
        (surfaces, reaches): (&[Surface], &[Reach]),
        samples: &Samples,
    ) {
        self.signs.resize(cell.surfaces.len(), [0; WORDS]);
        for (&id, signs) in cell.surfaces.iter().zip(&mut self.signs) {
            surface_signs(
                &surfaces[id as usize],
                &reaches[id as usize],
                samples,
                signs,
            );
        }
        solid_signs(&cell.formula, &self.signs, &mut self.gates, &mut self.solid);
    }
}
