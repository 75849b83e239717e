//! Principal axes of quadrics.

use glam::DMat3;

use super::Surface;
use crate::numeric::eigen_symmetric;

impl Surface {
    /// Unit directions at right angles (columns) along which f is
    /// Σ values_k x_k², plus linear terms and a constant, and those values: with
    /// x measured from [`anchor`](Surface::anchor). All 0 for a plane.
    #[must_use]
    pub fn principal_axes(&self) -> ([f64; 3], DMat3) {
        eigen_symmetric(self.quadratic)
    }
}
