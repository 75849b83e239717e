//! Which triangles may be: those that face the way their surface does.

use glam::DVec3;

use super::region::{Bend, Region, Way};
use crate::numeric::tolerance::FLAT;
use crate::program::Surface;
use crate::surface::round::{Round, facing_cosine, facing_range, gradient, placed};

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

/// The same with the normal at the triangle's middle alone, which is enough
/// where triangles are small.
#[inline(always)]
pub(super) fn faces_out_in_the_middle(
    surface: &Surface,
    region: &Region,
    corners: [DVec3; 3],
) -> bool {
    if region.way == Way::Done {
        return true;
    }
    let round = region.round.as_ref();
    let corners = placed(round, corners);
    let Some(normal) = normal(corners) else {
        return false;
    };
    if region.bend == Bend::Flat {
        return region.outward * normal.dot(surface.linear) > 0.0;
    }
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    agree(
        normal,
        region.outward * gradient(surface, round, middle),
        LEAST_COSINE,
    )
}

/// How well a triangle faces out at its middle: the cosine of the angle between normals.
pub(super) fn outward_cosine(surface: &Surface, region: &Region, corners: [DVec3; 3]) -> f64 {
    region.outward * facing_cosine(surface, region.round.as_ref(), corners)
}

/// The same, and nowhere against it: no edge runs around more than half of a tube, on the
/// wrong side of its axis.
#[inline(always)]
pub(super) fn faces_out_everywhere(
    surface: &Surface,
    region: &Region,
    corners: [DVec3; 3],
) -> bool {
    faces_out_in_the_middle(surface, region, corners)
        && (region.way == Way::Done || outward_range(surface, region, corners)[0] >= 0.0)
}

/// The least and the most, of all points of a triangle, of how much it faces outward, in
/// units of no meaning.
#[inline(always)]
pub(super) fn outward_range(surface: &Surface, region: &Region, corners: [DVec3; 3]) -> [f64; 2] {
    let [least, most] = facing_range(surface, region.round.as_ref(), corners);
    if region.outward > 0.0 {
        [least, most]
    } else {
        [-most, -least]
    }
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
