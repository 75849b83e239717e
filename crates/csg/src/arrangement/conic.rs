//! The conics in which planes cut quadrics.

use crate::elementary;
use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use super::curve::{Branch, Branches, Curve, Form, polar};
use super::intersection::{Nearness, Unknown};
use super::trig::BEGIN;
use crate::numeric::tolerance::{CANCELLED, NO_VALUE};
use crate::program::Surface;
use crate::surface::is_far;

/// The curves in which a plane cuts a quadric, where they are known.
pub(crate) fn conics(plane: &Surface, quadric: &Surface, near: f64) -> SmallVec<[Curve; 2]> {
    let branches = conic(plane, quadric, Nearness::of(near)).unwrap_or_default();
    branches.into_iter().map(|branch| branch.curve).collect()
}

/// What is farther from the origin than so many sizes of the scene is far away.
pub(super) const FAR: f64 = 100.0;

/// The conic in which a quadric is 0 that changes from `foot` by value d² + slope d
/// along each of two axes, more along the first, by its vertex: if the centre is so
/// far from a scene of that size around the origin that digits would be lost, and
/// the vertex is not.
fn near_parabola(
    quadric: &Surface,
    foot: DVec3,
    [(first, u, x), (second, v, slope)]: [(f64, DVec3, f64); 2],
    scene: f64,
) -> Option<Curve> {
    if slope.abs() < 2.0 * second.abs() * FAR * scene {
        return None;
    }
    let on_axis = foot - x / (2.0 * first) * u;
    let rest = quadric.value(on_axis);
    let discriminant = slope * slope - 4.0 * second * rest;
    if discriminant <= 0.0 {
        return None;
    }
    let at_vertex = discriminant.sqrt().copysign(slope);
    let vertex = on_axis - 2.0 * rest / (slope + at_vertex) * v;
    let k = first * second / (at_vertex * at_vertex);
    let b = -first / at_vertex * v;
    let reach = vertex.length() + scene;
    let most = reach.min((2.0 * reach / b.length()).sqrt());
    // There a half of the conic goes on and on.
    (16.0 * k.abs() * most * most <= 1.0).then_some(Curve::Parabola {
        point: vertex,
        a: u,
        b,
        l: 0.0,
        k,
    })
}

/// The two parts, all that is near a scene of that size around the origin, of the
/// conic in which a quadric is 0 that changes from `foot` by value d² + slope d along
/// each of two axes, more along the first: if they run along the second axis, nearly
/// straight, and meet, if at all, so far away that seen from there digits would be
/// lost.
fn near_lines(
    quadric: &Surface,
    foot: DVec3,
    [(first, u, x), (second, v, _)]: [(f64, DVec3, f64); 2],
    scene: f64,
) -> Option<SmallVec<[Curve; 2]>> {
    let on_axis = foot - x / (2.0 * first) * u;
    let middle = on_axis - on_axis.dot(v) * v;
    let rest = quadric.value(middle);
    let slope = quadric.gradient(middle).dot(v);
    let far = FAR * scene;
    if (second.abs() * far + slope.abs()) * far > 0.5 * rest.abs() {
        return None;
    }
    let off = (-rest / first).sqrt();
    if off.is_nan() {
        return Some(SmallVec::new());
    }
    let part = |off: f64| part_about(quadric, middle + off * u, [u, v], scene);
    [off, -off].into_iter().map(part).collect()
}

/// The part about one of its points, all that is near a scene of that size around the origin, of the
/// conic in which a quadric is 0 in the plane of two directions: if it hardly bends there.
fn part_about(quadric: &Surface, point: DVec3, [u, v]: [DVec3; 2], scene: f64) -> Option<Curve> {
    // In the plane: across the conic, and along it.
    let gradient = quadric.gradient(point);
    let across = gradient.dot(u) * u + gradient.dot(v) * v;
    let steep = across.length();
    let across = across / steep;
    let along = across.dot(u) * v - across.dot(v) * u;
    // bend d² + mixed d e + other e² + steep e = 0, d along and e across.
    let [bend, other] = [along, across].map(|d| 0.5 * quadric.curvature_along(d));
    let mixed = 2.0 * polar(quadric, along, across);
    let (l, k) = (-mixed / steep, bend * other / (steep * steep));
    let most = point.length() + scene;
    // There a half of the conic goes on and on.
    (16.0 * (l.abs() + k.abs() * most) * most <= 1.0).then(|| Curve::Parabola {
        point,
        a: along,
        b: -bend / steep * across,
        l,
        k,
    })
}

