//! Surfaces that nearly touch, meet in a point or a circle, or are in line, moved until they do.
//!
//! What an author meant to be tangent, concentric or flush, and missed by less than can be seen,
//! is found by what the numbers of planes, balls, round cylinders and cones nearly satisfy: each
//! such relation is an equation, linear but for second order, and all of them together are
//! satisfied by the least moves there are (Newton's method, each step by conjugate gradients
//! on the normal equations, which from nothing end at the shortest solution).

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use crate::numeric::tolerance::VALUE;
use crate::program::{Kind, Surface};
use crate::surface::SurfaceShape;

/// More surfaces are left as they are: their relations are looked for pair by pair, and along
/// each axis for each plane across.
const MOST: usize = 150;

/// A surface by its numbers, about the middle of the scene.
#[derive(Clone, Copy, Debug)]
struct Element {
    form: Form,
    /// A point of the plane, the centre, a point of the axis, or the apex.
    at: DVec3,
    /// The normal or the axis.
    axis: DVec3,
    /// The radius, or for cones the slope times the scene's reach.
    size: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Plane,
    Ball,
    Rod,
    Cone,
    /// Something else about a centre.
    Centered,
    /// Nothing to be moved.
    Fixed,
}

/// What is nearly so: a value that ought to be 0.
#[derive(Clone, Copy, Debug)]
enum Relation {
    /// Planes of one normal, or opposite ones.
    Flush([usize; 2]),
    /// A plane through a point or along an axis, or so many radii from there.
    OnPlane([usize; 2], f64),
    /// Points or axes in one place, as seen along a direction.
    InLine([usize; 2], DVec3),
    /// Points or axes at a distance of the radii times signs.
    Apart([usize; 2], [f64; 2]),
    /// Sizes of one kind.
    SameSize([usize; 2]),
    /// Two surfaces about one axis meet in a circle in a plane across it.
    Circle(usize, [usize; 2]),
}

/// By how much a value changes with the place and the size of an element.
type Slopes = SmallVec<[(usize, DVec3, f64); 3]>;

impl Element {
    fn of(surface: &Surface, reach: f64) -> Self {
        let element = |form, at, axis, size| Self {
            form,
            at,
            axis,
            size,
        };
        match surface.shape() {
            SurfaceShape::Plane { point, normal } => {
                element(Form::Plane, point.dot(normal) * normal, normal, 0.0)
            }
            SurfaceShape::Sphere { center, radius } => {
                element(Form::Ball, center, DVec3::ZERO, radius)
            }
            SurfaceShape::Cylinder {
                point,
                axis,
                radius,
            } => element(Form::Rod, point.reject_from(axis), axis, radius),
            SurfaceShape::Cone {
                point,
                axis,
                slope,
                radius: 0.0,
            } => element(Form::Cone, point, axis, slope * reach),
            SurfaceShape::Ellipsoid { placement, .. }
            | SurfaceShape::HyperboloidOneSheet { placement, .. }
            | SurfaceShape::HyperboloidTwoSheets { placement, .. }
            | SurfaceShape::EllipticCone { placement, .. } => {
                element(Form::Centered, placement.origin, DVec3::ZERO, 0.0)
            }
            _ => element(Form::Fixed, DVec3::ZERO, DVec3::ZERO, 0.0),
        }
    }

    fn has_axis(&self) -> bool {
        matches!(self.form, Form::Plane | Form::Rod | Form::Cone)
    }

    fn has_place(&self) -> bool {
        !matches!(self.form, Form::Plane | Form::Fixed)
    }

    fn radius(&self) -> f64 {
        match self.form {
            Form::Ball | Form::Rod => self.size,
            _ => 0.0,
        }
    }

    /// The surface with these numbers in place of its own.
    fn applied_to(&self, surface: &Surface, reach: f64) -> Surface {
        let sign = surface.quadratic[..3].iter().sum::<f64>().signum();
        // Of the unit matrix less the square of the axis, and of that square.
        let about_axis = |across: f64, along: f64, constant: f64, kind| {
            let [x, y, z] = self.axis.to_array();
            let less = along - across;
            let form = [
                across + less * x * x,
                across + less * y * y,
                across + less * z * z,
                2.0 * less * x * y,
                2.0 * less * y * z,
                2.0 * less * z * x,
            ];
            let size = form.iter().fold(0.0f64, |m, c| m.max(c.abs()));
            Surface {
                anchor: self.at,
                quadratic: form.map(|c| sign * c / size),
                linear: DVec3::ZERO,
                constant: sign * constant / size,
                kind,
            }
        };
        match self.form {
            Form::Plane => Surface {
                anchor: self.at,
                linear: self.axis,
                ..*surface
            },
            Form::Ball => about_axis(1.0, 1.0, -self.size * self.size, surface.kind),
            Form::Rod => about_axis(1.0, 0.0, -self.size * self.size, surface.kind),
            Form::Cone => {
                let slope = self.size / reach;
                let cone = about_axis(1.0, -slope * slope, 0.0, Kind::Cone);
                // Inside and outside are those of before.
                let far = self.at + self.axis;
                match cone.value(far) * surface.value(far) < 0.0 {
                    true => cone.negated(),
                    false => cone,
                }
            }
            Form::Centered => {
                let center = Self::of(surface, reach).at;
                Surface {
                    anchor: surface.anchor + (self.at - center),
                    ..*surface
                }
            }
            Form::Fixed => *surface,
        }
    }
}

