//! Ambient occlusion from the depth buffer.
//!
//! Around each pixel the surface is sampled on a spiral; each sample hides
//! light in proportion to how far it rises over the pixel's tangent plane
//! (McGuire et al., *The Alchemy screen-space ambient obscurance algorithm*,
//! HPG 2011). The spiral is turned by a fixed 4x4 pattern, and a 4x4 mean
//! removes that pattern again. Large pictures are sampled at every so manieth
//! pixel; the others take the mean of those next to them that are as deep.

mod grid;
mod openness;
mod spread;

use rayon::prelude::*;

use crate::blend;
use crate::buffers::Buffer;
use crate::camera::View;
use crate::frame::FrameMatrix;
use crate::ground::{Ground, ground_height};
use crate::image::Image;
use crate::pipeline::Renderer;
use crate::prepared::Prepared;
use crate::resolve::tile_rows;
use crate::simd::math::linear_to_srgb_byte;
use crate::simd::{FloatLanes, IntLanes, Kernel, LANES, Lanes, MaskLanes};
use crate::tile::{BLOCK, BLOCKS, OfPixels, TILE};
use grid::Grid;
use openness::openness;
use spread::Spread;

impl Renderer {
    /// How open each pixel of the last frame, which showed `scene` in `view`,
    /// is to light from everywhere: 1 open, 0 hidden; 1 where there is
    /// nothing. O(pixels).
    #[must_use]
    pub fn ambient_occlusion(&self, scene: &Prepared, view: &View) -> Buffer<f32> {
        self.occlusion(scene, view, false)
    }

    /// The same; with a ground that hides light as well.
    pub(crate) fn occlusion(&self, scene: &Prepared, view: &View, on_ground: bool) -> Buffer<f32> {
        let (width, height) = (self.width, self.height);
        let mut values = vec![1.0; width as usize * height as usize];
        self.spread_openness(scene, view, on_ground, &mut values, |open, rows| {
            for (y, row) in rows.iter_mut().enumerate() {
                for (x, to) in row.iter_mut().enumerate() {
                    *to = open[y / BLOCK * BLOCKS + x / BLOCK][y % BLOCK * BLOCK + x % BLOCK];
                }
            }
        });
        Buffer {
            width,
            height,
            values,
        }
    }

    /// Darkens a picture of the last frame by it.
    pub(crate) fn darken(&self, scene: &Prepared, view: &View, on_ground: bool, image: &mut Image) {
        let level = self.level;
        let pixels = &mut image.pixels;
        self.spread_openness(scene, view, on_ground, pixels, |open, rows| {
            level.run(DarkenTile { open, rows });
        });
    }

    /// Calls `change`, for each tile of which not all is open, with the openness
    /// of its pixels and its pieces of the rows of something that has a value a
    /// pixel.
    fn spread_openness<T: Send>(
        &self,
        scene: &Prepared,
        view: &View,
        on_ground: bool,
        values: &mut [T],
        change: impl Fn(&OfPixels<f32>, &mut [&mut [T]]) + Sync,
    ) {
        let (width, height) = (self.width, self.height);
        if width == 0 || height == 0 {
            return;
        }
        let matrix = FrameMatrix::new(view, scene.centre, width, height);
        let ground = if on_ground {
            Ground::new(&matrix, ground_height(scene))
        } else {
            None
        };
        let grid = Grid::new(self, view, &matrix, ground.as_ref());
        let samples = openness(self.level, &grid, &matrix, scene);
        let spread = Spread::new(self, &grid, &samples);
        let columns = (width as usize).div_ceil(TILE);
        let mut tiles = tile_rows(values, width as usize);
        let new_tile = || vec![[1.0; LANES]; BLOCKS * BLOCKS];
        let tiles = tiles.par_iter_mut().enumerate();
        tiles.for_each_init(new_tile, |open, (index, rows)| {
            let origin = [index % columns * TILE, index / columns * TILE];
            if let Some(open) = open.first_chunk_mut()
                && spread.tile(origin, open)
            {
                change(open, rows);
            }
        });
    }
}

/// Darkens the pixels of a tile by their openness.
struct DarkenTile<'a, 'p> {
    open: &'a OfPixels<f32>,
    rows: &'a mut [&'p mut [[u8; 4]]],
}

impl Kernel for DarkenTile<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) {
        let width = self.rows.first().map_or(0, |row| row.len());
        for (by, rows) in self.rows.chunks_mut(BLOCK).enumerate() {
            for bx in 0..width.div_ceil(BLOCK) {
                let open = &self.open[by * BLOCKS + bx];
                if s.load_f(open).lt(s.f(1.0)).bits() != 0 {
                    darken_block(s, open, rows, bx * BLOCK);
                }
            }
        }
    }
}

#[inline(always)]
fn darken_block<S: Lanes>(s: S, open: &[f32; LANES], rows: &mut [&mut [[u8; 4]]], first: usize) {
    let mut linear = [[0.0; LANES]; 3];
    for (y, row) in rows.iter().enumerate() {
        for (x, pixel) in row[first..].iter().take(BLOCK).enumerate() {
            for (lanes, &byte) in linear.iter_mut().zip(pixel) {
                lanes[y * BLOCK + x] = blend::decode(byte);
            }
        }
    }
    let mut bytes = [[0; LANES]; 3];
    for (lanes, bytes) in linear.iter().zip(&mut bytes) {
        let darker = s.load_f(lanes) * s.load_f(open);
        linear_to_srgb_byte(s, darker).round().store(bytes);
    }
    for (y, row) in rows.iter_mut().enumerate() {
        for (x, pixel) in row[first..].iter_mut().take(BLOCK).enumerate() {
            let lane = y * BLOCK + x;
            if open[lane] < 1.0 {
                for (channel, bytes) in pixel.iter_mut().zip(&bytes) {
                    *channel = bytes[lane] as u8;
                }
            }
        }
    }
}

/// Openness as a grey picture, transparent nowhere.
#[must_use]
pub fn occlusion_image(openness: &Buffer<f32>) -> Image {
    let grey = |open: f32| {
        let value = (open * 255.0).round() as u8;
        [value, value, value, 255]
    };
    Image {
        width: openness.width,
        height: openness.height,
        pixels: openness.values.iter().map(|&v| grey(v)).collect(),
    }
}
