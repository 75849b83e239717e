//! From contours to a formula: cleaned, uncrossed, nested.

use glam::DAffine2;

use super::arcs::{self, Sagitta, doubled_area, reversed, stretch};
use super::flatten::disc_corners;
use super::monotone::inside;
use super::outline::outline;
use super::plane_set::{Leaf, PlaneSet};
use super::polygon::{self, Nesting, cleaned};
use super::segments::enclosed_by_arcs;
use super::{Combination, Contour, FillRule, Profile, Shape};
use crate::error::ProfileFault;

/// The most corners of one profile: every side is an infinite line or plane
/// to whatever is cut by it.
const MOST_CORNERS: usize = 10_000;

/// The profile as a formula. Arcs and circles whose disc `keeps` does not want
/// become chords that near to them.
pub(crate) fn plane_set(
    profile: &Profile,
    sagitta: Sagitta,
    keeps: &dyn Fn(&DAffine2) -> bool,
) -> Result<PlaneSet, ProfileFault> {
    let mut corners = 0;
    let set = profile.fold(
        |shape, map| match shape {
            Shape::Disc if keeps(map) => Ok(PlaneSet::leaf(Leaf::Disc(*map))),
            Shape::Disc => of_contours(&[disc_corners(map, sagitta)], FillRule::EvenOdd),
            Shape::Contours(contours, rule) => {
                let stretch = stretch(&map.matrix2);
                let kept: Vec<Contour> = contours
                    .iter()
                    .map(|contour| {
                        arcs::cut(contour, stretch, sagitta, |arc| keeps(&(*map * arc.disc())))
                    })
                    .collect();
                corners += kept.iter().map(Vec::len).sum::<usize>();
                if corners > MOST_CORNERS {
                    return Err(ProfileFault::TooManyCorners {
                        corners,
                        limit: MOST_CORNERS,
                    });
                }
                Ok(of_contours(&kept, *rule)?.mapped(map))
            }
        },
        |combination, mut sets| {
            Ok(match combination {
                Combination::Union => PlaneSet::any(sets),
                Combination::Intersection => PlaneSet::all(sets),
                Combination::Difference if sets.is_empty() => PlaneSet::EMPTY,
                Combination::Difference => sets.remove(0).without(sets),
            })
        },
    )?;
    Ok(set.unwrap_or(PlaneSet::EMPTY))
}

fn of_contours(contours: &[Contour], rule: FillRule) -> Result<PlaneSet, ProfileFault> {
    let mut clean = Vec::with_capacity(contours.len());
    for contour in contours {
        clean.extend(cleaned(contour)?);
    }
    let Some(place) = polygon::crossing(&clean) else {
        return nested(&clean, rule);
    };
    let all: Vec<(usize, Contour)> = clean.into_iter().map(|contour| (0, contour)).collect();
    let outline = outline(&all, 1, |windings| rule.is_inside(windings[0]));
    let (contours, lines) = outline.ok_or(ProfileFault::Crossing { place })?;
    let set = nested(&contours, FillRule::NonZero)?;
    Ok(set.along(|from, to| lines.of(from, to)))
}

/// Contours that do not meet: each with what it encloses, in the order of their
/// areas, so that what lies in a contour comes before it.
fn nested(contours: &[Contour], rule: FillRule) -> Result<PlaneSet, ProfileFault> {
    let nesting = Nesting::of(contours, rule);
    let mut within: Vec<Vec<PlaneSet>> = vec![Vec::new(); contours.len() + 1];
    let outside = contours.len();
    for &k in nesting.order.iter().rev() {
        let inner = std::mem::take(&mut within[k]);
        let around = nesting.parents[k].unwrap_or(outside);
        if nesting.bounds[k] {
            let set = enclosed(&contours[k])?.without(inner);
            within[around].push(set);
        } else {
            within[around].extend(inner);
        }
    }
    Ok(PlaneSet::any(within.pop().unwrap_or_default()))
}

/// What one contour encloses.
fn enclosed(contour: &Contour) -> Result<PlaneSet, ProfileFault> {
    let contour = if doubled_area(contour) < 0.0 {
        reversed(contour)
    } else {
        contour.clone()
    };
    if contour.iter().all(|corner| corner.bulge == 0.0) {
        return Ok(inside(
            &polygon::points_of(std::slice::from_ref(&contour))[0],
        ));
    }
    if let [one, other] = contour[..]
        && one.bulge == 1.0
        && other.bulge == 1.0
    {
        let disc = arcs::side(&contour, 0).1.map(|arc| Leaf::Disc(arc.disc()));
        return Ok(disc.map_or(PlaneSet::EMPTY, PlaneSet::leaf));
    }
    enclosed_by_arcs(contour)
}
