//! Questions about a solid's boundary: rays and nearest points.

use csg::{Nearest, RayHit};
use glam::DVec3;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::Place;
use crate::arrays;
use crate::errors::{invalid, of_model};
use crate::meshing::MeshOptions;
use crate::solid::{PySolid, lower};
use crate::surface::PySurface;
use crate::waiting::{wait, wait_out};

/// Where a ray goes through the boundary of a solid: an item of what `Solid.ray` gives.
#[pyclass(frozen, name = "RayHit", module = "stereotomy")]
pub(crate) struct PyRayHit(RayHit);

#[pymethods]
impl PyRayHit {
    /// The hit is at origin + t * direction; at least 0.
    #[getter]
    fn t(&self) -> f64 {
        self.0.t
    }

    /// About how far t may be off by rounding.
    #[getter]
    fn error(&self) -> f64 {
        self.0.error
    }

    /// Where it is.
    #[getter]
    fn point(&self) -> Place {
        self.0.point.into()
    }

    /// The boundary's normal there, of unit length, out of the solid.
    #[getter]
    fn normal(&self) -> Place {
        self.0.normal.into()
    }

    /// Whether the ray goes into the solid, or out of it.
    #[getter]
    fn enters(&self) -> bool {
        self.0.enters
    }

    /// The face that is hit: its surface, and the primitive's number, name and colour.
    #[getter]
    fn face(&self) -> PySurface {
        PySurface(self.0.face.clone())
    }

    fn __repr__(&self) -> String {
        let way = if self.0.enters { "enters" } else { "leaves" };
        format!("<RayHit {way} at {}, t = {}>", self.0.point, self.0.t)
    }
}

/// What of a solid's boundary is nearest to a point: what `Solid.nearest` gives.
#[pyclass(frozen, name = "Nearest", module = "stereotomy")]
pub(crate) struct PyNearest(Nearest);

#[pymethods]
impl PyNearest {
    /// How far the point is from the boundary, negative within the solid.
    #[getter]
    fn distance(&self) -> f64 {
        self.0.distance
    }

    /// How far that may be off; None if it was not proven.
    #[getter]
    fn error(&self) -> Option<f64> {
        self.0.error
    }

    /// The nearest point, which is no farther than that off the boundary.
    #[getter]
    fn point(&self) -> Place {
        self.0.point.into()
    }

    /// The face it is on: its surface, and the primitive's number, name and colour.
    #[getter]
    fn face(&self) -> PySurface {
        PySurface(self.0.face.clone())
    }

    fn __repr__(&self) -> String {
        format!("<Nearest {} at {}>", self.0.distance, self.0.point)
    }
}

#[pymethods]
impl PySolid {
    /// Where a ray goes through the solid's boundary, in the order along it, entering and
    /// leaving in turn; nothing where it only touches. No mesh is made: hits are exact but for
    /// rounding. The direction may have any length.
    ///
    /// >>> import stereotomy as st
    /// >>> part = st.cube(4).named("block") - st.sphere(1).named("hollow")
    /// >>> [(hit.t, hit.enters, hit.face.name) for hit in part.ray([0, 0, 0], [1, 0, 0])]
    /// [(1.0, True, 'hollow'), (2.0, False, 'block')]
    fn ray(
        &self,
        py: Python<'_>,
        origin: [f64; 3],
        direction: [f64; 3],
    ) -> PyResult<Vec<PyRayHit>> {
        let program = lower(&self.0)?;
        let hits = wait_out(py, || program.ray(origin, direction))?;
        let hits = hits.map_err(of_model)?;
        Ok(hits.into_iter().map(PyRayHit).collect())
    }

    /// How far points are from the solid's boundary, negative within, with the nearest point and
    /// face: one point, or an array of shape (n, 3), for which the answer is a list of n. They are those
    /// of the mesh that the options of `mesh` give, which bounds the error.
    ///
    /// >>> import stereotomy as st
    /// >>> part = st.cube(4).named("block") - st.sphere(1).named("hollow")
    /// >>> near = part.nearest([0, 0, 0.25], tolerance=1e-4)
    /// >>> abs(near.distance - 0.75) <= near.error <= 1e-4, near.face.name
    /// (True, 'hollow')
    /// >>> [round(near.distance, 3) for near in part.nearest([[0, 0, 3], [0, 0, 1.75]])]
    /// [1.0, -0.25]
    #[pyo3(signature = (points, **options))]
    fn nearest<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let one = points.extract::<[f64; 3]>().ok();
        let points: Vec<[f64; 3]> = match one {
            Some(point) => vec![point],
            None => arrays::rows("points", points)?,
        };
        let points: Vec<DVec3> = points.into_iter().map(DVec3::from).collect();
        let MeshOptions { mesher, follow } = MeshOptions::of("nearest", options)?;
        let program = lower(&self.0)?;
        let nearest = wait(py, &follow, || program.nearest(&points, &mesher))?;
        let nearest = nearest.map_err(of_model)?;
        let nearest = nearest.ok_or_else(|| invalid("the solid is empty: nothing is near"))?;
        let mut nearest = nearest.into_iter().map(PyNearest);
        match (one, nearest.next()) {
            (Some(_), Some(nearest)) => Ok(Bound::new(py, nearest)?.into_any()),
            (_, first) => {
                let all: Vec<PyNearest> = first.into_iter().chain(nearest).collect();
                all.into_pyobject(py)
            }
        }
    }
}
