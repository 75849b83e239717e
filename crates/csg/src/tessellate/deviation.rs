//! How far a triangle strays from its surface, and a chord from its curve:
//! bounds, not samples.
//!
//! Along a chord or over a triangle a quadric f is a quadratic polynomial, and
//! a component of its gradient a linear one: the extremes of their ratio are
//! known in closed form, or nearly. From a point x the flow along the gradient
//! comes to f = 0 within |f(x)| / g if |∇f| >= g on its way; that is so for
//! g = |∇f(x)| - L D, where D is any bound of the way and L how fast the gradient
//! shrinks on it at most: the greatest eigenvalue of f's Hessian on the way down from
//! f > 0, minus the least one on the way up from f < 0 ([`Shrinkage`]). On fine triangles
//! |f| is of second order and L D beside the gradient as well, so that the bound is tight
//! but for a relative error of second order. Where the quadratic form is semidefinite, as
//! of spheres and cylinders, f or -f is convex: a triangle lies within, and on the
//! way out of there the gradient only grows (but for rounding), so that L is 0. Of a flat
//! cone it is little within, where nearly all of a triangle is.
//!
//! # The other direction
//! Where the gradient at no point of a triangle is at a right angle to its
//! normal, the flow maps the triangle onto a patch of the surface one to one.
//! The patches of neighbours meet along the images of their common edges, those
//! at a curve within the sliver between the curve and its chords; as the mesh is
//! closed, they cover the whole boundary. Every point of the boundary is then
//! the image of a point of the mesh that is as near as the bound says, or lies
//! in such a sliver, all of which is as near to the curve's chords as
//! [`of_chord`] says. What this rests on is that the mesh has the boundary's
//! topology. Around a cone's apex all this holds for a mesh of which vertices next to
//! the apex are moved there, and no point is moved by more than these.

mod chord;

use glam::DVec3;

pub(crate) use self::chord::of_chord;
use crate::program::Surface;

/// The spectral norm of the Hessian of f, or a little more: its largest sum of
/// magnitudes in a row, or its Frobenius norm.
fn hessian_norm(surface: &Surface) -> f64 {
    let [xx, yy, zz, xy, yz, zx] = surface.quadratic.map(f64::abs);
    let rows = (2.0 * xx + xy + zx)
        .max(2.0 * yy + xy + yz)
        .max(2.0 * zz + yz + zx);
    let squares = 4.0 * (xx * xx + yy * yy + zz * zz) + 2.0 * (xy * xy + yz * yz + zx * zx);
    rows.min(squares.sqrt())
}

/// How fast the gradient shrinks on the way from a triangle to the surface, at
/// most: the L of this module's beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shrinkage {
    /// On the way up, where f < 0.
    up: f64,
    /// On the way down, where f > 0.
    down: f64,
}

impl Shrinkage {
    /// Where the way leads only out of a convex set.
    pub const NONE: Self = Self { up: 0.0, down: 0.0 };

    pub fn of(surface: &Surface) -> Self {
        if surface.definiteness().is_some() {
            return Self::NONE;
        }
        let values = surface.standard_form().values;
        let most = |sign: f64| values.into_iter().fold(0.0f64, |m, v| m.max(sign * v));
        Self {
            up: 2.0 * most(-1.0),
            down: 2.0 * most(1.0),
        }
    }
}

/// The distance of a point to a surface, to first order.
pub(super) fn first_order(surface: &Surface, at: DVec3) -> f64 {
    surface.value(at).abs() / surface.gradient(at).length()
}

/// The largest |Σ 2 b_ij λ_i λ_j| over the triangle λ >= 0, Σ λ = 1, for
/// b = (b01, b12, b20): the middles of the edges and, where it lies inside, the
/// stationary point.
#[inline]
fn largest_on_triangle([a, b, c]: [f64; 3]) -> f64 {
    /// Of the square of what is on the edges: where the sum of weights is less, rounding alone
    /// may have made it, and inside there is no more than on the edges but for as much.
    const NO_WEIGHT: f64 = 1e-12;
    let on_edges = 0.5 * a.abs().max(b.abs()).max(c.abs());
    let weights = [b * (a + c - b), c * (a + b - c), a * (b + c - a)];
    let sum: f64 = weights.iter().sum();
    let is_inside = weights.iter().all(|w| w * sum >= 0.0);
    if is_inside && sum.abs() > NO_WEIGHT * on_edges * on_edges {
        on_edges.max((2.0 * a * b * c / sum).abs())
    } else {
        on_edges
    }
}

