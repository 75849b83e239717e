//! Surfaces by the numbers that an author gives.

use glam::DVec3;

use crate::numeric::tolerance::MISSED;
use crate::program::{Kind, Surface};
use crate::surface::SurfaceShape;
use crate::surface::round::about_axis;

/// A surface by its numbers, about the middle of the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub form: Form,
    /// A point of the plane, the centre, a point of the axis, or the apex.
    pub at: DVec3,
    /// The normal or the axis.
    pub axis: DVec3,
    /// Of all directions, up to signs, the one of that.
    pub direction: usize,
    /// By how much its surface is not round, in sizes.
    pub spread: f64,
    /// The radius, or for cones the slope times the scene's reach.
    pub size: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Form {
    Plane,
    Ball,
    Rod,
    Cone,
    /// Something else about a centre.
    Centered,
    /// Nothing to be moved.
    Fixed,
}

impl Element {
    /// Sizes that differ by no more than `within` are one.
    pub fn of(surface: &Surface, reach: f64, within: f64) -> Self {
        let element = |form, at, axis, size| Self {
            form,
            at,
            axis,
            direction: 0,
            spread: 0.0,
            size,
        };
        let range = |sizes: &[f64]| {
            let [least, most] = [f64::min, f64::max].map(|pick| {
                let picked = sizes.iter().copied().reduce(pick);
                picked.unwrap_or_default()
            });
            (least, most)
        };
        let is_round = |sizes: &[f64]| {
            let (least, most) = range(sizes);
            most - least <= within
        };
        let round = |form, at, axis, sizes: &[f64]| {
            let (least, most) = range(sizes);
            Self {
                spread: most - least,
                ..element(form, at, axis, least.midpoint(most))
            }
        };
        // A cone whose apex is so far away that it is none.
        let rod = || {
            let form = surface.standard_form();
            let (at, change) = about_axis(surface, &form, reach)?;
            let rest = surface.value(at);
            let radii = [0, 1].map(|k| (-rest / form.values[k]).sqrt());
            let rod = round(Form::Rod, at, form.axes[2], &radii);
            // By half of that each way.
            let opened = change * rod.size;
            let spread = rod.spread + opened;
            let is_rod = spread <= within && opened <= MISSED * reach;
            is_rod.then_some(Self { spread, ..rod })
        };
        let shape = surface.shape();
        let may_be_rod = match shape {
            SurfaceShape::EllipticCylinder { .. } => true,
            _ => surface.kind == Kind::Cone,
        };
        if let Some(rod) = may_be_rod.then(rod).flatten() {
            return rod;
        }
        match shape {
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
            SurfaceShape::Ellipsoid { placement, radii } if is_round(&radii) => {
                round(Form::Ball, placement.origin, DVec3::ZERO, &radii)
            }
            SurfaceShape::EllipticCone { placement, slopes }
                if is_round(&slopes.map(|slope| slope * reach)) =>
            {
                let sizes = slopes.map(|slope| slope * reach);
                round(Form::Cone, placement.origin, placement.axes[2], &sizes)
            }
            SurfaceShape::Ellipsoid { placement, .. }
            | SurfaceShape::HyperboloidOneSheet { placement, .. }
            | SurfaceShape::HyperboloidTwoSheets { placement, .. }
            | SurfaceShape::EllipticCone { placement, .. } => {
                element(Form::Centered, placement.origin, DVec3::ZERO, 0.0)
            }
            _ => element(Form::Fixed, DVec3::ZERO, DVec3::ZERO, 0.0),
        }
    }

    pub fn has_axis(&self) -> bool {
        matches!(self.form, Form::Plane | Form::Rod | Form::Cone)
    }

    pub fn has_place(&self) -> bool {
        !matches!(self.form, Form::Plane | Form::Fixed)
    }

    pub fn radius(&self) -> f64 {
        match self.form {
            Form::Ball | Form::Rod => self.size,
            _ => 0.0,
        }
    }

    /// The surface with these numbers in place of its own.
    pub fn applied_to(&self, surface: &Surface, reach: f64) -> Surface {
        let sign = surface.quadratic[..3].iter().sum::<f64>().signum();
        // Of the unit matrix less the square of the axis, and of that square.
        let by_axis = |across: f64, along: f64, constant: f64, kind| {
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
            Form::Ball => by_axis(1.0, 1.0, -self.size * self.size, surface.kind),
            Form::Rod => by_axis(1.0, 0.0, -self.size * self.size, Kind::EllipticCylinder),
            Form::Cone => {
                let slope = self.size / reach;
                let cone = by_axis(1.0, -slope * slope, 0.0, Kind::Cone);
                // Inside and outside are those of before.
                let far = self.at + self.axis;
                match cone.value(far) * surface.value(far) < 0.0 {
                    true => cone.negated(),
                    false => cone,
                }
            }
            Form::Centered => {
                let center = Self::of(surface, reach, 0.0).at;
                Surface {
                    anchor: surface.anchor + (self.at - center),
                    ..*surface
                }
            }
            Form::Fixed => *surface,
        }
    }

    /// Bound on the distance between points of two surfaces of one form, of nearly the same
    /// numbers, within a ball about the origin; none of those that are not round.
    pub fn distance_bound(&self, other: &Self, reach: f64) -> Option<f64> {
        // Turned about the place, and grown.
        let extent = reach + self.at.length();
        let grown = match self.form {
            Form::Ball | Form::Rod => 1.0,
            Form::Cone => extent / reach,
            _ => return None,
        };
        let turned = (self.axis - other.axis).length();
        let turned = turned.min((self.axis + other.axis).length());
        let sizes = (self.size - other.size).abs() + 0.5 * (self.spread + other.spread);
        (self.form == other.form)
            .then(|| self.at.distance(other.at) + extent * turned + grown * sizes)
    }
}
