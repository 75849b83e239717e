//! Points along the curve in which two surfaces meet, as many as a tolerance
//! asks for.
//!
//! A chord of length s strays from a curve of curvature κ by κ s² / 8. Points
//! at equal steps of ∫ √(κ / 8 tol) ds, each at most 1, make all chords stray
//! alike, and are as few as can be.

use glam::DVec3;

use super::course::Course;
use super::goal::Goal;
use crate::numeric::tolerance::CROSSING;
use crate::program::Surface;
use crate::surface::round::Round;
use crate::surface::solve;

/// Steps in which a curve is measured between two vertices.
const STEPS: usize = 16;

/// A measured stretch of a curve between two points on it.
struct Stretch<'a> {
    surfaces: [&'a Surface; 2],
    /// Points along it, and the integral up to each.
    points: [DVec3; STEPS + 1],
    chords: [f64; STEPS + 1],
    /// How near a point must come to both surfaces.
    precision: f64,
}

/// The curvature of the curve at a point, and how fast the two surfaces turn
/// along it; `None` where they touch, or nearly.
fn bends(surfaces: [&Surface; 2], at: DVec3) -> Option<(f64, f64)> {
    let [g1, g2] = surfaces.map(|s| s.gradient(at));
    let across = g1.cross(g2);
    let determinant = across.length_squared();
    let (g11, g22, g12) = (g1.length_squared(), g2.length_squared(), g1.dot(g2));
    if determinant <= CROSSING * CROSSING * g11 * g22 {
        return None;
    }
    let tangent = across / determinant.sqrt();
    // The acceleration a along the curve: ∇f·a = -tᵀ H t for both.
    let [k1, k2] = surfaces.map(|s| s.curvature_along(tangent));
    let alpha = (k2 * g12 - k1 * g22) / determinant;
    let beta = (k1 * g12 - k2 * g11) / determinant;
    let curvature = (alpha * g1 + beta * g2).length();
    let turn = |s: &Surface, g: DVec3| {
        // H t, from the gradient's change along t.
        let change = s.gradient(at + tangent) - g;
        change.reject_from(g).length() / g.length()
    };
    Some((curvature, turn(surfaces[0], g1).max(turn(surfaces[1], g2))))
}

/// The stretches between the vertices of a chain.
pub(super) struct Stretches<'a>(Vec<Stretch<'a>>);

impl<'a> Stretches<'a> {
    /// `None` where the curve could not be followed.
    pub fn new(
        surfaces: [&'a Surface; 2],
        vertices: &[DVec3],
        rounds: [Option<&Round>; 2],
        goal: &Goal,
        precision: f64,
    ) -> Option<Self> {
        let stretch = |w: &[DVec3]| Stretch::new(surfaces, [w[0], w[1]], rounds, goal, precision);
        vertices
            .windows(2)
            .map(stretch)
            .collect::<Option<_>>()
            .map(Self)
    }
}

impl Course for Stretches<'_> {
    fn chords(&self) -> f64 {
        self.0.iter().map(Stretch::chords).sum()
    }

    fn shares(&self) -> Vec<f64> {
        let total = self.chords();
        let ends = self.0.iter().scan(0.0, |sum, stretch| {
            *sum += stretch.chords();
            Some(*sum / total)
        });
        std::iter::once(0.0).chain(ends).collect()
    }

    fn points(&self, chords: u32) -> Option<Vec<DVec3>> {
        let total = self.chords();
        let mut points = Vec::with_capacity(chords as usize);
        let mut rest = self.0.iter();
        let (mut stretch, mut sum) = (rest.next()?, 0.0);
        for i in 1..chords {
            let wanted = f64::from(i) / f64::from(chords) * total;
            while wanted > sum + stretch.chords()
                && let Some(after) = rest.next()
            {
                sum += stretch.chords();
                stretch = after;
            }
            points.push(stretch.point_at((wanted - sum) / stretch.chords())?);
        }
        Some(points)
    }

    fn is_even(&self) -> bool {
        false
    }

    fn surfaces(&self) -> [&Surface; 2] {
        self.0[0].surfaces
    }
}

