//! Ambient occlusion from the depth buffer.
//!
//! Around each pixel the surface is sampled on a spiral; each sample hides
//! light in proportion to how far it rises over the pixel's tangent plane
//! (McGuire et al., *The Alchemy screen-space ambient obscurance algorithm*,
//! HPG 2011). The spiral is turned by a fixed 4x4 pattern, and a 4x4 mean
//! removes that pattern again. Large pictures are sampled at every so manieth
//! pixel; the others take the mean of those next to them that are as deep.

use glam::{DMat4, DVec4, Vec3};
use rayon::prelude::*;

use crate::blend;
use crate::buffers::Buffer;
use crate::camera::View;
use crate::frame::FrameMatrix;
use crate::ground::{Ground, ground_height};
use crate::image::Image;
use crate::pipeline::Renderer;
use crate::prepared::Prepared;
use crate::viewport::Viewport;

/// Samples around each pixel.
const SAMPLES: usize = 16;
/// Radius of the neighbourhood in parts of the scene's diagonal, and the most
/// in parts of the picture's longer side.
const RADIUS: f64 = 0.12;
const MOST: f64 = 0.12;
/// Turns of the spiral; coprime to the samples.
const TURNS: f64 = 7.0;
/// Strength of the darkening.
const STRENGTH: f32 = 3.0;
/// The most samples, about: what fits a cache.
const MOST_SAMPLES: f64 = 250_000.0;

/// What is known of one pixel of the grid.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Relative to the scene's centre, or NaN where there is nothing.
    point: Vec3,
    /// Reversed depth, 0 where there is no surface.
    depth: f32,
}

/// The pixels that are sampled, every so manieth each way.
struct Grid {
    step: u32,
    width: u32,
    height: u32,
    samples: Vec<Sample>,
}

impl Grid {
    fn new(
        renderer: &Renderer,
        view: &View,
        matrix: &FrameMatrix,
        ground: Option<&Ground>,
    ) -> Self {
        let (full_width, full_height) = (renderer.width, renderer.height);
        let pixels = f64::from(full_width) * f64::from(full_height);
        let step = ((pixels / MOST_SAMPLES).sqrt().ceil() as u32).max(1);
        let (width, height) = (full_width.div_ceil(step), full_height.div_ceil(step));
        let nothing = Sample {
            point: Vec3::NAN,
            depth: 0.0,
        };
        let mut samples = vec![nothing; width as usize * height as usize];
        let to_scene = unprojection(view, matrix);
        let rows = samples.par_chunks_mut(width.max(1) as usize).enumerate();
        rows.for_each(|(y, row)| {
            for (x, to) in row.iter_mut().enumerate() {
                let (px, py) = (x as u32 * step, y as u32 * step);
                if let Some((_, depth)) = renderer.number(px, py) {
                    let at = |v: u32| f64::from(v) + 0.5;
                    let p = to_scene * DVec4::new(at(px), at(py), f64::from(depth), 1.0);
                    to.point = (p.truncate() / p.w).as_vec3();
                    to.depth = depth;
                } else if let Some((point, _)) = ground.and_then(|g| g.at(px, py)) {
                    to.point = point.as_vec3();
                }
            }
        });
        Self {
            step,
            width,
            height,
            samples,
        }
    }

    fn at(&self, x: i32, y: i32) -> Option<&Sample> {
        let (x, y) = (x.cast_unsigned(), y.cast_unsigned());
        if x >= self.width || y >= self.height {
            return None;
        }
        self.samples.get((y * self.width + x) as usize)
    }

