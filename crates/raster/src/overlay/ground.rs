//! A soft shadow on the ground, under a light straight above.

use std::ops::Range;

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
use crate::simd::math::linear_to_srgb_byte;
use crate::simd::{
    DoubleLanes, FloatLanes, IntLanes, Kernel, LANE_NUMBERS, LANES, Lanes, Level, MaskLanes,
};

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

/// A horizontal plane as seen: where on it points of the window are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground {
    /// The window, (x, y, 1) in pixels, to the plane's points (x, y, 1) over W.
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
            to_plane,
            depth: row(z),
        })
    }

    /// Linear functions of the window, by factors of x, y (pixels) and 1: what is
    /// positive before the viewer, and the reversed depth of the plane, which is seen
    /// where that is in 0..=1.
    pub fn in_window(&self) -> [DVec3; 2] {
        let rows = self.to_plane.transpose();
        [rows.z_axis, rows * self.depth]
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

    /// Points (x, y, 1) of the ground to columns and rows of [`hidden`](Self::hidden).
    fn to_cells(&self) -> DMat3 {
        let per_unit = f64::from(SIZE) / self.extent;
        let high = self.low.y + self.extent;
        DMat3::from_cols(
            DVec3::new(per_unit, 0.0, 0.0),
            DVec3::new(0.0, -per_unit, 0.0),
            DVec3::new(-self.low.x * per_unit - 0.5, high * per_unit - 0.5, 1.0),
        )
    }

    /// The columns and rows of a picture that a shadow may be seen in.
    fn pixels(&self, to_cells: DMat3, size: [u32; 2]) -> Option<[Range<usize>; 2]> {
        let from_cells = to_cells.inverse();
        let corners = self.corners().map(|cell| from_cells * cell);
        // Of what reaches behind the viewer, all pixels may show some.
        let all_before = corners.iter().all(|corner| corner.z > 0.0);
        let ranges = [0, 1].map(|axis| {
            let side = f64::from(size[axis]);
            let along = corners.iter().map(|corner| corner[axis] / corner.z);
            let low = along.clone().fold(side, f64::min).floor().max(0.0);
            let high = along.fold(0.0, f64::max).ceil().min(side);
            let (low, high) = if all_before { (low, high) } else { (0.0, side) };
            low as usize..high as usize
        });
        ranges
            .iter()
            .all(|range| !range.is_empty())
            .then_some(ranges)
    }

    /// The corners, among the cells, of a rectangle outside of which nobody sees
    /// a shadow.
    fn corners(&self) -> [DVec3; 4] {
        let seen = |&k: &usize| self.hidden[k] * DARKNESS > 0.5 / 255.0;
        let cells = (0..self.hidden.len()).filter(seen);
        let start = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = cells.fold(start, |(low, high), k| {
            let cell = [k % SIZE as usize, k / SIZE as usize].map(|v| v as f64);
            let cell = DVec2::from_array(cell);
            (low.min(cell - 1.0), high.max(cell + 1.0))
        });
        [
            low,
            DVec2::new(high.x, low.y),
            high,
            DVec2::new(low.x, high.y),
        ]
        .map(|p| p.extend(1.0))
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
/// under the picture. Nothing happens for a viewer below that plane. What will be
/// behind is mixed with it in linear light if `linear`, or, as by those who show
/// pictures with transparent places, as encoded in sRGB: over white both look alike.
pub(crate) fn draw_ground_shadow(
    level: Level,
    scene: &Prepared,
    view: &View,
    linear: bool,
    image: &mut Image,
) {
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
    let to_cells = shadow.to_cells() * ground.to_plane;
    let Some([columns, rows]) = shadow.pixels(to_cells, [image.width, image.height]) else {
        return;
    };
    let [_, plane] = ground.in_window();
    let lines = image
        .pixels
        .par_chunks_mut(image.width as usize)
        .enumerate();
    lines
        .skip(rows.start)
        .take(rows.len())
        .for_each(|(y, line)| {
            level.run(ShadowRow {
                cast: Cast {
                    shadow,
                    linear,
                    to_cells: to_cells.transpose(),
                    plane,
                },
                first: [columns.start as f64 + 0.5, y as f64 + 0.5],
                pixels: &mut line[columns.clone()],
            });
        });
}

/// A shadow as a view shows it.
#[derive(Clone, Copy)]
struct Cast<'a> {
    shadow: &'a Shadow,
    /// How it will be mixed with what is behind.
    linear: bool,
    /// The window to the shadow's cells, row by row.
    to_cells: DMat3,
    /// The ground's depth.
    plane: DVec3,
}

/// Puts the shadow under some pixels of a row.
struct ShadowRow<'a> {
    cast: Cast<'a>,
    /// The middle of the first pixel.
    first: [f64; 2],
    pixels: &'a mut [[u8; 4]],
}

