//! All roots of a smooth function on an interval, none of them missed.
//!
//! Intervals are halved until a bound on the second derivative tells that the
//! function has no root in them, or is monotonic and has as many as its signs
//! at the ends do (the exclusion test of interval bisection: Moore, *Interval
//! Analysis*, 1966).

use std::f64::consts::TAU;

/// Where a function is 0.
#[derive(Debug, Default)]
pub(super) struct Roots {
    /// Where its sign changes.
    pub simple: Vec<f64>,
    /// Where it comes near 0, or changes sign more often than can be told.
    pub touching: Vec<f64>,
    /// Whether there are so many of the latter that the function is next to 0 on
    /// a stretch: then not all were looked for.
    pub is_lost: bool,
}

impl Roots {
    pub fn clear(&mut self) {
        self.simple.clear();
        self.touching.clear();
        self.is_lost = false;
    }

    /// Adds the roots between `start` and `end` of a function whose second
    /// derivative between two places is at most `bend` of them. Values below
    /// `tolerance` are rounding.
    pub fn find(
        &mut self,
        [start, end]: [f64; 2],
        value: impl Fn(f64) -> f64,
        bend: impl Fn(f64, f64) -> f64,
        tolerance: f64,
    ) {
        /// Intervals to begin with.
        const PARTS: u32 = 8;
        /// Halvings until roots that are still together are one.
        const MOST_HALVINGS: u32 = 40;
        const MOST_TOUCHING: usize = 32;
        let at = |k: u32| start + f64::from(k) / f64::from(PARTS) * (end - start);
        let mut pending: Vec<(f64, f64, f64, f64, u32)> = Vec::with_capacity(64);
        let mut from = (start, value(start));
        for k in 1..=PARTS {
            let to = if k == PARTS { end } else { at(k) };
            let to = (to, value(to));
            pending.push((from.0, from.1, to.0, to.1, 0));
            from = to;
        }
        while let Some((a, at_a, b, at_b, halvings)) = pending.pop() {
            let width = b - a;
            let bend = bend(a, b);
            let off = 0.125 * bend * width * width;
            let differ = (at_a <= 0.0) != (at_b <= 0.0);
            let least = at_a.abs().min(at_b.abs());
            if !differ && least > off + tolerance {
                continue;
            }
            let is_monotonic = (at_b - at_a).abs() > bend * width * width;
            // Away from both ends by more than rounding, a root is safe.
            if is_monotonic && !differ && least > tolerance {
                continue;
            }
            if is_monotonic && differ {
                self.simple.push(bracketed(&value, [a, b], [at_a, at_b]));
                continue;
            }
            if halvings == MOST_HALVINGS || off <= 0.1 * tolerance {
                self.touching.push(0.5 * (a + b));
                if self.touching.len() > MOST_TOUCHING {
                    self.is_lost = true;
                    return;
                }
                if differ {
                    self.simple.push(0.5 * (a + b));
                }
                continue;
            }
            let middle = 0.5 * (a + b);
            let at_middle = value(middle);
            pending.push((middle, at_middle, b, at_b, halvings + 1));
            pending.push((a, at_a, middle, at_middle, halvings + 1));
        }
    }
}

/// The root between two places of different sign, by the method of Ridders (*A
/// New Algorithm for Computing a Single Root of a Real Continuous Function*,
/// 1979).
fn bracketed(value: impl Fn(f64) -> f64, [mut a, mut b]: [f64; 2], ends: [f64; 2]) -> f64 {
    const MOST_STEPS: u32 = 60;
    let [mut at_a, mut at_b] = ends;
    let mut best = if at_a.abs() < at_b.abs() { a } else { b };
    for _ in 0..MOST_STEPS {
        let middle = 0.5 * (a + b);
        if at_a == 0.0 {
            return a;
        }
        if at_b == 0.0 {
            return b;
        }
        if middle <= a || middle >= b {
            break;
        }
        let at_middle = value(middle);
        let root = (at_middle * at_middle - at_a * at_b).sqrt();
        let new = middle + (middle - a) * (at_a - at_b).signum() * at_middle / root;
        if !new.is_finite() || at_middle == 0.0 {
            return middle;
        }
        let new = new.clamp(a, b);
        let at_new = value(new);
        let done = (new - best).abs() <= 2.0 * f64::EPSILON * (b.abs() + a.abs());
        best = new;
        if at_new == 0.0 || done {
            break;
        }
        let ([low, high], [at_low, at_high]) = if new < middle {
            ([new, middle], [at_new, at_middle])
        } else {
            ([middle, new], [at_middle, at_new])
        };
        // Of the three intervals the one where the sign changes.
        let is_negative = |v: f64| v <= 0.0;
        if is_negative(at_low) != is_negative(at_high) {
            (a, b, at_a, at_b) = (low, high, at_low, at_high);
        } else if is_negative(at_a) != is_negative(at_low) {
            (b, at_b) = (low, at_low);
        } else {
            (a, at_a) = (high, at_high);
        }
    }
    best
}

/// constant + c₁ cos t + s₁ sin t + c₂ cos 2t + s₂ sin 2t.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Trig {
    pub constant: f64,
    pub once: [f64; 2],
    pub twice: [f64; 2],
}

impl Trig {
    /// x² cos² t + y² sin² t + xy cos t sin t + x cos t + y sin t + 1, by its
    /// coefficients.
    pub fn of_form([xx, yy, xy]: [f64; 3], [x, y]: [f64; 2], constant: f64) -> Self {
        Self {
            constant: constant + 0.5 * (xx + yy),
            once: [x, y],
            twice: [0.5 * (xx - yy), 0.5 * xy],
        }
    }

