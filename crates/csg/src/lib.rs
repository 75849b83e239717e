//! Solids as Boolean combinations of half-spaces, and what is made of them: exact boundaries,
//! measures and meshes.
//!
//! ```
//! use csg::{BoundaryOptions, Mesher, Program, Solid};
//!
//! // Author: a solid is an immutable tree, put together by operators. Lengths are in a unit of
//! // your own, Z is up.
//! let plate = Solid::cuboid([40.0, 20.0, 5.0]).named("plate");
//! let hole = Solid::cylinder(3.0, -10.0..10.0).named("hole");
//! let holes = hole.translate([-12.0, 0.0, 0.0]) | hole.translate([12.0, 0.0, 0.0]);
//! let part = plate - holes;
//!
//! // Lower: distinct surfaces and one Boolean formula over the half-spaces that they bound.
//! // Mistakes in the tree are found here, with the way to the node.
//! let program = Program::lower(&part)?;
//! assert!(program.contains([0.0, 0.0, 0.0]) && !program.contains([12.0, 0.0, 0.0]));
//!
//! // Boundary: faces on the surfaces, edges on their curves, exactly.
//! let boundary = program.boundary(&BoundaryOptions::new())?;
//! assert_eq!((boundary.faces().len(), boundary.edges().len()), (8, 16));
//!
//! // Measure: volume, area, centroid and moments, with bounds.
//! let volume = boundary.measure().volume;
//! let exact = 4000.0 - 2.0 * 45.0 * std::f64::consts::PI;
//! assert!((volume.value - exact).abs() <= volume.error && volume.error < 1e-8);
//!
//! // Mesh: triangles that deviate by no more than a tolerance, proven.
//! let meshed = Mesher::new().tolerance(0.01).mesh(&program)?;
//! assert!(meshed.report.is_proven() && meshed.report.deviation <= Some(0.01));
//! assert!(meshed.report.check.is_manifold());
//! assert!((meshed.mesh.volume() - exact).abs() < 2.0);
//!
//! // Every triangle knows the primitive that it comes from.
//! let names: Vec<_> = meshed.mesh.surfaces.iter().filter_map(|s| s.name.as_deref()).collect();
//! assert!(names.contains(&"plate") && names.contains(&"hole"));
//! # Ok::<(), csg::Error>(())
//! ```
//!
//! What could not be done is in the report ([`Report`]) or an [`Error`] that says where and how to
//! mend it; nothing is silently wrong. `ARCHITECTURE.md` in the repository tells how it works, [`theory`] why it is
//! right.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod adapt;
mod arrangement;
pub mod brep;
mod clock;
pub mod color;
mod control;
pub mod corners;
mod draft;
pub mod elementary;
mod error;
mod finish;
mod limits;
mod machine;
mod merger;
pub mod mesh;
mod mesher;
mod numeric;
mod pages;
pub mod program;
mod query;
#[cfg(test)]
mod random;
mod report;
mod section;
mod settling;
mod shapes;
pub mod solid;
mod surface;
mod surface_nets;
#[cfg(test)]
#[path = "../../../tests/sweeps.rs"]
mod sweeps;
mod task;
mod tessellate;
pub mod theory;
mod undecided;
mod verify;

pub use brep::{BoundaryOptions, Brep};
pub use color::Color;
pub use control::CancelToken;
pub use error::{Error, NodeFault, NodePath, PathStep, PolyhedronFault, ProfileFault};
pub use glam;
pub use limits::{Demand, Limit, LimitReached, Limits};
pub use merger::{MergedTriangles, Merger};
pub use mesh::{
    LengthUnit, Mesh, MeshCheck, MeshDefect, MeshDistance, MeshMeasure, MeshNearest, MeshSurface,
};
pub use mesher::{MAX_CELLS, Meshed, Mesher};
pub use numeric::stretch;
pub use program::{Bounds, Placement, Program, Surface, SurfaceShape};
pub use query::{Nearest, RayHit};
pub use report::{Fallback, Moved, PLACES_PER_FALLBACK, Report};
pub use shapes::{Gear, Screw};
pub use solid::profile::{FillRule, Join, Path, Profile, turn};
pub use solid::{
    Axis, Made, MeshFaults, Node, Plane, Polyhedron, Primitive, Repairs, Solid, Twist,
    TwistAccuracy, shear_matrix,
};
pub use surface_nets::slab::{Slab, SlabBody, SlabHead, SlabSource};
pub use undecided::{Undecided, Why};
