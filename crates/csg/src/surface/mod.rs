//! Surfaces: planes and quadrics about an anchor point.

mod bounds;
mod id;
mod kind;
mod precise;
mod principal;
mod quadric;
pub(crate) mod round;
mod shape;
pub(crate) mod solve;
mod standard_form;

use std::fmt;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

pub use self::bounds::Bounds;
pub(crate) use self::bounds::half_space_bounds;
pub(crate) use self::id::SurfaceId;
pub(crate) use self::kind::Kind;
pub(crate) use self::quadric::{from_coefficients, is_far};
pub use self::shape::{Placement, SurfaceShape};
pub(crate) use self::standard_form::StandardForm;
use crate::numeric::tolerance::VALUE;

/// Where a surface's half-space f <= 0 lies relative to a set of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// f <= 0 on all of the set.
    Inside,
    /// f > 0 on all of the set.
    Outside,
    /// Neither could be proven.
    Crossing,
}

/// A plane or a quadric:
/// f(p) = xx dx² + yy dy² + zz dz² + xy dx dy + yz dy dz + zx dz dx + g·d + c
/// with d = p - anchor.
///
/// The anchor lies on the surface's plane, axis, centre or vertex, near the
/// primitive that gave it, so that a model a million units from the origin
/// loses no more digits than its coordinates do. Planes have a unit gradient
/// and c = 0; of a quadric's six quadratic coefficients the largest magnitude
/// is 1, so f is in squared lengths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    pub(crate) anchor: DVec3,
    /// xx, yy, zz, xy, yz, zx.
    pub(crate) quadratic: [f64; 6],
    pub(crate) linear: DVec3,
    pub(crate) constant: f64,
    /// What it is: a plane, or which quadric.
    pub(crate) kind: Kind,
}

impl Surface {
    /// The plane through `anchor`, whose half-space the normal points out of: of unit
    /// length but in primitives, which are normalised in place.
    pub(crate) fn plane(anchor: DVec3, normal: DVec3) -> Self {
        Self {
            anchor,
            quadratic: [0.0; 6],
            linear: normal,
            constant: 0.0,
            kind: Kind::Plane,
        }
    }

    /// Whether f is linear.
    #[must_use]
    pub fn is_plane(&self) -> bool {
        self.kind == Kind::Plane
    }

    /// The point f is expanded about.
    #[must_use]
    pub fn anchor(&self) -> DVec3 {
        self.anchor
    }

    /// The point where the gradient vanishes on the surface: a cone's apex, if it is so
    /// near to the part of the cone that is used that it is the anchor.
    #[must_use]
    pub fn apex(&self) -> Option<DVec3> {
        (self.kind == Kind::Cone && self.linear == DVec3::ZERO).then_some(self.anchor)
    }

    /// The direction of a cone's axis. Some direction for other surfaces.
    #[must_use]
    pub fn cone_axis(&self) -> DVec3 {
        self.standard_form().axes[2]
    }

    /// f at `point`.
    ///
    /// The order of operations is part of the contract: along x it is Horner's
    /// rule on coefficients that depend on y and z alone, exactly as the
    /// bit-parallel rows evaluate it, so that both agree to the last bit.
    #[must_use]
    #[inline]
    pub fn value(&self, point: DVec3) -> f64 {
        let [a, b, c] = self.row(point.y, point.z);
        let dx = point.x - self.anchor.x;
        (a * dx + b) * dx + c
    }

    /// The coefficients [a, b, c] of f = (a dx + b) dx + c along the row of
    /// given y and z, dx = x - anchor.x.
    #[must_use]
    #[inline]
    pub fn row(&self, y: f64, z: f64) -> [f64; 3] {
        let [xx, yy, zz, xy, yz, zx] = self.quadratic;
        let dy = y - self.anchor.y;
        let dz = z - self.anchor.z;
        let b = self.linear.x + (xy * dy + zx * dz);
        let c = self.constant
            + ((yy * dy + yz * dz + self.linear.y) * dy + (zz * dz + self.linear.z) * dz);
        [xx, b, c]
    }

