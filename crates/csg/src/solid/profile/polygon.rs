//! Polygons: their areas, their insides, where they cross, and how they lie in each other.

use std::cmp::Reverse;

use glam::DVec2;

use super::arcs::Arc;
use super::bent::{self, Bent};
use super::monotone::orient;
use super::side::{Side, find_pair, sides, slack};
use super::{Contour, Corner, FillRule};
use crate::error::ProfileFault;

/// The contour without repeated corners, straight ones and spikes; none if it
/// encloses nothing.
pub(super) fn cleaned(contour: &[Corner]) -> Result<Option<Contour>, ProfileFault> {
    if !contour
        .iter()
        .all(|corner| corner.point.is_finite() && corner.bend.is_finite())
    {
        return Err(ProfileFault::NotFinite {
            what: "every coordinate of a contour (if it is one: and not zero its size)",
        });
    }
    let mut corners: Contour = contour.to_vec();
    loop {
        let count = corners.len();
        let is_bent = !corners.iter().all(Corner::is_straight);
        if count < if is_bent { 2 } else { 3 } {
            return Ok(None);
        }
        let superfluous = |k: usize| {
            let before = corners[(k + count - 1) % count];
            let (here, after) = (corners[k], corners[(k + 1) % count]);
            here.point == after.point
                || before.is_straight()
                    && here.is_straight()
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
    /// Of contours that do not cross; they may touch in corners.
    pub(super) fn of(contours: &[Contour], rule: FillRule) -> Self {
        let areas: Vec<f64> = contours.iter().map(|c| bent::doubled_area(c)).collect();
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
            let middle = sides(&contours[k]).next().map(|side| side.at(0.5));
            let parent = larger
                .rev()
                .map(|Reverse(other)| other)
                .find(|&other| middle.is_some_and(|point| encloses(&contours[other], point)));
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

/// Whether a point lies within a contour of lines and arcs and not on its boundary: crossings
/// of the ray towards +x with chords, by exact predicates, and segments of discs.
pub(super) fn encloses(contour: &[Corner], point: DVec2) -> bool {
    let mut inside = false;
    for k in 0..contour.len() {
        let a = contour[k].point;
        let b = contour[(k + 1) % contour.len()].point;
        if (a.y > point.y) != (b.y > point.y) {
            let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
            inside ^= orient(low, high, point) > 0.0;
        }
        inside ^= match Bent::of(contour, k) {
            Some(Bent::Arc(arc)) => is_in_segment(&arc, point),
            Some(Bent::Parabola(_)) | None => false,
        };
    }
    inside
}

/// Whether a point lies between an arc and its chord; on the chord, as if it were a little more to
/// the right, and less above, as the ray has it.
fn is_in_segment(arc: &Arc, point: DVec2) -> bool {
    let along = arc.to - arc.from;
    let sides = [orient(arc.from, arc.to, point), -along.y, along.x];
    let side = sides.into_iter().find(|&side| side != 0.0);
    let beyond = side.is_some_and(|side| side * arc.sweep.signum() < 0.0);
    beyond && point.distance(arc.center) < arc.radius
}

/// The corners at which a polygon turns.
pub(super) fn without_straight(points: &[DVec2]) -> Vec<DVec2> {
    let corners: Contour = points.iter().copied().map(Corner::straight).collect();
    let clean = cleaned(&corners).ok().flatten().unwrap_or_default();
    clean.into_iter().map(|corner| corner.point).collect()
}

/// A place where two sides meet within rounding that are not neighbours, or neighbours in
/// more than their corner.
pub(super) fn crossing(contours: &[Contour]) -> Option<DVec2> {
    let mut all: Vec<Side> = Vec::new();
    let mut next: Vec<usize> = Vec::new();
    for contour in contours {
        let first = all.len();
        all.extend(sides(contour));
        next.extend(first + 1..all.len());
        next.resize(all.len(), first);
    }
    let slack = slack(all.iter());
    find_pair(&all, slack, |k, j| {
        // The corners that they share as neighbours; two arcs may share both.
        let shared = [
            (next[k] == j).then_some(all[k].to),
            (next[j] == k).then_some(all[k].from),
        ];
        meet_beyond(&all[k], &all[j], shared, slack)
    })
}

/// A place where two sides meet beyond the corners that they share.
fn meet_beyond(one: &Side, other: &Side, shared: [Option<DVec2>; 2], slack: f64) -> Option<DVec2> {
    // On one line or circle they meet in ends alone.
    for (one, other) in [(one, other), (other, one)] {
        let middle = one.at(0.5);
        if other.holds(middle, slack) {
            return Some(middle);
        }
    }
    let mut places = one.meet(other, slack).into_iter();
    places.find(|place| !shared.iter().flatten().any(|corner| corner == place))
}
