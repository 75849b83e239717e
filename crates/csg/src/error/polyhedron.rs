//! What is wrong with polyhedra.

use glam::DVec3;

/// What is wrong with the faces of a polyhedron.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PolyhedronFault {
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} is not finite: give ordinary numbers")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {vertex}, but there are only {vertices}")]
    NoSuchVertex {
        /// Index of the face.
        face: usize,
        /// What it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// An edge that only one face has, or faces that run the same way along it.
    #[error(
        "the surface is not closed: the edge of face {face} from ({:.6}, {:.6}, {:.6}) to ({:.6}, {:.6}, {:.6}) has no face on its other side, or one that runs the same way",
        .edge[0].x, .edge[0].y, .edge[0].z, .edge[1].x, .edge[1].y, .edge[1].z
    )]
    Open {
        /// Index of the face.
        face: usize,
        /// The ends of the edge.
        edge: [DVec3; 2],
    },
    /// The faces look inwards.
    #[error(
        "the faces are inside out: list the corners of every face counter-clockwise seen from outside"
    )]
    InsideOut,
    /// A shell of faces that looks the same way as the one that it lies in, or inwards beside
    /// others.
    #[error(
        "the shell of face {face} at about ({:.6}, {:.6}, {:.6}) looks the same way as the one that it lies in, or inwards beside others: turn its faces round if it is a hollow, leave it out if not",
        .place.x, .place.y, .place.z
    )]
    Misplaced {
        /// Index of a face of it.
        face: usize,
        /// A corner of the face.
        place: DVec3,
    },
    /// No volume.
    #[error("the faces enclose nothing")]
    Degenerate,
    /// Faces run through each other or overlap.
    #[error("faces {} and {} run through each other at about ({:.6}, {:.6}, {:.6})", .faces[0], .faces[1], .place.x, .place.y, .place.z)]
    Crossing {
        /// Indices of the faces.
        faces: [usize; 2],
        /// A corner of one of them.
        place: DVec3,
    },
    /// More faces than there is memory for, or, of parts, time.
    #[error(
        "{faces} faces: at most {limit} can be made into a solid, or into convex parts; give a simpler mesh"
    )]
    TooManyFaces {
        /// How many there are.
        faces: usize,
        /// The most there may be.
        limit: usize,
    },
}
