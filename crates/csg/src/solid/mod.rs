//! Authoring: what a user builds.
//!
//! A [`Solid`] is an immutable, cheaply shared tree of primitives, Boolean
//! operations and transforms. Building never fails; whatever is wrong with a
//! node is found, with its place in the tree, when the solid is lowered
//! ([`crate::Program::lower`]).

mod extrude;
mod from_mesh;
mod hull;
mod hull_of_discs;
pub(crate) mod partition;
pub(crate) mod polyhedron;
mod primitive;
mod primitives;
pub(crate) mod profile;
mod repair;
mod revolve;
mod round_cones;
mod rounded;
mod transform;
mod tree;
mod twist;

pub use crate::error::PolyhedronFault;
pub use from_mesh::MeshFaults;
pub use primitive::{Plane, Polyhedron, Primitive};
pub use repair::Repairs;
pub use transform::{Axis, shear_matrix};
pub use tree::{Made, Node, Solid};
pub use twist::{Twist, TwistAccuracy};