    /// The unit normal at a sample, towards the viewer: from the nearer of its
    /// neighbours either way, so that it does not mix two surfaces.
    fn normal(&self, x: i32, y: i32, here: Vec3, viewer: Vec3) -> Vec3 {
        let difference = |dx: i32, dy: i32| {
            let at = |sign: i32| {
                let other = self.at(x + sign * dx, y + sign * dy)?;
                let along = (other.point - here) * sign as f32;
                (other.depth > 0.0).then_some(along)
            };
            match (at(1), at(-1)) {
                (Some(a), Some(b)) if b.length_squared() < a.length_squared() => b,
                (Some(a), _) => a,
                (None, Some(b)) => b,
                (None, None) => Vec3::ZERO,
            }
        };
        let normal = difference(1, 0).cross(difference(0, 1));
        let normal = normal.normalize_or_zero();
        if normal.dot(viewer) < 0.0 {
            -normal
        } else {
            normal
        }
    }
}

/// Pixels, with reversed depth, to points relative to the scene's centre.
fn unprojection(view: &View, matrix: &FrameMatrix) -> DMat4 {
    let viewport = Viewport::of_image(matrix.width, matrix.height);
    let to_ndc = DMat4::from_cols(
        DVec4::new(2.0 / viewport.width, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -2.0 / viewport.height, 0.0, 0.0),
        DVec4::new(0.0, 0.0, -2.0, 0.0),
        DVec4::new(-1.0, 1.0, 1.0, 1.0),
    );
    DMat4::from_translation(-matrix.centre) * view.clip_to_world() * to_ndc
}

/// The directions of a spiral's samples, in parts of its radius, for each turn.
fn spirals() -> Vec<[[f32; 2]; SAMPLES]> {
    // Bayer's 4x4 matrix turns the spirals of neighbours apart.
    const TURN: [u8; 16] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
    let spiral = |turn: u8| {
        std::array::from_fn(|k| {
            let share = (k as f64 + 0.5) / SAMPLES as f64;
            let angle = (share * TURNS + f64::from(turn) / 16.0) * std::f64::consts::TAU;
            let (sin, cos) = angle.sin_cos();
            [(cos * share) as f32, (sin * share) as f32]
        })
    };
    TURN.map(spiral).to_vec()
}

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
        if width == 0 || height == 0 {
            return Buffer::default();
        }
        let matrix = FrameMatrix::new(view, scene.centre, width, height);
        let ground = if on_ground {
            Ground::new(&matrix, ground_height(scene))
        } else {
            None
        };
        let grid = Grid::new(self, view, &matrix, ground.as_ref());
        let raw = raw_openness(&grid, &matrix, scene);
        let smooth = without_pattern(&grid, &raw);
        Buffer {
            width,
            height,
            values: enlarged(self, &grid, &smooth),
        }
    }
}

/// The openness of each sample, with the pattern of its spiral.
fn raw_openness(grid: &Grid, matrix: &FrameMatrix, scene: &Prepared) -> Vec<f32> {
    let (low, high) = scene.bounds();
    let whole = ((high - low).length() * RADIUS).max(f64::MIN_POSITIVE);
    // Pixels a unit of length, times W.
    let scale = matrix.rows[0].truncate().length() / 256.0 / f64::from(grid.step);
    let most = f64::from(grid.width.max(grid.height)) * MOST;
    let spirals = spirals();
    let mut raw = vec![1.0; grid.samples.len()];
    let rows = raw.par_chunks_mut(grid.width as usize).enumerate();
    rows.for_each(|(y, row)| {
        for (x, open) in row.iter_mut().enumerate() {
            let sample = &grid.samples[y * grid.width as usize + x];
            if sample.depth == 0.0 {
                continue;
            }
            let point = sample.point.as_dvec3();
            let unit = scale / matrix.row(3, point);
            let pixels = (whole * unit).min(most);
            let radius = (pixels / unit) as f32;
            let viewer = matrix.viewer.truncate() - point * matrix.viewer.w;
            let (column, line) = (x as i32, y as i32);
            let normal = grid.normal(column, line, sample.point, viewer.as_vec3());
            let (slack, squared) = (0.01 * radius, radius * radius);
            let mut sum = 0.0;
            for [dx, dy] in spirals[y % 4 * 4 + x % 4] {
                let offset = [dx, dy].map(|d| (d * pixels as f32).round() as i32);
                let Some(other) = grid.at(column + offset[0], line + offset[1]) else {
                    continue;
                };
                let v = other.point - sample.point;
                let length = v.length_squared();
                let near = 1.0 - length / squared;
                // (False for NaN: where there is nothing.)
                if near > 0.0 {
                    let rise = (v.dot(normal) - slack) / (length.sqrt() + slack);
                    sum += near * rise.max(0.0);
                }
            }
            *open = (1.0 - STRENGTH * sum / SAMPLES as f32).clamp(0.0, 1.0);
        }
    });
    raw
}

