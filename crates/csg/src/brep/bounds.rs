//! The box around a boundary.

use glam::DVec3;

use super::chart::is_within;
use super::data::{Brep, Patch, range};
use super::view::Face;
use crate::program::{Bounds, Kind, Surface};

/// Parts of a stretch of a curve in each of which a coordinate has one extreme at most.
const PARTS: u32 = 32;

impl Brep {
    /// The least box around the solid, in model units; none around nothing. To rounding, but
    /// where a rounded face ends next to its outermost point: there to about a thousand
    /// millionth of the solid's size.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        self.bounds_of(&self.patches)
    }

    pub(super) fn bounds_of(&self, patches: &[Patch]) -> Option<Bounds> {
        let mut found: Option<[DVec3; 2]> = None;
        let mut add = |point: DVec3| {
            let [low, high] = found.unwrap_or([point; 2]);
            found = Some([low.min(point), high.max(point)]);
        };
        for patch in patches {
            for stretch in &patch.stretches {
                let curve = &self.curves[stretch.curve as usize];
                extremes(|t| curve.at(t), stretch.places, &mut add);
            }
            let surface = &self.surfaces[patch.side.plane.index()];
            let tips = DVec3::AXES.into_iter().flat_map(|axis| tips(surface, axis));
            tips.filter(|&tip| self.holds(patch, tip))
                .for_each(&mut add);
        }
        found.map(|[low, high]| Bounds {
            min: low + self.origin,
            max: high + self.origin,
        })
    }

    /// Whether a point of a patch's surface is on the patch.
    fn holds(&self, patch: &Patch, point: DVec3) -> bool {
        let chart = self.chart(patch);
        let flat = chart.flatten(point);
        chart.shows(point, flat, self.size)
            && is_within(self.chords(patch, &chart, 2 * PARTS), flat)
    }
}

impl Face<'_> {
    /// The least box around it, as near as [`Brep::bounds`].
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        let brep = self.brep();
        brep.bounds_of(&brep.patches[range(self.patches())])
    }
}

/// Hands on the ends of a stretch of a curve, and where a coordinate is extreme between.
fn extremes(curve: impl Fn(f64) -> DVec3, [from, to]: [f64; 2], add: &mut impl FnMut(DVec3)) {
    /// From its end a part that rises at first rises on so much of it.
    const BESIDE: f64 = 1e-3;
    let step = (to - from) / f64::from(PARTS);
    let places: Vec<f64> = (0..=PARTS).map(|k| from + f64::from(k) * step).collect();
    let points: Vec<DVec3> = places.iter().map(|&t| curve(t)).collect();
    points.iter().for_each(|&point| add(point));
    let beside = [from + BESIDE * step, to - BESIDE * step].map(&curve);
    let ends = [[0, 1], [points.len() - 1, points.len() - 2]];
    for direction in DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
        let far = |point: DVec3| point.dot(direction);
        let mut search = |ends: [f64; 2]| add(curve(highest(|t| far(curve(t)), ends)));
        for (triple, around) in points.windows(3).zip(places.windows(3)) {
            if far(triple[1]) > far(triple[0]) && far(triple[1]) >= far(triple[2]) {
                search([around[0], around[2]]);
            }
        }
        for ([end, next], point) in ends.into_iter().zip(beside) {
            if far(point) > far(points[end]) && far(points[end]) >= far(points[next]) {
                search([places[end], places[next]]);
            }
        }
    }
}

/// Where a function with one maximum between two places has it (golden section).
fn highest(value: impl Fn(f64) -> f64, [mut from, mut to]: [f64; 2]) -> f64 {
    /// The interval shrinks to a hundred-millionth, over which the maximum is flat to
    /// rounding.
    const STEPS: u32 = 40;
    const SHARE: f64 = 0.381_966_011_250_105;
    for _ in 0..STEPS {
        let (a, b) = (from + SHARE * (to - from), to - SHARE * (to - from));
        if value(a) < value(b) {
            from = a;
        } else {
            to = b;
        }
    }
    0.5 * (from + to)
}

/// The points of a surface where its tangent plane lies across a direction, if these are
/// outermost points of it: on other kinds of surfaces extremes are at their faces' borders.
fn tips(surface: &Surface, across: DVec3) -> Vec<DVec3> {
    let form = surface.standard_form();
    let along = form.axes.map(|axis| axis.dot(across));
    let place = |y: [f64; 3]| {
        let terms = form.axes.iter().zip(y).map(|(&axis, y)| y * axis);
        form.center + terms.sum::<DVec3>()
    };
    match surface.kind {
        Kind::Ellipsoid | Kind::HyperboloidTwoSheets => {
            let terms = along.iter().zip(form.values).map(|(d, v)| d * d / v);
            let square = -form.constant / terms.sum::<f64>();
            let at = |sign: f64| {
                let factor = sign * square.sqrt();
                place(std::array::from_fn(|k| factor * along[k] / form.values[k]))
            };
            let tips = [1.0, -1.0].map(at);
            tips.into_iter().filter(|tip| tip.is_finite()).collect()
        }
        Kind::EllipticParaboloid => {
            let factor = form.slope / along[2];
            let [x, y] = [0, 1].map(|k| factor * along[k] / (2.0 * form.values[k]));
            let rest = form.values[0] * x * x + form.values[1] * y * y + form.constant;
            let tip = place([x, y, -rest / form.slope]);
            Some(tip)
                .filter(|tip| tip.is_finite())
                .into_iter()
                .collect()
        }
        _ => Vec::new(),
    }
}