impl<'a> Stretch<'a> {
    /// `None` where the curve could not be followed.
    fn new(
        surfaces: [&'a Surface; 2],
        [from, to]: [DVec3; 2],
        rounds: [Option<&Round>; 2],
        goal: &Goal,
        precision: f64,
    ) -> Option<Self> {
        /// What turns more often between two vertices is no curve, in radians.
        const MOST_TURN: f64 = 3.0 * std::f64::consts::PI;
        let mut stretch = Self {
            surfaces,
            points: [from; STEPS + 1],
            chords: [0.0; STEPS + 1],
            precision,
        };
        let along = to - from;
        if is_straight(surfaces, from, to, precision) {
            stretch.points[STEPS] = to;
            return Some(stretch);
        }
        for i in 1..STEPS {
            let start = from + i as f64 / STEPS as f64 * along;
            stretch.points[i] = on_curve(surfaces, start, 0.5 * along.length(), precision)?;
        }
        stretch.points[STEPS] = to;
        let mut densities = [0.0; STEPS + 1];
        // At an apex there is no gradient.
        let middle = from.midpoint(to);
        let least = surfaces.map(|s| 1e-3 * s.gradient(middle).length());
        for (i, density) in densities.iter_mut().enumerate() {
            let at = stretch.points[i];
            let is_apex = (0..2).any(|k| surfaces[k].gradient(at).length() < least[k]);
            let (curvature, turn) = bends(surfaces, at)
                .filter(|_| !is_apex)
                .unwrap_or_else(|| stretch.bends_about(i));
            let for_distance = (curvature / (8.0 * goal.tolerance)).sqrt();
            let tangent = stretch.direction(i);
            let on_rounds = rounds.iter().copied().flatten();
            let on_rounds = on_rounds.map(|r| r.chords_along(at, tangent, goal.tolerance));
            let for_distance = on_rounds.fold(for_distance, f64::max);
            let for_angle = goal.angle.map_or(0.0, |angle| turn / angle);
            *density = for_distance.max(for_angle);
        }
        let mut length = 0.0;
        for i in 1..=STEPS {
            let step = stretch.points[i].distance(stretch.points[i - 1]);
            let mean = 0.5 * (densities[i - 1] + densities[i]);
            stretch.chords[i] = stretch.chords[i - 1] + mean * step;
            length += step;
        }
        // ∫ √κ ds is at most √(length ∫ κ ds) (Cauchy and Schwarz).
        let for_distance = (length * MOST_TURN / (8.0 * goal.tolerance)).sqrt();
        let for_angle = goal.angle.map_or(0.0, |angle| MOST_TURN / angle);
        let is_even = rounds.iter().all(Option::is_none);
        if is_even && stretch.chords[STEPS] > for_distance + for_angle + 1.0 {
            return None;
        }
        Some(stretch)
    }

    /// The curve's direction about a point of it.
    fn direction(&self, index: usize) -> DVec3 {
        let [before, after] = [index.max(1) - 1, (index + 1).min(STEPS)];
        (self.points[after] - self.points[before]).normalize_or_zero()
    }

    /// The curvature, and how fast the surfaces turn, about a point of it, by
    /// differences.
    fn bends_about(&self, index: usize) -> (f64, f64) {
        let i = index.clamp(1, STEPS - 1);
        let [p, q, r] = [i - 1, i, i + 1].map(|k| self.points[k]);
        let (before, after) = (q - p, r - q);
        let length = 0.5 * (before.length() + after.length());
        if length == 0.0 {
            return (0.0, 0.0);
        }
        let turned = |a: DVec3, b: DVec3| a.normalize_or_zero().distance(b.normalize_or_zero());
        let turn = |s: &Surface| turned(s.gradient(p), s.gradient(r)) / (2.0 * length);
        (
            turned(before, after) / length,
            turn(self.surfaces[0]).max(turn(self.surfaces[1])),
        )
    }

    /// How many chords it takes, as a real number.
    fn chords(&self) -> f64 {
        self.chords[STEPS]
    }

    /// The point up to which it takes `share` of all chords.
    fn point_at(&self, share: f64) -> Option<DVec3> {
        let wanted = share * self.chords();
        let i = self.chords.partition_point(|&c| c < wanted).clamp(1, STEPS);
        let (low, high) = (self.chords[i - 1], self.chords[i]);
        let (p, q) = (self.points[i - 1], self.points[i]);
        let start = p.lerp(q, ((wanted - low) / (high - low)).clamp(0.0, 1.0));
        on_curve(self.surfaces, start, p.distance(q), self.precision)
    }
}

/// Whether the line between two points of two surfaces lies on both, but for
/// `precision`.
pub(super) fn is_straight(surfaces: [&Surface; 2], from: DVec3, to: DVec3, precision: f64) -> bool {
    surfaces.iter().all(|s| {
        let sag = 0.125 * s.curvature_along(to - from).abs();
        s.is_plane() || sag <= precision * s.gradient(from.midpoint(to)).length()
    })
}

/// A point of the curve in which two surfaces meet, within `reach` of another
/// one; as near to both as `precision`.
pub(super) fn on_curve(
    surfaces: [&Surface; 2],
    start: DVec3,
    reach: f64,
    precision: f64,
) -> Option<DVec3> {
    let is_sharp = surfaces.iter().all(|s| solve::blur(s, start) <= precision);
    if is_sharp && let Some(point) = nearby(surfaces, start, reach, precision) {
        return Some(point);
    }
    let solution = solve::sharp_common_point(&surfaces, start, reach, precision);
    let is_near = solution.point.distance_squared(start) <= reach * reach;
    (is_near && solution.residual <= precision).then_some(solution.point)
}

/// The same by a few of Newton's steps across the curve, which is enough where
/// the surfaces cross at an angle.
fn nearby(surfaces: [&Surface; 2], start: DVec3, reach: f64, precision: f64) -> Option<DVec3> {
    const MOST_STEPS: usize = 6;
    let mut point = start;
    for _ in 0..MOST_STEPS {
        let [g1, g2] = surfaces.map(|s| s.gradient(point));
        let [f1, f2] = surfaces.map(|s| s.value(point));
        let (g11, g22, g12) = (g1.length_squared(), g2.length_squared(), g1.dot(g2));
        let determinant = g11 * g22 - g12 * g12;
        if determinant <= CROSSING * CROSSING * g11 * g22 {
            return None;
        }
        let (a, b) = (f1 * g22 - f2 * g12, f2 * g11 - f1 * g12);
        let step = (a * g1 + b * g2) / determinant;
        point -= step;
        // What is left is of the order of the step's square.
        if step.length_squared() <= 1e-9 * precision * reach {
            return (point.distance_squared(start) <= reach * reach).then_some(point);
        }
    }
    None
}
