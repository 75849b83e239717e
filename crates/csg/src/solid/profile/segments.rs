//! What contours with arcs enclose: what their corners do, and segments of discs.
//!
//! The segments of arcs that bend outwards are added, those of the others taken away. Arcs are
//! cut until no segment meets another side or its segment, with one exception: beside a
//! corner at which one bends outwards and the next one inwards both may overlap, however
//! finely they are cut, where they are tangent. If their chords turn left there nothing within
//! the corners is in both, and what is in both is outside; if they turn right all around
//! the overlap is within the corners, and what is in both is inside: that segment is added last.

use std::f64::consts::FRAC_PI_4;

use glam::DVec2;

use super::arcs::{Arc, side};
use super::monotone::inside;
use super::plane_set::{Leaf, PlaneSet};
use super::polygon::{doubled_area, without_straight};
use super::{Contour, Corner};
use crate::elementary;
use crate::error::ProfileFault;
use crate::numeric::tolerance::IN_PROFILE;

/// What a contour with arcs encloses, whose inside is on its left.
pub(super) fn enclosed_by_arcs(contour: Contour) -> Result<PlaneSet, ProfileFault> {
    let (contour, is_last) = parted(contour)?;
    let points: Vec<DVec2> = contour.iter().map(|corner| corner.point).collect();
    let corners = without_straight(&points);
    let mut first = vec![if corners.len() > 2 {
        inside(&corners)
    } else {
        PlaneSet::EMPTY
    }];
    let (mut dents, mut last) = (Vec::new(), Vec::new());
    for (k, is_last) in is_last.into_iter().enumerate() {
        match side(&contour, k).1 {
            Some(arc) if arc.sweep < 0.0 => dents.push(arc.segment()),
            Some(arc) if is_last => last.push(arc.segment()),
            Some(arc) => first.push(arc.segment()),
            None => {}
        }
    }
    last.push(PlaneSet::any(first).without(dents));
    Ok(PlaneSet::any(last))
}

impl Arc {
    /// A convex polygon around the arc and its chord, both ends its corners.
    fn around(&self) -> Vec<DVec2> {
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

    /// What lies between the arc and its chord.
    pub(super) fn segment(&self) -> PlaneSet {
        // On the right of the chord if the arc turns left.
        let [from, to] = if self.sweep > 0.0 {
            [self.to, self.from]
        } else {
            [self.from, self.to]
        };
        PlaneSet::all(vec![
            PlaneSet::leaf(Leaf::Disc(self.disc())),
            PlaneSet::leaf(Leaf::HalfPlane { from, to }),
        ])
    }
}

/// The contour with its arcs cut as the segments need it, and which of them are to be added last.
fn parted(mut contour: Contour) -> Result<(Contour, Vec<bool>), ProfileFault> {
    const ROUNDS: usize = 10;
    let far = |most: f64, corner: &Corner| corner.point.abs().max_element().max(most);
    let slack = IN_PROFILE * contour.iter().fold(0.0, far);
    let mut place = DVec2::ZERO;
    for _ in 0..=ROUNDS {
        let overlaps = Overlaps::of(&contour, slack);
        let Some(first) = overlaps.cut.iter().position(|&cut| cut) else {
            return Ok((contour, overlaps.right));
        };
        place = contour[first].point;
        let mut finer = Vec::with_capacity(2 * contour.len());
        for (k, &corner) in contour.iter().enumerate() {
            match side(&contour, k).1 {
                Some(arc) if overlaps.cut[k] => {
                    let bulge = elementary::tan(arc.sweep / 8.0);
                    for point in [corner.point, arc.at(0.5)] {
                        finer.push(Corner { point, bulge });
                    }
                }
                _ => finer.push(corner),
            }
        }
        contour = finer;
    }
    Err(ProfileFault::Crossing { place })
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
        let around: Vec<Vec<DVec2>> = (0..count)
            .map(|k| match side(contour, k) {
                (_, Some(arc)) => arc.around(),
                (next, None) => vec![contour[k].point, next],
            })
            .collect();
        let boxes: Vec<(DVec2, DVec2)> = around
            .iter()
            .map(|points| {
                let first = (points[0], points[0]);
                let grown = |(min, max): (DVec2, DVec2), &p: &DVec2| (min.min(p), max.max(p));
                points.iter().fold(first, grown)
            })
            .collect();
        // As three corners may be of which no two sides are without one in common.
        let corners: Vec<DVec2> = contour.iter().map(|corner| corner.point).collect();
        let is_reversed = doubled_area(&corners) <= 0.0;
        let mut cut = vec![false; count];
        let (mut left, mut right) = (vec![false; count], vec![false; count]);
        for k in (0..count).filter(|&k| contour[k].bulge != 0.0) {
            for other in (0..count).filter(|&other| other != k) {
                let apart = boxes[k].1.cmplt(boxes[other].0) | boxes[other].1.cmplt(boxes[k].0);
                if apart.any() {
                    continue;
                }
                // Corners within rounding of a chord are not to be taken for those beyond it.
                let Some(corner) = Shared::of(contour, k, other, slack) else {
                    cut[k] |= overlap(&around[k], &around[other], -slack);
                    continue;
                };
                if !(corner.turns_back || overlap(&around[k], &around[other], slack)) {
                    continue;
                }
                match corner.bends {
                    true if contour[k].bulge < 0.0 => {}
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
    /// Whether one bends outwards and the other one inwards.
    bends: bool,
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
            bends: contour[k].bulge * contour[other].bulge < 0.0,
        })
    }
}

/// Whether two convex polygons overlap by more than `slack`: no side of either
/// separates them.
fn overlap(a: &[DVec2], b: &[DVec2], slack: f64) -> bool {
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
