//! The class `Mesh`: triangles as NumPy arrays, measured, checked and drawn.

use std::sync::Arc;

use csg::{Mesh, Meshed, Solid};
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arguments::{Corners, Place};
use crate::arrays;
use crate::check::{Measured, PyCheck, PyMeasure};
use crate::errors::invalid;
use crate::files::repaired;
use crate::report::PyReport;
use crate::solid::PySolid;
use crate::surface::PySurface;
use crate::unit;
use crate::waiting::wait_out;

/// A triangle mesh: `Solid.mesh` and `load_mesh` make it, or arrays of vertices of shape
/// (n, 3) and of triangles of shape (m, 3), counter-clockwise seen from outside. Its own
/// arrays are views that cannot be written to: no copy is made (`mesh.vertices.copy()` is
/// one).
///
/// >>> import stereotomy as st
/// >>> mesh = st.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
/// ...                [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
/// >>> mesh.check().is_manifold, round(6 * mesh.volume, 9)
/// (True, 1.0)
#[pyclass(frozen, weakref, name = "Mesh", module = "stereotomy")]
pub(crate) struct PyMesh {
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) report: Option<PyReport>,
}

impl PyMesh {
    pub(crate) fn of(meshed: Meshed) -> Self {
        Self {
            mesh: Arc::new(meshed.mesh),
            report: Some(PyReport(meshed.report)),
        }
    }

    pub(crate) fn without_report(mesh: Mesh) -> Self {
        Self {
            mesh: Arc::new(mesh),
            report: None,
        }
    }
}

#[pymethods]
impl PyMesh {
    #[new]
    #[pyo3(signature = (vertices, triangles, *, triangle_surfaces=None, surfaces=None, corner_normals=None, feature_edges=None, unit="mm"))]
    #[allow(clippy::too_many_arguments, reason = "Python's keywords")]
    fn new(
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        triangle_surfaces: Option<&Bound<'_, PyAny>>,
        surfaces: Option<Vec<PySurface>>,
        corner_normals: Option<&Bound<'_, PyAny>>,
        feature_edges: Option<Vec<Bound<'_, PyAny>>>,
        unit: &str,
    ) -> PyResult<Self> {
        let vertices: Vec<[f64; 3]> = arrays::rows("vertices", vertices)?;
        let triangles: Vec<[u32; 3]> = arrays::rows("triangles", triangles)?;
        let in_range = |index: u32| (index as usize) < vertices.len();
        if let Some(at) = triangles
            .iter()
            .position(|t| !t.iter().all(|&v| in_range(v)))
        {
            return Err(invalid(format!(
                "triangles[{at}] is {:?}: there are {} vertices",
                triangles[at],
                vertices.len()
            )));
        }
        let mut mesh = Mesh::new(vertices.into_iter().map(Into::into).collect(), triangles);
        let surfaces = surfaces.unwrap_or_default();
        let of_triangles: Vec<u32> = match triangle_surfaces {
            Some(given) => arrays::row("triangle_surfaces", given)?,
            None => Vec::new(),
        };
        if !of_triangles.is_empty() && of_triangles.len() != mesh.triangles.len()
            || of_triangles.iter().any(|&s| s as usize >= surfaces.len())
        {
            return Err(invalid(format!(
                "triangle_surfaces must have an index into surfaces (there are {}) for each of the {} triangles",
                surfaces.len(),
                mesh.triangles.len()
            )));
        }
        mesh.triangle_surfaces = of_triangles;
        mesh.surfaces = surfaces.into_iter().map(|surface| surface.0).collect();
        if let Some(normals) = corner_normals {
            let numpy = normals.py().import("numpy")?;
            let flat = numpy.call_method1("reshape", (normals, (-1, 3)))?;
            let normals: Vec<[f32; 3]> = arrays::rows("corner_normals", &flat)?;
            if normals.len() != 3 * mesh.triangles.len() {
                return Err(invalid(format!(
                    "corner_normals must have the shape ({}, 3, 3)",
                    mesh.triangles.len()
                )));
            }
            let corners = normals.chunks_exact(3);
            mesh.corner_normals = corners
                .map(|corner| std::array::from_fn(|k| corner[k].into()))
                .collect();
        }
        for edge in feature_edges.into_iter().flatten() {
            mesh.feature_edges
                .push(arrays::row("feature_edges", &edge)?);
        }
        let count = mesh.positions.len();
        let mut along_edges = mesh.feature_edges.iter().flatten();
        if let Some(vertex) = along_edges.find(|&&vertex| vertex as usize >= count) {
            return Err(invalid(format!(
                "feature_edges name the vertex {vertex}: there are {count}"
            )));
        }
        mesh.unit = unit::named(unit)?;
        Ok(Self::without_report(mesh))
    }

