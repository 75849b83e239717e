//! From the openness of samples to that of pixels.

use super::grid::Grid;
use crate::fill::{LANE_X, LANE_Y};
use crate::pipeline::Renderer;
use crate::simd::{FloatLanes, IntLanes, Kernel, LANES, Lanes, MaskLanes};
use crate::tile::{BLOCK, BLOCKS, OfPixels};

/// Openness of samples, and of all pixels between those: the mean of the samples
/// around each that are about as deep.
pub(super) struct Spread<'a> {
    renderer: &'a Renderer,
    grid: &'a Grid,
    /// Of the samples, row by row.
    samples: &'a [f32],
    /// Samples in a row.
    stride: usize,
    /// Depths so far apart count half.
    same: f32,
}

impl<'a> Spread<'a> {
    pub fn new(renderer: &'a Renderer, grid: &'a Grid, samples: &'a [f32]) -> Self {
        let (near, far) = grid.depth_range();
        Self {
            renderer,
            grid,
            samples,
            stride: samples.len() / grid.height.max(1),
            same: (near - far).max(1e-6) * 3e-3,
        }
    }

    /// Finds that of the pixels of a tile, which is 1 where there is nothing, and
    /// returns whether any is not 1.
    pub fn tile(&self, origin: [usize; 2], to: &mut OfPixels<f32>) -> bool {
        self.renderer.level.run(SpreadTile {
            spread: self,
            origin,
            to,
        })
    }
}

struct SpreadTile<'a, 'b> {
    spread: &'a Spread<'b>,
    origin: [usize; 2],
    to: &'a mut OfPixels<f32>,
}

impl Kernel for SpreadTile<'_, '_> {
    type Output = bool;
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) -> bool {
        let mut any = false;
        for (index, to) in self.to.iter_mut().enumerate() {
            let x = self.origin[0] + index % BLOCKS * BLOCK;
            let y = self.origin[1] + index / BLOCKS * BLOCK;
            *to = [1.0; LANES];
            if let Some(depths) = self.spread.renderer.depths_of_block(x, y) {
                any |= block(s, self.spread, [x, y], &depths, to);
            }
        }
        any
    }
}

/// The same for one block of pixels.
#[inline(always)]
fn block<S: Lanes>(
    s: S,
    spread: &Spread,
    at: [usize; 2],
    depths: &[f32; LANES],
    to: &mut [f32; LANES],
) -> bool {
    let Spread { grid, samples, .. } = *spread;
    if grid.step == 1 {
        return pixel_by_pixel(spread, at, depths, to);
    }
    let (zero, one) = (s.f(0.0), s.f(1.0));
    let depth = s.load_f(depths);
    let is_there = zero.lt(depth);
    let step = grid.step;
    let first = at.map(|v| v / step);
    // Samples a block lies between, each way.
    let count = (BLOCK - 1) / step + 2;
    let per_step = s.f(1.0 / step as f32);
    let x = (s.load_i(&LANE_X) + s.i((at[0] % step) as i32)).to_float() * per_step;
    let y = (s.load_i(&LANE_Y) + s.i((at[1] % step) as i32)).to_float() * per_step;
    let last = [grid.width - 1, grid.height - 1];
    let (mut sum, mut total) = (zero, zero);
    for j in 0..count {
        let near_y = near(s, y, j);
        let row = (first[1] + j).min(last[1]);
        for i in 0..count {
            let column = (first[0] + i).min(last[0]);
            let other = grid.depth(column, row);
            if other == 0.0 {
                continue;
            }
            let apart = depth - s.f(other);
            let apart = apart.max(zero - apart);
            let alike = s.f(spread.same) / (s.f(spread.same) + apart);
            let weight = (near_y * near(s, x, i) + s.f(1e-3)) * alike;
            sum = sum + s.f(samples[row * spread.stride + column]) * weight;
            total = total + weight;
        }
    }
    let open = (is_there & zero.lt(total)).select_f(sum / total, one);
    open.store(to);
    open.lt(one).bits() != 0
}

/// 1 at the k-th sample, 0 at those next to it.
#[inline(always)]
fn near<S: Lanes>(s: S, at: S::F, k: usize) -> S::F {
    let away = at - s.f(k as f32);
    (s.f(1.0) - away.max(s.f(0.0) - away)).max(s.f(0.0))
}

/// The same where each pixel is a sample.
fn pixel_by_pixel(
    spread: &Spread,
    [x, y]: [usize; 2],
    depths: &[f32; LANES],
    to: &mut [f32; LANES],
) -> bool {
    for (lane, open) in to.iter_mut().enumerate() {
        let (x, y) = (x + lane % BLOCK, y + lane / BLOCK);
        if depths[lane] > 0.0 && x < spread.grid.width && y < spread.grid.height {
            *open = spread.samples[y * spread.stride + x];
        }
    }
    to.iter().any(|&open| open < 1.0)
}
