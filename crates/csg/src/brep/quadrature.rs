//! Integrals over patches of surfaces, by line integrals along their exact edges.
//!
//! In the coordinates of a chart the area integral of f is the line integral of
//! F dy around it, F the integral of f along x (Green). Both are taken by the rule of
//! Gauss and Legendre. dy/dt comes from the polynomial through the rule's own nodes, so
//! that of a curve nothing but its points need be known. Intervals are halved until
//! halving changes nothing any more.

use crate::elementary;
use std::sync::LazyLock;

use glam::{DVec2, DVec3};

use super::bounded::Bounded;
use super::chart::Chart;
use crate::numeric::tolerance::{CONVERGED, INTEGRAL};

/// The integrals over a face that the measures of a solid need: of p·n, and of p·n times
/// x, y, z, xx, yy, zz, xy, yz, zx, p counted from some point and n the outward normal; and
/// the area.
pub(super) type Integrals = [f64; 11];

/// What is integrated, at a point with a normal.
fn integrand(point: DVec3, normal: DVec3) -> Integrals {
    let along = point.dot(normal);
    let DVec3 { x, y, z } = point;
    let once = along * point;
    [
        along,
        once.x,
        once.y,
        once.z,
        once.x * x,
        once.y * y,
        once.z * z,
        once.x * y,
        once.y * z,
        once.z * x,
        normal.length(),
    ]
}

/// Integrals with bounds on their errors.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    pub values: Integrals,
    /// How much halving changed, and rounding.
    pub errors: Integrals,
}

impl Sum {
    pub fn add(&mut self, other: &Self) {
        for k in 0..self.values.len() {
            self.values[k] += other.values[k];
            self.errors[k] += other.errors[k];
        }
    }
}

/// A rule of Gauss and Legendre on the interval from 0 to 1.
struct Rule {
    nodes: Vec<f64>,
    weights: Vec<f64>,
    /// For each node the derivatives there of the polynomials that are 1 at one node and 0
    /// at all others.
    derivatives: Vec<Vec<f64>>,
}

impl Rule {
    fn new(count: usize) -> Self {
        let n = count as f64;
        let mut nodes = Vec::with_capacity(count);
        let mut weights = Vec::with_capacity(count);
        for k in 0..count {
            // Newton's method from Tricomi's guess.
            let mut x = elementary::cos(std::f64::consts::PI * (k as f64 + 0.75) / (n + 0.5));
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut before, mut here) = (1.0, x);
                for j in 2..=count {
                    let j = j as f64;
                    (before, here) = (here, ((2.0 * j - 1.0) * x * here - (j - 1.0) * before) / j);
                }
                slope = n * (x * here - before) / (x * x - 1.0);
                let step = here / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            nodes.push(0.5 - 0.5 * x);
            weights.push(1.0 / ((1.0 - x * x) * slope * slope));
        }
        let factor = |j: usize| -> f64 {
            let others = (0..count).filter(|&k| k != j);
            others.map(|k| nodes[j] - nodes[k]).product()
        };
        let factors: Vec<f64> = (0..count).map(factor).collect();
        let derivatives = (0..count).map(|i| {
            let mut row: Vec<f64> = (0..count)
                .map(|j| match i == j {
                    true => 0.0,
                    false => factors[i] / (factors[j] * (nodes[i] - nodes[j])),
                })
                .collect();
            row[i] = -row.iter().sum::<f64>();
            row
        });
        let derivatives = derivatives.collect();
        Self {
            nodes,
            weights,
            derivatives,
        }
    }
}

/// Along edges.
static ALONG: LazyLock<Rule> = LazyLock::new(|| Rule::new(12));
/// Exact for what is integrated over planes, across patches and along lines.
static FLAT: LazyLock<Rule> = LazyLock::new(|| Rule::new(2));
static COARSE: LazyLock<Rule> = LazyLock::new(|| Rule::new(14));
static FINE: LazyLock<Rule> = LazyLock::new(|| Rule::new(20));

/// Intervals are halved no more often: at a corner where the rest is not smooth, what is left
/// of it is a millionth.
const MOST_HALVINGS: u32 = 20;

/// And no more than so many of one stretch: then rounding is all that changes.
const MOST_STRIPS: u32 = 500;

/// The integrals between x = 0 and a stretch of a curve.
#[derive(Clone, Copy, Debug, Default)]
struct Strip {
    values: Integrals,
    /// What rounding may change, of the integrals and of where the curve is.
    noise: Integrals,
    /// Halving tells no more than this.
    least: Integrals,
}

