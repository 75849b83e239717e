//! Quadrics that touch at a point, or nearly so.

use glam::{DVec3, DVec4};
use smallvec::{SmallVec, smallvec};

use super::conics::conics;
use super::{Lines, Pencil, form, matrix};
use crate::arrangement::curve::Branches;
use crate::arrangement::intersection::Unknown;
use crate::numeric::eigen_symmetric;
use crate::numeric::tolerance::{CANCELLED, TOUCHING};
use crate::program::Surface;

/// A place where surfaces touch or nearly do, and the quadric of the pencil whose gradient is 0
/// there.
struct Tangency {
    at: DVec3,
    /// The gradient of the first surface.
    gradient: DVec3,
    /// The form of that quadric, its value, which is 0 where they touch, and what rounding
    /// left of its gradient.
    form: [f64; 6],
    value: f64,
    rest: DVec3,
    /// The values of that form, ascending, and its axes.
    values: [f64; 3],
    axes: [DVec3; 3],
}

impl Tangency {
    /// From near it; none if the surfaces have no tangent plane in common there.
    fn of([a, b]: [&Surface; 2], start: DVec3) -> Option<Self> {
        let at = contact(a, b, start);
        let [p, q] = [a, b].map(|s| s.gradient(at));
        let factor = p.dot(q) / q.length_squared();
        let rest = p - factor * q;
        if !factor.is_finite() || rest.length() > TOUCHING * p.length() {
            return None;
        }
        let mut form: [f64; 6] = a.quadratic;
        for (sum, value) in form.iter_mut().zip(b.quadratic) {
            *sum -= factor * value;
        }
        let (values, axes) = eigen_symmetric(form);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
        Some(Self {
            at,
            gradient: p,
            form,
            value: a.value(at) - factor * b.value(at),
            rest,
            values: order.map(|k| values[k]),
            axes: order.map(|k| axes.col(k)),
        })
    }

    fn largest(&self) -> f64 {
        self.values[2].max(-self.values[0])
    }

    fn is_nothing(&self, value: f64) -> bool {
        value.abs() <= CANCELLED * self.largest()
    }
}

impl Pencil<'_> {
    /// The curves of quadrics that touch at a point, or nearly so.
    pub(super) fn through_contact(&self, start: DVec3) -> Result<Branches, Unknown> {
        /// In units of the pencil: of surfaces of one shape, contacts at infinity are rounded to
        /// some far away, which tell nothing.
        const FAR: f64 = 1e3;
        let [a, _] = self.surfaces;
        let contact = Tangency::of(self.surfaces, start).ok_or(Unknown::NoForm)?;
        let Tangency {
            at, values, axes, ..
        } = contact;
        if self.is_about_contact || at.distance(self.origin) > FAR * self.unit {
            return Err(Unknown::NoForm);
        }
        let sign = |value: f64| match contact.is_nothing(value) {
            true => 0.0,
            false => value.signum(),
        };
        // 0 along a line: it meets the surfaces in points if it is not on them.
        let along = |axis: DVec3| {
            if contact.is_nothing(0.5 * a.curvature_along(axis)) {
                Err(Unknown::NoForm)
            } else {
                Err(Unknown::Touch(smallvec![at]))
            }
        };
        match values.map(sign) {
            [-1.0, 0.0, 1.0] => {
                let [low, high] = [values[0], values[2]].map(|v| v.abs().sqrt());
                let sides = [1.0, -1.0].map(|sign| {
                    Surface::plane(
                        at,
                        (low * axes[0] + sign * high * axes[2]).normalize_or_zero(),
                    )
                });
                // Of the two points on their line one is where the contact was found.
                let along = axes[1];
                let square = 0.5 * a.curvature_along(along);
                let other = at - a.gradient(at).dot(along) / square * along;
                let nodes = [at, other].into_iter().filter(|node| node.is_finite());
                conics(
                    &sides,
                    &nodes.collect::<SmallVec<[DVec3; 2]>>(),
                    a,
                    self.nearness,
                )
            }
            // A cone with its apex there.
            [-1.0, middle, 1.0] => {
                let scaled = |k: usize| (axes[k] / values[k].abs().sqrt()).extend(0.0);
                let odd = if middle > 0.0 { 0 } else { 2 };
                let apex = ((at - self.origin) / self.unit).extend(1.0);
                let lines = Lines {
                    p: [scaled(odd), scaled(2 - odd), scaled(1)],
                    q: [apex, DVec4::ZERO, DVec4::ZERO],
                };
                // No other contact is looked for on its lines: that might never end.
                let once = Pencil {
                    is_about_contact: true,
                    ..*self
                };
                once.on_cone(&lines, &self.matrices[1])
            }
            [1.0, 1.0, 1.0] | [-1.0, -1.0, -1.0] => self.beside_contact(&contact),
            [0.0, 1.0, 1.0] => along(axes[0]),
            [-1.0, -1.0, 0.0] => along(axes[2]),
            _ => Err(Unknown::NoForm),
        }
    }

    /// The one curve of quadrics that nearly touch, if they do not cross elsewhere: none, or a
    /// loop around the contact, whose digits are lost in the pencil's unit.
    fn beside_contact(&self, contact: &Tangency) -> Result<Branches, Unknown> {
        let &Tangency { at, value, .. } = contact;
        let steep = contact.gradient.length();
        if value.abs() <= self.nearness.touch * steep {
            return Err(Unknown::Touch(smallvec![at]));
        }
        if value * contact.values[1] > 0.0 {
            return Ok(Branches::new());
        }
        // The longest axis of the ellipsoid that the curve is on.
        let least = contact.values.map(f64::abs).into_iter().reduce(f64::min);
        let unit = (value / least.unwrap_or(1.0)).abs().sqrt();
        let ellipsoid = form(contact.form, contact.rest, value, unit);
        let about = Pencil {
            surfaces: self.surfaces,
            origin: at,
            unit,
            matrices: [
                matrix(self.surfaces[0], at, unit) * (unit / steep),
                ellipsoid * contact.largest().recip(),
            ],
            blur: 0.0,
            nearness: self.nearness.within(unit / self.unit),
            is_about_contact: true,
        };
        about.by_members()
    }
}

/// Where two surfaces have the same tangent plane, from near it.
fn contact(a: &Surface, b: &Surface, start: DVec3) -> DVec3 {
    const STEPS: u32 = 6;
    let hessian = |s: &Surface| {
        let [xx, yy, zz, xy, yz, zx] = s.quadratic;
        glam::DMat3::from_cols_array(&[2.0 * xx, xy, zx, xy, 2.0 * yy, yz, zx, yz, 2.0 * zz])
    };
    let mut at = start;
    for _ in 0..STEPS {
        // a = 0 and ∇a = factor ∇b, by Newton's method.
        let [p, q] = [a, b].map(|s| s.gradient(at));
        let factor = p.dot(q) / q.length_squared();
        let [u, v] = <[DVec3; 2]>::from(q.normalize_or_zero().any_orthonormal_pair());
        let second = hessian(a) - factor * hessian(b);
        let rows = glam::DMat3::from_cols(p, second * u, second * v).transpose();
        let off = p - factor * q;
        let step = rows.inverse() * DVec3::new(a.value(at), off.dot(u), off.dot(v));
        if !step.is_finite() || step.length() > 1e-3 * a.gradient(at).length() {
            break;
        }
        at -= step;
    }
    at
}
