//! A soft shadow on the ground, under a light straight above.

use csg::Color;
use glam::{DMat3, DVec2, DVec3, DVec4};
use rayon::prelude::*;

use crate::blend::under;
use crate::camera::{Camera, Lens, View};
use crate::fixed::SUBPIXELS;
use crate::frame::FrameMatrix;
use crate::image::Image;
use crate::options::RenderOptions;
use crate::pipeline::Renderer;
use crate::prepared::Prepared;

/// Width and height of the shadow's own picture.
const SIZE: u32 = 256;
/// How far the shadow's picture reaches beyond the scene, and how wide it is
/// blurred, in parts of the scene's largest extent.
const MARGIN: f64 = 0.25;
const BLUR: f64 = 0.03;
/// How far a shadow reaches beyond what casts it, in parts of the scene's
/// largest extent: three blurs, of which the last tenth is not seen.
pub(crate) const SHADOW_SPREAD: f64 = 2.7 * BLUR;
/// Opacity where the whole light is hidden.
const DARKNESS: f32 = 0.45;

/// A horizontal plane as seen: where on it a pixel's centre shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground {
    height: f64,
    /// Pixel centres (x, y, 1) to the plane's points (x, y, 1) over W.
    to_plane: DMat3,
    /// Reversed depth, of those points.
    depth: DVec3,
}

impl Ground {
    /// The plane z = `height` relative to the matrix's origin; `None` for a
    /// viewer who does not look down on it.
    pub fn new(matrix: &FrameMatrix, height: f64) -> Option<Self> {
        if matrix.viewer.z <= height * matrix.viewer.w {
            return None;
        }
        let [x, y, z, w] = matrix.rows;
        let row = |r: DVec4| DVec3::new(r.x, r.y, r.z * height + r.w);
        let to_window = DMat3::from_cols(row(x), row(y), row(w)).transpose();
        let sub = f64::from(SUBPIXELS);
        let [middle_x, middle_y] = matrix.middle.map(f64::from);
        let to_samples = DMat3::from_cols(
            DVec3::new(sub, 0.0, 0.0),
            DVec3::new(0.0, sub, 0.0),
            DVec3::new(-middle_x, -middle_y, 1.0),
        );
        let to_plane = to_window.inverse() * to_samples;
        to_plane.is_finite().then_some(Self {
            height,
            to_plane,
            depth: row(z),
        })
    }

    /// The point of the plane in the middle of a pixel, and its reversed depth;
    /// `None` behind the viewer or beyond the far plane.
    pub fn at(&self, x: u32, y: u32) -> Option<(DVec3, f64)> {
        let pixel = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
        let p = self.to_plane * pixel;
        let depth = self.depth.dot(p);
        let seen = p.z > 0.0 && (0.0..=1.0).contains(&depth);
        seen.then(|| ((p.truncate() / p.z).extend(self.height), depth))
    }
}

/// How much light from above is hidden on the ground, relative to the scene's
/// centre.
#[derive(Clone, Debug)]
pub(crate) struct Shadow {
    low: DVec2,
    extent: f64,
    hidden: Vec<f32>,
}

impl Shadow {
    /// That of a scene, if there is anything.
    pub fn of(scene: &Prepared) -> Option<Self> {
        let (low, high) = scene.bounds();
        let size = (high - low).max_element().max(f64::MIN_POSITIVE);
        let middle = low + (high - low) / 2.0;
        let extent = size * (1.0 + 2.0 * MARGIN);
        let camera = Camera {
            eye: middle.truncate().extend(high.z + size),
            target: middle.truncate().extend(low.z),
            up: DVec3::Y,
            lens: Lens::Orthographic { height: extent },
            near: size * 0.5,
            far: high.z - scene.lowest + size * 1.5,
        };
        let mut renderer = Renderer::default();
        let options = RenderOptions {
            lights: Vec::new(),
            cull_back_faces: false,
            ..RenderOptions::default()
        };
        let view = camera.view(SIZE, SIZE).ok()?;
        let mut image = Image::default();
        let drawn = renderer.draw(scene, &view, SIZE, SIZE, &options, &mut image);
        drawn.ok()?;
        let coverage = image.pixels.iter().map(|p| f32::from(p[3]) / 255.0);
        let mut hidden: Vec<f32> = coverage.collect();
        let radius = (f64::from(SIZE) * BLUR / (1.0 + 2.0 * MARGIN)).ceil() as usize;
        // Three box blurs are nearly a Gaussian.
        for _ in 0..6 {
            hidden = transpose(&blur_rows(&hidden, radius));
        }
        Some(Self {
            low: (middle - scene.centre).truncate() - extent / 2.0,
            extent,
            hidden,
        })
    }

    /// The part of the light hidden at a point of the ground.
    fn at(&self, point: DVec2) -> f32 {
        let size = f64::from(SIZE);
        let x = (point.x - self.low.x) / self.extent * size - 0.5;
        let y = (1.0 - (point.y - self.low.y) / self.extent) * size - 0.5;
        if !(x >= 0.0 && y >= 0.0 && x < size - 1.0 && y < size - 1.0) {
            return 0.0;
        }
        let (column, row) = (x as usize, y as usize);
        let (u, v) = (x.fract() as f32, y.fract() as f32);
        let value = |dx: usize, dy: usize| self.hidden[(row + dy) * SIZE as usize + column + dx];
        let top = value(0, 0) * (1.0 - u) + value(1, 0) * u;
        let bottom = value(0, 1) * (1.0 - u) + value(1, 1) * u;
        top * (1.0 - v) + bottom * v
    }
}

/// Means over `2 radius + 1` neighbours in each row of a square picture.
fn blur_rows(values: &[f32], radius: usize) -> Vec<f32> {
    let size = SIZE as usize;
    let mut blurred = vec![0.0; values.len()];
    for (row, to) in values.chunks(size).zip(blurred.chunks_mut(size)) {
        let mut sum: f32 = row[..radius.min(size)].iter().sum();
        for (k, value) in to.iter_mut().enumerate() {
            sum += row.get(k + radius).unwrap_or(&0.0);
            *value = sum / (2 * radius + 1) as f32;
            sum -= k.checked_sub(radius).map_or(0.0, |k| row[k]);
        }
    }
    blurred
}

fn transpose(values: &[f32]) -> Vec<f32> {
    let size = SIZE as usize;
    (0..values.len())
        .map(|k| values[k % size * size + k / size])
        .collect()
}

/// The height of the ground relative to a scene's centre: its lowest point.
pub(crate) fn ground_height(scene: &Prepared) -> f64 {
    scene.low.z - scene.centre.z
}

/// Puts the shadow that a scene casts on the plane through its lowest point
/// under the picture. Nothing happens for a viewer below that plane.
pub(crate) fn draw_ground_shadow(scene: &Prepared, view: &View, image: &mut Image) {
    if scene.triangles.is_empty() || image.pixels.is_empty() {
        return;
    }
    let matrix = FrameMatrix::new(view, scene.centre, image.width, image.height);
    let Some(ground) = Ground::new(&matrix, ground_height(scene)) else {
        return;
    };
    let Some(shadow) = scene.shadow() else {
        return;
    };
    let width = image.width as usize;
    let black = Color::from_linear([0.0; 3]);
    let rows = image.pixels.par_chunks_mut(width).enumerate();
    rows.for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate().filter(|(_, p)| p[3] < 255) {
            let Some((point, _)) = ground.at(x as u32, y as u32) else {
                continue;
            };
            let hidden = shadow.at(point.truncate());
            if hidden > 0.0 {
                *pixel = under(*pixel, black, hidden * DARKNESS);
            }
        }
    });
}
