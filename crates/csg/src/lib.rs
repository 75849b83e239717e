//! Solids as Boolean combinations of half-spaces.

pub mod color;
pub mod mesh;

pub use color::Color;
pub use mesh::{LengthUnit, Mesh, MeshSurface};
