//! Offsets: a contour's sides moved along their normals and joined.
//!
//! Around a corner that opens away from the moving side the moved sides are
//! joined; at any other they cross, and a detour through the corner itself
//! winds the loop between them negatively. What the contour then winds around
//! positively is the offset (X. Chen, S. McMains, "Polygon offsetting by
//! computing winding numbers", 2005).

use crate::elementary;
use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::arcs::{Sagitta, stretch};
use super::bent::cut;
use super::contour::formula;
use super::flatten;
use super::outline::outline;
use super::polygon::points_of;
use super::side::Side;
use super::{Contour, Corner, FillRule, Profile, Shape};
use crate::error::ProfileFault;
use crate::numeric::tolerance::{IN_PROFILE, PROFILE_CHORD};

/// How the sides of an offset are joined around a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Join {
    /// By an arc around the corner: all points within the distance.
    Round,
    /// By chords of an arc, so many to a whole turn.
    Chords(usize),
    /// By prolonging both, up to so many distances from the corner; beyond
    /// that by a bevel.
    Mitre(f64),
    /// By a straight side.
    Bevel,
    /// By a straight side as far from the corner as the others are.
    Square,
}

impl Profile {
    /// The profile grown by a distance, or shrunk by a negative one, to all
    /// sides. Lines and arcs stay such, also of Boolean combinations, if rounding
    /// leaves nothing open about where they meet ([`Profile::exact_offset`]);
    /// otherwise, and of ellipses and parabolas, chords within 1e-4 of the profile's size are
    /// moved (for another tolerance, see [`Profile::flattened`] and
    /// [`Join::Chords`]).
    #[must_use]
    pub fn offset(&self, distance: f64, join: Join) -> Self {
        self.exact_offset(distance, join)
            .unwrap_or_else(|| Self::of(self.offset_of_chords(distance, join)))
    }

    /// The profile grown by a distance, or shrunk by a negative one, of lines and arcs.
    /// `None` if it has ellipses or parabolas, or if rounding leaves open where the moved sides
    /// meet: then [`Profile::offset`] moves chords.
    #[must_use]
    pub fn exact_offset(&self, distance: f64, join: Join) -> Option<Self> {
        if self.fault().is_some() || distance == 0.0 {
            return Some(self.clone());
        }
        if !distance.is_finite() {
            let what = "the distance";
            return Some(Self::faulty(ProfileFault::NotFinite { what }));
        }
        let is_straight = self.is_straight();
        let moved: Vec<Contour> = if is_straight {
            // No chords, whatever their tolerance.
            match self.moved_chords(distance, join, 1.0) {
                Ok(moved) => moved,
                Err(fault) => return Some(Self::faulty(fault)),
            }
        } else {
            let contours = self.outline()?;
            contours
                .iter()
                .map(|contour| moved_contour(contour, distance, join))
                .collect()
        };
        if is_straight && moved.iter().flatten().all(Corner::is_straight) {
            let polygons = flatten::positive(&points_of(&moved)).concat();
            return Some(Self::polygons_of(polygons, FillRule::NonZero));
        }
        let moved: Vec<(usize, Contour)> = moved.into_iter().map(|contour| (0, contour)).collect();
        let (contours, _) = outline(&moved, 1, |windings| windings[0] > 0)?;
        let moved = Self::within(contours);
        // Whether a formula tells it is known to that alone.
        let is_told = formula(&moved, Sagitta::of_length(1.0), &|_| true).is_ok();
        is_told.then_some(moved)
    }

    fn offset_of_chords(&self, distance: f64, join: Join) -> Result<Self, ProfileFault> {
        let tolerance = self.tolerance_of(PROFILE_CHORD)?;
        let moved = self.moved_chords(distance, join, tolerance)?;
        let sagitta = Sagitta::of_length(tolerance);
        let moved: Vec<Contour> = moved
            .iter()
            .map(|contour| cut(contour, 1.0, sagitta, |_| false))
            .collect();
        let polygons = flatten::positive(&points_of(&moved)).concat();
        Ok(Self::polygons_of(polygons, FillRule::NonZero))
    }

