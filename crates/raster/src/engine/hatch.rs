//! Hatching of section caps.

use crate::deferred::Batch;
use crate::fixed::SUBPIXELS;
use crate::shading::ShadeContext;
use crate::tile::decode;

/// Strokes of hatching across the diameter of a scene.
const HATCH_STROKES: f64 = 60.0;
/// The part of a cap that strokes cover, and how much they darken it.
const HATCH_WIDTH: f64 = 0.22;
const HATCH_DARKENING: f64 = 0.6;

/// Darkens the pixels of caps where they are hatched.
pub(crate) fn hatch(context: &ShadeContext, batch: &mut Batch) {
    let scene = context.scene;
    let spacing = (scene.high - scene.low).length() / HATCH_STROKES;
    let x_row = context.matrix.rows[0].truncate().length();
    for (job, colour) in batch.jobs.iter().zip(&mut batch.colours) {
        for (k, &number) in job.triangles.iter().enumerate() {
            let (_, Some(section)) = decode(number) else {
                continue;
            };
            let Some(plane) = scene.sections.get(section) else {
                continue;
            };
            let point = context.cap_point(job, section, k);
            // The size of a pixel there, in strokes.
            let pixel = context.matrix.row(3, point) * f64::from(SUBPIXELS) / x_row / spacing;
            let across = plane.hatch.dot(point) / spacing;
            let from_middle = (across - across.floor() - 0.5).abs();
            let covered =
                ((HATCH_WIDTH / 2.0 - from_middle) / pixel.max(1e-6) + 0.5).clamp(0.0, 1.0);
            for channel in colour.iter_mut() {
                channel[k] *= (1.0 - HATCH_DARKENING * covered) as f32;
            }
        }
    }
}
