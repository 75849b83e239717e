//! The curves in which two surfaces meet, in closed form.
//!
//! A plane cuts a quadric in a conic. Two quadrics meet in conics, too, if some
//! combination of them is a plane or a pair of planes; else, if one of them is
//! a cylinder or a cone, every ruling of it meets the other in at most two
//! points (Levin, *A Parametric Algorithm for Drawing Pictures of Solid Objects
//! Composed of Quadric Surfaces*, 1976).

use std::f64::consts::TAU;

use glam::{DMat4, DVec3, DVec4};
use smallvec::SmallVec;

use super::curve::{BEGIN, Curve, Form, Part, Rulings, polar};
use super::frame::{Frame, Ruled};
use super::roots::{Roots, Trig};
use crate::program::{Surface, eigen_symmetric};

/// Why the curves of two surfaces are not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Unknown {
    /// They touch in single points.
    Touch,
    /// There is no closed form for them here.
    NoForm,
}

/// All curves of two surfaces.
pub(crate) type Curves = SmallVec<[Curve; 2]>;

/// Coefficients below this share of the largest are rounding.
const NEGLIGIBLE: f64 = 1e-11;

/// A surface, and its frame if it is a quadric.
#[derive(Clone, Copy)]
pub(super) struct Framed<'a> {
    pub surface: &'a Surface,
    pub frame: Option<&'a Frame>,
}

/// The curves common to two surfaces. Surfaces that come nearer to each other
/// than `near` without crossing touch.
pub(super) fn curves(first: Framed<'_>, second: Framed<'_>, near: f64) -> Result<Curves, Unknown> {
    let (a, b) = (first.surface, second.surface);
    if a.is_plane() && b.is_plane() {
        return Ok(line(a, b).into_iter().collect());
    }
    if a.is_plane() {
        return conic(a, b, near);
    }
    if b.is_plane() {
        return conic(b, a, near);
    }
    if let Some(plane) = radical_plane(a, b) {
        return plane.map_or(Ok(Curves::new()), |plane| conic(&plane, a, near));
    }
    let ruled = |framed: Framed<'_>, wanted| framed.frame.is_some_and(|f| f.ruled == wanted);
    for wanted in [Ruled::Cylinder, Ruled::Cone] {
        for (carrier, other) in [(first, second), (second, first)] {
            if ruled(carrier, wanted)
                && let Some(frame) = carrier.frame
            {
                match on_rulings(carrier.surface, frame, other.surface, near) {
                    Err(Unknown::NoForm) => {}
                    known => return known,
                }
            }
        }
    }
    for carrier in singular_members(a, b) {
        if let Some(frame) = Frame::of(&carrier).filter(|frame| frame.ruled != Ruled::No) {
            for other in [a, b] {
                match on_rulings(&carrier, &frame, other, near) {
                    Err(Unknown::NoForm) => {}
                    known => return known,
                }
            }
        }
    }
    Err(Unknown::NoForm)
}

