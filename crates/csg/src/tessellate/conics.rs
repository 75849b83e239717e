//! The conics among the curves in which two surfaces meet.
//!
//! They are what a plane has in common with a quadric, and two quadrics with
//! each other if some combination of them is a plane or a pair of planes. As a
//! function x(t) of the parameters of [`Curve`] all of them have |x′ × x″| the
//! same everywhere, so that a chord over a short interval δ strays by
//! δ² |x′ × x″| / 8 |x′|: where to cut one into chords that stray alike, which
//! [`super::curves`] finds by steps for any curve, takes here no more than the
//! length of x′ at some places.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::course::Course;
use super::curves::on_curve;
use super::goal::Goal;
use crate::arrangement::{Curve, conics};
use crate::numeric::eigen_symmetric;
use crate::numeric::tolerance::{
    CANCELLED, NEAR, NEAR_OF_REFINED, ON_CONIC, TOUCHING, TOUCHING_AT_ENDS,
};
use crate::program::Surface;
use crate::surface::round::{LEAST_ASPECT, Round};
use crate::surface::solve;

/// An ellipse, a parabola, or a branch of a hyperbola.
pub(super) struct Conic {
    curve: Curve,
    /// The plane in which it lies.
    plane: Surface,
    /// |x′ × x″|.
    bend: f64,
}

/// The plane in which two quadrics a and b meet along a row of points common to
/// them, if they do.
///
/// A combination a - λ b that is a pair of planes vanishes along the line
/// through two points of one of the planes, which tells λ; its gradient there
/// is that plane's normal. There is none where the line is in both planes: they cross in it, or
/// are one, in which the quadrics touch. Then both are those of the form's axes, and the other
/// points tell which is meant.
fn common_plane([a, b]: [&Surface; 2], points: &[DVec3]) -> Option<Surface> {
    let p = *points.first()?;
    let off = |q: &DVec3| q.distance_squared(p);
    let q = points
        .iter()
        .copied()
        .max_by(|q, r| off(q).total_cmp(&off(r)))?;
    let along = q - p;
    let [bend_a, bend_b] = [a, b].map(|s| s.curvature_along(along));
    // A chord of neither, but for rounding.
    if bend_b.abs() <= TOUCHING * along.length_squared() {
        return None;
    }
    let factor = bend_a / bend_b;
    let scale = 1.0 + factor.abs();
    // A third of the way: the middle may lie in the other plane too.
    let anchor = p + along / 3.0;
    let normal = a.gradient(anchor) - factor * b.gradient(anchor);
    let size = a.gradient(anchor).length() + factor.abs() * b.gradient(anchor).length();
    let normal = if normal.length() > TOUCHING_AT_ENDS * size {
        normal.normalize_or_zero()
    } else {
        let (values, axes) = eigen_symmetric(std::array::from_fn(|k| {
            a.quadratic[k] - factor * b.quadratic[k]
        }));
        let values = DVec3::from(values);
        let [most, least] = [values.max_position(), values.min_position()];
        // μ (m·x)² - ν (n·x)² with μ, ν >= 0.
        let half = |axis: usize| values[axis].abs().sqrt() * axes.col(axis);
        let normals = [half(most) + half(least), half(most) - half(least)];
        let farthest = |normal: &DVec3| {
            let offs = points.iter().map(|point| (*point - p).dot(*normal).abs());
            offs.fold(0.0, f64::max)
        };
        let [one, other] = normals.map(DVec3::normalize_or_zero);
        if farthest(&one) <= farthest(&other) {
            one
        } else {
            other
        }
    };
    let (u, v) = normal.any_orthonormal_pair();
    let bends = [u, v, u + v].map(|d| a.curvature_along(d) - factor * b.curvature_along(d));
    let vanishes = bends.iter().all(|bend| bend.abs() <= CANCELLED * scale);
    vanishes.then_some(Surface::plane(anchor, normal))
}

impl Conic {
    /// The one of two surfaces that goes through the vertices of a chain.
    pub fn through(
        surfaces: [&Surface; 2],
        vertices: &[DVec3],
        is_long: bool,
        precision: f64,
    ) -> Option<(Self, Vec<f64>)> {
        let [a, b] = surfaces;
        let (plane, quadric) = if a.is_plane() {
            (*a, b)
        } else if b.is_plane() {
            (*b, a)
        } else {
            (common_plane(surfaces, vertices)?, a)
        };
        let curves = conics(&plane, quadric, NEAR_OF_REFINED * precision).into_iter();
        let mut conics = curves.filter_map(|curve| Self::new(curve, plane));
        conics.find_map(|conic| {
            let blur = |at: DVec3| {
                let blurs = surfaces.iter().filter(|_| is_long);
                let blurs = blurs.map(|s| solve::blur(s, at));
                blurs.fold(precision, f64::max)
            };
            let stops = conic.parameters(vertices, |at| ON_CONIC * blur(at))?;
            Some((conic, stops))
        })
    }

