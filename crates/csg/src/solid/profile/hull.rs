//! Convex hulls.

use std::f64::consts::TAU;

use glam::DVec2;

use super::monotone::orient;
use super::path::Path;
use super::{Combination, Profile, Shape, Step};
use crate::elementary;
use crate::error::ProfileFault;
use crate::numeric::tolerance::{IN_PROFILE, PROFILE_CHORD};

impl Profile {
    /// The least convex set around the profile. Where [`Profile::exact_hull`] has none it is a
    /// polygon, arcs within 1e-4 of the profile's size (for another tolerance, see
    /// [`Profile::flattened`]).
    #[must_use]
    pub fn hull(&self) -> Self {
        if let Some(hull) = self.exact_hull() {
            return hull;
        }
        let hull = || -> Result<Self, ProfileFault> {
            let tolerance = self.tolerance_of(PROFILE_CHORD)?;
            let points = self.contours(tolerance)?.concat();
            Ok(Self::hull_of(points))
        };
        Self::of(hull())
    }

    /// The least convex set around the profile, if this is a union of circles and polygons
    /// ([`Profile::hull_of_discs`]), or if no arc around it bends outwards.
    #[must_use]
    pub fn exact_hull(&self) -> Option<Self> {
        if let Some(discs) = self.discs() {
            return Some(Self::hull_of_discs(discs));
        }
        if self.is_straight() {
            // No chords, whatever their tolerance.
            return Some(Self::of(
                self.contours(1.0).map(|c| Self::hull_of(c.concat())),
            ));
        }
        let corners = self.outline()?.concat();
        let is_flat = corners.iter().all(|corner| corner.bulge() <= 0.0);
        is_flat.then(|| Self::hull_of(corners.into_iter().map(|corner| corner.point)))
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

    /// The convex hull of discs, each a centre and a radius, which may be 0: arcs of them,
    /// and lines that touch two. Without any point if all are points on a line. Takes as many
    /// steps as there are discs, for each of those on it.
    #[must_use]
    pub fn hull_of_discs<P: Into<DVec2>>(discs: impl IntoIterator<Item = (P, f64)>) -> Self {
        let discs: Vec<Disc> = discs
            .into_iter()
            .map(|(center, radius)| Disc {
                center: center.into(),
                radius,
            })
            .collect();
        for &Disc { center, radius } in &discs {
            if !(center.is_finite() && radius.is_finite()) {
                return Self::faulty(ProfileFault::NotFinite { what: "a disc" });
            }
            if radius < 0.0 {
                let what = "a radius";
                return Self::faulty(ProfileFault::NotPositive {
                    what,
                    value: radius,
                });
            }
        }
        if discs.iter().all(|disc| disc.radius == 0.0) {
            return Self::hull_of(discs.iter().map(|disc| disc.center));
        }
        let arcs = arcs_around(&discs);
        if let [(only, ..)] = arcs[..] {
            let Disc { center, radius } = discs[only];
            return Self::circle(radius).translate(center);
        }
        let at =
            |k: usize, angle: f64| discs[k].center + discs[k].radius * elementary::direction(angle);
        let mut path = Path::from(at(arcs[0].0, arcs[0].1));
        for (k, &(disc, from, to)) in arcs.iter().enumerate() {
            if discs[disc].radius > 0.0 {
                path = path.arc_to(at(disc, to), to - from);
            }
            if let Some(&(next, from, _)) = arcs.get(k + 1) {
                path = path.line_to(at(next, from));
            }
        }
        path.close()
    }

    /// The centre and the radius if it is one circle.
    #[must_use]
    pub fn as_circle(&self) -> Option<(DVec2, f64)> {
        match self.discs()?[..] {
            [(center, radius)] if radius > 0.0 => Some((center, radius)),
            _ => None,
        }
    }

    /// The discs and points whose hull is that of the profile, if it is made of circles and
    /// polygons alone.
    fn discs(&self) -> Option<Vec<(DVec2, f64)>> {
        let mut discs = Vec::new();
        let mut has_circle = false;
        for step in &self.steps {
            match step {
                Step::Shape(Shape::Disc, map) => {
                    let (x, y) = (map.matrix2.x_axis, map.matrix2.y_axis);
                    let radius = x.length();
                    let is_round = (radius - y.length()).abs() <= IN_PROFILE * radius
                        && x.dot(y).abs() <= IN_PROFILE * radius * radius;
                    if !is_round {
                        return None;
                    }
                    has_circle = true;
                    discs.push((map.translation, radius));
                }
                Step::Shape(Shape::Contours(contours, _), map) => {
                    for corner in contours.iter().flatten() {
                        if !corner.is_straight() {
                            return None;
                        }
                        discs.push((map.transform_point2(corner.point), 0.0));
                    }
                }
                Step::Combine(Combination::Union, _) => {}
                Step::Combine(..) | Step::Fault(_) => return None,
            }
        }
        has_circle.then_some(discs)
    }
}

#[derive(Clone, Copy)]
struct Disc {
    center: DVec2,
    radius: f64,
}

/// The discs on their hull, counter-clockwise, each with the angles between which its arc is:
/// turning on from each, the next is the first that comes to reach farther.
fn arcs_around(discs: &[Disc]) -> Vec<(usize, f64, f64)> {
    let reach = |disc: &Disc| disc.center.x + disc.radius;
    let first = (0..discs.len()).max_by(|&i, &j| {
        let [a, b] = [&discs[i], &discs[j]];
        let by_reach = reach(a).total_cmp(&reach(b));
        // The one that reaches farther a little later.
        let by_height = a.center.y.total_cmp(&b.center.y);
        by_reach.then(by_height).then(a.radius.total_cmp(&b.radius))
    });
    let Some(first) = first else {
        return Vec::new();
    };
    let mut arcs = Vec::new();
    let (mut at, mut from, mut turned) = (first, 0.0, 0.0);
    while arcs.len() <= 2 * discs.len() {
        let own = discs[at];
        // How far on it is until another one reaches as far, and how far that one is.
        let mut next: Option<(f64, f64, usize)> = None;
        for (other, disc) in discs.iter().enumerate() {
            let away = disc.center - own.center;
            let distance = away.length();
            let sine = (own.radius - disc.radius) / distance;
            if sine.is_nan() || sine > 1.0 - IN_PROFILE {
                // Within this one.
                continue;
            }
            let angle = elementary::atan2(away.y, away.x) - elementary::acos(sine.max(-1.0));
            let on = (angle - from).rem_euclid(TAU);
            // Around this one it reaches farther everywhere.
            let is_around = sine <= -1.0;
            let on = if is_around || on > TAU - IN_PROFILE {
                0.0
            } else {
                on
            };
            let is_first = next.is_none_or(|(least, farthest, _)| {
                on < least - IN_PROFILE || on < least + IN_PROFILE && distance > farthest
            });
            if is_first {
                next = Some((on, distance, other));
            }
        }
        let rest = TAU - turned;
        match next.filter(|&(on, ..)| on < rest - IN_PROFILE) {
            Some((on, _, other)) => {
                arcs.push((at, from, from + on));
                (at, from, turned) = (other, from + on, turned + on);
            }
            None => {
                arcs.push((at, from, from + rest));
                break;
            }
        }
    }
    // The first arc begins where the last one does.
    if arcs.len() > 1
        && let Some((_, begins, _)) = arcs.pop_if(|last| last.0 == first)
    {
        arcs[0].1 = begins - TAU;
    }
    arcs
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
