//! How far two surfaces of one kind are apart.

use super::element::Element;
use crate::numeric::eigen_symmetric;
use crate::numeric::tolerance::SAME_VALUE;
use crate::program::Surface;

impl Surface {
    /// Whether both half-spaces, of surfaces that nearly coincide, are on one side.
    pub(super) fn is_aligned(&self, other: &Self) -> bool {
        let terms = |s: &Self| {
            if s.is_plane() {
                [s.linear.x, s.linear.y, s.linear.z, 0.0, 0.0, 0.0]
            } else {
                s.quadratic
            }
        };
        let products = terms(self).into_iter().zip(terms(other));
        products.map(|(a, b)| a * b).sum::<f64>() > 0.0
    }

    /// Bound, to first order, on the distance between this surface and another one of
    /// its kind, within a ball about the origin; infinite if they are not alike.
    pub(super) fn distance_bound(&self, other: &Self, reach: f64) -> f64 {
        if self.is_plane() != other.is_plane() {
            return f64::INFINITY;
        }
        let sign = if self.is_aligned(other) { 1.0 } else { -1.0 };
        if self.is_plane() {
            let [one, off] = [self, other].map(|plane| plane.linear.dot(plane.anchor));
            let turn = (self.linear - sign * other.linear).length();
            return (one - sign * off).abs() + turn * reach;
        }
        let general = self.bound_by_functions(other, reach);
        let [one, other] = [self, other].map(|s| Element::of(s, reach, f64::INFINITY));
        let by_numbers = one.distance_bound(&other, reach);
        by_numbers.map_or(general, |bound| bound.min(general))
    }

    /// The same of two quadrics.
    ///
    /// If f is this one's function and D its difference to a multiple of the other
    /// one's, points of the other one are off this one by |D| / |∇f|.
    fn bound_by_functions(&self, other: &Self, reach: f64) -> f64 {
        let dot = |p: &[f64; 6], q: &[f64; 6]| -> f64 { p.iter().zip(q).map(|(p, q)| p * q).sum() };
        let factor =
            dot(&self.quadratic, &other.quadratic) / dot(&other.quadratic, &other.quadratic);
        let rest: [f64; 6] =
            std::array::from_fn(|k| self.quadratic[k] - factor * other.quadratic[k]);
        let form = dot(&rest, &rest).sqrt();
        let (linear, constant) = other.expanded_about(self.anchor);
        let linear = (self.linear - factor * linear).length();
        let constant = (self.constant - factor * constant).abs();
        let reach = reach + self.anchor.length();
        let (values, axes) = eigen_symmetric(self.quadratic);
        let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let is_none = |value: f64| value.abs() <= SAME_VALUE * largest;
        let least = values.iter().filter(|&&v| !is_none(v));
        let least = least.fold(f64::INFINITY, |m, v| m.min(v.abs()));
        if self.apex().is_some() {
            // Both gradient and difference grow with the distance from the apex.
            return (form * reach + linear) / (2.0 * least) + (constant / least).sqrt();
        }
        let along = |k: usize| self.linear.dot(axes.col(k)).abs();
        let slope = (0..3).filter(|&k| is_none(values[k])).map(along);
        // On Σ v x² = c the square of the gradient is 4 Σ v² x², at least 4 |v c|.
        let gradient = slope
            .fold(0.0, f64::max)
            .max(2.0 * (least * self.constant.abs()).sqrt());
        ((form * reach + linear) * reach + constant) / gradient
    }
}