/// The largest |f| of a triangle's points if it is none at the corners.
#[inline(always)]
pub(super) fn largest_inside(surface: &Surface, [p, q, r]: [DVec3; 3]) -> f64 {
    let quarter = |d: DVec3| -0.25 * surface.curvature_along(d);
    largest_on_triangle([quarter(q - p), quarter(r - q), quarter(p - r)])
}

/// A bound of the distance of any point of the triangle to the surface; of
/// corners on it, or near it. Infinite where none could be proven: the
/// triangle is too large for the surface's curvature.
#[must_use]
pub(crate) fn of_triangle(surface: &Surface, corners: [DVec3; 3]) -> f64 {
    with_shrinkage(surface, Shrinkage::of(surface), corners)
}

/// The same of a surface whose shrinkage is known.
pub(super) fn with_shrinkage(surface: &Surface, shrinkage: Shrinkage, corners: [DVec3; 3]) -> f64 {
    let bound = along_gradient(surface, shrinkage, corners);
    let apex = surface.apex().filter(|&apex| {
        let is_near = |corner: &DVec3| corner.distance(apex) < bound;
        corners.iter().any(is_near)
    });
    apex.map_or(bound, |apex| {
        bound.min(over_apex(surface, shrinkage, apex, corners))
    })
}

/// The same for a triangle that goes by a cone's apex so closely that gradients turn
/// too far along it: with the nearest corner moved there, or two of them, no point of
/// it is moved by more than these.
fn over_apex(surface: &Surface, shrinkage: Shrinkage, apex: DVec3, mut corners: [DVec3; 3]) -> f64 {
    corners.sort_unstable_by(|a, b| a.distance(apex).total_cmp(&b.distance(apex)));
    let [nearest, second, farthest] = corners;
    let with_tip = along_gradient(surface, shrinkage, [apex, second, farthest]);
    // On a ruling but for rounding.
    let folded = along_gradient(surface, shrinkage, [apex, farthest, farthest]);
    let bounds = [
        nearest.distance(apex) + with_tip,
        second.distance(apex) + folded,
    ];
    bounds[0].min(bounds[1])
}

/// A bound of the distance by the flow along the gradient.
fn along_gradient(surface: &Surface, shrinkage: Shrinkage, corners: [DVec3; 3]) -> f64 {
    let mut corners = corners.map(|at| Corner::new(surface, at));
    if surface.is_plane() {
        let off = corners.map(|corner| corner.value.abs());
        return off[0].max(off[1]).max(off[2]);
    }
    let mut quarters = quarters(surface, corners.each_ref());
    if let Some(apex) = surface.apex()
        && let Some(tip) = corners.iter().position(|corner| corner.at == apex)
    {
        // f is homogeneous about the apex, and so is the distance: it is the
        // largest on the opposite side.
        let opposite = (tip + 1) % 3;
        quarters = [quarters[opposite], 0.0, 0.0];
        let (u, w) = (corners[opposite].gradient, corners[(tip + 2) % 3].gradient);
        for (corner, gradient) in corners.iter_mut().zip([u, w, w]) {
            corner.gradient = gradient;
        }
    }
    let along = towards_farthest(&corners, quarters);
    Ratio::new(shrinkage, corners.each_ref(), quarters, along).bound()
}

/// Whether a triangle is as near to its surface as a distance, by a bound that
/// is mostly a little looser than [`of_triangle`] and costs half as much: if not,
/// it may still be. `shrinkage` is that of the surface.
#[inline]
pub(super) fn is_within(
    surface: &Surface,
    shrinkage: Shrinkage,
    [p, q, r]: [DVec3; 3],
    distance: f64,
) -> bool {
    let corner = |at| Corner::new(surface, at);
    let corners = [corner(p), corner(q), corner(r)];
    let quarters = quarters(surface, corners.each_ref());
    let along = towards_farthest(&corners, quarters);
    let ratio = Ratio::new(shrinkage, corners.each_ref(), quarters, along);
    ratio.loosely(distance) <= distance
}