/// The cones, cylinders and pairs of planes among the combinations of two
/// quadrics: those whose 4 by 4 matrix is singular.
fn singular_members(a: &Surface, b: &Surface) -> Vec<Surface> {
    let anchor = 0.5 * (a.anchor + b.anchor);
    // In units in which all coefficients are of like size.
    let size = [a, b].map(|s| {
        s.value(anchor)
            .abs()
            .sqrt()
            .max(s.gradient(anchor).length())
    });
    let unit = size[0].max(size[1]).max(a.anchor.distance(b.anchor));
    let matrix = |s: &Surface| {
        let [xx, yy, zz, xy, yz, zx] = s.quadratic;
        let g = s.gradient(anchor) / unit;
        let c = s.value(anchor) / (unit * unit);
        [
            [xx, 0.5 * xy, 0.5 * zx, 0.5 * g.x],
            [0.5 * xy, yy, 0.5 * yz, 0.5 * g.y],
            [0.5 * zx, 0.5 * yz, zz, 0.5 * g.z],
            [0.5 * g.x, 0.5 * g.y, 0.5 * g.z, c],
        ]
    };
    let (p, q) = (matrix(a), matrix(b));
    // Of degree four in the cosine and the sine of an angle, and the same at
    // the opposite one: of degree two in those of its double.
    let determinant = |doubled: f64| {
        let (sin, cos) = (0.5 * doubled).sin_cos();
        let column =
            |k: usize| DVec4::from_array(std::array::from_fn(|i| cos * p[i][k] + sin * q[i][k]));
        DMat4::from_cols(column(0), column(1), column(2), column(3)).determinant()
    };
    let trig = Trig::through(determinant);
    let mut roots = Roots::default();
    trig.roots(1e-14 * trig.magnitude(), &mut roots);
    let combined = |&doubled: &f64| {
        let (sin, cos) = (0.5 * doubled).sin_cos();
        let mut quadratic: [f64; 6] =
            std::array::from_fn(|k| cos * a.quadratic[k] + sin * b.quadratic[k]);
        let largest = quadratic.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for value in &mut quadratic {
            *value /= largest;
        }
        let sum = |f: &dyn Fn(&Surface) -> DVec3| (cos * f(a) + sin * f(b)) / largest;
        Surface {
            anchor,
            quadratic,
            linear: sum(&|s| s.gradient(anchor)),
            constant: (cos * a.value(anchor) + sin * b.value(anchor)) / largest,
        }
    };
    roots.simple.iter().map(combined).collect()
}

/// The line common to two planes.
fn line(p: &Surface, q: &Surface) -> Option<Curve> {
    /// Planes that meet at a smaller sine of their angle are parallel.
    const PARALLEL: f64 = 1e-11;
    let direction = p.linear.cross(q.linear);
    let square = direction.length_squared();
    if square < PARALLEL * PARALLEL {
        return None;
    }
    let offsets = [p, q].map(|s| s.linear.dot(s.anchor));
    let point =
        (q.linear.cross(direction) * offsets[0] + direction.cross(p.linear) * offsets[1]) / square;
    Some(Curve::Line {
        point,
        direction: direction / square.sqrt(),
    })
}

/// The plane in which two quadrics of the same quadratic part, but for a factor,
/// meet. The inner option is none where they are parallel or the same.
#[allow(clippy::option_option)]
fn radical_plane(a: &Surface, b: &Surface) -> Option<Option<Surface>> {
    let dot = |p: &Surface, q: &Surface| -> f64 {
        p.quadratic
            .iter()
            .zip(q.quadratic)
            .map(|(p, q)| p * q)
            .sum()
    };
    let factor = dot(a, b) / dot(b, b);
    let rest = a.quadratic.iter().zip(b.quadratic);
    if rest
        .map(|(a, b)| (a - factor * b).abs())
        .fold(0.0, f64::max)
        > NEGLIGIBLE
    {
        return None;
    }
    // Linear: the same gradient everywhere.
    let at = 0.5 * (a.anchor + b.anchor);
    let gradient = a.gradient(at) - factor * b.gradient(at);
    let value = a.value(at) - factor * b.value(at);
    let length = gradient.length();
    let terms = a.gradient(at).length() + factor.abs() * b.gradient(at).length();
    if length <= 1e-9 * terms.max(f64::MIN_POSITIVE) {
        return Some(None);
    }
    Some(Some(Surface {
        anchor: at - value / (length * length) * gradient,
        quadratic: [0.0; 6],
        linear: gradient / length,
        constant: 0.0,
    }))
}

/// The curves in which a plane cuts a quadric, where they are known.
pub(crate) fn conics(plane: &Surface, quadric: &Surface, near: f64) -> Curves {
    conic(plane, quadric, near).unwrap_or_default()
}

