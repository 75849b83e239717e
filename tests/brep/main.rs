//! The exact boundary of solids, and measures from it, held against closed forms, identities
//! of measures, and the program itself.

mod models;
mod reference;
mod sound;
mod structure;
mod sums;

use csg::{BoundaryOptions, Brep, Program, Solid};
use stereotomy::csg;

/// The boundary of a solid.
fn boundary(solid: &Solid) -> Result<Brep, csg::Error> {
    Program::lower(solid)?.boundary(&BoundaryOptions::new())
}
