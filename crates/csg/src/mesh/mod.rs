//! Triangle meshes with provenance: what every later stage reads.
//!
//! Nothing here knows about solids; `raster` and `io` need only this module.

mod apart;
pub(crate) mod box_tree;
#[cfg(test)]
pub(crate) mod boxes;
mod check;
mod components;
mod contour;
mod data;
mod distance;
mod flat;
mod intersect;
mod intersections;
mod measure;
mod nearest;
mod nesting;
pub(crate) mod predicates;
mod sheets;
pub(crate) mod shells;
mod star;
pub(crate) mod triangulate;
mod twins;

pub use check::{DefectPlace, MeshCheck, MeshDefect, PLACES_PER_DEFECT};
pub use components::Components;
pub use data::{LengthUnit, Mesh, MeshSurface};
pub use distance::MeshDistance;
pub(crate) use intersections::Intersections;
pub use measure::MeshMeasure;
pub use nearest::MeshNearest;
pub(crate) use predicates::flat;
pub(crate) use shells::Shells;
