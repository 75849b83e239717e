//! The native part of the Python package `stereotomy`: the crates `csg`, `io`,
//! `raster` and `text` as Python sees them. No geometry is done here.

// `cargo test --lib` makes a test of it whatever the manifest says, which could not be
// linked (Python's symbols are those of the interpreter that loads it): an empty one can.
#![cfg(not(test))]
// What Python hands over is owned by whom it is handed to, and `self` of a class is
// a reference whether it is used or not.
#![allow(clippy::needless_pass_by_value, reason = "arguments from Python")]

mod arguments;
mod arrays;
mod bodies;
mod check;
mod corners;
mod errors;
mod files;
mod mesh;
mod meshing;
mod path;
mod patterns;
mod pickling;
mod picture;
mod primitives;
mod profile;
mod queries;
mod report;
mod shapes;
mod shards;
mod solid;
mod surface;
mod transform;
mod unit;
mod waiting;

use pyo3::prelude::*;

#[pymodule]
fn _stereotomy(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    errors::add_to(module)?;
    module.add_class::<solid::PySolid>()?;
    module.add_class::<profile::PyProfile>()?;
    module.add_class::<path::PyPath>()?;
    module.add_class::<mesh::PyMesh>()?;
    module.add_class::<surface::PySurface>()?;
    module.add_class::<queries::PyRayHit>()?;
    module.add_class::<queries::PyNearest>()?;
    module.add_class::<report::PyReport>()?;
    module.add_class::<report::PyFallback>()?;
    module.add_class::<report::PyMoved>()?;
    module.add_class::<check::PyCheck>()?;
    module.add_class::<check::PyMeasure>()?;
    module.add_class::<picture::PyPicture>()?;
    module.add_class::<picture::PyAnimation>()?;
    primitives::add_to(module)?;
    bodies::add_to(module)?;
    corners::add_to(module)?;
    shapes::add_to(module)?;
    files::add_to(module)?;
    shards::add_to(module)?;
    pickling::add_to(module)
}
