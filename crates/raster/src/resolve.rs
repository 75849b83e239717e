//! From the visibility buffer of a tile to pixels.

use csg::Color;

use crate::deferred::{Batch, Job, ShadeContext, Triple16, shade};
use crate::simd::math::linear_to_srgb;
use crate::simd::{FloatLanes, IntLanes, Kernel, LANES, Lanes, MaskLanes, triple};
use crate::tile::{BLOCK, BLOCKS, NO_TRIANGLE, TILE, Tile};

/// Shades a tile into the pieces of the picture's rows that it covers.
pub(crate) struct ResolveTile<'a, 'p> {
    pub context: &'a ShadeContext<'a>,
    pub tile: &'a Tile,
    /// First pixel of the tile in the picture.
    pub origin: [usize; 2],
    pub rows: &'a mut [&'p mut [[u8; 4]]],
    pub background: Color,
}

/// What is known of the 16 pixels of a block before they are encoded.
#[derive(Clone, Copy)]
struct Block {
    /// Linear colour, times `share`.
    sum: Triple16,
    /// The part of each pixel that triangles cover.
    share: [f32; LANES],
    /// Bits of the pixels of which `share` is not 0.
    covered: u32,
    /// Bits of the pixels of which it is neither 0 nor 1.
    partial: u32,
}

const EMPTY: Block = Block {
    sum: [[0.0; LANES]; 3],
    share: [0.0; LANES],
    covered: 0,
    partial: 0,
};

/// The job of shading a part of a block.
struct Part {
    block: usize,
    /// The share of each pixel that the job colours.
    share: [f32; LANES],
}

impl Kernel for ResolveTile<'_, '_> {
    /// Pixels that show a triangle.
    type Output = u64;
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) -> u64 {
        let background = encode(self.background);
        if !self.tile.drawn {
            for row in self.rows.iter_mut() {
                row.fill(background);
            }
            return 0;
        }
        let mut shaded = 0;
        let height = self.rows.len();
        let width = self.rows.first().map_or(0, |row| row.len());
        let mut batch = Batch::default();
        let mut parts = Vec::new();
        let mut pixels = [[0i32; LANES]; BLOCKS];
        for by in 0..height.div_ceil(BLOCK) {
            batch.jobs.clear();
            parts.clear();
            let mut blocks = [EMPTY; BLOCKS];
            let columns = width.div_ceil(BLOCK);
            for (bx, block) in blocks[..columns].iter_mut().enumerate() {
                let at = [self.origin[0] + bx * BLOCK, self.origin[1] + by * BLOCK];
                self.find_jobs(s, by * BLOCKS + bx, bx, at, block, &mut batch, &mut parts);
                shaded += u64::from(block.covered.count_ones());
            }
            shade(s, self.context, &mut batch);
            add_up(s, &batch, &parts, &mut blocks);
            self.encode_blocks(s, &blocks[..columns], &mut pixels, background);
            for (y, row) in self.rows[by * BLOCK..].iter_mut().take(BLOCK).enumerate() {
                for (to, from) in row.chunks_mut(BLOCK).zip(&pixels) {
                    for (pixel, lane) in to.iter_mut().zip(&from[y * BLOCK..]) {
                        *pixel = lane.to_le_bytes();
                    }
                }
            }
        }
        shaded
    }
}

