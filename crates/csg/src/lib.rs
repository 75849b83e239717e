//! Solids as Boolean combinations of half-spaces.

pub mod color;
mod error;
pub mod mesh;
pub mod program;
pub mod solid;

pub use color::Color;
pub use error::{Error, NodeFault, NodePath, PathStep};
pub use glam;
pub use mesh::{LengthUnit, Mesh, MeshCheck, MeshDefect, MeshMeasure, MeshSurface};
pub use program::{Bounds, Program, Surface};
pub use solid::{Axis, Node, Plane, Primitive, Solid};
