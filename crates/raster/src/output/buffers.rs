//! What the visibility buffer of the last frame says besides the picture:
//! depth, triangles, surfaces, normals, and the point under a pixel.

use glam::{DVec2, DVec3, Vec3};

use crate::camera::View;

use crate::frame::FrameMatrix;
use crate::interpolant::weights_at;
use crate::pipeline::Renderer;
use crate::prepared::Prepared;
use crate::section::Section;
use crate::tile::{BLOCK, BLOCK_PIXELS, BLOCKS, TILE, decode};
use crate::viewport::{Viewport, integer_depth};

/// One value for each pixel, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Buffer<T> {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` values, the top row first.
    pub values: Vec<T>,
}

impl<T: Copy> Buffer<T> {
    /// The value in column `x` and row `y` from the top, if it is inside.
    #[must_use]
    pub fn get(&self, x: u32, y: u32) -> Option<T> {
        if x >= self.width {
            return None;
        }
        let index = y as usize * self.width as usize + x as usize;
        self.values.get(index).copied()
    }
}

/// What lies under a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// The point on the surface, in world coordinates.
    pub point: DVec3,
    /// The triangle of the mesh.
    pub triangle: u32,
    /// The triangle's surface, an index into [`csg::Mesh::surfaces`], if the
    /// mesh has them.
    pub surface: Option<u32>,
}

impl Renderer {
    /// Triangle and reversed depth of a pixel's first sample.
    pub(crate) fn sample(&self, x: u32, y: u32) -> Option<(u32, f32)> {
        let (number, depth) = self.number(x, y)?;
        Some((decode(number).0 as u32, depth))
    }

    /// What [`decode`] reads, and reversed depth, of a pixel's first sample.
    pub(crate) fn number(&self, x: u32, y: u32) -> Option<(i32, f32)> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let scale = self.scale.max(1) as usize;
        let (x, y) = (
            x as usize * scale + scale / 2,
            y as usize * scale + scale / 2,
        );
        let columns = (self.width as usize * scale).div_ceil(TILE);
        let tile = y / TILE * columns + x / TILE;
        self.tiles.first_sample(tile, x % TILE, y % TILE)
    }

    /// The reversed depths of a block of pixels, given the first one, where this is
    /// a tile's; `None` where there is nothing.
    pub(crate) fn depths_of_block(&self, x: usize, y: usize) -> Option<[f32; BLOCK_PIXELS]> {
        if self.scale == 1 {
            let tile = y / TILE * (self.width as usize).div_ceil(TILE) + x / TILE;
            let block = y % TILE / BLOCK * BLOCKS + x % TILE / BLOCK;
            return self.tiles.block_depths(tile, block).copied();
        }
        let mut depths = [0.0; BLOCK_PIXELS];
        for (lane, depth) in depths.iter_mut().enumerate() {
            let (x, y) = (x + lane % BLOCK, y + lane / BLOCK);
            *depth = self
                .number(x as u32, y as u32)
                .map_or(0.0, |(_, depth)| depth);
        }
        depths.iter().any(|&depth| depth > 0.0).then_some(depths)
    }

    fn buffer<T: Copy>(&self, value: impl Fn(Option<(u32, f32)>, u32, u32) -> T) -> Buffer<T> {
        let mut values = Vec::with_capacity(self.width as usize * self.height as usize);
        for y in 0..self.height {
            for x in 0..self.width {
                values.push(value(self.sample(x, y), x, y));
            }
        }
        Buffer {
            width: self.width,
            height: self.height,
            values,
        }
    }

    /// The window depth of the last frame: 0 at the near plane, 1 at the far
    /// plane and where there is nothing.
    #[must_use]
    pub fn depth_buffer(&self) -> Buffer<f32> {
        self.buffer(|sample, _, _| sample.map_or(1.0, |(_, depth)| 1.0 - depth))
    }

    /// The window depth of the last frame as numbers of so many bits (1..=32),
    /// 0 near to 2^bits - 1 far ([`integer_depth`]).
    #[must_use]
    pub fn integer_depth_buffer(&self, bits: u32) -> Buffer<u32> {
        self.buffer(|sample, _, _| {
            let depth = sample.map_or(1.0, |(_, depth)| 1.0 - f64::from(depth));
            integer_depth(depth, bits)
        })
    }

    /// The reversed depth of the last frame: 1 at the near plane, 0 at the
    /// far plane and where there is nothing; exact where window depth is
    /// rounded.
    #[must_use]
    pub fn reversed_depth_buffer(&self) -> Buffer<f32> {
        self.buffer(|sample, _, _| sample.map_or(0.0, |(_, depth)| depth))
    }

    /// The number of the triangle that each pixel of the last frame shows.
    #[must_use]
    pub fn triangle_buffer(&self) -> Buffer<Option<u32>> {
        self.buffer(|sample, _, _| sample.map(|(triangle, _)| triangle))
    }

    /// The index into [`csg::Mesh::surfaces`] that each pixel of the last
    /// frame shows; `None` also for a mesh without surfaces.
    #[must_use]
    pub fn surface_buffer(&self, scene: &Prepared) -> Buffer<Option<u32>> {
        self.buffer(|sample, _, _| {
            let (triangle, _) = sample?;
            scene.triangle_surfaces.get(triangle as usize).copied()
        })
    }

    /// The interpolated unit normal (world coordinates) at each pixel of the
    /// last frame, which showed `scene` in `view`; zero where there is
    /// nothing.
    #[must_use]
    pub fn normal_buffer(&self, scene: &Prepared, view: &View) -> Buffer<Vec3> {
        let matrix = FrameMatrix::new(view, scene.centre, self.width, self.height);
        self.buffer(|_, x, y| {
            let normal = |(number, _): (i32, f32)| {
                let (triangle, section) = decode(number);
                let section: Option<&Section> = section.and_then(|k| scene.sections.get(k));
                if let Some(section) = section {
                    return Some(section.normal.as_vec3());
                }
                let corners = scene.corners(triangle)?;
                let [a, b, c] = scene.corner_normals(triangle)?;
                let w = weights_at(&matrix, corners, x, y);
                Some((a * w[0] + b * w[1] + c * w[2]).normalize_or_zero())
            };
            self.number(x, y).and_then(normal).unwrap_or_default()
        })
    }

    /// What lies under the pixel in column `x` and row `y` of the last frame,
    /// which showed `scene` in `view`.
    #[must_use]
    pub fn pick(&self, scene: &Prepared, view: &View, x: u32, y: u32) -> Option<Pick> {
        let (triangle, depth) = self.sample(x, y)?;
        let position = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let viewport = Viewport::of_image(self.width, self.height);
        let point = viewport.unproject(view, position.extend(1.0 - f64::from(depth)))?;
        Some(Pick {
            point,
            triangle,
            surface: scene.triangle_surfaces.get(triangle as usize).copied(),
        })
    }
}
