//! Curves in space, and where surfaces cross them.

use crate::elementary;
use std::f64::consts::TAU;

use glam::{DVec3, DVec4};
use smallvec::SmallVec;

use super::rational;
use super::roots::{Known, Roots, Tolerance, bend_within};
use super::rulings::{Along, Rulings};
use super::trig::Trig;
use crate::numeric::tolerance::{POLYNOMIAL, VALUE};
use crate::program::{Bounds, Surface};

/// A curve, as a function of a parameter t.
#[derive(Clone, Debug)]
pub(crate) enum Curve {
    /// point + t direction, of unit length.
    Line { point: DVec3, direction: DVec3 },
    /// center + cos t a + sin t b.
    Ellipse { center: DVec3, a: DVec3, b: DVec3 },
    /// center + cosh t a + sinh t b: one branch.
    Hyperbola { center: DVec3, a: DVec3, b: DVec3 },
    /// point + (t a + t² b) / (1 + l t + k t²), a and b at right angles: a conic
    /// from a point of it, where it has the direction a. A parabola, or the part
    /// near by of one whose centre or vertex is far away.
    Parabola {
        point: DVec3,
        a: DVec3,
        b: DVec3,
        l: f64,
        k: f64,
    },
    /// Where the lines on a quadric meet another one.
    Rulings(Box<Rulings>),
}

/// One of the curves in which two surfaces meet.
#[derive(Clone, Debug)]
pub(super) struct Branch {
    pub curve: Curve,
    /// Where others of the same surfaces, or itself, pass through it: there the
    /// surfaces have one tangent plane.
    pub nodes: SmallVec<[f64; 2]>,
}

/// All curves in which two surfaces meet.
pub(super) type Branches = SmallVec<[Branch; 2]>;

impl Branch {
    /// Without nodes.
    pub fn new(curve: Curve) -> Self {
        Self {
            curve,
            nodes: SmallVec::new(),
        }
    }
}

/// f(origin + x u + y v) as a polynomial in x and y.
#[derive(Clone, Copy, Debug)]
pub(super) struct Form {
    /// Of x², y², xy.
    pub square: [f64; 3],
    pub linear: [f64; 2],
    pub constant: f64,
}

impl Form {
    pub fn of(surface: &Surface, origin: DVec3, u: DVec3, v: DVec3) -> Self {
        if surface.is_plane() {
            return Self {
                square: [0.0; 3],
                linear: [surface.linear.dot(u), surface.linear.dot(v)],
                constant: surface.value(origin),
            };
        }
        let gradient = surface.gradient(origin);
        Self {
            square: [
                0.5 * surface.curvature_along(u),
                0.5 * surface.curvature_along(v),
                2.0 * polar(surface, u, v),
            ],
            linear: [gradient.dot(u), gradient.dot(v)],
            constant: surface.value(origin),
        }
    }

    /// Whether it is farther from 0 than a tolerance all along x = cos t,
    /// y = sin t, as is easily told.
    fn is_clear_around(&self, tolerance: f64) -> bool {
        let ([xx, yy, xy], [x, y]) = (self.square, self.linear);
        let varies = 0.5 * ((xx - yy).abs() + xy.abs()) + x.abs() + y.abs();
        (self.constant + 0.5 * (xx + yy)).abs() > varies + tolerance
    }

    /// Along x = cos t, y = sin t.
    pub fn around(&self) -> Trig {
        Trig::of_form(self.square, self.linear, self.constant)
    }
}

/// uᵀ A v of a surface's quadratic form A.
pub(super) fn polar(surface: &Surface, u: DVec3, v: DVec3) -> f64 {
    let [xx, yy, zz, xy, yz, zx] = surface.quadratic;
    (xx * u.x + 0.5 * (xy * u.y + zx * u.z)) * v.x
        + (yy * u.y + 0.5 * (xy * u.x + yz * u.z)) * v.y
        + (zz * u.z + 0.5 * (zx * u.x + yz * u.y)) * v.z
}

