//! The surfaces of faces that were cut at seams.
//!
//! Poles and seams of the file's surfaces are put where the face is cut, or where it is not:
//! opposite of the direction from which it is seen.

use std::f64::consts::TAU;

use csg::brep::Face;
use csg::elementary;
use csg::{Placement, SurfaceShape};
use glam::DVec3;

use super::chart::{Chart, Frame, Profile, Written};
use super::patches::{paraboloid, revolved, stereographic};
use super::scaled::Scaled;
use super::text::{Entities, Id, Real};

/// Writes the surface of a face; none if there is no way to.
pub(super) fn write(to: &mut Entities, face: &Face<'_>) -> Option<Written> {
    let view = face.view();
    Some(match face.surface().shape() {
        SurfaceShape::Plane { point, .. } => {
            let normal = face.normal(point);
            let placement = to.placement(point, [normal, normal.any_orthonormal_vector()]);
            Written {
                surface: to.share(format_args!("PLANE('',{placement})")),
                is_outward: true,
                chart: None,
            }
        }
        SurfaceShape::Sphere { center, radius } => {
            let meridian = face.meridian();
            let axes = meridian.unwrap_or_else(|| [view.any_orthonormal_vector(), -view]);
            let mut written = sphere(to, face, (center, radius), axes);
            if meridian.is_none() {
                let frame = Frame::new(center, axes);
                written.chart = Some(Chart::Sphere { frame, radius });
            }
            written
        }
        SurfaceShape::Cylinder {
            point,
            axis,
            radius,
        } => {
            let axes = [axis, seam(face, point, axis)];
            let placement = to.placement(point, axes);
            let length = Real(radius);
            Written {
                surface: to.share(format_args!("CYLINDRICAL_SURFACE('',{placement},{length})")),
                is_outward: is_away(face, |p| (p - point).reject_from(axis)),
                chart: Some(Chart::Turned {
                    frame: Frame::new(point, axes),
                    radius,
                    slope: 0.0,
                }),
            }
        }
        SurfaceShape::Cone {
            point,
            mut axis,
            mut radius,
            slope,
        } => {
            // Of both halves the one on which the face is has the positive radius.
            let middle = 0.5
                * face
                    .points()
                    .iter()
                    .map(|p| radius + slope * (*p - point).dot(axis))
                    .sum::<f64>();
            if middle < 0.0 {
                (axis, radius) = (-axis, -radius);
            }
            let mut origin = point;
            if radius < 0.0 {
                origin -= 2.0 * radius / slope * axis;
                radius = -radius;
            }
            let axes = [axis, seam(face, point, axis)];
            let placement = to.placement(origin, axes);
            let (length, angle) = (Real(radius), Real(elementary::atan(slope)));
            Written {
                surface: to.share(format_args!(
                    "CONICAL_SURFACE('',{placement},{length},{angle})"
                )),
                is_outward: is_away(face, |p| (p - point).reject_from(axis)),
                chart: Some(Chart::Turned {
                    frame: Frame::new(origin, axes),
                    radius,
                    slope,
                }),
            }
        }
        SurfaceShape::Ellipsoid { placement, radii } => stereographic(
            to,
            face,
            Scaled {
                placement,
                scales: radii,
            },
        ),
        SurfaceShape::EllipticParaboloid { placement, bends } if is_round(bends) => {
            paraboloid_of_revolution(to, &[*face], (&placement, bends), None)
        }
        SurfaceShape::EllipticParaboloid { placement, bends } => {
            let scaled = Scaled {
                placement,
                scales: [1.0; 3],
            };
            paraboloid(to, face, scaled, bends)
        }
        SurfaceShape::HyperbolicParaboloid {
            placement,
            bends: [a, b],
        } => {
            let scaled = Scaled {
                placement,
                scales: [1.0; 3],
            };
            paraboloid(to, face, scaled, [a, -b])
        }
        SurfaceShape::EllipticCylinder { placement, radii } => {
            extruded(to, face, &placement, radii)
        }
        SurfaceShape::ParabolicCylinder { placement, bend } => {
            let scaled = Scaled {
                placement,
                scales: [1.0; 3],
            };
            if !is_around_vertex(scaled.range(face, |p| p.x), bend) {
                return Some(paraboloid(to, face, scaled, [bend, 0.0]));
            }
            let Placement { origin, axes, .. } = placement;
            let [across, _, up] = axes;
            let axis = up.cross(across);
            let focus = Real(0.25 / bend);
            let placement = to.placement(origin, [axis, up]);
            let parabola = to.share(format_args!("PARABOLA('',{placement},{focus})"));
            // (Open CASCADE counts along parabolas by another measure than the standard.)
            linear_extrusion(to, face, (parabola, axis), |_| up)
        }
        SurfaceShape::HyperbolicCylinder {
            placement,
            radii: [a, b],
        } => {
            let Placement { origin, axes, .. } = placement;
            let [x, _, axis] = axes;
            // The branch that the face is on.
            let ahead = face.points().into_iter().map(|p| (p - origin).dot(x));
            let x = ahead.sum::<f64>().signum() * x;
            let placement = to.placement(origin, [axis, x]);
            let lengths = [a, b].map(Real);
            let branch = to.share(format_args!(
                "HYPERBOLA('',{placement},{},{})",
                lengths[0], lengths[1]
            ));
            let written = linear_extrusion(to, face, (branch, axis), |_| x);
            Written {
                chart: Some(Chart::Branch {
                    frame: Frame::new(origin, [axis, x]),
                    radii: [a, b],
                }),
                ..written
            }
        }
        SurfaceShape::EllipticCone {
            placement,
            slopes: [a, b],
        } => {
            let scaled = Scaled {
                placement,
                scales: [a, b, 1.0],
            };
            let [low, high] = scaled.range(face, |p| p.z);
            // One half of it, from the apex at most.
            let [near, far] = if high > -low {
                [low.max(0.0), high]
            } else {
                [high.min(0.0), low]
            };
            let net = [near, far].map(|z| [z.abs(), z, 1.0]);
            revolved(to, face, scaled, (&net, Profile::Line([near, far])))
        }
        SurfaceShape::HyperboloidOneSheet {
            placement,
            radii: [a, b, c],
        } if is_round([a, b]) => {
            let turned = Turned::new(face, &placement, 1.0);
            let placement = to.placement(placement.origin, turned.across_and(turned.x));
            let [a, c] = [0.5 * (a + b), c].map(Real);
            let branch = to.add(format_args!("HYPERBOLA('',{placement},{a},{c})"));
            turned.whole(to, face, branch)
        }
        SurfaceShape::HyperboloidOneSheet { placement, radii } => {
            let scaled = Scaled {
                placement,
                scales: radii,
            };
            let [low, high] = scaled.range(face, |p| elementary::asinh(p.z));
            let [half, middle] = [0.5 * (high - low), 0.5 * (low + high)];
            let net = [
                [elementary::cosh(low), elementary::sinh(low), 1.0],
                [
                    elementary::cosh(middle),
                    elementary::sinh(middle),
                    elementary::cosh(half),
                ],
                [elementary::cosh(high), elementary::sinh(high), 1.0],
            ];
            revolved(to, face, scaled, (&net, Profile::Beside([low, high])))
        }
        SurfaceShape::HyperboloidTwoSheets { placement, radii }
            if is_round([radii[0], radii[1]]) =>
        {
            hyperboloid_of_revolution(to, &[*face], (&placement, radii), None)
        }
        SurfaceShape::HyperboloidTwoSheets { placement, radii } => {
            let scaled = Scaled {
                placement,
                scales: radii,
            };
            let sign = scaled.range(face, |p| p.z).iter().sum::<f64>().signum();
            let [_, high] = scaled.range(face, |p| elementary::acosh(p.z.abs().max(1.0)));
            let net = [
                [0.0, sign, 1.0],
                [
                    elementary::sinh(0.5 * high),
                    sign * elementary::cosh(0.5 * high),
                    elementary::cosh(0.5 * high),
                ],
                [elementary::sinh(high), sign * elementary::cosh(high), 1.0],
            ];
            revolved(to, face, scaled, (&net, Profile::Across([0.0, high])))
        }
        _ => return None,
    })
}

