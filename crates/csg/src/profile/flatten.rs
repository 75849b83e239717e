//! Polygons: chords for arcs, and Booleans of contours by `i_overlay` on a grid
//! of whole numbers that holds every corner given to it exactly.

use glam::{DAffine2, DVec2};
use i_overlay::core::fill_rule::FillRule as OverlayFill;
use i_overlay::core::overlay::{Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::point::IntPoint;

use super::arcs::{chords, cut};
use super::contour::{Nesting, cleaned, stretch};
use super::fault::ProfileFault;
use super::monotone::orient;
use super::turn::turn;
use super::{Combination, Contour, Corner, FillRule, Profile, Shape};

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
        Ok(contours.into_iter().flatten().fold(None, |bounds, point| {
            let (min, max) = bounds.unwrap_or((point, point));
            Some((min.min(point), max.max(point)))
        }))
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
        let polygons = self.fold(
            |shape, map| match shape {
                Shape::Disc => Ok(vec![points_of(&[disc_corners(map, tolerance)])]),
                Shape::Contours(contours, rule) => {
                    let stretch = stretch(&map.matrix2);
                    let mut clean = Vec::new();
                    for contour in contours.iter() {
                        let mapped: Contour = cut(contour, stretch, tolerance, |_| false)
                            .into_iter()
                            .map(|corner| Corner::straight(map.transform_point2(corner.point)))
                            .collect();
                        clean.extend(cleaned(&mapped)?);
                    }
                    Ok(if crossing(&clean).is_some() {
                        resolved(&points_of(&clean), *rule)
                    } else {
                        grouped(&points_of(&clean), *rule)
                    })
                }
            },
            |combination, operands| Ok(combined(combination, operands)),
        )?;
        Ok(polygons.unwrap_or_default())
    }
}

/// The corners of chords for the image of the disc of radius 1.
pub(super) fn disc_corners(map: &DAffine2, tolerance: f64) -> Contour {
    let count = chords(stretch(&map.matrix2), std::f64::consts::TAU, tolerance).max(3);
    let mut corners: Contour = (0..count)
        .map(|k| Corner::straight(map.transform_point2(turn(k, count))))
        .collect();
    if map.matrix2.determinant() < 0.0 {
        corners.reverse();
    }
    corners
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

/// Whether a point lies within a polygon and not on its boundary: crossings
/// of the ray towards +x, by exact predicates.
pub(super) fn encloses(polygon: &[DVec2], point: DVec2) -> bool {
    let mut inside = false;
    for (&a, &b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        if (a.y > point.y) != (b.y > point.y) {
            let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
            inside ^= orient(low, high, point) > 0.0;
        }
    }
    inside
}

/// The corners at which a polygon turns.
pub(super) fn without_straight(points: &[DVec2]) -> Vec<DVec2> {
    let corners: Contour = points.iter().copied().map(Corner::straight).collect();
    let clean = cleaned(&corners).ok().flatten().unwrap_or_default();
    clean.into_iter().map(|corner| corner.point).collect()
}

/// A place where two sides meet that are not neighbours, or neighbours in more
/// than their corner; arcs as fine polygons. Sides are sorted by x.
pub(super) fn crossing(contours: &[Contour]) -> Option<DVec2> {
    let mut sides: Vec<(DVec2, DVec2, usize, usize)> = Vec::new();
    for contour in contours {
        let points = super::arcs::trace(contour);
        let (first, count) = (sides.len(), points.len());
        for k in 0..count {
            let next = first + (k + 1) % count;
            sides.push((points[k], points[(k + 1) % count], first + k, next));
        }
    }
    sides.sort_by(|a, b| a.0.x.min(a.1.x).total_cmp(&b.0.x.min(b.1.x)));
    for (rank, &(a, b, own, next)) in sides.iter().enumerate() {
        let reach = a.x.max(b.x);
        for &(c, d, other, after) in &sides[rank + 1..] {
            if c.x.min(d.x) > reach {
                break;
            }
            if a.y.max(b.y) < c.y.min(d.y) || c.y.max(d.y) < a.y.min(b.y) {
                continue;
            }
            let meet = if next == other {
                after != own && folds_back(a, b, d)
            } else if after == own {
                folds_back(c, d, b)
            } else {
                sides_meet(a, b, c, d)
            };
            if meet {
                return Some(a.midpoint(b).midpoint(c.midpoint(d)));
            }
        }
    }
    None
}

/// Whether the side from b to c lies on the one from a to b.
fn folds_back(a: DVec2, b: DVec2, c: DVec2) -> bool {
    orient(a, b, c) == 0.0 && (a - b).dot(c - b) > 0.0
}

fn sides_meet(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let ends = [orient(a, b, c), orient(a, b, d)];
    let others = [orient(c, d, a), orient(c, d, b)];
    let apart = |[p, q]: [f64; 2]| p > 0.0 && q > 0.0 || p < 0.0 && q < 0.0;
    // Boxes overlap: on one line that is a meeting.
    !apart(ends) && !apart(others)
}

/// Contours that do not meet, as polygons.
fn grouped(contours: &[Vec<DVec2>], rule: FillRule) -> Vec<Polygon> {
    let nesting = Nesting::of(contours, rule);
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

/// Whole numbers have 62 bits: a scale by a power of two that uses most of them
/// keeps every corner within 2^-59 of the largest coordinate.
fn overlay(
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
    let scale = 2.0_f64.powi(59 - (largest.log2().floor() as i32 + 1));
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
