//! The fast filler: triangles by edge functions, 16 pixels at a time.
//!
//! An edge function (see [`fixed`](crate::fixed)) is linear, and samples are
//! 256 sub-pixels apart, so at the sample (i, j) of a tile it is
//! `c + 256 (dx j - dy i)`. It is not negative exactly if
//! `floor(c / 256) + dx j - dy i` is not: shifting c right by 8 bits loses
//! nothing, and leaves numbers that fit 32 bits for triangles of any size
//! within the guard band; c itself may need 64. The top-left rule subtracts 1
//! from c beforehand at the edges that do not own their samples.

use crate::fixed::{SUBPIXEL_BITS, SUBPIXELS};
use crate::simd::{DoubleLanes, FloatLanes, IntLanes, LANES, Lanes, MaskLanes, triple};
use crate::tile::{Plane, SAMPLES_OF_QUAD, SQUARES, TILE, TILE_BITS, TileBuffer};

/// Depth that changes by more than this from one sub-pixel to the next, a
/// sixteenth of its range in a pixel, is set up and filled in double precision
/// throughout: in single precision its change within a few pixels is rounded
/// to more than a unit of 24 bits. Only faces seen nearly edge-on are so steep.
pub(crate) const STEEP: f32 = 1.0 / 16.0 / 256.0;

/// A triangle set up for filling, its corners taken clockwise as seen (y
/// downwards).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Record {
    /// Edge functions at the top left corner of its first pixel, less 1 where
    /// the edge does not own its samples.
    pub c: [i64; 3],
    /// Their changes for one sub-pixel right and down.
    pub right: [i32; 3],
    pub down: [i32; 3],
    /// First and last pixel with a sample in its box, within the picture.
    pub x: [i16; 2],
    pub y: [i16; 2],
    /// A point near it, in sub-pixels from the top left corner of its first
    /// pixel.
    pub anchor: [f32; 2],
    /// Reversed depth there; what is far from there may be within the tile.
    pub z: f64,
    /// Its change for one sub-pixel right and down.
    pub slope: [f64; 2],
    /// Least and greatest depth of the corners.
    pub z_low: f32,
    pub z_high: f32,
    /// Number of the triangle in drawing order.
    pub triangle: i32,
    /// What it adds to windings: 1 where it shows its back, -1 for its front.
    pub winding: i32,
}

impl Record {
    /// Depth so many sub-pixels from the first pixel. In double precision for
    /// the first sample of each block, so that single precision adds no more
    /// than what changes within a block.
    #[inline(always)]
    pub fn depth_at(&self, [x, y]: [i32; 2]) -> f64 {
        let x = f64::from(x as f32 - self.anchor[0]);
        let y = f64::from(y as f32 - self.anchor[1]);
        self.z + (self.slope[0] * x + self.slope[1] * y)
    }

    /// The change of depth from the first sample of a block to all others.
    #[inline(always)]
    fn depth_in_block<S: Lanes>(&self, s: S, lattice: &Lattice) -> S::F {
        let [x, y] = self.slope.map(|slope| s.f(slope as f32));
        x * s.load_i(&lattice.x).to_float() + y * s.load_i(&lattice.y).to_float()
    }

    /// [`Record::depth_in_block`] in double precision.
    #[inline(always)]
    fn precise_depth_in_block<S: Lanes>(&self, s: S, lattice: &Lattice) -> S::D {
        let [x, y] = self.slope.map(|slope| s.d(slope));
        x * s.load_i(&lattice.x).to_double() + y * s.load_i(&lattice.y).to_double()
    }