/// Surfaces about the middle of the scene with the places, directions and sizes that their
/// relations ask for; those that are fixed stay. None if there is nothing to be moved.
pub(super) fn aligned(
    surfaces: &[Surface],
    is_fixed: impl Fn(usize) -> bool,
    reach: f64,
    within: f64,
) -> Option<Vec<Surface>> {
    const STEPS: usize = 5;
    if surfaces.len() > MOST {
        return None;
    }
    let of = |(index, surface): (usize, &Surface)| {
        let element = Element::of(surface, reach);
        match is_fixed(index) {
            true => Element {
                form: Form::Fixed,
                ..element
            },
            false => element,
        }
    };
    let before: Vec<Element> = surfaces.iter().enumerate().map(of).collect();
    let mut elements = before.clone();
    straighten(&mut elements, within / reach);
    let relations = relations(&elements, reach, within);
    let rounding = VALUE * reach;
    for _ in 0..STEPS {
        let rows: Vec<(f64, Slopes)> = relations
            .iter()
            .map(|relation| relation.value(&elements, reach))
            .collect();
        if rows.iter().all(|(value, _)| value.abs() <= rounding) {
            break;
        }
        let moves = least_moves(&rows, elements.len());
        for (element, (by, size)) in elements.iter_mut().zip(moves) {
            element.at += by;
            element.size += size;
        }
    }
    let mut is_moved = false;
    let after = surfaces.iter().zip(&before).zip(&elements);
    let after = after.map(|((surface, before), after)| {
        let by = before.at.distance(after.at) + (before.size - after.size).abs();
        let turned = before.axis.distance(after.axis) * reach;
        if by + turned <= rounding {
            return *surface;
        }
        is_moved = true;
        after.applied_to(surface, reach)
    });
    let after: Vec<Surface> = after.collect();
    is_moved.then_some(after)
}

/// Makes directions that are nearly the same, or nearly at right angles, so.
fn straighten(elements: &mut [Element], within: f64) {
    let mut known: Vec<DVec3> = Vec::new();
    for element in elements.iter_mut().filter(|element| element.has_axis()) {
        let axis = element.axis;
        let same = known.iter().find(|k| k.cross(axis).length() <= within);
        if let Some(same) = same {
            element.axis = same.dot(axis).signum() * *same;
        } else {
            let mut across = known.iter().filter(|k| k.dot(axis).abs() <= within);
            element.axis = match (across.next(), across.next()) {
                (None, _) => axis,
                (Some(one), other) => {
                    let normal = other.map(|other| one.cross(*other));
                    let normal = normal.filter(|normal| normal.length() > 0.1);
                    let straight = match normal {
                        Some(normal) => normal.dot(axis).signum() * normal,
                        None => axis.reject_from_normalized(*one),
                    };
                    straight.normalize()
                }
            };
            known.push(element.axis);
        }
        element.at = match element.form {
            Form::Plane => element.at.dot(axis) * axis.dot(element.axis).signum() * element.axis,
            Form::Rod => element.at.reject_from_normalized(element.axis),
            _ => element.at,
        };
    }
}

/// Whether directions are the same or opposite, once they were straightened.
fn is_parallel(a: DVec3, b: DVec3) -> bool {
    a.cross(b).length() <= VALUE
}

fn is_across(a: DVec3, b: DVec3) -> bool {
    a.dot(b).abs() <= VALUE
}

/// The directions in which places of two elements differ: all, or those across axes.
fn free_directions(a: &Element, b: &Element) -> SmallVec<[DVec3; 3]> {
    let axis = |element: &Element| (element.form == Form::Rod).then_some(element.axis);
    let across = |axis: DVec3| <[DVec3; 2]>::from(axis.any_orthonormal_pair());
    match (axis(a), axis(b)) {
        (None, None) => smallvec![DVec3::X, DVec3::Y, DVec3::Z],
        (Some(axis), Some(other)) if !is_parallel(axis, other) => {
            smallvec![axis.cross(other).normalize()]
        }
        (Some(axis), _) | (_, Some(axis)) => SmallVec::from_slice(&across(axis)),
    }
}

