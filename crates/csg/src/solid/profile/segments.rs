//! What contours with bent sides enclose: what their corners do, and segments between the sides
//! and their chords.
//!
//! The segments of sides that bend outwards are added, those of the others taken away. They are
//! cut until no segment meets another side or its segment, with one exception: beside a
//! corner at which one bends outwards and the next one inwards both may overlap, however
//! finely they are cut, where they are tangent. If their chords turn left there nothing within
//! the corners is in both, and what is in both is outside; if they turn right all around
//! the overlap is within the corners, and what is in both is inside: that segment is added last.

use std::f64::consts::FRAC_PI_4;

use glam::DVec2;

use super::arcs::Arc;
use super::bent::Bent;
use super::monotone::inside;
use super::plane_set::PlaneSet;
use super::polygon::{doubled_area, without_straight};
use super::{Contour, Corner};
use crate::elementary;
use crate::error::ProfileFault;
use crate::mesh::box_tree::{Bounds, BoxTree};
use crate::numeric::tolerance::IN_PROFILE;

/// What a contour with bent sides is made of, whose inside is on its left.
pub(super) struct Segments {
    /// Where the polygon of its chords turns; fewer than three of one that encloses nothing.
    pub corners: Vec<DVec2>,
    /// What is added to it.
    pub first: PlaneSet,
    /// What is taken away then.
    pub dents: PlaneSet,
    /// What is added last.
    pub last: PlaneSet,
}

impl Segments {
    pub(super) fn of(contour: Contour) -> Result<Self, ProfileFault> {
        let (contour, is_last) = parted(contour)?;
        let points: Vec<DVec2> = contour.iter().map(|corner| corner.point).collect();
        let [mut first, mut dents, mut last] = [const { Vec::new() }; 3];
        for (k, is_last) in is_last.into_iter().enumerate() {
            match Bent::of(&contour, k) {
                Some(side) if !side.turns_left() => dents.push(side.segment()),
                Some(side) if is_last => last.push(side.segment()),
                Some(side) => first.push(side.segment()),
                None => {}
            }
        }
        let [first, dents, last] = [first, dents, last].map(PlaneSet::any);
        Ok(Self {
            corners: without_straight(&points),
            first,
            dents,
            last,
        })
    }

    pub(super) fn enclosed(self) -> PlaneSet {
        let polygon = if self.corners.len() > 2 {
            inside(&self.corners)
        } else {
            PlaneSet::EMPTY
        };
        let first = PlaneSet::any(vec![polygon, self.first]);
        PlaneSet::any(vec![first.without(vec![self.dents]), self.last])
    }
}

impl Arc {
    /// A convex polygon around the arc and its chord, both ends its corners.
    pub(super) fn around(&self) -> Vec<DVec2> {
        let pieces = (self.sweep.abs() / FRAC_PI_4).ceil().max(1.0);
        let stretch = 1.0 / elementary::cos(0.5 * self.sweep / pieces);
        let mut points = vec![self.from];
        for piece in 0..pieces as usize {
            let middle = self.at((piece as f64 + 0.5) / pieces);
            points.push(self.center + (middle - self.center) * stretch);
        }
        points.push(self.to);
        points
    }
}

/// How often sides are halved to get them apart from others.
const ROUNDS: usize = 10;

/// Below how much points of contours are one.
fn slack<'a>(corners: impl Iterator<Item = &'a Corner>) -> f64 {
    let far = |most: f64, corner: &Corner| corner.point.abs().max_element().max(most);
    IN_PROFILE * corners.fold(0.0, far)
}

/// The contour with those of its bent sides halved that are to be cut.
fn halved(contour: &[Corner], cut: impl Fn(usize) -> bool) -> Contour {
    let mut finer = Vec::with_capacity(2 * contour.len());
    for (k, &corner) in contour.iter().enumerate() {
        match Bent::of(contour, k) {
            Some(side) if cut(k) => finer.extend(side.halved()),
            _ => finer.push(corner),
        }
    }
    finer
}

