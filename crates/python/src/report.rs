//! The class `Report`: what a mesher did, and what it could not do.

use csg::{Fallback, Moved, Report};
use pyo3::prelude::*;

use crate::arguments::{Corners, Place};
use crate::check::PyCheck;

/// The account of how a mesh came about.
#[pyclass(frozen, from_py_object, name = "Report", module = "stereotomy")]
#[derive(Clone)]
pub(crate) struct PyReport(pub(crate) Report);

#[pymethods]
impl PyReport {
    /// "boundary", "polyhedral" (exact, of planes), "adaptive", "exact" (a lattice) or
    /// "draft".
    #[getter]
    fn method(&self) -> &'static str {
        self.0.method
    }

    /// The deviation holds without any condition, and nothing had to be settled for.
    #[getter]
    fn is_proven(&self) -> bool {
        self.0.is_proven()
    }

    /// With a tolerance: a bound on the distance between mesh and solid, both ways.
    #[getter]
    fn deviation(&self) -> Option<f64> {
        self.0.deviation
    }

    /// Where the deviation is.
    #[getter]
    fn farthest(&self) -> Option<Place> {
        self.0.farthest.map(Into::into)
    }

    /// The box that was meshed as (least, greatest corner); None if the solid is empty.
    #[getter]
    fn bounds(&self) -> Corners<Place> {
        let bounds = self.0.bounds?;
        Some((bounds.min.into(), bounds.max.into()))
    }

    /// The side of a cell, where cells were used; else 0.
    #[getter]
    fn cell_size(&self) -> f64 {
        self.0.cell_size
    }

    /// Cells that were sampled.
    #[getter]
    fn cells_visited(&self) -> u64 {
        self.0.cells_visited
    }

    /// The largest distance of a vertex from the surface it is assigned to.
    #[getter]
    fn largest_vertex_distance(&self) -> f64 {
        self.0.largest_vertex_distance
    }

    /// The same for the centroids of triangles.
    #[getter]
    fn largest_centroid_distance(&self) -> f64 {
        self.0.largest_centroid_distance
    }

    /// What share of the volume is in the mesh or in the solid alone, as some rays tell.
    #[getter]
    fn difference(&self) -> f64 {
        self.0.difference
    }

    /// What was done to surfaces that nearly coincide or touch, if anything was.
    #[getter]
    fn moved(&self) -> Option<PyMoved> {
        self.0.moved.map(PyMoved)
    }

    /// What had to be settled for somewhere, each kind once.
    #[getter]
    fn fallbacks(&self) -> Vec<PyFallback> {
        self.0.fallbacks.iter().cloned().map(PyFallback).collect()
    }

    /// Where the exact boundary could not be told, so that another way had to do: what
    /// could not be told, and about where.
    #[getter]
    fn undecided(&self) -> Vec<(&'static str, Place)> {
        let places = self.0.undecided.iter();
        let told = places.map(|undecided| (undecided.why.describe(), undecided.place.into()));
        told.collect()
    }

    /// With partial results: what was made larger to stay within the limits.
    #[getter]
    fn limits_reached(&self) -> Vec<String> {
        self.0
            .limits_reached
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    /// Closed, oriented, manifold? Of the finished mesh.
    #[getter]
    fn check(&self) -> PyCheck {
        PyCheck(self.0.check.clone())
    }

    /// The stages and the seconds that they took, in order.
    #[getter]
    fn stages(&self) -> Vec<(&'static str, f64)> {
        self.0.stages.clone()
    }

    fn __repr__(&self) -> String {
        let report = &self.0;
        let mut text = format!("<Report: {}, {}", report.method, report.check);
        if let Some(deviation) = report.deviation {
            let proven = if report.is_proven() { " (proven)" } else { "" };
            text += &format!(", deviation at most {deviation:.3e}{proven}");
        }
        for fallback in &report.fallbacks {
            text += &format!("; settled for {fallback}");
        }
        text + ">"
    }
}

/// One kind of thing that had to be settled for, and where.
#[pyclass(frozen, name = "Fallback", module = "stereotomy")]
pub(crate) struct PyFallback(Fallback);

#[pymethods]
impl PyFallback {
    /// What it is.
    #[getter]
    fn kind(&self) -> &'static str {
        self.0.kind
    }

    /// How often it happened.
    #[getter]
    fn count(&self) -> usize {
        self.0.count
    }

    /// The first few places.
    #[getter]
    fn places(&self) -> Vec<Place> {
        self.0.places.iter().map(|&place| place.into()).collect()
    }

    fn __repr__(&self) -> String {
        format!("<Fallback: {}>", self.0)
    }
}

/// Surfaces that are not where the solid has them.
#[pyclass(frozen, name = "Moved", module = "stereotomy")]
pub(crate) struct PyMoved(Moved);

#[pymethods]
impl PyMoved {
    /// How many surfaces were replaced by another one.
    #[getter]
    fn merged(&self) -> usize {
        self.0.merged
    }

    /// A bound on how far any surface was moved.
    #[getter]
    fn distance(&self) -> f64 {
        self.0.distance
    }

    /// A point of the surface that was moved farthest.
    #[getter]
    fn place(&self) -> Place {
        self.0.place.into()
    }

    fn __repr__(&self) -> String {
        format!(
            "<Moved: by at most {:e}, {} made one with others>",
            self.0.distance, self.0.merged
        )
    }
}
