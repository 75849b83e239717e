//! The parameters of surfaces as they are written: where a point has which, and which have what point.

use std::f64::consts::TAU;

use csg::elementary;
use glam::{DVec2, DVec3, DVec4};

use super::scaled::Scaled;
use super::text::Id;

/// A surface, and whether its normal points out of the solid.
pub(super) struct Written {
    pub surface: Id,
    pub is_outward: bool,
    /// Its parameters, where images of edges are written on it.
    pub chart: Option<Chart>,
}

/// Places on a surface in the file, by its two parameters.
#[derive(Clone, Debug)]
pub(super) enum Chart {
    /// Longitude and latitude.
    Sphere { frame: Frame, radius: f64 },
    /// The angle around the axis and the height along it, at which the radius grows by a slope.
    Turned {
        frame: Frame,
        radius: f64,
        slope: f64,
    },
    /// The angle of an ellipse and the height along its axis.
    Extruded { frame: Frame, radii: [f64; 2] },
    /// The hyperbolic angle of a branch around x and the height along its axis.
    Branch { frame: Frame, radii: [f64; 2] },
    /// A rational polynomial, whose parameters go from 0 to 1.
    Bezier(Box<Bezier>),
}

/// Coordinates by an origin and axes of unit length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub origin: DVec3,
    pub axes: [DVec3; 3],
}

impl Frame {
    /// By the directions of z and x, as placements have them.
    pub fn new(origin: DVec3, [z, x]: [DVec3; 2]) -> Self {
        Self {
            origin,
            axes: [x, z.cross(x), z],
        }
    }

    fn coordinates(&self, point: DVec3) -> DVec3 {
        let off = point - self.origin;
        self.axes.map(|axis| off.dot(axis)).into()
    }

    fn point(&self, at: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        self.origin + at.x * x + at.y * y + at.z * z
    }
}

#[derive(Clone, Debug)]
pub(super) struct Bezier {
    pub scaled: Scaled,
    /// Points times weights, and weights.
    pub net: Vec<Vec<DVec4>>,
    pub parameters: Parameters,
}

/// How a rational polynomial's parameters follow from coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) enum Parameters {
    /// x and y as a unit sphere is seen from the point opposite of a direction, from where to where.
    Stereographic {
        view: DVec3,
        axes: [DVec3; 2],
        x: [f64; 2],
        y: [f64; 2],
    },
    /// x and y themselves.
    Plain { x: [f64; 2], y: [f64; 2] },
    /// The angle around z, and where on the profile.
    Revolved { angles: [f64; 2], profile: Profile },
}

/// A line or a branch of a hyperbola beside the axis, from one end to the other.
#[derive(Clone, Copy, Debug)]
pub(super) enum Profile {
    /// By z.
    Line([f64; 2]),
    /// sinh is z.
    Beside([f64; 2]),
    /// sinh is the distance from the axis.
    Across([f64; 2]),
}

/// x and y as a unit sphere is seen from the point opposite of a direction.
pub(super) fn stereographic(p: DVec3, view: DVec3, axes: [DVec3; 2]) -> DVec2 {
    DVec2::from(axes.map(|axis| p.dot(axis))) / (1.0 + p.dot(view))
}

/// Where between two values one lies, from 0 to 1.
fn share([from, to]: [f64; 2], value: f64) -> f64 {
    (value - from) / (to - from)
}

/// Where on a rational arc of degree two a direction is, by the tangents of half its angle from the
/// middle and of half that of an end: they grow evenly, as the arc is seen from the point opposite of
/// its middle.
fn arc_share(tangent: f64, half_tangent: f64) -> f64 {
    0.5 + 0.5 * tangent / half_tangent
}

impl Parameters {
    fn of(&self, p: DVec3) -> DVec2 {
        match *self {
            Self::Stereographic { view, axes, x, y } => {
                let flat = stereographic(p, view, axes);
                DVec2::new(share(x, flat.x), share(y, flat.y))
            }
            Self::Plain { x, y } => DVec2::new(share(x, p.x), share(y, p.y)),
            Self::Revolved { angles, profile } => {
                let [from, to] = angles;
                let ahead = elementary::direction(0.5 * (from + to));
                let (cos, sin) = (ahead.dot(p.truncate()), ahead.perp_dot(p.truncate()));
                let turn = elementary::atan2(sin, cos);
                let tangents = [turn, 0.5 * (to - from)].map(|angle| elementary::tan(0.5 * angle));
                DVec2::new(arc_share(tangents[0], tangents[1]), profile.share(p))
            }
        }
    }
}

