//! Offsets: a contour's sides moved along their normals and joined.
//!
//! Around a corner that opens away from the moving side the moved sides are
//! joined; at any other they cross, and a detour through the corner itself
//! winds the loop between them negatively. What the contour then winds around
//! positively is the offset (X. Chen, S. McMains, "Polygon offsetting by
//! computing winding numbers", 2005). Arcs stay arcs where no two sides of the
//! moved contours meet, which is checked; otherwise chords replace them.

use crate::elementary;
use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::arcs::{Sagitta, cut, doubled_area, side, stretch};
use super::flatten;
use super::polygon::{cleaned, crossing, points_of};
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
    /// sides. Arcs stay arcs where the moved contours do not meet themselves;
    /// otherwise they become chords within 1e-4 of the profile's size (for
    /// another tolerance, see [`Profile::flattened`] and [`Join::Chords`]).
    #[must_use]
    pub fn offset(&self, distance: f64, join: Join) -> Self {
        Self::of(self.try_offset(distance, join))
    }

    fn try_offset(&self, distance: f64, join: Join) -> Result<Self, ProfileFault> {
        if !distance.is_finite() {
            return Err(ProfileFault::NotFinite {
                what: "the distance",
            });
        }
        if distance == 0.0 {
            return Ok(self.clone());
        }
        if let Some(contours) = self.own_contours()
            && let Some(kept) = kept(&contours, distance, join)
        {
            let shape = Shape::Contours(kept.into(), FillRule::NonZero);
            return Ok(Self::shape(shape, glam::DAffine2::IDENTITY));
        }
        let tolerance = self.tolerance_of(PROFILE_CHORD)?;
        let mut moved = Vec::new();
        for points in self.contours(tolerance)? {
            let straight = points.into_iter().map(Corner::straight);
            let straight: Contour = straight.collect();
            let raw = moved_contour(&straight, distance, join, false);
            moved.push(cut(&raw, 1.0, Sagitta::of_length(tolerance), |_| false));
        }
        let polygons = flatten::positive(&points_of(&moved)).concat();
        if polygons.is_empty() {
            return Ok(Self::empty());
        }
        Ok(Self::polygons_of(polygons, FillRule::NonZero))
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

    /// The contours of a profile that is no Boolean combination, arcs
    /// included, with the inside on their left, where they do not meet.
    fn own_contours(&self) -> Option<Vec<Contour>> {
        let [super::Step::Shape(shape, map)] = &self.steps[..] else {
            return None;
        };
        let (x, y) = (map.matrix2.x_axis, map.matrix2.y_axis);
        let similar = x.abs_diff_eq(-y.perp(), IN_PROFILE * x.length())
            || x.abs_diff_eq(y.perp(), IN_PROFILE * x.length());
        let mirrored = map.matrix2.determinant() < 0.0;
        let contours: Vec<Contour> = match shape {
            Shape::Disc => vec![
                [DVec2::X, DVec2::NEG_X]
                    .map(|point| Corner { point, bulge: 1.0 })
                    .to_vec(),
            ],
            Shape::Contours(contours, _) if contours.len() == 1 => contours.to_vec(),
            Shape::Contours(..) => return None,
        };
        let mapped = |corner: &Corner| Corner {
            point: map.transform_point2(corner.point),
            bulge: if mirrored {
                -corner.bulge
            } else {
                corner.bulge
            },
        };
        let contour: Contour = contours[0].iter().map(mapped).collect();
        let round = contour.iter().any(|corner| corner.bulge != 0.0);
        if round && !similar {
            return None;
        }
        let contour = cleaned(&contour).ok()??;
        if crossing(std::slice::from_ref(&contour)).is_some() {
            return None;
        }
        Some(vec![if doubled_area(&contour) < 0.0 {
            super::arcs::reversed(&contour)
        } else {
            contour
        }])
    }
}

/// The moved contours with their arcs, if they do not meet.
fn kept(contours: &[Contour], distance: f64, join: Join) -> Option<Vec<Contour>> {
    let mut moved = Vec::with_capacity(contours.len());
    for contour in contours {
        if !every_side_stays(contour, distance) {
            return None;
        }
        let raw = moved_contour(contour, distance, join, true);
        moved.push(cleaned(&raw).ok()??);
    }
    let proper = moved.iter().all(|contour| doubled_area(contour) > 0.0);
    (proper && crossing(&moved).is_none()).then_some(moved)
}

/// The angle turned through at corner k, counter-clockwise positive, and the
/// directions before and after.
fn turning(contour: &[Corner], k: usize) -> (f64, DVec2, DVec2) {
    let before = (k + contour.len() - 1) % contour.len();
    let tangent = |k: usize, share: f64| match side(contour, k) {
        (_, Some(arc)) => arc.tangent(share),
        (next, None) => (next - contour[k].point).normalize_or_zero(),
    };
    let (arriving, leaving) = (tangent(before, 1.0), tangent(k, 0.0));
    let angle = elementary::atan2(arriving.perp_dot(leaving), arriving.dot(leaving));
    (angle, arriving, leaving)
}

/// Whether every side keeps some of its length when moved to its right, and
/// every arc some of its radius.
fn every_side_stays(contour: &[Corner], distance: f64) -> bool {
    let lost = |k: usize| {
        let angle = turning(contour, k % contour.len()).0;
        (-distance * elementary::tan(0.5 * angle)).max(0.0)
    };
    (0..contour.len()).all(|k| match side(contour, k) {
        (_, Some(arc)) => arc.radius + distance * arc.sweep.signum() > 0.0,
        (next, None) => contour[k].point.distance(next) > lost(k) + lost(k + 1),
    })
}

/// The sides of a contour moved to their right, and joined. Where `exact`,
/// straight sides that cross end there.
fn moved_contour(contour: &[Corner], distance: f64, join: Join, exact: bool) -> Contour {
    let count = contour.len();
    let mut moved = Vec::with_capacity(2 * count);
    for k in 0..count {
        let here = contour[k].point;
        let (angle, arriving, leaving) = turning(contour, k);
        let [from, to] = [arriving, leaving].map(|t| here - distance * t.perp());
        let before = contour[(k + count - 1) % count];
        let straight = before.bulge == 0.0 && contour[k].bulge == 0.0;
        if angle.abs() < IN_PROFILE {
            // Nothing to join.
        } else if angle * distance > 0.0 {
            join_sides(&mut moved, here, [from, to], angle, join);
        } else if exact && straight {
            // The same prolonging, inwards.
            let corner = here + (from - here + to - here) / (1.0 + elementary::cos(angle));
            moved.push(Corner::straight(corner));
            continue;
        } else {
            moved.extend([from, here].map(Corner::straight));
        }
        moved.push(Corner {
            point: to,
            // The same angle about the same centre.
            bulge: contour[k].bulge,
        });
    }
    moved
}

/// Adds what comes before the start of the leaving side.
fn join_sides(moved: &mut Contour, here: DVec2, [from, to]: [DVec2; 2], angle: f64, join: Join) {
    match join {
        Join::Round => moved.push(Corner {
            point: from,
            bulge: elementary::tan(angle / 4.0),
        }),
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
