//! Elongated quadrics as the round ones that they are in coordinates of their own.
//!
//! Where an ellipsoid, cylinder or cone is much flatter than wide its normal turns about
//! within a distance far below the tolerance, so that no triangle there faces as its
//! surface does, and the way along the gradient leads past it. An affine map makes it a
//! unit ball, a circular cylinder, a cone of a right angle. Triangles that face outward
//! there do not overlap, and an affine map leaves that so. The ways from the ball's
//! centre, and those at right angles from the axis, map them onto the quadric one to one,
//! which bounds the distance both ways.

use glam::{DMat3, DVec3};
use smallvec::SmallVec;

use super::{Kind, StandardForm, Surface};

/// The longest half axis by the shortest, from which on it counts as long: tunes only the
/// number of triangles.
pub(crate) const LEAST_ASPECT: f64 = 6.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    /// x² + y² + z² = 1.
    Ball,
    /// x² + y² = 1.
    Cylinder,
    /// x² + y² = z².
    Cone,
}

/// An elongated quadric and the map that makes it round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Round {
    shape: Shape,
    /// The centre, a point of the axis, or the apex.
    center: DVec3,
    /// From there, to coordinates in which it has its shape.
    to_round: DMat3,
    /// The direction of the axis.
    axis: DVec3,
    /// 1 if f grows outward, else -1.
    outward: f64,
}

impl Round {
    /// None for all others: triangles on these are good as they are, and those on a needle of
    /// which within `reach` of the origin only a short piece is, however long it is beyond.
    pub fn of(surface: &Surface, reach: f64) -> Option<Self> {
        let mut round = match surface.kind {
            Kind::Ellipsoid => 3,
            Kind::EllipticCylinder | Kind::Cone => 2,
            _ => return None,
        };
        let form = surface.standard_form();
        if like_cylinder(surface, &form, reach).is_some() {
            round = 2;
        }
        let sizes = form.values[..round].iter().map(|v| v.abs());
        let least = sizes.clone().fold(f64::INFINITY, f64::min);
        let most = sizes.fold(0.0, f64::max);
        let is_long = least * LEAST_ASPECT * LEAST_ASPECT <= most;
        is_long.then(|| Self::standard(surface)).flatten()
    }

    /// The same of any ellipsoid, elliptic cylinder or cone: a circular cone is flat, too, where
    /// its axis is much shorter than it is wide.
    pub fn standard(surface: &Surface) -> Option<Self> {
        let shape = match surface.kind {
            Kind::Ellipsoid => Shape::Ball,
            Kind::EllipticCylinder => Shape::Cylinder,
            Kind::Cone if surface.apex().is_some() => Shape::Cone,
            _ => return None,
        };
        let StandardForm {
            center,
            axes,
            mut values,
            constant,
            ..
        } = surface.standard_form();
        let depth = match shape {
            Shape::Ball | Shape::Cylinder => -constant,
            Shape::Cone => values[2].abs() * values[0].signum(),
        };
        // (Any length along a cylinder's axis is as good as any other.)
        if shape == Shape::Cylinder {
            values[2] = values[0].abs().min(values[1].abs()) * values[0].signum();
        }
        let scaled = |k: usize| (values[k] / depth).abs().sqrt() * axes[k];
        let mut rows = [0, 1, 2].map(scaled);
        if rows[0].cross(rows[1]).dot(rows[2]) < 0.0 {
            rows[0] = -rows[0];
        }
        let to_round = DMat3::from_cols_array_2d(&rows.map(|r| r.to_array())).transpose();
        let is_real = depth * values[0] > 0.0 && to_round.is_finite();
        is_real.then_some(Self {
            shape,
            center,
            to_round,
            axis: axes[2],
            outward: values[0].signum(),
        })
    }

    /// Where a point comes to lie with the round surface.
    #[inline]
    pub fn place(&self, point: DVec3) -> DVec3 {
        self.to_round * (point - self.center)
    }

    /// What a direction becomes.
    #[inline]
    pub fn direction(&self, along: DVec3) -> DVec3 {
        self.to_round * along
    }

    /// Another surface as it lies with the round one.
    pub fn image(&self, surface: &Surface) -> Surface {
        surface.pulled_back(&self.to_round.inverse(), self.place(surface.anchor))
    }

    /// No distance is so many times as long as with the round surface.
    pub fn longest(&self) -> f64 {
        // Its rows are at right angles to each other.
        let rows = self.to_round.transpose();
        let lengths = [rows.x_axis, rows.y_axis, rows.z_axis].map(DVec3::length);
        lengths.into_iter().fold(f64::INFINITY, f64::min).recip()
    }