/// The half of a parabola that is near a scene of that size around the origin, in the plane of two
/// directions through a point on its axis, if that passes by far from there: seen from the vertex
/// digits would be lost.
fn half_parabola(
    quadric: &Surface,
    on_axis: DVec3,
    [u, v]: [DVec3; 2],
    scene: f64,
) -> Option<Curve> {
    const STEPS: u32 = 8;
    let axis_off = on_axis.dot(u).abs();
    if !is_far(axis_off, scene) {
        return None;
    }
    // From the foot of the origin to the curve, which is nearly straight there.
    let mut point = on_axis - on_axis.dot(u) * u - on_axis.dot(v) * v;
    for _ in 0..STEPS {
        let gradient = quadric.gradient(point);
        let across = gradient.dot(u) * u + gradient.dot(v) * v;
        point -= quadric.value(point) / across.length_squared() * across;
    }
    if point.length() > 2.0 * scene {
        return None;
    }
    part_about(quadric, point, [u, v], scene)
}

/// The line in which a plane of that normal cuts a quadric that is linear in it, by a point of the plane
/// and the gradient there along the plane: so are those along the axis of a hyperbolic paraboloid and
/// one of the lines on it.
fn straight(
    quadric: &Surface,
    foot: DVec3,
    (normal, gradient): (DVec3, DVec3),
) -> Result<Branches, Unknown> {
    let steep = gradient.length();
    if steep <= CANCELLED * quadric.gradient(foot).length() {
        return Err(Unknown::NoForm);
    }
    let across = gradient / steep;
    Ok(smallvec![Branch::new(Curve::Line {
        point: foot - quadric.value(foot) / steep * across,
        direction: normal.cross(across),
    })])
}

