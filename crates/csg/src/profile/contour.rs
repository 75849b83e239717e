//! From contours to a formula: cleaned, uncrossed, nested.

use std::cmp::Reverse;

use glam::{DAffine2, DMat2, DVec2};

use super::arcs::{self, doubled_area, reversed};
use super::fault::ProfileFault;
use super::flatten::{self, disc_corners};
use super::monotone::{inside, orient};
use super::plane_set::{Leaf, PlaneSet};
use super::{Combination, Contour, Corner, FillRule, Profile, Shape};

/// The most corners of one profile: every side is an infinite line or plane
/// to whatever is cut by it.
const MOST_CORNERS: usize = 10_000;

/// The profile as a formula. Arcs and circles whose disc `keeps` does not want
/// become chords within `tolerance` of them.
pub(crate) fn plane_set(
    profile: &Profile,
    tolerance: f64,
    keeps: &dyn Fn(&DAffine2) -> bool,
) -> Result<PlaneSet, ProfileFault> {
    let mut corners = 0;
    let set = profile.fold(
        |shape, map| match shape {
            Shape::Disc if keeps(map) => Ok(PlaneSet::leaf(Leaf::Disc(*map))),
            Shape::Disc => of_contours(&[disc_corners(map, tolerance)], FillRule::EvenOdd),
            Shape::Contours(contours, rule) => {
                let stretch = stretch(&map.matrix2);
                let kept: Vec<Contour> = contours
                    .iter()
                    .map(|contour| {
                        arcs::cut(contour, stretch, tolerance, |arc| {
                            keeps(&(*map * arc.disc()))
                        })
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

/// By how much a linear map stretches at most.
pub(super) fn stretch(map: &DMat2) -> f64 {
    let (x, y) = (map.x_axis, map.y_axis);
    let sum = x.length_squared() + y.length_squared();
    let product = map.determinant();
    let difference = (sum * sum - 4.0 * product * product).max(0.0).sqrt();
    (0.5 * (sum + difference)).sqrt()
}

fn of_contours(contours: &[Contour], rule: FillRule) -> Result<PlaneSet, ProfileFault> {
    let mut clean = Vec::with_capacity(contours.len());
    for contour in contours {
        clean.extend(cleaned(contour)?);
    }
    let Some(place) = flatten::crossing(&clean) else {
        return nested(&clean, rule);
    };
    if clean.iter().flatten().any(|corner| corner.bulge != 0.0) {
        return Err(ProfileFault::Crossing { place });
    }
    let shapes = flatten::resolved(&flatten::points_of(&clean), rule);
    let shapes = shapes.into_iter().map(|contours| {
        let mut sets = contours.iter().map(|points| {
            let mut corners = flatten::without_straight(points);
            if flatten::doubled_area(&corners) < 0.0 {
                corners.reverse();
            }
            inside(&corners)
        });
        let outer = sets.next().unwrap_or(PlaneSet::EMPTY);
        outer.without(sets.collect())
    });
    Ok(PlaneSet::any(shapes.collect()))
}

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

/// Contours that do not meet: each with what it encloses, in the order of their
/// areas, so that what lies in a contour comes before it.
fn nested(contours: &[Contour], rule: FillRule) -> Result<PlaneSet, ProfileFault> {
    let traces: Vec<Vec<DVec2>> = contours.iter().map(|c| arcs::trace(c)).collect();
    let nesting = Nesting::of(&traces, rule);
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
        let areas: Vec<f64> = contours.iter().map(|c| flatten::doubled_area(c)).collect();
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
                .find(|&other| flatten::encloses(&contours[other], contours[k][0]));
            let around = parent.map_or(0, |parent| windings[parent]);
            windings[k] = around + if areas[k] > 0.0 { 1 } else { -1 };
            nesting.parents[k] = parent;
            nesting.inside[k] = rule.is_inside(windings[k]);
            nesting.bounds[k] = nesting.inside[k] != rule.is_inside(around);
        }
        nesting
    }
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
            &flatten::points_of(std::slice::from_ref(&contour))[0],
        ));
    }
    let contour = arcs::parted(contour)?;
    let points: Vec<DVec2> = contour.iter().map(|corner| corner.point).collect();
    let corners = flatten::without_straight(&points);
    let mut parts = vec![if corners.len() > 2 {
        inside(&corners)
    } else {
        PlaneSet::EMPTY
    }];
    let mut dents = Vec::new();
    for k in 0..contour.len() {
        match arcs::side(&contour, k).1 {
            Some(arc) if arc.sweep > 0.0 => parts.push(arc.segment()),
            Some(arc) => dents.push(arc.segment()),
            None => {}
        }
    }
    Ok(PlaneSet::any(parts).without(dents))
}
