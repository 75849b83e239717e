//! The curves that the lines on a quadric draw on another one, in homogeneous
//! coordinates.
//!
//! A cone's or cylinder's lines all pass through its vertex q, which may be at
//! infinity, and through the points p(θ) of a conic; a one-sheet hyperboloid or
//! hyperbolic paraboloid has lines through p(θ) and q(θ), both on conics. The
//! point α p + β q is on another quadric M where
//! a α² + 2 b α β + c β² = 0, a = pᵀMp, b = pᵀMq, c = qᵀMq:
//! at most twice on each line (Levin, *A Parametric Algorithm for Drawing
//! Pictures of Solid Objects Composed of Quadric Surfaces*, 1976; Dupont et al.,
//! *Near-Optimal Parameterization of the Intersection of Quadrics*, 2008). All
//! of them are trigonometric polynomials in θ.

mod candidates;

use crate::elementary;
use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec3, DVec4};
use smallvec::{SmallVec, smallvec};

use super::roots::{Candidate, Roots};
use super::trig::{BEGIN, Trig};
use crate::numeric::tolerance::{NO_DISCRIMINANT, SAME_ANGLE};
use crate::program::Surface;

/// The matrix of a quadric in coordinates about `origin` of some unit.
pub(super) fn matrix(surface: &Surface, origin: DVec3, unit: f64) -> DMat4 {
    form(
        surface.quadratic,
        surface.gradient(origin),
        surface.value(origin),
        unit,
    )
}

/// The matrix of a quadratic form with a gradient and a value at the origin, in coordinates of
/// some unit.
pub(super) fn form(quadratic: [f64; 6], gradient: DVec3, value: f64, unit: f64) -> DMat4 {
    let [xx, yy, zz, xy, yz, zx] = quadratic;
    let [x, y, z] = (gradient / unit).to_array();
    let constant = value / (unit * unit);
    DMat4::from_cols_array_2d(&[
        [xx, 0.5 * xy, 0.5 * zx, 0.5 * x],
        [0.5 * xy, yy, 0.5 * yz, 0.5 * y],
        [0.5 * zx, 0.5 * yz, zz, 0.5 * z],
        [0.5 * x, 0.5 * y, 0.5 * z, constant],
    ])
}

/// A point that moves along a conic with the cosine and the sine of an angle:
/// of 1, cos and sin the factors.
pub(crate) type Round = [DVec4; 3];

/// The lines on a quadric, each through a point of `p` and one of `q`.
#[derive(Clone, Debug)]
pub(crate) struct Lines {
    pub p: Round,
    pub q: Round,
}

/// a, b and c of the quadratic form on every line.
#[derive(Clone, Debug)]
pub(crate) struct OnLines {
    pub a: Trig,
    pub b: Trig,
    pub c: Trig,
}

impl OnLines {
    fn magnitudes(&self) -> [f64; 3] {
        [&self.a, &self.b, &self.c].map(Trig::magnitude)
    }

    /// b² - ac, and how much of it is rounding.
    pub fn discriminant(&self) -> (Trig, f64) {
        let OnLines { a, b, c } = self;
        let [size_a, size_b, size_c] = self.magnitudes();
        let discriminant = b.times(b).plus(-1.0, &a.times(c));
        let size = size_b * size_b + size_a * size_c;
        (discriminant, NO_DISCRIMINANT * size)
    }
}

impl Lines {
    /// The values of another quadric.
    pub fn form(&self, other: &DMat4) -> OnLines {
        let product = |first: &Round, second: &Round| {
            let second = second.map(|v| *other * v);
            let at = |i: usize, j: usize| first[i].dot(second[j]);
            Trig::of_form(
                [at(1, 1), at(2, 2), at(1, 2) + at(2, 1)],
                [at(0, 1) + at(1, 0), at(0, 2) + at(2, 0)],
                at(0, 0),
            )
        };
        OnLines {
            a: product(&self.p, &self.p),
            b: product(&self.p, &self.q),
            c: product(&self.q, &self.q),
        }
    }