/// How a surface lies to a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meets {
    /// At single points, if at all.
    Points,
    /// The curve lies in it.
    Curve,
}

/// t where t / (1 + l t + k t²), on the way from 0, is a number.
fn of_share(number: f64, [l, k]: [f64; 2]) -> f64 {
    let rest = 1.0 - l * number;
    2.0 * number / (rest + (rest * rest - 4.0 * k * number * number).max(0.0).sqrt())
}

/// The box around a rational curve; infinite where weights are not positive.
fn around_control(control: [DVec4; 3]) -> [DVec3; 2] {
    if control.iter().any(|point| point.w <= 0.0) {
        return [DVec3::NEG_INFINITY, DVec3::INFINITY];
    }
    let [a, b, c] = control.map(|point| point.truncate() / point.w);
    [a.min(b).min(c), a.max(b).max(c)]
}

impl Curve {
    pub fn at(&self, t: f64) -> DVec3 {
        match self {
            &Self::Line { point, direction } => point + t * direction,
            &Self::Ellipse { center, a, b } => {
                let (sin, cos) = elementary::sin_cos(t);
                center + cos * a + sin * b
            }
            &Self::Hyperbola { center, a, b } => {
                center + elementary::cosh(t) * a + elementary::sinh(t) * b
            }
            &Self::Parabola { point, a, b, l, k } => {
                point + t / (1.0 + (l + k * t) * t) * (a + t * b)
            }
            Self::Rulings(rulings) => rulings.at(t),
        }
    }

    /// The direction of the curve, of any length.
    pub fn direction(&self, t: f64) -> DVec3 {
        match self {
            Self::Line { direction, .. } => *direction,
            Self::Ellipse { a, b, .. } => {
                let (sin, cos) = elementary::sin_cos(t);
                cos * b - sin * a
            }
            Self::Hyperbola { a, b, .. } => elementary::sinh(t) * a + elementary::cosh(t) * b,
            Self::Parabola { a, b, l, k, .. } => (1.0 - k * t * t) * a + (2.0 + l * t) * t * b,
            Self::Rulings(rulings) => rulings.at(t + 1e-6) - rulings.at(t - 1e-6),
        }
    }

    /// The first and the second derivative; none of rulings.
    pub fn derivatives(&self, t: f64) -> Option<[DVec3; 2]> {
        match self {
            Self::Line { direction, .. } => Some([*direction, DVec3::ZERO]),
            Self::Ellipse { a, b, .. } => {
                let (sin, cos) = elementary::sin_cos(t);
                Some([cos * b - sin * a, -cos * a - sin * b])
            }
            Self::Hyperbola { a, b, .. } => {
                let (sinh, cosh) = (elementary::sinh(t), elementary::cosh(t));
                Some([sinh * a + cosh * b, cosh * a + sinh * b])
            }
            Self::Parabola { a, b, l, k, .. } => {
                let below = 1.0 + (l + k * t) * t;
                let above = (1.0 - k * t * t) * a + (2.0 + l * t) * t * b;
                let change = -2.0 * k * t * a + 2.0 * (1.0 + l * t) * b;
                let first = above / (below * below);
                let second = change / (below * below) - 2.0 * (l + 2.0 * k * t) / below * first;
                Some([first, second])
            }
            Self::Rulings(_) => None,
        }
    }

    /// Where on a conic a point of it is; none if it is on the other branch of a
    /// hyperbola.
    pub fn place(&self, point: DVec3) -> Option<f64> {
        // x a + y b.
        let along = |a: &DVec3, b: &DVec3, d: DVec3| {
            let (aa, ab, bb) = (a.dot(*a), a.dot(*b), b.dot(*b));
            let (x, y) = (d.dot(*a), d.dot(*b));
            let determinant = aa * bb - ab * ab;
            [
                (x * bb - y * ab) / determinant,
                (y * aa - x * ab) / determinant,
            ]
        };
        match self {
            Self::Line {
                point: start,
                direction,
            } => Some((point - start).dot(*direction)),
            Self::Ellipse { center, a, b } => {
                let [x, y] = along(a, b, point - center);
                Some(elementary::atan2(y, x).rem_euclid(TAU))
            }
            Self::Hyperbola { center, a, b } => {
                let [x, y] = along(a, b, point - center);
                (x > 0.0).then(|| elementary::asinh(y))
            }
            Self::Parabola {
                point: start,
                a,
                l,
                k,
                ..
            } => {
                let number = (point - start).dot(*a) / a.length_squared();
                Some(of_share(number, [*l, *k]))
            }
            Self::Rulings(_) => None,
        }
    }

