//! Anti-aliased, depth-tested lines and points.
//!
//! A line is the set of points within half its width of a segment; a pixel's
//! coverage falls from 1 to 0 over the pixel around that border (Gupta,
//! Sproull, 1981, with a box of one pixel). Coverage is collected in a layer
//! by maximum, so that joints of polylines are not darker than their parts
//! and order does not matter, and the layer is put over the picture once.

use csg::Color;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::blend::over;
use crate::clip::clip_segment;
use crate::frame::FrameMatrix;
use crate::image::Image;
use crate::pipeline::Renderer;
use crate::prepared::Prepared;
use crate::tile::decode;

/// The coverage of some lines or points, in 0..=1 for each pixel.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    width: u32,
    height: u32,
    coverage: Vec<u8>,
}

/// Length of a dash and of the gap after it, in pixels.
const DASH: [f64; 2] = [5.0, 4.0];

/// A segment in the window: x and y in pixels, z the reversed depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    pub a: DVec3,
    pub b: DVec3,
    /// Distance in pixels along the polyline to `a`, for dashes.
    pub start: f64,
}

impl Layer {
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            coverage: vec![0; width as usize * height as usize],
        }
    }

    fn raise(&mut self, x: u32, y: u32, coverage: f64) {
        let at = y as usize * self.width as usize + x as usize;
        if let Some(value) = self.coverage.get_mut(at) {
            *value = (*value).max((coverage * 255.0).round() as u8);
        }
    }

    /// Calls `pixel` with column, row, coverage and the nearest parameter of
    /// the segment for all pixels it touches.
    fn trace(&self, segment: &Segment, width: f64, mut pixel: impl FnMut(u32, u32, f64, f64)) {
        let (a, b) = (segment.a.truncate(), segment.b.truncate());
        if !(a.is_finite() && b.is_finite()) {
            return;
        }
        let half = width / 2.0;
        let reach = half + 1.0;
        let along = b - a;
        let length_squared = along.length_squared();
        // Walks along the longer axis, and across it by the reach.
        let major = usize::from(along.y.abs() > along.x.abs());
        let minor = 1 - major;
        let size = [f64::from(self.width), f64::from(self.height)];
        let slope = if along[major] == 0.0 {
            0.0
        } else {
            along[minor] / along[major]
        };
        let spread = reach * (1.0 + slope * slope).sqrt() + slope.abs();
        let first = (a[major].min(b[major]) - reach).floor().max(0.0);
        let last = (a[major].max(b[major]) + reach)
            .floor()
            .min(size[major] - 1.0);
        let mut step = first;
        while step <= last {
            let centre = step + 0.5;
            let inside = centre.clamp(a[major].min(b[major]), a[major].max(b[major]));
            let middle = a[minor] + slope * (inside - a[major]);
            let mut across = (middle - spread).floor().max(0.0);
            let end = (middle + spread).floor().min(size[minor] - 1.0);
            while across <= end {
                let mut p = DVec2::ZERO;
                p[major] = centre;
                p[minor] = across + 0.5;
                let t = if length_squared > 0.0 {
                    ((p - a).dot(along) / length_squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let coverage = (half + 0.5 - p.distance(a + along * t)).clamp(0.0, width.min(1.0));
                if coverage > 0.0 {
                    pixel(p.x as u32, p.y as u32, coverage, t);
                }
                across += 1.0;
            }
            step += 1.0;
        }
    }

    /// Adds a segment without looking at depth.
    pub fn draw(&mut self, segment: &Segment, width: f64) {
        let mut found = Vec::new();
        self.trace(segment, width, |x, y, coverage, _| {
            found.push((x, y, coverage));
        });
        for (x, y, coverage) in found {
            self.raise(x, y, coverage);
        }
    }

    /// Puts the layer in one colour over a picture.
    pub fn composite(&self, image: &mut Image, color: Color) {
        let pixels = image.pixels.par_iter_mut().with_min_len(1 << 14);
        pixels.zip(&self.coverage).for_each(|(pixel, &coverage)| {
            if coverage > 0 {
                let alpha = f32::from(coverage) / 255.0 * color.alpha;
                *pixel = over(*pixel, color, alpha);
            }
        });
    }

    /// Makes lines fainter where so many are that none can be told: the mean
    /// coverage of a neighbourhood is held below a limit.
    pub fn thin(&mut self) {
        /// Half a side of the neighbourhood in pixels.
        const REACH: usize = 12;
        const LIMIT: f32 = 0.12;
        let [width, height] = [self.width, self.height].map(|side| side as usize);
        // Sums over all pixels above and to the left.
        let mut sums = vec![0u64; (width + 1) * (height + 1)];
        for (y, row) in self.coverage.chunks(width.max(1)).enumerate() {
            let mut sum = 0;
            for (x, &coverage) in row.iter().enumerate() {
                sum += u64::from(coverage);
                sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + sum;
            }
        }
        let rows = self.coverage.par_chunks_mut(width.max(1)).enumerate();
        rows.for_each(|(y, row)| {
            let (top, bottom) = (y.saturating_sub(REACH), (y + REACH).min(height));
            for (x, value) in row.iter_mut().enumerate().filter(|(_, v)| **v > 0) {
                let (left, right) = (x.saturating_sub(REACH), (x + REACH).min(width));
                let at = |y: usize, x: usize| sums[y * (width + 1) + x];
                let sum = at(bottom, right) + at(top, left) - at(top, right) - at(bottom, left);
                let mean = sum as f32 / 255.0 / ((bottom - top) * (right - left)) as f32;
                let share = (LIMIT / mean.max(LIMIT)).powi(2);
                *value = (f32::from(*value) * share).round() as u8;
            }
        });
    }
}

/// What is visible of a line, and what is hidden.
pub(crate) struct LineLayers {
    pub visible: Layer,
    /// Only where it is wanted.
    pub hidden: Option<Layer>,
}

impl LineLayers {
    pub fn new(width: u32, height: u32, hidden: bool) -> Self {
        Self {
            visible: Layer::new(width, height),
            hidden: hidden.then(|| Layer::new(width, height)),
        }
    }

    /// Adds a segment; what the frame hides of it goes, dashed, to the hidden
    /// layer.
    pub fn draw(&mut self, frame: &Drawn, segment: &Segment, width: f64) {
        let length = segment.a.truncate().distance(segment.b.truncate());
        let (mut seen, mut dashes) = (Vec::new(), Vec::new());
        self.visible.trace(segment, width, |x, y, coverage, t| {
            if frame.shows_at(x, y, segment.a.lerp(segment.b, t)) {
                seen.push((x, y, coverage));
            } else if (segment.start + length * t).rem_euclid(DASH[0] + DASH[1]) < DASH[0] {
                dashes.push((x, y, coverage));
            }
        });
        for (x, y, coverage) in seen {
            self.visible.raise(x, y, coverage);
        }
        if let Some(hidden) = &mut self.hidden {
            for (x, y, coverage) in dashes {
                hidden.raise(x, y, coverage);
            }
        }
    }
}

/// A renderer's last frame, and what it shows.
#[derive(Clone, Copy)]
pub(crate) struct Drawn<'a> {
    pub renderer: &'a Renderer,
    pub scene: &'a Prepared,
    pub matrix: &'a FrameMatrix,
}