/// The conic in which a plane cuts a quadric.
fn conic(plane: &Surface, quadric: &Surface, near: f64) -> Result<Curves, Unknown> {
    let foot = quadric.anchor - plane.value(quadric.anchor) * plane.linear;
    let (u, v) = plane.linear.any_orthonormal_pair();
    let Form {
        square: [xx, yy, xy],
        linear: [x, y],
        ..
    } = Form::of(quadric, foot, u, v);
    // Principal axes.
    let (sin, cos) = (0.5 * xy.atan2(xx - yy)).sin_cos();
    let (u, v) = (cos * u + sin * v, cos * v - sin * u);
    let [mut first, mut second] = [u, v].map(|d| 0.5 * quadric.curvature_along(d));
    let (x, y) = (cos * x + sin * y, cos * y - sin * x);
    for value in [&mut first, &mut second] {
        if value.abs() <= NEGLIGIBLE {
            *value = 0.0;
        }
    }
    let mut axes = [(first, u, x), (second, v, y)];
    if first == 0.0 {
        axes.swap(0, 1);
    }
    let [(first, u, x), (second, v, y)] = axes;
    if first == 0.0 {
        // A plane in which the quadric is linear: never two generic ones.
        return Err(Unknown::NoForm);
    }
    let mut curves = Curves::new();
    let mut center = foot - x / (2.0 * first) * u;
    if second != 0.0 {
        center -= y / (2.0 * second) * v;
        let rest = quadric.value(center);
        // Of the points in the plane where the gradient points into it, the
        // centre is nearest to the surface.
        let touches = rest.abs() <= near * quadric.gradient(center).length().max(near);
        let radius = |value: f64| (rest / value).abs().sqrt();
        let (a, b) = (radius(first) * u, radius(second) * v);
        if (first > 0.0) == (second > 0.0) {
            if touches {
                // At the apex of a cone there is no curve, but no contact either.
                let is_apex = |apex: DVec3| apex.distance(center) <= near;
                return if quadric.apex().is_some_and(is_apex) {
                    Ok(curves)
                } else {
                    Err(Unknown::Touch)
                };
            }
            if (rest > 0.0) != (first > 0.0) {
                let (sin, cos) = BEGIN.sin_cos();
                curves.push(Curve::Ellipse {
                    center,
                    a: cos * a + sin * b,
                    b: cos * b - sin * a,
                    node: None,
                });
            }
            return Ok(curves);
        }
        if touches {
            // Two lines that cross: through the apex of a cone, or in a saddle
            // that the plane touches.
            if quadric
                .apex()
                .is_none_or(|apex| apex.distance(center) > near)
            {
                return Err(Unknown::NoForm);
            }
            for sign in [1.0, -1.0] {
                let direction = second.abs().sqrt() * u + sign * first.abs().sqrt() * v;
                curves.push(Curve::Line {
                    point: center,
                    direction: direction.normalize_or_zero(),
                });
            }
            return Ok(curves);
        }
        let (a, b) = if (rest > 0.0) == (first > 0.0) {
            (b, a)
        } else {
            (a, b)
        };
        curves.push(Curve::Hyperbola { center, a, b });
        curves.push(Curve::Hyperbola {
            center,
            a: -a,
            b: -b,
        });
        return Ok(curves);
    }
    let rest = quadric.value(center);
    if y.abs() > NEGLIGIBLE * quadric.gradient(center).length() {
        // first x² + y y + rest = 0.
        curves.push(Curve::Parabola {
            point: center - rest / y * v,
            a: u,
            b: -first / y * v,
        });
        return Ok(curves);
    }
    let square = -rest / first;
    if square.abs() <= near * near || rest.abs() <= near * quadric.gradient(center).length() {
        // Touching all along it.
        curves.push(Curve::Line {
            point: center,
            direction: v,
        });
        return Ok(curves);
    }
    if square > 0.0 {
        for offset in [square.sqrt(), -square.sqrt()] {
            curves.push(Curve::Line {
                point: center + offset * u,
                direction: v,
            });
        }
    }
    Ok(curves)
}

