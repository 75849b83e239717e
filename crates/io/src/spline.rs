//! Curves without a short equation, as B-splines.

use csg::elementary;
use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::DVec3;

/// A B-spline of degree five whose second derivative goes on and on.
#[derive(Clone, Debug)]
pub(crate) struct Spline {
    /// From 0 to 1; the first and the last are six times there, the others three times.
    pub knots: Vec<f64>,
    pub points: Vec<DVec3>,
}

impl Spline {
    /// Its point, by de Boor's algorithm.
    pub fn at(&self, u: f64) -> DVec3 {
        let last = self.knots.len() - 1;
        // In which span, and the knots about it, as often as they are there.
        let span = self.knots[1..last].partition_point(|&knot| knot <= u);
        let knot = |index: usize| {
            // (The first is there six times.)
            let distinct = if index < 6 { 0 } else { 1 + (index - 6) / 3 };
            self.knots[distinct.min(last)]
        };
        let k = 5 + 3 * span;
        let mut d: [DVec3; 6] = std::array::from_fn(|j| self.points[k - 5 + j]);
        for r in 1..=5 {
            for j in (r..=5).rev() {
                let (a, b) = (knot(j + k - 5), knot(j + 1 + k - r));
                d[j] = d[j - 1].lerp(d[j], (u - a) / (b - a));
            }
        }
        d[5]
    }
}

/// A point of a curve and its first two derivatives.
type Jet = [DVec3; 3];

/// No curve is cut into more spans.
const MOST_SPANS: usize = 4096;

/// Shorter spans at an end tell of a root there.
const SHORT: f64 = 1e-5;

/// A spline through points of a curve, from its first end to its last, that strays from it by
/// no more than a tolerance; none if none is found.
///
/// Each span has the curve's point and first two derivatives at its ends (Hermite), so its
/// error falls with the sixth power of its length. Derivatives are those of the polynomial
/// through points of Chebyshev's on each span. Spans are halved until points between these
/// are near enough.
pub(crate) fn fit(at: impl Fn(f64) -> DVec3, range: [f64; 2], tolerance: f64) -> Option<Spline> {
    let (knots, spans) = fit_spans(at, range, tolerance)?;
    Some(Spline {
        points: joined_points(&knots, &spans),
        knots,
    })
}

/// The control points of a span.
pub(crate) type Span = [DVec3; 6];

/// The knots and spans of such a spline.
///
/// Where a curve's parameter is that of a square root at an end, no polynomial follows it, and spans
/// there would be halved without end: such a curve is taken by the root.
pub(crate) fn fit_spans(
    at: impl Fn(f64) -> DVec3,
    [from, to]: [f64; 2],
    tolerance: f64,
) -> Option<(Vec<f64>, Vec<Span>)> {
    // (To the bit at both ends.)
    let place = |u: f64| if u == 1.0 { to } else { from + u * (to - from) };
    let halved = |warp: fn(f64) -> f64| {
        let at = |u: f64| at(place(warp(u)));
        let is_near = |u: f64, point: DVec3| at(u).distance(point) <= tolerance;
        halved(&at, QUARTERS.to_vec(), is_near, 0.0)
    };
    let plain = halved(|u| u);
    let is_root = plain.as_ref().map_or([true; 2], |(knots, _)| {
        let last = knots.len() - 1;
        [knots[1], 1.0 - knots[last - 1]].map(|length| length < SHORT)
    });
    match is_root {
        [false, false] => plain,
        [true, false] => halved(|u| u * u),
        [false, true] => halved(|u| u * (2.0 - u)),
        [true, true] => halved(|u| u * u * (3.0 - 2.0 * u)),
    }
}

/// The knots with which a curve is begun of which nothing is known.
pub(crate) const QUARTERS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// A spline through points of a curve that keeps its parameter, from 0 to 1, and the knots that are
/// given: none if it had spans as short as tell of a root. Whether it is near enough where it is held
/// against the curve `is_near` tells, by the parameter and the spline's point.
pub(crate) fn fit_as_given(
    at: impl Fn(f64) -> DVec3,
    knots: &[f64],
    is_near: impl Fn(f64, DVec3) -> bool,
) -> Option<Spline> {
    let (knots, spans) = halved(&at, knots.to_vec(), is_near, SHORT)?;
    Some(Spline {
        points: joined_points(&knots, &spans),
        knots,
    })
}