    /// The one that takes the same values as a function that is one.
    pub fn through(value: impl Fn(f64) -> f64) -> Self {
        const PLACES: u32 = 5;
        let mut sum = Self::default();
        for k in 0..PLACES {
            let t = f64::from(k) / f64::from(PLACES) * TAU;
            let value = value(t) / f64::from(PLACES);
            sum.constant += value;
            let both = |t: f64| [2.0 * value * t.cos(), 2.0 * value * t.sin()];
            let (once, twice) = (both(t), both(2.0 * t));
            for i in 0..2 {
                sum.once[i] += once[i];
                sum.twice[i] += twice[i];
            }
        }
        sum
    }

    pub fn value(&self, t: f64) -> f64 {
        let (sin, cos) = t.sin_cos();
        let twice = self.twice[0] * (cos - sin) * (cos + sin) + self.twice[1] * 2.0 * sin * cos;
        self.constant + self.once[0] * cos + self.once[1] * sin + twice
    }

    /// No value is farther from 0.
    pub fn magnitude(&self) -> f64 {
        let [a, b] = [self.once, self.twice].map(|[c, s]| c.hypot(s));
        self.constant.abs() + a + b
    }

    /// Whether it is positive somewhere, by more than rounding.
    pub fn is_ever_positive(&self) -> bool {
        const SAMPLES: u32 = 32;
        let limit = 1e-6 * self.magnitude();
        (0..SAMPLES).any(|k| self.value(f64::from(k) / f64::from(SAMPLES) * TAU) > limit)
    }

    /// The square of a polynomial that has no double angles.
    pub fn squared(&self) -> Self {
        let ([c, s], k) = (self.once, self.constant);
        Self::of_form(
            [c * c, s * s, 2.0 * c * s],
            [2.0 * k * c, 2.0 * k * s],
            k * k,
        )
    }

    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let add = |a: [f64; 2], b: [f64; 2]| [a[0] + factor * b[0], a[1] + factor * b[1]];
        Self {
            constant: self.constant + factor * other.constant,
            once: add(self.once, other.once),
            twice: add(self.twice, other.twice),
        }
    }

    /// Where the derivative is 0, by Newton's method.
    fn extremum_near(&self, start: f64) -> f64 {
        const STEPS: u32 = 4;
        let mut t = start;
        for _ in 0..STEPS {
            let ((sin, cos), (sin2, cos2)) = (t.sin_cos(), (2.0 * t).sin_cos());
            let ([c, s], [c2, s2]) = (self.once, self.twice);
            let first = s * cos - c * sin + 2.0 * (s2 * cos2 - c2 * sin2);
            let second = -(c * cos + s * sin) - 4.0 * (c2 * cos2 + s2 * sin2);
            let step = first / second;
            if step.abs() < 1e-3 {
                t -= step;
            } else {
                return start;
            }
        }
        t
    }

    /// Adds the roots from 0 to 2π.
    pub fn roots(&self, tolerance: f64, roots: &mut Roots) {
        let [once, twice] = [self.once, self.twice].map(|[c, s]| c.hypot(s));
        if self.constant.abs() > once + twice + tolerance {
            return;
        }
        if twice > 1e-3 * tolerance {
            let bend = |_: f64, _: f64| once + 4.0 * twice;
            let before = roots.touching.len();
            roots.find([0.0, TAU], |t| self.value(t), bend, tolerance);
            for touching in &mut roots.touching[before..] {
                *touching = self.extremum_near(*touching);
            }
            // Intervals on both sides of one may have found it.
            roots.touching.sort_by(f64::total_cmp);
            roots.touching.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            return;
        }
        let middle = self.once[1].atan2(self.once[0]);
        if (self.constant.abs() - once).abs() <= tolerance {
            let touching = if self.constant > 0.0 {
                middle + TAU / 2.0
            } else {
                middle
            };
            roots.touching.push(touching.rem_euclid(TAU));
            return;
        }
        let half = (-self.constant / once).acos();
        for root in [middle - half, middle + half] {
            roots.simple.push(root.rem_euclid(TAU));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Of a product of linear factors in cos and sin, whose roots are known.
    #[test]
    fn trigonometric_roots_are_all_found() {
        let mut random = Random(1);
        let mut found = 0;
        for _ in 0..2000 {
            let mut four = || -> [f64; 4] { std::array::from_fn(|_| random.unit() * TAU) };
            let [a, b, c, d] = four();
            // sin((t-a)/2) sin((t-b)/2) is of degree one; its roots are a, b.
            let degree_one = |a: f64, b: f64| Trig {
                constant: 0.5 * (0.5 * (a - b)).cos(),
                once: [-0.5 * (0.5 * (a + b)).cos(), -0.5 * (0.5 * (a + b)).sin()],
                twice: [0.0; 2],
            };
            let (first, second) = (degree_one(a, b), degree_one(c, d));
            // 4 f g = (f + g)² - (f - g)².
            let product = first.plus(1.0, &second).squared();
            let product = product.plus(-1.0, &first.plus(-1.0, &second).squared());
            let mut wanted = vec![a, b, c, d];
            wanted.sort_by(f64::total_cmp);
            let mut roots = Roots::default();
            product.roots(1e-14, &mut roots);
            roots.simple.sort_by(f64::total_cmp);
            if !roots.touching.is_empty() {
                continue;
            }
            found += 1;
            assert_eq!(roots.simple.len(), 4, "{wanted:?}: {:?}", roots.simple);
            for (root, wanted) in roots.simple.iter().zip(&wanted) {
                assert!((root - wanted).abs() < 1e-6, "{root} {wanted}");
            }
        }
        assert!(found > 1900, "{found}");
    }
}