/// The contour with its bent sides cut as the segments need it, and which of them are to be added
/// last.
fn parted(mut contour: Contour) -> Result<(Contour, Vec<bool>), ProfileFault> {
    let slack = slack(contour.iter());
    let mut place = DVec2::ZERO;
    for _ in 0..=ROUNDS {
        let overlaps = Overlaps::of(&contour, slack);
        let Some(first) = overlaps.cut.iter().position(|&cut| cut) else {
            return Ok((contour, overlaps.right));
        };
        place = contour[first].point;
        contour = halved(&contour, |k| overlaps.cut[k]);
    }
    Err(ProfileFault::Crossing { place })
}

/// Contours with those of their bent sides that `are_such` cut until what is between these and their
/// chords meets no other side, nor what is between that and its chord, but in corners that both
/// share: then they cross where contours of chords do. A place at which that did not come to an
/// end is an error.
pub(super) fn apart(
    mut contours: Vec<Contour>,
    are_such: impl Fn(&Corner) -> bool,
) -> Result<Vec<Contour>, ProfileFault> {
    if !contours.iter().flatten().any(&are_such) {
        return Ok(contours);
    }
    let slack = slack(contours.iter().flatten());
    let mut place = DVec2::ZERO;
    for _ in 0..=ROUNDS {
        let all: Vec<(usize, usize)> = (0..contours.len())
            .flat_map(|of| (0..contours[of].len()).map(move |k| (of, k)))
            .collect();
        let hulls = all.iter().map(|&(of, k)| Hull::of(&contours[of], k));
        let hulls: Vec<Hull> = hulls.collect();
        let boxes: Vec<Bounds> = hulls.iter().map(Hull::bounds).collect();
        let tree = BoxTree::numbered(&boxes);
        let mut cut: Vec<Vec<bool>> = contours.iter().map(|c| vec![false; c.len()]).collect();
        let mut is_apart = true;
        for (index, &(of, k)) in all.iter().enumerate() {
            if !are_such(&contours[of][k]) {
                continue;
            }
            let meets = |other: u32| {
                let (its, j) = all[other as usize];
                let is_own = its == of;
                let shared = || Shared::of(&contours[of], k, j, slack);
                match is_own.then(shared).flatten() {
                    // There both chords are on one line.
                    Some(corner) => corner.turns_back,
                    None if is_own && j == k => false,
                    None => hulls[index].overlaps(&hulls[other as usize], -slack),
                }
            };
            if tree.any_overlapping(None, &boxes[index], &mut { meets }) {
                (cut[of][k], is_apart) = (true, false);
                place = contours[of][k].point;
            }
        }
        if is_apart {
            return Ok(contours);
        }
        let finer = contours.iter().zip(&cut);
        contours = finer
            .map(|(contour, cut)| halved(contour, |k| cut[k]))
            .collect();
    }
    Err(ProfileFault::Crossing { place })
}

/// Which way a side turns: 1 to the left, -1 to the right, 0 if it is straight.
fn turn(contour: &[Corner], k: usize) -> f64 {
    match Bent::of(contour, k) {
        Some(side) if side.turns_left() => 1.0,
        Some(_) => -1.0,
        None => 0.0,
    }
}

/// What segments overlap.
struct Overlaps {
    /// Whether an arc must be cut.
    cut: Vec<bool>,
    /// Whether an arc that bends outwards overlaps one that bends inwards beside a corner where
    /// their chords turn right.
    right: Vec<bool>,
}

