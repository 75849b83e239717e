//! How far triangles of a face stray, fast.

use glam::DVec3;

use super::deviation::{Corner, Ratio, largest_inside, quarters, with_shrinkage};
use super::region::Region;
use super::shape::faces_out_in_the_middle;
use crate::program::Surface;

/// The distance of the triangle's farthest point to the surface to first order,
/// of corners on it. No bound, but fast.
#[inline(always)]
pub(super) fn estimate(surface: &Surface, region: &Region, corners: [DVec3; 3]) -> f64 {
    let largest = largest_inside(surface, corners);
    if let Some(round) = &region.round {
        return round.estimate(surface, largest, &corners);
    }
    let [p, q, r] = corners;
    largest / surface.gradient((p + q + r) / 3.0).length()
}

/// [`of_triangle`](super::deviation::of_triangle) for many triangles of one quadric's smooth part.
pub(super) struct Judge<'a> {
    surface: &'a Surface,
    region: &'a Region,
    tolerance: f64,
}

impl<'a> Judge<'a> {
    pub fn new(surface: &'a Surface, region: &'a Region, tolerance: f64) -> Self {
        Self {
            surface,
            region,
            tolerance,
        }
    }

    /// The bound of a triangle's distance; `None` for one that does not face
    /// outward, or hardly.
    #[inline(always)]
    pub fn judge(&self, corners: [&Corner; 3]) -> Option<f64> {
        /// Far from folded: the squared cosine between the triangle's normal
        /// and the surface's.
        const LEAST_COSINE_SQUARED: f64 = 0.04;
        let [p, q, r] = corners.map(|corner| corner.at);
        if self.region.round.is_some() {
            let faces_out = faces_out_in_the_middle(self.surface, self.region, [p, q, r]);
            return faces_out.then(|| self.region.bound(self.surface, [p, q, r]));
        }
        let normal = (q - p).cross(r - p);
        let sum = corners[0].gradient + corners[1].gradient + corners[2].gradient;
        let along = self.region.outward * normal.dot(sum);
        let square = sum.length_squared();
        if along <= 0.0 || along * along < LEAST_COSINE_SQUARED * normal.length_squared() * square {
            return None;
        }
        // Mostly the tolerance itself is a distance that the map shrinks.
        let ratio = Ratio::new(
            self.region.shrinkage,
            corners,
            quarters(self.surface, corners),
            sum * square.sqrt().recip(),
        );
        let bound = ratio.of(self.tolerance);
        if bound <= self.tolerance {
            return Some(bound);
        }
        let shrinkage = self.region.shrinkage;
        Some(with_shrinkage(self.surface, shrinkage, [p, q, r]))
    }
}
