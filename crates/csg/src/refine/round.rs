//! Elongated ellipsoids, as the unit balls that they are in coordinates of their own.
//!
//! Where an ellipsoid is much flatter or longer than wide its normal turns about within
//! a distance far below the tolerance, so that no triangle there faces as its surface
//! does, and the way along the gradient leads past it. An affine map makes it a unit
//! ball. Triangles of the ball's convex hull that face away from its centre do not
//! overlap, and an affine map leaves that so; the rays from the centre map them onto
//! the ellipsoid one to one, which bounds the distance both ways.

use glam::{DMat3, DVec3};

use super::deviation::largest_off;
use crate::program::{Surface, eigen_symmetric};

/// An ellipsoid and the map that makes it the unit ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Round {
    center: DVec3,
    to_ball: DMat3,
    /// -f at the centre.
    depth: f64,
}

impl Round {
    /// None for all but elongated ellipsoids: triangles on others are good as they are.
    pub fn of(surface: &Surface) -> Option<Self> {
        /// The longest half axis by the shortest: tunes only the number of triangles.
        const LEAST_ASPECT: f64 = 6.0;
        surface.definiteness()?;
        let (values, axes) = eigen_symmetric(surface.quadratic);
        let sizes = values.map(f64::abs);
        let [least, most] = [f64::min, f64::max].map(|by| sizes.into_iter().reduce(by));
        let (least, most) = (least?, most?);
        let is_ellipsoid = least > f64::EPSILON * most;
        if !is_ellipsoid || least * LEAST_ASPECT * LEAST_ASPECT > most {
            return None;
        }
        let axes = [axes.x_axis, axes.y_axis, axes.z_axis];
        let along = |axis: DVec3, value: f64| surface.linear.dot(axis) / (2.0 * value) * axis;
        let off: DVec3 = axes.iter().zip(values).map(|(&a, v)| along(a, v)).sum();
        let center = surface.anchor - off;
        let depth = -surface.value(center);
        let scaled = |k: usize| (values[k] / depth).sqrt() * axes[k];
        let to_ball = DMat3::from_cols(scaled(0), scaled(1), scaled(2)).transpose();
        to_ball.is_finite().then_some(Self {
            center,
            to_ball,
            depth,
        })
    }

    /// Where a point comes to lie with the unit ball.
    #[inline]
    pub fn place(&self, point: DVec3) -> DVec3 {
        self.to_ball * (point - self.center)
    }

    /// The direction of f's gradient at a place of the unit ball.
    #[inline]
    pub fn gradient(&self, place: DVec3) -> DVec3 {
        self.depth.signum() * place
    }

    /// How much of a triangle faces along the gradient, with a sign.
    pub fn facing(&self, corners: [DVec3; 3]) -> f64 {
        let [p, q, r] = corners.map(|at| self.place(at));
        let normal = (q - p).cross(r - p);
        normal.dot(self.gradient(p + q + r))
    }

    /// The point of the ellipsoid on the ray from its centre.
    pub fn project(&self, point: DVec3) -> Option<DVec3> {
        let place = self.place(point);
        let projected = self.center + (point - self.center) / place.length();
        projected.is_finite().then_some(projected)
    }

    /// How far a chord or a triangle may be off, by the largest |f| of its points: from
    /// a point at the share s of the way from the centre it is (1 / s - 1) times that
    /// way, and 1 - s² = |f| / depth. Infinite if it goes through the centre.
    fn distance(&self, off: f64, corners: &[DVec3]) -> f64 {
        let squares = corners.iter().map(|c| c.distance_squared(self.center));
        let farthest = squares.fold(0.0, f64::max).sqrt();
        let share = (1.0 - off / self.depth.abs()).max(0.0).sqrt();
        (1.0 / share - 1.0) * farthest
    }

    /// A bound of the distance of any point of a triangle to the ellipsoid.
    pub fn bound(&self, surface: &Surface, corners: [DVec3; 3]) -> f64 {
        self.distance(largest_off(surface, corners), &corners)
    }

