//! What the visibility buffer of the last frame says besides the picture:
//! depth, triangles, surfaces, normals, and the point under a pixel.

use glam::{DVec2, DVec3, Vec3};

use crate::RasterError;
use crate::camera::View;

use crate::frame::FrameMatrix;
use crate::image::Image;
use crate::interpolate::weights_at;
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

/// Depths of so many bits as the bytes of a grey PNG of 16 bits, or of 8 where
/// these are enough: the numbers themselves, the upper 16 of more.
///
/// # Errors
/// [`RasterError::EmptyImage`] without pixels.
pub fn integer_depth_png(depths: &Buffer<u32>, bits: u32) -> Result<Vec<u8>, RasterError> {
    let (width, height) = (depths.width, depths.height);
    if width == 0 || height == 0 {
        return Err(RasterError::EmptyImage { width, height });
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    let deep = bits > 8;
    encoder.set_depth(if deep {
        png::BitDepth::Sixteen
    } else {
        png::BitDepth::Eight
    });
    let bytes: Vec<u8> = if deep {
        let upper = |&v: &u32| (v >> bits.saturating_sub(16).min(16)) as u16;
        depths
            .values
            .iter()
            .flat_map(|v| upper(v).to_be_bytes())
            .collect()
    } else {
        depths.values.iter().map(|&v| v as u8).collect()
    };
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(file)
}

/// Depth as a grey picture: white near, dark far, between the least and the
/// greatest depth that occur; transparent where there is nothing.
#[must_use]
pub fn depth_image(depth: &Buffer<f32>) -> Image {
    let drawn = || depth.values.iter().copied().filter(|&d| d < 1.0);
    let (low, high) = drawn().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), d| {
        (low.min(d), high.max(d))
    });
    let range = (high - low).max(f32::MIN_POSITIVE);
    to_image(depth, |d| {
        let grey = (255.0 - 215.0 * (d - low) / range).round() as u8;
        if d < 1.0 {
            [grey, grey, grey, 255]
        } else {
            [0; 4]
        }
    })
}

/// Normals as colours: (n + 1) / 2 in red, green and blue, not gamma-encoded;
/// transparent where there is nothing.
#[must_use]
pub fn normal_image(normals: &Buffer<Vec3>) -> Image {
    to_image(normals, |n| {
        if n == Vec3::ZERO {
            return [0; 4];
        }
        let [r, g, b] = n
            .to_array()
            .map(|c| (c.midpoint(1.0) * 255.0).round().clamp(0.0, 255.0) as u8);
        [r, g, b, 255]
    })
}

/// Numbers (of surfaces or triangles) as well separated colours; transparent
/// where there is none.
#[must_use]
pub fn id_image(ids: &Buffer<Option<u32>>) -> Image {
    to_image(ids, |id| {
        id.map_or([0; 4], |id| {
            // Fibonacci hashing spreads neighbouring numbers over all hues.
            let hash = (id + 1).wrapping_mul(0x9e37_79b9);
            let [a, b, c, _] = hash.to_be_bytes();
            let bright = |v: u8| 64 + v / 4 * 3;
            [bright(a), bright(b), bright(c), 255]
        })
    })
}

fn to_image<T: Copy>(buffer: &Buffer<T>, colour: impl Fn(T) -> [u8; 4]) -> Image {
    Image {
        width: buffer.width,
        height: buffer.height,
        pixels: buffer.values.iter().map(|&v| colour(v)).collect(),
    }
}