/// A part of a stretch, and the integrals along it by its halves.
struct Part {
    places: [f64; 2],
    halvings: u32,
    halves: [Integrals; 2],
    sum: Sum,
    /// How much more halving changed than tells something, as a factor.
    excess: f64,
}

/// Lengths that integrals are measured by.
pub(super) struct Scale {
    /// The point that others are counted from.
    pub about: DVec3,
    /// Of the scene.
    pub size: f64,
    /// No curve is farther from where it should be.
    pub off: f64,
}

/// A stretch of a curve with a patch on its left.
struct Along<'a, C> {
    chart: &'a Chart<'a>,
    curve: C,
    /// How far off x and y may be.
    off: f64,
    scale: &'a Scale,
    sum: Sum,
    strips: u32,
}

/// The part of integrals over a patch that one of its edges gives: a curve, or a line, that runs
/// from one place to another with the patch on its left.
pub(super) fn along(
    chart: &Chart<'_>,
    curve: impl Fn(f64) -> DVec3,
    is_line: bool,
    places: [f64; 2],
    scale: &Scale,
) -> Sum {
    let off = chart.per_length() * scale.off;
    let mut along = Along {
        chart,
        curve,
        off,
        scale,
        sum: Sum::default(),
        strips: 0,
    };
    if is_line && chart.is_flat() {
        let Strip { values, noise, .. } = along.strip(places, &FLAT, &FLAT);
        along.sum = Sum {
            values,
            errors: noise,
        };
    } else {
        let once = along.strip(places, &ALONG, &COARSE);
        along.refine(places, &once.values);
    }
    // The strips between where it ends and where it should.
    for end in places {
        let row = row(
            chart,
            chart.flatten((along.curve)(end)),
            &COARSE,
            scale.about,
        );
        for (error, value) in along.sum.errors.iter_mut().zip(row) {
            *error += off * value.abs();
        }
    }
    along.sum
}

impl<C: Fn(f64) -> DVec3> Along<'_, C> {
    /// Adds the integrals along a stretch, of which a first estimate is known: that part of it is
    /// halved next for which halving changed most.
    fn refine(&mut self, places: [f64; 2], once: &Integrals) {
        let mut parts = vec![self.part(places, once, 0)];
        loop {
            let worst = parts
                .iter_mut()
                .filter(|part| part.excess > 1.0 && part.halvings < MOST_HALVINGS)
                .max_by(|a, b| a.excess.total_cmp(&b.excess));
            let Some(worst) = worst.filter(|_| self.strips <= MOST_STRIPS) else {
                break;
            };
            let [from, to] = worst.places;
            let middle = 0.5 * (from + to);
            let halvings = worst.halvings + 1;
            let [one, other] = worst.halves;
            *worst = self.part([from, middle], &one, halvings);
            parts.push(self.part([middle, to], &other, halvings));
        }
        for part in &parts {
            self.sum.add(&part.sum);
        }
    }

    /// A part of which an estimate is known, and what halving it changes.
    fn part(&mut self, [from, to]: [f64; 2], once: &Integrals, halvings: u32) -> Part {
        let middle = 0.5 * (from + to);
        let halves = [[from, middle], [middle, to]];
        let [a, b] = halves.map(|half| self.strip(half, &ALONG, &FINE));
        let both = |one: &Integrals, other: &Integrals| -> Integrals {
            std::array::from_fn(|k| one[k] + other[k])
        };
        let twice = both(&a.values, &b.values);
        let least = both(&a.least, &b.least);
        let noise = both(&a.noise, &b.noise);
        let change: Integrals = std::array::from_fn(|k| (twice[k] - once[k]).abs());
        let excess = (0..change.len()).map(|k| change[k] / least[k]);
        Part {
            places: [from, to],
            halvings,
            halves: [a.values, b.values],
            sum: Sum {
                values: twice,
                errors: both(&change, &noise),
            },
            excess: excess.fold(0.0, f64::max),
        }
    }

    fn strip(&mut self, [from, to]: [f64; 2], rule: &Rule, across: &Rule) -> Strip {
        self.strips += 1;
        let flat = |node: f64| self.chart.flatten((self.curve)(from + node * (to - from)));
        let points: Vec<DVec2> = rule.nodes.iter().map(|&node| flat(node)).collect();
        // Differences keep their digits about a point near by.
        let about = flat(0.5);
        // As many digits of y as coordinates in space have.
        let unit = self.chart.per_length() * self.scale.size;
        let mut strip = Strip::default();
        let mut beside = Integrals::default();
        for (k, point) in points.iter().enumerate() {
            let slopes = rule.derivatives[k].iter().zip(&points);
            let slope: DVec2 = slopes.map(|(&d, &p)| d * (p - about)).sum();
            // The patches on both sides would have to end in the same points.
            let aside = rule.weights[k] * slope.length() * self.off;
            let slope = slope.y;
            let at = self.chart.lift(*point);
            for (beside, value) in beside
                .iter_mut()
                .zip(integrand(at - self.scale.about, self.chart.normal(at)))
            {
                *beside += aside * value.abs();
            }
            let row = row(self.chart, *point, across, self.scale.about);
            for (j, value) in row.into_iter().enumerate() {
                let term = self.chart.turn() * rule.weights[k] * value;
                strip.values[j] += term * slope;
                strip.noise[j] += INTEGRAL * (term * slope).abs();
                strip.least[j] += INTEGRAL * (term * unit).abs();
            }
        }
        for (j, (least, noise)) in strip.least.iter_mut().zip(strip.noise).enumerate() {
            let power = match j {
                0 => 3,
                1..=3 => 4,
                4..=9 => 5,
                _ => 2,
            };
            *least += noise + CONVERGED * self.scale.size.powi(power);
        }
        for (noise, beside) in strip.noise.iter_mut().zip(beside) {
            *noise += beside;
        }
        strip
    }
}

