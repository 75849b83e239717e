//! Fixed-point window coordinates and the exact definition of coverage.
//!
//! Vertices are snapped to 1/256 pixel; from there on coverage is integer
//! arithmetic and has no rounding. [`covers`] is the definition, which the
//! fast filler is tested against.

/// Number of fractional bits of a window coordinate.
pub const SUBPIXEL_BITS: u32 = 8;
/// Fixed-point units in a pixel.
pub const SUBPIXELS: i32 = 1 << SUBPIXEL_BITS;

/// A point of the window in units of 1/256 pixel, y downwards.
pub type FixedPoint = [i32; 2];

/// Snaps a window coordinate in pixels to 1/256, halves to even; `None` if it is not
/// finite or does not fit.
#[must_use]
pub fn snap(coordinate: f64) -> Option<i32> {
    let scaled = (coordinate * f64::from(SUBPIXELS)).round_ties_even();
    (scaled.abs() <= f64::from(1 << 30)).then_some(scaled as i32)
}

/// Twice the signed area of a triangle; positive if it is clockwise as seen
/// in the picture (y downwards).
#[must_use]
pub fn doubled_area([a, b, c]: [FixedPoint; 3]) -> i64 {
    edge(a, b, c)
}

/// The edge function of the directed edge from `a` to `b` at `p`: positive to
/// its right as seen in the picture (y downwards), 0 on its line (Pineda, *A
/// parallel algorithm for polygon rasterization*, SIGGRAPH 1988).
#[must_use]
pub fn edge(a: FixedPoint, b: FixedPoint, p: FixedPoint) -> i64 {
    let difference = |to: i32, from: i32| i64::from(to) - i64::from(from);
    difference(b[0], a[0]) * difference(p[1], a[1])
        - difference(b[1], a[1]) * difference(p[0], a[0])
}

/// Whether the edge from `a` to `b` of a clockwise triangle is a top edge
/// (horizontal, interior below) or a left edge (going up, interior to the
/// right). A sample exactly on an edge belongs to the triangle only if the
/// edge is one of these, so that of the two triangles at a shared edge
/// exactly one owns the sample.
#[must_use]
pub fn is_top_left(a: FixedPoint, b: FixedPoint) -> bool {
    b[1] < a[1] || (b[1] == a[1] && b[0] > a[0])
}

/// Whether a triangle of either orientation covers the sample `p`, by the
/// top-left rule; a triangle without area covers nothing.
#[must_use]
pub fn covers([a, b, c]: [FixedPoint; 3], p: FixedPoint) -> bool {
    let [a, b, c] = match doubled_area([a, b, c]) {
        0 => return false,
        area if area < 0 => [a, c, b],
        _ => [a, b, c],
    };
    [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
        let e = edge(from, to, p);
        e > 0 || (e == 0 && is_top_left(from, to))
    })
}
