//! Which triangles may be: those that face the way their surface does.

use glam::DVec3;

use super::region::{Bend, Region, Way};
use crate::numeric::tolerance::FLAT;
use crate::program::Surface;
use crate::surface::round::{Round, cosine, gradient, placed, range};

/// Of the angle between normals, in the middle: far from folded.
pub(super) const LEAST_COSINE: f64 = 0.2;

/// Whether the triangle's normal is within the angle of the given cosine of
/// the outward normal of its surface at each of its corners.
pub(super) fn faces_out(
    surface: &Surface,
    region: &Region,
    corners: [DVec3; 3],
    least_cosine: f64,
) -> bool {
    let round = region.round.as_ref();
    let corners = placed(round, corners);
    let Some(normal) = normal(corners) else {
        return false;
    };
    if region.bend == Bend::Flat {
        return region.outward * normal.dot(surface.linear) > 0.0;
    }
    let agrees = |corner| {
        let outward = region.outward * gradient(surface, round, corner);
        agree(normal, outward, least_cosine)
    };
    agrees(corners[0]) && agrees(corners[1]) && agrees(corners[2])
}

/// Points as they are looked at, of one face, and the outward gradient at each. Three of them
/// are a triangle, by their places.
#[derive(Clone, Copy)]
pub(super) struct Sight<'a, const N: usize> {
    region: &'a Region,
    at: [DVec3; N],
    outward: [DVec3; N],
}

impl<'a, const N: usize> Sight<'a, N> {
    #[inline(always)]
    pub fn new(surface: &Surface, region: &'a Region, points: [DVec3; N]) -> Self {
        let round = region.round.as_ref();
        let (mut at, mut outward) = (points, points);
        for k in 0..N {
            at[k] = round.map_or(points[k], |round| round.place(points[k]));
            outward[k] = region.outward * gradient(surface, round, at[k]);
        }
        Self {
            region,
            at,
            outward,
        }
    }

    /// Whether a triangle's normal is not far from the outward one at its middle, which is
    /// enough where triangles are small.
    #[inline(always)]
    pub fn faces_out_in_the_middle(&self, corners: [usize; 3]) -> bool {
        if self.region.way == Way::Done {
            return true;
        }
        let [p, q, r] = corners;
        let Some(normal) = normal([self.at[p], self.at[q], self.at[r]]) else {
            return false;
        };
        if self.region.bend == Bend::Flat {
            return normal.dot(self.outward[p]) > 0.0;
        }
        agree(normal, self.in_the_middle(corners), LEAST_COSINE)
    }

    /// The same, and nowhere against it: no edge runs around more than half of a tube, on the
    /// wrong side of its axis.
    #[inline(always)]
    pub fn faces_out_everywhere(&self, corners: [usize; 3]) -> bool {
        self.faces_out_in_the_middle(corners)
            && (self.region.bend == Bend::Flat
                || self.region.way == Way::Done
                || self.range(corners)[0] >= 0.0)
    }

    /// The outward gradient at a triangle's middle: a quadric's is linear in the point.
    #[inline(always)]
    fn in_the_middle(&self, [p, q, r]: [usize; 3]) -> DVec3 {
        (self.outward[p] + self.outward[q] + self.outward[r]) / 3.0
    }

    #[inline(always)]
    fn normal(&self, [p, q, r]: [usize; 3]) -> DVec3 {
        (self.at[q] - self.at[p]).cross(self.at[r] - self.at[p])
    }

    /// How well a triangle faces out at its middle: the cosine of the angle between normals.
    pub fn cosine(&self, corners: [usize; 3]) -> f64 {
        cosine(self.normal(corners), self.in_the_middle(corners))
    }

    /// The least and the most, of all points of a triangle, of how much it faces outward, in
    /// units of no meaning.
    #[inline(always)]
    pub fn range(&self, corners: [usize; 3]) -> [f64; 2] {
        let normal = self.normal(corners);
        let [p, q, r] = corners;
        let along = |k: usize| normal.dot(self.outward[k]);
        range([along(p), along(q), along(r)])
    }
}

/// [`Sight::faces_out_in_the_middle`] of a triangle by its corners.
#[inline(always)]
pub(super) fn faces_out_in_the_middle(
    surface: &Surface,
    region: &Region,
    corners: [DVec3; 3],
) -> bool {
    Sight::new(surface, region, corners).faces_out_in_the_middle([0, 1, 2])
}

/// [`Sight::faces_out_everywhere`] of a triangle by its corners.
#[inline(always)]
pub(super) fn faces_out_everywhere(
    surface: &Surface,
    region: &Region,
    corners: [DVec3; 3],
) -> bool {
    Sight::new(surface, region, corners).faces_out_everywhere([0, 1, 2])
}

/// Whether a triangle that has an area faces into the solid.
pub(super) fn faces_in(surface: &Surface, region: &Region, corners: [DVec3; 3]) -> bool {
    region.outward * facing(surface, region.round.as_ref(), corners) < 0.0
}

/// 1 if a triangle that has an area faces along its surface's gradient next to its middle,
/// -1 if against it; else 0.
#[inline(always)]
pub(super) fn facing(surface: &Surface, round: Option<&Round>, corners: [DVec3; 3]) -> f64 {
    let corners = placed(round, corners);
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let along = normal(corners).map_or(0.0, |n| n.dot(gradient(surface, round, middle)));
    f64::from(i8::from(along > 0.0) - i8::from(along < 0.0))
}

/// How much of a triangle faces out, with a sign, in units of no meaning.
pub(super) fn outward_area(surface: &Surface, region: &Region, corners: [DVec3; 3]) -> f64 {
    let round = region.round.as_ref();
    let [p, q, r] = placed(round, corners);
    let gradient = gradient(surface, round, (p + q + r) / 3.0);
    region.outward * (q - p).cross(r - p).dot(gradient)
}

/// Twice the area times the unit normal, if there is an area.
#[inline(always)]
fn normal([p, q, r]: [DVec3; 3]) -> Option<DVec3> {
    let normal = (q - p).cross(r - p);
    let longest = (q - p)
        .length_squared()
        .max((r - q).length_squared())
        .max((p - r).length_squared());
    let limit = FLAT * longest;
    (normal.length_squared() > limit * limit).then_some(normal)
}

#[inline(always)]
fn agree(normal: DVec3, gradient: DVec3, least_cosine: f64) -> bool {
    let along = normal.dot(gradient);
    let lengths = normal.length_squared() * gradient.length_squared();
    // At an apex the gradient says nothing.
    along >= 0.0 && along * along >= least_cosine * least_cosine * lengths
}