/// The corner of a triangle: where it is, and f and its gradient there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub at: DVec3,
    pub gradient: DVec3,
    value: f64,
}

impl Corner {
    #[inline(always)]
    pub fn new(surface: &Surface, at: DVec3) -> Self {
        Self {
            at,
            gradient: surface.gradient(at),
            value: surface.value(at),
        }
    }
}

/// f over the triangle is Σ 2 b_ij λ_i λ_j plus what it is at the corners:
/// b01, b12, b20.
#[inline(always)]
pub(super) fn quarters(surface: &Surface, [p, q, r]: [&Corner; 3]) -> [f64; 3] {
    let quarter = |d: DVec3| -0.25 * surface.curvature_along(d);
    [
        quarter(q.at - p.at),
        quarter(r.at - q.at),
        quarter(p.at - r.at),
    ]
}

/// The gradient's direction about where the triangle is farthest off, and any
/// direction will do: the middles of the edges along which f bends most.
#[inline(always)]
fn towards_farthest(corners: &[Corner; 3], quarters: [f64; 3]) -> DVec3 {
    let [u, v, w] = corners.map(|corner| corner.gradient);
    let [uv, vw, wu] = quarters.map(f64::abs);
    let sum = (wu + uv) * u + (uv + vw) * v + (vw + wu) * w;
    sum.try_normalize().unwrap_or_else(|| u.normalize_or_zero())
}

/// The map from a distance from the triangle to a bound of that of the surface,
/// if the way to it is not longer.
///
/// With f = Σ 2 b_ij λ_i λ_j and the slope Σ s_i λ_i >= (Σ √s_i λ_i)² by Cauchy
/// and Schwarz: in terms of √s_i λ_i their ratio is one of quadratic forms
/// again.
pub(super) struct Ratio {
    slopes: [f64; 3],
    least: f64,
    greatest: f64,
    /// Where f < 0 and where f > 0; or both in the first, where these do not differ.
    parts: [Part; 2],
}

/// What of f is on one side of the surface.
#[derive(Clone, Copy)]
struct Part {
    shrinkage: f64,
    quarters: [f64; 3],
    at_corners: f64,
}

impl Part {
    fn is_none(&self) -> bool {
        self.quarters == [0.0; 3] && self.at_corners == 0.0
    }
}

impl Ratio {
    #[inline(always)]
    pub fn new(
        shrinkage: Shrinkage,
        corners: [&Corner; 3],
        quarters: [f64; 3],
        along: DVec3,
    ) -> Self {
        let gradients = corners.map(|corner| corner.gradient);
        // The gradient's component along any direction is linear.
        let slopes = gradients.map(|gradient| gradient.dot(along));
        let values = corners.map(|corner| corner.value);
        let parts = if shrinkage.up == shrinkage.down {
            let all = Part {
                shrinkage: shrinkage.up,
                quarters,
                at_corners: values.into_iter().fold(0.0, |m, v| v.abs().max(m)),
            };
            let none = Part {
                shrinkage: 0.0,
                quarters: [0.0; 3],
                at_corners: 0.0,
            };
            [all, none]
        } else {
            [
                Part {
                    shrinkage: shrinkage.up,
                    quarters: quarters.map(|b| b.min(0.0)),
                    at_corners: values.into_iter().fold(0.0, |m, v| m.max(-v)),
                },
                Part {
                    shrinkage: shrinkage.down,
                    quarters: quarters.map(|b| b.max(0.0)),
                    at_corners: values.into_iter().fold(0.0, f64::max),
                },
            ]
        };
        Self {
            slopes,
            least: slopes[0].min(slopes[1]).min(slopes[2]),
            greatest: slopes[0].max(slopes[1]).max(slopes[2]),
            parts,
        }
    }

    /// The larger of what a bound is of both parts.
    #[inline(always)]
    fn larger(&self, bound: impl Fn(&Part) -> f64) -> f64 {
        let [first, second] = &self.parts;
        let of_first = bound(first);
        if second.is_none() {
            of_first
        } else {
            of_first.max(bound(second))
        }
    }