/// The curves on a cylinder or a cone.
fn on_rulings(
    carrier: &Surface,
    frame: &Frame,
    other: &Surface,
    near: f64,
) -> Result<Curves, Unknown> {
    let is_cone = frame.ruled == Ruled::Cone;
    let [center, mut a, mut b, mut axis] = frame.rulings();
    if is_cone {
        let length = axis.length();
        (a, b, axis) = (a / length, b / length, axis / length);
    } else {
        // The section's radius: the frame's units are those of the surface.
        let square = -carrier.value(center);
        let radius = square.abs().sqrt();
        (a, b) = (radius * a, radius * b);
        axis = axis.normalize_or_zero();
    }
    let (form, along) = (
        Form::of(other, center, a, b),
        other.gradient(center).dot(axis),
    );
    let second = 0.5 * other.curvature_along(axis);
    let mixed = [a, b].map(|d| 2.0 * polar(other, axis, d));
    // square s² + linear s + constant = 0.
    let (square, linear, constant) = if is_cone {
        let square = Trig::of_form(form.square, mixed, second);
        let linear = Trig {
            constant: along,
            once: form.linear,
            ..Trig::default()
        };
        let constant = Trig {
            constant: form.constant,
            ..Trig::default()
        };
        (square, linear, constant)
    } else {
        let square = Trig {
            constant: second,
            ..Trig::default()
        };
        let linear = Trig {
            constant: along,
            once: mixed,
            ..Trig::default()
        };
        (square, linear, form.around())
    };
    let slope = other
        .gradient(center)
        .length()
        .max(constant.magnitude().sqrt());
    if square.magnitude() <= NEGLIGIBLE {
        if linear.magnitude() > NEGLIGIBLE * slope {
            return Err(Unknown::NoForm);
        }
        // Parallel cylinders: lines.
        let mut roots = Roots::default();
        constant.roots(near * slope, &mut roots);
        let line = |t: &f64| Curve::Line {
            point: center + t.cos() * a + t.sin() * b,
            direction: axis,
        };
        // Where they touch, along one line.
        roots.simple.retain(|t| !roots.touching.contains(t));
        return Ok(roots
            .simple
            .iter()
            .chain(&roots.touching)
            .map(line)
            .collect());
    }
    if is_cone && form.constant.abs() <= near * slope {
        return Err(Unknown::NoForm);
    }
    let scale = linear.squared().magnitude() + 4.0 * square.magnitude() * constant.magnitude();
    let discriminant = if is_cone {
        linear.squared().plus(-4.0 * form.constant, &square)
    } else {
        linear.squared().plus(-4.0 * second, &constant)
    };
    let rulings = |part| Rulings {
        is_cone,
        center,
        a,
        b,
        axis,
        other: *other,
        part,
        between: None,
    };
    let mut parts: SmallVec<[Part; 2]> = SmallVec::new();
    let mut roots = Roots::default();
    if discriminant.magnitude() <= 1e-12 * scale {
        parts.push(Part::Touching);
    } else {
        discriminant.roots(1e-12 * scale, &mut roots);
        if let Some(&touching) = roots.touching.first() {
            let point = rulings(Part::Around { last: true }).at(touching - BEGIN);
            return match planes_through(carrier, other, point, near) {
                // Where other parts of the curve pass through it, or are beside.
                Err(Unknown::Touch) if discriminant.is_ever_positive() => Err(Unknown::NoForm),
                known => known,
            };
        }
        roots.simple.sort_by(f64::total_cmp);
        match roots.simple.as_slice() {
            [] if discriminant.constant < 0.0 => {}
            [] => parts.extend([false, true].map(|last| Part::Around { last })),
            // Rounding took one of a pair.
            angles if angles.len() % 2 == 1 => return Err(Unknown::NoForm),
            angles => {
                let is_between = discriminant.value(0.5 * (angles[0] + angles[1])) > 0.0;
                for k in (usize::from(!is_between)..angles.len()).step_by(2) {
                    let from = angles[k];
                    let to = *angles.get(k + 1).unwrap_or(&(angles[0] + TAU));
                    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
                    parts.push(Part::Between { middle, half });
                }
            }
        }
    }
    // The rulings that go to infinity without meeting the surface again.
    roots.clear();
    if is_cone {
        square.roots(1e-9 * square.magnitude(), &mut roots);
        if !roots.touching.is_empty() {
            return Err(Unknown::NoForm);
        }
    }
    let mut curves = Curves::new();
    for part in parts {
        let rulings = rulings(part);
        let mut poles: Vec<f64> = Vec::new();
        for &angle in &roots.simple {
            // There one of the two roots 1 / s is 0.
            let is_last = linear.value(angle) > 0.0;
            poles.extend(rulings.parameter(angle, is_last));
        }
        poles.sort_by(f64::total_cmp);
        let pieces = if let (Some(&first), Some(&last)) = (poles.first(), poles.last()) {
            let next = poles[1..].iter().copied().chain([first + TAU]);
            debug_assert!(last < first + TAU);
            poles.iter().copied().zip(next).map(Some).collect()
        } else {
            vec![None]
        };
        curves.extend(pieces.into_iter().map(|between| {
            Curve::Rulings(Box::new(Rulings {
                between,
                ..rulings.clone()
            }))
        }));
    }
    Ok(curves)
}