impl Drawn<'_> {
    /// Whether a point of the window on the surface of what is drawn is seen
    /// at a pixel that the line around it touches.
    fn shows_at(&self, x: u32, y: u32, point: DVec3) -> bool {
        let of_edge = self.shows_on_triangles(x, y, point);
        of_edge.unwrap_or_else(|| self.shows_nearby(x, y, point))
    }

    /// Whether a point of an edge is not behind one of the triangles that are
    /// drawn at a pixel or at one next to it and cover the point: exact, however
    /// thin a wall is. None where there is no such triangle: where they are smaller
    /// than pixels, or at the border of what is drawn.
    fn shows_on_triangles(&self, x: u32, y: u32, point: DVec3) -> Option<bool> {
        /// Of the depth, and more than rounding.
        const SAME: f64 = 1e-9;
        let at = point.truncate();
        let mut covered = None;
        for (x, y) in self.pixels_around(x, y) {
            let number = self.renderer.number(x, y).map(|(number, _)| number);
            if let Some(corners) = number.and_then(|number| self.triangle(number))
                && covers(corners, at)
                && let Some(plane) = plane_depth(corners, at)
            {
                if point.z * (1.0 + SAME) >= plane {
                    return Some(true);
                }
                covered = Some(false);
            }
        }
        covered
    }

    /// Whether a point is not behind what is drawn at a pixel or at one next to it,
    /// or not behind its plane. For surfaces slope: on both sides of an edge that
    /// two faces turn towards the viewer, what is drawn is nearer than the edge
    /// itself.
    fn shows_nearby(&self, x: u32, y: u32, point: DVec3) -> bool {
        let depth = point.z * (1.0 + 1e-4);
        self.pixels_around(x, y).any(|(x, y)| {
            let Some((number, kept)) = self.renderer.number(x, y) else {
                return true;
            };
            let corners = || self.triangle(number);
            let plane = || plane_depth(corners()?, point.truncate());
            depth >= f64::from(kept) || plane().is_some_and(|plane| depth >= plane)
        })
    }

    /// A pixel, and those next to it. Beyond the picture's border nothing is known.
    fn pixels_around(&self, x: u32, y: u32) -> impl Iterator<Item = (u32, u32)> {
        let last = (self.renderer.width - 1, self.renderer.height - 1);
        let columns = x.saturating_sub(1)..=(x + 1).min(last.0);
        let rows = y.saturating_sub(1)..=(y + 1).min(last.1);
        let around = rows.flat_map(move |y| columns.clone().map(move |x| (x, y)));
        std::iter::once((x, y)).chain(around)
    }

    /// The corners in the window of the triangle that a pixel shows, if all are
    /// before the viewer. Not of the cap of a section, which hides what is behind
    /// it, and is seen but from outside: no edge lies in a valley with it.
    fn triangle(&self, number: i32) -> Option<[DVec3; 3]> {
        let (triangle, None) = decode(number) else {
            return None;
        };
        let corners = self.scene.corners(triangle)?;
        let clip = corners.map(|corner| self.matrix.clip(corner));
        let is_before = clip.iter().all(|corner| corner.w > 0.0);
        is_before.then(|| clip.map(|corner| self.matrix.window(corner)))
    }
}