    /// About how far a chord is off its surface.
    pub fn sag(&self, surface: &Surface, [p, q]: [DVec3; 2]) -> f64 {
        self.estimate(
            surface,
            0.125 * surface.curvature_along(q - p).abs(),
            &[p, q],
        )
    }

    /// About how far a chord or a triangle is off its surface, by the largest |f| of
    /// its points: along the gradient, where that hardly turns, or from the centre.
    pub fn estimate(&self, surface: &Surface, off: f64, corners: &[DVec3]) -> f64 {
        let gradients = corners.iter().map(|&corner| surface.gradient(corner));
        let along = gradients.clone().sum::<DVec3>().normalize_or_zero();
        let slopes = gradients.map(|gradient| gradient.dot(along));
        let least = slopes.fold(f64::INFINITY, f64::min).max(0.0);
        (off / least).min(self.distance(off, corners))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{Program, Solid};

    /// An ellipsoid of the given half axes, turned, and the point of it above a point
    /// of the unit ball.
    fn ellipsoid(axes: [f64; 3]) -> (Surface, impl Fn(DVec3) -> DVec3) {
        let solid = Solid::ellipsoid(axes).rotate_x(0.4).rotate_z(1.1);
        let program = Program::lower(&solid).expect("valid");
        let turn = DMat3::from_rotation_z(1.1) * DMat3::from_rotation_x(0.4);
        let place = move |p: DVec3| turn * (p * DVec3::from(axes));
        (program.surfaces()[0], place)
    }

    proptest! {
        /// No sampled point of a triangle is farther off along the ray from the centre
        /// than the bound, which is no more than twice as large as the longest of
        /// those ways.
        #[test]
        fn the_way_from_the_centre_bounds_the_distance(
            exponents in prop::array::uniform3(-4.0..0.0f64),
            centre in prop::array::uniform3(-1.0..1.0f64),
            spread in prop::array::uniform3(prop::array::uniform3(-0.3..0.3f64)),
        ) {
            let centre = DVec3::from(centre);
            prop_assume!(centre.length() > 0.2);
            let (surface, place) = ellipsoid(exponents.map(|e| 10f64.powf(e)));
            // Coefficients know the thinnest axis to so many roundings.
            let [least, most] = [f64::min, f64::max].map(|by| exponents.into_iter().reduce(by));
            let aspect = 10f64.powf(most.unwrap_or(0.0) - least.unwrap_or(0.0));
            let Some(round) = Round::of(&surface) else {
                return Ok(());
            };
            let corners = spread.map(|s| place((centre.normalize() + DVec3::from(s)).normalize()));
            let bound = round.bound(&surface, corners);
            let (mut farthest, mut ways) = (0.0f64, 0.0f64);
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                    let point = corners[0] + u * (corners[1] - corners[0])
                        + v * (corners[2] - corners[0]);
                    let projected = round.project(point).expect("not the centre");
                    let off = surface.value(projected).abs() / round.depth.abs();
                    prop_assert!(off < 64.0 * f64::EPSILON * aspect * aspect, "{off}");
                    farthest = farthest.max(point.distance(projected));
                    let share = round.place(point).length();
                    let size = corners.iter().map(|c| c.length()).fold(0.0, f64::max);
                    ways = ways.max((1.0 / share - 1.0) * size);
                }
            }
            prop_assert!(farthest <= bound * (1.0 + 1e-9) + 1e-12, "{farthest} > {bound}");
            prop_assert!(bound <= 1.2 * ways + 1e-9, "{bound} of {ways}");
        }
    }

    #[test]
    fn only_elongated_ellipsoids_are_made_round() {
        let of = |solid: Solid| Round::of(&Program::lower(&solid).expect("valid").surfaces()[0]);
        assert!(of(Solid::sphere(3.0)).is_none());
        assert!(of(Solid::ellipsoid([3.0, 3.0, 0.9])).is_none());
        assert!(of(Solid::ellipsoid([3.0, 3.0, 0.3])).is_some());
        assert!(of(Solid::elliptic_cylinder([1.0, 0.1], 0.0..1.0)).is_none());
    }
}
