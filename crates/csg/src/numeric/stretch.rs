//! How much maps stretch.

use glam::{DAffine3, DMat3, DVec3};

/// By how much an affine map makes lengths longer at most, or a little more: exactly of rotations, of
/// scales along the axes and of products of both.
#[must_use]
pub fn stretch(map: &DAffine3) -> f64 {
    // The spectral norm of a symmetric matrix is no more than its greatest sum of a row.
    let square = map.matrix3.transpose() * map.matrix3;
    let rows = DMat3::from_cols_array(&square.to_cols_array().map(f64::abs)) * DVec3::ONE;
    rows.max_element().sqrt()
}
