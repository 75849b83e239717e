//! Polygons: chords for arcs, and Booleans of contours by `i_overlay` on a grid
//! of whole numbers that holds every corner given to it exactly.

use crate::elementary;
use glam::{DAffine2, DVec2};
use i_overlay::core::fill_rule::FillRule as OverlayFill;
use i_overlay::core::overlay::{Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::point::IntPoint;

use super::arcs::{Sagitta, chords, stretch};
use super::bent::{Bent, cut};
use super::plane_set::Leaf;
use super::polygon::{Nesting, cleaned, crossing, doubled_area, points_of};
use super::turn::turn;
use super::{Combination, Contour, Corner, FillRule, Profile, Shape, Step};
use crate::error::ProfileFault;
use crate::numeric::Welder;
use crate::numeric::tolerance::IN_PROFILE;

/// A polygon: its outer contour, counter-clockwise, then its holes, clockwise.
pub(super) type Polygon = Vec<Vec<DVec2>>;

impl Profile {
    /// The profile as closed polygons, outer contours counter-clockwise and
    /// holes clockwise, arcs cut into chords that stray at most `tolerance`
    /// from them.
    ///
    /// # Errors
    /// Whatever is wrong with the profile; a tolerance that is not positive.
    pub fn contours(&self, tolerance: f64) -> Result<Vec<Vec<DVec2>>, ProfileFault> {
        Ok(self.polygons(tolerance)?.into_iter().flatten().collect())
    }

    /// The least and the greatest coordinates, arcs within `tolerance`; `None`
    /// if the profile has no points.
    ///
    /// # Errors
    /// As [`Profile::contours`].
    pub fn bounds(&self, tolerance: f64) -> Result<Option<(DVec2, DVec2)>, ProfileFault> {
        let contours = self.contours(tolerance)?;
        let bounds = contours.into_iter().flatten().fold(None, |bounds, point| {
            let (min, max) = bounds.unwrap_or((point, point));
            Some((min.min(point), max.max(point)))
        });
        // Between chords there may be nothing where there is something between arcs.
        Ok(bounds.or_else(|| self.exact_bounds().flatten()))
    }

    /// The same, to rounding where [`Profile::exact_area`] is, else to 1e-7 of the size.
    pub(crate) fn tight_bounds(&self) -> Result<Option<(DVec2, DVec2)>, ProfileFault> {
        const SHARE: f64 = 1e-7;
        match self.exact_bounds() {
            Some(bounds) if self.fault().is_none() => Ok(bounds),
            _ => self.bounds(self.tolerance_of(SHARE)?),
        }
    }

    /// A box around the profile, however much too large; `None` if there is none.
    pub(crate) fn reach(&self) -> Result<Option<(DVec2, DVec2)>, ProfileFault> {
        type Reach = (DVec2, DVec2);
        let around = |one: Reach, other: Reach| (one.0.min(other.0), one.1.max(other.1));
        let common = |one: Option<Reach>, other: Option<Reach>| {
            let ((a, b), (c, d)) = (one?, other?);
            let (min, max) = (a.max(c), b.min(d));
            min.cmple(max).all().then_some((min, max))
        };
        let of_shape = |shape: &Shape, map: &DAffine2| {
            let disc = |map: &DAffine2| {
                let (x, y) = (map.matrix2.x_axis, map.matrix2.y_axis);
                let half = DVec2::new(elementary::hypot(x.x, y.x), elementary::hypot(x.y, y.y));
                (map.translation - half, map.translation + half)
            };
            Ok(match shape {
                Shape::Disc => Some(disc(map)),
                Shape::Contours(contours, _) => {
                    let points = contours.iter().flat_map(|contour| {
                        (0..contour.len()).flat_map(|k| match Bent::of(contour, k) {
                            Some(side) => side.around(),
                            None => vec![contour[k].point],
                        })
                    });
                    let points = points.map(|point| map.transform_point2(point));
                    points.map(|point| (point, point)).reduce(around)
                }
            })
        };
        let combined = |combination, operands: Vec<Option<Reach>>| {
            Ok(match combination {
                Combination::Union => operands.into_iter().flatten().reduce(around),
                Combination::Intersection => operands.into_iter().reduce(common).flatten(),
                Combination::Difference => operands.into_iter().next().flatten(),
            })
        };
        Ok(self.fold(of_shape, combined)?.flatten())
    }

    /// The area, arcs within `tolerance`.
    ///
    /// # Errors
    /// As [`Profile::contours`].
    pub fn area(&self, tolerance: f64) -> Result<f64, ProfileFault> {
        let contours = self.contours(tolerance)?;
        Ok(0.5 * contours.iter().map(|c| doubled_area(c)).sum::<f64>())
    }

    /// The same profile with chords instead of arcs and circles, straying at
    /// most `tolerance` from them, and its Booleans carried out.
    #[must_use]
    pub fn flattened(&self, tolerance: f64) -> Self {
        Self::of(self.contours(tolerance).map(Self::of_polygons))
    }

    /// The same profile with chords instead of parabolas, straying at most `tolerance` from them;
    /// `None` if it has no parabolas.
    pub(crate) fn without_parabolas(&self, tolerance: f64) -> Option<Self> {
        let mut has_parabolas = false;
        let mut profile = self.clone();
        for step in &mut profile.steps {
            if let Step::Shape(Shape::Contours(contours, _), map) = step
                && contours.iter().flatten().any(Corner::is_parabola)
            {
                has_parabolas = true;
                let sagitta = Sagitta::of_length(tolerance);
                let stretch = stretch(&map.matrix2);
                let keeps = |leaf: Leaf| !matches!(leaf, Leaf::Parabola(_));
                let cut = contours
                    .iter()
                    .map(|contour| cut(contour, stretch, sagitta, keeps));
                *contours = cut.collect();
            }
        }
        has_parabolas.then_some(profile)
    }

    fn of_polygons(polygons: Vec<Vec<DVec2>>) -> Self {
        let contours: Vec<Contour> = polygons
            .into_iter()
            .map(|points| points.into_iter().map(Corner::straight).collect())
            .collect();
        let shape = Shape::Contours(contours.into(), FillRule::NonZero);
        Self::shape(shape, DAffine2::IDENTITY)
    }

    pub(super) fn polygons(&self, tolerance: f64) -> Result<Vec<Polygon>, ProfileFault> {
        if tolerance.is_nan() || tolerance <= 0.0 {
            let what = "the tolerance";
            return Err(ProfileFault::NotPositive {
                what,
                value: tolerance,
            });
        }
        let sagitta = Sagitta::of_length(tolerance);
        let polygons = self.fold(
            |shape, map| match shape {
                Shape::Disc => Ok(vec![points_of(&[disc_corners(map, sagitta)])]),
                Shape::Contours(contours, rule) => {
                    let stretch = stretch(&map.matrix2);
                    let mut clean = Vec::new();
                    for contour in contours.iter() {
                        let mapped: Contour = cut(contour, stretch, sagitta, |_| false)
                            .into_iter()
                            .map(|corner| Corner::straight(map.transform_point2(corner.point)))
                            .collect();
                        clean.extend(cleaned(&mapped)?);
                    }
                    Ok(if crossing(&clean).is_some() {
                        resolved(&points_of(&clean), *rule)
                    } else {
                        grouped(&clean, *rule)
                    })
                }
            },
            |combination, operands| Ok(combined(combination, operands)),
        )?;
        Ok(polygons.unwrap_or_default())
    }
}

/// The corners of chords for the image of the disc of radius 1: of the same area
/// where they must also be that near to its radius, else on it.
pub(super) fn disc_corners(map: &DAffine2, sagitta: Sagitta) -> Contour {
    let count = chords(stretch(&map.matrix2), std::f64::consts::TAU, sagitta).max(3);
    let angle = std::f64::consts::TAU / count as f64;
    let radius = if sagitta.of_radius < 1.0 {
        (angle / elementary::sin(angle)).sqrt()
    } else {
        1.0
    };
    let mut corners: Contour = (0..count)
        .map(|k| Corner::straight(map.transform_point2(radius * turn(k, count))))
        .collect();
    if map.matrix2.determinant() < 0.0 {
        corners.reverse();
    }
    corners
}

/// Contours that do not meet, as polygons.
fn grouped(contours: &[Contour], rule: FillRule) -> Vec<Polygon> {
    let nesting = Nesting::of(contours, rule);
    let contours = points_of(contours);
    let mut polygons: Vec<Polygon> = Vec::new();
    // Which polygon a contour is of, or the one around a contour that bounds nothing.
    let mut polygon_of: Vec<Option<usize>> = vec![None; contours.len()];
    for &k in &nesting.order {
        let around = nesting.parents[k].and_then(|parent| polygon_of[parent]);
        if !nesting.bounds[k] {
            polygon_of[k] = around;
            continue;
        }
        let mut points = contours[k].clone();
        if (doubled_area(&points) > 0.0) != nesting.inside[k] {
            points.reverse();
        }
        if nesting.inside[k] {
            polygon_of[k] = Some(polygons.len());
            polygons.push(vec![points]);
        } else if let Some(polygon) = around {
            polygons[polygon].push(points);
        }
    }
    polygons
}

/// Whatever the contours enclose, as polygons that do not cross.
pub(super) fn resolved(contours: &[Vec<DVec2>], rule: FillRule) -> Vec<Polygon> {
    let fill = match rule {
        FillRule::EvenOdd => OverlayFill::EvenOdd,
        FillRule::NonZero => OverlayFill::NonZero,
    };
    overlay(contours, &[], OverlayRule::Subject, fill)
}

/// Where the contours wind around counter-clockwise more often than not.
pub(super) fn positive(contours: &[Vec<DVec2>]) -> Vec<Polygon> {
    overlay(contours, &[], OverlayRule::Subject, OverlayFill::Positive)
}

fn combined(combination: Combination, mut operands: Vec<Vec<Polygon>>) -> Vec<Polygon> {
    if operands.len() < 2 {
        return operands.pop().unwrap_or_default();
    }
    let rule = match combination {
        Combination::Union => {
            let all: Vec<Vec<DVec2>> = operands.into_iter().flatten().flatten().collect();
            return positive(&all);
        }
        Combination::Intersection => OverlayRule::Intersect,
        Combination::Difference => OverlayRule::Difference,
    };
    let mut operands = operands.into_iter();
    let mut result = operands.next().unwrap_or_default();
    for operand in operands {
        let [subject, clip] = [result.concat(), operand.concat()];
        result = overlay(&subject, &clip, rule, OverlayFill::Positive);
    }
    result
}

/// The outlines of what contours enclose, corners that are one but for rounding at one place.
fn overlay(
    subject: &[Vec<DVec2>],
    clip: &[Vec<DVec2>],
    rule: OverlayRule,
    fill: OverlayFill,
) -> Vec<Polygon> {
    /// Corners that were moved may have made others, at most so often.
    const ROUNDS: usize = 4;
    let mut polygons = overlay_once(subject, clip, rule, fill);
    for _ in 0..ROUNDS {
        if !put_together(&mut polygons) {
            break;
        }
        let fill = OverlayFill::Positive;
        polygons = overlay_once(&polygons.concat(), &[], OverlayRule::Subject, fill);
    }
    polygons
}

/// Puts corners at one place that are no farther apart than rounding; whether there were such.
fn put_together(polygons: &mut [Polygon]) -> bool {
    let corners = || polygons.iter().flatten().flatten();
    let reach = corners().fold(0.0_f64, |most, p| p.abs().max_element().max(most));
    let mut welder = Welder::new(IN_PROFILE * reach);
    let mut is_moved = false;
    for corner in polygons.iter_mut().flatten().flatten() {
        let number = welder.number(corner.extend(0.0));
        let place = welder.points[number as usize].truncate();
        is_moved |= place != *corner;
        *corner = place;
    }
    is_moved
}

/// Whole numbers have 62 bits: a scale by a power of two that uses most of them
/// keeps every corner within 2^-59 of the largest coordinate.
fn overlay_once(
    subject: &[Vec<DVec2>],
    clip: &[Vec<DVec2>],
    rule: OverlayRule,
    fill: OverlayFill,
) -> Vec<Polygon> {
    let all = subject.iter().chain(clip).flatten();
    let largest = all.fold(0.0_f64, |most, point| point.abs().max_element().max(most));
    if !(1e-250..1e250).contains(&largest) {
        return Vec::new();
    }
    let scale = 2.0_f64.powi(59 - (elementary::log2(largest).floor() as i32 + 1));
    let mut engine = Overlay::<i64>::new(64);
    for (contours, kind) in [(subject, ShapeType::Subject), (clip, ShapeType::Clip)] {
        for contour in contours {
            let points = contour.iter().map(|point| {
                let [x, y] = (*point * scale).to_array().map(|v| v.round() as i64);
                IntPoint { x, y }
            });
            engine.add_path_iter(points, kind);
        }
    }
    let back = |point: IntPoint<i64>| DVec2::new(point.x as f64, point.y as f64) / scale;
    let shapes = engine.overlay(rule, fill).into_iter();
    shapes
        .map(|shape| {
            let contours = shape.into_iter();
            contours
                .map(|contour| contour.into_iter().map(back).collect())
                .collect()
        })
        .collect()
}