/// The length of a curve between two places, whose points may be off by some length.
pub(super) fn length(curve: impl Fn(f64) -> DVec3, places: [f64; 2], off: f64) -> Bounded {
    Lengths::of(|stretch| chord(&curve, stretch), places, off)
}

/// The length of an arc of an ellipse that is given by its half axes, from one angle to
/// another, to all digits: the speed is known exactly, and its logarithm is steepest beside the ends
/// of the long axis, in some (short / long) radians, so that a halving for each power of two in
/// that is enough.
pub(super) fn arc_length([long, short]: [f64; 2], places: [f64; 2]) -> Bounded {
    let speed = |angle: f64| {
        let (sin, cos) = elementary::sin_cos(angle);
        elementary::hypot(long * sin, short * cos)
    };
    let rule = &*ALONG;
    let stretch = |[from, to]: [f64; 2]| {
        let terms = rule.nodes.iter().zip(&rule.weights);
        let term = |(node, weight): (&f64, &f64)| weight * speed(from + node * (to - from));
        (to - from).abs() * terms.map(term).sum::<f64>()
    };
    Lengths::of(stretch, places, 0.0)
}

/// Lengths of stretches of a curve that are summed up.
struct Lengths<F> {
    /// An estimate for a stretch.
    stretch: F,
    /// Halving tells no more than this.
    least: f64,
    sum: Bounded,
}

impl<F: Fn([f64; 2]) -> f64> Lengths<F> {
    fn of(stretch: F, places: [f64; 2], off: f64) -> Bounded {
        let once = stretch(places);
        let mut lengths = Self {
            stretch,
            least: INTEGRAL * once + off,
            sum: Bounded::default(),
        };
        lengths.halve(places, once, 0);
        lengths.sum
    }

    fn halve(&mut self, [from, to]: [f64; 2], once: f64, halvings: u32) {
        let middle = 0.5 * (from + to);
        let halves = [[from, middle], [middle, to]];
        let twice = halves.map(|half| (self.stretch)(half));
        let length = twice[0] + twice[1];
        let change = (length - once).abs();
        if change <= self.least || halvings == MOST_HALVINGS {
            self.sum.value += length;
            self.sum.error += change + INTEGRAL * length;
            return;
        }
        for (half, once) in halves.into_iter().zip(twice) {
            self.halve(half, once, halvings + 1);
        }
    }
}

/// The area that the line from a point to one that runs along a curve sweeps over, above 0
/// where it turns counter-clockwise, as the sum of some panels.
pub(super) fn swept(
    curve: impl Fn(f64) -> DVec2,
    [from, to]: [f64; 2],
    about: DVec2,
    panels: u32,
) -> f64 {
    let step = (to - from) / f64::from(panels);
    let panels = (0..panels).map(|k| from + f64::from(k) * step);
    panels.map(|at| sweep(&curve, [at, at + step], about)).sum()
}

