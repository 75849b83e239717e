//! From contours to a formula: cleaned, uncrossed, nested.

use glam::{DAffine2, DVec2};

use super::arcs::{Sagitta, stretch};
use super::bent::{Bent, cut, doubled_area, reversed};
use super::flatten::disc_corners;
use super::monotone::inside;
use super::outline::outline;
use super::plane_set::{Leaf, PlaneSet};
use super::polygon::{self, Nesting, cleaned, encloses};
use super::segments::{Segments, apart};
use super::{Bend, Combination, Contour, Corner, FillRule, Profile, Shape, Step};
use crate::error::ProfileFault;

/// The most corners of one profile: every side is an infinite line or plane
/// to whatever is cut by it.
const MOST_CORNERS: usize = 10_000;

/// A profile as a formula.
pub(crate) struct Formula {
    pub set: PlaneSet,
    /// Whether chords stand for something in it.
    pub has_chords: bool,
}

/// The profile as a formula. Circles, arcs and parabolas of which `keeps` does not want what they
/// enclose become chords that near to them. Contours with parabolas that cross are an error.
pub(crate) fn formula(
    profile: &Profile,
    sagitta: Sagitta,
    keeps: &dyn Fn(&Leaf) -> bool,
) -> Result<Formula, ProfileFault> {
    let mut corners = 0;
    let mut has_chords = false;
    let mut keeps = |leaf: Leaf| {
        let keeps = keeps(&leaf);
        has_chords |= !keeps;
        keeps
    };
    let set = profile.fold(
        |shape, map| match shape {
            Shape::Disc if keeps(Leaf::Disc(*map)) => Ok(PlaneSet::leaf(Leaf::Disc(*map))),
            Shape::Disc => of_contours(&[disc_corners(map, sagitta)], FillRule::EvenOdd),
            Shape::Contours(contours, rule) => {
                let stretch = stretch(&map.matrix2);
                let mut kept: Vec<Contour> = Vec::with_capacity(contours.len());
                for contour in contours.iter() {
                    let keeps = |leaf: Leaf| keeps(leaf.mapped(map));
                    kept.push(cut(contour, stretch, sagitta, keeps));
                }
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
    Ok(Formula {
        set: set.unwrap_or(PlaneSet::EMPTY),
        has_chords,
    })
}

/// A profile as the polygons of the chords of its bent sides, and formulas for what is between both.
pub(crate) struct Segmented {
    /// Outer contours counter-clockwise, holes clockwise.
    pub polygons: Vec<Vec<DVec2>>,
    /// What is added to what these enclose (`true`) and taken away, in this order.
    pub steps: Vec<(bool, PlaneSet)>,
}

/// One shape of contours so, if it has bent sides and none of them cross. As a polyhedron is told by
/// its faces near a place, and half-planes are everywhere, this is how many sides are told.
pub(crate) fn segmented(profile: &Profile) -> Result<Option<Segmented>, ProfileFault> {
    let Some((uncrossed, map)) = Uncrossed::of(profile, |corner| !corner.is_straight())? else {
        return Ok(None);
    };
    let mut polygons = Vec::new();
    // Of contours around the set, and of those around its holes.
    let mut steps = [const { [const { Vec::new() }; 3] }; 2];
    for (contour, is_outer) in uncrossed.bounding() {
        let Ok(segments) = Segments::of(left_inside(contour)) else {
            return Ok(None);
        };
        if segments.corners.len() > 2 {
            let corners = segments.corners.iter();
            let mut corners: Vec<DVec2> = corners.map(|&p| map.transform_point2(p)).collect();
            if is_outer == (map.matrix2.determinant() < 0.0) {
                corners.reverse();
            }
            polygons.push(corners);
        }
        let own = [segments.first, segments.dents, segments.last];
        for (all, own) in steps[usize::from(!is_outer)].iter_mut().zip(own) {
            all.push(own.mapped(map));
        }
    }
    // Those of different contours have nothing in common.
    let steps = steps.into_iter().zip([true, false]);
    let steps = steps.flat_map(|([first, dents, last], is_outer)| {
        [(is_outer, first), (!is_outer, dents), (is_outer, last)]
    });
    let steps = steps.map(|(is_added, sets)| (is_added, PlaneSet::any(sets)));
    Ok(Some(Segmented {
        polygons,
        steps: steps.filter(|(_, set)| !set.is_empty()).collect(),
    }))
}

/// Contours of one shape that do not cross, and how they lie in each other.
struct Uncrossed {
    contours: Vec<Contour>,
    nesting: Nesting,
}

impl Uncrossed {
    /// Those of a profile that is one shape, and its map, with the sides cut that [`apart`] is to
    /// cut.
    fn of(
        profile: &Profile,
        are_cut: impl Fn(&Corner) -> bool,
    ) -> Result<Option<(Self, &DAffine2)>, ProfileFault> {
        let [Step::Shape(Shape::Contours(contours, rule), map)] = &profile.steps[..] else {
            return Ok(None);
        };
        let Ok(contours) = apart(all_cleaned(contours)?, are_cut) else {
            return Ok(None);
        };
        if polygon::crossing(&contours).is_some() {
            return Ok(None);
        }
        let nesting = Nesting::of(&contours, *rule);
        Ok(Some((Self { contours, nesting }, map)))
    }

    /// Those that bound the set, the largest first, and whether it is on their inner side.
    fn bounding(&self) -> impl Iterator<Item = (&Contour, bool)> {
        let Nesting {
            order,
            bounds,
            inside,
            ..
        } = &self.nesting;
        let bounding = order.iter().filter(|&&k| bounds[k]);
        bounding.map(|&k| (&self.contours[k], inside[k]))
    }
}

impl Profile {
    /// The area, to rounding. `None` if it has ellipses or is faulty, or if rounding leaves open
    /// what meets; and of parabolas if their contours cross, or are combined with others.
    #[must_use]
    pub fn exact_area(&self) -> Option<f64> {
        if self.fault().is_some() {
            return None;
        }
        if let Some(contours) = self.outline() {
            return Some(0.5 * contours.iter().map(|c| doubled_area(c)).sum::<f64>());
        }
        let (uncrossed, map) = Uncrossed::of(self, Corner::is_parabola).ok()??;
        let areas = uncrossed.bounding().map(|(contour, is_outer)| {
            let area = 0.5 * doubled_area(contour).abs();
            if is_outer { area } else { -area }
        });
        Some(map.matrix2.determinant().abs() * areas.sum::<f64>())
    }

    /// The same profile with a shape for each contour that runs one way round and those within it that
    /// run the other way, of shapes with parabolas that are inside where contours wind around them
    /// at all: so letters are drawn whose strokes overlap. `None` if there are none such, or it is
    /// not the same.
    pub(crate) fn strokes(&self) -> Option<Self> {
        /// Of the size, how near chords are by which it is told what is in what.
        const FINE: f64 = 1e-6;
        /// Of the square of the size, areas that are one: both are of the same chords.
        const SAME: f64 = 1e-10;
        let tolerance = self.tolerance_of(FINE).ok()?;
        let size = tolerance / FINE;
        let mut strokes = Self { steps: Vec::new() };
        for step in &self.steps {
            match step {
                Step::Shape(Shape::Contours(contours, FillRule::NonZero), map)
                    if contours.iter().flatten().any(Corner::is_parabola) =>
                {
                    let sagitta = Sagitta::of_length(tolerance);
                    let groups = strokes_of(contours, stretch(&map.matrix2), sagitta)?;
                    let count = groups.len();
                    let shapes = groups.into_iter().map(|group| {
                        Step::Shape(Shape::Contours(group.into(), FillRule::NonZero), *map)
                    });
                    strokes.steps.extend(shapes);
                    strokes.steps.push(Step::Combine(Combination::Union, count));
                }
                step => strokes.steps.push(step.clone()),
            }
        }
        let [own, other] = [self, &strokes].map(|profile| profile.area(tolerance));
        let is_same = (own.ok()? - other.ok()?).abs() <= SAME * size * size;
        (strokes != *self && is_same).then_some(strokes)
    }
}

/// Contours that run the way round of the largest, each with those within it that run the other way.
fn strokes_of(contours: &[Contour], stretch: f64, sagitta: Sagitta) -> Option<Vec<Vec<Contour>>> {
    let areas: Vec<f64> = contours.iter().map(|c| doubled_area(c)).collect();
    let largest = areas.iter().copied();
    let largest = largest.max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let (mut outer, holes): (Vec<usize>, Vec<usize>) =
        (0..contours.len()).partition(|&k| areas[k] * largest > 0.0);
    // The least around a hole is the one that it is in.
    outer.sort_by(|&a, &b| areas[a].abs().total_cmp(&areas[b].abs()));
    let mut groups: Vec<Vec<Contour>> = outer.iter().map(|&k| vec![contours[k].clone()]).collect();
    let chords = outer
        .iter()
        .map(|&k| cut(&contours[k], stretch, sagitta, |_| false));
    let chords: Vec<Contour> = chords.collect();
    for hole in holes {
        let place = contours[hole].first()?.point;
        let around = chords.iter().position(|outer| encloses(outer, place))?;
        groups[around].push(contours[hole].clone());
    }
    Some(groups)
}

fn all_cleaned(contours: &[Contour]) -> Result<Vec<Contour>, ProfileFault> {
    let mut clean = Vec::with_capacity(contours.len());
    for contour in contours {
        clean.extend(cleaned(contour)?);
    }
    Ok(clean)
}

fn of_contours(contours: &[Contour], rule: FillRule) -> Result<PlaneSet, ProfileFault> {
    let clean = apart(all_cleaned(contours)?, Corner::is_parabola)?;
    let Some(place) = polygon::crossing(&clean) else {
        return nested(&clean, rule);
    };
    if clean.iter().flatten().any(Corner::is_parabola) {
        return Err(ProfileFault::Crossing { place });
    }
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

/// The contour with its inside on its left.
fn left_inside(contour: &Contour) -> Contour {
    if doubled_area(contour) < 0.0 {
        reversed(contour)
    } else {
        contour.clone()
    }
}

/// What one contour encloses.
fn enclosed(contour: &Contour) -> Result<PlaneSet, ProfileFault> {
    let contour = left_inside(contour);
    if contour.iter().all(Corner::is_straight) {
        return Ok(inside(
            &polygon::points_of(std::slice::from_ref(&contour))[0],
        ));
    }
    if let [one, other] = contour[..]
        && one.bend == Bend::Arc(1.0)
        && other.bend == Bend::Arc(1.0)
        && let Some(half) = Bent::of(&contour, 0)
    {
        return Ok(PlaneSet::leaf(half.leaf()));
    }
    Ok(Segments::of(contour)?.enclosed())
}
