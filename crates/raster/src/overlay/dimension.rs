//! Dimensions, and a bar that tells the scale.

use csg::{Color, Mesh};
use glam::{DVec2, DVec3};

use crate::camera::View;
use crate::image::Image;
use crate::lettering::{Lettering, text_width};
use crate::line::{Layer, Segment};
use crate::viewport::Viewport;

/// A distance between two points, to be drawn with its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimension {
    /// One end.
    pub from: DVec3,
    /// The other end.
    pub to: DVec3,
    /// What the line keeps clear of: it is drawn on the far side of `from` and
    /// `to` from there.
    pub clear_of: DVec3,
    /// By how much each end may be off: digits that this leaves open are not
    /// written.
    pub error: f64,
}

impl Dimension {
    /// The length in model units.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.from.distance(self.to)
    }

    /// Those of a box as a view shows it: of its four edges along each axis the
    /// one that is farthest outwards, and rather low.
    #[must_use]
    pub fn of_box(low: DVec3, high: DVec3, view: &View, width: u32, height: u32) -> Vec<Self> {
        let viewport = Viewport::of_image(width, height);
        let centre = low + (high - low) / 2.0;
        let corner = |k: usize| {
            let pick = |axis: usize| [low, high][k >> axis & 1][axis];
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let at = |p: DVec3| viewport.project(view, p).map(DVec3::truncate);
        let Some(middle) = at(centre) else {
            return Vec::new();
        };
        let of_axis = |axis: usize| {
            let edges = (0..8).filter(|k| k >> axis & 1 == 0);
            let score = |k: usize| {
                let (a, b) = (at(corner(k))?, at(corner(k | 1 << axis))?);
                let along = (b - a).try_normalize()?;
                let outwards = (a - middle).perp_dot(along).abs();
                Some(outwards + 0.35 * (a.y + b.y) / 2.0)
            };
            let best = edges
                .filter_map(|k| Some((score(k)?, k)))
                .max_by(|a, b| a.0.total_cmp(&b.0))?;
            Some(Self {
                from: corner(best.1),
                to: corner(best.1 | 1 << axis),
                clear_of: centre,
                error: 0.0,
            })
        };
        (0..3)
            .filter_map(of_axis)
            .filter(|d| d.length() > 0.0)
            .collect()
    }

    /// That between two parallel flat faces, given by the names of their
    /// surfaces; `None` if one is not there, not flat, or not parallel to the
    /// other.
    #[must_use]
    pub fn between(mesh: &Mesh, one: &str, other: &str) -> Option<Self> {
        let (a, normal) = flat_face(mesh, one)?;
        let (b, across) = flat_face(mesh, other)?;
        (normal.cross(across).length() < 1e-6).then_some(())?;
        let to = a + normal * normal.dot(b - a);
        let (low, high) = crate::prepared::finite_bounds(&mesh.positions)?;
        Some(Self {
            from: a,
            to,
            clear_of: low + (high - low) / 2.0,
            error: 0.0,
        })
    }
}

/// The middle and the unit normal of the flat faces on surfaces of a name.
fn flat_face(mesh: &Mesh, name: &str) -> Option<(DVec3, DVec3)> {
    let (mut sum, mut area, mut vector, mut normals) = (DVec3::ZERO, 0.0, DVec3::ZERO, Vec::new());
    for (index, &triangle) in mesh.triangles.iter().enumerate() {
        let surface = mesh.surface_of(index);
        if surface.and_then(|s| s.name.as_deref()) != Some(name) {
            continue;
        }
        let at = |v: u32| mesh.positions.get(v as usize).copied();
        let [Some(a), Some(b), Some(c)] = triangle.map(at) else {
            continue;
        };
        let own = (b - a).cross(c - a);
        let size = own.length();
        sum += (a + b + c) / 3.0 * size;
        (area, vector) = (area + size, vector + own);
        normals.push(own);
    }
    let normal = vector.try_normalize()?;
    let flat = |n: &DVec3| n.dot(normal) >= (1.0 - 1e-9) * n.length();
    normals.iter().all(flat).then(|| (sum / area, normal))
}

/// A number as it is written beside a line: four digits that count, no zeros
/// after them.
#[must_use]
pub fn written(value: f64) -> String {
    written_within(value, 0.0)
}