/// Means over the 4x4 pattern, leaving out samples without a surface.
fn without_pattern(grid: &Grid, raw: &[f32]) -> Vec<f32> {
    let width = grid.width as usize;
    let mut smooth = vec![1.0; raw.len()];
    let rows = smooth.par_chunks_mut(width).enumerate();
    rows.for_each(|(y, row)| {
        let lines = y.saturating_sub(2)..(y + 2).min(grid.height as usize);
        for (x, to) in row.iter_mut().enumerate() {
            if grid.samples[y * width + x].depth == 0.0 {
                continue;
            }
            let columns = x.saturating_sub(2)..(x + 2).min(width);
            let (mut sum, mut count) = (0.0, 0.0);
            for line in lines.clone() {
                let here = line * width + columns.start..line * width + columns.end;
                for (open, sample) in raw[here.clone()].iter().zip(&grid.samples[here]) {
                    if sample.depth > 0.0 {
                        sum += open;
                        count += 1.0;
                    }
                }
            }
            *to = sum / count;
        }
    });
    smooth
}

/// The openness of all pixels from that of the samples around each that are
/// about as deep.
fn enlarged(renderer: &Renderer, grid: &Grid, smooth: &[f32]) -> Vec<f32> {
    if grid.step == 1 {
        return smooth.to_vec();
    }
    let surfaces = || {
        grid.samples
            .par_iter()
            .map(|s| s.depth)
            .filter(|&d| d > 0.0)
    };
    let nearest = surfaces().reduce(|| 0.0, f32::max);
    let farthest = surfaces().reduce(|| 1.0, f32::min);
    // Depths so far apart count half.
    let same = (nearest - farthest).max(1e-6) * 3e-3;
    let width = renderer.width as usize;
    let mut values = vec![1.0; width * renderer.height as usize];
    let rows = values.par_chunks_mut(width).enumerate();
    let step = grid.step as usize;
    let share = 1.0 / step as f32;
    let last = [grid.width as usize - 1, grid.height as usize - 1];
    rows.for_each(|(y, row)| {
        let down = (y % step) as f32 * share;
        let lines = [(y / step, 1.0 - down), ((y / step + 1).min(last[1]), down)];
        for (x, to) in row.iter_mut().enumerate() {
            let Some((_, depth)) = renderer.number(x as u32, y as u32) else {
                continue;
            };
            let right = (x % step) as f32 * share;
            let column = x / step;
            let columns = [(column, 1.0 - right), ((column + 1).min(last[0]), right)];
            let (mut sum, mut total) = (0.0, 0.0);
            for (line, near_line) in lines {
                for (column, near_column) in columns {
                    let k = line * grid.width as usize + column;
                    let other = grid.samples[k].depth;
                    if other > 0.0 {
                        let alike = same / (same + (depth - other).abs());
                        let weight = (near_line * near_column + 1e-3) * alike;
                        sum += smooth[k] * weight;
                        total += weight;
                    }
                }
            }
            if total > 0.0 {
                *to = sum / total;
            }
        }
    });
    values
}

/// Darkens a picture by ambient occlusion.
pub(crate) fn darken(image: &mut Image, openness: &Buffer<f32>) {
    let pixels = image.pixels.par_iter_mut().with_min_len(1 << 12);
    pixels.zip(&openness.values).for_each(|(pixel, &open)| {
        if open < 1.0 {
            for channel in &mut pixel[..3] {
                *channel = blend::encode(blend::decode(*channel) * open);
            }
        }
    });
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