/// The knots and spans for a curve whose parameter goes from 0 to 1: none if spans of a length would have
/// to be halved.
fn halved(
    at: &impl Fn(f64) -> DVec3,
    mut knots: Vec<f64>,
    is_near: impl Fn(f64, DVec3) -> bool,
    shortest: f64,
) -> Option<(Vec<f64>, Vec<Span>)> {
    while knots.len() <= MOST_SPANS {
        let spans: Vec<[f64; 2]> = knots.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        let jets: Vec<[Jet; 2]> = spans.iter().map(|&span| jets(at, span)).collect();
        let mut joined = vec![jets[0][0]];
        for pair in jets.windows(2) {
            let (before, after) = (pair[0][1], pair[1][0]);
            joined.push(std::array::from_fn(|k| 0.5 * (before[k] + after[k])));
        }
        joined.push(jets[jets.len() - 1][1]);
        let spans: Vec<Span> = spans
            .iter()
            .zip(joined.windows(2))
            .map(|(span, jets)| bezier(span[1] - span[0], [jets[0], jets[1]]))
            .collect();
        let mut finer = vec![0.0];
        for (pair, span) in knots.windows(2).zip(&spans) {
            let [a, b] = [pair[0], pair[1]];
            let is_near = |&share: &f64| is_near(a + share * (b - a), point(*span, share));
            if !CHECKED.iter().all(is_near) {
                if b - a < shortest {
                    return None;
                }
                finer.push(0.5 * (a + b));
            }
            finer.push(b);
        }
        if finer.len() == knots.len() {
            return Some((knots, spans));
        }
        knots = finer;
    }
    None
}

/// Where spans are held against the curve: between the points that they were made from.
const CHECKED: [f64; 6] = [0.06, 0.22, 0.4, 0.57, 0.81, 0.95];

/// The degree of the polynomials that give derivatives.
const DEGREE: usize = 14;

/// A polynomial's derivatives at the begin of the interval from 0 to 1.
struct Differences {
    /// Chebyshev's extreme points, from 0 to 1.
    nodes: [f64; DEGREE + 1],
    /// How much each of them adds to the first derivative, and to the second.
    first: [f64; DEGREE + 1],
    second: [f64; DEGREE + 1],
}

/// By the matrix of derivatives at these points (Trefethen, *Spectral Methods in MATLAB*, 6),
/// whose square is that of second ones.
static DIFFERENCES: LazyLock<Differences> = LazyLock::new(|| {
    let angle = |k: usize| PI * k as f64 / DEGREE as f64;
    let nodes: [f64; DEGREE + 1] = std::array::from_fn(|k| elementary::sin(0.5 * angle(k)).powi(2));
    let weight = |k: usize| {
        let end = if k == 0 || k == DEGREE { 2.0 } else { 1.0 };
        if k.is_multiple_of(2) { end } else { -end }
    };
    // x_i - x_j without cancellation.
    let gap = |i: usize, j: usize| {
        elementary::sin(0.5 * (angle(i) + angle(j))) * elementary::sin(0.5 * (angle(i) - angle(j)))
    };
    let mut matrix = [[0.0; DEGREE + 1]; DEGREE + 1];
    for (i, row) in matrix.iter_mut().enumerate() {
        for j in (0..=DEGREE).filter(|&j| j != i) {
            row[j] = weight(i) / weight(j) / gap(i, j);
        }
        row[i] = -row.iter().sum::<f64>();
    }
    let second = |j: usize| (0..=DEGREE).map(|k| matrix[0][k] * matrix[k][j]).sum();
    Differences {
        nodes,
        first: matrix[0],
        second: std::array::from_fn(second),
    }
});

/// The point and derivatives of a curve at both ends of a span.
fn jets(at: &impl Fn(f64) -> DVec3, [a, b]: [f64; 2]) -> [Jet; 2] {
    let rule = &*DIFFERENCES;
    let length = b - a;
    let points = rule.nodes.map(|node| at(a + node * length));
    let jet = |points: [DVec3; DEGREE + 1], length: f64| {
        let about = points[0];
        let sum = |weights: &[f64]| -> DVec3 {
            let terms = weights.iter().zip(&points);
            terms
                .map(|(&weight, &point)| weight * (point - about))
                .sum()
        };
        [
            about,
            sum(&rule.first) / length,
            sum(&rule.second) / (length * length),
        ]
    };
    let mut back = points;
    back.reverse();
    [jet(points, length), jet(back, -length)]
}

