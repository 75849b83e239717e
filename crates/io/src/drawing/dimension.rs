//! Sizes, as lines with arrows and a number.

use csg::{LengthUnit, elementary};
use glam::DVec2;

/// Of the drawing's longer side: how far from it lines for sizes are, how high numbers are, and
/// how long arrows.
const AWAY: f64 = 0.08;
pub(super) const HEIGHT: f64 = 0.028;
const ARROW: f64 = 0.022;

/// A size in a drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimension {
    /// The size, in the model's unit.
    pub value: f64,
    /// What is measured: from where to where; of a circle a diameter.
    pub ends: [DVec2; 2],
    /// The line beside it, with arrows at both ends; of a circle from the second end outwards,
    /// with an arrow there.
    pub line: [DVec2; 2],
    /// Whether it is the diameter of a circle.
    pub is_diameter: bool,
}

impl Dimension {
    /// The width of a box, below it, and its height, on its left.
    pub(super) fn of_box([low, high]: [DVec2; 2]) -> Vec<Self> {
        let away = AWAY * (high - low).max_element();
        let [right, above] = [DVec2::new(high.x, low.y), DVec2::new(low.x, high.y)];
        let size = |ends: [DVec2; 2], off: DVec2| Self {
            value: ends[0].distance(ends[1]),
            ends,
            line: ends.map(|end| end - off),
            is_diameter: false,
        };
        vec![
            size([low, right], away * DVec2::Y),
            size([low, above], away * DVec2::X),
        ]
    }

    /// The diameter of a circle, in a drawing of some size: those that come one after another
    /// in directions of their own, as circles may have one centre.
    pub(super) fn of_circle(center: DVec2, radius: f64, number: usize, size: f64) -> Self {
        /// In degrees: nearly upwards, then on and on downwards on the right.
        const ANGLES: [f64; 6] = [62.0, 38.0, 14.0, -12.0, -36.0, -60.0];
        let out = elementary::direction(ANGLES[number % ANGLES.len()].to_radians());
        let ends = [center - radius * out, center + radius * out];
        Self {
            value: 2.0 * radius,
            ends,
            line: [ends[1], ends[1] + 0.6 * AWAY * size * out],
            is_diameter: true,
        }
    }

    pub(super) fn is_same_diameter(&self, other: &Self) -> bool {
        let is_same = (self.value - other.value).abs() <= 1e-9 * self.value;
        self.is_diameter && other.is_diameter && is_same
    }

    /// The number as it is drawn: six digits at most, and the unit.
    #[must_use]
    pub fn text(&self, unit: LengthUnit) -> String {
        let decimals = (5.0 - elementary::log10(self.value).floor()).clamp(0.0, 12.0) as usize;
        let number = super::decimal(self.value, decimals);
        let sign = if self.is_diameter { "⌀" } else { "" };
        format!("{sign}{number} {}", unit.symbol())
    }

    /// What is drawn, in a drawing of some size: straight lines.
    pub(super) fn strokes(&self, size: f64) -> Vec<[DVec2; 2]> {
        let mut strokes = vec![self.line];
        let [from, to] = self.line;
        let along = ARROW * size * (to - from).normalize_or_zero();
        let beside = 0.25 * along.perp();
        let mut arrow = |tip: DVec2, back: DVec2| {
            strokes.push([tip, tip + back + beside]);
            strokes.push([tip, tip + back - beside]);
        };
        arrow(from, along);
        if self.is_diameter {
            return strokes;
        }
        arrow(to, -along);
        for (end, line) in self.ends.into_iter().zip(self.line) {
            let off = line - end;
            strokes.push([end + 0.15 * off, line + 0.2 * off]);
        }
        strokes
    }

    /// Where the middle of the number's base line is, and the direction in which it is read.
    pub(super) fn place(&self, size: f64) -> (DVec2, DVec2) {
        let [from, to] = self.line;
        let height = HEIGHT * size;
        if self.is_diameter {
            // (Some nine letters, each a little wider than a half of its height.)
            let half = 0.5 * 9.0 * 0.55 * height;
            return (to + DVec2::new(half, -0.35 * height), DVec2::X);
        }
        let mut along = (to - from).normalize_or_zero();
        // From the left to the right, or upwards.
        if along.x < -1e-9 || along.x.abs() <= 1e-9 && along.y < 0.0 {
            along = -along;
        }
        (from.midpoint(to) + 0.3 * height * along.perp(), along)
    }

    /// A box around it.
    pub(super) fn bounds(&self, size: f64) -> [DVec2; 2] {
        let (middle, along) = self.place(size);
        let height = HEIGHT * size;
        let half = if self.is_diameter { 2.5 * height } else { 0.0 };
        let text = [-1.0, 1.0].map(|side| middle + side * half * along);
        let points = self.ends.into_iter().chain(self.line).chain(text);
        let points = points.chain([middle + 1.4 * height * along.perp()]);
        points.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
            [low.min(p), high.max(p)]
        })
    }
}