/// Writes the sphere of faces around an axis.
pub(super) fn write_zone(to: &mut Entities, face: &Face<'_>, axis: DVec3) -> Option<Written> {
    let SurfaceShape::Sphere { center, radius } = face.surface().shape() else {
        return None;
    };
    let axes = [axis, axis.any_orthonormal_vector()];
    Some(sphere(to, face, (center, radius), axes))
}

/// A sphere by the directions of a pole and of the meridian where longitudes begin.
fn sphere(
    to: &mut Entities,
    face: &Face<'_>,
    (center, radius): (DVec3, f64),
    axes: [DVec3; 2],
) -> Written {
    let placement = to.placement(center, axes);
    let radius = Real(radius);
    Written {
        surface: to.share(format_args!("SPHERICAL_SURFACE('',{placement},{radius})")),
        is_outward: is_away(face, |p| p - center),
        chart: None,
    }
}

/// Writes the surface of faces that have the pole of a paraboloid or a hyperboloid of two sheets, of
/// revolution, between them: cut at the meridian in a direction across the axis.
pub(super) fn write_cap(to: &mut Entities, faces: &[Face<'_>], meridian: DVec3) -> Option<Written> {
    match faces.first()?.surface().shape() {
        SurfaceShape::EllipticParaboloid { placement, bends } => Some(paraboloid_of_revolution(
            to,
            faces,
            (&placement, bends),
            Some(meridian),
        )),
        SurfaceShape::HyperboloidTwoSheets { placement, radii } => Some(hyperboloid_of_revolution(
            to,
            faces,
            (&placement, radii),
            Some(meridian),
        )),
        _ => None,
    }
}

/// A parabola turned around its axis, beginning in a direction across it or else opposite of the face.
fn paraboloid_of_revolution(
    to: &mut Entities,
    faces: &[Face<'_>],
    (placement, bends): (&Placement, [f64; 2]),
    meridian: Option<DVec3>,
) -> Written {
    let scaled = Scaled {
        placement: *placement,
        scales: [1.0; 3],
    };
    let turned = Turned::new(&faces[0], placement, 1.0).begun(meridian);
    let focus = Real(0.25 / bends[0]);
    let placement = to.placement(placement.origin, turned.across_and(turned.axis));
    let parabola = to.add(format_args!("PARABOLA('',{placement},{focus})"));
    let farthest = scaled.farthest(faces, |p| elementary::hypot(p.x, p.y));
    let ends = [0.0, bends[0] * farthest * farthest];
    turned.half(to, &faces[0], parabola, (farthest, ends))
}

/// The same of one branch of a hyperbola.
fn hyperboloid_of_revolution(
    to: &mut Entities,
    faces: &[Face<'_>],
    (placement, [a, b, c]): (&Placement, [f64; 3]),
    meridian: Option<DVec3>,
) -> Written {
    let scaled = Scaled {
        placement: *placement,
        scales: [a, b, c],
    };
    let sign = scaled
        .range(&faces[0], |p| p.z)
        .iter()
        .sum::<f64>()
        .signum();
    let high = scaled.farthest(faces, |p| elementary::acosh(p.z.abs().max(1.0)));
    let turned = Turned::new(&faces[0], placement, sign).begun(meridian);
    let placement = to.placement(placement.origin, turned.across_and(turned.axis));
    let (long, across) = (Real(c), Real(0.5 * (a + b)));
    let branch = to.add(format_args!("HYPERBOLA('',{placement},{long},{across})"));
    let ends = [1.0, elementary::cosh(high)].map(|height| c * height);
    turned.half(to, &faces[0], branch, (a * elementary::sinh(high), ends))
}

/// Whether a piece of the parabola y = bend x² between two places is around its vertex, and not much
/// longer than wide. Others are told by control points, as readers lose digits along them: of an extruded
/// parabola that begins a third of its length beside the vertex Open CASCADE is off by 1e-4, and at
/// one of a letter 10 high, narrow and around its vertex, edges close with a tolerance of 0.24.
pub(super) fn is_around_vertex([from, to]: [f64; 2], bend: f64) -> bool {
    /// Decree: at the ends, of heights to distances across.
    const STEEPEST: f64 = 2.0;
    from * to < 0.0 && 2.0 * bend * from.abs().max(to.abs()) <= STEEPEST
}

/// Whether both scales of a section across an axis are one, to rounding.
pub(super) fn is_round([a, b]: [f64; 2]) -> bool {
    (a - b).abs() <= ROUND * a.abs()
}

/// Two scales that differ by no more, of the larger, are one.
const ROUND: f64 = 1e-14;

/// A meridian turned around an axis: the file's curve lies opposite of the face.
struct Turned {
    origin: DVec3,
    axis: DVec3,
    /// The direction across the axis in which the meridian lies.
    x: DVec3,
}

impl Turned {
    /// Around the last axis of a placement or, for a negative sign, against it.
    fn new(face: &Face<'_>, placement: &Placement, sign: f64) -> Self {
        let axis = sign * placement.axes[2];
        let ahead = face.points().into_iter().map(|p| p - placement.origin);
        Self {
            origin: placement.origin,
            axis,
            x: -across(ahead.sum(), axis),
        }
    }

    /// The same, with the meridian in another direction, if there is one.
    fn begun(self, x: Option<DVec3>) -> Self {
        Self {
            x: x.unwrap_or(self.x),
            ..self
        }
    }

    /// Directions of z and x for a curve in the plane of the meridian that is symmetric about
    /// one: y is the other one.
    fn across_and(&self, symmetry: DVec3) -> [DVec3; 2] {
        let other = if symmetry == self.x {
            self.axis
        } else {
            self.x
        };
        [symmetry.cross(other), symmetry]
    }

    /// The surface of a curve that stays on one side of the axis.
    fn whole(&self, to: &mut Entities, face: &Face<'_>, curve: Id) -> Written {
        let (origin, axis) = (to.point(self.origin), to.direction(self.axis));
        let axis = to.share(format_args!("AXIS1_PLACEMENT('',{origin},{axis})"));
        Written {
            surface: to.add(format_args!("SURFACE_OF_REVOLUTION('',{curve},{axis})")),
            is_outward: is_away(face, |p| (p - self.origin).reject_from(self.axis)),
            chart: None,
        }
    }

    /// The surface of a curve that begins on the axis: as far as a radius, and from which height
    /// to which.
    fn half(
        &self,
        to: &mut Entities,
        face: &Face<'_>,
        curve: Id,
        (radius, [low, high]): (f64, [f64; 2]),
    ) -> Written {
        let from = to.point(self.origin + low * self.axis);
        let until = to.point(self.origin + high * self.axis + radius * self.x);
        let half = to.add(format_args!(
            "TRIMMED_CURVE('',{curve},({from}),({until}),.T.,.CARTESIAN.)"
        ));
        self.whole(to, face, half)
    }
}

/// An ellipse along its axis.
fn extruded(to: &mut Entities, face: &Face<'_>, placement: &Placement, radii: [f64; 2]) -> Written {
    let Placement { origin, axes, .. } = *placement;
    let [x, _, axis] = axes;
    let (mut long, [most, least]) = if radii[0] < radii[1] {
        (axes[1], [radii[1], radii[0]])
    } else {
        (x, radii)
    };
    // The ellipse begins at the end of its long axis where the face is not: a face is a quarter
    // around the end of one axis.
    if face.view().dot(long) > 0.0 {
        long = -long;
    }
    let frame = Frame::new(origin, [axis, long]);
    let placement = to.placement(origin, [axis, long]);
    let lengths = [most, least].map(Real);
    let ellipse = to.share(format_args!(
        "ELLIPSE('',{placement},{},{})",
        lengths[0], lengths[1]
    ));
    let written = linear_extrusion(to, face, (ellipse, axis), |p| {
        (p - origin).reject_from(axis)
    });
    Written {
        chart: Some(Chart::Extruded {
            frame,
            radii: [most, least],
        }),
        ..written
    }
}

/// A curve along a direction. On its right, seen against that, are the vectors at points.
fn linear_extrusion(
    to: &mut Entities,
    face: &Face<'_>,
    (curve, direction): (Id, DVec3),
    right: impl Fn(DVec3) -> DVec3,
) -> Written {
    let direction = to.direction(direction);
    let vector = to.share(format_args!("VECTOR('',{direction},1.)"));
    Written {
        surface: to.share(format_args!(
            "SURFACE_OF_LINEAR_EXTRUSION('',{curve},{vector})"
        )),
        is_outward: is_away(face, right),
        chart: None,
    }
}

/// The part of a direction across an axis, of unit length.
fn across(direction: DVec3, axis: DVec3) -> DVec3 {
    let across = direction.reject_from(axis);
    across
        .try_normalize()
        .unwrap_or_else(|| axis.any_orthonormal_vector())
}

/// In which direction across its axis the seam of a cylinder or cone lies: where the face is cut,
/// if it is on both sides of an edge, or else in the middle of the widest angle in which it
/// is not.
fn seam(face: &Face<'_>, point: DVec3, axis: DVec3) -> DVec3 {
    const SAMPLES: u32 = 16;
    let (x, y) = {
        let x = axis.any_orthonormal_vector();
        (x, axis.cross(x))
    };
    let mut angles: Vec<f64> = Vec::new();
    for edge in face.edges() {
        let [from, to] = edge.range();
        let at = |share: f64| (edge.at(from + share * (to - from)) - point).reject_from(axis);
        let [one, other] = edge.faces();
        if one == other {
            // (The end may be an apex, which is in no direction.)
            let farthest = [0.0, 0.5, 1.0].map(at);
            let farthest = farthest
                .into_iter()
                .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
            return farthest.unwrap_or(x).normalize_or(x);
        }
        let samples = (0..=SAMPLES).map(|k| at(f64::from(k) / f64::from(SAMPLES)));
        angles.extend(samples.map(|off| elementary::atan2(off.dot(y), off.dot(x))));
    }
    angles.sort_by(f64::total_cmp);
    let first = angles.first().map(|first| first + TAU);
    let next = angles.iter().copied().skip(1).chain(first);
    let gaps = angles
        .iter()
        .zip(next)
        .map(|(from, to)| (to - from, 0.5 * (from + to)));
    let widest = gaps.max_by(|a, b| a.0.total_cmp(&b.0));
    let (sin, cos) = elementary::sin_cos(widest.map_or(0.0, |(_, middle)| middle));
    cos * x + sin * y
}

/// Whether a vector leads out of the solid, where it is not 0, at points of a face.
fn is_away(face: &Face<'_>, vector: impl Fn(DVec3) -> DVec3) -> bool {
    let points = face.points().into_iter();
    let along = points.map(|point| vector(point).dot(face.normal(point)));
    along.sum::<f64>() > 0.0
}
