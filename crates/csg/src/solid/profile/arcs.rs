//! Arcs: what a bulge says, and chords instead.

use crate::elementary;

use glam::{DAffine2, DMat2, DVec2};

/// An arc from one point to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub from: DVec2,
    pub to: DVec2,
    pub center: DVec2,
    pub radius: f64,
    /// The angle turned through, counter-clockwise positive.
    pub sweep: f64,
}

impl Arc {
    /// The arc of a bulge that is not zero.
    pub(super) fn new(from: DVec2, to: DVec2, bulge: f64) -> Self {
        let chord = to - from;
        // The centre is (1 - b²) / 4b chords to the left of the chord's middle.
        let left = chord.perp() * ((1.0 - bulge * bulge) / (4.0 * bulge));
        let center = from.midpoint(to) + left;
        let radius = chord.length() * (1.0 + bulge * bulge) / (4.0 * bulge.abs());
        Self {
            from,
            to,
            center,
            radius,
            sweep: 4.0 * elementary::atan(bulge),
        }
    }

    pub(super) fn disc(&self) -> DAffine2 {
        DAffine2::from_scale_angle_translation(DVec2::splat(self.radius), 0.0, self.center)
    }

    /// The point after a share of the arc.
    pub(super) fn at(&self, share: f64) -> DVec2 {
        let turned = elementary::direction(self.sweep * share).rotate(self.from - self.center);
        self.center + turned
    }

    /// The direction of travel after a share of the arc.
    pub(super) fn tangent(&self, share: f64) -> DVec2 {
        let outward = elementary::direction(self.sweep * share).rotate(self.from - self.center);
        (outward.perp() * self.sweep.signum()).normalize_or_zero()
    }

    /// Twice the area between it and its chord, negative if it turns right.
    pub(super) fn doubled_segment(&self) -> f64 {
        self.radius * self.radius * (self.sweep - elementary::sin(self.sweep))
    }
}

/// How far chords may stray from an arc: a length, and a share of its radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sagitta {
    pub length: f64,
    pub of_radius: f64,
}

impl Sagitta {
    pub(crate) const fn of_length(length: f64) -> Self {
        Self {
            length,
            of_radius: 1.0,
        }
    }
}

/// How many chords keep so near to an arc of `sweep` radians.
pub(super) fn chords(radius: f64, sweep: f64, sagitta: Sagitta) -> usize {
    const MOST: f64 = 1e6;
    let share = sagitta.of_radius.min(sagitta.length / radius);
    let half = elementary::acos((1.0 - share).clamp(0.0, 1.0));
    let count = (0.5 * sweep.abs() / half).ceil();
    count.clamp(1.0, MOST) as usize
}

/// By how much a linear map stretches at most.
pub(super) fn stretch(map: &DMat2) -> f64 {
    let (x, y) = (map.x_axis, map.y_axis);
    let sum = x.length_squared() + y.length_squared();
    let product = map.determinant();
    let difference = (sum * sum - 4.0 * product * product).max(0.0).sqrt();
    (0.5 * (sum + difference)).sqrt()
}