    /// All of a closed curve; of others at least the part that is nearer to a
    /// point than `reach`, or nothing.
    pub fn range(&self, around: DVec3, reach: f64) -> Option<[f64; 2]> {
        match self {
            Self::Line { point, direction } => {
                let middle = (around - point).dot(*direction);
                let off = (point + middle * direction - around).length();
                (off < reach).then_some([middle - reach, middle + reach])
            }
            Self::Ellipse { .. } => Some([0.0, TAU]),
            Self::Rulings(rulings) => {
                let Some((from, to)) = rulings.between else {
                    return Some([0.0, TAU]);
                };
                // From where it is far away.
                let edge = |pole: f64, middle: f64| {
                    let mut t = middle;
                    for _ in 0..50 {
                        if rulings.at(t).distance(around) >= 2.0 * reach {
                            break;
                        }
                        t = 0.5 * (t + pole);
                    }
                    t
                };
                let at = |share: f64| from + share * (to - from);
                Some([edge(from, at(0.01)), edge(to, at(0.99))])
            }
            Self::Hyperbola { center, a, b } => {
                // Both grow with e^|t| / 2, and across a by |b| sinh t.
                let far = (reach + (around - center).length()) / a.length().min(b.length());
                let end = elementary::asinh(far) + 1.0;
                Some([-end, end])
            }
            Self::Parabola { point, a, b, l, k } => {
                // Both along its axis and across.
                let far = reach + (around - point).length();
                let far = (far / a.length()).min((2.0 * far / b.length()).sqrt());
                // Not beyond where a goes back again: what is told about a point is near it.
                let far = far.min(0.5 / (l.abs() + k.abs().sqrt()));
                Some([-far, far].map(|number| of_share(number, [*l, *k])))
            }
        }
    }

    /// A box around the part between two places, infinite if none is known.
    pub fn bounds(&self, range: [f64; 2]) -> Bounds {
        let [min, max] = match self {
            Self::Line { .. } => {
                let [start, end] = range.map(|t| self.at(t));
                [start.min(end), start.max(end)]
            }
            Self::Rulings(_) => [DVec3::NEG_INFINITY, DVec3::INFINITY],
            &Self::Ellipse { center, a, b } => match rational::of_ellipse([center, a, b], range) {
                Some(control) => around_control(control),
                None => {
                    let reach = (a * a + b * b).map(f64::sqrt);
                    [center - reach, center + reach]
                }
            },
            &Self::Hyperbola { center, a, b } => {
                around_control(rational::of_hyperbola([center, a, b], range))
            }
            &Self::Parabola { point, a, b, l, k } => {
                around_control(rational::of_parabola([point, a, b], [l, k], range))
            }
        };
        Bounds { min, max }
    }

    /// Whether it is a polynomial of its parameter: a line or a parabola.
    pub fn is_polynomial(&self) -> bool {
        match *self {
            Self::Line { .. } => true,
            Self::Parabola { l, k, .. } => l == 0.0 && k == 0.0,
            _ => false,
        }
    }

    pub fn is_line(&self) -> bool {
        matches!(self, Self::Line { .. })
    }

    /// Whether it closes on itself.
    pub fn is_closed(&self) -> bool {
        match self {
            Self::Ellipse { .. } => true,
            Self::Rulings(rulings) => rulings.between.is_none(),
            _ => false,
        }
    }