    /// The same lines by another angle, in which those nearer than `half` to `middle` are half
    /// of all: by tan(φ / 2) = tan(half / 2) tan(φ' / 2) for the angle φ from the middle, and
    /// with factors that are polynomials in the new sine and cosine again.
    pub fn spread(&self, middle: f64, half: f64) -> Self {
        let (sin, cos) = elementary::sin_cos(middle);
        let (s, c) = elementary::sin_cos(0.5 * half);
        let narrow = s / c;
        let square = narrow * narrow;
        let spread = |round: &Round| {
            let &[one, x, y] = round;
            if x == DVec4::ZERO && y == DVec4::ZERO {
                // A vertex.
                return *round;
            }
            let (x, y) = (cos * x + sin * y, cos * y - sin * x);
            let (near, far) = (0.5 * (one + x), 0.5 * square * (one - x));
            [near + far, near - far, narrow * y]
        };
        Self {
            p: spread(&self.p),
            q: spread(&self.q),
        }
    }

    /// Of a quadric that is two planes but for little, whose lines are all next to one line
    /// but for few in each plane: those of one plane and of the other, both spread, each with the
    /// angle up to which, to both sides of 0, they are those of that plane.
    pub fn of_two_planes(&self) -> Option<[(Self, f64); 2]> {
        /// Of how many digits are lost else.
        const NARROW: f64 = 0.03;
        /// The tangent of half the angle from one plane to where the lines are the other's:
        /// about 1, but surfaces are often placed such that there something else is.
        const SHARE: f64 = 1.287;
        let length = |v: DVec4| v.length();
        let [one, x, y] = self.p.map(length);
        let [w, ..] = self.q.map(length);
        let long = if self.is_cone() { y } else { y.min(w) };
        let narrow = one.max(x) / long;
        if narrow > NARROW {
            return None;
        }
        let half = 2.0 * elementary::atan2(narrow, 1.0);
        let of_plane = |middle: f64, share: f64| {
            let until = 2.0 * elementary::atan2(share, narrow);
            (self.spread(middle, half), until)
        };
        Some([of_plane(0.0, SHARE), of_plane(PI, SHARE.recip())])
    }

    /// The point of p on the line at an angle.
    pub fn point(&self, angle: f64) -> DVec4 {
        on_conic(&self.p, elementary::sin_cos(angle))
    }

    /// How long the vectors of both points of the line at an angle are.
    pub fn lengths(&self, angle: f64) -> [f64; 2] {
        let turn = elementary::sin_cos(angle);
        [&self.p, &self.q].map(|round| on_conic(round, turn).length())
    }

    /// Whether all pass through one point.
    fn is_cone(&self) -> bool {
        self.q[1..] == [DVec4::ZERO; 2]
    }

    /// The map of a point on a cone or cylinder to its shares of the vertex and of p's three
    /// vectors; none of other surfaces.
    fn to_shares(&self) -> Option<DMat4> {
        let [vertex, ..] = self.q;
        let map = DMat4::from_cols(vertex, self.p[0], self.p[1], self.p[2]).inverse();
        (self.is_cone() && map.is_finite()).then_some(map)
    }

    /// The values of a plane at p and q.
    fn values(&self, plane: DVec4) -> [Trig; 2] {
        [&self.p, &self.q].map(|v| Trig::linear(v.map(|v| v.dot(plane))))
    }
}

/// What part of the lines a curve takes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    /// All of them, each where α : β = -b + √(b² - ac) : a, or where the root is
    /// negative.
    Around { is_plus: bool },
    /// All of them, each where it touches the other surface.
    Touching,
    /// All of them, each where it meets the other surface besides in q: c = 0.
    Once,
    /// Those between two that touch the other surface, there and back. The last
    /// is b² - ac over cos(θ - middle) - cos(half).
    Between { middle: f64, half: f64, rest: Trig },
}

