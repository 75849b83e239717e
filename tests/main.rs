//! All tests of several crates at once but those that count memory, as one program: the
//! heavy ones that wait for other programs run beside each other.
#![allow(missing_docs, reason = "a test")]

#[path = "brep/main.rs"]
mod brep;
#[path = "contacts/main.rs"]
mod contacts;
mod corpus;
#[path = "manifold3d/python.rs"]
mod environment;
mod every_file;
mod exchange;
mod fuzzing;
mod judge;
mod manifold3d;
#[path = "meshing/main.rs"]
mod meshing;
mod models;
mod python;
#[path = "meshing/random.rs"]
mod random;
mod step;
mod sweeps;

// Where the fuzz targets look for them.
use stereotomy::{csg, io, raster};

/// The first of all tests by name, which is the order in which they run.
mod a_python_package {
    #[test]
    fn tests_begin() {
        crate::python::begin();
    }
}

/// The last.
mod z_python_package {
    #[test]
    fn passes_its_tests() {
        crate::python::end();
    }
}

/// The folder of the workspace.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

#[test]
fn every_file_is_a_module() {
    every_file::is_a_module(env!("CARGO_MANIFEST_DIR"), include_str!("main.rs"));
}
