//! The class `Path`: contours drawn side by side.

use csg::Path;
use pyo3::prelude::*;

use crate::errors::call;
use crate::profile::{PyProfile, checked_profile};

/// A closed contour of lines and arcs, drawn side by side from `start`; the last side back
/// is added where it is missing. It must not cross itself. Each method gives a new path.
///
/// >>> import math, stereotomy as st
/// >>> door = st.Path([0, 0]).line_to([2, 0]).line_to([2, 3]).arc_through([1, 4], [0, 3]).close()
/// >>> abs(door.area(1e-9) - (6 + math.pi / 2)) < 1e-8
/// True
#[pyclass(frozen, name = "Path", module = "stereotomy")]
pub(crate) struct PyPath(Path);

impl PyPath {
    fn path(&self) -> Path {
        self.0.clone()
    }
}

#[pymethods]
impl PyPath {
    #[new]
    fn new(start: [f64; 2]) -> Self {
        Self(Path::from(start))
    }

    /// A straight side.
    fn line_to(&self, end: [f64; 2]) -> Self {
        Self(self.path().line_to(end))
    }

    /// An arc that turns through an angle in degrees (or radians), counter-clockwise
    /// positive, less than a whole turn either way.
    ///
    /// >>> import math, stereotomy as st
    /// >>> half = st.Path([1, 0]).arc_to([-1, 0], 180).close()
    /// >>> abs(half.area(1e-9) - math.pi / 2) < 1e-8
    /// True
    #[pyo3(signature = (end, angle, *, radians=false))]
    fn arc_to(&self, end: [f64; 2], angle: f64, radians: bool) -> Self {
        let angle = crate::arguments::angle(angle, radians);
        Self(self.path().arc_to(end, angle))
    }

    /// The arc through a point on its way; a straight side if the three points lie on a
    /// line.
    fn arc_through(&self, middle: [f64; 2], end: [f64; 2]) -> Self {
        Self(self.path().arc_through(middle, end))
    }

    /// A quadratic Bézier curve: a piece of a parabola, and kept as such.
    fn quadratic_to(&self, control: [f64; 2], end: [f64; 2]) -> Self {
        Self(self.path().quadratic_to(control, end))
    }

    /// A cubic Bézier curve, as chords that stray at most `tolerance`.
    #[pyo3(signature = (first, second, end, *, tolerance=1e-3))]
    fn cubic_to(&self, first: [f64; 2], second: [f64; 2], end: [f64; 2], tolerance: f64) -> Self {
        Self(self.path().cubic_to(first, second, end, tolerance))
    }

    /// What the path encloses, as a profile.
    ///
    /// >>> import stereotomy as st
    /// >>> st.Path([0, 0]).line_to([1, 0]).close()
    /// Traceback (most recent call last):
    /// ValueError: Path.close(): a contour of 2 corners encloses nothing: give at least three, or two with an arc
    fn close(&self) -> PyResult<PyProfile> {
        checked_profile(self.path().close(), call!("Path.close"))
    }

    fn __repr__(&self) -> String {
        "<Path>".to_owned()
    }
}
