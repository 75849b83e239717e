//! Polygons: their areas, their insides, where they cross, and how they lie in each other.

use std::cmp::Reverse;

use glam::DVec2;

use super::arcs::trace;
use super::monotone::orient;
use super::{Contour, Corner, FillRule};
use crate::error::ProfileFault;

/// The contour without repeated corners, straight ones and spikes; none if it
/// encloses nothing.
pub(super) fn cleaned(contour: &[Corner]) -> Result<Option<Contour>, ProfileFault> {
    if !contour
        .iter()
        .all(|corner| corner.point.is_finite() && corner.bulge.is_finite())
    {
        return Err(ProfileFault::NotFinite {
            what: "every coordinate of a contour (if it is one: and not zero its size)",
        });
    }
    let mut corners: Contour = contour.to_vec();
    loop {
        let count = corners.len();
        let has_arcs = corners.iter().any(|corner| corner.bulge != 0.0);
        if count < if has_arcs { 2 } else { 3 } {
            return Ok(None);
        }
        let superfluous = |k: usize| {
            let before = corners[(k + count - 1) % count];
            let (here, after) = (corners[k], corners[(k + 1) % count]);
            here.point == after.point
                || before.bulge == 0.0
                    && here.bulge == 0.0
                    && orient(before.point, here.point, after.point) == 0.0
        };
        let keep: Vec<bool> = {
            // Of two neighbours only one goes at a time: their neighbours change.
            let mut keep = vec![true; count];
            for k in 0..count {
                if (k == 0 || keep[k - 1]) && (k + 1 < count || keep[0]) && superfluous(k) {
                    keep[k] = false;
                }
            }
            keep
        };
        if !keep.contains(&false) {
            return Ok(Some(corners));
        }
        let mut keep = keep.into_iter();
        corners.retain(|_| keep.next().unwrap_or(true));
    }
}

/// How contours lie in each other.
pub(super) struct Nesting {
    /// The largest first.
    pub order: Vec<usize>,
    /// The least contour around each.
    pub parents: Vec<Option<usize>>,
    /// Whether a contour bounds the set, rather than lying within or outside.
    pub bounds: Vec<bool>,
    /// Whether the set is on its inner side.
    pub inside: Vec<bool>,
}

impl Nesting {
    pub(super) fn of(contours: &[Vec<DVec2>], rule: FillRule) -> Self {
        let areas: Vec<f64> = contours.iter().map(|c| doubled_area(c)).collect();
        let mut order: Vec<usize> = (0..contours.len()).collect();
        order.sort_by(|&a, &b| areas[b].abs().total_cmp(&areas[a].abs()).then(a.cmp(&b)));
        let mut nesting = Self {
            parents: vec![None; contours.len()],
            bounds: vec![true; contours.len()],
            inside: vec![true; contours.len()],
            order,
        };
        let mut windings = vec![0_i64; contours.len()];
        for (rank, &k) in nesting.order.iter().enumerate() {
            let larger = nesting.order[..rank].iter().copied().map(Reverse);
            let parent = larger
                .rev()
                .map(|Reverse(other)| other)
                .find(|&other| encloses(&contours[other], contours[k][0]));
            let around = parent.map_or(0, |parent| windings[parent]);
            windings[k] = around + if areas[k] > 0.0 { 1 } else { -1 };
            nesting.parents[k] = parent;
            nesting.inside[k] = rule.is_inside(windings[k]);
            nesting.bounds[k] = nesting.inside[k] != rule.is_inside(around);
        }
        nesting
    }
}

pub(super) fn points_of(contours: &[Contour]) -> Vec<Vec<DVec2>> {
    contours
        .iter()
        .map(|contour| contour.iter().map(|corner| corner.point).collect())
        .collect()
}

/// Twice the area of a polygon: positive if counter-clockwise.
pub(crate) fn doubled_area(points: &[DVec2]) -> f64 {
    let Some(&base) = points.first() else {
        return 0.0;
    };
    let sides = points.iter().zip(points.iter().cycle().skip(1));
    sides.map(|(&a, &b)| (a - base).perp_dot(b - base)).sum()
}

/// Whether a point lies within a polygon and not on its boundary: crossings
/// of the ray towards +x, by exact predicates.
pub(super) fn encloses(polygon: &[DVec2], point: DVec2) -> bool {
    let mut inside = false;
    for (&a, &b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        if (a.y > point.y) != (b.y > point.y) {
            let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
            inside ^= orient(low, high, point) > 0.0;
        }
    }
    inside
}

/// The corners at which a polygon turns.
pub(super) fn without_straight(points: &[DVec2]) -> Vec<DVec2> {
    let corners: Contour = points.iter().copied().map(Corner::straight).collect();
    let clean = cleaned(&corners).ok().flatten().unwrap_or_default();
    clean.into_iter().map(|corner| corner.point).collect()
}

/// A place where two sides meet that are not neighbours, or neighbours in more
/// than their corner; arcs as fine polygons. Sides are sorted by x.
pub(super) fn crossing(contours: &[Contour]) -> Option<DVec2> {
    let mut sides: Vec<(DVec2, DVec2, usize, usize)> = Vec::new();
    for contour in contours {
        let points = trace(contour);
        let (first, count) = (sides.len(), points.len());
        for k in 0..count {
            let next = first + (k + 1) % count;
            sides.push((points[k], points[(k + 1) % count], first + k, next));
        }
    }
    sides.sort_by(|a, b| a.0.x.min(a.1.x).total_cmp(&b.0.x.min(b.1.x)));
    for (rank, &(a, b, own, next)) in sides.iter().enumerate() {
        let reach = a.x.max(b.x);
        for &(c, d, other, after) in &sides[rank + 1..] {
            if c.x.min(d.x) > reach {
                break;
            }
            if a.y.max(b.y) < c.y.min(d.y) || c.y.max(d.y) < a.y.min(b.y) {
                continue;
            }
            let meet = if next == other {
                after != own && folds_back(a, b, d)
            } else if after == own {
                folds_back(c, d, b)
            } else {
                sides_meet(a, b, c, d)
            };
            if meet {
                return Some(a.midpoint(b).midpoint(c.midpoint(d)));
            }
        }
    }
    None
}

/// Whether the side from b to c lies on the one from a to b.
fn folds_back(a: DVec2, b: DVec2, c: DVec2) -> bool {
    orient(a, b, c) == 0.0 && (a - b).dot(c - b) > 0.0
}

fn sides_meet(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let ends = [orient(a, b, c), orient(a, b, d)];
    let others = [orient(c, d, a), orient(c, d, b)];
    let apart = |[p, q]: [f64; 2]| p > 0.0 && q > 0.0 || p < 0.0 && q < 0.0;
    // Boxes overlap: on one line that is a meeting.
    !apart(ends) && !apart(others)
}
