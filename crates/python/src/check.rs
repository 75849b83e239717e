//! The classes `Check` and `Measure`: whether a mesh is sound, and how large it is.

use csg::{MeshCheck, MeshMeasure};
use glam::DMat3;
use pyo3::prelude::*;

/// Whether a mesh is closed, oriented and manifold, in numbers.
#[pyclass(frozen, name = "Check", module = "stereotomy")]
pub(crate) struct PyCheck(pub(crate) MeshCheck);

#[pymethods]
impl PyCheck {
    /// All triangles of the mesh.
    #[getter]
    fn triangles(&self) -> usize {
        self.0.triangles
    }

    /// Vertices that are part of a usable triangle.
    #[getter]
    fn vertices(&self) -> usize {
        self.0.vertices
    }

    /// Distinct edges of usable triangles.
    #[getter]
    fn edges(&self) -> usize {
        self.0.edges
    }

    /// Parts that share no vertex.
    #[getter]
    fn components(&self) -> usize {
        self.0.components
    }

    /// The surface has no border.
    #[getter]
    fn is_closed(&self) -> bool {
        self.0.is_closed()
    }

    /// No two triangles disagree about which side is outside.
    #[getter]
    fn is_oriented(&self) -> bool {
        self.0.is_oriented()
    }

    /// Closed, oriented, and everywhere like a plane.
    #[getter]
    fn is_manifold(&self) -> bool {
        self.0.is_manifold()
    }

    /// Handles, summed over the parts; None unless the mesh is manifold.
    #[getter]
    fn genus(&self) -> Option<i64> {
        self.0.genus()
    }

    /// How often each defect occurs, those that do not left out.
    #[getter]
    fn defects(&self) -> std::collections::BTreeMap<String, usize> {
        let all = csg::MeshDefect::ALL.into_iter();
        let counted = all.map(|defect| (defect.to_string(), self.0.count(defect)));
        counted.filter(|(_, count)| *count > 0).collect()
    }

    fn __repr__(&self) -> String {
        format!("<Check: {}>", self.0)
    }
}

/// Volume, area, centroid and moments, in the model's unit.
#[pyclass(frozen, name = "Measure", module = "stereotomy")]
pub(crate) struct PyMeasure(pub(crate) MeshMeasure);

/// Rows of a matrix.
type Rows = [[f64; 3]; 3];

fn rows(matrix: DMat3) -> Rows {
    matrix.transpose().to_cols_array_2d()
}

#[pymethods]
impl PyMeasure {
    /// The enclosed volume.
    #[getter]
    fn volume(&self) -> f64 {
        self.0.volume
    }

    /// The area of all triangles.
    #[getter]
    fn area(&self) -> f64 {
        self.0.area
    }

    /// The centroid of the volume; None if that is zero.
    #[getter]
    fn centroid(&self) -> Option<(f64, f64, f64)> {
        self.0.centroid.map(Into::into)
    }

    /// The second moments about the centroid, as rows: the integral of (x - c)(x - c)ᵀ.
    #[getter]
    fn second_moments(&self) -> Rows {
        rows(self.0.second_moments)
    }

    /// The inertia tensor about the centroid at density 1, as rows.
    #[getter]
    fn inertia(&self) -> Rows {
        rows(self.0.inertia())
    }

    fn __repr__(&self) -> String {
        format!("<Measure: volume {}, area {}>", self.0.volume, self.0.area)
    }
}
