//! The classes `Check` and `Measure`: whether a mesh is sound, and how large it is.

use csg::brep::SolidMeasure;
use csg::{MeshCheck, MeshMeasure};
use glam::DMat3;
use pyo3::prelude::*;

use crate::arguments::Place;

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

/// Volume, area, centroid and moments, in the model's unit: of a solid's exact boundary, with
/// bounds on their errors, or of a mesh.
#[pyclass(frozen, name = "Measure", module = "stereotomy")]
pub(crate) struct PyMeasure(pub(crate) Measured);

/// What was measured.
pub(crate) enum Measured {
    Solid(SolidMeasure),
    Mesh(MeshMeasure),
}

/// Rows of a matrix.
type Rows = [[f64; 3]; 3];

fn rows(matrix: DMat3) -> Rows {
    matrix.transpose().to_cols_array_2d()
}

#[pymethods]
impl PyMeasure {
    /// The volume.
    #[getter]
    pub(crate) fn volume(&self) -> f64 {
        match &self.0 {
            Measured::Solid(measure) => measure.volume.value,
            Measured::Mesh(measure) => measure.volume,
        }
    }

    /// A bound on how far the volume is off; None of a mesh.
    #[getter]
    fn volume_error(&self) -> Option<f64> {
        match &self.0 {
            Measured::Solid(measure) => Some(measure.volume.error),
            Measured::Mesh(_) => None,
        }
    }

    /// The area of the boundary.
    #[getter]
    pub(crate) fn area(&self) -> f64 {
        match &self.0 {
            Measured::Solid(measure) => measure.area.value,
            Measured::Mesh(measure) => measure.area,
        }
    }

    /// A bound on how far the area is off; None of a mesh.
    #[getter]
    fn area_error(&self) -> Option<f64> {
        match &self.0 {
            Measured::Solid(measure) => Some(measure.area.error),
            Measured::Mesh(_) => None,
        }
    }

    /// The centroid of the volume; None if that is zero.
    #[getter]
    fn centroid(&self) -> Option<Place> {
        match &self.0 {
            Measured::Solid(measure) => measure.centroid.map(|c| c.map(|x| x.value).into()),
            Measured::Mesh(measure) => measure.centroid.map(Into::into),
        }
    }

    /// The second moments about the centroid, as rows: the integral of (x - c)(x - c)ᵀ.
    #[getter]
    fn second_moments(&self) -> Rows {
        rows(match &self.0 {
            Measured::Solid(measure) => measure.second_moments,
            Measured::Mesh(measure) => measure.second_moments,
        })
    }

    /// The inertia tensor about the centroid at density 1, as rows.
    #[getter]
    fn inertia(&self) -> Rows {
        rows(match &self.0 {
            Measured::Solid(measure) => measure.inertia(),
            Measured::Mesh(measure) => measure.inertia(),
        })
    }

    fn __repr__(&self) -> String {
        let within = |error: Option<f64>| error.map_or(String::new(), |e| format!(" ± {e:.0e}"));
        format!(
            "<Measure: volume {}{}, area {}{}>",
            self.volume(),
            within(self.volume_error()),
            self.area(),
            within(self.area_error())
        )
    }
}