    /// Into how many chords the curve should be cut between two places so that
    /// each turns by no more than about `turn` where its radius of curvature is
    /// `size`, and strays as far where it is another one, but turns by no more
    /// than three times that. So chords keep their order where curves touch.
    pub fn chords(&self, from: f64, to: f64, turn: f64, size: f64) -> u32 {
        let (total, length) = match self {
            Self::Line { .. } => return 1,
            Self::Ellipse { a, b, .. } => {
                (to - from, (to - from) * (a.length() * b.length()).sqrt())
            }
            _ => {
                const STEPS: u32 = 16;
                let place = |k: u32| from + f64::from(k) / f64::from(STEPS) * (to - from);
                let (mut total, mut length) = (0.0, 0.0);
                for k in 0..STEPS {
                    let [t, u] = [k, k + 1].map(place);
                    let directions = [t, u].map(|t| self.direction(t).normalize_or_zero());
                    total += directions[0].distance(directions[1]);
                    length += self.at(t).distance(self.at(u));
                }
                (total, length)
            }
        };
        if total == 0.0 {
            return 1;
        }
        let turn = turn * (size * total / length).sqrt().min(3.0);
        (total / turn).ceil().clamp(1.0, 1e4) as u32
    }

    /// Where a surface crosses the curve between two places: the only roots then. Distances
    /// below `on` are rounding, and closer than `near` without crossing is
    /// touching.
    pub(super) fn meet(
        &self,
        surface: &Surface,
        range: [f64; 2],
        tolerances: [f64; 2],
        roots: &mut Roots,
    ) -> Meets {
        self.meet_on(surface, [range; 2], tolerances, roots, || None)
    }

    /// The same, where it crosses, on a part of the two places alone. What is known of the places by
    /// simpler curves is asked where roots cannot be told apart.
    pub(super) fn meet_on(
        &self,
        surface: &Surface,
        ranges: [[f64; 2]; 2],
        tolerances: [f64; 2],
        roots: &mut Roots,
        known: impl FnOnce() -> Option<Known>,
    ) -> Meets {
        let meets = self.meet_near(surface, ranges, tolerances, roots, known);
        roots.keep_within(ranges[1]);
        meets
    }

