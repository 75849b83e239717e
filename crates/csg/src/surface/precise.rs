//! Values free of rounding but for the last, for points next to which a quadric bends so
//! sharply that rounding would move it by far more than coordinates tell: the ends of
//! needles, the rims of flat ellipsoids.

use glam::DVec3;

use super::Surface;
use crate::numeric::tolerance::USUAL_VALUE;

/// A sum of two doubles, the second beyond the last digit of the first (Dekker, *A
/// Floating-Point Technique for Extending the Available Precision*, 1971).
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Double {
    /// a + b.
    fn sum(a: f64, b: f64) -> Self {
        let sum = a + b;
        let of_b = sum - a;
        Self(sum, (a - (sum - of_b)) + (b - of_b))
    }

    /// a b.
    fn product(a: f64, b: f64) -> Self {
        let halves = |x: f64| {
            let scaled = 134_217_729.0 * x;
            let high = scaled - (scaled - x);
            (high, x - high)
        };
        let product = a * b;
        let ((a0, a1), (b0, b1)) = (halves(a), halves(b));
        Self(product, ((a0 * b0 - product) + a0 * b1 + a1 * b0) + a1 * b1)
    }

    fn plus(self, other: Self) -> Self {
        let high = Self::sum(self.0, other.0);
        let low = Self::sum(self.1, other.1);
        let sum = Self::sum(high.0, high.1 + low.0);
        Self::sum(sum.0, sum.1 + low.1)
    }

    fn times(self, other: Self) -> Self {
        let product = Self::product(self.0, other.0);
        Self::sum(product.0, product.1 + (self.0 * other.1 + self.1 * other.0))
    }

    fn times_coefficient(self, coefficient: f64) -> Self {
        self.times(Self(coefficient, 0.0))
    }
}

impl Surface {
    /// About the largest error of [`Self::value`] at a point.
    #[inline]
    pub(crate) fn rounding_of_value(&self, point: DVec3) -> f64 {
        let square = (point - self.anchor).length_squared();
        let slope = self.linear.length();
        USUAL_VALUE * (square + slope * square.sqrt() + self.constant.abs())
    }

    /// f at a point to twice as many digits as [`Self::value`] computes with, rounded
    /// once; ten times as slow.
    pub(crate) fn precise_value(&self, point: DVec3) -> f64 {
        let (p, anchor) = (point.to_array(), self.anchor.to_array());
        let [dx, dy, dz] = [0, 1, 2].map(|axis| Double::sum(p[axis], -anchor[axis]));
        let [xx, yy, zz, xy, yz, zx] = self.quadratic;
        let along = |square: f64, d: Double, product: f64, other: Double, linear: f64| {
            let of_squares = d.times_coefficient(square);
            let of_products = other.times_coefficient(product);
            let sum = of_squares.plus(of_products).plus(Double(linear, 0.0));
            sum.times(d)
        };
        let sum = along(xx, dx, xy, dy, self.linear.x)
            .plus(along(yy, dy, yz, dz, self.linear.y))
            .plus(along(zz, dz, zx, dx, self.linear.z))
            .plus(Double(self.constant, 0.0));
        sum.0 + sum.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrangement::random_quadric;
    use crate::random::Random;

    #[test]
    fn values_are_those_of_rational_arithmetic() {
        // At points of few digits the value is a whole number of more than a double's.
        let mut random = Random(3);
        for _ in 0..500 {
            let mut digits = |count: u32| (random.unit() * 2f64.powi(count as i32)).floor() as i64;
            let q: [i64; 6] = std::array::from_fn(|_| digits(30) - (1 << 29));
            let linear: [i64; 3] = std::array::from_fn(|_| digits(30) - (1 << 29));
            let constant = digits(40);
            let [p, anchor]: [[i64; 3]; 2] =
                std::array::from_fn(|_| std::array::from_fn(|_| digits(20) - (1 << 19)));
            let float = |v: [i64; 3]| DVec3::from_array(v.map(|v| v as f64));
            let surface = Surface::of_terms(
                float(anchor),
                q.map(|v| v as f64),
                float(linear),
                constant as f64,
            );
            let d: [i128; 3] = std::array::from_fn(|k| i128::from(p[k] - anchor[k]));
            let q = q.map(i128::from);
            let exact = q[0] * d[0] * d[0]
                + q[1] * d[1] * d[1]
                + q[2] * d[2] * d[2]
                + q[3] * d[0] * d[1]
                + q[4] * d[1] * d[2]
                + q[5] * d[2] * d[0]
                + (0..3).map(|k| i128::from(linear[k]) * d[k]).sum::<i128>()
                + i128::from(constant);
            assert_eq!(surface.precise_value(float(p)), exact as f64);
        }
    }

    #[test]
    fn plain_values_are_off_by_no_more_than_their_rounding() {
        let mut random = Random(4);
        for _ in 0..2000 {
            let surface = random_quadric(&mut random);
            let point = DVec3::from_array(std::array::from_fn(|_| 4.0 * random.unit() - 2.0));
            let off = (surface.value(point) - surface.precise_value(point)).abs();
            assert!(
                off <= surface.rounding_of_value(point),
                "{surface:?} {point}"
            );
        }
    }
}