    /// None for lines.
    fn new(curve: Curve, plane: Surface) -> Option<Self> {
        let bend = match curve {
            Curve::Ellipse { a, b, .. } | Curve::Hyperbola { a, b, .. } => a.cross(b).length(),
            Curve::Parabola { a, b, .. } => 2.0 * a.cross(b).length(),
            Curve::Line { .. } | Curve::Rulings(_) => return None,
        };
        Some(Self { curve, plane, bend })
    }

    /// Into how many chords a unit of the parameter of a long ellipse is to be cut, for
    /// these to be near to it on the rays from its centre; 0 for others.
    fn at_ends(&self, t: f64, tolerance: f64) -> f64 {
        let Curve::Ellipse { center, a, b } = self.curve else {
            return 0.0;
        };
        // a² + b² of the half axes by their product.
        let aspect = (a.length_squared() + b.length_squared()) / self.bend;
        if aspect < LEAST_ASPECT {
            return 0.0;
        }
        (self.curve.at(t).distance(center) / (8.0 * tolerance)).sqrt()
    }

    fn is_circle(&self) -> bool {
        let Curve::Ellipse { a, b, .. } = self.curve else {
            return false;
        };
        let (aa, bb) = (a.length_squared(), b.length_squared());
        (aa - bb).abs().max(a.dot(b).abs()) <= NEAR * aa
    }

    /// The parameter of a point on it, of an ellipse up to whole turns.
    fn parameter(&self, point: DVec3) -> f64 {
        self.curve.place(point).unwrap_or(f64::NAN)
    }

    /// The parameters of vertices in a row along it, none farther from the one
    /// before than half a turn; `None` if they are not.
    fn parameters(&self, vertices: &[DVec3], limit: impl Fn(DVec3) -> f64) -> Option<Vec<f64>> {
        /// So much of half a turn is still clearly less.
        const CLEARLY: f64 = 0.95;
        let is_periodic = self.curve.is_closed();
        let mut row: Vec<f64> = Vec::with_capacity(vertices.len());
        for &vertex in vertices {
            let mut t = self.parameter(vertex);
            if self.curve.at(t).distance_squared(vertex) > limit(vertex).powi(2) {
                return None;
            }
            if let Some(&before) = row.last().filter(|_| is_periodic) {
                t += TAU * ((before - t) / TAU).round();
            }
            row.push(t);
        }
        let forward = row.last() > row.first();
        let fits = |w: &[f64]| {
            let step = if forward { w[1] - w[0] } else { w[0] - w[1] };
            step > 0.0 && !(is_periodic && step > CLEARLY * PI)
        };
        row.windows(2).all(fits).then_some(row)
    }
}

/// A measured part of a conic, with vertices along it.
pub(super) struct OnConic<'a> {
    surfaces: [&'a Surface; 2],
    conic: Conic,
    /// Whether rounding moves one of the surfaces farther than coordinates tell.
    is_long: bool,
    precision: f64,
    /// The parameters of the vertices.
    stops: Vec<f64>,
    /// Of the conic between places at equal steps of the parameter.
    step: f64,
    /// At each place how many chords there are in a unit of the parameter, and
    /// up to there.
    places: Vec<(f64, f64)>,
    /// Whether all chords are alike: those of a circle, unless angles ask for more
    /// here and there.
    is_even: bool,
}