/// The conics of two quadrics that touch at a point, if some combination of them
/// is a pair of planes through it.
fn planes_through(a: &Surface, b: &Surface, at: DVec3, near: f64) -> Result<Curves, Unknown> {
    let [p, q] = [a, b].map(|s| s.gradient(at));
    let factor = p.dot(q) / q.length_squared();
    let mut both = *a;
    for (sum, value) in both.quadratic.iter_mut().zip(b.quadratic) {
        *sum -= factor * value;
    }
    let (values, axes) = eigen_symmetric(both.quadratic);
    let axes = [axes.x_axis, axes.y_axis, axes.z_axis];
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
    let [low, none, high] = order;
    let is_pair = values[low] < -1e-6
        && values[high] > 1e-6
        && values[none].abs() <= 1e-6 * (values[high] - values[low])
        && (p - factor * q).length() <= 1e-4 * p.length();
    if !is_pair {
        return Err(Unknown::Touch);
    }
    // Where both are 0 to second order: improve the point along the axes.
    let gradient = |d: DVec3| (a.gradient(at) - factor * b.gradient(at)).dot(d);
    let center = at
        - gradient(axes[low]) / (2.0 * values[low]) * axes[low]
        - gradient(axes[high]) / (2.0 * values[high]) * axes[high];
    let planes = [1.0, -1.0].map(|sign| {
        let normal = (-values[low]).sqrt() * axes[low] + sign * values[high].sqrt() * axes[high];
        Surface {
            anchor: center,
            quadratic: [0.0; 6],
            linear: normal.normalize_or_zero(),
            constant: 0.0,
        }
    });
    let mut curves = Curves::new();
    for k in 0..2 {
        for mut curve in conic(&planes[k], a, near)? {
            let Curve::Ellipse { node, .. } = &mut curve else {
                return Err(Unknown::NoForm);
            };
            *node = Some(planes[1 - k]);
            curves.push(curve);
        }
    }
    Ok(curves)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::net::solve;
    use crate::random::Random;

    /// A quadric of any kind about the origin, turned.
    fn quadric(random: &mut Random) -> Surface {
        let mut number = |low: f64, high: f64| low + (high - low) * random.unit();
        let turn = DMat3::from_euler(
            glam::EulerRot::XYZ,
            number(0.0, 6.0),
            number(0.0, 6.0),
            number(0.0, 6.0),
        );
        let (a, b, c) = (number(0.3, 1.0), number(0.3, 1.0), number(0.2, 1.0));
        let (values, slope, constant) = match number(0.0, 6.0) as u32 {
            0 => ([1.0, a, b], 0.0, -c),
            1 => ([1.0, a, 0.0], 0.0, -c),
            2 => ([1.0, a, -b], 0.0, 0.0),
            3 => ([1.0, a, -b], 0.0, -c),
            4 => ([1.0, a, -b], 0.0, c),
            _ => ([1.0, a, 0.0], b, 0.0),
        };
        let form = turn * DMat3::from_diagonal(values.into()) * turn.transpose();
        let entry = |i: usize, j: usize| form.col(j)[i];
        Surface {
            anchor: DVec3::new(number(-0.5, 0.5), number(-0.5, 0.5), number(-0.5, 0.5)),
            quadratic: [
                entry(0, 0),
                entry(1, 1),
                entry(2, 2),
                2.0 * entry(0, 1),
                2.0 * entry(1, 2),
                2.0 * entry(2, 0),
            ],
            linear: slope * turn.z_axis,
            constant,
        }
    }

    fn distance(curve: &Curve, point: DVec3) -> f64 {
        const SAMPLES: u32 = 400;
        let Some([start, end]) = curve.range(DVec3::ZERO, 3.0) else {
            return f64::INFINITY;
        };
        let step = (end - start) / f64::from(SAMPLES);
        let off = |t: f64| curve.at(t).distance(point);
        let nearest = (0..=SAMPLES)
            .map(|k| start + f64::from(k) * step)
            .min_by(|a, b| off(*a).total_cmp(&off(*b)))
            .unwrap_or(start);
        let (mut low, mut high) = (nearest - step, nearest + step);
        for _ in 0..60 {
            let (a, b) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
            if off(a) < off(b) {
                high = b;
            } else {
                low = a;
            }
        }
        off(0.5 * (low + high))
    }

    /// It cuts the saddle in two lines, for which there is no form yet: they must
    /// not be taken for a single point.
    #[test]
    fn a_plane_that_touches_a_saddle_is_not_passed_over() {
        let surface = |quadratic, linear, constant| Surface {
            anchor: DVec3::ZERO,
            quadratic,
            linear,
            constant,
        };
        let saddle = surface([1.0, 1.0, -1.0, 0.0, 0.0, 0.0], DVec3::ZERO, -1.0);
        let frame = Frame::of(&saddle);
        let saddle = Framed {
            surface: &saddle,
            frame: frame.as_ref(),
        };
        for (x, wanted) in [(1.0, None), (0.5, Some(2)), (1.5, Some(2))] {
            let plane = Surface {
                anchor: x * DVec3::X,
                ..surface([0.0; 6], DVec3::X, 0.0)
            };
            let plane = Framed {
                surface: &plane,
                frame: None,
            };
            let found = curves(plane, saddle, 1e-9);
            assert_eq!(found.as_ref().map(Curves::len).ok(), wanted, "{x}");
            if wanted.is_none() {
                assert!(matches!(found, Err(Unknown::NoForm)), "{x}");
            }
        }
    }

    #[test]
    fn curves_are_all_that_two_surfaces_have_in_common() {
        const NEAR: f64 = 1e-9;
        let mut random = Random(7);
        let (mut known, mut points) = (0, 0);
        for case in 0..400 {
            let surfaces = [quadric(&mut random), quadric(&mut random)];
            let frames = surfaces.map(|s| Frame::of(&s));
            let [a, b] = [0, 1].map(|k| Framed {
                surface: &surfaces[k],
                frame: frames[k].as_ref(),
            });
            let Ok(curves) = curves(a, b, NEAR) else {
                continue;
            };
            known += 1;
            for curve in &curves {
                let Some([start, end]) = curve.range(DVec3::ZERO, 3.0) else {
                    continue;
                };
                for k in 0..50 {
                    let at = curve.at(start + f64::from(k) / 50.0 * (end - start));
                    let off = solve::residual(surfaces.iter(), at);
                    assert!(
                        off < 1e-7 * (1.0 + at.length()),
                        "case {case}: {off} {curve:?}"
                    );
                }
            }
            for _ in 0..20 {
                let start = DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
                let found = solve::common_point(&[&surfaces[0], &surfaces[1]], start, 0.5);
                if found.residual > 1e-13 || found.point.length() > 2.0 {
                    continue;
                }
                points += 1;
                let off = curves.iter().map(|c| distance(c, found.point));
                let off = off.fold(f64::INFINITY, f64::min);
                assert!(
                    off < 1e-5,
                    "case {case}: {off} of {} {surfaces:?}",
                    curves.len()
                );
            }
        }
        assert!(known > 300 && points > 2000, "{known} {points}");
    }
}
