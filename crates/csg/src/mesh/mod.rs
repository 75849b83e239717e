//! Triangle meshes with provenance: what every later stage reads.
//!
//! Nothing here knows about solids; `raster` and `io` need only this module.

mod data;

pub use data::{LengthUnit, Mesh, MeshSurface};