    /// Edge functions at the samples of a block, the first of which is `start`
    /// sub-pixels from the first pixel.
    #[inline(always)]
    fn edges_in_block<S: Lanes>(&self, s: S, lattice: &Lattice, start: [i32; 2]) -> [S::I; 3] {
        let (right, down) = (self.right, self.down);
        let at = triple!(|K| {
            let (right, down) = (i64::from(right[K]), i64::from(down[K]));
            self.c[K] + right * i64::from(start[0]) + down * i64::from(start[1])
        });
        let small = |v: i32| v.unsigned_abs() < 1 << 15;
        let near = |c: i64| c.unsigned_abs() < 1 << 29;
        if right.into_iter().chain(down).all(small) && at.into_iter().all(near) {
            let (x, y) = (s.load_i(&lattice.x), s.load_i(&lattice.y));
            return triple!(|K| {
                (s.i(at[K] as i32) + (s.i(right[K]) * x + s.i(down[K]) * y))
                    .shr::<{ SUBPIXEL_BITS as i32 }>()
            });
        }
        triple!(|K| {
            let (right, down) = (i64::from(right[K]), i64::from(down[K]));
            let mut lanes = [0; LANES];
            for (k, lane) in lanes.iter_mut().enumerate() {
                let (x, y) = (i64::from(lattice.x[k]), i64::from(lattice.y[k]));
                let c = (at[K] + right * x + down * y) >> SUBPIXEL_BITS;
                // Beyond the limits the sign cannot change within a tile.
                *lane = c.clamp(-(1 << 30), 1 << 30) as i32;
            }
            s.load_i(&lanes)
        })
    }

    fn is_steep(&self) -> bool {
        self.slope
            .iter()
            .any(|slope| slope.abs() > f64::from(STEEP))
    }

    /// Whether every sample of a tile is inside, its first pixel being so many
    /// pixels from the record's.
    fn covers_tile(&self, from_first: [i32; 2]) -> bool {
        let start = from_first.map(|pixels| i64::from(pixels) << SUBPIXEL_BITS);
        let side = (TILE as i64) << SUBPIXEL_BITS;
        (0..3).all(|k| {
            let (right, down) = (i64::from(self.right[k]), i64::from(self.down[k]));
            let corner = self.c[k] + right * start[0] + down * start[1];
            corner + (right * side).min(0) + (down * side).min(0) >= 0
        })
    }
}

/// One pixel that a triangle covers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PixelOfTriangle {
    /// Sixteen times its block in the tile, plus its lane in the block.
    pub pixel: u32,
    pub depth: f32,
    pub triangle: i32,
}

/// Draws single pixels into the first plane of a tile.
pub(crate) fn fill_pixels(tile: &mut TileBuffer, pixels: &[PixelOfTriangle]) {
    let depths = tile.depth[0].as_flattened_mut();
    let triangles = tile.triangle[0].as_flattened_mut();
    for p in pixels {
        let at = p.pixel as usize % (TILE * TILE);
        let old = depths[at];
        // Equal depths go to the triangle drawn first.
        if old < p.depth || (old == p.depth && p.triangle < triangles[at]) {
            depths[at] = p.depth;
            triangles[at] = p.triangle;
        }
    }
}

/// The sub-pixel positions, from a pixel's corner, of its samples.
pub(crate) const CENTRE_SAMPLE: [[i32; 2]; 1] = [[128, 128]];

/// Counts of a filler's work.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FillCounts {
    /// Triangles that hierarchical depth hid.
    pub hidden: u64,
    /// Blocks of 4x4 samples looked at.
    pub blocks: u64,
    /// Pixels shaded afterwards.
    pub shaded: u64,
    /// Whether there was anything to fill.
    pub any: bool,
}

impl FillCounts {
    /// The counts of two tiles together.
    pub fn add(self, other: Self) -> Self {
        Self {
            hidden: self.hidden + other.hidden,
            blocks: self.blocks + other.blocks,
            shaded: self.shaded + other.shaded,
            any: self.any | other.any,
        }
    }
}

/// Column and row of each lane in its block.
pub(crate) const LANE_X: [i32; 16] = [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3];
pub(crate) const LANE_Y: [i32; 16] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3];

/// Where the 16 samples of a block are: one of each of 4x4 pixels, or four of
/// each of 2x2. Small triangles touch fewer of the latter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lattice {
    /// log2 of the pixels along a side of a block.
    bits: u32,
    /// The first sample, in sub-pixels from the block's corner.
    first: [i32; 2],
    /// The others, from there.
    x: [i32; LANES],
    y: [i32; LANES],
}