impl Part {
    /// From one root of b² - ac to another.
    pub fn between(from: f64, to: f64, discriminant: &Trig) -> Self {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        Self::Between {
            middle,
            half,
            rest: discriminant.without_roots(middle, half),
        }
    }
}

/// A curve on the lines of one quadric and on another one.
#[derive(Clone, Debug)]
pub(crate) struct Rulings {
    /// Of the coordinates, and their unit.
    pub origin: DVec3,
    pub unit: f64,
    pub lines: Lines,
    pub on_lines: OnLines,
    pub part: Part,
    /// Of a part of the curve between which places.
    pub between: Option<(f64, f64)>,
    /// If it is on some of the lines alone, the angle up to which, to both sides of 0.
    pub until: Option<f64>,
}

/// How a curve runs along a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Along {
    /// It lies in it.
    Within,
    /// So closely on a long stretch that it cannot be told where it crosses.
    Beside,
}

fn on_conic([one, cos, sin]: &Round, (s, c): (f64, f64)) -> DVec4 {
    *one + c * *cos + s * *sin
}

impl Rulings {
    /// The point at a place in homogeneous coordinates, of length 1, the last of
    /// them not negative.
    fn homogeneous(&self, t: f64) -> DVec4 {
        let t = t + BEGIN;
        // The sine and the cosine of the line's angle, and √(b² - ac) with the
        // sign that tells the two points on a line apart.
        let on = &self.on_lines;
        let (turn, root) = match &self.part {
            Part::Touching | Part::Once => (elementary::sin_cos(t), 0.0),
            Part::Around { is_plus } => {
                let turn = elementary::sin_cos(t);
                let [a, b, c] = [&on.a, &on.b, &on.c].map(|f| f.value_at(turn));
                let root = (b * b - a * c).max(0.0).sqrt();
                (turn, if *is_plus { root } else { -root })
            }
            Part::Between { middle, half, rest } => {
                // The angle is middle + φ, φ = -half cos t, and
                // cos φ - cos half = 2 sin((half + φ) / 2) sin((half - φ) / 2).
                let (sin, cos) = elementary::sin_cos(0.5 * t);
                let turn = elementary::sin_cos(middle - half * (cos * cos - sin * sin));
                let factors =
                    2.0 * elementary::sin(half * sin * sin) * elementary::sin(half * cos * cos);
                let root = (factors * rest.value_at(turn)).max(0.0).sqrt();
                (turn, root.copysign(sin * cos))
            }
        };
        let [a, b, c] = [&on.a, &on.b, &on.c].map(|f| f.value_at(turn));
        let [p, q] = [&self.lines.p, &self.lines.q].map(|v| on_conic(v, turn));
        let [alpha, beta] = if matches!(self.part, Part::Once) {
            [-2.0 * b, a]
        } else {
            // The same ratio twice, the one farther from 0 : 0.
            let ratios = [[root - b, a], [c, -b - root]];
            let size = |[alpha, beta]: [f64; 2]| alpha.abs().max(beta.abs());
            ratios[usize::from(size(ratios[1]) > size(ratios[0]))]
        };
        let point = (alpha * p + beta * q).normalize_or_zero();
        if point.w < 0.0 { -point } else { point }
    }

    pub fn at(&self, t: f64) -> DVec3 {
        self.weighted(t).0
    }

    /// The point at a place, with a number that is next to 0 where it is next to
    /// infinity, and else about 1.
    pub fn weighted(&self, t: f64) -> (DVec3, f64) {
        let point = self.homogeneous(t);
        (
            self.origin + self.unit / point.w * point.truncate(),
            point.w,
        )
    }