    /// The gradient of f at `point`.
    #[must_use]
    #[inline]
    pub fn gradient(&self, point: DVec3) -> DVec3 {
        let [xx, yy, zz, xy, yz, zx] = self.quadratic;
        let d = point - self.anchor;
        DVec3::new(
            2.0 * xx * d.x + (xy * d.y + zx * d.z) + self.linear.x,
            2.0 * yy * d.y + (yz * d.z + xy * d.x) + self.linear.y,
            2.0 * zz * d.z + (zx * d.x + yz * d.y) + self.linear.z,
        )
    }

    /// The directional second derivative dᵀ H d of f along `d`, twice its
    /// quadratic form.
    #[must_use]
    #[inline]
    pub fn curvature_along(&self, d: DVec3) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.quadratic;
        2.0 * ((xx * d.x + xy * d.y) * d.x
            + (yy * d.y + yz * d.z) * d.y
            + (zz * d.z + zx * d.x) * d.z)
    }

    /// How the surface parts from its tangent plane at one of its points, in the plane of two unit
    /// vectors, `along` in the tangent plane and `up` across it: the factors of s², s³ and s⁴ in its
    /// height above the point so far along.
    pub(crate) fn bends(&self, at: DVec3, along: DVec3, up: DVec3) -> [f64; 3] {
        // f(s along + h up) = g h + a s² + 2 b s h + c h² = 0, power by power.
        let slope = self.gradient(at).dot(up);
        let half = |d: DVec3| 0.5 * self.curvature_along(d);
        let (a, c) = (half(along), half(up));
        let b = 0.5 * (half(along + up) - a - c);
        let second = -a / slope;
        let third = -2.0 * b * second / slope;
        let fourth = -(2.0 * b * third + c * second * second) / slope;
        [second, third, fourth]
    }

    /// The sizes of the terms of half of [`Self::curvature_along`]: so much of them is rounding.
    pub(crate) fn terms_along(&self, d: DVec3) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.quadratic.map(f64::abs);
        let DVec3 { x, y, z } = d.abs();
        (xx * x + xy * y) * x + (yy * y + yz * z) * y + (zz * z + zx * x) * z
    }

    /// Bounds of f over the box of the given centre and half extents, rounded
    /// outward.
    ///
    /// About the centre, f = f0 + Σ (g_i d_i + a_ii d_i²) + Σ a_ij d_i d_j.
    /// The separable part is bounded exactly, the cross terms by their
    /// magnitudes: exact without cross terms, of second-order excess with.
    #[must_use]
    #[inline]
    pub fn bounds_over(&self, center: DVec3, half: DVec3) -> (f64, f64) {
        let f0 = self.value(center);
        let d = center - self.anchor;
        let reach = d.abs() + half;
        if self.is_plane() {
            let spread = self.linear.abs().dot(half);
            let margin = VALUE * self.linear.abs().dot(reach);
            return (f0 - spread - margin, f0 + spread + margin);
        }
        let gradient = self.gradient(center);
        let [xx, yy, zz, xy, yz, zx] = self.quadratic;
        let [xy, yz, zx] = [xy.abs(), yz.abs(), zx.abs()];
        let (x0, x1) = parabola_range(xx, gradient.x, half.x);
        let (y0, y1) = parabola_range(yy, gradient.y, half.y);
        let (z0, z1) = parabola_range(zz, gradient.z, half.z);
        let cross = xy * half.x * half.y + yz * half.y * half.z + zx * half.z * half.x;
        let magnitude = (xx.abs() * reach.x + xy * reach.y) * reach.x
            + (yy.abs() * reach.y + yz * reach.z) * reach.y
            + (zz.abs() * reach.z + zx * reach.x) * reach.z
            + self.linear.abs().dot(reach)
            + self.constant.abs();
        let margin = cross + 4.0 * VALUE * magnitude;
        (f0 + (x0 + y0 + z0) - margin, f0 + (x1 + y1 + z1) + margin)
    }

    /// Which side of the surface the box lies on.
    #[must_use]
    #[inline]
    pub fn side_of_box(&self, center: DVec3, half: DVec3) -> Side {
        let (low, high) = self.bounds_over(center, half);
        if low > 0.0 {
            Side::Outside
        } else if high <= 0.0 {
            Side::Inside
        } else {
            Side::Crossing
        }
    }

    /// The same surface in coordinates relative to `origin`.
    #[must_use]
    pub(crate) fn relative_to(&self, origin: DVec3) -> Self {
        Self {
            anchor: self.anchor - origin,
            ..*self
        }
    }

    /// The same surface after an affine map M, by its inverse and where that takes the
    /// anchor: f(M⁻¹ (p - M anchor)), whose quadratic form is M⁻ᵀ A M⁻¹ and whose linear one
    /// M⁻ᵀ g.
    #[must_use]
    pub(crate) fn pulled_back(&self, inverse: &DMat3, anchor: DVec3) -> Self {
        let transposed = inverse.transpose();
        let linear = transposed * self.linear;
        if self.is_plane() {
            return Self {
                anchor,
                linear,
                ..*self
            };
        }
        let [xx, yy, zz, xy, yz, zx] = self.quadratic;
        let form = DMat3::from_cols(
            DVec3::new(xx, 0.5 * xy, 0.5 * zx),
            DVec3::new(0.5 * xy, yy, 0.5 * yz),
            DVec3::new(0.5 * zx, 0.5 * yz, zz),
        );
        let image = transposed * form * *inverse;
        Self {
            anchor,
            quadratic: [
                image.x_axis.x,
                image.y_axis.y,
                image.z_axis.z,
                image.x_axis.y + image.y_axis.x,
                image.y_axis.z + image.z_axis.y,
                image.z_axis.x + image.x_axis.z,
            ],
            linear,
            constant: self.constant,
            kind: self.kind,
        }
    }

    /// The surface of -f.
    #[must_use]
    pub(crate) fn negated(&self) -> Self {
        Self {
            anchor: self.anchor,
            quadratic: self.quadratic.map(|a| -a),
            linear: -self.linear,
            constant: -self.constant,
            kind: self.kind,
        }
    }

    /// The same f about another anchor: (linear, constant).
    #[must_use]
    pub(crate) fn expanded_about(&self, anchor: DVec3) -> (DVec3, f64) {
        (self.gradient(anchor), self.value(anchor))
    }
}

