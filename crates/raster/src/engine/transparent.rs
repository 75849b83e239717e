//! What is seen through: all of it at each sample, sorted by depth, so that
//! parts that run through each other are right (the A-buffer; Carpenter, *The
//! A-buffer, an antialiased hidden surface method*, SIGGRAPH 1984).
//!
//! Opaque triangles are drawn first. Samples of the others are collected as
//! fragments, in front of what is opaque ordered from near to far, and blended
//! layer by layer: the nearest fragments of all samples are shaded together,
//! then the second ones, and so on. Fragments count at their own sample only,
//! so that outlines are as smooth as those of opaque parts.

use std::cmp::Ordering;

use crate::blend;
use crate::deferred::{Job, shade};
use crate::fill::Record;
use crate::fixed::SUBPIXELS;
use crate::resolve::{Block, FindJobs, ResolveTile, Scratch};
use crate::shading::ShadeContext;
use crate::simd::{LANES, Level};
use crate::tile::{BLOCK, BLOCK_PIXELS, BLOCKS, NO_TRIANGLE, OfPixels, TILE, TileBuffer, decode};

/// A sample of a triangle that is seen through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fragment {
    /// Sixteen times its block in the tile, plus its lane in the block.
    pixel: u16,
    sample: u8,
    /// What it adds to windings: 0 for a cap.
    pub winding: i8,
    /// Reversed.
    depth: f32,
    /// The number of the triangle, or of the cap.
    pub triangle: i32,
}

impl Fragment {
    /// The cap of a section at the place of another fragment.
    pub fn cap(self, depth: f32, number: i32) -> Self {
        Self {
            winding: 0,
            depth,
            triangle: number,
            ..self
        }
    }

    /// The plane of its sample, and the place in it.
    pub fn place(&self) -> (usize, usize) {
        (usize::from(self.sample), usize::from(self.pixel))
    }

    /// By place, then from near to far; equal depths as they are drawn.
    pub fn order(&self, other: &Self) -> Ordering {
        let nearer = other.depth.total_cmp(&self.depth);
        let place = self.place().cmp(&other.place());
        place.then(nearer).then(self.triangle.cmp(&other.triangle))
    }
}

/// Adds the samples of a tile that records cover to its fragments, and to its
/// windings where these are counted.
pub(crate) fn collect<'a>(
    tile: &mut TileBuffer,
    origin: [i32; 2],
    records: impl Iterator<Item = &'a Record>,
    samples: &[[i32; 2]],
) {
    let Some(fragments) = &mut tile.fragments else {
        return;
    };
    let last = TILE as i32 - 1;
    for record in records {
        let range = |v: [i16; 2], axis: usize| {
            let [low, high] = v.map(|v| i32::from(v) - origin[axis]);
            low.max(0)..=high.min(last)
        };
        let first = [record.x[0], record.y[0]].map(i32::from);
        for y in range(record.y, 1) {
            for x in range(record.x, 0) {
                for (k, sample) in samples.iter().enumerate() {
                    let at = [
                        (x + origin[0] - first[0]) * SUBPIXELS + sample[0],
                        (y + origin[1] - first[1]) * SUBPIXELS + sample[1],
                    ];
                    let covered = (0..3).all(|k| {
                        let (right, down) = (i64::from(record.right[k]), i64::from(record.down[k]));
                        record.c[k] + right * i64::from(at[0]) + down * i64::from(at[1]) >= 0
                    });
                    if covered {
                        let (x, y) = (x as usize, y as usize);
                        let block = y / BLOCK * BLOCKS + x / BLOCK;
                        let depth = record.depth_at(at) as f32;
                        fragments.push(Fragment {
                            pixel: (block * BLOCK_PIXELS + y % BLOCK * BLOCK + x % BLOCK) as u16,
                            sample: k as u8,
                            winding: record.winding as i8,
                            depth: depth.max(record.z_low).min(record.z_high),
                            triangle: record.triangle,
                        });
                        if let Some(windings) = tile.winding.get_mut(k) {
                            windings[block][y % BLOCK * BLOCK + x % BLOCK] += record.winding;
                        }
                    }
                }
            }
        }
    }
}

/// What has been blended of one sample: premultiplied colour, and the share of
/// light that what is behind still adds.
#[derive(Clone, Copy)]
struct Blended {
    rgb: [f32; 3],
    through: f32,
}

