//! Curves in space, and what is seen of them along a direction.

use std::f64::consts::{FRAC_PI_2, TAU};

use csg::brep::{CurveShape, Edge};
use csg::elementary;
use glam::{DVec2, DVec3, DVec4};

use super::outline::{Piece, Shape};
use super::section::SectionFrame;
use crate::spline;

/// Of the drawing's size: shorter curves are points, and conics as thin are lines.
const THIN: f64 = 1e-10;

/// A smooth curve, as a function of a parameter.
#[derive(Clone, Debug)]
enum Space {
    /// From 0 to 1.
    Line([DVec3; 2]),
    /// center + cos t a + sin t b.
    Ellipse { center: DVec3, a: DVec3, b: DVec3 },
    /// Rational, of degree two, from 0 to 1: points times weights, and weights.
    Conic([DVec4; 3]),
    /// A polynomial of degree five, from 0 to 1.
    Quintic([DVec3; 6]),
}

/// A curve and what is seen of it.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    space: Space,
    frame: SectionFrame,
    pub range: [f64; 2],
    /// No second derivative of what is seen is longer.
    pub bend: f64,
    /// Whether a straight line is seen.
    pub is_straight: bool,
    /// A box around what is seen.
    pub bounds: [DVec2; 2],
}

impl Seen {
    /// What is seen of an edge, of a solid of some size: curves of degree four in parts that
    /// stray by no more than a tolerance. None of one that runs along the view.
    pub fn of_edge(
        edge: &Edge<'_>,
        frame: &SectionFrame,
        size: f64,
        tolerance: f64,
    ) -> Option<Vec<Self>> {
        let range = edge.range();
        let curve = edge.curve();
        let ends = edge.vertices().map(|ends| ends.map(|end| end.point()));
        let (space, range) = match curve {
            CurveShape::Line { .. } => {
                let ends = ends.unwrap_or_else(|| range.map(|t| edge.at(t)));
                (vec![Space::Line(ends)], [0.0, 1.0])
            }
            CurveShape::Ellipse { center, a, b } => (vec![Space::Ellipse { center, a, b }], range),
            _ => match curve.control(range) {
                Some(control) => (vec![Space::Conic(control)], [0.0, 1.0]),
                None => {
                    let (_, spans) = spline::fit_spans(|t| edge.at(t), range, tolerance)?;
                    (spans.into_iter().map(Space::Quintic).collect(), [0.0, 1.0])
                }
            },
        };
        let parts = space
            .into_iter()
            .flat_map(|space| Self::parts(space, *frame, range, size));
        Some(parts.collect())
    }

    /// A curve; of one that is seen as a line, the parts in which it runs one way.
    fn parts(space: Space, frame: SectionFrame, range: [f64; 2], size: f64) -> Vec<Self> {
        let mut seen = Self {
            space,
            frame,
            range,
            bend: 0.0,
            is_straight: false,
            bounds: [DVec2::ZERO; 2],
        };
        let along = seen.straight(size);
        seen.is_straight = along.is_some();
        let mut ends = vec![range[0]];
        if let Some(along) = along
            && !matches!(seen.space, Space::Line(_))
        {
            ends.extend(seen.turns(along));
        }
        ends.push(range[1]);
        let part = |pair: &[f64]| {
            let mut part = seen.clone();
            part.range = [pair[0], pair[1]];
            part.bend = part.most_bend();
            part.bounds = part.bounds(part.range);
            part
        };
        let parts = ends.windows(2).map(part);
        parts
            .filter(|part| part.bounds[0].distance(part.bounds[1]) > THIN * size)
            .collect()
    }

    /// The direction of the line that is seen, if it is one.
    fn straight(&self, size: f64) -> Option<DVec2> {
        const SAMPLES: u32 = 12;
        let [from, to] = self.range;
        let points: Vec<DVec2> = (0..=SAMPLES)
            .map(|k| self.at(from + (to - from) * f64::from(k) / f64::from(SAMPLES)))
            .collect();
        let off = |point: &DVec2| *point - points[0];
        let along = points
            .iter()
            .map(off)
            .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?
            .normalize_or_zero();
        let is_on = |point: &DVec2| off(point).perp_dot(along).abs() <= THIN * size;
        points.iter().all(is_on).then_some(along)
    }