/// From one place to the other, in the directions in which they differ.
fn separation(a: &Element, b: &Element) -> DVec3 {
    let directions = free_directions(a, b);
    let off = b.at - a.at;
    directions.iter().map(|&e| off.dot(e) * e).sum()
}

fn relations(elements: &[Element], reach: f64, within: f64) -> Vec<Relation> {
    let mut found = Vec::new();
    let is_near = |value: f64| value.abs() <= within;
    for (i, a) in elements.iter().enumerate() {
        for (k, b) in elements.iter().enumerate().skip(i + 1) {
            let pair = [i, k];
            match (a.form, b.form) {
                (Form::Fixed, _) | (_, Form::Fixed) => {}
                (Form::Plane, Form::Plane) => {
                    let off = (a.at - b.at).dot(a.axis);
                    if is_parallel(a.axis, b.axis) && is_near(off) {
                        found.push(Relation::Flush(pair));
                    }
                }
                (Form::Plane, _) => found.extend(on_plane(elements, [i, k], within)),
                (_, Form::Plane) => found.extend(on_plane(elements, [k, i], within)),
                _ => found.extend(between(elements, pair, within)),
            }
            if a.form == b.form && matches!(a.form, Form::Ball | Form::Rod | Form::Cone) {
                let is_same = is_near(a.size - b.size);
                found.extend(is_same.then_some(Relation::SameSize(pair)));
            }
        }
    }
    let planes = (0..elements.len()).filter(|&p| elements[p].form == Form::Plane);
    let planes: Vec<usize> = planes.collect();
    for (i, a) in elements.iter().enumerate() {
        for (k, b) in elements.iter().enumerate().skip(i + 1) {
            let Some(axis) = common_axis(a, b, within) else {
                continue;
            };
            let across = planes
                .iter()
                .filter(|&&p| is_parallel(elements[p].axis, axis));
            for &plane in across {
                let radii = [a, b].map(|round| round_at(round, &elements[plane], reach));
                if let [Some((one, ..)), Some((other, ..))] = radii
                    && is_near(one - other)
                {
                    found.push(Relation::Circle(plane, [i, k]));
                }
            }
        }
    }
    found
}

fn on_plane(elements: &[Element], pair: [usize; 2], within: f64) -> Option<Relation> {
    let [plane, other] = pair.map(|index| &elements[index]);
    let is_along = other.form != Form::Rod || is_across(plane.axis, other.axis);
    let off = (other.at - plane.at).dot(plane.axis);
    let radii = [0.0, 1.0, -1.0].into_iter();
    let mut near = radii.filter(|radii| (off - radii * other.radius()).abs() <= within);
    let radii = near.next().filter(|_| is_along && other.has_place())?;
    Some(Relation::OnPlane(pair, radii))
}

fn between(elements: &[Element], pair: [usize; 2], within: f64) -> SmallVec<[Relation; 3]> {
    let [a, b] = pair.map(|index| &elements[index]);
    let apart = separation(a, b).length();
    if apart <= within {
        let directions = free_directions(a, b).into_iter();
        return directions.map(|e| Relation::InLine(pair, e)).collect();
    }
    let [r, s] = [a.radius(), b.radius()];
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0]];
    let mut signs = signs.into_iter().filter(|_| r + s > 0.0);
    let near = signs.find(|[p, q]| (p * r + q * s - apart).abs() <= within);
    near.map(|signs| Relation::Apart(pair, signs))
        .into_iter()
        .collect()
}

/// The axis about which both are round.
fn common_axis(a: &Element, b: &Element, within: f64) -> Option<DVec3> {
    let is_round = |e: &Element| matches!(e.form, Form::Ball | Form::Rod | Form::Cone);
    let of = |e: &Element| (e.form != Form::Ball).then_some(e.axis);
    let axis = match (of(a), of(b)) {
        (Some(axis), Some(other)) if is_parallel(axis, other) => axis,
        (Some(axis), None) | (None, Some(axis)) => axis,
        _ => return None,
    };
    let off = (b.at - a.at).reject_from_normalized(axis).length();
    (is_round(a) && is_round(b) && off <= within).then_some(axis)
}

/// The radius of something round in a plane across its axis, and by how much it changes with
/// the plane's offset, with its own place along the plane's normal, and with its size.
fn round_at(round: &Element, plane: &Element, reach: f64) -> Option<(f64, f64, f64, f64)> {
    /// Of a ball's radius: a circle nearer to its pole says little of it.
    const LEAST: f64 = 1e-3;
    let height = (plane.at - round.at).dot(plane.axis);
    match round.form {
        Form::Rod => Some((round.size, 0.0, 0.0, 1.0)),
        Form::Cone => {
            let slope = round.size / reach * height.signum();
            Some((slope * height, slope, -slope, height.abs() / reach))
        }
        Form::Ball => {
            let radius = (round.size * round.size - height * height).max(0.0).sqrt();
            let slope = height / radius;
            (radius > LEAST * round.size).then_some((radius, -slope, slope, round.size / radius))
        }
        _ => None,
    }
}

