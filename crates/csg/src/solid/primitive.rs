//! What a leaf of the tree is.

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// The half-space `normal · p <= offset`; `normal` points out of it and need
/// not have unit length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// Outward normal, of any positive length.
    pub normal: DVec3,
    /// Offset along `normal`, in units of its length: for a unit normal the
    /// signed distance of the plane from the origin.
    pub offset: f64,
}

impl Plane {
    /// The plane through `point` with the given outward normal.
    #[must_use]
    pub fn through(point: impl Into<DVec3>, normal: impl Into<DVec3>) -> Self {
        let normal = normal.into();
        Self {
            normal,
            offset: normal.dot(point.into()),
        }
    }
}

/// A leaf of a solid's tree, in its own coordinates: axes along z, centres at
/// the origin, moved into place by the transforms above it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Primitive {
    /// No point.
    Empty,
    /// Every point.
    Space,
    /// One side of a plane.
    HalfSpace {
        /// A point on the plane.
        point: DVec3,
        /// Outward normal, of any positive length.
        normal: DVec3,
    },
    /// f(p) <= 0 for f = c0 x² + c1 y² + c2 z² + c3 xy + c4 yz + c5 zx
    /// + c6 x + c7 y + c8 z + c9.
    Quadric([f64; 10]),
    /// An axis-aligned box.
    Cuboid {
        /// Least corner.
        min: DVec3,
        /// Greatest corner.
        max: DVec3,
    },
    /// (x/rx)² + (y/ry)² + (z/rz)² <= 1.
    Ellipsoid {
        /// Semi-axes; all equal for a sphere.
        radii: DVec3,
    },
    /// A right elliptic cylinder along z.
    Cylinder {
        /// Semi-axes across; equal for a circular cylinder.
        radii: DVec2,
        /// Extent along z; `None` for an infinite cylinder.
        z: Option<Range<f64>>,
    },
    /// A right circular frustum along z; a cone where one radius is 0.
    Frustum {
        /// Radius at the lower end, at least 0.
        bottom: f64,
        /// Radius at the upper end, at least 0; not both radii are 0.
        top: f64,
        /// Extent along z.
        z: Range<f64>,
    },
    /// The upper nappe x² + y² <= (slope z)², z >= 0: apex at the origin.
    InfiniteCone {
        /// Radius per height, the tangent of the half-angle.
        slope: f64,
    },
    /// z >= (x/a)² + (y/b)².
    Paraboloid {
        /// a and b.
        scales: DVec2,
    },
    /// (x/a)² + (y/b)² - (z/c)² <= 1: around the z axis, connected.
    HyperboloidOneSheet {
        /// a, b and c.
        radii: DVec3,
    },
    /// (z/c)² - (x/a)² - (y/b)² >= 1: the two bowls around the z axis.
    HyperboloidTwoSheets {
        /// a, b and c.
        radii: DVec3,
    },
    /// The intersection of the half-spaces of some planes.
    ConvexPolyhedron(Arc<[Plane]>),
    /// A right prism along z over a convex polygon.
    Prism {
        /// Corners in order, either way round.
        polygon: Arc<[DVec2]>,
        /// Extent along z.
        z: Range<f64>,
    },
    /// What a closed surface of many flat faces bounds.
    Polyhedron(Arc<Polyhedron>),
}

/// A closed surface of triangles, the faces that these make up, and their planes: made by
/// [`Solid::polyhedron`](crate::Solid::polyhedron), which checks it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Polyhedron {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Of each triangle.
    pub(crate) faces: Vec<u32>,
    /// Of each face, with unit normals.
    pub(crate) planes: Vec<Plane>,
}

impl Polyhedron {
    /// The corners of triangles.
    #[must_use]
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Triangles, counter-clockwise seen from outside.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
}

impl Primitive {
    /// The primitive's kind, in the words of the authoring functions.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Empty => "empty",
            Self::Space => "space",
            Self::HalfSpace { .. } => "half_space",
            Self::Quadric(_) => "quadric",
            Self::Cuboid { .. } => "cuboid",
            Self::Ellipsoid { radii } if same(radii.x, radii.y) && same(radii.y, radii.z) => {
                "sphere"
            }
            Self::Ellipsoid { .. } => "ellipsoid",
            Self::Cylinder { radii, z } => match (same(radii.x, radii.y), z.is_some()) {
                (true, true) => "cylinder",
                (true, false) => "infinite_cylinder",
                (false, true) => "elliptic_cylinder",
                (false, false) => "infinite_elliptic_cylinder",
            },
            Self::Frustum { top, .. } if *top == 0.0 => "cone",
            Self::Frustum { .. } => "frustum",
            Self::InfiniteCone { .. } => "infinite_cone",
            Self::Paraboloid { .. } => "paraboloid",
            Self::HyperboloidOneSheet { .. } => "hyperboloid_one_sheet",
            Self::HyperboloidTwoSheets { .. } => "hyperboloid_two_sheets",
            Self::ConvexPolyhedron(_) => "convex_polyhedron",
            Self::Prism { .. } => "prism",
            Self::Polyhedron(_) => "polyhedron",
        }
    }
}

/// Whether two sizes are one, NaN included: a sphere of NaN is a sphere.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}