impl<'a> OnConic<'a> {
    /// `None` if the vertices do not lie in a row along a conic.
    pub fn new(
        surfaces: [&'a Surface; 2],
        vertices: &[DVec3],
        rounds: [Option<&Round>; 2],
        goal: &Goal,
        precision: f64,
    ) -> Option<Self> {
        /// Between two places, in radians or what comes near it.
        const STEP: f64 = 0.2;
        const MOST_STEPS: f64 = 256.0;
        let is_long = rounds.iter().any(Option::is_some);
        let (conic, stops) = Conic::through(surfaces, vertices, is_long, precision)?;
        let (from, to) = (stops[0], stops[stops.len() - 1]);
        let is_even = conic.is_circle() && goal.angle.is_none();
        let count = if is_even {
            1.0
        } else {
            ((to - from).abs() / STEP).ceil().clamp(1.0, MOST_STEPS)
        };
        let step = (to - from) / count;
        let mut places: Vec<(f64, f64)> = Vec::with_capacity(count as usize + 1);
        for i in 0..=count as u32 {
            let t = from + f64::from(i) * step;
            let along = conic.curve.direction(t);
            let for_distance = (conic.bend / (8.0 * goal.tolerance * along.length())).sqrt();
            let rounds = rounds.iter().copied().flatten();
            let on_rounds =
                rounds.map(|r| r.chords_along(conic.curve.at(t), along, goal.tolerance));
            let for_distance = on_rounds.fold(for_distance, f64::max);
            let for_distance = for_distance.max(conic.at_ends(t, goal.tolerance));
            let for_angle = goal.angle.map_or(0.0, |angle| {
                let at = conic.curve.at(t);
                // H x′, from the gradient's change along x′.
                let turns = surfaces.map(|s| {
                    let gradient = s.gradient(at);
                    let change = s.gradient(at + along) - gradient;
                    change.reject_from(gradient).length() / gradient.length()
                });
                turns[0].max(turns[1]) / angle
            });
            let density = for_distance.max(for_angle);
            let sum = places.last().map_or(0.0, |&(before, sum)| {
                sum + 0.5 * (before + density) * step.abs()
            });
            places.push((density, sum));
        }
        let total = places.last()?.1;
        (total.is_finite() && total > 0.0).then_some(Self {
            surfaces,
            conic,
            is_long,
            precision,
            stops,
            step,
            places,
            is_even,
        })
    }

    fn point(&self, t: f64) -> Option<DVec3> {
        let point = self.conic.curve.at(t);
        let blurs = self.surfaces.iter().filter(|_| self.is_long);
        let blurs = blurs.map(|s| solve::blur(s, point));
        let blur = blurs.fold(0.0, f64::max);
        let is_on = |s: &Surface| {
            let limit = self.precision * self.precision * s.gradient(point).length_squared();
            s.value(point).powi(2) <= limit
        };
        if blur <= self.precision && self.surfaces.iter().all(|s| is_on(s)) {
            Some(point)
        } else {
            let reach = ON_CONIC * blur.max(self.precision);
            on_curve(self.surfaces, point, reach, self.precision)
        }
    }
}

impl Course for OnConic<'_> {
    fn chords(&self) -> f64 {
        self.places[self.places.len() - 1].1
    }

    fn shares(&self) -> Vec<f64> {
        let share = |&t: &f64| {
            let steps = (t - self.stops[0]) / self.step;
            let i = (steps as usize).min(self.places.len() - 2);
            let rest = steps - i as f64;
            let ((low, sum), (high, _)) = (self.places[i], self.places[i + 1]);
            let part = (low + 0.5 * (high - low) * rest) * rest * self.step.abs();
            (sum + part) / self.chords()
        };
        self.stops.iter().map(share).collect()
    }

    fn points(&self, chords: u32) -> Option<Vec<DVec3>> {
        let mut points = Vec::with_capacity(chords as usize);
        let mut i = 0;
        for k in 1..chords {
            let wanted = f64::from(k) / f64::from(chords) * self.chords();
            while i + 2 < self.places.len() && self.places[i + 1].1 < wanted {
                i += 1;
            }
            // The density between two places is linear: of the share x of a step
            // the integral is low x + (high - low) x² / 2.
            let ((low, sum), (high, _)) = (self.places[i], self.places[i + 1]);
            let left = (wanted - sum) / self.step.abs();
            let root = (low * low + 2.0 * (high - low) * left).max(0.0).sqrt();
            let steps = i as f64 + 2.0 * left / (low + root);
            points.push(self.point(self.stops[0] + steps * self.step)?);
        }
        Some(points)
    }

    fn is_even(&self) -> bool {
        self.is_even
    }

