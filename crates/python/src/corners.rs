//! What is made of the corners of solids: hulls, Minkowski sums, new sizes, projections.

use csg::corners::Faceting;
use csg::{Error, Profile, Solid};
use glam::{BVec2, BVec3};
use pyo3::prelude::*;

use crate::errors::of_model;
use crate::profile::PyProfile;
use crate::solid::PySolid;
use crate::waiting::wait_out;

fn made<T: Send>(
    py: Python<'_>,
    within: f64,
    of: impl FnOnce(&mut Faceting) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let mut faceting = Faceting::new().within(within);
    wait_out(py, || of(&mut faceting))?.map_err(of_model)
}

#[pymethods]
impl PySolid {
    /// The Minkowski sum of two solids: all sums of a point of each. Exact of flat faces, of balls,
    /// and of balls of one size and flat faces with at most 200 corners; what else is curved is taken
    /// for faces within a share of its size.
    ///
    /// >>> import math, stereotomy as st
    /// >>> rounded = st.cube(2).minkowski_sum(st.sphere(0.5))
    /// >>> volume = 8 + 24 * 0.5 + 6 * math.pi * 0.25 + math.pi / 6
    /// >>> abs(rounded.measure().volume - volume) < 1e-9
    /// True
    #[pyo3(signature = (other, *, within=1e-4))]
    fn minkowski_sum(&self, py: Python<'_>, other: &Self, within: f64) -> PyResult<Self> {
        let both = [self.0.clone(), other.0.clone()];
        made(py, within, |faceting| Solid::minkowski_sum(both, faceting)).map(Self)
    }

    /// The solid scaled about the origin to a size along each axis: 0 leaves an axis alone, or, where
    /// `auto` is true, scales it as the axis of the largest new size.
    ///
    /// >>> import stereotomy as st
    /// >>> bar = st.cuboid([1, 2, 3]).resized([2, 0, 0], auto=(False, True, False))
    /// >>> round(bar.measure().volume, 9)
    /// 24.0
    #[pyo3(signature = (size, auto=(false, false, false), *, within=1e-4), text_signature = "($self, size, auto=(False, False, False), *, within=0.0001)")]
    fn resized(
        &self,
        py: Python<'_>,
        size: [f64; 3],
        auto: (bool, bool, bool),
        within: f64,
    ) -> PyResult<Self> {
        let auto = BVec3::new(auto.0, auto.1, auto.2);
        made(py, within, |faceting| self.0.resized(size, auto, faceting)).map(Self)
    }

    /// The projection onto the plane z = 0 as a profile: of flat faces exact, what is curved is
    /// taken for faces within a share of its size.
    ///
    /// >>> import stereotomy as st
    /// >>> round(st.cube(2).rotate_x(45).projection().area() ** 2, 9)
    /// 32.0
    #[pyo3(signature = (*, within=1e-4))]
    fn projection(&self, py: Python<'_>, within: f64) -> PyResult<PyProfile> {
        made(py, within, |faceting| self.0.projection(faceting)).map(PyProfile)
    }
}

#[pymethods]
impl PyProfile {
    /// The Minkowski sum of two profiles: all sums of a point of each. Exact of polygons, and where
    /// one is a circle.
    ///
    /// >>> import math, stereotomy as st
    /// >>> rounded = st.rectangle([2, 1]).minkowski_sum(st.circle(0.5))
    /// >>> abs(rounded.area(1e-6) - (2 + 3 + math.pi / 4)) < 1e-5
    /// True
    #[pyo3(signature = (other, *, within=1e-4))]
    fn minkowski_sum(&self, py: Python<'_>, other: &Self, within: f64) -> PyResult<Self> {
        let both = [self.0.clone(), other.0.clone()];
        made(py, within, |faceting| {
            Profile::minkowski_sum(both, faceting)
        })
        .map(Self)
    }

    /// The profile scaled about the origin to a size along each axis, as `Solid.resized` does.
    ///
    /// >>> import stereotomy as st
    /// >>> st.rectangle([2, 1]).resized([6, 0], auto=(False, True)).area()
    /// 18.0
    #[pyo3(signature = (size, auto=(false, false)), text_signature = "($self, size, auto=(False, False))")]
    fn resized(&self, size: [f64; 2], auto: (bool, bool)) -> PyResult<Self> {
        let resized = self.0.resized(size, BVec2::new(auto.0, auto.1));
        resized.map(Self).map_err(of_model)
    }
}

/// The least convex solid around solids: exact of balls, of cylinders between two planes, of
/// flat faces, and mostly of what has parallel axes; what else is curved is taken for faces within a
/// share of its size.
///
/// >>> import math, stereotomy as st
/// >>> balls = [st.sphere(1), st.sphere(1).translate([2, 0, 0])]
/// >>> capsule = st.hull_of_solids(balls)
/// >>> abs(capsule.measure().volume - (4 / 3 + 2) * math.pi) < 1e-9
/// True
#[pyfunction]
#[pyo3(signature = (solids, *, within=1e-4))]
fn hull_of_solids(py: Python<'_>, solids: Vec<PySolid>, within: f64) -> PyResult<PySolid> {
    let solids: Vec<Solid> = solids.into_iter().map(|solid| solid.0).collect();
    made(py, within, |faceting| Solid::hull_of(&solids, faceting)).map(PySolid)
}

pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(hull_of_solids, module)?)
}