    /// The moved contours of chords within a tolerance.
    fn moved_chords(
        &self,
        distance: f64,
        join: Join,
        tolerance: f64,
    ) -> Result<Vec<Contour>, ProfileFault> {
        let contours = self.contours(tolerance)?.into_iter();
        let straight = contours.map(|points| points.into_iter().map(Corner::straight).collect());
        Ok(straight
            .map(|contour: Contour| moved_contour(&contour, distance, join))
            .collect())
    }

    /// A share of the profile's size.
    pub(crate) fn tolerance_of(&self, share: f64) -> Result<f64, ProfileFault> {
        let size = self.fold(
            |shape, map| {
                let reach = match shape {
                    Shape::Disc => 1.0,
                    Shape::Contours(contours, _) => {
                        let points = contours.iter().flatten();
                        points.fold(0.0, |most, corner| corner.point.length().max(most))
                    }
                };
                Ok(reach * stretch(&map.matrix2) + map.translation.length())
            },
            |_, sizes| Ok(sizes.into_iter().fold(0.0, f64::max)),
        )?;
        Ok((size.unwrap_or(1.0) * share).max(f64::MIN_POSITIVE))
    }
}

/// The sides of a contour moved to their right, and joined. What an arc turns around in that is
/// moved to its centre at most: what is as far away beyond, something else is nearer to.
fn moved_contour(contour: &[Corner], distance: f64, join: Join) -> Contour {
    let count = contour.len();
    let mut moved = Vec::with_capacity(2 * count);
    // The centre of the arc from corner k, if it is moved there.
    let center = |k: usize| {
        let arc = Side::of(contour, k % count).arc?;
        (arc.radius + distance * arc.sweep.signum() <= 0.0).then_some(arc.center)
    };
    for k in 0..count {
        let here = contour[k].point;
        let arriving = Side::of(contour, (k + count - 1) % count).course(1.0);
        let leaving = Side::of(contour, k).course(0.0);
        let angle = arriving.turn_to(&leaving);
        let [from, to] = [&arriving, &leaving].map(|c| here - distance * c.direction.perp());
        let is_joined = angle.abs() >= IN_PROFILE;
        if is_joined && angle * distance > 0.0 {
            join_sides(&mut moved, here, [from, to], angle, join);
        } else if is_joined {
            let from = center(k + count - 1).unwrap_or(from);
            moved.extend([from, here].map(Corner::straight));
        }
        if center(k).is_some() {
            moved.push(Corner::straight(to));
        }
        moved.push(match center(k) {
            Some(center) => Corner::straight(center),
            // The same angle about the same centre.
            None => Corner::arc(to, contour[k].bulge()),
        });
    }
    moved
}

/// Adds what comes before the start of the leaving side.
fn join_sides(moved: &mut Contour, here: DVec2, [from, to]: [DVec2; 2], angle: f64, join: Join) {
    match join {
        Join::Round => moved.push(Corner::arc(from, elementary::tan(angle / 4.0))),
        Join::Chords(fragments) => {
            let steps = (fragments.max(3) as f64 * angle.abs() / TAU)
                .round()
                .max(1.0);
            for step in 0..steps as usize {
                let turned = elementary::direction(angle * step as f64 / steps);
                moved.push(Corner::straight(here + turned.rotate(from - here)));
            }
        }
        Join::Mitre(limit) if angle.abs() < PI && 1.0 <= limit * elementary::cos(0.5 * angle) => {
            let corner = here + (from - here + to - here) / (1.0 + elementary::cos(angle));
            moved.extend([from, corner].map(Corner::straight));
        }
        Join::Square if angle.abs() < PI => {
            // Along the sides, up to where that side is.
            let reach = elementary::tan(0.25 * angle);
            let first = from + reach * (from - here).perp();
            let last = to - reach * (to - here).perp();
            moved.extend([from, first, last].map(Corner::straight));
        }
        Join::Mitre(_) | Join::Square | Join::Bevel => moved.push(Corner::straight(from)),
    }
}