/// A number that may be off by so much, as [`written`] but for the decimals that
/// this leaves open.
#[must_use]
pub fn written_within(value: f64, error: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".into();
    }
    // Half a unit of the last one is the error or more.
    let known = -(2.0 * error.abs()).max(1e-9).log10().ceil() as i32;
    let digits = 3 - value.abs().log10().floor() as i32;
    let digits = digits.min(known).clamp(0, 9) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    }
}

/// Draws dimensions: lines beside what they measure, with arrows and numbers.
pub fn draw_dimensions(
    dimensions: &[Dimension],
    unit: &str,
    view: &View,
    color: Color,
    image: &mut Image,
) {
    let viewport = Viewport::of_image(image.width, image.height);
    let size = f64::from(image.width.min(image.height));
    let text = (size / 45.0).clamp(7.0, 40.0);
    let width = (text / 9.0).max(1.0);
    let mut layer = Layer::new(image.width, image.height);
    for dimension in dimensions {
        let at = |p: DVec3| viewport.project(view, p).map(DVec3::truncate);
        let (Some(a), Some(b), Some(middle)) =
            (at(dimension.from), at(dimension.to), at(dimension.clear_of))
        else {
            continue;
        };
        let Some(along) = (b - a).try_normalize() else {
            continue;
        };
        let side = along.perp();
        let outwards = if side.dot(a - middle) < 0.0 {
            -side
        } else {
            side
        };
        let gap = outwards * text * 2.2;
        let mut stroke = |from: DVec2, to: DVec2| {
            let (a, b) = (from.extend(0.0), to.extend(0.0));
            layer.draw(&Segment { a, b, start: 0.0 }, width);
        };
        for end in [a, b] {
            stroke(
                end + outwards * text * 0.5,
                end + gap + outwards * text * 0.5,
            );
        }
        let (a, b) = (a + gap, b + gap);
        stroke(a, b);
        for (tip, back) in [(a, along), (b, -along)] {
            for turn in [-0.32, 0.32] {
                stroke(tip, tip + DVec2::from_angle(turn).rotate(back) * text * 0.9);
            }
        }
        let label = format!(
            "{} {unit}",
            written_within(dimension.length(), 2.0 * dimension.error)
        );
        let label = label.trim();
        let half = DVec2::new(text_width(label, text) / 2.0, text / 2.0);
        let away = outwards * (half.dot(outwards.abs()) + text * 0.6);
        let middle = (a + b) / 2.0 + away;
        // Letters stay in the picture.
        let limit = DVec2::new(viewport.width, viewport.height);
        let corner = (middle - half)
            .min(limit - half * 2.0 - 2.0)
            .max(DVec2::splat(2.0));
        let lettering = Lettering {
            text: label,
            at: corner + DVec2::Y * text,
            height: text,
            color,
        };
        lettering.draw_on(&mut layer);
    }
    layer.composite(image, color);
}

/// Draws a bar at the lower right that is a round number of units long, for
/// pixels of that size.
pub fn draw_scale_bar(pixel: f64, unit: &str, color: Color, image: &mut Image) {
    let (width, height) = (f64::from(image.width), f64::from(image.height));
    let text = (width.min(height) / 45.0).clamp(7.0, 40.0);
    let most = width * 0.22 * pixel;
    if !(most > 0.0 && most.is_finite()) {
        return;
    }
    let power = 10f64.powf(most.log10().floor());
    let length = [5.0, 2.0, 1.0]
        .map(|step| step * power)
        .into_iter()
        .find(|&length| length <= most)
        .unwrap_or(power);
    let right = DVec2::new(width - text * 1.5, height - text * 1.5);
    let left = right - DVec2::X * (length / pixel);
    let mut layer = Layer::new(image.width, image.height);
    let line = (text / 7.0).max(1.0);
    let tick = DVec2::Y * text * 0.5;
    for (a, b) in [
        (left, right),
        (left - tick, left + tick),
        (right - tick, right + tick),
    ] {
        let (a, b) = (a.extend(0.0), b.extend(0.0));
        layer.draw(&Segment { a, b, start: 0.0 }, line);
    }
    let label = format!("{} {unit}", written(length));
    let label = label.trim();
    let at = (left + right) / 2.0 - DVec2::new(text_width(label, text) / 2.0, text);
    Lettering {
        text: label,
        at,
        height: text,
        color,
    }
    .draw_on(&mut layer);
    layer.composite(image, color);
}