/// The range of g d + a d² over |d| <= h.
#[inline]
fn parabola_range(a: f64, g: f64, h: f64) -> (f64, f64) {
    let even = a * h * h;
    let odd = (g * h).abs();
    let (mut low, mut high) = (even - odd, even + odd);
    // The vertex -g / 2a lies inside: it is the least or the greatest value.
    if g.abs() < 2.0 * a.abs() * h {
        let vertex = -g * g / (4.0 * a);
        low = low.min(vertex);
        high = high.max(vertex);
    }
    (low, high)
}

/// Roots, as shares of the edge, of the quadratic with second coefficient
/// `quadratic` per unit of length that takes the values f0 and f1 at the ends
/// of an edge of the given length: one if f <= 0 at one end alone, else two
/// or none. Without cancellation (Press et al., *Numerical Recipes*, 5.6).
pub(crate) fn roots_between(quadratic: f64, length: f64, f0: f64, f1: f64) -> ([f64; 2], usize) {
    let a = quadratic * length * length;
    let b = f1 - f0 - a;
    if (f0 <= 0.0) != (f1 <= 0.0) {
        if a == 0.0 {
            return ([(f0 / (f0 - f1)).clamp(0.0, 1.0), 0.0], 1);
        }
        let discriminant = (b * b - 4.0 * a * f0).max(0.0);
        let q = -0.5 * (b + discriminant.sqrt().copysign(b));
        let misfit = |t: f64| {
            if t.is_finite() {
                (t - 0.5).abs()
            } else {
                f64::INFINITY
            }
        };
        let (first, second) = (q / a, f0 / q);
        let t = if misfit(second) <= misfit(first) {
            second
        } else {
            first
        };
        let t = if t >= 0.0 { t.min(1.0) } else { 0.0 };
        return ([t, 0.0], 1);
    }
    // The extremum lies between the ends, and beyond zero.
    if !(b.abs() < 2.0 * a.abs() && a * f0 > 0.0) || b * a >= 0.0 {
        return ([0.0; 2], 0);
    }
    let discriminant = b * b - 4.0 * a * f0;
    if discriminant <= 0.0 {
        return ([0.0; 2], 0);
    }
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    let (first, second) = (q / a, f0 / q);
    (
        [
            first.min(second).clamp(0.0, 1.0),
            first.max(second).clamp(0.0, 1.0),
        ],
        2,
    )
}