    /// The direction of f's gradient at a place with the round surface.
    #[inline]
    pub fn gradient(&self, place: DVec3) -> DVec3 {
        let outward = match self.shape {
            Shape::Ball => place,
            Shape::Cylinder => place.with_z(0.0),
            Shape::Cone => place.with_z(-place.z),
        };
        self.outward * outward
    }

    /// How much of a triangle faces along the gradient, with a sign.
    pub fn facing(&self, corners: [DVec3; 3]) -> f64 {
        let [p, q, r] = corners.map(|at| self.place(at));
        let normal = (q - p).cross(r - p);
        normal.dot(self.gradient((p + q + r) / 3.0))
    }

    /// From the centre, or the axis, to a point.
    fn spoke(&self, point: DVec3) -> DVec3 {
        let off = point - self.center;
        match self.shape {
            Shape::Ball => off,
            Shape::Cylinder | Shape::Cone => off - off.dot(self.axis) * self.axis,
        }
    }

    /// A spoke as a share of the one that ends at the surface, by its direction; none at
    /// an apex. Straight lines have straight images.
    fn share(&self, point: DVec3) -> Option<DVec3> {
        let place = self.place(point);
        let share = match self.shape {
            Shape::Ball => place,
            Shape::Cylinder => place.with_z(0.0),
            Shape::Cone => (place / place.z.abs()).with_z(0.0),
        };
        share.is_finite().then_some(share)
    }

    /// The point of the surface on the way from the centre, or the axis.
    pub fn project(&self, point: DVec3) -> Option<DVec3> {
        let spoke = self.spoke(point);
        let projected = point + (1.0 / self.share(point)?.length() - 1.0) * spoke;
        projected.is_finite().then_some(projected)
    }

    /// How far the surface turns between two points, about in radians.
    pub fn turn(&self, ends: [DVec3; 2]) -> f64 {
        match ends.map(|end| self.share(end)) {
            [Some(a), Some(b)] => a.distance(b),
            _ => 0.0,
        }
    }

    /// A bound of the distance of any point of a chord or triangle to the surface, by the
    /// ways from the centre or the axis; infinite if it goes through there.
    pub fn bound(&self, corners: &[DVec3]) -> f64 {
        let shares = corners.iter().filter_map(|&corner| self.share(corner));
        let shares: SmallVec<[DVec3; 3]> = shares.collect();
        let farthest = corners.iter().map(|&corner| self.spoke(corner).length());
        let farthest = farthest.fold(0.0, f64::max);
        // Corners are off it by rounding.
        let most = shares
            .iter()
            .map(|share| share.length())
            .fold(1.0, f64::max);
        let least = distance_from_origin(&shares).min(1.0);
        (1.0 / least - 1.0).max(1.0 - 1.0 / most) * farthest
    }

    /// About how far a chord or a triangle is off its surface, by the largest |f| of
    /// its points: along the gradient, where that hardly turns, or by [`Self::bound`].
    pub fn estimate(&self, surface: &Surface, off: f64, corners: &[DVec3]) -> f64 {
        let gradients = corners.iter().map(|&corner| surface.gradient(corner));
        let along = gradients.clone().sum::<DVec3>().normalize_or_zero();
        let slopes = gradients.map(|gradient| gradient.dot(along));
        let least = slopes.fold(f64::INFINITY, f64::min).max(0.0);
        (off / least).min(self.bound(corners))
    }

    /// About how far a chord is off its surface.
    pub fn sag(&self, surface: &Surface, ends: [DVec3; 2]) -> f64 {
        let off = 0.125 * surface.curvature_along(ends[1] - ends[0]).abs();
        self.estimate(surface, off, &ends)
    }

    /// Into how many chords a unit of a curve's parameter is to be cut at a point, by its
    /// derivative there, for these to be as near to the surface as a tolerance on the
    /// ways from the centre or the axis: the triangles beside them then face out.
    pub fn chords_along(&self, at: DVec3, derivative: DVec3, tolerance: f64) -> f64 {
        /// Of the derivative: a difference is as good.
        const STEP: f64 = 1e-6;
        let ends = [-STEP, STEP].map(|step| at + step * derivative);
        let turn = self.turn(ends) / (2.0 * STEP);
        turn * (self.spoke(at).length() / (8.0 * tolerance)).sqrt()
    }
}

/// Corners as they are looked at: with the round surface if there is one.
#[inline(always)]
pub(crate) fn placed(round: Option<&Round>, corners: [DVec3; 3]) -> [DVec3; 3] {
    round.map_or(corners, |round| corners.map(|at| round.place(at)))
}