    /// The same, and others perhaps.
    fn meet_near(
        &self,
        surface: &Surface,
        [range, part]: [[f64; 2]; 2],
        [on, near]: [f64; 2],
        roots: &mut Roots,
        known: impl FnOnce() -> Option<Known>,
    ) -> Meets {
        let [start, end] = range;
        match self {
            Self::Line { point, direction } => {
                let square = 0.5 * surface.curvature_along(*direction);
                // About the middle, for the sake of digits.
                let middle = 0.5 * (start + end);
                let gradient = surface.gradient(point + middle * direction);
                let linear = gradient.dot(*direction);
                let constant = surface.value(point + middle * direction);
                let half = 0.5 * (end - start);
                let slope = gradient.length().max(square.abs() * half);
                let most = constant.abs() + (linear.abs() + square.abs() * half) * half;
                if most <= on * slope {
                    return Meets::Curve;
                }
                let mut add = |t: f64| {
                    if start < t && t < end {
                        roots.simple.push(t);
                    }
                };
                if square.abs() * half * half <= 1e-3 * on * slope {
                    if linear != 0.0 {
                        add(middle - constant / linear);
                    }
                    return Meets::Points;
                }
                // About where the line runs along the surface, if that is on the stretch:
                // next to an apex or a thin one what is left there is less than the
                // rounding of values farther off.
                let expanded = |t: f64| {
                    let at = point + t * direction;
                    (surface.gradient(at).dot(*direction), surface.value(at))
                };
                let vertex = middle - linear / (2.0 * square);
                let is_within = start < vertex && vertex < end;
                let center = if is_within { vertex } else { middle };
                let (linear, constant) = expanded(center);
                let vertex = -linear / (2.0 * square);
                let lowest = constant - square * vertex * vertex;
                // A root is so far from there that f is as steep as this at it, however
                // flat it is between two of them that are close to each other.
                let across = surface.gradient(point + (center + vertex) * direction);
                let slope =
                    elementary::hypot(across.length(), 2.0 * (square * lowest).abs().sqrt());
                if lowest.abs() <= near * slope {
                    if is_within {
                        roots.touching.push(center + vertex);
                    }
                    return Meets::Points;
                }
                let discriminant = -4.0 * square * lowest;
                if discriminant > 0.0 {
                    let q = -0.5 * (linear + discriminant.sqrt().copysign(linear));
                    add(center + q / square);
                    add(center + constant / q);
                }
                Meets::Points
            }
            &Self::Ellipse { center, a, b } => {
                let form = Form::of(surface, center, a, b);
                // The gradient is linear in the point. Where the surface is thin it changes
                // by orders of magnitude along the curve, and only there tells what is near.
                let middle = surface.gradient(center);
                let [of_a, of_b] = [a, b].map(|d| surface.gradient(center + d) - middle);
                let steepest = middle.length() + of_a.length() + of_b.length();
                if form.is_clear_around(on.max(near) * steepest) {
                    return Meets::Points;
                }
                let trig = form.around();
                if trig.magnitude() <= on * (middle + of_a).length() {
                    return Meets::Curve;
                }
                // At an apex it tells nothing, and rounding is left.
                let rounding = POLYNOMIAL * trig.magnitude();
                let at = |t: f64| {
                    let (sin, cos) = elementary::sin_cos(t);
                    near * (middle + cos * of_a + sin * of_b).length() + rounding
                };
                let most = near * steepest + rounding;
                trig.roots_within(&Tolerance { at, most }, roots);
                Meets::Points
            }
            &Self::Hyperbola { center, a, b } => {
                let form = Form::of(surface, center, a, b);
                let [xx, yy, xy] = form.square;
                let [x, y] = form.linear;
                let value = |t: f64| {
                    let (c, s) = (elementary::cosh(t), elementary::sinh(t));
                    (xx * c + xy * s + x) * c + (yy * s + y) * s + form.constant
                };
                // The squares are those of cosh 2t and sinh 2t.
                let (even, odd) = (2.0 * (xx + yy), 2.0 * xy);
                let second = |t: f64| {
                    let twice = 2.0 * t;
                    even * elementary::cosh(twice)
                        + odd * elementary::sinh(twice)
                        + x * elementary::cosh(t)
                        + y * elementary::sinh(t)
                };
                let bend = |from: f64, to: f64| {
                    let far = from.abs().max(to.abs());
                    let squares = (even.abs() + odd.abs()) * elementary::cosh(2.0 * far);
                    let rest = (x.abs() + y.abs()) * elementary::cosh(far);
                    bend_within([from, to], squares + rest, second, 2.0 * squares + rest)
                };
                let terms = |t: f64| {
                    let (c, s) = (elementary::cosh(t), elementary::sinh(t).abs());
                    let squares = (xx * c).abs() + xy.abs() * s + x.abs();
                    squares * c + ((yy * s).abs() + y.abs()) * s + form.constant.abs()
                };
                let value = (value, terms);
                self.find(surface, [range, part], [on, near], value, bend, roots)
            }
            &Self::Parabola { point, a, b, l, k } => {
                let form = Form::of(surface, point, a, b);
                let [xx, yy, xy] = form.square;
                let [x, y] = form.linear;
                let c = form.constant;
                // Times (1 + l t + k t²)², which is about 1.
                let once = x + 2.0 * l * c;
                let square = xx + y + l * x + (l * l + 2.0 * k) * c;
                let cube = xy + k * x + l * (y + 2.0 * k * c);
                let fourth = yy + k * (y + k * c);
                let value = |t: f64| c + t * (once + t * (square + t * (cube + t * fourth)));
                let bend = |from: f64, to: f64| {
                    let far = from.abs().max(to.abs());
                    let most =
                        2.0 * square.abs() + far * (6.0 * cube.abs() + 12.0 * far * fourth.abs());
                    let second = |t: f64| 2.0 * square + t * (6.0 * cube + 12.0 * t * fourth);
                    let third = 6.0 * cube.abs() + 24.0 * far * fourth.abs();
                    bend_within([from, to], most, second, third)
                };
                let terms = |t: f64| {
                    let t = t.abs();
                    let high = square.abs() + t * (cube.abs() + t * fourth.abs());
                    c.abs() + t * (once.abs() + t * high)
                };
                let before = [roots.simple.len(), roots.touching.len()];
                let value = (value, terms);
                let meets = self.find(surface, [range, part], [on, near], value, bend, roots);
                let derivative = |order: usize, t: f64| match order {
                    1 => once + t * (2.0 * square + t * (3.0 * cube + t * 4.0 * fourth)),
                    2 => 2.0 * square + t * (6.0 * cube + t * 12.0 * fourth),
                    3 => 6.0 * cube + t * 24.0 * fourth,
                    _ => 24.0 * fourth,
                };
                /// How far places are off at most, of the range.
                const MOST_OFF: f64 = 1e-3;
                let nothing = |t: f64| near * surface.gradient(self.at(t)).length();
                let off = (nothing, MOST_OFF * (end - start));
                roots.tell_multiple(before, off, derivative);
                meets
            }
            Self::Rulings(rulings) => {
                self.meet_on_lines(rulings, surface, range, [on, near], roots, known)
            }
        }
    }