    /// Where the curve, seen as a line, turns back.
    fn turns(&self, along: DVec2) -> Vec<f64> {
        const SAMPLES: u32 = 64;
        let [from, to] = self.range;
        let speed = |t: f64| self.slope(t).dot(along);
        let at = |k: u32| from + (to - from) * f64::from(k) / f64::from(SAMPLES);
        let mut turns = Vec::new();
        for k in 0..SAMPLES {
            let (mut low, mut high) = (at(k), at(k + 1));
            let is_up = speed(low) > 0.0;
            if (speed(high) > 0.0) == is_up {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if (speed(middle) > 0.0) == is_up {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            turns.push(low);
        }
        turns
    }

    /// The point in space at a parameter.
    pub fn point(&self, t: f64) -> DVec3 {
        match &self.space {
            Space::Line([from, to]) => from.lerp(*to, t),
            Space::Ellipse { center, a, b } => {
                let (sin, cos) = elementary::sin_cos(t);
                *center + cos * *a + sin * *b
            }
            Space::Conic(control) => {
                let point = blossom(control, t, t);
                point.truncate() / point.w
            }
            Space::Quintic(control) => spline::point(*control, t),
        }
    }

    /// What is seen of it.
    pub fn at(&self, t: f64) -> DVec2 {
        self.frame.flatten(self.point(t))
    }

    /// The derivative of what is seen.
    pub fn slope(&self, t: f64) -> DVec2 {
        let slope = match &self.space {
            Space::Line([from, to]) => *to - *from,
            Space::Ellipse { a, b, .. } => {
                let (sin, cos) = elementary::sin_cos(t);
                cos * *b - sin * *a
            }
            Space::Conic(control) => {
                let point = blossom(control, t, t);
                let slope = 2.0 * (blossom(control, t, 1.0) - blossom(control, t, 0.0));
                (slope.truncate() - slope.w / point.w * point.truncate()) / point.w
            }
            Space::Quintic(control) => {
                let sides: [DVec3; 5] =
                    std::array::from_fn(|k| 5.0 * (control[k + 1] - control[k]));
                spline::point(sides, t)
            }
        };
        self.frame.turned(slope)
    }

    fn most_bend(&self) -> f64 {
        match &self.space {
            Space::Line(_) => 0.0,
            Space::Ellipse { a, b, .. } => {
                let [a, b] = [a, b].map(|half| self.frame.turned(*half));
                (a.length_squared() + b.length_squared()).sqrt()
            }
            // By differences of slopes, and as much again.
            Space::Conic(_) => {
                const STEPS: u32 = 32;
                let [from, to] = self.range;
                let step = (to - from) / f64::from(STEPS);
                let at = |k: u32| self.slope(from + f64::from(k) * step);
                let bends = (0..STEPS).map(|k| at(k + 1).distance(at(k)) / step);
                2.0 * bends.fold(0.0, f64::max)
            }
            Space::Quintic(control) => {
                let bends = control.windows(3).map(|c| {
                    let bend = c[0] - 2.0 * c[1] + c[2];
                    20.0 * self.frame.turned(bend).length()
                });
                bends.fold(0.0, f64::max)
            }
        }
    }

    /// A box around what is seen between two parameters.
    pub fn bounds(&self, [from, to]: [f64; 2]) -> [DVec2; 2] {
        const PARTS: u32 = 8;
        let step = (to - from) / f64::from(PARTS);
        let points = (0..=PARTS).map(|k| self.at(from + f64::from(k) * step));
        let slack = DVec2::splat(self.bend * step * step / 8.0);
        let [low, high] = points.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
            [low.min(p), high.max(p)]
        });
        [low - slack, high + slack]
    }

