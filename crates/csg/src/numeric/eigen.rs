//! Eigenvalues of symmetric matrices.

use crate::elementary;
use glam::DMat3;

/// Eigenvalues and eigenvectors (columns) of the symmetric matrix of a
/// quadratic form.
pub(crate) fn eigen_symmetric([xx, yy, zz, xy, yz, zx]: [f64; 6]) -> ([f64; 3], DMat3) {
    let (values, vectors) = jacobi([
        [xx, 0.5 * xy, 0.5 * zx],
        [0.5 * xy, yy, 0.5 * yz],
        [0.5 * zx, 0.5 * yz, zz],
    ]);
    (values, DMat3::from_cols_array_2d(&vectors))
}

/// Eigenvalues and eigenvectors of a symmetric matrix, by cyclic Jacobi
/// rotations (Golub and Van Loan, *Matrix Computations*, 8.5).
pub(crate) fn jacobi<const N: usize>(mut a: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut v: [[f64; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    // Convergence is quadratic; six sweeps are plenty.
    for _ in 0..12 {
        for apart in 1..N {
            for p in 0..N - apart {
                let q = p + apart;
                if a[p][q] == 0.0 {
                    continue;
                }
                let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t =
                    if tau >= 0.0 { 1.0 } else { -1.0 } / (tau.abs() + elementary::hypot(tau, 1.0));
                let c = 1.0 / elementary::hypot(t, 1.0);
                let s = t * c;
                let turn = |x: f64, y: f64| (c * x - s * y, s * x + c * y);
                for row in &mut a {
                    (row[p], row[q]) = turn(row[p], row[q]);
                }
                for (rows, keep) in [(&mut a, false), (&mut v, true)] {
                    let (low, high) = (rows[p], rows[q]);
                    for k in 0..N {
                        (rows[p][k], rows[q][k]) = turn(low[k], high[k]);
                    }
                    if !keep {
                        (rows[p][q], rows[q][p]) = (0.0, 0.0);
                    }
                }
            }
        }
    }
    (std::array::from_fn(|k| a[k][k]), v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_of_known_matrices() {
        // [[2,1,0],[1,2,0],[0,0,5]] has 1, 3, 5.
        let (mut values, vectors) = eigen_symmetric([2.0, 2.0, 5.0, 2.0, 0.0, 0.0]);
        values.sort_by(f64::total_cmp);
        for (value, expected) in values.iter().zip([1.0, 3.0, 5.0]) {
            assert!((value - expected).abs() < 1e-14, "{values:?}");
        }
        assert!((vectors.determinant().abs() - 1.0).abs() < 1e-14);
    }
}
