//! Solids as Boolean combinations of half-spaces.

mod adapt;
pub mod brep;
pub mod color;
mod control;
mod draft;
mod error;
mod evaluation;
mod finish;
mod limits;
mod machine;
pub mod mesh;
mod mesher;
mod numeric;
mod pages;
pub mod program;
#[cfg(test)]
mod random;
mod refine;
mod report;
mod section;
mod settling;
mod shapes;
pub mod solid;
mod surface;
mod surface_nets;
mod task;
mod undecided;
mod verify;

pub use brep::{BoundaryOptions, Brep};
pub use color::Color;
pub use control::CancelToken;
pub use error::{Error, NodeFault, NodePath, PathStep, PolyhedronFault, ProfileFault};
pub use glam;
pub use limits::{Demand, Limit, LimitReached, Limits};
pub use mesh::{LengthUnit, Mesh, MeshCheck, MeshDefect, MeshMeasure, MeshSurface};
pub use mesher::{MAX_CELLS, Meshed, Mesher};
pub use program::{Bounds, Program, Surface};
pub use report::{Fallback, Moved, PLACES_PER_FALLBACK, Report};
pub use shapes::{Gear, Screw};
pub use solid::profile::{FillRule, Join, Path, Profile, turn};
pub use solid::{Axis, Made, MeshFaults, Node, Plane, Primitive, Solid, Twist, shear_matrix};
pub use undecided::{Undecided, Why};