/// The direction of the gradient at a place of the kind that [`placed`] returns.
#[inline(always)]
pub(crate) fn gradient(surface: &Surface, round: Option<&Round>, at: DVec3) -> DVec3 {
    round.map_or_else(|| surface.gradient(at), |round| round.gradient(at))
}

/// How well a triangle faces along the gradient at its middle: the cosine of the angle
/// between both; 0 if it has no area.
pub(crate) fn facing_cosine(surface: &Surface, round: Option<&Round>, corners: [DVec3; 3]) -> f64 {
    let [p, q, r] = placed(round, corners);
    let gradient = gradient(surface, round, (p + q + r) / 3.0);
    cosine((q - p).cross(r - p), gradient)
}

/// Of the angle between two vectors; 0 if one has no length.
pub(crate) fn cosine(a: DVec3, b: DVec3) -> f64 {
    let lengths = a.length_squared() * b.length_squared();
    if lengths > 0.0 {
        a.dot(b) / lengths.sqrt()
    } else {
        0.0
    }
}

/// The least and the most, of all points of a triangle, of how much it faces along the
/// gradient, in units of no meaning: at the corners, as a quadric's gradient is linear in
/// the point.
#[inline(always)]
pub(crate) fn facing_range(
    surface: &Surface,
    round: Option<&Round>,
    corners: [DVec3; 3],
) -> [f64; 2] {
    let corners @ [p, q, r] = placed(round, corners);
    let normal = (q - p).cross(r - p);
    range(corners.map(|at| normal.dot(gradient(surface, round, at))))
}

/// The least and the most of three.
#[inline(always)]
pub(crate) fn range([a, b, c]: [f64; 3]) -> [f64; 2] {
    [a.min(b).min(c), a.max(b).max(c)]
}

/// Where the axis is of a quadric that within `reach` of the origin is like a cylinder along its
/// last axis: a centre or an apex far away would only cost digits.
pub(crate) fn like_cylinder(surface: &Surface, form: &StandardForm, reach: f64) -> Option<DVec3> {
    /// Of the square of its radius.
    const MOST_CHANGE: f64 = 0.5;
    let (on_axis, change) = about_axis(surface, form, reach)?;
    (change <= MOST_CHANGE).then_some(on_axis)
}

/// The point of a quadric's last axis that is next to the origin, if the quadric is around it
/// there, and bound on the share by which within `reach` of the origin the square of its radius
/// changes: with d the distance along the axis, by value d² + slope d.
pub(crate) fn about_axis(
    surface: &Surface,
    &StandardForm { axes, values, .. }: &StandardForm,
    reach: f64,
) -> Option<(DVec3, f64)> {
    if values[0] * values[1] <= 0.0 {
        return None;
    }
    let gradient = surface.gradient(DVec3::ZERO);
    let off_axis: DVec3 = (0..2)
        .map(|k| gradient.dot(axes[k]) / (2.0 * values[k]) * axes[k])
        .sum();
    let rest = surface.value(-off_axis);
    let slope = gradient.dot(axes[2]).abs();
    let change = (values[2].abs() * reach + slope) * reach;
    (rest * values[0] < 0.0).then(|| (-off_axis, change / rest.abs()))
}