/// The roots of a t² + b t + c, without cancellation: an infinite one where there is only
/// one, none where there are none or they are one.
pub(crate) fn line_roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = b * b - 4.0 * a * c;
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    (discriminant > 0.0 && q != 0.0).then(|| {
        let far = if a == 0.0 { f64::INFINITY } else { q / a };
        [far.min(c / q), far.max(c / q)]
    })
}

impl fmt::Display for Surface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const TERMS: [&str; 9] = ["x²", "y²", "z²", "xy", "yz", "zx", "x", "y", "z"];
        let coefficients = self
            .quadratic
            .into_iter()
            .chain(self.linear.to_array())
            .zip(TERMS);
        let mut first = true;
        for (coefficient, term) in coefficients.chain([(self.constant, "")]) {
            if coefficient == 0.0 {
                continue;
            }
            let sign = match (first, coefficient < 0.0) {
                (true, true) => "-",
                (true, false) => "",
                (false, true) => " - ",
                (false, false) => " + ",
            };
            first = false;
            let magnitude = coefficient.abs();
            if magnitude == 1.0 && !term.is_empty() {
                write!(f, "{sign}{term}")?;
            } else if term.is_empty() {
                write!(f, "{sign}{magnitude}")?;
            } else {
                write!(f, "{sign}{magnitude} {term}")?;
            }
        }
        if self.anchor != DVec3::ZERO {
            write!(
                f,
                " about ({}, {}, {})",
                self.anchor.x, self.anchor.y, self.anchor.z
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_surface() -> impl Strategy<Value = Surface> {
        (
            prop::array::uniform6(-1.0..1.0f64),
            prop::array::uniform3(-2.0..2.0f64),
            -2.0..2.0f64,
            prop::array::uniform3(-3.0..3.0f64),
            prop::bool::ANY,
        )
            .prop_map(|(quadratic, linear, constant, anchor, separable)| {
                let mut quadratic = quadratic;
                if separable {
                    quadratic[3..].fill(0.0);
                }
                Surface::of_terms(anchor.into(), quadratic, linear.into(), constant)
            })
    }

    proptest! {
        #[test]
        fn bounds_enclose_and_are_tight_without_cross_terms(
            surface in any_surface(),
            center in prop::array::uniform3(-3.0..3.0f64),
            half in prop::array::uniform3(1e-3..1.0f64),
        ) {
            let (center, half) = (DVec3::from(center), DVec3::from(half));
            let (low, high) = surface.bounds_over(center, half);
            let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
            let n = 12;
            for i in 0..=n {
                for j in 0..=n {
                    for k in 0..=n {
                        let t = DVec3::new(i.into(), j.into(), k.into()) * (2.0 / f64::from(n)) - 1.0;
                        let f = surface.value(center + t * half);
                        prop_assert!(low <= f && f <= high, "{low} <= {f} <= {high}");
                        least = least.min(f);
                        greatest = greatest.max(f);
                    }
                }
            }
            if surface.quadratic[3..] == [0.0; 3] {
                // Sampling misses an extremum by at most the curvature over
                // half a step per axis.
                let miss = (half / f64::from(n)).length_squared();
                prop_assert!(least - low <= miss + 1e-12, "{least} {low}");
                prop_assert!(high - greatest <= miss + 1e-12, "{greatest} {high}");
            }
        }

        #[test]
        fn gradient_is_the_derivative(
            surface in any_surface(),
            point in prop::array::uniform3(-3.0..3.0f64),
        ) {
            let point = DVec3::from(point);
            let h = 1e-3;
            for axis in DVec3::AXES {
                // Exact for quadratics but for rounding.
                let slope = (surface.value(point + axis * h) - surface.value(point - axis * h)) / (2.0 * h);
                prop_assert!((slope - surface.gradient(point).dot(axis)).abs() < 1e-9);
            }
        }
    }
}