    /// The vertices' positions, (n, 3) float64: a view, not a copy.
    #[getter]
    fn vertices<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let positions = &slf.get().mesh.positions;
        arrays::view(slf, positions, [positions.len(), 3])
    }

    /// The triangles' vertices, (m, 3) uint32: a view, not a copy.
    #[getter]
    fn triangles<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let triangles = &slf.get().mesh.triangles;
        arrays::view(slf, triangles, [triangles.len(), 3])
    }

    /// For each triangle its index into `surfaces`, (m,) uint32: a view; empty if nobody
    /// knows.
    #[getter]
    fn triangle_surfaces<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let surfaces = &slf.get().mesh.triangle_surfaces;
        arrays::view(slf, surfaces, [surfaces.len()])
    }

    /// Outward unit normals at triangles' corners, (m, 3, 3) float32: a view; empty if
    /// nobody computed them.
    #[getter]
    fn corner_normals<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let normals = &slf.get().mesh.corner_normals;
        arrays::view(slf, normals, [normals.len(), 3, 3])
    }

    /// What the triangles' surfaces are.
    #[getter]
    fn surfaces(&self) -> Vec<PySurface> {
        self.mesh.surfaces.iter().cloned().map(PySurface).collect()
    }

    /// Feature edges as polylines of vertex indices, a closed one ends where it began: views.
    #[getter]
    fn feature_edges<'py>(slf: &Bound<'py, Self>) -> PyResult<Vec<Bound<'py, PyArray1<u32>>>> {
        let edges = slf.get().mesh.feature_edges.iter();
        edges
            .map(|edge| arrays::view(slf, edge, [edge.len()]))
            .collect()
    }

    /// The unit of the positions.
    #[getter]
    fn unit(&self) -> &'static str {
        unit::symbol(self.mesh.unit)
    }

    /// How the mesh came about; None if no mesher made it.
    #[getter]
    fn report(&self) -> Option<PyReport> {
        self.report.clone()
    }

    /// (Least, greatest corner) of the box around all vertices; None without any.
    #[getter]
    fn bounds(&self) -> Corners<Place> {
        let (low, high) = self.mesh.bounds()?;
        Some((low.into(), high.into()))
    }

    /// The enclosed volume.
    #[getter]
    fn volume(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.measure(py)?.volume())
    }

    /// The area of all triangles.
    #[getter]
    fn area(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.measure(py)?.area())
    }

    /// Volume, area, centroid and moments, in one pass.
    pub(crate) fn measure(&self, py: Python<'_>) -> PyResult<PyMeasure> {
        let measure = wait_out(py, || self.mesh.measure())?;
        Ok(PyMeasure(Measured::Mesh(measure)))
    }

    /// Whether the mesh is closed, oriented and manifold.
    fn check(&self, py: Python<'_>) -> PyResult<PyCheck> {
        Ok(PyCheck(wait_out(py, || self.mesh.check())?))
    }

    /// Pairs of triangles that run through each other, (k, 2) uint32.
    ///
    /// >>> import stereotomy as st
    /// >>> st.cube(1).mesh().self_intersections().shape
    /// (0, 2)
    fn self_intersections<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        use numpy::PyArrayMethods;
        let pairs = wait_out(py, || self.mesh.self_intersections())?;
        let shape = [pairs.len(), 2];
        PyArray1::from_vec(py, pairs.into_flattened()).reshape(shape)
    }

    /// The solid that the mesh bounds, to be combined with others: its triangles' planes as
    /// half-spaces. All that is wrong with the mesh is an error with its places; with `repair`
    /// what can be is mended (holes, triangles that look the wrong way or are there twice,
    /// shells through others), with a warning that says what was changed.
    ///
    /// >>> import stereotomy as st
    /// >>> again = st.cube(2).mesh().to_solid() - st.sphere(1.2)
    /// >>> again.contains([0.9, 0.9, 0.9])
    /// True
    #[pyo3(signature = (*, repair=false))]
    fn to_solid(&self, py: Python<'_>, repair: bool) -> PyResult<PySolid> {
        if repair {
            let solid = wait_out(py, || Solid::repaired(&self.mesh))?;
            return repaired(py, solid.map_err(|faults| invalid(faults.to_string()))?);
        }
        let solid = wait_out(py, || Solid::from_mesh(&self.mesh))?;
        let solid = solid.map_err(|faults| invalid(faults.to_string()))?;
        Ok(PySolid(solid))
    }

    fn __repr__(&self) -> String {
        format!(
            "<Mesh: {} triangles, {} vertices>",
            self.mesh.triangles.len(),
            self.mesh.positions.len()
        )
    }

    /// Pickles hold all but the report.
    fn __getnewargs_ex__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        let py = slf.py();
        let mesh = slf.get();
        let keywords = PyDict::new(py);
        keywords.set_item("triangle_surfaces", Self::triangle_surfaces(slf)?)?;
        keywords.set_item("surfaces", mesh.surfaces())?;
        keywords.set_item("corner_normals", Self::corner_normals(slf)?)?;
        keywords.set_item("feature_edges", Self::feature_edges(slf)?)?;
        keywords.set_item("unit", mesh.unit())?;
        let arrays = (Self::vertices(slf)?, Self::triangles(slf)?);
        Ok((arrays.into_pyobject(py)?, keywords))
    }
}