impl Relation {
    fn value(&self, elements: &[Element], reach: f64) -> (f64, Slopes) {
        match *self {
            Self::Flush([i, k]) => {
                let normal = elements[i].axis;
                let value = (elements[i].at - elements[k].at).dot(normal);
                (value, smallvec![(i, normal, 0.0), (k, -normal, 0.0)])
            }
            Self::OnPlane([plane, other], radii) => {
                let normal = elements[plane].axis;
                let off = (elements[other].at - elements[plane].at).dot(normal);
                let value = off - radii * elements[other].radius();
                let slopes = smallvec![(plane, -normal, 0.0), (other, normal, -radii)];
                (value, slopes)
            }
            Self::InLine([i, k], along) => {
                let value = (elements[k].at - elements[i].at).dot(along);
                (value, smallvec![(i, -along, 0.0), (k, along, 0.0)])
            }
            Self::Apart([i, k], [p, q]) => {
                let [a, b] = [&elements[i], &elements[k]];
                let apart = separation(a, b);
                let along = apart.normalize_or_zero();
                let value = apart.length() - p * a.radius() - q * b.radius();
                let has_size = |e: &Element, sign: f64| match e.radius() {
                    0.0 => 0.0,
                    _ => -sign,
                };
                let slopes = smallvec![(i, -along, has_size(a, p)), (k, along, has_size(b, q))];
                (value, slopes)
            }
            Self::SameSize([i, k]) => {
                let value = elements[i].size - elements[k].size;
                (
                    value,
                    smallvec![(i, DVec3::ZERO, 1.0), (k, DVec3::ZERO, -1.0)],
                )
            }
            Self::Circle(plane, [i, k]) => {
                let normal = elements[plane].axis;
                let radii = [i, k].map(|round| round_at(&elements[round], &elements[plane], reach));
                let [Some(one), Some(other)] = radii else {
                    return (0.0, Slopes::new());
                };
                let slopes = smallvec![
                    (plane, (one.1 - other.1) * normal, 0.0),
                    (i, one.2 * normal, one.3),
                    (k, -other.2 * normal, -other.3)
                ];
                (one.0 - other.0, slopes)
            }
        }
    }
}

/// The least moves of places and sizes by which all values become 0 to first order: by
/// conjugate gradients on the normal equations (Hestenes and Stiefel, *Methods of Conjugate
/// Gradients for Solving Linear Systems*, 1952).
fn least_moves(rows: &[(f64, Slopes)], count: usize) -> Vec<(DVec3, f64)> {
    /// Of the square at first.
    const SMALL: f64 = 1e-30;
    let along = |moves: &[(DVec3, f64)]| -> Vec<f64> {
        let change = |(_, slopes): &(f64, Slopes)| {
            let each = slopes.iter().map(|&(element, place, size)| {
                let (by, grown) = moves[element];
                place.dot(by) + size * grown
            });
            each.sum()
        };
        rows.iter().map(change).collect()
    };
    let back = |values: &[f64]| {
        let mut sums = vec![(DVec3::ZERO, 0.0); count];
        for ((_, slopes), &value) in rows.iter().zip(values) {
            for &(element, place, size) in slopes {
                sums[element].0 += value * place;
                sums[element].1 += value * size;
            }
        }
        sums
    };
    let square = |moves: &[(DVec3, f64)]| -> f64 {
        let squares = moves
            .iter()
            .map(|(by, size)| by.length_squared() + size * size);
        squares.sum()
    };
    let mut moves = vec![(DVec3::ZERO, 0.0); count];
    let mut left: Vec<f64> = rows.iter().map(|(value, _)| -value).collect();
    let mut slope = back(&left);
    let mut direction = slope.clone();
    let first = square(&slope);
    let mut steepness = first;
    for _ in 0..8 * count {
        if steepness <= SMALL * first || steepness == 0.0 {
            break;
        }
        let change = along(&direction);
        let length: f64 = change.iter().map(|c| c * c).sum();
        if length == 0.0 {
            break;
        }
        let step = steepness / length;
        for (all, one) in moves.iter_mut().zip(&direction) {
            all.0 += step * one.0;
            all.1 += step * one.1;
        }
        for (left, change) in left.iter_mut().zip(&change) {
            *left -= step * change;
        }
        slope = back(&left);
        let next = square(&slope);
        let share = next / steepness;
        for (all, one) in direction.iter_mut().zip(&slope) {
            *all = (one.0 + share * all.0, one.1 + share * all.1);
        }
        steepness = next;
    }
    moves
}