    /// The same of a curve on the lines of a quadric.
    fn meet_on_lines(
        &self,
        rulings: &Rulings,
        surface: &Surface,
        range: [f64; 2],
        [on, near]: [f64; 2],
        roots: &mut Roots,
        known: impl FnOnce() -> Option<Known>,
    ) -> Meets {
        if self.lies_in(surface, range, on) {
            return Meets::Curve;
        }
        // In homogeneous coordinates, where nothing is infinite.
        let power = if surface.is_plane() { 1 } else { 2 };
        let value = |t: f64| {
            let (at, weight) = rulings.weighted(t);
            surface.value(at) * weight.powi(power)
        };
        let tolerance = |t: f64| {
            let (at, weight) = rulings.weighted(t);
            near * surface.gradient(at).length() * weight.powi(power)
        };
        match rulings.candidates(surface, range) {
            Ok(mut candidates) => {
                if candidates.iter().any(|candidate| candidate.reach > 0.0)
                    && let Some(known) = known()
                {
                    rulings.tell_apart(&mut candidates, range, &known);
                }
                roots.find_at(&candidates, range, value, tolerance);
            }
            Err(Along::Within) => return Meets::Curve,
            Err(Along::Beside) => roots.is_lost = true,
        }
        Meets::Points
    }

    /// Adds where a surface's value along the curve is 0, given with the sum of its terms'
    /// magnitudes.
    fn find(
        &self,
        surface: &Surface,
        [range, part]: [[f64; 2]; 2],
        [on, near]: [f64; 2],
        (value, terms): (impl Fn(f64) -> f64, impl Fn(f64) -> f64),
        bend: impl Fn(f64, f64) -> f64,
        roots: &mut Roots,
    ) -> Meets {
        if self.lies_in(surface, range, on) {
            return Meets::Curve;
        }
        let tolerance = Tolerance {
            at: |t: f64| near * surface.gradient(self.at(t)).length() + VALUE * terms(t),
            most: f64::INFINITY,
        };
        roots.find_in_part(part, range[1] - range[0], value, bend, &tolerance);
        Meets::Points
    }

    /// Whether several points of the curve are on a surface.
    fn lies_in(&self, surface: &Surface, [start, end]: [f64; 2], on: f64) -> bool {
        const SAMPLES: u32 = 9;
        (0..SAMPLES).all(|k| {
            let t = start + (f64::from(k) + 0.37) / f64::from(SAMPLES) * (end - start);
            let at = self.at(t);
            surface.value(at).abs() <= on * surface.gradient(at).length()
        })
    }
}
