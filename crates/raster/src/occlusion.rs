//! Ambient occlusion from the depth and normal buffers.
//!
//! Around each pixel the surface is sampled on a spiral; each sample hides
//! light in proportion to how far it rises over the pixel's tangent plane
//! (McGuire et al., *The Alchemy screen-space ambient obscurance algorithm*,
//! HPG 2011). The spiral is turned by a fixed 4x4 pattern, and a 4x4 mean
//! removes that pattern again.

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use crate::buffers::Buffer;
use crate::camera::View;
use crate::image::Image;
use crate::pipeline::Renderer;
use crate::scene::Scene;
use crate::viewport::Viewport;

/// Samples around each pixel.
const SAMPLES: usize = 16;
/// Radius of the neighbourhood in parts of the scene's diagonal.
const RADIUS: f64 = 0.12;
/// Turns of the spiral; coprime to the samples.
const TURNS: f64 = 7.0;
/// Strength of the darkening.
const STRENGTH: f64 = 3.0;

/// Surface points of a frame, for all pixels.
struct Points {
    width: u32,
    height: u32,
    points: Vec<Option<DVec3>>,
}

impl Points {
    fn at(&self, x: i64, y: i64) -> Option<DVec3> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        if x >= self.width || y >= self.height {
            return None;
        }
        self.points[y as usize * self.width as usize + x as usize]
    }
}

impl Renderer {
    /// How open each pixel of the last frame, which showed `scene` in `view`,
    /// is to light from everywhere: 1 open, 0 hidden; 1 where there is
    /// nothing. Cost: about 1 µs a pixel and thread.
    #[must_use]
    pub fn ambient_occlusion(&self, scene: &Scene, view: &View) -> Buffer<f32> {
        let (width, height) = (self.width, self.height);
        let normals = self.normal_buffer(scene, view);
        if normals.values.is_empty() {
            return Buffer::default();
        }
        let viewport = Viewport::of_image(width, height);
        let mut points = vec![None; normals.values.len()];
        points
            .par_chunks_mut(width as usize)
            .enumerate()
            .for_each(|(y, row)| {
                for (x, point) in row.iter_mut().enumerate() {
                    let depth = self.sample(x as u32, y as u32);
                    *point = depth.and_then(|(_, depth)| {
                        let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                        viewport.unproject(view, at.extend(1.0 - f64::from(depth)))
                    });
                }
            });
        let points = Points {
            width,
            height,
            points,
        };
        let (low, high) = scene.bounds();
        let radius = ((high - low).length() * RADIUS).max(f64::MIN_POSITIVE);
        let right = view
            .world_to_eye()
            .transpose()
            .x_axis
            .truncate()
            .normalize_or_zero();
        let raw: Vec<f32> = (0..points.points.len())
            .into_par_iter()
            .map(|k| {
                let (x, y) = (k as u32 % width, k as u32 / width);
                let Some(point) = points.points[k] else {
                    return 1.0;
                };
                // The radius as drawn at this distance.
                let reach = [point, point + right * radius]
                    .map(|p| viewport.project(view, p).map(DVec3::truncate));
                let [Some(centre), Some(rim)] = reach else {
                    return 1.0;
                };
                let pixels = centre.distance(rim).min(f64::from(width.max(height)) / 4.0);
                openness(&points, x, y, point, normals.values[k], pixels, radius)
            })
            .collect();
        let smooth = (0..raw.len())
            .into_par_iter()
            .map(|k| mean(&raw, &points, k))
            .collect();
        Buffer {
            width,
            height,
            values: smooth,
        }
    }
}

fn openness(
    points: &Points,
    x: u32,
    y: u32,
    point: DVec3,
    normal: Vec3,
    pixels: f64,
    radius: f64,
) -> f32 {
    // Bayer's 4x4 matrix turns the spirals of neighbours apart.
    const TURN: [u8; 16] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
    let turn = f64::from(TURN[(y as usize % 4) * 4 + x as usize % 4]) / 16.0;
    let normal = normal.as_dvec3();
    let mut sum = 0.0;
    for k in 0..SAMPLES {
        let share = (k as f64 + 0.5) / SAMPLES as f64;
        let angle = (share * TURNS + turn) * std::f64::consts::TAU;
        let offset = DVec2::from_angle(angle) * (share * pixels);
        let at = |c: u32, d: f64| i64::from(c) + d.round() as i64;
        let Some(other) = points.at(at(x, offset.x), at(y, offset.y)) else {
            continue;
        };
        let v = other - point;
        let squared = v.length_squared();
        let rise = v.dot(normal) - 0.01 * radius;
        let near = (1.0 - squared / (radius * radius)).max(0.0);
        sum += near * (rise / (squared.sqrt() + 0.01 * radius)).max(0.0);
    }
    (1.0 - STRENGTH * sum / SAMPLES as f64).clamp(0.0, 1.0) as f32
}

/// The mean over the 4x4 pattern, leaving out pixels without a surface.
fn mean(raw: &[f32], points: &Points, k: usize) -> f32 {
    if points.points[k].is_none() {
        return 1.0;
    }
    let (x, y) = (k as u32 % points.width, k as u32 / points.width);
    let (mut sum, mut count) = (0.0, 0.0);
    for dy in -2..2 {
        for dx in -2..2 {
            let (u, v) = (i64::from(x) + dx, i64::from(y) + dy);
            if points.at(u, v).is_some() {
                sum += raw[v as usize * points.width as usize + u as usize];
                count += 1.0;
            }
        }
    }
    sum / count
}

/// Darkens a picture by ambient occlusion.
pub(crate) fn darken(image: &mut Image, openness: &Buffer<f32>) {
    for (pixel, &open) in image.pixels.iter_mut().zip(&openness.values) {
        if open < 1.0 {
            for channel in &mut pixel[..3] {
                let linear = csg::color::srgb_to_linear(f32::from(*channel) / 255.0);
                let encoded = csg::color::linear_to_srgb(linear * open);
                *channel = (encoded * 255.0).round() as u8;
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
