//! Signs of determinants that are never a matter of rounding.
//!
//! Sums of floating-point numbers that do not overlap say what products and sums of others are to the
//! last bit (Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates*, 1997).

use std::cmp::Ordering;

use smallvec::SmallVec;

/// A number as the sum of others: each is larger than all before together, and none is 0.
#[derive(Clone, Debug, Default)]
struct Sum(SmallVec<[f64; 16]>);

/// A sum as it is rounded, and what is lost by that.
fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let of_b = sum - a;
    let of_a = sum - of_b;
    [sum, (a - of_a) + (b - of_b)]
}

/// A product as it is rounded, and what is lost by that.
fn two_product(a: f64, b: f64) -> [f64; 2] {
    let product = a * b;
    [product, a.mul_add(b, -product)]
}

impl Sum {
    fn add(&mut self, number: f64) {
        let mut rest = number;
        let mut kept: SmallVec<[f64; 16]> = SmallVec::new();
        for &part in &self.0 {
            let [sum, lost] = two_sum(rest, part);
            rest = sum;
            if lost != 0.0 {
                kept.push(lost);
            }
        }
        if rest != 0.0 {
            kept.push(rest);
        }
        self.0 = kept;
    }

    fn add_product(&mut self, a: f64, b: f64) {
        for part in two_product(a, b) {
            self.add(part);
        }
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Self::default();
        for &a in &self.0 {
            for &b in &other.0 {
                product.add_product(a, b);
            }
        }
        product
    }

    fn add_all(&mut self, other: &Self, sign: f64) {
        for &part in &other.0 {
            self.add(sign * part);
        }
    }

    /// The largest part has its sign.
    fn cmp_zero(&self) -> Ordering {
        let last = self.0.last().copied().unwrap_or(0.0);
        last.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
    }
}

/// a d - b c.
fn minor([a, b]: [f64; 2], [c, d]: [f64; 2]) -> Sum {
    let mut sum = Sum::default();
    sum.add_product(a, d);
    sum.add_product(-b, c);
    sum
}

/// The sign of the determinant of three rows of three numbers.
pub(crate) fn sign_of_3(rows: [[f64; 3]; 3]) -> Ordering {
    let [p, q, r] = rows;
    let mut sum = Sum::default();
    for (k, &factor) in r.iter().enumerate() {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let mut own = Sum::default();
        own.add(factor);
        sum.add_all(&minor([p[i], p[j]], [q[i], q[j]]).times(&own), 1.0);
    }
    sum.cmp_zero()
}

/// The sign of the determinant of four rows of four numbers, by the minors of the first two and of
/// the last two (Laplace).
pub(crate) fn sign_of_4(rows: [[f64; 4]; 4]) -> Ordering {
    /// Two columns, the other two, and the sign of all four in that order.
    const PARTS: [([usize; 2], [usize; 2], f64); 6] = [
        ([0, 1], [2, 3], 1.0),
        ([0, 2], [1, 3], -1.0),
        ([0, 3], [1, 2], 1.0),
        ([1, 2], [0, 3], 1.0),
        ([1, 3], [0, 2], -1.0),
        ([2, 3], [0, 1], 1.0),
    ];
    let [p, q, r, s] = rows;
    let mut sum = Sum::default();
    for ([i, j], [k, l], sign) in PARTS {
        let first = minor([p[i], p[j]], [q[i], q[j]]);
        let last = minor([r[k], r[l]], [s[k], s[l]]);
        sum.add_all(&first.times(&last), sign);
    }
    sum.cmp_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Of whole numbers as large as products of four of them fit into 128 bits, by those.
    #[test]
    fn signs_are_those_of_whole_numbers() {
        let mut random = Random(9);
        let mut flat = 0;
        for case in 0..2000 {
            let mut number = || {
                let most = [3.0, 1e3, 3e8][case % 3];
                (most * (2.0 * random.unit() - 1.0)).round()
            };
            let mut rows: [[f64; 4]; 4] =
                std::array::from_fn(|_| std::array::from_fn(|_| number()));
            if case % 2 == 0 {
                // In one plane with others, or next to it.
                rows[3] = std::array::from_fn(|k| rows[0][k] + 2.0 * rows[1][k] - rows[2][k]);
                rows[3][case % 4] += [0.0, 1.0, -1.0][case % 3];
            }
            let whole = |rows: &[[f64; 4]], columns: [usize; 3]| -> i128 {
                let at = |i: usize, k: usize| rows[i][columns[k]] as i128;
                at(0, 0) * (at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1))
                    - at(0, 1) * (at(1, 0) * at(2, 2) - at(1, 2) * at(2, 0))
                    + at(0, 2) * (at(1, 0) * at(2, 1) - at(1, 1) * at(2, 0))
            };
            let three = whole(&rows[..3], [0, 1, 2]);
            let rest = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
            let four: i128 = (0..4)
                .map(|k| {
                    let sign = if k % 2 == 0 { -1 } else { 1 };
                    sign * rows[3][k] as i128 * whole(&rows[..3], rest[k])
                })
                .sum();
            let of_3 = [0, 1, 2].map(|k| [rows[k][0], rows[k][1], rows[k][2]]);
            assert_eq!(sign_of_3(of_3), three.cmp(&0), "{rows:?}");
            assert_eq!(sign_of_4(rows), four.cmp(&0), "{rows:?}");
            flat += usize::from(four == 0);
        }
        assert!(flat > 200, "{flat}");
    }
}
