//! Parabolas: what control points say.

use glam::{DAffine2, DMat2, DVec2};

use super::arcs::Sagitta;
use super::{Bend, Corner};
use crate::numeric::tolerance::IN_PROFILE;

/// A corner with a parabola of three control points to the next one, if another point of the curve is
/// on it.
pub(crate) fn corner_on_parabola([from, control, to]: [DVec2; 3], point: DVec2) -> Option<Corner> {
    let curve = Parabola::new(from, control, to);
    curve.has(point).then(|| Corner {
        point: from,
        bend: curve.bend(),
    })
}

/// A piece of a parabola, which is a quadratic Bézier curve: from one point to another, at which
/// its tangents meet in the control point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parabola {
    pub from: DVec2,
    pub control: DVec2,
    pub to: DVec2,
    /// The points of the curve that it is a piece of.
    pub of: [DVec2; 3],
}

impl Parabola {
    /// A whole curve.
    pub(super) fn new(from: DVec2, control: DVec2, to: DVec2) -> Self {
        let of = [from, control, to];
        Self {
            from,
            control,
            to,
            of,
        }
    }

    pub(super) fn bend(&self) -> Bend {
        let Self { control, of, .. } = *self;
        Bend::Parabola { control, of }
    }

    /// The point at a parameter from 0 to 1.
    pub(super) fn at(&self, t: f64) -> DVec2 {
        let [first, last] = [
            self.from.lerp(self.control, t),
            self.control.lerp(self.to, t),
        ];
        first.lerp(last, t)
    }

    /// Both halves (de Casteljau).
    pub(super) fn halves(&self) -> [Self; 2] {
        let [first, last] = [
            self.from.midpoint(self.control),
            self.control.midpoint(self.to),
        ];
        let middle = first.midpoint(last);
        let half = |from, control, to| Self {
            from,
            control,
            to,
            of: self.of,
        };
        [half(self.from, first, middle), half(middle, last, self.to)]
    }

    /// Twice the area of the triangle of its three points: positive if it turns left.
    pub(super) fn turn(&self) -> f64 {
        (self.control - self.from).perp_dot(self.to - self.from)
    }

    /// Whether a point is on the parabola, but for rounding: b² = 4 a c, by its shares a, b and c of
    /// the three points.
    pub(super) fn has(&self, point: DVec2) -> bool {
        let Self {
            from, control, to, ..
        } = *self;
        let turn = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
        let whole = turn(from, control, to);
        let [a, b, c] = [
            turn(point, control, to),
            turn(from, point, to),
            turn(from, control, point),
        ];
        // The shares of a thin one are known to fewer digits.
        let longest = from.distance(control).max(control.distance(to));
        let size = [from, control, to].map(|point| point.abs().max_element());
        let off = IN_PROFILE * longest * size.into_iter().fold(0.0, f64::max);
        (b * b - 4.0 * a * c).abs() <= 4.0 * off * whole.abs()
    }

    /// Whether it is a straight line but for rounding.
    pub(super) fn is_straight(&self) -> bool {
        let Self {
            from, control, to, ..
        } = *self;
        let size = [from, control, to].map(|point| point.abs().max_element());
        let longest = from.distance(control).max(control.distance(to));
        self.turn().abs() <= IN_PROFILE * size.into_iter().fold(0.0, f64::max) * longest
    }

    /// Twice the area between it and its chord: by Archimedes two thirds of the triangle's.
    pub(super) fn doubled_segment(&self) -> f64 {
        self.turn() * (2.0 / 3.0)
    }

    /// The map under which y >= x² has the parabola's inner side for its image, and the curve that
    /// it is a piece of goes from x = 0 to x = 1. Singular of a straight line.
    pub(super) fn map(&self) -> DAffine2 {
        let [from, control, to] = self.of;
        let axes = DMat2::from_cols(2.0 * (control - from), from - control + (to - control));
        DAffine2::from_mat2_translation(axes, from)
    }

    /// How many chords keep so near to it under a map that stretches by `stretch`: over 1/n of the
    /// parameter one strays by at most a quarter of the second difference over n².
    pub(super) fn chords(&self, stretch: f64, sagitta: Sagitta) -> usize {
        const MOST: f64 = 1e4;
        let bend = (self.from - self.control + (self.to - self.control)).length();
        let count = (0.25 * bend * stretch / sagitta.length).sqrt().ceil();
        count.clamp(1.0, MOST) as usize
    }
}
