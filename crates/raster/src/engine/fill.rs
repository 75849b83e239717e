//! The fast filler: triangles by edge functions, 16 pixels at a time.
//!
//! An edge function (see [`fixed`](crate::fixed)) is linear, and samples are
//! 256 sub-pixels apart, so at the sample (i, j) of a tile it is
//! `c + 256 (dx j - dy i)`. It is not negative exactly if
//! `floor(c / 256) + dx j - dy i` is not: shifting c right by 8 bits loses
//! nothing, and leaves numbers that fit 32 bits for triangles of any size
//! within the guard band; c itself may need 64. The top-left rule subtracts 1
//! from c beforehand at the edges that do not own their samples.

use crate::fixed::SUBPIXEL_BITS;
use crate::simd::{DoubleLanes, FloatLanes, IntLanes, Lanes, MaskLanes, triple};
use crate::tile::{BLOCK, BLOCKS, Plane, SQUARES, TILE, TileBuffer};

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
    fn depth_in_block<S: Lanes>(&self, s: S) -> S::F {
        let [x, y] = self.slope.map(|slope| s.f(slope as f32));
        let lane_x = s.load_i(&LANE_X).shl::<8>().to_float();
        let lane_y = s.load_i(&LANE_Y).shl::<8>().to_float();
        x * lane_x + y * lane_y
    }

    /// [`Record::depth_in_block`] in double precision.
    #[inline(always)]
    fn precise_depth_in_block<S: Lanes>(&self, s: S) -> S::D {
        let [x, y] = self.slope.map(|slope| s.d(slope));
        let lane_x = s.load_i(&LANE_X).shl::<8>().to_double();
        let lane_y = s.load_i(&LANE_Y).shl::<8>().to_double();
        x * lane_x + y * lane_y
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

/// Sub-pixels from a block to the next.
const BLOCK_STEP: f64 = (BLOCK << SUBPIXEL_BITS) as f64;

/// Fills one triangle into every sample plane of a tile whose first pixel is
/// `origin`.
#[inline(always)]
pub(crate) fn fill<S: Lanes>(
    s: S,
    buffer: &mut TileBuffer,
    origin: [i32; 2],
    record: &Record,
    samples: &[[i32; 2]],
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
    if whole {
        for (plane, sample) in buffer.planes().zip(samples) {
            let start = [0, 1].map(|axis| (from_first[axis] << SUBPIXEL_BITS) + sample[axis]);
            fill_whole(s, plane, record, start, fresh);
        }
        counts.blocks += (samples.len() * BLOCKS * BLOCKS) as u64;
        return;
    }
    let block = BLOCK as i32;
    let blocks = [x0 / block, x1 / block, y0 / block, y1 / block];
    counts.blocks += samples.len() as u64
        * (blocks[1] - blocks[0] + 1) as u64
        * (blocks[3] - blocks[2] + 1) as u64;
    // The first block in sub-pixels from the record's first pixel.
    let first = [
        (from_first[0] + blocks[0] * block) << SUBPIXEL_BITS,
        (from_first[1] + blocks[2] * block) << SUBPIXEL_BITS,
    ];
    let (lane_x, lane_y) = (s.load_i(&LANE_X), s.load_i(&LANE_Y));
    let (right, down) = (record.right, record.down);
    let edges = triple!(|K| {
        let (right, down) = (i64::from(right[K]), i64::from(down[K]));
        Edge::<S> {
            at_first: record.c[K] + right * i64::from(first[0]) + down * i64::from(first[1]),
            in_block: s.i(record.right[K]) * lane_x + s.i(record.down[K]) * lane_y,
        }
    });
    for (plane, sample) in buffer.planes().zip(samples) {
        let start = [first[0] + sample[0], first[1] + sample[1]];
        let row = triple!(|K| {
            let (right, down) = (i64::from(right[K]), i64::from(down[K]));
            let at = right * i64::from(sample[0]) + down * i64::from(sample[1]);
            // Beyond the limits the sign cannot change within a tile.
            let c = (edges[K].at_first + at) >> SUBPIXEL_BITS;
            s.i(c.clamp(-(1 << 30), 1 << 30) as i32) + edges[K].in_block
        });
        let row_depth = record.depth_at(start);
        if record.is_steep() {
            let in_block = record.precise_depth_in_block(s);
            let depth = |first: f64| (s.d(first) + in_block).to_single();
            fill_plane(s, plane, record, blocks, row, row_depth, depth);
        } else {
            let in_block = record.depth_in_block(s);
            let depth = |first: f64| s.f(first as f32) + in_block;
            fill_plane(s, plane, record, blocks, row, row_depth, depth);
        }
    }
}

/// An edge function, in sub-pixels at the first pixel of the first block, and
/// its changes from there to all pixels of a block.
#[derive(Clone, Copy)]
struct Edge<S: Lanes> {
    at_first: i64,
    in_block: S::I,
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
    mut plane: Plane,
    record: &Record,
    [bx0, bx1, by0, by1]: [i32; 4],
    mut row: [S::I; 3],
    mut row_depth: f64,
    depth: impl Fn(f64) -> S::F,
) {
    let block = BLOCK as i32;
    let (right, down) = (record.right, record.down);
    let zero = s.i(0);
    let id = s.i(record.triangle);
    let few = (bx1 - bx0 + 1) * (by1 - by0 + 1) <= FEW;
    let step = triple!(|K| s.i(right[K] * block));
    let step_down = triple!(|K| s.i(down[K] * block));
    let (low, high) = (s.f(record.z_low), s.f(record.z_high));
    let block_step = record.slope.map(|slope| slope * BLOCK_STEP);
    for by in by0..=by1 {
        let mut e = row;
        let mut depth_here = row_depth;
        for bx in bx0..=bx1 {
            let outside = (e[0] | e[1] | e[2]).lt(zero);
            if few || outside.bits() != 0xffff {
                let index = (by as usize * BLOCKS + bx as usize) % (BLOCKS * BLOCKS);
                let z = depth(depth_here).max(low).min(high);
                let (kept, number) = (&mut plane.depth[index], &mut plane.triangle[index]);
                let old = s.load_f(kept);
                let old_id = s.load_i(number);
                // Equal depths go to the triangle drawn first.
                let nearer = old.lt(z) | (old.eq(z) & id.lt(old_id));
                let pass = nearer & !outside;
                pass.update_f(z, old).store(kept);
                pass.update_i(id, old_id).store(number);
                if let Some(windings) = &mut plane.winding {
                    let winding = s.load_i(&windings[index]);
                    let added = outside.select_i(zero, s.i(record.winding));
                    (winding + added).store(&mut windings[index]);
                }
            }
            e = triple!(|K| e[K] + step[K]);
            depth_here += block_step[0];
        }
        row = triple!(|K| row[K] + step_down[K]);
        row_depth += block_step[1];
    }
}

/// Fills a whole plane, whose first sample is `start` sub-pixels from the
/// record's first pixel. What is there does not matter if `fresh`.
#[inline(always)]
fn fill_whole<S: Lanes>(s: S, plane: Plane, record: &Record, start: [i32; 2], fresh: bool) {
    let (low, high) = (s.f(record.z_low), s.f(record.z_high));
    let in_block = record.depth_in_block(s);
    let mut row_depth = record.depth_at(start);
    let block_step = record.slope.map(|slope| slope * BLOCK_STEP);
    let id = s.i(record.triangle);
    let rows = plane.depth.chunks_exact_mut(BLOCKS);
    for (depths, triangles) in rows.zip(plane.triangle.chunks_exact_mut(BLOCKS)) {
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
    let windings = plane.winding.map(|plane| plane.as_flattened_mut());
    for winding in windings.into_iter().flatten() {
        *winding += record.winding;
    }
}