/// The control points of the polynomial of degree five with given ends.
fn bezier(length: f64, [a, b]: [Jet; 2]) -> [DVec3; 6] {
    let [from, to] = [(a, length), (b, -length)].map(|(jet, h)| {
        let [point, first, second] = jet;
        let next = point + 0.2 * h * first;
        [point, next, next + 0.2 * h * first + 0.05 * h * h * second]
    });
    [from[0], from[1], from[2], to[2], to[1], to[0]]
}

/// The point of a polynomial, by de Casteljau's algorithm.
pub(crate) fn point<const N: usize>(mut points: [DVec3; N], share: f64) -> DVec3 {
    for count in (1..N).rev() {
        for k in 0..count {
            points[k] = points[k].lerp(points[k + 1], share);
        }
    }
    points[0]
}

/// The control points of spans joined at triple knots: of the seven about a knot b between a
/// and c the third and fifth, and between them the value of the polar form at (a, b, b, b, c)
/// (Ramshaw, *Blossoms are polar forms*, 1989).
fn joined_points(knots: &[f64], spans: &[[DVec3; 6]]) -> Vec<DVec3> {
    let mut points = spans[0][..3].to_vec();
    for (k, pair) in spans.windows(2).enumerate() {
        let (before, after) = (&pair[0], &pair[1]);
        let share = (knots[k + 2] - knots[k]) / (knots[k + 1] - knots[k]);
        points.extend([before[3], before[3].lerp(before[4], share), after[2]]);
    }
    points.extend(&spans[spans.len() - 1][3..]);
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    type Curve<'a> = &'a dyn Fn(f64) -> DVec3;

    #[test]
    fn splines_are_where_their_curves_are() {
        // Viviani's curve, a sharp bend, and polynomials, which are met exactly.
        let viviani = |t: f64| DVec3::new(t.cos().powi(2), t.cos() * t.sin(), t.sin());
        let bend = |t: f64| DVec3::new(t, (1e-4 + t * t).sqrt(), 0.0);
        let quintic = |t: f64| DVec3::new(t, t * t * t, t.powi(5) - t);
        let curves: [(Curve<'_>, [f64; 2]); 3] = [
            (&viviani, [0.0, 6.0]),
            (&bend, [-1.0, 2.0]),
            (&quintic, [-1.0, 1.0]),
        ];
        for (k, (curve, range)) in curves.into_iter().enumerate() {
            let mut spans = Vec::new();
            for tolerance in [1e-6, 1e-9] {
                let spline = fit(curve, range, tolerance).expect("a spline");
                assert_eq!(spline.points.len(), 3 * spline.knots.len());
                for step in 0..=5000 {
                    let u = f64::from(step) / 5000.0;
                    let exact = curve(range[0] + u * (range[1] - range[0]));
                    let off = spline.at(u).distance(exact);
                    assert!(off < 1.5 * tolerance, "{k}: {off} at {u}");
                }
                spans.push(spline.knots.len() - 1);
            }
            match k {
                2 => assert_eq!(spans, [4, 4]),
                // A thousandth of the error takes about three times as many.
                _ => assert!(spans[1] < 5 * spans[0], "{spans:?}"),
            }
        }
    }

    #[test]
    fn roots_at_ends_are_no_trouble() {
        let curves: [Curve<'_>; 3] = [
            &|t| DVec3::new(t.sqrt(), t, 0.3 * t * t),
            &|t| DVec3::new((1.0 - t).sqrt(), t, t.sin()),
            &|t| DVec3::new((t * (1.0 - t)).sqrt(), t, t.cos()),
        ];
        for (k, curve) in curves.into_iter().enumerate() {
            let (knots, spans) = fit_spans(curve, [0.0, 1.0], 1e-9).expect("a spline");
            assert!(spans.len() < 60, "{k}: {}", spans.len());
            assert!(knots.windows(2).all(|pair| pair[1] - pair[0] > 1e-5));
            for ends in [
                [curve(0.0), spans[0][0]],
                [curve(1.0), spans[spans.len() - 1][5]],
            ] {
                assert!(ends[0].distance(ends[1]) < 1e-15, "{k}: {ends:?}");
            }
        }
    }

    #[test]
    fn what_no_spline_follows_is_told() {
        let noise = |t: f64| DVec3::splat((1e9 * t).sin());
        assert!(fit(noise, [0.0, 1.0], 1e-9).is_none());
    }
}