impl ResolveTile<'_, '_> {
    /// [`ResolveTile::run`] for a tile in which something is seen through.
    pub fn run_transparent(self, level: Level, samples: &[[i32; 2]]) -> u64 {
        let (samples, pixels) = (samples.len(), TILE * TILE);
        let layers = self.layers(samples);
        let clear = Blended {
            rgb: [0.0; 3],
            through: 1.0,
        };
        let mut blended = vec![clear; samples * pixels];
        let mut shown = vec![false; pixels];
        for numbers in layers
            .iter()
            .map(Vec::as_slice)
            .chain([&*self.tile.triangle])
        {
            for (plane, blended) in numbers.iter().zip(blended.chunks(pixels)) {
                let numbers = plane.as_flattened().iter().zip(blended);
                for (shown, (&number, blended)) in shown.iter_mut().zip(numbers) {
                    *shown |= number != NO_TRIANGLE && blended.through > 0.0;
                }
            }
            let mut blocks = [Block::default(); BLOCKS];
            for by in 0..BLOCKS {
                let Scratch { batch, shares } = &mut *self.scratch;
                batch.jobs.clear();
                shares.clear();
                batch.cache.clear();
                level.run(FindJobs {
                    numbers,
                    in_quads: false,
                    origin: self.origin,
                    by,
                    blocks: &mut blocks,
                    batch,
                    shares,
                });
                shade(level, self.context, batch);
                for (bx, block) in blocks.iter().enumerate() {
                    let jobs = block.first_job..block.first_job + block.jobs;
                    for (job, colours) in batch.jobs[jobs.clone()].iter().zip(&batch.colours[jobs])
                    {
                        let index = by * BLOCKS + bx;
                        blend_job(self.context, job, colours, numbers, index, &mut blended);
                    }
                }
            }
        }
        self.write(&blended, samples);
        shown.into_iter().filter(|&shown| shown).count() as u64
    }

    /// For each rank, from the nearest fragments to the farthest, the numbers
    /// of all samples, a plane each.
    fn layers(&self, samples: usize) -> Vec<Vec<OfPixels<i32>>> {
        let mut fragments = self.tile.fragments.as_deref().cloned().unwrap_or_default();
        let kept = self.context.scene.kept_triangles;
        // Equal depths show what was drawn first. Nothing is before an opaque cap,
        // up to rounding.
        fragments.retain(|f| {
            let (plane, at) = f.place();
            let depth = self.tile.depth[plane].as_flattened()[at];
            let number = self.tile.triangle[plane].as_flattened()[at];
            let (triangle, section) = decode(f.triangle);
            let is_shown = (section.is_some() || triangle < kept) && decode(number).1.is_none();
            is_shown && (f.depth > depth || (f.depth == depth && f.triangle < number))
        });
        fragments.sort_unstable_by(Fragment::order);
        let mut layers: Vec<Vec<OfPixels<i32>>> = Vec::new();
        let groups = fragments.chunk_by(|a, b| a.place() == b.place());
        for group in groups {
            for (rank, fragment) in group.iter().enumerate() {
                if rank == layers.len() {
                    let none = [[NO_TRIANGLE; BLOCK_PIXELS]; BLOCKS * BLOCKS];
                    layers.push(vec![none; samples]);
                }
                let plane = &mut layers[rank][usize::from(fragment.sample)];
                plane.as_flattened_mut()[usize::from(fragment.pixel)] = fragment.triangle;
            }
        }
        layers
    }

    /// Encodes the mean of each pixel's samples, the background behind them.
    fn write(self, blended: &[Blended], samples: usize) {
        let weight = 1.0 / samples as f32;
        for (y, row) in self.rows.iter_mut().enumerate() {
            for (x, pixel) in row.iter_mut().enumerate() {
                let block = y / BLOCK * BLOCKS + x / BLOCK;
                let at = block * BLOCK_PIXELS + y % BLOCK * BLOCK + x % BLOCK;
                let (mut rgb, mut through) = ([0.0; 3], 0.0);
                for plane in blended.chunks(TILE * TILE) {
                    through += plane[at].through * weight;
                    for (sum, colour) in rgb.iter_mut().zip(plane[at].rgb) {
                        *sum += colour * weight;
                    }
                }
                let behind = through * self.background.alpha;
                let opacity = 1.0 - through + behind;
                for (sum, color) in rgb.iter_mut().zip(self.background.rgb) {
                    *sum = (*sum + color * behind) / opacity.max(f32::MIN_POSITIVE);
                }
                let [r, g, b] = rgb.map(blend::encode);
                *pixel = [r, g, b, (opacity.min(1.0) * 255.0).round() as u8];
            }
        }
    }
}

/// Puts the colours of a job behind what is there, at all samples that show
/// its triangles.
fn blend_job(
    context: &ShadeContext,
    job: &Job,
    colours: &[[f32; LANES]; 3],
    numbers: &[OfPixels<i32>],
    block: usize,
    blended: &mut [Blended],
) {
    for lane in (0..LANES).filter(|lane| job.wanted >> lane & 1 != 0) {
        let number = job.triangles[lane];
        let opacity = context.opacity(decode(number).0).clamp(0.0, 1.0);
        let at = block * BLOCK_PIXELS + lane;
        for (k, plane) in numbers.iter().enumerate() {
            let to = &mut blended[k * TILE * TILE + at];
            if plane.as_flattened()[at] == number && to.through > 0.0 {
                let share = to.through * opacity;
                for (sum, colour) in to.rgb.iter_mut().zip(colours) {
                    *sum += colour[lane].clamp(0.0, 1.0) * share;
                }
                to.through *= 1.0 - opacity;
            }
        }
    }
}