/// Whether a point of the window is in a triangle, or on its border.
fn covers([a, b, c]: [DVec3; 3], at: DVec2) -> bool {
    /// Of a triangle's width, and more than rounding.
    const BORDER: f64 = 1e-9;
    let [a, b, c] = [a, b, c].map(DVec3::truncate);
    let area = (b - a).perp_dot(c - a);
    let weight = |p: DVec2, q: DVec2| (q - p).perp_dot(at - p) / area;
    let weights = [weight(a, b), weight(b, c), weight(c, a)];
    weights.iter().all(|&weight| weight >= -BORDER)
}

/// The reversed depth of a triangle's plane at a point of the window, kept
/// between those of its corners.
fn plane_depth([a, b, c]: [DVec3; 3], at: DVec2) -> Option<f64> {
    let normal = (b - a).cross(c - a);
    let away = at - a.truncate();
    let depth = a.z - normal.truncate().dot(away) / normal.z;
    let (low, high) = (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z));
    depth.is_finite().then(|| depth.clamp(low, high))
}

/// Puts a polyline given in scene coordinates into the window, cut to the
/// view volume.
pub(crate) fn project_polyline(
    matrix: &FrameMatrix,
    points: impl Iterator<Item = DVec3>,
    mut segment: impl FnMut(Segment),
) {
    let mut previous = None;
    let mut start = 0.0;
    for p in points {
        let clip = matrix.clip(p);
        if let Some(from) = previous.replace(clip)
            && let Some((enter, leave)) = clip_segment(from, clip)
        {
            let a = matrix.window(from.lerp(clip, enter));
            let b = matrix.window(from.lerp(clip, leave));
            segment(Segment { a, b, start });
            start += a.truncate().distance(b.truncate());
        }
    }
}