impl Profile {
    fn share(self, p: DVec3) -> f64 {
        let (ends, value) = match self {
            Self::Line(ends) => return share(ends, p.z),
            Self::Beside(ends) => (ends, p.z),
            Self::Across(ends) => (ends, elementary::hypot(p.x, p.y)),
        };
        let [from, to] = ends;
        let off = elementary::asinh(value) - 0.5 * (from + to);
        let tangents = [off, 0.5 * (to - from)].map(|x| {
            let half = 0.5 * x;
            elementary::sinh(half) / elementary::cosh(half)
        });
        arc_share(tangents[0], tangents[1])
    }
}

impl Bezier {
    fn point(&self, at: DVec2) -> DVec3 {
        let rows = self.net.iter().map(|row| casteljau(row.clone(), at.y));
        let point = casteljau(rows.collect(), at.x);
        self.scaled.point(point.truncate() / point.w)
    }
}

/// The point of a polynomial, by its control points.
fn casteljau(mut points: Vec<DVec4>, share: f64) -> DVec4 {
    for count in (1..points.len()).rev() {
        for k in 0..count {
            points[k] = points[k].lerp(points[k + 1], share);
        }
    }
    points[0]
}

impl Chart {
    /// The parameters of a point on the surface; angles around an axis from 0 to a whole turn.
    pub fn place(&self, point: DVec3) -> DVec2 {
        let around = |x: f64, y: f64| elementary::atan2(y, x).rem_euclid(TAU);
        match self {
            Self::Sphere { frame, .. } => {
                let p = frame.coordinates(point);
                let across = elementary::hypot(p.x, p.y);
                DVec2::new(around(p.x, p.y), elementary::atan2(p.z, across))
            }
            Self::Turned { frame, .. } => {
                let p = frame.coordinates(point);
                DVec2::new(around(p.x, p.y), p.z)
            }
            Self::Extruded {
                frame,
                radii: [a, b],
            } => {
                let p = frame.coordinates(point);
                DVec2::new(around(p.x / a, p.y / b), p.z)
            }
            Self::Branch { frame, radii } => {
                let p = frame.coordinates(point);
                DVec2::new(elementary::asinh(p.y / radii[1]), p.z)
            }
            Self::Bezier(patch) => patch.parameters.of(patch.scaled.coordinates(point)),
        }
    }

    /// The point at some parameters.
    pub fn point(&self, at: DVec2) -> DVec3 {
        let turned = || elementary::direction(at.x);
        match self {
            Self::Sphere { frame, radius } => {
                let (sin, cos) = elementary::sin_cos(at.y);
                frame.point((turned() * cos).extend(sin) * *radius)
            }
            Self::Turned {
                frame,
                radius,
                slope,
            } => frame.point((turned() * (radius + slope * at.y)).extend(at.y)),
            Self::Extruded { frame, radii } => {
                frame.point((turned() * DVec2::from(*radii)).extend(at.y))
            }
            Self::Branch {
                frame,
                radii: [a, b],
            } => {
                let (cosh, sinh) = (elementary::cosh(at.x), elementary::sinh(at.x));
                frame.point(DVec3::new(a * cosh, b * sinh, at.y))
            }
            Self::Bezier(patch) => patch.point(at),
        }
    }

    /// How many times as far a point moves that is found again by its parameters: across the shortest
    /// half axis its coordinates count for more than along the longest one.
    pub fn stretch(&self) -> f64 {
        match self {
            Self::Bezier(patch) => patch.scaled.stretch(),
            _ => 1.0,
        }
    }

    /// After what the first parameter comes again.
    pub fn period(&self) -> Option<f64> {
        (!matches!(self, Self::Branch { .. } | Self::Bezier(_))).then_some(TAU)
    }
}
