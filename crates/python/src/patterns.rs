//! Copies of a solid in rows, grids, circles, along paths and helices.

use pyo3::prelude::*;

use crate::errors::call;
use crate::solid::{PySolid, checked};

#[pymethods]
impl PySolid {
    /// `count` copies, each moved by `step` against the one before.
    ///
    /// >>> import stereotomy as st
    /// >>> st.sphere(1).linear_pattern(3, step=[4, 0, 0]).contains([8, 0, 0])
    /// True
    fn linear_pattern(&self, count: usize, step: [f64; 3]) -> PyResult<Self> {
        let pattern = self.0.linear_pattern(count, step);
        checked(pattern, call!("linear_pattern", count, step))
    }

    /// Copies on a grid: so many along x, y and z, at these steps.
    ///
    /// >>> import stereotomy as st
    /// >>> st.sphere(1).grid_pattern([2, 3, 1], steps=[4, 4, 4]).mesh(tolerance=0.1).check().components
    /// 6
    fn grid_pattern(&self, counts: [usize; 3], steps: [f64; 3]) -> PyResult<Self> {
        let pattern = self.0.grid_pattern(counts, steps);
        checked(pattern, call!("grid_pattern", counts, steps))
    }

    /// `count` copies around the z axis, over a whole turn.
    ///
    /// >>> import stereotomy as st
    /// >>> st.cylinder(0.1, z=1).translate([1, 0, 0]).polar_pattern(4).contains([0, -1, 0.5])
    /// True
    fn polar_pattern(&self, count: usize) -> PyResult<Self> {
        checked(self.0.polar_pattern(count), call!("polar_pattern", count))
    }

    /// `count` copies at equal distances along a path of straight pieces, from its first
    /// point to its last, the solid's x axis along the way and its z axis as far up as that
    /// allows.
    ///
    /// >>> import stereotomy as st
    /// >>> st.sphere(1).path_pattern([[0, 0, 0], [8, 0, 0]], count=3).contains([4, 0, 0])
    /// True
    fn path_pattern(&self, path: Vec<[f64; 3]>, count: usize) -> PyResult<Self> {
        let pattern = self.0.path_pattern(path.iter().copied(), count);
        checked(pattern, call!("path_pattern", path, count))
    }

    /// `count` copies up a helix around the z axis, `per_turn` of them in a turn that rises
    /// by `pitch`.
    ///
    /// >>> import stereotomy as st
    /// >>> steps = st.cuboid([2, 1, 0.2]).translate([2, 0, 0]).helical_pattern(8, per_turn=8, pitch=4)
    /// >>> steps.contains([0, 2, 1])
    /// True
    fn helical_pattern(&self, count: usize, per_turn: f64, pitch: f64) -> PyResult<Self> {
        let pattern = self.0.helical_pattern(count, per_turn, pitch);
        checked(pattern, call!("helical_pattern", count, per_turn, pitch))
    }
}
