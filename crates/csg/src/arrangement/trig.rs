//! Trigonometric polynomials of low degree and their roots.

use crate::elementary;
use std::f64::consts::TAU;

use super::roots::{Roots, Tolerance, bend_within};

/// Closed curves begin so far from the axes of symmetry, in radians, that they
/// begin on no other surface of a symmetric model.
pub(super) const BEGIN: f64 = 0.777_312_5;

/// How far places where a polynomial comes near 0 are off at most, in radians: within 1e-9 of 0 it is
/// around a root of multiplicity four on 6e-3 to both sides.
const MOST_OFF: f64 = 1e-2;

/// The highest degree there is.
const DEGREE: usize = 8;

/// Σ cₖ cos kt + sₖ sin kt, k = 0, …, 8.
///
/// That is the real part of Σ (cₖ - i sₖ) zᵏ on the unit circle z = exp it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Trig {
    /// cₖ and sₖ; s₀ is 0.
    terms: [[f64; 2]; DEGREE + 1],
    degree: usize,
}

impl Trig {
    pub fn constant(value: f64) -> Self {
        let mut sum = Self::default();
        sum.terms[0][0] = value;
        sum
    }

    /// constant + c cos t + s sin t, by all three.
    pub fn linear([constant, c, s]: [f64; 3]) -> Self {
        let mut sum = Self::constant(constant);
        sum.terms[1] = [c, s];
        sum.degree = 1;
        sum
    }

    /// x² cos² t + y² sin² t + xy cos t sin t + x cos t + y sin t + 1, by its
    /// coefficients.
    pub fn of_form([xx, yy, xy]: [f64; 3], [x, y]: [f64; 2], constant: f64) -> Self {
        let mut sum = Self::linear([constant + 0.5 * (xx + yy), x, y]);
        sum.terms[2] = [0.5 * (xx - yy), 0.5 * xy];
        sum.degree = 2;
        sum
    }

    /// The one of degree two that takes the same values as a function that is
    /// one.
    pub fn through(value: impl Fn(f64) -> f64) -> Self {
        const PLACES: u32 = 5;
        let mut sum = Self {
            degree: 2,
            ..Self::default()
        };
        for place in 0..PLACES {
            let t = f64::from(place) / f64::from(PLACES) * TAU;
            let value = value(t) / f64::from(PLACES);
            sum.terms[0][0] += value;
            for k in [1, 2] {
                let (sin, cos) = elementary::sin_cos(k as f64 * t);
                sum.terms[k][0] += 2.0 * value * cos;
                sum.terms[k][1] += 2.0 * value * sin;
            }
        }
        sum
    }

    pub fn value(&self, t: f64) -> f64 {
        self.value_at(elementary::sin_cos(t))
    }

    /// The value where the sine and the cosine are known.
    pub fn value_at(&self, (sin, cos): (f64, f64)) -> f64 {
        // Horner's rule.
        let [mut re, mut im] = [0.0; 2];
        for k in (1..=self.degree).rev() {
            let [c, s] = self.terms[k];
            let (x, y) = (re + c, im - s);
            (re, im) = (x * cos - y * sin, x * sin + y * cos);
        }
        re + self.terms[0][0]
    }

    /// No value is farther from 0.
    pub fn magnitude(&self) -> f64 {
        self.amplitudes().sum()
    }