    /// Where on the curve a point of the line at an angle is, given by α and β;
    /// none if it is the other branch's.
    pub fn place(&self, angle: f64, [alpha, beta]: [f64; 2]) -> Option<f64> {
        let around = (angle - BEGIN).rem_euclid(TAU);
        // a α + b β = ±root β, b α + c β = ∓root α.
        let OnLines { a, b, c } = &self.on_lines;
        let [a, b, c] = [a, b, c].map(|f| f.value(angle));
        let is_plus = if beta.abs() > alpha.abs() {
            (a * alpha + b * beta) * beta >= 0.0
        } else {
            (b * alpha + c * beta) * alpha <= 0.0
        };
        match self.part {
            Part::Touching | Part::Once => Some(around),
            Part::Around { is_plus: mine } => (mine == is_plus).then_some(around),
            Part::Between { middle, half, .. } => {
                let off = (angle - middle + PI).rem_euclid(TAU) - PI;
                if off.abs() > half + SAME_ANGLE {
                    return None;
                }
                let turn = elementary::acos((-off / half).clamp(-1.0, 1.0));
                let turn = if is_plus { turn } else { TAU - turn };
                Some((turn - BEGIN).rem_euclid(TAU))
            }
        }
    }

    /// The places on the curve of lines at an angle, and how far around them those of lines so
    /// near to it are.
    fn places(&self, angle: f64, reach: f64) -> SmallVec<[Candidate; 2]> {
        let candidate = |angle: f64, reach: f64| Candidate {
            place: (angle - BEGIN).rem_euclid(TAU),
            reach,
        };
        match self.part {
            Part::Touching | Part::Once | Part::Around { .. } => smallvec![candidate(angle, reach)],
            Part::Between { middle, half, .. } => {
                // Beyond the last lines that the curve is on, a root is of no point of it, or
                // put there by rounding: it counts as the last line's.
                let off = (angle - middle + PI).rem_euclid(TAU) - PI;
                let turn = |off: f64| elementary::acos((-off / half).clamp(-1.0, 1.0));
                let [low, turn, high] = [off - reach, off, off + reach].map(turn);
                let reach = (turn - low).max(high - turn);
                smallvec![candidate(turn, reach), candidate(TAU - turn, reach)]
            }
        }
    }

    /// The parts of the curve between where it goes to infinity and the last of the lines
    /// that it is on.
    pub fn parts(self) -> Vec<Self> {
        let infinity = DVec4::W;
        let [p, q] = self.lines.values(infinity);
        let (at_infinity, _) = self.on_plane(infinity);
        let mut roots = Roots::default();
        at_infinity.roots(NO_DISCRIMINANT * at_infinity.magnitude(), &mut roots);
        let mut ends: Vec<f64> = Vec::new();
        for &angle in roots.simple.iter().chain(&roots.touching) {
            let point = [q.value(angle), -p.value(angle)];
            ends.extend(self.place(angle, point));
        }
        let last = self.until.iter().flat_map(|&until| [until, -until]);
        for angle in last.filter(|&angle| self.has_line(angle)) {
            ends.extend(self.places(angle, 0.0).iter().map(|c| c.place));
        }
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|a, b| (*a - *b).abs() < SAME_ANGLE);
        let Some(&first) = ends.first() else {
            let is_own = self.is_on_own_lines(0.0);
            return is_own.then_some(self).into_iter().collect();
        };
        let next = ends[1..].iter().copied().chain([first + TAU]);
        let between = ends.iter().copied().zip(next);
        let own = between.filter(|(from, to)| self.is_on_own_lines(0.5 * (from + to)));
        let part = |between| Self {
            between: Some(between),
            ..self.clone()
        };
        own.map(part).collect()
    }

    /// Whether the line at an angle has points of the curve, were it on all lines.
    fn has_line(&self, angle: f64) -> bool {
        match self.part {
            Part::Between { middle, half, .. } => {
                ((angle - middle + PI).rem_euclid(TAU) - PI).abs() < half
            }
            _ => true,
        }
    }

    /// Whether a place on the curve is on one of the lines that it is on.
    fn is_on_own_lines(&self, t: f64) -> bool {
        let angle = match self.part {
            Part::Between { middle, half, .. } => middle - half * elementary::sin_cos(t + BEGIN).1,
            _ => t + BEGIN,
        };
        let off = (angle + PI).rem_euclid(TAU) - PI;
        self.until.is_none_or(|until| off.abs() < until)
    }
}

