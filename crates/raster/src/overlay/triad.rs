//! The axes triad in the picture's lower left corner.

use csg::Color;
use glam::{DVec2, DVec3};

use crate::camera::View;
use crate::image::Image;
use crate::line::{Layer, Segment};

/// Strokes of the letters X, Y and Z in a box from -1 to 1, y upwards.
const LETTERS: [&[[f64; 4]]; 3] = [
    &[[-0.7, -1.0, 0.7, 1.0], [-0.7, 1.0, 0.7, -1.0]],
    &[
        [-0.7, 1.0, 0.0, 0.1],
        [0.7, 1.0, 0.0, 0.1],
        [0.0, 0.1, 0.0, -1.0],
    ],
    &[
        [-0.7, 1.0, 0.7, 1.0],
        [0.7, 1.0, -0.7, -1.0],
        [-0.7, -1.0, 0.7, -1.0],
    ],
];

/// Draws the directions of the world's axes: X red, Y green, Z blue, those
/// that point at the viewer over the others.
pub(crate) fn draw_triad(view: &View, image: &mut Image) {
    let size = f64::from(image.width.min(image.height));
    let length = size * 0.07;
    if length < 6.0 {
        return;
    }
    let centre = DVec2::new(length * 1.7, f64::from(image.height) - length * 1.7);
    let colours = [[0.85, 0.15, 0.15], [0.15, 0.6, 0.15], [0.15, 0.3, 0.9]];
    let mut axes: Vec<(usize, DVec3)> = [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .map(|axis| {
            view.world_to_eye()
                .transform_vector3(axis)
                .normalize_or_zero()
        })
        .enumerate()
        .collect();
    axes.sort_by(|a, b| a.1.z.total_cmp(&b.1.z));
    for (k, axis) in axes {
        let mut layer = Layer::new(image.width, image.height);
        let direction = DVec2::new(axis.x, -axis.y);
        let width = (size / 300.0).clamp(1.0, 4.0);
        let mut stroke = |a: DVec2, b: DVec2| {
            let segment = Segment {
                a: a.extend(0.0),
                b: b.extend(0.0),
                start: 0.0,
            };
            layer.draw(&segment, width);
        };
        stroke(centre, centre + direction * length);
        let at = centre + direction * length * 1.35;
        let scale = length * 0.13;
        for &[x0, y0, x1, y1] in LETTERS[k] {
            stroke(
                at + DVec2::new(x0, -y0) * scale,
                at + DVec2::new(x1, -y1) * scale,
            );
        }
        layer.composite(image, Color::from_srgb(colours[k]));
    }
}