    fn amplitudes(&self) -> impl Iterator<Item = f64> {
        let terms = self.terms[..=self.degree].iter();
        terms.map(|[c, s]| (c * c + s * s).sqrt())
    }

    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let mut sum = *self;
        sum.degree = self.degree.max(other.degree);
        for (mine, theirs) in sum.terms.iter_mut().zip(other.terms) {
            mine[0] += factor * theirs[0];
            mine[1] += factor * theirs[1];
        }
        sum
    }

    /// The product; of the degrees the sum must be at most eight.
    pub fn times(&self, other: &Self) -> Self {
        let mut product = Self {
            degree: (self.degree + other.degree).min(DEGREE),
            ..Self::default()
        };
        for (k, [c, s]) in self.terms[..=self.degree].iter().enumerate() {
            for (l, [d, r]) in other.terms[..=other.degree].iter().enumerate() {
                if k + l > DEGREE {
                    continue;
                }
                let (cc, ss, cs, sc) = (0.5 * c * d, 0.5 * s * r, 0.5 * c * r, 0.5 * s * d);
                product.terms[k + l][0] += cc - ss;
                product.terms[k + l][1] += cs + sc;
                let between = &mut product.terms[k.abs_diff(l)];
                between[0] += cc + ss;
                between[1] += if k > l { sc - cs } else { cs - sc };
            }
        }
        product.terms[0][1] = 0.0;
        product
    }

    pub fn derivative(&self) -> Self {
        let mut derivative = *self;
        for (k, term) in derivative.terms.iter_mut().enumerate() {
            let [c, s] = *term;
            *term = [k as f64 * s, -(k as f64) * c];
        }
        derivative
    }

    /// Of a polynomial that is 0 at `middle` - `half` and `middle` + `half` its
    /// quotient by cos(t - middle) - cos(half).
    pub fn without_roots(&self, middle: f64, half: f64) -> Self {
        // With z = exp i(t - middle) the divisor is (z - 2 cos half + 1/z) / 2:
        // from the highest power down.
        let shifted = |k: usize| {
            let ([c, s], (sin, cos)) = (self.terms[k], elementary::sin_cos(k as f64 * middle));
            [c * cos + s * sin, s * cos - c * sin]
        };
        let twice = 2.0 * elementary::cos(half);
        let mut quotient = Self {
            degree: self.degree.saturating_sub(1),
            ..Self::default()
        };
        let mut above = [[0.0; 2]; 2];
        for k in (0..self.degree).rev() {
            let high = shifted(k + 1);
            let term = |i: usize| 2.0 * high[i] + twice * above[0][i] - above[1][i];
            above = [[term(0), term(1)], above[0]];
            quotient.terms[k] = above[0];
        }
        // The constant has no second half.
        quotient.terms[0] = [0.5 * quotient.terms[0][0], 0.0];
        let turned = |k: usize| {
            let ([c, s], (sin, cos)) = (quotient.terms[k], elementary::sin_cos(k as f64 * middle));
            [c * cos - s * sin, s * cos + c * sin]
        };
        Self {
            terms: std::array::from_fn(turned),
            ..quotient
        }
    }

    fn derivative_at(&self, order: usize, t: f64) -> f64 {
        let terms = self.terms[..=self.degree].iter().enumerate();
        let terms = terms.map(|(k, [c, s])| {
            let (sin, cos) = elementary::sin_cos(k as f64 * t);
            let (own, next) = (c * cos + s * sin, s * cos - c * sin);
            let turned = [own, next, -own, -next][order % 4];
            (k as f64).powi(order as i32) * turned
        });
        terms.sum()
    }

    /// A place that is no root, nor near one, so that a search all around from there
    /// meets each root once. Surfaces are often placed such that 0 is one.
    fn clear_start(&self, tolerance: f64) -> f64 {
        let places = (0..=2 * DEGREE).map(|k| BEGIN + k as f64);
        let mut clear = places.filter(|&t| self.value(t).abs() > 2.0 * tolerance);
        clear.next().unwrap_or(BEGIN)
    }

    /// Adds the roots from 0 to 2π, simple and touching ones each in order, and each
    /// once though the function has a period. Values within `tolerance` are as good as 0.
    pub(super) fn roots(&self, tolerance: f64, roots: &mut Roots) {
        self.roots_within(&Tolerance::everywhere(tolerance), roots);
    }

    /// The same, with a tolerance that depends on the place.
    pub(super) fn roots_within(
        &self,
        tolerance: &Tolerance<impl Fn(f64) -> f64>,
        roots: &mut Roots,
    ) {
        let start = self.clear_start(tolerance.most);
        self.roots_on([start, start + TAU], tolerance, roots);
    }

    /// The same of a part of the angles, and it may be others besides.
    pub(super) fn roots_on(
        &self,
        range: [f64; 2],
        tolerance: &Tolerance<impl Fn(f64) -> f64>,
        roots: &mut Roots,
    ) {
        let constant = self.terms[0][0];
        let mut amplitudes = [0.0; DEGREE + 1];
        for (slot, amplitude) in amplitudes.iter_mut().zip(self.amplitudes()) {
            *slot = amplitude;
        }
        let [_, once, higher @ ..] = amplitudes;
        let higher_sum: f64 = higher.iter().sum();
        if constant.abs() > once + higher_sum + tolerance.most {
            return;
        }
        if higher_sum > 1e-3 * tolerance.most {
            let most = |power: i32| {
                let powers = (2..).map(|k: u32| f64::from(k).powi(power));
                once + higher.iter().zip(powers).map(|(a, k)| a * k).sum::<f64>()
            };
            let (most, third) = (most(2), most(3));
            let second = self.derivative().derivative();
            let bend =
                |from: f64, to: f64| bend_within([from, to], most, |t| second.value(t), third);
            let before = [roots.simple.len(), roots.touching.len()];
            roots.find_in_part(range, TAU, |t| self.value(t), bend, tolerance);
            roots.tell_multiple(before, (&tolerance.at, MOST_OFF), |order, t| {
                self.derivative_at(order, t)
            });
            let found = [
                &mut roots.simple[before[0]..],
                &mut roots.touching[before[1]..],
            ];
            for places in found {
                for place in places.iter_mut() {
                    *place = place.rem_euclid(TAU);
                }
                places.sort_unstable_by(f64::total_cmp);
            }
            return;
        }
        let middle = elementary::atan2(self.terms[1][1], self.terms[1][0]);
        let touching = if constant > 0.0 {
            middle + TAU / 2.0
        } else {
            middle
        };
        if (constant.abs() - once).abs() <= (tolerance.at)(touching) {
            roots.touching.push(touching.rem_euclid(TAU));
            return;
        }
        if constant.abs() > once {
            return;
        }
        let half = elementary::acos(-constant / once);
        for root in [middle - half, middle + half] {
            roots.simple.push(root.rem_euclid(TAU));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// sin((t-a)/2) sin((t-b)/2) is of degree one; its roots are a and b.
    fn with_roots([a, b]: [f64; 2]) -> Trig {
        let (sin, cos) = (0.5 * (a + b)).sin_cos();
        Trig::linear([0.5 * (0.5 * (a - b)).cos(), -0.5 * cos, -0.5 * sin])
    }

    #[test]
    fn roots_where_the_search_might_begin_are_found_once() {
        for at in [0.0, BEGIN, 0.25 * TAU, 0.5 * TAU] {
            let touching = with_roots([at, at]).times(&with_roots([at + 1.0, at + 2.0]));
            let mut roots = Roots::default();
            touching.roots(1e-12, &mut roots);
            assert_eq!(roots.touching.len(), 1, "{at}: {roots:?}");
            assert_eq!(roots.simple.len(), 2, "{at}: {roots:?}");
            let off = (roots.touching[0] - at + 1.0).rem_euclid(TAU) - 1.0;
            assert!(off.abs() < 1e-9, "{at}: {roots:?}");
        }
    }

    #[test]
    fn roots_of_products_are_all_found() {
        let mut random = Random(1);
        let mut found = 0;
        for case in 0..2000 {
            let mut pair = || -> [f64; 2] { std::array::from_fn(|_| random.unit() * TAU) };
            let pairs: Vec<[f64; 2]> = (0..1 + case % 4).map(|_| pair()).collect();
            let product = pairs
                .iter()
                .fold(Trig::constant(1.0), |p, &pair| p.times(&with_roots(pair)));
            let mut wanted = pairs.concat();
            wanted.sort_by(f64::total_cmp);
            let mut roots = Roots::default();
            product.roots(1e-14, &mut roots);
            roots.simple.sort_by(f64::total_cmp);
            if !roots.touching.is_empty() {
                continue;
            }
            found += 1;
            assert_eq!(
                roots.simple.len(),
                wanted.len(),
                "{wanted:?}: {:?}",
                roots.simple
            );
            for (root, wanted) in roots.simple.iter().zip(&wanted) {
                assert!((root - wanted).abs() < 1e-6, "{root} {wanted}");
            }
            let [a, b] = pairs[0];
            let quotient = product.without_roots(0.5 * (a + b), 0.5 * (a - b));
            for k in 0..20 {
                let t = 0.3 * f64::from(k);
                let divisor = (t - 0.5 * (a + b)).cos() - (0.5 * (a - b)).cos();
                let off = quotient.value(t) * divisor - product.value(t);
                assert!(off.abs() < 1e-12, "{off}");
            }
        }
        assert!(found > 1800, "{found}");
    }
}