/// The distance of the origin from a point, a segment or a triangle.
pub(crate) fn distance_from_origin(corners: &[DVec3]) -> f64 {
    let segment = |a: DVec3, b: DVec3| {
        let along = b - a;
        let share = -a.dot(along) / along.length_squared();
        let share = if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        };
        (a + share * along).length()
    };
    match *corners {
        [a, b, c] => {
            let normal = (b - a).cross(c - a);
            let is_inside = |p: DVec3, q: DVec3| normal.dot((q - p).cross(-p)) >= 0.0;
            let sides = [(a, b), (b, c), (c, a)];
            if normal != DVec3::ZERO && sides.iter().all(|&(p, q)| is_inside(p, q)) {
                return a.dot(normal).abs() / normal.length();
            }
            sides
                .map(|(p, q)| segment(p, q))
                .into_iter()
                .fold(f64::INFINITY, f64::min)
        }
        [a, b] => segment(a, b),
        [a] => a.length(),
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{Program, Solid};

    fn surface(solid: &Solid) -> Surface {
        let program = Program::lower(solid).expect("valid");
        let mut all = program.surfaces().iter();
        *all.find(|s| !s.is_plane()).expect("a quadric")
    }

    /// A flat ellipsoid, cylinder or cone, turned, and the point of it that was above a
    /// point of the unit circle at a height.
    fn flat(kind: usize, thin: f64) -> (Surface, impl Fn(f64, f64) -> DVec3) {
        let solid = match kind {
            0 => Solid::ellipsoid([1.0, thin, 0.8]),
            1 => Solid::elliptic_cylinder([1.0, thin], -1.0..1.0),
            _ => Solid::frustum(1.0, 0.0, 0.0..1.0).scale_xyz([1.0, thin, 1.0]),
        };
        let turn = DMat3::from_rotation_z(1.1) * DMat3::from_rotation_x(0.4);
        let place = move |angle: f64, z: f64| {
            let (radius, z) = match kind {
                0 => ((1.0 - z * z).sqrt(), 0.8 * z),
                1 => (1.0, z),
                _ => (1.0 - z, z),
            };
            turn * DVec3::new(radius * angle.cos(), thin * radius * angle.sin(), z)
        };
        (surface(&solid.rotate_x(0.4).rotate_z(1.1)), place)
    }

    proptest! {
        /// No sampled point of a triangle is farther off than the bound by the way from the
        /// centre or axis, which leads to the surface; and the bound is hardly too large.
        #[test]
        fn the_ways_from_the_centre_bound_the_distance(
            kind in 0usize..3,
            thin in -4.0..-1.0f64,
            angle in 0.0..6.0f64,
            height in -0.5..0.5f64,
            spread in prop::array::uniform3(prop::array::uniform2(-0.3..0.3f64)),
        ) {
            let thin = 10f64.powf(thin);
            let (surface, place) = flat(kind, thin);
            let round = Round::of(&surface, f64::INFINITY).expect("elongated");
            let corners = spread.map(|[a, h]| place(angle + a, height + h));
            let bound = round.bound(&corners);
            let (mut farthest, mut longest) = (0.0f64, 0.0f64);
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                    let point = corners[0] + u * (corners[1] - corners[0])
                        + v * (corners[2] - corners[0]);
                    let projected = round.project(point).expect("not the centre");
                    // Coefficients know the thinnest axis to so many roundings.
                    let share = round.share(projected).expect("no apex").length();
                    prop_assert!((share - 1.0).abs() < 1e-14 / (thin * thin), "{share}");
                    farthest = farthest.max(point.distance(projected));
                    let share = round.share(point).expect("no apex").length();
                    longest = longest.max(1.0 / share - 1.0);
                }
            }
            let spokes = corners.iter().map(|&c| round.spoke(c).length());
            let spoke = spokes.fold(0.0, f64::max);
            prop_assert!(farthest <= bound * (1.0 + 1e-9) + 1e-14 / (thin * thin));
            prop_assert!(bound <= 1.3 * longest * spoke + 1e-9, "{bound}, {longest}");
        }
    }

    #[test]
    fn only_elongated_quadrics_are_made_round() {
        let of = |solid: Solid| Round::of(&surface(&solid), f64::INFINITY);
        assert!(of(Solid::sphere(3.0)).is_none());
        assert!(of(Solid::ellipsoid([3.0, 3.0, 0.9])).is_none());
        assert!(of(Solid::ellipsoid([3.0, 3.0, 0.3])).is_some());
        assert!(of(Solid::cylinder(1.0, 0.0..1.0)).is_none());
        assert!(of(Solid::elliptic_cylinder([1.0, 0.1], 0.0..1.0)).is_some());
        assert!(of(Solid::infinite_cone(0.01)).is_none());
        assert!(of(Solid::infinite_cone(1.0).scale_xyz([1.0, 0.1, 1.0])).is_some());
        assert!(of(Solid::paraboloid([1.0, 0.01])).is_none());
        assert!(of(Solid::hyperboloid_one_sheet([1.0, 0.01, 1.0])).is_none());
    }

    #[test]
    fn distances_from_the_origin() {
        let [x, y] = [DVec3::X, DVec3::Y];
        let half = 0.5f64.sqrt();
        assert!((distance_from_origin(&[x, y]) - half).abs() < 1e-15);
        assert!((distance_from_origin(&[x, x, y]) - half).abs() < 1e-15);
        let third = (1.0f64 / 3.0).sqrt();
        assert!((distance_from_origin(&[x, y, DVec3::Z]) - third).abs() < 1e-15);
        assert_eq!(distance_from_origin(&[x, y, -x - y]), 0.0);
        assert_eq!(distance_from_origin(&[2.0 * x, 3.0 * x, 2.0 * x + y]), 2.0);
    }
}
