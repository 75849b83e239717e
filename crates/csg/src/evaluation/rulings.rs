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

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec3, DVec4};
use smallvec::{SmallVec, smallvec};

use super::roots::{Candidate, Roots};
use super::trig::{BEGIN, Trig};
use crate::program::Surface;

/// The matrix of a quadric in coordinates about `origin` of some unit.
pub(super) fn matrix(surface: &Surface, origin: DVec3, unit: f64) -> DMat4 {
    let [xx, yy, zz, xy, yz, zx] = surface.quadratic;
    let [x, y, z] = (surface.gradient(origin) / unit).to_array();
    let constant = surface.value(origin) / (unit * unit);
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

/// A curve on the lines of one quadric and on another one.
#[derive(Clone, Debug)]
pub(crate) struct Rulings {
    /// Of the coordinates, and their unit.
    pub origin: DVec3,
    pub unit: f64,
    pub lines: Lines,
    pub on_lines: OnLines,
    pub part: Part,
    /// Where the curve comes from infinity and goes there.
    pub between: Option<(f64, f64)>,
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
            Part::Touching | Part::Once => (t.sin_cos(), 0.0),
            Part::Around { is_plus } => {
                let turn = t.sin_cos();
                let [a, b, c] = [&on.a, &on.b, &on.c].map(|f| f.value_at(turn));
                let root = (b * b - a * c).max(0.0).sqrt();
                (turn, if *is_plus { root } else { -root })
            }
            Part::Between { middle, half, rest } => {
                // The angle is middle + φ, φ = -half cos t, and
                // cos φ - cos half = 2 sin((half + φ) / 2) sin((half - φ) / 2).
                let (sin, cos) = (0.5 * t).sin_cos();
                let turn = (middle - half * (cos * cos - sin * sin)).sin_cos();
                let factors = 2.0 * (half * sin * sin).sin() * (half * cos * cos).sin();
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
                if off.abs() > half {
                    return None;
                }
                let turn = (-off / half).acos();
                let turn = if is_plus { turn } else { TAU - turn };
                Some((turn - BEGIN).rem_euclid(TAU))
            }
        }
    }

    /// The places that a point of the line at an angle may have.
    fn places(&self, angle: f64) -> SmallVec<[f64; 2]> {
        let around = (angle - BEGIN).rem_euclid(TAU);
        match self.part {
            Part::Touching | Part::Once | Part::Around { .. } => smallvec![around],
            Part::Between { middle, half, .. } => {
                let off = (angle - middle + PI).rem_euclid(TAU) - PI;
                let turn = (-off / half).clamp(-1.0, 1.0).acos();
                let turns = [turn, TAU - turn];
                turns
                    .map(|turn| (turn - BEGIN).rem_euclid(TAU))
                    .into_iter()
                    .collect()
            }
        }
    }

    /// What vanishes on the lines on which the curve meets a plane. On such a line
    /// α : β = q : -p, by the plane's values at p and q. And how large its terms
    /// are.
    fn on_plane(&self, plane: DVec4) -> (Trig, f64) {
        let [p, q] = self.lines.values(plane);
        let OnLines { a, b, c } = &self.on_lines;
        let [size_a, size_b, size_c] = self.on_lines.magnitudes();
        let [size_p, size_q] = [&p, &q].map(Trig::magnitude);
        match self.part {
            Part::Once => (
                a.times(&q).plus(-2.0, &b.times(&p)),
                size_a * size_q + size_b * size_p,
            ),
            _ => {
                let mixed = b.times(&p).times(&q);
                let ends = a.times(&q).times(&q).plus(1.0, &c.times(&p).times(&p));
                let size = (size_a * size_q + size_b * size_p) * size_q + size_c * size_p * size_p;
                (ends.plus(-2.0, &mixed), size)
            }
        }
    }

    /// The same for another quadric: its value at the one point of a line, or the
    /// resultant of the two equations for α : β.
    fn on_quadric(&self, other: &DMat4) -> (Trig, f64) {
        let OnLines { a, b, c } = &self.on_lines;
        let form = self.lines.form(other);
        let [size_a, size_b, size_c] = self.on_lines.magnitudes();
        let [form_a, form_b, form_c] = form.magnitudes();
        let one_point = |factor: f64| {
            let squares = form.a.times(&b.times(b));
            let mixed = form.b.times(&a.times(b));
            let sum = squares.plus(-2.0 * factor, &mixed);
            let size = (form_a * size_b + form_b * size_a) * size_b + form_c * size_a * size_a;
            (sum.plus(factor * factor, &form.c.times(&a.times(a))), size)
        };
        match self.part {
            // α : β = -2 b : a, and -b : a.
            Part::Once => one_point(0.5),
            Part::Touching => one_point(1.0),
            Part::Around { .. } | Part::Between { .. } => {
                let minor =
                    |[p, q]: [&Trig; 2], [r, s]: [&Trig; 2]| p.times(s).plus(-1.0, &q.times(r));
                let ac = minor([a, c], [&form.a, &form.c]);
                let ab = minor([a, b], [&form.a, &form.b]);
                let bc = minor([b, c], [&form.b, &form.c]);
                let size_ac = size_a * form_c + size_c * form_a;
                let size_ab = size_a * form_b + size_b * form_a;
                let size_bc = size_b * form_c + size_c * form_b;
                (
                    ac.times(&ac).plus(-4.0, &ab.times(&bc)),
                    size_ac * size_ac + size_ab * size_bc,
                )
            }
        }
    }

    /// All places between two at which the curve may meet a surface, in order, and
    /// whether it may touch it there; none if some branch of the curve may on a
    /// long stretch.
    pub fn candidates(&self, surface: &Surface, [start, end]: [f64; 2]) -> Option<Vec<Candidate>> {
        /// Of the greatest value: what is less may be 0.
        const SMALL: f64 = 1e-11;
        let (equation, size) = if surface.is_plane() {
            let value = surface.value(self.origin) / self.unit;
            self.on_plane(surface.linear.extend(value))
        } else {
            self.on_quadric(&matrix(surface, self.origin, self.unit))
        };
        let magnitude = equation.magnitude();
        let mut roots = Roots::default();
        equation.roots(SMALL * magnitude, &mut roots);
        if roots.is_lost || magnitude <= SMALL * size {
            return None;
        }
        let mut places: Vec<Candidate> = Vec::new();
        for (angles, touches) in [(&roots.simple, false), (&roots.touching, true)] {
            let own = angles.iter().flat_map(|&angle| self.places(angle));
            let own = own.map(|place| start + (place - start).rem_euclid(TAU));
            let own = own.filter(|&place| place > start && place < end);
            places.extend(own.map(|place| (place, touches)));
        }
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places.dedup_by(|a, b| {
            let is_same = a.0 - b.0 < 1e-13 * (end - start);
            b.1 |= is_same && a.1;
            is_same
        });
        Some(places)
    }

    /// Cuts the curve where it goes to infinity.
    pub fn cut_at_infinity(self) -> Vec<Self> {
        let infinity = DVec4::W;
        let [p, q] = self.lines.values(infinity);
        let (at_infinity, _) = self.on_plane(infinity);
        let mut roots = Roots::default();
        at_infinity.roots(1e-12 * at_infinity.magnitude(), &mut roots);
        let mut poles: Vec<f64> = Vec::new();
        for &angle in roots.simple.iter().chain(&roots.touching) {
            let point = [q.value(angle), -p.value(angle)];
            poles.extend(self.place(angle, point));
        }
        poles.sort_by(f64::total_cmp);
        poles.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let Some(&first) = poles.first() else {
            return vec![self];
        };
        let next = poles[1..].iter().copied().chain([first + TAU]);
        let part = |between| Self {
            between: Some(between),
            ..self.clone()
        };
        poles.iter().copied().zip(next).map(part).collect()
    }
}
