//! What drawings are made of: closed outlines of lines and conics in a plane.

use csg::elementary;
use std::f64::consts::TAU;

use glam::DVec2;

/// A closed line: what it bounds lies on its left.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Each from where the one before ends.
    pub pieces: Vec<Piece>,
}

/// A line or an arc of a conic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Where it begins.
    pub from: DVec2,
    /// Where it ends: the same place all around a circle or an ellipse.
    pub to: DVec2,
    /// What is between.
    pub shape: Shape,
}

/// What leads from one point to another.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// A straight line.
    Line,
    /// center + cos t long + sin t short.
    Ellipse {
        /// The centre.
        center: DVec2,
        /// The longer half axis; any radius of a circle.
        long: DVec2,
        /// The other one, at right angles to it: on its left or on its right.
        short: DVec2,
        /// From which t to which; backwards, if the second is less.
        range: [f64; 2],
        /// Whether it is a circle: both half axes are of one length.
        is_circle: bool,
    },
    /// A parabola or hyperbola as a rational Bézier curve between the piece's ends,
    /// whose weights are 1: the point in the middle, and its weight.
    Conic {
        /// Where the tangents of the ends meet.
        control: DVec2,
        /// Less than 1 for ellipses, 1 for parabolas, more for hyperbolas.
        weight: f64,
    },
    /// A Bézier curve of degree three, in place of a curve of degree four or more in space.
    Cubic {
        /// The two points between the ends.
        controls: [DVec2; 2],
    },
}

impl Shape {
    /// Of an ellipse its angle, signed and counter-clockwise, from the first place to the
    /// second.
    pub(super) fn turn(&self) -> f64 {
        match *self {
            Self::Ellipse {
                long, short, range, ..
            } => long.perp_dot(short).signum() * (range[1] - range[0]),
            _ => 0.0,
        }
    }
}

impl Piece {
    /// The point at a share of the way, from 0 to 1.
    #[must_use]
    pub fn at(&self, share: f64) -> DVec2 {
        match self.shape {
            Shape::Line => self.from.lerp(self.to, share),
            Shape::Ellipse {
                center,
                long,
                short,
                range: [from, to],
                ..
            } => {
                let (sin, cos) = elementary::sin_cos(from + share * (to - from));
                center + cos * long + sin * short
            }
            Shape::Cubic { controls: [a, b] } => {
                let rest = 1.0 - share;
                let [from, to] = [rest.powi(3) * self.from, share.powi(3) * self.to];
                from + 3.0 * rest * share * (rest * a + share * b) + to
            }
            Shape::Conic { control, weight } => {
                let rest = 1.0 - share;
                let weights = [rest * rest, 2.0 * weight * rest * share, share * share];
                let sum: f64 = weights.iter().sum();
                (weights[0] * self.from + weights[1] * control + weights[2] * self.to) / sum
            }
        }
    }

    /// Whether it goes all around.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        matches!(self.shape, Shape::Ellipse { .. }) && self.from == self.to
    }

    /// A box around it, the least one but for conics and cubics, which lie in that of their
    /// control points.
    pub(super) fn bounds(&self) -> [DVec2; 2] {
        let ends = [self.from.min(self.to), self.from.max(self.to)];
        match self.shape {
            Shape::Line => ends,
            Shape::Conic { control, .. } => [ends[0].min(control), ends[1].max(control)],
            Shape::Cubic { controls: [a, b] } => [ends[0].min(a).min(b), ends[1].max(a).max(b)],
            Shape::Ellipse {
                long, short, range, ..
            } => {
                let extremes = [
                    elementary::atan2(short.x, long.x),
                    elementary::atan2(short.y, long.y),
                    elementary::atan2(short.x, long.x) + 0.5 * TAU,
                    elementary::atan2(short.y, long.y) + 0.5 * TAU,
                ];
                let (least, most) = (range[0].min(range[1]), range[0].max(range[1]));
                let mut bounds = ends;
                for t in extremes {
                    let t = least + (t - least).rem_euclid(TAU);
                    if t <= most {
                        let point = self.at((t - range[0]) / (range[1] - range[0]));
                        bounds = [bounds[0].min(point), bounds[1].max(point)];
                    }
                }
                bounds
            }
        }
    }
}

impl Outline {
    /// The least and greatest corner of a box around it.
    #[must_use]
    pub fn bounds(&self) -> [DVec2; 2] {
        let bounds = self.pieces.iter().map(Piece::bounds);
        bounds
            .reduce(|one, other| [one[0].min(other[0]), one[1].max(other[1])])
            .unwrap_or_default()
    }
}