    fn surfaces(&self) -> [&Surface; 2] {
        let [a, b] = self.surfaces;
        if a.is_plane() || b.is_plane() {
            self.surfaces
        } else {
            [&self.conic.plane, a]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate::deviation;
    use crate::{Program, Solid};
    use rustc_hash::FxHashMap;

    /// The first two surfaces of two solids.
    fn surfaces(solids: [Solid; 2]) -> [Surface; 2] {
        solids.map(|solid| Program::lower(&solid).expect("valid").surfaces()[0])
    }

    /// Points along the curve of two surfaces near some others.
    fn along([a, b]: [&Surface; 2], near: &[[f64; 3]]) -> Vec<DVec3> {
        let point = |&p: &[f64; 3]| solve::common_point(&[a, b], p.into(), 1.0).point;
        near.iter().map(point).collect()
    }

    #[test]
    fn conics_are_cut_into_chords_that_stray_alike() {
        let rod = Solid::infinite_cylinder(1.0);
        let cone = Solid::infinite_cone(0.5);
        let level = |z: f64| Solid::half_space([0.0, 0.0, 1.0], z);
        let upright = Solid::half_space([1.0, 0.0, 0.0], 0.3);
        let slanted = Solid::half_space([-0.5, 0.0, 1.0], 0.4);
        let cases = [
            // A circle, with the chain around more than half of it.
            (
                [level(0.2), rod.clone()],
                vec![
                    [1.0, 0.0, 0.2],
                    [0.0, 1.0, 0.2],
                    [-1.0, 0.1, 0.2],
                    [-0.3, -1.0, 0.2],
                ],
            ),
            // Ellipses.
            (
                [slanted, rod.clone()],
                vec![[1.0, 0.0, 0.9], [0.0, 1.0, 0.4], [-1.0, 0.0, -0.1]],
            ),
            (
                [rod.clone(), rod.rotate_x(PI / 2.0)],
                vec![[0.9, 0.4, 0.4], [0.2, 0.9, 0.9]],
            ),
            // Two spheres: a circle.
            (
                [
                    Solid::sphere(1.0),
                    Solid::sphere(0.8).translate([0.6, 0.3, 0.1]),
                ],
                vec![[0.7, 0.5, 0.5], [0.7, -0.5, 0.5]],
            ),
            // A hyperbola.
            (
                [upright, cone],
                vec![[0.3, -1.0, 2.0], [0.3, 0.0, 0.6], [0.3, 2.0, 4.0]],
            ),
            // A parabola.
            (
                [
                    Solid::half_space([1.0, 0.0, 0.0], 0.3),
                    Solid::paraboloid([1.0, 1.0]),
                ],
                vec![[0.3, -1.0, 1.0], [0.3, 2.0, 4.0]],
            ),
        ];
        let goal = Goal {
            tight: FxHashMap::default(),
            tolerance: 1e-4,
            promised: 1e-4,
            even_curves: false,
            keeps_vertices: false,
            angle: None,
        };
        for (case, (solids, near)) in cases.into_iter().enumerate() {
            let surfaces = surfaces(solids);
            let pair = [&surfaces[0], &surfaces[1]];
            let vertices = along(pair, &near);
            let course = OnConic::new(pair, &vertices, [None; 2], &goal, 1e-12);
            let course = course.unwrap_or_else(|| panic!("case {case}: no conic"));
            let chords = course.chords().ceil();
            assert!(chords > 10.0, "case {case}: {chords}");
            let mut points = course.points(chords as u32).expect("points");
            points.insert(0, vertices[0]);
            points.push(vertices[vertices.len() - 1]);
            for (share, &vertex) in course.shares().into_iter().zip(&vertices) {
                let off = |k: &usize| points[*k].distance(vertex);
                let nearest = (0..points.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
                let nearest = nearest.expect("points") as f64;
                assert!((nearest - share * chords).abs() < 0.6, "case {case}");
            }
            for &point in &points {
                assert!(
                    solve::residual(pair.into_iter(), point) < 1e-12,
                    "case {case}"
                );
            }
            let bounds = points
                .windows(2)
                .map(|w| deviation::of_chord(course.surfaces(), w[0], w[1]));
            let (least, most) =
                bounds.fold((f64::INFINITY, 0.0f64), |(l, m), b| (l.min(b), m.max(b)));
            let wanted = 1e-4 * (course.chords() / chords).powi(2);
            assert!(
                least > 0.97 * wanted && most < 1.03 * wanted,
                "case {case}: {least} {most} {wanted}"
            );
        }
    }

    #[test]
    fn curves_of_degree_four_are_no_conics() {
        let thin = Solid::infinite_cylinder(0.5).rotate_x(PI / 2.0);
        let surfaces = surfaces([Solid::infinite_cylinder(1.0), thin]);
        let pair = [&surfaces[0], &surfaces[1]];
        let vertices = along(pair, &[[0.5, 0.9, 0.1], [0.0, 1.0, 0.5]]);
        assert!(Conic::through(pair, &vertices, false, 1e-12).is_none());
    }
}
