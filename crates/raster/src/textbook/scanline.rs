//! Scan-line filling with linear interpolation: the documented reference.
//!
//! For each row of samples that a triangle crosses, the two edges it crosses
//! give the ends of a span; values are interpolated linearly along the edges,
//! then along the span. Rows from the top vertex (inclusive) to the bottom one
//! (exclusive), samples from the left edge (inclusive) to the right one
//! (exclusive): with the ends computed exactly, this is the top-left rule, and
//! covers the same samples as the edge functions of [`fixed`](crate::fixed).

use std::ops::Range;

use crate::fixed::{FixedPoint, SUBPIXELS, doubled_area};

/// Smallest k with sample k of a row or column at or after `position`: that
/// is, k * 256 + 128 >= numerator / denominator, for a positive denominator.
fn first_sample(numerator: i128, denominator: i128) -> i32 {
    let half = i128::from(SUBPIXELS) / 2;
    let a = numerator - half * denominator;
    let b = i128::from(SUBPIXELS) * denominator;
    // Rounds up, for either sign.
    let k = -(-a).div_euclid(b);
    k.clamp(i128::from(i32::MIN), i128::from(i32::MAX)) as i32
}

/// A row of samples covered by a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span<const N: usize> {
    /// The row.
    pub y: i32,
    /// First column covered.
    pub start: i32,
    /// First column not covered any more.
    pub end: i32,
    /// The interpolated values at the first sample.
    pub values: [f64; N],
    /// Their change from one sample to the next.
    pub step: [f64; N],
}

/// Calls `span` for every row of samples that a triangle covers inside a
/// picture of `width` x `height` pixels, from the top down. `values` are given
/// at the corners. A triangle without area covers nothing.
pub fn scan_convert<const N: usize>(
    corners: [FixedPoint; 3],
    values: [[f64; N]; 3],
    width: i32,
    height: i32,
    span: impl FnMut(Span<N>),
) {
    scan_convert_rows(corners, values, width, 0..height, span);
}

/// The rows of samples that a triangle covers.
#[must_use]
pub fn rows_of(corners: [FixedPoint; 3]) -> Range<i32> {
    let row = |y: i32| first_sample(i128::from(y), 1);
    let [a, b, c] = corners.map(|corner| corner[1]);
    row(a.min(b).min(c))..row(a.max(b).max(c))
}

/// [`scan_convert`] in some rows only.
pub fn scan_convert_rows<const N: usize>(
    corners: [FixedPoint; 3],
    values: [[f64; N]; 3],
    width: i32,
    rows: Range<i32>,
    mut span: impl FnMut(Span<N>),
) {
    if doubled_area(corners) == 0 {
        return;
    }
    let mut order = [0, 1, 2];
    order.sort_by_key(|&k| (corners[k][1], corners[k][0]));
    let [top, middle, bottom] = order;
    let row = |k: usize| first_sample(i128::from(corners[k][1]), 1);
    for y in row(top).max(rows.start)..row(bottom).min(rows.end) {
        // The long edge, and the one of the two short ones at this row.
        let short = if y < row(middle) {
            (top, middle)
        } else {
            (middle, bottom)
        };
        let one = crossing(corners, values, (top, bottom), y);
        let other = crossing(corners, values, short, y);
        let (left, right) = if one.x <= other.x {
            (one, other)
        } else {
            (other, one)
        };
        let (start, end) = (left.first.max(0), right.first.min(width));
        if start >= end {
            continue;
        }
        let length = right.x - left.x;
        let mut step = [0.0; N];
        let mut first = left.values;
        for k in 0..N {
            if length > 0.0 {
                step[k] = (right.values[k] - left.values[k]) / length;
            }
            first[k] += step[k] * (f64::from(start) + 0.5 - left.x);
        }
        span(Span {
            y,
            start,
            end,
            values: first,
            step,
        });
    }
}

/// Where an edge crosses a row of samples.
struct Crossing<const N: usize> {
    /// In pixels.
    x: f64,
    /// First column whose sample is at or after it.
    first: i32,
    values: [f64; N],
}

fn crossing<const N: usize>(
    corners: [FixedPoint; 3],
    values: [[f64; N]; 3],
    (upper, lower): (usize, usize),
    y: i32,
) -> Crossing<N> {
    let [x0, y0] = corners[upper].map(i128::from);
    let [x1, y1] = corners[lower].map(i128::from);
    let sample = i128::from(y) * i128::from(SUBPIXELS) + i128::from(SUBPIXELS) / 2;
    // x = x0 + (x1 - x0) (sample - y0) / (y1 - y0), as a fraction; the row
    // lies between the ends, so y1 > y0.
    let denominator = (y1 - y0).max(1);
    let numerator = x0 * denominator + (x1 - x0) * (sample - y0);
    let t = (sample - y0) as f64 / denominator as f64;
    let mut mixed = values[upper];
    for (value, end) in mixed.iter_mut().zip(values[lower]) {
        *value += (end - *value) * t;
    }
    Crossing {
        x: numerator as f64 / denominator as f64 / f64::from(SUBPIXELS),
        first: first_sample(numerator, denominator),
        values: mixed,
    }
}
