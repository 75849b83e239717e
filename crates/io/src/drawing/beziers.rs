//! Bézier curves in place of conics.

use csg::elementary;
use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

use super::outline::{Piece, Shape};

/// A parabola: where the tangents of its ends meet, and where it ends.
pub(super) type Quadratic = [DVec2; 2];

/// Two control points, and where it ends.
pub(super) type Cubic = [DVec2; 3];

/// Parabolas that stray from a conic between its ends by no more than a tolerance.
///
/// A rational curve of weight w and the parabola of the same control points are farthest apart
/// in the middle, by |w - 1| / 2 (w + 1) of what the control point is off the chord's middle.
/// Cut there, both halves have weight √((1 + w) / 2), and are some sixteen times as near.
pub(super) fn parabolas(piece: &Piece, tolerance: f64) -> Vec<Quadratic> {
    let mut parabolas = Vec::new();
    if let Shape::Conic { control, weight } = piece.shape {
        halve(
            [piece.from, control, piece.to],
            weight,
            tolerance,
            &mut parabolas,
        );
    }
    parabolas
}

fn halve([a, b, c]: [DVec2; 3], weight: f64, tolerance: f64, parabolas: &mut Vec<Quadratic>) {
    /// The error is then no longer that of the curve, but of rounding.
    const MOST: usize = 1 << 12;
    let off = (weight - 1.0).abs() / (2.0 * (weight + 1.0)) * b.distance(a.midpoint(c));
    if off <= tolerance || parabolas.len() >= MOST {
        parabolas.push([b, c]);
        return;
    }
    let [left, right] = [a, c].map(|end| (end + weight * b) / (1.0 + weight));
    let middle = left.midpoint(right);
    let weight = (0.5 * (1.0 + weight)).sqrt();
    halve([a, left, middle], weight, tolerance, parabolas);
    halve([middle, right, c], weight, tolerance, parabolas);
}

/// Cubic curves that stray from a piece by no more than a tolerance.
pub(super) fn cubics(piece: &Piece, tolerance: f64) -> Vec<Cubic> {
    /// Of the radius, how far a cubic strays from a quarter of a circle: it falls with the
    /// sixth power of the angle.
    const QUARTER: f64 = 2.73e-4;
    let straight =
        |from: DVec2, to: DVec2| [from.lerp(to, 1.0 / 3.0), from.lerp(to, 2.0 / 3.0), to];
    match piece.shape {
        Shape::Line => vec![straight(piece.from, piece.to)],
        Shape::Cubic { controls: [a, b] } => vec![[a, b, piece.to]],
        Shape::Conic { .. } => {
            let mut from = piece.from;
            let raise = |[control, to]: Quadratic| {
                let cubic = [
                    control.lerp(from, 1.0 / 3.0),
                    control.lerp(to, 1.0 / 3.0),
                    to,
                ];
                from = to;
                cubic
            };
            parabolas(piece, tolerance).into_iter().map(raise).collect()
        }
        Shape::Ellipse {
            center,
            long,
            short,
            range: [from, to],
            ..
        } => {
            let turn = (to - from).abs();
            let finest =
                FRAC_PI_2 * elementary::pow(tolerance / (QUARTER * long.length()), 1.0 / 6.0);
            let count = (turn / finest.min(FRAC_PI_2)).ceil().clamp(1.0, 1e4);
            let step = (to - from) / count;
            let arm = 4.0 / 3.0 * elementary::tan(0.25 * step);
            let at = |t: f64| center + elementary::cos(t) * long + elementary::sin(t) * short;
            let along = |t: f64| elementary::cos(t) * short - elementary::sin(t) * long;
            let part = |k: u32| {
                let (start, end) = (from + f64::from(k) * step, from + f64::from(k + 1) * step);
                let last = if f64::from(k + 1) == count {
                    piece.to
                } else {
                    at(end)
                };
                [
                    at(start) + arm * along(start),
                    at(end) - arm * along(end),
                    last,
                ]
            };
            (0..count as u32).map(part).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The farthest that points of the curves are from a dense polyline of the piece.
    fn strays(piece: &Piece, cubics: &[Cubic]) -> f64 {
        let exact: Vec<DVec2> = (0..=20_000)
            .map(|k| piece.at(f64::from(k) / 20_000.0))
            .collect();
        let mut from = piece.from;
        let mut most = 0.0_f64;
        for &[p, q, to] in cubics {
            for k in 0..=8 {
                let t = f64::from(k) / 8.0;
                let s = 1.0 - t;
                let point =
                    s * s * s * from + 3.0 * s * s * t * p + 3.0 * s * t * t * q + t * t * t * to;
                let least = exact.windows(2).map(|ends| {
                    let side = ends[1] - ends[0];
                    let share =
                        ((point - ends[0]).dot(side) / side.length_squared()).clamp(0.0, 1.0);
                    point.distance(ends[0] + share * side)
                });
                most = most.max(least.fold(f64::INFINITY, f64::min));
            }
            from = to;
        }
        most
    }

    #[test]
    fn curves_keep_their_tolerance_without_waste() {
        let arc = |long: DVec2, short: DVec2, range: [f64; 2]| {
            let shape = Shape::Ellipse {
                center: DVec2::new(3.0, 1.0),
                long,
                short,
                range,
                is_circle: false,
            };
            let piece = Piece {
                from: DVec2::ZERO,
                to: DVec2::ONE,
                shape,
            };
            Piece {
                from: piece.at(0.0),
                to: piece.at(1.0),
                shape,
            }
        };
        let conic = |weight: f64| Piece {
            from: DVec2::ZERO,
            to: DVec2::new(4.0, 1.0),
            shape: Shape::Conic {
                control: DVec2::new(1.0, 3.0),
                weight,
            },
        };
        for piece in [
            arc(DVec2::new(2.0, 0.5), DVec2::new(-0.25, 1.0), [0.3, 6.0]),
            arc(DVec2::new(2.0, 0.5), DVec2::new(0.25, -1.0), [2.0, -1.0]),
            conic(1.0),
            conic(1.7),
            conic(30.0),
        ] {
            for tolerance in [1e-2, 1e-4, 1e-6] {
                let cubics = cubics(&piece, tolerance);
                let off = strays(&piece, &cubics);
                // (Points of the polyline stray from the curve by 1e-8 themselves.)
                assert!(
                    off <= 1.01 * tolerance + 2e-8,
                    "{piece:?}: {off} of {tolerance}"
                );
                let is_coarsest = cubics.len() <= 4 || off > 1e-3 * tolerance;
                assert!(
                    is_coarsest,
                    "{piece:?}: {off} of {tolerance} with {}",
                    cubics.len()
                );
                assert_eq!(cubics.last().map(|c| c[2]), Some(piece.to));
            }
        }
    }
}
