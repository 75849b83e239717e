//! From the visibility buffer of a tile to pixels.

use csg::Color;

use crate::deferred::{Batch, Job, shade};
use crate::shading::ShadeContext;
use crate::simd::math::linear_to_srgb_byte;
use crate::simd::vector::{Triple, Triple16, load, splat};
use crate::simd::{FloatLanes, IntLanes, Kernel, LANES, Lanes, Level, MaskLanes, triple};
use crate::tile::{
    BLOCK, BLOCKS, MOST_SAMPLES, NO_TRIANGLE, OfPixels, TILE, TileBuffer, part_block,
};

/// Shades a tile into the pieces of the picture's rows that it covers.
pub(crate) struct ResolveTile<'a, 'p> {
    pub context: &'a ShadeContext<'a>,
    pub tile: &'a TileBuffer<'a>,
    /// First pixel of the tile in the picture.
    pub origin: [usize; 2],
    pub rows: &'a mut [&'p mut [[u8; 4]]],
    pub background: Color,
    pub scratch: &'a mut Scratch,
}

/// Memory that goes from tile to tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub batch: Batch,
    /// For each job of the batch, the share of each pixel that it colours.
    pub shares: Vec<[f32; LANES]>,
}

/// What is known of the 16 pixels of a block before they are encoded.
#[derive(Clone, Copy, Default)]
pub(crate) struct Block {
    /// Its jobs in the batch.
    pub first_job: usize,
    pub jobs: usize,
    /// Bits of the pixels that triangles cover, at least in part.
    covered: u32,
    /// Whether there may be pixels of several triangles, or covered in part.
    mixed: bool,
}

impl ResolveTile<'_, '_> {
    /// Does so, and returns the number of pixels that show a triangle. Each
    /// pass is compiled by itself: together they need more registers than
    /// there are.
    pub fn run(self, level: Level) -> u64 {
        let background = encode(self.background);
        if !self.tile.tile.drawn {
            for row in self.rows.iter_mut() {
                row.fill(background);
            }
            return 0;
        }
        let mut shaded = 0;
        let height = self.rows.len();
        let width = self.rows.first().map_or(0, |row| row.len());
        let Scratch { batch, shares } = self.scratch;
        batch.cache.clear();
        let mut blocks = [Block::default(); BLOCKS];
        for by in 0..height.div_ceil(BLOCK) {
            batch.jobs.clear();
            shares.clear();
            let blocks = &mut blocks[..width.div_ceil(BLOCK)];
            shaded += level.run(FindJobs {
                numbers: self.tile.triangle,
                in_quads: self.tile.in_quads(),
                origin: self.origin,
                by,
                blocks,
                batch,
                shares,
            });
            shade(level, self.context, batch);
            let end = (by * BLOCK + BLOCK).min(height);
            level.run(EncodeBlocks {
                blocks,
                colours: &batch.colours,
                shares,
                background: self.background,
                encoded_background: background,
                rows: &mut self.rows[by * BLOCK..end],
            });
        }
        shaded
    }
}

/// Lists what is to be shaded in a row of blocks.
pub(crate) struct FindJobs<'a> {
    /// The triangles of the tile, a plane for each sample; or for four of them,
    /// in blocks of 2x2 pixels.
    pub numbers: &'a [OfPixels<i32>],
    pub in_quads: bool,
    pub origin: [usize; 2],
    /// Number of the row in the tile.
    pub by: usize,
    pub blocks: &'a mut [Block],
    pub batch: &'a mut Batch,
    pub shares: &'a mut Vec<[f32; LANES]>,
}

impl Kernel for FindJobs<'_> {
    /// Pixels that show a triangle.
    type Output = u64;
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) -> u64 {
        let mut shaded = 0;
        for (bx, block) in self.blocks.iter_mut().enumerate() {
            let at = [
                self.origin[0] + bx * BLOCK,
                self.origin[1] + self.by * BLOCK,
            ];
            let index = self.by * BLOCKS + bx;
            let samples = self.numbers.len();
            let (batch, shares) = (&mut *self.batch, &mut *self.shares);
            *block = if self.in_quads {
                let parted = part_block(s, self.numbers, index);
                find_jobs(s, samples, |k| &parted[k % MOST_SAMPLES], at, batch, shares)
            } else {
                find_jobs(s, samples, |k| &self.numbers[k][index], at, batch, shares)
            };
            shaded += u64::from(block.covered.count_ones());
        }
        shaded
    }
}

/// Writes a row of blocks into the picture.
struct EncodeBlocks<'a, 'p> {
    blocks: &'a [Block],
    colours: &'a [Triple16],
    shares: &'a [[f32; LANES]],
    background: Color,
    encoded_background: [u8; 4],
    /// The rows of pixels, of which there are fewer at the lower edge.
    rows: &'a mut [&'p mut [[u8; 4]]],
}

impl Kernel for EncodeBlocks<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) {
        for (bx, block) in self.blocks.iter().enumerate() {
            let colours = &self.colours[block.first_job..];
            let shares = &self.shares[block.first_job..];
            let pixels = encode_block(
                s,
                block,
                colours,
                shares,
                self.background,
                self.encoded_background,
            );
            for (from, row) in pixels.chunks_exact(BLOCK).zip(self.rows.iter_mut()) {
                copy_row(from, &mut row[bx * BLOCK..]);
            }
        }
    }
}

