//! B-splines, rational ones too, as Bézier curves.

use glam::{DVec2, DVec3};

use super::super::curves::{Outline, Side};

/// The highest degree that is read.
const HIGHEST: i64 = 15;

pub(super) struct Spline {
    degree: usize,
    knots: Vec<f64>,
    /// Times their weights, and these.
    controls: Vec<DVec3>,
}

impl Spline {
    pub(super) fn of(
        degree: i64,
        knots: Vec<f64>,
        points: &[DVec2],
        weights: &[f64],
    ) -> Result<Self, String> {
        if !(1..=HIGHEST).contains(&degree) {
            return Err(format!(
                "its degree is {degree}: it must be from 1 to {HIGHEST}"
            ));
        }
        let degree = degree as usize;
        let count = points.len();
        if count <= degree || knots.len() != count + degree + 1 {
            return Err(format!(
                "{count} control points of degree {degree} need {} knots, and more points than the degree; there are {}",
                count + degree + 1,
                knots.len()
            ));
        }
        if knots.windows(2).any(|pair| pair[1] < pair[0]) || knots[degree] >= knots[count] {
            return Err("its knots do not rise".to_owned());
        }
        if !(weights.is_empty() || weights.len() == count) {
            return Err(format!(
                "it has {} weights for {count} control points",
                weights.len()
            ));
        }
        if weights.iter().any(|weight| !(1e-12..1e12).contains(weight)) {
            return Err("its weights must be above 0".to_owned());
        }
        let weight = |k: usize| weights.get(k).copied().unwrap_or(1.0);
        let controls = points.iter().enumerate();
        let controls = controls.map(|(k, point)| (weight(k) * *point).extend(weight(k)));
        Ok(Self {
            degree,
            knots,
            controls: controls.collect(),
        })
    }

    /// One Bézier curve for each span of its knots: control point k of the span from a to b is
    /// the value of the polar form where a is taken p - k times and b k times (Ramshaw, *Blossoms
    /// are polar forms*, 1989).
    pub(super) fn outline(&self) -> Outline {
        let p = self.degree;
        let mut outline: Option<Outline> = None;
        for j in p..self.controls.len() {
            let [a, b] = [self.knots[j], self.knots[j + 1]];
            if a == b {
                continue;
            }
            let at = |k: usize| self.polar(j, |r| if r <= p - k { a } else { b });
            let span: Vec<DVec3> = (0..=p).map(at).collect();
            let [start, end] = [span[0], span[p]].map(|control| control.truncate() / control.z);
            let outline = outline.get_or_insert_with(|| Outline::from(start));
            outline.push(Side::Bezier(span), end);
        }
        outline.unwrap_or_else(|| Outline::from(DVec2::ZERO))
    }

    /// The polar form of span j by de Boor's algorithm, with an argument for each step from 1.
    fn polar(&self, j: usize, argument: impl Fn(usize) -> f64) -> DVec3 {
        let p = self.degree;
        let mut row: Vec<DVec3> = self.controls[j - p..=j].to_vec();
        for r in 1..=p {
            let u = argument(r);
            for i in (r..=p).rev() {
                let [low, high] = [self.knots[i + j - p], self.knots[i + 1 + j - r]];
                row[i] = row[i - 1].lerp(row[i], (u - low) / (high - low));
            }
        }
        row[p]
    }
}
