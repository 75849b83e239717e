//! Contours of named points: their areas, and which lie within others.

use glam::DVec2;

/// A named point of a contour.
pub(crate) type Named = (DVec2, u32);

/// What lies within one contour.
pub(super) struct Region<'a> {
    pub outer: &'a [Named],
    /// Of the outer contour.
    pub bounds: [DVec2; 2],
    /// Of all within the outer contour, holes included.
    pub area: f64,
    pub holes: Vec<&'a [Named]>,
}

impl Region<'_> {
    /// Whether a hole lies within the outer contour, and does not fill it: then it is one around
    /// that.
    pub fn holds(&self, hole: &[Named]) -> bool {
        let [low, high] = self.bounds;
        let point = hole[0].0;
        let is_near = point.cmpge(low).all() && point.cmple(high).all();
        let leaves_some = || self.area + signed_area(hole) > rounding_of_area(self.outer);
        is_near && leaves_some() && is_within(hole, self.outer)
    }
}

pub(super) fn signed_area(contour: &[Named]) -> f64 {
    let origin = contour[0].0;
    let pairs = contour.iter().zip(contour.iter().cycle().skip(1));
    0.5 * pairs
        .map(|(a, b)| (a.0 - origin).perp_dot(b.0 - origin))
        .sum::<f64>()
}

/// What rounding may make of the area of a contour that goes back the way it came.
pub(super) fn rounding_of_area(contour: &[Named]) -> f64 {
    let origin = contour[0].0;
    let squares = contour.iter().map(|p| p.0.distance_squared(origin));
    4.0 * f64::EPSILON * contour.len() as f64 * squares.fold(0.0, f64::max)
}

pub(super) fn leftmost(contour: &[Named]) -> Named {
    let key = |p: &Named| (p.0.x, p.0.y);
    contour.iter().copied().fold(
        contour[0],
        |least, p| {
            if key(&p) < key(&least) { p } else { least }
        },
    )
}

/// Whether a hole lies inside a contour, which it may touch at corners.
fn is_within(hole: &[Named], contour: &[Named]) -> bool {
    let is_free = |p: &DVec2| contour.iter().all(|q| q.0 != *p);
    let corners = hole.iter().map(|p| p.0);
    let ends = hole.iter().zip(hole.iter().cycle().skip(1));
    let middles = ends.map(|(a, b)| a.0.midpoint(b.0));
    let free = corners.chain(middles).find(is_free);
    free.is_some_and(|point| contains(contour, point))
}

/// Whether a point lies inside a contour.
fn contains(contour: &[Named], point: DVec2) -> bool {
    let pairs = contour.iter().zip(contour.iter().cycle().skip(1));
    is_surrounded(pairs.map(|(a, b)| [a.0, b.0]), point)
}

/// Whether a point lies within closed contours, given edge by edge: the parity
/// of crossings of a ray.
pub(crate) fn is_surrounded(edges: impl Iterator<Item = [DVec2; 2]>, point: DVec2) -> bool {
    let crosses = |&[a, b]: &[DVec2; 2]| {
        let (a, b) = (a - point, b - point);
        (a.y > 0.0) != (b.y > 0.0) && (a.perp_dot(b) > 0.0) == (b.y > a.y)
    };
    edges.filter(crosses).count() % 2 == 1
}

/// The least and the greatest coordinates.
pub(super) fn bounds(points: impl Iterator<Item = DVec2>) -> [DVec2; 2] {
    let none = [DVec2::splat(f64::INFINITY), DVec2::splat(f64::NEG_INFINITY)];
    points.fold(none, |[low, high], p| [low.min(p), high.max(p)])
}
