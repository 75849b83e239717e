//! Volumes of solids by their exact boundaries, for several test files.

use csg::brep::Bounded;
use csg::{BoundaryOptions, Program, Solid};

#[track_caller]
pub fn measured(what: &str, solid: &Solid) -> Bounded {
    let program = Program::lower(solid).unwrap_or_else(|e| panic!("{what}: {e}"));
    let boundary = program.boundary(&BoundaryOptions::new());
    let boundary = boundary.unwrap_or_else(|e| panic!("{what}: {e}"));
    boundary.measure().volume
}