impl Kernel for ShadowRow<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Lanes>(self, s: S) {
        let [x, y] = self.first;
        for (number, pixels) in self.pixels.chunks_mut(LANES).enumerate() {
            if pixels.iter().any(|pixel| pixel[3] < 255) {
                let first = x + (number * LANES) as f64;
                let x = s.load_f(&LANE_NUMBERS).to_double() + s.d(first);
                put_shadow(s, &self.cast, [x, s.d(y)], pixels);
            }
        }
    }
}

/// The same of at most sixteen.
#[inline(always)]
fn put_shadow<S: Lanes>(s: S, cast: &Cast, at: [S::D; 2], pixels: &mut [[u8; 4]]) {
    let Cast {
        shadow,
        linear,
        to_cells,
        plane,
    } = *cast;
    let (zero, one, last) = (s.f(0.0), s.f(1.0), s.f((SIZE - 1) as f32));
    let w = on_plane(s, to_cells.z_axis, at);
    let x = (on_plane(s, to_cells.x_axis, at) / w).to_single();
    let y = (on_plane(s, to_cells.y_axis, at) / w).to_single();
    let depth = on_plane(s, plane, at).to_single();
    let on_ground = zero.lt(w.to_single()) & zero.le(depth) & depth.le(one);
    let seen = on_ground & zero.le(x) & x.lt(last) & zero.le(y) & y.lt(last);
    if seen.bits() == 0 {
        return;
    }
    let (x, y) = (seen.select_f(x, zero), seen.select_f(y, zero));
    // (A whole number may be a cell's end as well.)
    let half = s.f(0.5);
    let (column, row) = ((x - half).round(), (y - half).round());
    let mut cells = [0; LANES];
    (row * s.i(SIZE.cast_signed()) + column).store(&mut cells);
    let mut corners = [[0.0; LANES]; 4];
    for (lane, cell) in cells.into_iter().enumerate() {
        let around = shadow
            .hidden
            .get(cell as usize..cell as usize + SIZE as usize + 2);
        if let Some(&[a, b, .., c, d]) = around {
            for (corner, value) in corners.iter_mut().zip([a, b, c, d]) {
                corner[lane] = value;
            }
        }
    }
    let [a, b, c, d] = corners.map(|corner| s.load_f(&corner));
    let (u, v) = (x - column.to_float(), y - row.to_float());
    let top = a * (one - u) + b * u;
    let bottom = c * (one - u) + d * u;
    let hidden = top * (one - v) + bottom * v;
    let opacity = hidden * s.f(DARKNESS);
    let opacity = if linear {
        opacity
    } else {
        (one - linear_to_srgb_byte(s, one - opacity) * s.f(1.0 / 255.0)).max(zero)
    };
    let opacity = seen.select_f(opacity, zero);
    let (mut opacities, mut bytes) = ([0.0; LANES], [0; LANES]);
    opacity.store(&mut opacities);
    (opacity * s.f(255.0)).round().store(&mut bytes);
    let black = Color::from_linear([0.0; 3]);
    for (lane, pixel) in pixels.iter_mut().enumerate() {
        match pixel[3] {
            255 => {}
            0 if bytes[lane] == 0 => {}
            0 => *pixel = [0, 0, 0, bytes[lane] as u8],
            _ => *pixel = under(*pixel, black, opacities[lane]),
        }
    }
}

/// What a linear function, by its factors of x, y and 1, is at some places.
#[inline(always)]
fn on_plane<S: Lanes>(s: S, function: DVec3, [x, y]: [S::D; 2]) -> S::D {
    s.d(function.x) * x + (s.d(function.y) * y + s.d(function.z))
}
