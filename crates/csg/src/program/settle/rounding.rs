//! Surfaces in round numbers.

use crate::elementary;
use glam::DVec3;

use crate::numeric::eigen_symmetric;
use crate::numeric::tolerance::SAME_VALUE;
use crate::program::Surface;

/// How many decimals numbers are rounded to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decimal {
    /// The power of ten.
    per_unit: f64,
}

impl Decimal {
    /// So few that rounding changes a number by no more than a distance.
    pub fn below(distance: f64) -> Self {
        let digits = (-elementary::log10(2.0 * distance)).ceil();
        Self {
            per_unit: elementary::pow(10f64, digits),
        }
    }

    pub fn step(self) -> f64 {
        1.0 / self.per_unit
    }

    /// A number rounded, the same for all that round to it.
    fn round(self, value: f64) -> f64 {
        let rounded = (value * self.per_unit).round() / self.per_unit;
        if rounded.is_finite() { rounded } else { value }
    }

    fn round_all(self, point: DVec3) -> DVec3 {
        point.map(|value| self.round(value))
    }
}

impl Surface {
    /// This surface with its place and sizes rounded to one number of decimals, and its
    /// directions to another; none where it has no such numbers.
    pub(super) fn rounded(
        &self,
        (origin, reach): (DVec3, f64),
        step: Decimal,
        turn: Decimal,
    ) -> Option<Self> {
        /// Sizes that are so many times the scene's are no numbers that an author wrote
        /// beside the others.
        const HUGE: f64 = 1e3;
        let direction = |axis: DVec3| turn.round_all(axis).normalize_or_zero();
        if self.is_plane() {
            // Turned about the point nearest to the solid's middle.
            let foot = origin - self.value(origin) * self.linear;
            let linear = direction(self.linear);
            let anchor = step.round(linear.dot(foot)) * linear;
            return Some(Self {
                anchor,
                linear,
                ..*self
            });
        }
        let (values, axes) = eigen_symmetric(self.quadratic);
        let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let is_same = |a: f64, b: f64| (a - b).abs() <= SAME_VALUE * largest;
        let is_none = |value: f64| is_same(value, 0.0);
        let is_central = self.linear == DVec3::ZERO;
        if !is_central {
            let anchor = step.round_all(self.anchor);
            return Some(Self { anchor, ..*self });
        }
        // The last two may be the same, and the first one differs from them.
        let odd = (0..3).find(|&k| is_same(values[(k + 1) % 3], values[(k + 2) % 3]));
        let order = odd.map_or([0, 1, 2], |k| [k, (k + 1) % 3, (k + 2) % 3]);
        let values = order.map(|k| values[k]);
        let mut axes = order.map(|k| axes.col(k));
        // The point of an axis nearest to the solid's middle, whatever it was made from.
        let mut anchor = self.anchor;
        for (value, axis) in values.iter().zip(axes) {
            if is_none(*value) {
                anchor += (origin - anchor).dot(axis) * axis;
            }
        }
        let anchor = step.round_all(anchor);
        axes[0] = direction(axes[0]);
        axes[1] = if odd.is_some() {
            axes[0].any_orthonormal_vector()
        } else {
            direction(axes[1])
                .reject_from_normalized(axes[0])
                .normalize_or_zero()
        };
        axes[2] = axes[0].cross(axes[1]);
        // Squares of sizes, which are lengths, or of slopes if they go through a point.
        let unit = if self.constant == 0.0 {
            largest
        } else {
            self.constant.abs()
        };
        let decimals = if self.constant == 0.0 { turn } else { step };
        let square = |value: f64| {
            if is_none(value) {
                return 0.0;
            }
            let size = (unit / value.abs()).sqrt();
            let rounded = decimals.round(size);
            let size = if rounded > 0.0 && size <= HUGE * reach {
                rounded
            } else {
                size
            };
            value.signum() / (size * size)
        };
        let squares = [square(values[0]), square(values[1]), square(values[2])];
        let squares = match odd {
            Some(_) => [squares[0], squares[1], squares[1]],
            None => squares,
        };
        // Σ square axis axisᵀ; where two are the same, what that leaves of the unit
        // matrix times these, so that no direction across the first is distinguished.
        let mut form = [0.0; 6];
        let rest = if odd.is_some() { squares[1] } else { 0.0 };
        for (square, axis) in squares.iter().zip(axes) {
            let [x, y, z] = axis.to_array();
            let weight = square - rest;
            let terms = [x * x, y * y, z * z, 2.0 * x * y, 2.0 * y * z, 2.0 * z * x];
            for (sum, term) in form.iter_mut().zip(terms) {
                *sum += weight * term;
            }
        }
        for sum in &mut form[..3] {
            *sum += rest;
        }
        let size = form.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        let constant = if self.constant == 0.0 {
            0.0
        } else {
            self.constant.signum() / size
        };
        let rounded = Self {
            anchor,
            quadratic: form.map(|c| c / size),
            linear: DVec3::ZERO,
            constant,
            kind: self.kind,
        };
        let is_finite = rounded.quadratic.iter().all(|c| c.is_finite()) && constant.is_finite();
        (is_finite && size > 0.0).then_some(rounded)
    }
}