impl Lattice {
    /// Those of a tile that is filled in blocks of four samples, or of one.
    pub fn of(samples: &[[i32; 2]], in_quads: bool) -> Vec<Self> {
        let group = if in_quads { SAMPLES_OF_QUAD } else { 1 };
        samples.chunks(group).map(Self::new).collect()
    }

    /// Of so many samples a pixel.
    fn new(samples: &[[i32; 2]]) -> Self {
        let bits = if samples.len() == 1 { 2 } else { 1 };
        let side = 1 << bits;
        let first = samples[0];
        let at = |lane: i32| {
            let (sample, pixel) = (lane / (side * side), lane % (side * side));
            let sample = samples[sample as usize % samples.len()];
            [
                (pixel % side) * SUBPIXELS + sample[0] - first[0],
                (pixel / side) * SUBPIXELS + sample[1] - first[1],
            ]
        };
        Self {
            bits,
            first,
            x: std::array::from_fn(|lane| at(lane as i32)[0]),
            y: std::array::from_fn(|lane| at(lane as i32)[1]),
        }
    }
}

/// Fills one triangle into every sample plane of a tile whose first pixel is
/// `origin`.
#[inline(always)]
pub(crate) fn fill<S: Lanes>(
    s: S,
    buffer: &mut TileBuffer,
    origin: [i32; 2],
    record: &Record,
    lattices: &[Lattice],
    counts: &mut FillCounts,
) {
    // Its box of pixels within the tile.
    let last = TILE as i32 - 1;
    let range = |v: [i16; 2], axis: usize| {
        let [low, high] = v.map(|v| i32::from(v) - origin[axis]);
        (low.max(0), high.min(last))
    };
    let (x0, x1) = range(record.x, 0);
    let (y0, y1) = range(record.y, 1);
    let from_first = [0, 1].map(|axis| origin[axis] - i32::from([record.x[0], record.y[0]][axis]));
    let whole = (x0, y0) == (0, 0) && (x1, y1) == (last, last) && record.covers_tile(from_first);
    let fresh = !buffer.tile.drawn;
    if fresh {
        buffer.begin(whole);
    }
    // Hierarchical depth: hidden if every 8x8 square it touches is nearer.
    let mut hidden = true;
    for square_y in y0 >> 3..=y1 >> 3 {
        for square_x in x0 >> 3..=x1 >> 3 {
            let square = (square_y as usize * SQUARES + square_x as usize) % (SQUARES * SQUARES);
            hidden &= record.z_high < buffer.tile.farthest[square];
        }
    }
    if hidden && buffer.winding.is_empty() {
        counts.hidden += 1;
        return;
    }
    for (mut plane, lattice) in buffer.planes().zip(lattices) {
        let plane = &mut plane;
        let Lattice { bits, first, .. } = *lattice;
        let blocks = if whole {
            [0, last >> bits, 0, last >> bits]
        } else {
            [x0 >> bits, x1 >> bits, y0 >> bits, y1 >> bits]
        };
        counts.blocks += (blocks[1] - blocks[0] + 1) as u64 * (blocks[3] - blocks[2] + 1) as u64;
        // The first sample of the first block.
        let start = [0, 1].map(|axis| {
            ((from_first[axis] + (blocks[2 * axis] << bits)) << SUBPIXEL_BITS) + first[axis]
        });
        if whole {
            fill_whole(s, plane, record, lattice, start, fresh);
            continue;
        }
        let row = record.edges_in_block(s, lattice, start);
        let row_depth = record.depth_at(start);
        if record.is_steep() {
            let in_block = record.precise_depth_in_block(s, lattice);
            let depth = |first: f64| (s.d(first) + in_block).to_single();
            fill_plane(s, plane, record, (bits, blocks), row, row_depth, depth);
        } else {
            let in_block = record.depth_in_block(s, lattice);
            let depth = |first: f64| s.f(first as f32) + in_block;
            fill_plane(s, plane, record, (bits, blocks), row, row_depth, depth);
        }
    }
}