    fn bound(&self) -> f64 {
        self.larger(|part| shrunk(|distance| self.of_part(part, distance)))
    }

    #[inline(always)]
    pub fn of(&self, distance: f64) -> f64 {
        self.larger(|part| self.of_part(part, distance))
    }

    /// The same with the least slope all over the triangle.
    #[inline(always)]
    fn loosely(&self, distance: f64) -> f64 {
        self.larger(|part| {
            let least = self.least - part.shrinkage * distance;
            if least <= 0.0 {
                return f64::INFINITY;
            }
            (largest_on_triangle(part.quarters) + part.at_corners) / least
        })
    }

    #[inline(always)]
    fn of_part(&self, part: &Part, distance: f64) -> f64 {
        let less = part.shrinkage * distance;
        let least = self.least - less;
        if least <= 0.0 {
            return f64::INFINITY;
        }
        if self.greatest <= 1.01 * least {
            return (largest_on_triangle(part.quarters) + part.at_corners) / least;
        }
        let [b01, b12, b20] = part.quarters;
        let [r0, r1, r2] = self.slopes.map(|slope| (slope - less).sqrt());
        let scaled = [b01 / (r0 * r1), b12 / (r1 * r2), b20 / (r2 * r0)];
        largest_on_triangle(scaled) + part.at_corners / least
    }
}

