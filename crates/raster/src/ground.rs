//! A soft shadow on the ground, under a light straight above.

use csg::Color;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::RasterError;
use crate::camera::{Camera, Lens, View};
use crate::image::Image;
use crate::line::under;
use crate::options::RenderOptions;
use crate::pipeline::Renderer;
use crate::scene::Scene;
use crate::viewport::Viewport;

/// Width and height of the shadow's own picture.
const SIZE: u32 = 256;
/// How far the shadow's picture reaches beyond the scene, and how wide it is
/// blurred, in parts of the scene's largest extent.
const MARGIN: f64 = 0.25;
const BLUR: f64 = 0.03;
/// Opacity where the whole light is hidden.
const DARKNESS: f32 = 0.45;

/// How much light from above is hidden, on the plane z = `height`.
struct Shadow {
    height: f64,
    low: DVec2,
    extent: f64,
    hidden: Vec<f32>,
}

impl Shadow {
    fn of(scene: &Scene) -> Result<Self, RasterError> {
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
        let view = camera.view(SIZE, SIZE)?;
        let mut image = Image::default();
        renderer.draw(scene, &view, SIZE, SIZE, &options, &mut image)?;
        let mut hidden: Vec<f32> = image
            .pixels
            .iter()
            .map(|p| f32::from(p[3]) / 255.0)
            .collect();
        let radius = (f64::from(SIZE) * BLUR / (1.0 + 2.0 * MARGIN)).ceil() as usize;
        // Three box blurs are nearly a Gaussian.
        for _ in 0..3 {
            hidden = transpose(&blur_rows(&hidden, radius));
            hidden = transpose(&blur_rows(&hidden, radius));
        }
        Ok(Self {
            height: low.z,
            low: middle.truncate() - extent / 2.0,
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
        for (k, value) in to.iter_mut().enumerate() {
            let window = &row[k.saturating_sub(radius)..(k + radius + 1).min(size)];
            *value = window.iter().sum::<f32>() / (2 * radius + 1) as f32;
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

/// Puts the shadow that a scene casts on the plane through its lowest point
/// under the picture. Nothing happens for a viewer below that plane.
pub(crate) fn draw_ground_shadow(
    scene: &Scene,
    view: &View,
    image: &mut Image,
) -> Result<(), RasterError> {
    if scene.triangles.is_empty() || image.pixels.is_empty() {
        return Ok(());
    }
    let shadow = Shadow::of(scene)?;
    let viewport = Viewport::of_image(image.width, image.height);
    let width = image.width as usize;
    let black = Color::from_linear([0.0; 3]);
    image
        .pixels
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                if pixel[3] == 255 {
                    continue;
                }
                let position = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let Some((near, far)) = viewport.ray(view, position) else {
                    continue;
                };
                let t = (shadow.height - near.z) / (far.z - near.z);
                if !(far.z < near.z && (0.0..=1.0).contains(&t)) {
                    continue;
                }
                let hidden = shadow.at(near.lerp(far, t).truncate());
                if hidden > 0.0 {
                    *pixel = under(*pixel, black, hidden * DARKNESS);
                }
            }
        });
    Ok(())
}