/// Blocks of a triangle so small that looking whether one is missed altogether
/// costs more than filling none of its pixels: the branch is not foreseen.
const FEW: i32 = 4;

/// Fills the blocks of a plane (first and last column, first and last row),
/// from the edge functions and the depth at the first of them. `depth`
/// continues that of a block's first sample to all.
#[inline(always)]
fn fill_plane<S: Lanes>(
    s: S,
    plane: &mut Plane,
    record: &Record,
    (bits, [bx0, bx1, by0, by1]): (u32, [i32; 4]),
    mut row: [S::I; 3],
    mut row_depth: f64,
    depth: impl Fn(f64) -> S::F,
) {
    let (right, down) = (record.right, record.down);
    let zero = s.i(0);
    let id = s.i(record.triangle);
    let few = (bx1 - bx0 + 1) * (by1 - by0 + 1) <= FEW;
    let step = triple!(|K| s.i(right[K] << bits));
    let step_down = triple!(|K| s.i(down[K] << bits));
    let (low, high) = (s.f(record.z_low), s.f(record.z_high));
    let block_step = block_step(record, bits);
    for by in by0..=by1 {
        let mut e = row;
        let mut depth_here = row_depth;
        for bx in bx0..=bx1 {
            let outside = (e[0] | e[1] | e[2]).lt(zero);
            if few || outside.bits() != 0xffff {
                let index = ((by << (TILE_BITS - bits)) + bx) as usize;
                let (Some(kept), Some(number)) =
                    (plane.depth.get_mut(index), plane.triangle.get_mut(index))
                else {
                    return;
                };
                let z = depth(depth_here).max(low).min(high);
                let old = s.load_f(kept);
                let old_id = s.load_i(number);
                // Equal depths go to the triangle drawn first.
                let nearer = old.lt(z) | (old.eq(z) & id.lt(old_id));
                let pass = nearer & !outside;
                pass.update_f(z, old).store(kept);
                pass.update_i(id, old_id).store(number);
                if let Some(winding) = plane.winding.get_mut(index) {
                    let added = outside.select_i(zero, s.i(record.winding));
                    (s.load_i(winding) + added).store(winding);
                }
            }
            e = triple!(|K| e[K] + step[K]);
            depth_here += block_step[0];
        }
        row = triple!(|K| row[K] + step_down[K]);
        row_depth += block_step[1];
    }
}

/// The change of depth from a block to the next, right and down.
#[inline(always)]
fn block_step(record: &Record, bits: u32) -> [f64; 2] {
    record
        .slope
        .map(|slope| slope * f64::from(SUBPIXELS << bits))
}

/// Fills a whole plane, whose first sample is `start` sub-pixels from the
/// record's first pixel. What is there does not matter if `fresh`.
#[inline(always)]
fn fill_whole<S: Lanes>(
    s: S,
    plane: &mut Plane,
    record: &Record,
    lattice: &Lattice,
    start: [i32; 2],
    fresh: bool,
) {
    let (low, high) = (s.f(record.z_low), s.f(record.z_high));
    let in_block = record.depth_in_block(s, lattice);
    let mut row_depth = record.depth_at(start);
    let block_step = block_step(record, lattice.bits);
    let id = s.i(record.triangle);
    let blocks = TILE >> lattice.bits;
    let rows = plane.depth.chunks_exact_mut(blocks);
    for (depths, triangles) in rows.zip(plane.triangle.chunks_exact_mut(blocks)) {
        let mut depth_here = row_depth;
        for (depth, triangle) in depths.iter_mut().zip(triangles) {
            let z = (s.f(depth_here as f32) + in_block).max(low).min(high);
            if fresh {
                z.store(depth);
                id.store(triangle);
            } else {
                let old = s.load_f(depth);
                let old_id = s.load_i(triangle);
                let nearer = old.lt(z) | (old.eq(z) & id.lt(old_id));
                nearer.update_f(z, old).store(depth);
                nearer.update_i(id, old_id).store(triangle);
            }
            depth_here += block_step[0];
        }
        row_depth += block_step[1];
    }
    for winding in plane.winding.as_flattened_mut() {
        *winding += record.winding;
    }
}