#[cfg(test)]
mod tests {
    use super::super::curve::{Curve, Meets};
    use super::*;

    /// The product of two planes' equations n·x + d, with a share of x² + y² - 1.
    fn product((a, d): (DVec3, f64), (b, e): (DVec3, f64), share: f64) -> Surface {
        let mixed = |i: usize, j: usize| a[i] * b[j] + a[j] * b[i];
        Surface::of_terms(
            DVec3::ZERO,
            [
                a.x * b.x + share,
                a.y * b.y + share,
                a.z * b.z,
                mixed(0, 1),
                mixed(1, 2),
                mixed(2, 0),
            ],
            e * a + d * b,
            d * e - share,
        )
    }

    /// Two planes cut a cylinder; surfaces that contain the lower ellipse cross the
    /// upper one.
    #[test]
    fn roots_are_found_though_another_branch_lies_in_the_surface() {
        let lower = (DVec3::new(0.0, 0.5, 1.0), 3.0);
        let upper = (DVec3::new(0.0, -1.0, 1.0), -3.0);
        let lines = Lines {
            p: [DVec4::W, DVec4::X, DVec4::Y],
            q: [DVec4::Z, DVec4::ZERO, DVec4::ZERO],
        };
        let on_lines = lines.form(&matrix(&product(lower, upper, 0.0), DVec3::ZERO, 1.0));
        let branches = [true, false].map(|is_plus| Rulings {
            origin: DVec3::ZERO,
            unit: 1.0,
            lines: lines.clone(),
            on_lines: on_lines.clone(),
            part: Part::Around { is_plus },
            between: None,
            until: None,
        });
        let on_upper = branches.iter().find(|branch| branch.at(0.0).z > 0.0);
        let curve = Curve::Rulings(Box::new(on_upper.expect("one is above").clone()));
        let meet = |surface: &Surface| {
            let mut roots = Roots::default();
            let meets = curve.meet(surface, [0.0, TAU], [1e-12, 1e-9], &mut roots);
            assert!(!roots.is_lost);
            (meets, roots)
        };
        for share in [0.0, 0.4, -0.7] {
            // Crossing where y = 0.3 x + 0.1, and touching where y = 1.
            let (meets, roots) = meet(&product(lower, (DVec3::new(-0.3, 1.0, 0.0), -0.1), share));
            assert_eq!((meets, roots.simple.len()), (Meets::Points, 2), "{roots:?}");
            for &root in &roots.simple {
                let at = curve.at(root);
                assert!((at.y - 0.3 * at.x - 0.1).abs() < 1e-13, "{at}");
            }
            let (meets, roots) = meet(&product(lower, (DVec3::Y, -1.0), share));
            assert_eq!(meets, Meets::Points);
            assert_eq!(
                (roots.simple.len(), roots.touching.len()),
                (0, 1),
                "{roots:?}"
            );
            assert!(
                curve
                    .at(roots.touching[0])
                    .distance(DVec3::new(0.0, 1.0, 4.0))
                    < 1e-6
            );
            let (meets, roots) = meet(&product(lower, (DVec3::Y, 1.5), share));
            assert_eq!(meets, Meets::Points);
            assert!(roots.simple.is_empty() && roots.touching.is_empty());
            assert_eq!(
                meet(&product(upper, (DVec3::Y, 0.3), share)).0,
                Meets::Curve
            );
        }
        let normal = lower.0.normalize();
        let (meets, roots) = meet(&Surface::plane(-lower.1 / lower.0.z * DVec3::Z, normal));
        assert_eq!(meets, Meets::Points);
        assert!(roots.simple.is_empty() && roots.touching.is_empty());
    }
}