/// The conic in which a plane cuts a quadric.
pub(super) fn conic(
    plane: &Surface,
    quadric: &Surface,
    nearness: Nearness,
) -> Result<Branches, Unknown> {
    let Nearness { near, touch } = nearness;
    let foot = quadric.anchor - plane.value(quadric.anchor) * plane.linear;
    let (u, v) = plane.linear.any_orthonormal_pair();
    let Form {
        square: [xx, yy, xy],
        linear: [x, y],
        ..
    } = Form::of(quadric, foot, u, v);
    // Principal axes.
    let (sin, cos) = elementary::sin_cos(0.5 * elementary::atan2(xy, xx - yy));
    let (u, v) = (cos * u + sin * v, cos * v - sin * u);
    let [mut first, mut second] = [u, v].map(|d| 0.5 * quadric.curvature_along(d));
    let (x, y) = (cos * x + sin * y, cos * y - sin * x);
    // By their own terms, as those of flat cones are far below the largest coefficient; to a share of
    // that coefficients are known.
    for (value, direction) in [(&mut first, u), (&mut second, v)] {
        if value.abs() <= (CANCELLED * quadric.terms_along(direction)).max(NO_VALUE) {
            *value = 0.0;
        }
    }
    let mut axes = [(first, u, x), (second, v, y)];
    if first == 0.0 {
        axes.swap(0, 1);
    }
    let [(first, u, x), (second, v, y)] = axes;
    if first == 0.0 {
        return straight(quadric, foot, (plane.linear, x * u + y * v));
    }
    let mut branches = Branches::new();
    let mut center = foot - x / (2.0 * first) * u;
    let axes = if first.abs() >= second.abs() {
        [(first, u, x), (second, v, y)]
    } else {
        [(second, v, y), (first, u, x)]
    };
    let scene = nearness.scene();
    // How steep the quadric is on the axis: at a cone's apex not at all.
    let steepest = [0.0, scene].map(|off| quadric.gradient(center + off * v).length());
    let is_ruled = second == 0.0 && y.abs() <= CANCELLED * steepest[0].max(steepest[1]);
    if !is_ruled && let Some(parts) = near_lines(quadric, foot, axes, scene) {
        return Ok(parts.into_iter().map(Branch::new).collect());
    }
    if second != 0.0 {
        if let Some(curve) = near_parabola(quadric, foot, axes, scene) {
            branches.push(Branch::new(curve));
            return Ok(branches);
        }
        center -= y / (2.0 * second) * v;
        let rest = quadric.value(center);
        // Of the points in the plane where the gradient points into it, the
        // centre is nearest to the surface.
        let of_contact = touch * quadric.gradient(center).length().max(touch);
        let touches = rest.abs() <= of_contact.max(quadric.rounding_of_value(center));
        let radius = |value: f64| (rest / value).abs().sqrt();
        let (a, b) = (radius(first) * u, radius(second) * v);
        if (first > 0.0) == (second > 0.0) {
            if touches {
                // At the apex of a cone there is no curve, but no contact either.
                let is_apex = |apex: DVec3| apex.distance(center) <= near;
                return if quadric.apex().is_some_and(is_apex) {
                    Ok(branches)
                } else {
                    Err(Unknown::Touch(smallvec![center]))
                };
            }
            if (rest > 0.0) != (first > 0.0) {
                let (sin, cos) = elementary::sin_cos(BEGIN);
                branches.push(Branch::new(Curve::Ellipse {
                    center,
                    a: cos * a + sin * b,
                    b: cos * b - sin * a,
                }));
            }
            return Ok(branches);
        }
        if touches {
            // Two lines that cross: in the apex of a cone, or where the plane touches
            // a saddle.
            for sign in [1.0, -1.0] {
                let direction = second.abs().sqrt() * u + sign * first.abs().sqrt() * v;
                branches.push(Branch {
                    curve: Curve::Line {
                        point: center,
                        direction: direction.normalize_or_zero(),
                    },
                    nodes: smallvec![0.0],
                });
            }
            return Ok(branches);
        }
        let (a, b) = if (rest > 0.0) == (first > 0.0) {
            (b, a)
        } else {
            (a, b)
        };
        branches.push(Branch::new(Curve::Hyperbola { center, a, b }));
        branches.push(Branch::new(Curve::Hyperbola {
            center,
            a: -a,
            b: -b,
        }));
        return Ok(branches);
    }
    let rest = quadric.value(center);
    if !is_ruled {
        if let Some(half) = half_parabola(quadric, center, [u, v], scene) {
            branches.push(Branch::new(half));
            return Ok(branches);
        }
        // first x² + y y + rest = 0.
        branches.push(Branch::new(Curve::Parabola {
            point: center - rest / y * v,
            a: u,
            b: -first / y * v,
            l: 0.0,
            k: 0.0,
        }));
        return Ok(branches);
    }
    let square = -rest / first;
    if square.abs() <= touch * touch || rest.abs() <= touch * quadric.gradient(center).length() {
        // Touching all along it.
        branches.push(Branch::new(Curve::Line {
            point: center,
            direction: v,
        }));
        return Ok(branches);
    }
    if square > 0.0 {
        // From the foot to the line that is farther off, and from the product of both to the nearer
        // one: where the plane is nearly along the axis of a parabola the middle is far away.
        let to_center = -x / (2.0 * first);
        let farther = to_center + square.sqrt().copysign(to_center);
        let nearer = quadric.value(foot) / (first * farther);
        for offset in [farther, nearer] {
            let point = foot + offset * u;
            let gradient = quadric.gradient(point);
            let across = gradient - gradient.dot(plane.linear) * plane.linear;
            let along = plane.linear.cross(across).normalize_or(v);
            branches.push(Branch::new(Curve::Line {
                point,
                direction: if along.dot(v) < 0.0 { -along } else { along },
            }));
        }
    }
    Ok(branches)
}
