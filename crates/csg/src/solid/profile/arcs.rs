//! Arcs: what a bulge says, and chords instead.

use crate::elementary;

use glam::{DAffine2, DMat2, DVec2};

use super::{Contour, Corner};

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

/// The corner after corner k, and the arc between them if there is one.
pub(super) fn side(contour: &[Corner], k: usize) -> (DVec2, Option<Arc>) {
    let Corner { point, bulge } = contour[k];
    let next = contour[(k + 1) % contour.len()].point;
    let arc = (bulge != 0.0).then(|| Arc::new(point, next, bulge));
    (next, arc)
}

/// The contour with the arcs that `keeps` does not want cut into chords that
/// keep so near to them under a map that stretches by `stretch`.
pub(super) fn cut(
    contour: &[Corner],
    stretch: f64,
    sagitta: Sagitta,
    keeps: impl Fn(&Arc) -> bool,
) -> Contour {
    let mut corners = Vec::with_capacity(contour.len());
    for (k, &corner) in contour.iter().enumerate() {
        match side(contour, k).1 {
            Some(arc) if !keeps(&arc) => {
                let count = chords(arc.radius * stretch, arc.sweep, sagitta);
                corners.push(Corner::straight(corner.point));
                let inner = (1..count).map(|i| arc.at(i as f64 / count as f64));
                corners.extend(inner.map(Corner::straight));
            }
            _ => corners.push(corner),
        }
    }
    corners
}

/// Twice the area, arcs included: positive if counter-clockwise.
pub(super) fn doubled_area(contour: &[Corner]) -> f64 {
    let base = contour.first().map_or(DVec2::ZERO, |corner| corner.point);
    (0..contour.len())
        .map(|k| {
            let (next, arc) = side(contour, k);
            let chord = (contour[k].point - base).perp_dot(next - base);
            let segment = arc.map_or(0.0, |arc| {
                arc.radius * arc.radius * (arc.sweep - elementary::sin(arc.sweep))
            });
            chord + segment
        })
        .sum()
}

/// The same contour the other way round.
pub(super) fn reversed(contour: &[Corner]) -> Contour {
    let count = contour.len();
    (0..count)
        .map(|k| Corner {
            point: contour[count - 1 - k].point,
            bulge: -contour[(2 * count - 2 - k) % count].bulge,
        })
        .collect()
}

/// By how much a linear map stretches at most.
pub(super) fn stretch(map: &DMat2) -> f64 {
    let (x, y) = (map.x_axis, map.y_axis);
    let sum = x.length_squared() + y.length_squared();
    let product = map.determinant();
    let difference = (sum * sum - 4.0 * product * product).max(0.0).sqrt();
    (0.5 * (sum + difference)).sqrt()
}
