//! What is seen of lines on the surface of what is drawn.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::frame::FrameMatrix;
use crate::line::{Band, Layer, Segment};
use crate::pipeline::Renderer;
use crate::prepared::Prepared;
use crate::tile::{NO_TRIANGLE, decode};

/// Length of a dash and of the gap after it, in pixels.
const DASH: [f64; 2] = [5.0, 4.0];
/// Rows that one thread draws at a time.
const ROWS: u32 = 32;

/// What is visible of a line, and what is hidden.
pub(crate) struct LineLayers {
    pub visible: Layer,
    /// Only where it is wanted.
    pub hidden: Option<Layer>,
}

/// The rows of both that one thread draws, and what lies there.
struct Bands<'a> {
    visible: Band<'a>,
    hidden: Option<Band<'a>>,
    segments: Vec<&'a Segment>,
}

impl LineLayers {
    pub fn new(width: u32, height: u32, hidden: bool) -> Self {
        Self {
            visible: Layer::new(width, height),
            hidden: hidden.then(|| Layer::new(width, height)),
        }
    }

    /// Adds segments of one width; what the frame hides of them goes, dashed, to
    /// the hidden layer.
    pub fn draw(&mut self, frame: Drawn, segments: &[Segment], width: f64) {
        let hidden = self.hidden.iter_mut().flat_map(|layer| layer.bands(ROWS));
        let hidden = hidden.map(Some).chain(std::iter::repeat_with(|| None));
        let visible = self.visible.bands(ROWS).zip(hidden);
        let mut bands: Vec<_> = visible
            .map(|(visible, hidden)| Bands {
                visible,
                hidden,
                segments: Vec::new(),
            })
            .collect();
        for segment in segments {
            // (None of it above the picture, or where it is nowhere.)
            let [first, last] = segment.rows(width).map(|row| row / f64::from(ROWS));
            let end = (last + 1.0).max(0.0) as usize;
            let end = end.min(bands.len());
            let first = (first.max(0.0) as usize).min(end);
            for band in &mut bands[first..end] {
                band.segments.push(segment);
            }
        }
        let bands = bands.into_par_iter();
        bands.for_each_init(|| Known::new(frame), |known, band| band.draw(known, width));
    }
}

impl Bands<'_> {
    fn draw(mut self, known: &mut Known, width: f64) {
        let region = self.visible.region();
        for segment in self.segments {
            let length = segment.a.truncate().distance(segment.b.truncate());
            segment.trace(width, &region, |x, y, coverage, t| {
                if known.shows_at(x, y, segment.a.lerp(segment.b, t)) {
                    self.visible.raise(x, y, coverage);
                } else if let Some(hidden) = &mut self.hidden
                    && (segment.start + length * t).rem_euclid(DASH[0] + DASH[1]) < DASH[0]
                {
                    hidden.raise(x, y, coverage);
                }
            });
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

/// A triangle in the window.
#[derive(Clone, Copy)]
struct Flat {
    corners: [DVec2; 3],
    /// Its sides over twice its area.
    sides: [DVec2; 3],
    /// Depth of the first corner, and how it changes to the right and downwards.
    depth: f64,
    slope: DVec2,
    /// The least and the greatest depth of a corner.
    range: [f64; 2],
}

impl Flat {
    fn new([a, b, c]: [DVec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        let corners = [a, b, c].map(DVec3::truncate);
        let [p, q, r] = corners;
        let area = (q - p).perp_dot(r - p);
        Self {
            corners,
            sides: [q - p, r - q, p - r].map(|side| side / area),
            depth: a.z,
            slope: -normal.truncate() / normal.z,
            range: [a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z)],
        }
    }

    /// Whether a point of the window is in it, or on its border.
    fn covers(&self, at: DVec2) -> bool {
        /// Of a triangle's width, and more than rounding.
        const BORDER: f64 = 1e-9;
        let sides = self.sides.iter().zip(&self.corners);
        sides
            .map(|(side, &corner)| side.perp_dot(at - corner))
            .all(|weight| weight >= -BORDER)
    }

    /// The reversed depth of its plane at a point of the window, kept between
    /// those of its corners.
    fn plane_depth(&self, at: DVec2) -> Option<f64> {
        let depth = self.depth + self.slope.dot(at - self.corners[0]);
        let [low, high] = self.range;
        depth.is_finite().then(|| depth.clamp(low, high))
    }
}

/// The triangles of a frame that were looked at last.
struct Known<'a> {
    frame: Drawn<'a>,
    /// By the last digits of their numbers.
    triangles: Vec<(i32, Option<Flat>)>,
}

impl<'a> Known<'a> {
    /// A power of two, small enough for a cache.
    const SIZE: usize = 64;

    fn new(frame: Drawn<'a>) -> Self {
        Self {
            frame,
            triangles: vec![(NO_TRIANGLE, None); Self::SIZE],
        }
    }

    fn triangle(&mut self, number: i32) -> Option<&Flat> {
        let place = number as usize % Self::SIZE;
        if self.triangles[place].0 != number {
            let corners = self.frame.triangle(number);
            self.triangles[place] = (number, corners.map(Flat::new));
        }
        self.triangles[place].1.as_ref()
    }

    /// Whether a point of the window on the surface of what is drawn is seen
    /// at a pixel that the line around it touches.
    fn shows_at(&mut self, x: u32, y: u32, point: DVec3) -> bool {
        let of_edge = self.shows_on_triangles(x, y, point);
        of_edge.unwrap_or_else(|| self.shows_nearby(x, y, point))
    }

    /// Whether a point of an edge is not behind one of the triangles that are
    /// drawn at a pixel or at one next to it and cover the point: exact, however
    /// thin a wall is. None where there is no such triangle: where they are smaller
    /// than pixels, or at the border of what is drawn.
    fn shows_on_triangles(&mut self, x: u32, y: u32, point: DVec3) -> Option<bool> {
        /// Of the depth, and more than rounding.
        const SAME: f64 = 1e-9;
        let at = point.truncate();
        let mut covered = None;
        let mut last = NO_TRIANGLE;
        let renderer = self.frame.renderer;
        for (x, y) in pixels_around(renderer, x, y) {
            let Some((number, _)) = renderer.number(x, y) else {
                continue;
            };
            if std::mem::replace(&mut last, number) == number {
                continue;
            }
            if let Some(triangle) = self.triangle(number)
                && triangle.covers(at)
                && let Some(plane) = triangle.plane_depth(at)
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
    fn shows_nearby(&mut self, x: u32, y: u32, point: DVec3) -> bool {
        let depth = point.z * (1.0 + 1e-4);
        let renderer = self.frame.renderer;
        pixels_around(renderer, x, y).any(|(x, y)| {
            let Some((number, kept)) = renderer.number(x, y) else {
                return true;
            };
            let plane = |flat: &Flat| flat.plane_depth(point.truncate());
            depth >= f64::from(kept)
                || self
                    .triangle(number)
                    .and_then(plane)
                    .is_some_and(|plane| depth >= plane)
        })
    }
}

/// A pixel, and those next to it. Beyond the picture's border nothing is known.
fn pixels_around(renderer: &Renderer, x: u32, y: u32) -> impl Iterator<Item = (u32, u32)> {
    let last = (renderer.width - 1, renderer.height - 1);
    let columns = x.saturating_sub(1)..=(x + 1).min(last.0);
    let rows = y.saturating_sub(1)..=(y + 1).min(last.1);
    let around = rows.flat_map(move |y| columns.clone().map(move |x| (x, y)));
    std::iter::once((x, y)).chain(around)
}