/// Copies a row of a block, as far as it is inside the picture.
#[inline(always)]
fn copy_row(from: &[i32], to: &mut [[u8; 4]]) {
    if let (Some(to), Some(from)) = (to.first_chunk_mut::<BLOCK>(), from.first_chunk::<BLOCK>()) {
        *to = from.map(i32::to_le_bytes);
    } else {
        for (pixel, lane) in to.iter_mut().zip(from) {
            *pixel = lane.to_le_bytes();
        }
    }
}

/// Lists what is to be shaded in one block: one job where every pixel shows
/// one triangle, up to one for each sample elsewhere.
#[inline(always)]
fn find_jobs<'a, S: Lanes>(
    s: S,
    samples: usize,
    numbers: impl Fn(usize) -> &'a [i32; LANES],
    at: [usize; 2],
    batch: &mut Batch,
    shares: &mut Vec<[f32; LANES]>,
) -> Block {
    let none = s.i(NO_TRIANGLE);
    let first_lanes = numbers(0);
    let first = s.load_i(first_lanes);
    let mut alike = 0xffff;
    let mut covered = !first.eq(none).bits() & 0xffff;
    for sample in 1..samples {
        let other = s.load_i(numbers(sample));
        alike &= other.eq(first).bits();
        covered |= !other.eq(none).bits() & 0xffff;
    }
    let mut block = Block {
        first_job: batch.jobs.len(),
        jobs: 0,
        covered,
        mixed: alike != 0xffff,
    };
    if covered == 0 {
        return block;
    }
    if !block.mixed {
        block.jobs = 1;
        batch.jobs.push(Job {
            triangles: *first_lanes,
            wanted: covered,
            at,
        });
        shares.push([1.0; LANES]);
        return block;
    }
    // Each triangle of a pixel is shaded once, and counts for as many samples
    // as show it.
    let zero = s.f(0.0);
    let weight = s.f(1.0 / samples as f32);
    for k in 0..samples {
        let lanes = numbers(k);
        let triangle = s.load_i(lanes);
        let mut fresh = !triangle.eq(none).bits() & 0xffff;
        let mut shown = zero;
        for other in 0..samples {
            let same = s.load_i(numbers(other)).eq(triangle);
            if other < k {
                fresh &= !same.bits();
            }
            shown = shown + same.select_f(weight, zero);
        }
        if fresh == 0 {
            continue;
        }
        let mut share = [0.0; LANES];
        s.mask(fresh).select_f(shown, zero).store(&mut share);
        block.jobs += 1;
        batch.jobs.push(Job {
            triangles: *lanes,
            wanted: fresh,
            at,
        });
        shares.push(share);
    }
    block
}

#[inline(always)]
fn clamped<S: Lanes>(s: S, colour: &Triple16) -> Triple<S> {
    let (zero, one) = (s.f(0.0), s.f(1.0));
    let colour = load(s, colour);
    triple!(|K| colour[K].max(zero).min(one))
}

/// Adds up the colours of a block's jobs, puts the background behind them,
/// and encodes the pixels as little-endian RGBA.
#[inline(always)]
fn encode_block<S: Lanes>(
    s: S,
    block: &Block,
    colours: &[Triple16],
    shares: &[[f32; LANES]],
    background: Color,
    encoded_background: [u8; 4],
) -> [i32; LANES] {
    let plain = s.i(i32::from_le_bytes(encoded_background));
    let mut pixels = [0; LANES];
    if block.covered == 0 {
        plain.store(&mut pixels);
        return pixels;
    }
    let (zero, one) = (s.f(0.0), s.f(1.0));
    let mut alpha = s.i(255).shl::<24>();
    let linear = if block.mixed {
        let mut sum = [zero; 3];
        let mut total = zero;
        for (colour, share) in colours.iter().zip(shares).take(block.jobs) {
            let share = s.load_f(share);
            let here = zero.lt(share);
            let colour = clamped(s, colour);
            sum = triple!(|K| sum[K] + here.select_f(colour[K] * share, zero));
            total = total + share;
        }
        let behind = s.f(background.alpha) * (one - total).max(zero);
        let opacity = total + behind;
        let divisor = zero.lt(opacity).select_f(opacity, one);
        let rgb = splat(s, background.rgb.into());
        alpha = (opacity.min(one) * s.f(255.0)).round().shl::<24>();
        triple!(|K| (sum[K] + rgb[K] * behind) / divisor)
    } else {
        load(s, &colours[0])
    };
    let byte = triple!(|K| linear_to_srgb_byte(s, linear[K]).round());
    let pixel = (byte[0] | byte[1].shl::<8>()) | (byte[2].shl::<16>() | alpha);
    // Uncovered pixels keep the exact background.
    s.mask(block.covered)
        .select_i(pixel, plain)
        .store(&mut pixels);
    pixels
}

/// A linear colour as an 8-bit sRGB pixel.
pub(crate) fn encode(color: Color) -> [u8; 4] {
    let [r, g, b] = color.to_srgb();
    [r, g, b, color.alpha].map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// Cuts a picture, or what has as many values, into the row pieces of its tiles,
/// tile by tile.
pub(crate) fn tile_rows<T>(pixels: &mut [T], width: usize) -> Vec<Vec<&mut [T]>> {
    let mut tiles = Vec::new();
    for strip in pixels.chunks_mut(width.max(1) * TILE) {
        let first = tiles.len();
        tiles.resize_with(first + width.div_ceil(TILE), || Vec::with_capacity(TILE));
        for row in strip.chunks_mut(width) {
            for (tile, piece) in tiles[first..].iter_mut().zip(row.chunks_mut(TILE)) {
                tile.push(piece);
            }
        }
    }
    tiles
}
