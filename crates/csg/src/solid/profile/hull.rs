//! Convex hulls.

use glam::DVec2;

use super::Profile;
use super::monotone::orient;
use crate::error::ProfileFault;
use crate::numeric::tolerance::PROFILE_CHORD;

impl Profile {
    /// The least convex set around the profile: a polygon, arcs within 1e-4 of
    /// the profile's size (for another tolerance, see [`Profile::flattened`]).
    #[must_use]
    pub fn hull(&self) -> Self {
        let hull = || -> Result<Self, ProfileFault> {
            let tolerance = self.tolerance_of(PROFILE_CHORD)?;
            let points = self.contours(tolerance)?.concat();
            Ok(Self::hull_of(points))
        };
        Self::of(hull())
    }

    /// The convex hull of points; without any point if they lie on a line.
    #[must_use]
    pub fn hull_of<P: Into<DVec2>>(points: impl IntoIterator<Item = P>) -> Self {
        let points: Vec<DVec2> = points.into_iter().map(Into::into).collect();
        if !points.iter().all(|point| point.is_finite()) {
            return Self::faulty(ProfileFault::NotFinite { what: "a point" });
        }
        let corners = convex_hull(points);
        if corners.len() < 3 {
            return Self::empty();
        }
        Self::polygon(corners)
    }
}

/// The corners of the hull, counter-clockwise (A. M. Andrew, "Another efficient
/// algorithm for convex hulls in two dimensions", 1979), by exact predicates.
fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let mut hull: Vec<DVec2> = Vec::new();
    for back in [false, true] {
        let kept = hull.len();
        let mut add = |point: DVec2| {
            while hull.len() > kept + 1
                && orient(hull[hull.len() - 2], hull[hull.len() - 1], point) <= 0.0
            {
                hull.pop();
            }
            hull.push(point);
        };
        if back {
            points.iter().rev().copied().for_each(&mut add);
        } else {
            points.iter().copied().for_each(&mut add);
        }
        // The last point begins the other half.
        hull.pop();
    }
    hull
}