impl Overlaps {
    fn of(contour: &[Corner], slack: f64) -> Self {
        let count = contour.len();
        let around: Vec<Hull> = (0..count).map(|k| Hull::of(contour, k)).collect();
        // As three corners may be of which no two sides are without one in common.
        let corners: Vec<DVec2> = contour.iter().map(|corner| corner.point).collect();
        let is_reversed = doubled_area(&corners) <= 0.0;
        let mut cut = vec![false; count];
        let (mut left, mut right) = (vec![false; count], vec![false; count]);
        let turns: Vec<f64> = (0..count).map(|k| turn(contour, k)).collect();
        for k in (0..count).filter(|&k| turns[k] != 0.0) {
            for other in (0..count).filter(|&other| other != k) {
                if !around[k].may_meet(&around[other]) {
                    continue;
                }
                // Corners within rounding of a chord are not to be taken for those beyond it.
                let Some(corner) = Shared::of(contour, k, other, slack) else {
                    cut[k] |= around[k].overlaps(&around[other], -slack);
                    continue;
                };
                if !(corner.turns_back || around[k].overlaps(&around[other], slack)) {
                    continue;
                }
                match turns[k] * turns[other] < 0.0 {
                    true if turns[k] < 0.0 => {}
                    true if corner.turn > 0.0 || count == 2 => left[k] = true,
                    true if corner.turn < 0.0 => right[k] = true,
                    _ => cut[k] = true,
                }
            }
            cut[k] |= right[k] && (left[k] || is_reversed);
        }
        Self { cut, right }
    }
}

/// The corner that two neighbours share.
struct Shared {
    /// How the chords turn there, positive to the left; 0 where they go straight on, or back.
    turn: f64,
    turns_back: bool,
}

impl Shared {
    fn of(contour: &[Corner], k: usize, other: usize, slack: f64) -> Option<Self> {
        let next = |k: usize| (k + 1) % contour.len();
        let first = if next(k) == other {
            k
        } else if next(other) == k {
            other
        } else {
            return None;
        };
        let (second, third) = (next(first), next(next(first)));
        let [a, b, c] = [first, second, third].map(|k| contour[k].point);
        let (to, from) = (b - a, c - b);
        let across = to.perp_dot(from);
        let is_straight = across.abs() <= slack * to.length().max(from.length());
        Some(Self {
            turn: if is_straight { 0.0 } else { across },
            turns_back: is_straight && to.dot(from) < 0.0,
        })
    }
}

/// A convex polygon around a side and its chord, and its least and greatest coordinates.
struct Hull {
    points: Vec<DVec2>,
    min: DVec2,
    max: DVec2,
}

impl Hull {
    /// Around the side from corner k.
    fn of(contour: &[Corner], k: usize) -> Self {
        let points = match Bent::of(contour, k) {
            Some(side) => side.around(),
            None => vec![contour[k].point, contour[(k + 1) % contour.len()].point],
        };
        let (mut min, mut max) = (points[0], points[0]);
        for &point in &points {
            (min, max) = (min.min(point), max.max(point));
        }
        Self { points, min, max }
    }

    fn bounds(&self) -> Bounds {
        let [low, high] = [self.min, self.max].map(|corner| corner.extend(0.0));
        Bounds { low, high }
    }

    fn may_meet(&self, other: &Self) -> bool {
        !(self.max.cmplt(other.min) | other.max.cmplt(self.min)).any()
    }

    /// Whether they overlap by more than `slack`: no side of either separates them.
    fn overlaps(&self, other: &Self, slack: f64) -> bool {
        let [a, b] = [&self.points[..], &other.points[..]];
        let separates = |one: &[DVec2], other: &[DVec2]| {
            (0..one.len()).any(|k| {
                let (from, to) = (one[k], one[(k + 1) % one.len()]);
                let Some(across) = (to - from).perp().try_normalize() else {
                    return false;
                };
                let range = |points: &[DVec2]| {
                    points
                        .iter()
                        .fold((f64::INFINITY, f64::NEG_INFINITY), |range, p| {
                            let value = across.dot(*p - from);
                            (range.0.min(value), range.1.max(value))
                        })
                };
                let (one, other) = (range(one), range(other));
                one.1 <= other.0 + slack || other.1 <= one.0 + slack
            })
        };
        !(separates(a, b) || separates(b, a))
    }
}