/// A distance that a map shrinks is a bound, and so is its image: of a map from
/// a distance to a bound of that of the surface, if the way to it is not longer.
/// Infinite if none is found.
#[inline(always)]
fn shrunk(map: impl Fn(f64) -> f64) -> f64 {
    let guess = 1.25 * map(0.0);
    let bound = map(guess);
    if bound <= guess {
        bound
    } else if map(2.0 * bound) <= 2.0 * bound {
        map(2.0 * bound)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Program, Solid};
    use proptest::prelude::*;

    fn surfaces(solid: &Solid) -> Vec<Surface> {
        Program::lower(solid).expect("valid").surfaces().to_vec()
    }

    fn curved(solid: &Solid) -> Surface {
        let mut all = surfaces(solid).into_iter();
        all.find(|s| !s.is_plane()).expect("a quadric")
    }

    /// The points of a fine lattice on the triangle.
    fn samples([p, q, r]: [DVec3; 3]) -> impl Iterator<Item = DVec3> {
        const N: u32 = 60;
        (0..=N).flat_map(move |i| {
            (0..=N - i).map(move |j| {
                let (a, b) = (f64::from(i) / f64::from(N), f64::from(j) / f64::from(N));
                p + a * (q - p) + b * (r - p)
            })
        })
    }

    /// The bound holds, and exceeds the largest sampled distance at most
    /// `slack` times.
    fn assert_tight(
        surface: &Surface,
        corners: [DVec3; 3],
        distance: impl Fn(DVec3) -> f64,
        slack: f64,
    ) {
        let sampled = samples(corners).map(distance).fold(0.0, f64::max);
        let bound = of_triangle(surface, corners);
        assert!(sampled <= bound + 1e-15, "{sampled} > {bound}");
        assert!(
            bound <= slack * sampled + 1e-15,
            "{bound}, sampled {sampled}"
        );
    }

    #[test]
    fn planes_have_none() {
        let plane = surfaces(&Solid::cube(2.0))[0];
        let normal = plane.gradient(DVec3::ZERO);
        let (u, v) = normal.any_orthonormal_pair();
        let o = plane.anchor();
        let corners = [o, o + u, o + 0.3 * u + v];
        assert!(of_triangle(&plane, corners) < 1e-15);
    }

    fn on_sphere(p: DVec3) -> DVec3 {
        p.normalize()
    }

    proptest! {
        #[test]
        fn spheres(
            centre in prop::array::uniform3(-1.0..1.0f64),
            spread in prop::array::uniform3(prop::array::uniform3(-1.0..1.0f64)),
            size in 1e-3..0.1f64,
        ) {
            let sphere = curved(&Solid::sphere(1.0));
            let centre = DVec3::from(centre);
            prop_assume!(centre.length() > 0.1);
            let corners = spread.map(|s| on_sphere(on_sphere(centre) + size * DVec3::from(s)));
            assert_tight(&sphere, corners, |p| 1.0 - p.length(), 1.05);
        }

        #[test]
        fn cylinders(
            angles in prop::array::uniform3(-0.1..0.1f64),
            heights in prop::array::uniform3(-0.9..0.9f64),
        ) {
            let cylinder = curved(&Solid::cylinder(1.0, -1.0..1.0));
            let corners = [0, 1, 2].map(|i| {
                DVec3::new(angles[i].cos(), angles[i].sin(), heights[i])
            });
            assert_tight(&cylinder, corners, |p| 1.0 - p.truncate().length(), 1.05);
        }

        #[test]
        fn cones_with_and_without_their_tip(
            angles in prop::array::uniform3(-0.1..0.1f64),
            heights in prop::array::uniform3(0.3..0.9f64),
            tip in prop::bool::ANY,
        ) {
            // A cone of radius 1 at z = 0 and apex at z = 1.
            let cone = curved(&Solid::frustum(1.0, 0.0, 0.0..1.0));
            let mut corners = [0, 1, 2].map(|i| {
                let r = 1.0 - heights[i];
                DVec3::new(r * angles[i].cos(), r * angles[i].sin(), heights[i])
            });
            if tip {
                corners[1] = DVec3::Z;
            }
            let distance = |p: DVec3| {
                (1.0 - p.z - p.truncate().length()) * std::f64::consts::FRAC_1_SQRT_2
            };
            assert_tight(&cone, corners, distance, 1.3);
        }

        /// Some corners so near to the tip that the triangle goes around it.
        #[test]
        fn cones_around_their_tip(
            angles in prop::array::uniform3(0.0..6.3f64),
            exponents in prop::array::uniform3(0.0..12.0f64),
        ) {
            let cone = curved(&Solid::frustum(1.0, 0.0, 0.0..1.0));
            let radii = exponents.map(|e| 0.5 * 10f64.powf(-e));
            let corners = [0, 1, 2].map(|i| {
                DVec3::new(radii[i] * angles[i].cos(), radii[i] * angles[i].sin(), 1.0 - radii[i])
            });
            let distance = |p: DVec3| {
                (1.0 - p.z - p.truncate().length()) * std::f64::consts::FRAC_1_SQRT_2
            };
            let bound = of_triangle(&cone, corners);
            let sampled = samples(corners).map(distance).fold(0.0, f64::max);
            prop_assert!(sampled <= bound + 1e-15, "{sampled} > {bound}");
            // No farther than from the farther one of the corners near the tip.
            let mut from_tip = corners.map(|c| c.distance(DVec3::Z));
            from_tip.sort_by(f64::total_cmp);
            prop_assert!(bound <= 1.01 * from_tip[1] + 1e-15, "{bound}, {from_tip:?}");
        }

        #[test]
        fn saddles_are_bounded(
            at in prop::array::uniform2(-0.5..0.5f64),
            spread in prop::array::uniform3(prop::array::uniform2(-0.05..0.05f64)),
        ) {
            // z = x y, from the quadric x y - z = 0.
            let coefficients = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0];
            let saddle = surfaces(&Solid::quadric(coefficients))[0];
            let corners = spread.map(|[x, y]| {
                let (x, y) = (at[0] + x, at[1] + y);
                DVec3::new(x, y, x * y)
            });
            let bound = of_triangle(&saddle, corners);
            for p in samples(corners) {
                // To first order, and the second is far below the slack.
                let distance = saddle.value(p).abs() / saddle.gradient(p).length();
                prop_assert!(distance <= 1.01 * bound + 1e-15, "{distance} > {bound}");
            }
        }

        #[test]
        fn chords_of_circles_and_ellipses(
            start in 0.0..6.3f64,
            angle in 1e-3..0.2f64,
            tilt in 0.0..1.0f64,
        ) {
            // x² + y² = 1 cut by z = tilt x.
            let cylinder = curved(&Solid::cylinder(1.0, -3.0..3.0));
            let normal = DVec3::new(-tilt, 0.0, 1.0);
            let plane = surfaces(&Solid::half_space(normal, 0.0))[0];
            let on_curve = |t: f64| DVec3::new(t.cos(), t.sin(), tilt * t.cos());
            let (p, q) = (on_curve(start), on_curve(start + angle));
            let bound = of_chord([&cylinder, &plane], p, q);
            let mut largest = 0.0f64;
            for i in 1..40 {
                let point = p + f64::from(i) / 40.0 * (q - p);
                let nearest = (0..=400)
                    .map(|j| on_curve(start + angle * f64::from(j) / 400.0).distance(point))
                    .fold(f64::MAX, f64::min);
                largest = largest.max(nearest);
            }
            // The nearest of the samples on the curve is a little off.
            let step = 1.5 * angle / 400.0;
            prop_assert!(largest * largest <= bound * bound + step * step);
            prop_assert!(bound <= 1.1 * largest, "{bound}, sampled {largest}");
        }
    }

    proptest! {
        #[test]
        fn chords_of_crossing_pipes(
            start in 0.0..6.3f64,
            angle in 1e-3..0.2f64,
            radius in 0.3..0.98f64,
        ) {
            let wide = curved(&Solid::cylinder(1.0, -3.0..3.0));
            // About the x axis.
            let coefficients = [0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -radius * radius];
            let narrow = surfaces(&Solid::quadric(coefficients))[0];
            let on_curve = |t: f64| {
                let (y, z) = (radius * t.cos(), radius * t.sin());
                DVec3::new((1.0 - y * y).sqrt(), y, z)
            };
            let (p, q) = (on_curve(start), on_curve(start + angle));
            let bound = of_chord([&wide, &narrow], p, q);
            let mut largest = 0.0f64;
            for i in 1..20 {
                let point = p + f64::from(i) / 20.0 * (q - p);
                let nearest = (0..=400)
                    .map(|j| on_curve(start + angle * f64::from(j) / 400.0).distance(point))
                    .fold(f64::MAX, f64::min);
                largest = largest.max(nearest);
            }
            // The nearest of the samples on the curve is a little off.
            let step = 1.5 * angle / 400.0 / (1.0 - radius * radius).sqrt();
            prop_assert!(largest * largest <= bound * bound + step * step);
            prop_assert!(bound <= 1.5 * largest + step, "{bound}, sampled {largest}");
        }
    }

    /// However small the angle between the surfaces is.
    #[test]
    fn chords_along_rulings_that_two_surfaces_have_in_common_are_exact() {
        for width in [0.5, 2e-3, 2e-5, 2e-7] {
            let cylinder = |side: f64| {
                let solid = Solid::cylinder(1.0, -5.0..5.0);
                curved(&solid.translate([side * (1.0 - 0.5 * width), 0.0, 0.0]))
            };
            let [left, right] = [-1.0, 1.0].map(cylinder);
            let y = (width - 0.25 * width * width).sqrt();
            let ends = [-4.0, 4.0].map(|z| DVec3::new(0.0, y, z));
            let bound = of_chord([&left, &right], ends[0], ends[1]);
            assert!(bound < 1e-11, "{width}: {bound}");
        }
    }

    /// Though gradients grow along them.
    #[test]
    fn chords_along_rulings_of_cones_with_one_apex_are_exact() {
        for angle in [1.0, 2e-3, 2e-5] {
            let cone = Solid::frustum(2.0, 0.0, -2.0..0.0);
            let pair = [curved(&cone), curved(&cone.rotate_x(angle))];
            // z is the same in both frames.
            let slope = (0.5 * angle).tan();
            let along = DVec3::new((1.0 - slope * slope).sqrt(), -slope, 1.0);
            let bound = of_chord([&pair[0], &pair[1]], -1.75 * along, -0.5 * along);
            assert!(bound < 1e-10, "{angle}: {bound}");
        }
    }

    #[test]
    fn what_cannot_be_bounded_is_said() {
        let sphere = curved(&Solid::sphere(1.0));
        // Three points on a great circle: the centre is on the triangle.
        let corners = [DVec3::X, DVec3::NEG_X, DVec3::Y];
        assert_eq!(of_triangle(&sphere, corners), f64::INFINITY);
    }
}
