//! Anti-aliased, depth-tested lines and points.
//!
//! A line is the set of points within half its width of a segment; a pixel's
//! coverage falls from 1 to 0 over the pixel around that border (Gupta,
//! Sproull, 1981, with a box of one pixel). Coverage is collected in a layer
//! by maximum, so that joints of polylines are not darker than their parts
//! and order does not matter, and the layer is put over the picture once.

use std::ops::Range;

use csg::Color;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::blend::over;
use crate::clip::clip_segment;
use crate::frame::FrameMatrix;
use crate::image::Image;

/// The coverage of some lines or points, in 0..=1 for each pixel.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    width: u32,
    height: u32,
    coverage: Vec<u8>,
}

/// A segment in the window: x and y in pixels, z the reversed depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    pub a: DVec3,
    pub b: DVec3,
    /// Distance in pixels along the polyline to `a`, for dashes.
    pub start: f64,
}

/// Rows of a layer, for one thread.
pub(crate) struct Band<'a> {
    width: u32,
    first: u32,
    coverage: &'a mut [u8],
}

impl Band<'_> {
    /// Its columns and rows.
    pub fn region(&self) -> [Range<u32>; 2] {
        let rows = self.coverage.len() / (self.width as usize).max(1);
        [0..self.width, self.first..self.first + rows as u32]
    }

    /// Adds the coverage of one pixel.
    #[inline]
    pub fn raise(&mut self, x: u32, y: u32, coverage: f64) {
        let at = (y - self.first) as usize * self.width as usize + x as usize;
        if let Some(value) = self.coverage.get_mut(at) {
            *value = (*value).max((coverage * 255.0 + 0.5) as u8);
        }
    }
}

impl Segment {
    /// Calls `pixel` with column, row, coverage and the nearest parameter of
    /// the segment for all pixels of a region that it touches, if it is so wide.
    pub fn trace(
        &self,
        width: f64,
        [columns, rows]: &[Range<u32>; 2],
        mut pixel: impl FnMut(u32, u32, f64, f64),
    ) {
        let (a, b) = (self.a.truncate(), self.b.truncate());
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
        let low = [columns.start, rows.start].map(f64::from);
        let end = [columns.end, rows.end].map(|end| f64::from(end) - 1.0);
        let slope = if along[major] == 0.0 {
            0.0
        } else {
            along[minor] / along[major]
        };
        let spread = reach * (1.0 + slope * slope).sqrt() + slope.abs();
        let first = (a[major].min(b[major]) - reach).floor().max(low[major]);
        let last = (a[major].max(b[major]) + reach).floor().min(end[major]);
        let mut step = first;
        while step <= last {
            let centre = step + 0.5;
            let inside = centre.clamp(a[major].min(b[major]), a[major].max(b[major]));
            let middle = a[minor] + slope * (inside - a[major]);
            let mut across = (middle - spread).floor().max(low[minor]);
            let last = (middle + spread).floor().min(end[minor]);
            while across <= last {
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

    /// The rows that it may touch, if it is so wide.
    pub fn rows(&self, width: f64) -> [f64; 2] {
        let reach = width / 2.0 + 1.0;
        [
            self.a.y.min(self.b.y) - reach,
            self.a.y.max(self.b.y) + reach,
        ]
    }
}

impl Layer {
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            coverage: vec![0; width as usize * height as usize],
        }
    }

    /// All of it.
    fn whole(&mut self) -> Band<'_> {
        Band {
            width: self.width,
            first: 0,
            coverage: &mut self.coverage,
        }
    }

    /// Cuts it into bands of so many rows, the last of which may have fewer.
    pub fn bands(&mut self, rows: u32) -> impl Iterator<Item = Band<'_>> {
        let width = self.width;
        let values = (width as usize * rows as usize).max(1);
        let pieces = self.coverage.chunks_mut(values).zip(0..);
        pieces.map(move |(coverage, number)| Band {
            width,
            first: number * rows,
            coverage,
        })
    }

    /// Adds a segment without looking at depth.
    pub fn draw(&mut self, segment: &Segment, width: f64) {
        let mut band = self.whole();
        segment.trace(width, &band.region(), |x, y, coverage, _| {
            band.raise(x, y, coverage);
        });
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

/// Puts a polyline given in scene coordinates into the window, cut to the
/// view volume.
pub(crate) fn project_polyline(
    matrix: &FrameMatrix,
    points: impl Iterator<Item = DVec3>,
) -> impl Iterator<Item = Segment> {
    let mut previous = None;
    let mut start = 0.0;
    points.filter_map(move |p| {
        let clip = matrix.clip(p);
        let from = previous.replace(clip)?;
        let (enter, leave) = clip_segment(from, clip)?;
        let a = matrix.window(from.lerp(clip, enter));
        let b = matrix.window(from.lerp(clip, leave));
        let segment = Segment { a, b, start };
        start += a.truncate().distance(b.truncate());
        Some(segment)
    })
}