/// The same, by one rule.
fn sweep(curve: &impl Fn(f64) -> DVec2, [from, to]: [f64; 2], about: DVec2) -> f64 {
    let rule = &*ALONG;
    let at = |&node: &f64| curve(from + node * (to - from)) - about;
    let points: Vec<DVec2> = rule.nodes.iter().map(at).collect();
    let terms = rule.derivatives.iter().zip(&points).zip(&rule.weights);
    let term = |((row, point), weight): ((&Vec<f64>, &DVec2), &f64)| {
        let slope: DVec2 = row.iter().zip(&points).map(|(&d, &p)| d * p).sum();
        weight * point.perp_dot(slope)
    };
    0.5 * terms.map(term).sum::<f64>()
}

/// The length of a stretch, by one rule.
fn chord(curve: &impl Fn(f64) -> DVec3, [from, to]: [f64; 2]) -> f64 {
    let rule = &*ALONG;
    let about = curve(0.5 * (from + to));
    let at = |&node: &f64| curve(from + node * (to - from)) - about;
    let points: Vec<DVec3> = rule.nodes.iter().map(at).collect();
    let speeds = rule.derivatives.iter().map(|row| {
        let slope: DVec3 = row.iter().zip(&points).map(|(&d, &p)| d * p).sum();
        slope.length()
    });
    speeds.zip(&rule.weights).map(|(s, w)| s * w).sum()
}

/// The integrals along x, from 0 to a point.
fn row(chart: &Chart<'_>, end: DVec2, across: &Rule, about: DVec3) -> Integrals {
    let mut sums = Integrals::default();
    let (rule, panels) = if chart.is_flat() {
        (&*FLAT, 1.0)
    } else {
        // Graphs are known as far around a point as it is from the axis, or more.
        (
            across,
            (end.x.abs() / elementary::hypot(end.y, 1.0))
                .ceil()
                .clamp(1.0, 1e3),
        )
    };
    let width = end.x / panels;
    for panel in 0..panels as u32 {
        for (node, weight) in rule.nodes.iter().zip(&rule.weights) {
            let x = width * (f64::from(panel) + node);
            let point = chart.lift(DVec2::new(x, end.y));
            let values = integrand(point - about, chart.normal(point));
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += weight * width * value;
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_for_polynomials_and_their_derivatives() {
        for count in [2, 3, 12, 20] {
            let rule = Rule::new(count);
            for power in 0..2 * count as i32 {
                let terms = rule.nodes.iter().zip(&rule.weights);
                let sum: f64 = terms.map(|(x, w)| w * x.powi(power)).sum();
                assert!(
                    (sum - 1.0 / f64::from(power + 1)).abs() < 1e-15,
                    "{count} {power}"
                );
            }
            for power in 1..count as i32 {
                for (x, row) in rule.nodes.iter().zip(&rule.derivatives) {
                    let terms = rule.nodes.iter().zip(row);
                    let slope: f64 = terms.map(|(x, d)| d * x.powi(power)).sum();
                    let wanted = f64::from(power) * x.powi(power - 1);
                    assert!((slope - wanted).abs() < 1e-12, "{count} {power}");
                }
            }
        }
    }

    /// By the means of the arithmetic and the geometric kind (Gauss; NIST's library of functions,
    /// 19.8.6), which double the digits with every step.
    fn around(long: f64, short: f64) -> f64 {
        let (mut a, mut g) = (long, short);
        let (mut sum, mut power) = (long * long - 0.5 * (long * long - short * short), 0.5);
        for _ in 0..40 {
            let c = 0.5 * (a - g);
            (a, g) = (0.5 * (a + g), (a * g).sqrt());
            power *= 2.0;
            sum -= power * c * c;
        }
        std::f64::consts::TAU / a * sum
    }

    #[test]
    fn arcs_of_ellipses_are_as_long_as_they_are_however_flat() {
        for short in [1.0, 0.3, 0.04, 1e-3, 1e-6] {
            let axes = [603.0, 603.0 * short];
            let wanted = around(axes[0], axes[1]);
            let whole = arc_length(axes, [0.0, std::f64::consts::TAU]);
            let off = (whole.value - wanted).abs();
            assert!(
                off <= whole.error + 1e-14 * wanted,
                "{short}: {whole:?}, not {wanted}"
            );
            assert!(whole.error < 1e-12 * wanted, "{short}: {whole:?}");
            // A short arc beside the end of the long axis.
            let [one, rest] = [[-0.01, 0.02], [0.02, std::f64::consts::TAU - 0.01]];
            let [one, rest] = [one, rest].map(|places| arc_length(axes, places));
            let off = (one.value + rest.value - wanted).abs();
            assert!(off < 1e-12 * wanted, "{short}: {one:?} {rest:?}");
            assert!(one.error < 1e-12 * one.value, "{short}: {one:?}");
        }
    }
}