    /// The nearest place to a point, and how far it is.
    pub fn nearest(&self, point: DVec2) -> (f64, f64) {
        let [from, to] = self.range;
        if let Space::Line(_) = self.space {
            let (start, slope) = (self.at(0.0), self.slope(0.0));
            let t = ((point - start).dot(slope) / slope.length_squared()).clamp(from, to);
            return (t, self.at(t).distance(point));
        }
        const SAMPLES: u32 = 24;
        let step = (to - from) / f64::from(SAMPLES);
        let off = |t: f64| self.at(t).distance_squared(point);
        let places = (0..=SAMPLES).map(|k| from + f64::from(k) * step);
        let mut best = places
            .min_by(|a, b| off(*a).total_cmp(&off(*b)))
            .unwrap_or(from);
        // Newton's method for points, on the tangent.
        for _ in 0..30 {
            let slope = self.slope(best);
            let step_to = (point - self.at(best)).dot(slope) / slope.length_squared();
            if !step_to.is_finite() {
                break;
            }
            let next = (best + step_to.clamp(-step, step)).clamp(from, to);
            if (next - best).abs() <= 1e-15 * (1.0 + best.abs()) {
                break;
            }
            if off(next) > off(best) {
                break;
            }
            best = next;
        }
        (best, off(best).sqrt())
    }

    /// The part between two parameters as it is drawn, within a tolerance.
    pub fn pieces(&self, [from, to]: [f64; 2], tolerance: f64) -> Vec<Piece> {
        let is_whole = matches!(self.space, Space::Ellipse { .. })
            && !self.is_straight
            && to - from > TAU - 1e-9;
        let start = self.at(from);
        let end = if is_whole { start } else { self.at(to) };
        let piece = |shape: Shape| Piece {
            from: start,
            to: end,
            shape,
        };
        if self.is_straight {
            return vec![piece(Shape::Line)];
        }
        match &self.space {
            Space::Line(_) => vec![piece(Shape::Line)],
            Space::Ellipse { center, a, b } => {
                let [a, b] = [a, b].map(|half| self.frame.turned(*half));
                let turn = 0.5
                    * elementary::atan2(2.0 * a.dot(b), a.length_squared() - b.length_squared());
                let (sin, cos) = elementary::sin_cos(turn);
                let [long, short] = [cos * a + sin * b, cos * b - sin * a];
                let is_circle = long.length() - short.length() <= 1e-12 * long.length();
                vec![piece(Shape::Ellipse {
                    center: self.frame.flatten(*center),
                    long,
                    short,
                    range: [from - turn, to - turn],
                    is_circle,
                })]
            }
            Space::Conic(control) => {
                let [first, middle, last] =
                    [(from, from), (from, to), (to, to)].map(|(s, t)| blossom(control, s, t));
                vec![piece(Shape::Conic {
                    control: self.frame.flatten(middle.truncate() / middle.w),
                    weight: middle.w / (first.w * last.w).sqrt(),
                })]
            }
            Space::Quintic(_) => {
                let mut pieces = Vec::new();
                self.cubics([from, to], tolerance, 0, &mut pieces);
                pieces
            }
        }
    }

    /// Cubics with the ends and tangents of parts.
    fn cubics(&self, [from, to]: [f64; 2], tolerance: f64, depth: u32, pieces: &mut Vec<Piece>) {
        const DEEPEST: u32 = 12;
        let third = (to - from) / 3.0;
        let ends = [self.at(from), self.at(to)];
        let piece = Piece {
            from: ends[0],
            to: ends[1],
            shape: Shape::Cubic {
                controls: [
                    ends[0] + third * self.slope(from),
                    ends[1] - third * self.slope(to),
                ],
            },
        };
        let is_near = [0.2, 0.5, 0.8].iter().all(|&share| {
            let exact = self.at(from + share * (to - from));
            piece.at(share).distance(exact) <= tolerance
        });
        if is_near || depth >= DEEPEST {
            pieces.push(piece);
            return;
        }
        let middle = 0.5 * (from + to);
        self.cubics([from, middle], tolerance, depth + 1, pieces);
        self.cubics([middle, to], tolerance, depth + 1, pieces);
    }

    /// So many parts at least keep the tangent within a quarter of a turn.
    pub fn first_parts(&self) -> u32 {
        match self.space {
            Space::Line(_) => 1,
            Space::Ellipse { .. } => ((self.range[1] - self.range[0]) / FRAC_PI_2)
                .ceil()
                .max(1.0) as u32,
            _ => 2,
        }
    }
}

/// The polar form of a rational curve of degree two.
fn blossom(control: &[DVec4; 3], s: f64, t: f64) -> DVec4 {
    let ends = [
        control[0].lerp(control[1], s),
        control[1].lerp(control[2], s),
    ];
    ends[0].lerp(ends[1], t)
}