impl ResolveTile<'_, '_> {
    /// Lists what is to be shaded in one block: one job where every pixel
    /// shows one triangle, up to one for each sample elsewhere.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "the state of one loop")]
    fn find_jobs<S: Lanes>(
        &self,
        s: S,
        index: usize,
        bx: usize,
        at: [usize; 2],
        block: &mut Block,
        batch: &mut Batch,
        parts: &mut Vec<Part>,
    ) {
        let planes = &self.tile.planes;
        let none = s.i(NO_TRIANGLE);
        let first_lanes = &planes[0].triangle[index];
        let first = s.load_i(first_lanes);
        let mut alike = 0xffff;
        let mut covered = !first.eq(none).bits() & 0xffff;
        for plane in &planes[1..] {
            let other = s.load_i(&plane.triangle[index]);
            alike &= other.eq(first).bits();
            covered |= !other.eq(none).bits() & 0xffff;
        }
        block.covered = covered;
        if covered == 0 {
            return;
        }
        let (zero, one) = (s.f(0.0), s.f(1.0));
        let mut share = [0.0; LANES];
        if alike == 0xffff {
            s.mask(covered).select_f(one, zero).store(&mut share);
            block.share = share;
            batch.jobs.push(Job {
                triangles: *first_lanes,
                wanted: covered,
                at,
            });
            parts.push(Part { block: bx, share });
            return;
        }
        // Each triangle of a pixel is shaded once, and counts for as many
        // samples as show it.
        let weight = s.f(1.0 / planes.len() as f32);
        let mut total = zero;
        for (k, plane) in planes.iter().enumerate() {
            let lanes = &plane.triangle[index];
            let triangle = s.load_i(lanes);
            let mut fresh = !triangle.eq(none).bits() & 0xffff;
            let mut samples = zero;
            for (other_k, other) in planes.iter().enumerate() {
                let same = s.load_i(&other.triangle[index]).eq(triangle);
                if other_k < k {
                    fresh &= !same.bits();
                }
                samples = samples + same.select_f(weight, zero);
            }
            if fresh == 0 {
                continue;
            }
            let part = s.mask(fresh).select_f(samples, zero);
            total = total + part;
            part.store(&mut share);
            batch.jobs.push(Job {
                triangles: *lanes,
                wanted: fresh,
                at,
            });
            parts.push(Part { block: bx, share });
        }
        total.store(&mut block.share);
        block.partial = covered & total.lt(one).bits();
    }

    /// Puts the background behind the blocks of a row and encodes them as
    /// little-endian RGBA.
    #[inline(always)]
    fn encode_blocks<S: Lanes>(
        &self,
        s: S,
        blocks: &[Block],
        pixels: &mut [[i32; LANES]; BLOCKS],
        background: [u8; 4],
    ) {
        let (zero, one) = (s.f(0.0), s.f(1.0));
        let plain = s.i(i32::from_le_bytes(background));
        let opaque = s.i(255).shl::<24>();
        for (block, pixels) in blocks.iter().zip(pixels) {
            if block.covered == 0 {
                plain.store(pixels);
                continue;
            }
            let mut linear = [
                s.load_f(&block.sum[0]),
                s.load_f(&block.sum[1]),
                s.load_f(&block.sum[2]),
            ];
            let mut alpha = opaque;
            if block.partial != 0 {
                let share = s.load_f(&block.share);
                let behind = s.f(self.background.alpha) * (one - share).max(zero);
                let opacity = share + behind;
                let divisor = zero.lt(opacity).select_f(opacity, one);
                let rgb = splat3(s, self.background.rgb);
                linear = triple!(|K| (linear[K] + rgb[K] * behind) / divisor);
                alpha = (opacity.min(one) * s.f(255.0)).round().shl::<24>();
            }
            let byte = triple!(|K| (linear_to_srgb(s, linear[K]) * s.f(255.0)).round());
            let pixel = (byte[0] | byte[1].shl::<8>()) | (byte[2].shl::<16>() | alpha);
            // Uncovered pixels keep the exact background.
            s.mask(block.covered).select_i(pixel, plain).store(pixels);
        }
    }
}

#[inline(always)]
fn splat3<S: Lanes>(s: S, [r, g, b]: [f32; 3]) -> [S::F; 3] {
    [s.f(r), s.f(g), s.f(b)]
}

/// Adds the colours of the jobs to the blocks they belong to.
#[inline(always)]
fn add_up<S: Lanes>(s: S, batch: &Batch, parts: &[Part], blocks: &mut [Block; BLOCKS]) {
    let (zero, one) = (s.f(0.0), s.f(1.0));
    for (part, colour) in parts.iter().zip(&batch.colours) {
        let share = s.load_f(&part.share);
        let here = zero.lt(share);
        for (sum, c) in blocks[part.block].sum.iter_mut().zip(colour) {
            let light = s.load_f(c).max(zero).min(one);
            let added = here.select_f(light * share, zero);
            (s.load_f(sum) + added).store(sum);
        }
    }
}

/// A linear colour as an 8-bit sRGB pixel.
pub(crate) fn encode(color: Color) -> [u8; 4] {
    let [r, g, b] = color.to_srgb();
    [r, g, b, color.alpha].map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// Cuts a picture into the row pieces of its tiles, tile by tile.
pub(crate) fn tile_rows(pixels: &mut [[u8; 4]], width: usize) -> Vec<Vec<&mut [[u8; 4]]>> {
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
