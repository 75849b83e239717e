//! The exact boundary representation of a solid.
//!
//! ```text
//!            Brep
//!             │
//!   Shell ── Face ── Loop ── Coedge ── Edge ── Vertex
//!             │               │         │
//!          Surface        one side    Curve
//! ```
//!
//! A **shell** is a connected part of the boundary: the outside of a body, or the wall of a
//! void in it. A **face** is a connected part of one surface, bounded by **loops** of
//! **coedges**: each is one side of an **edge** with the face on its left as seen from
//! outside. An edge is a piece of the curve in which two surfaces meet, from **vertex** to
//! vertex; an edge all around a closed curve has none. A face that closes on itself, as a
//! whole sphere does, has no loop.
//!
//! Faces of one surface that look alike are one face. Where a solid touches itself in an
//! edge or a point, that edge or vertex is there once for each of the parts: so the
//! boundary is a manifold, always.
//!
//! Inside, faces are cut along *seams* into patches, each of which is a graph in some
//! coordinates; integrals are taken over these.

mod bodies;
mod bounded;
mod bounds;
mod build;
mod chart;
mod curve;
mod data;
mod evaluate;
mod loops;
mod measure;
mod patches;
mod quadrature;
mod seams;
mod slits;
mod uncut;
mod view;

pub use self::bounded::Bounded;
pub use self::curve::{CurveShape, HalfAxes};
pub use self::data::{Brep, CoedgeId, EdgeId, FaceId, LoopId, ShellId, VertexId};
pub use self::evaluate::BoundaryOptions;
pub use self::measure::SolidMeasure;
pub use self::view::{Coedge, Edge, Face, Loop, Shell, Vertex};
