//! Primitives in place.

use glam::DVec3;
use smallvec::SmallVec;

use crate::solid::Plane;
use crate::solid::partition::{Facet, Part};
use crate::surface::{Bounds, Surface};

/// A closed polyhedron of many faces in place.
#[derive(Debug)]
pub(super) struct Region {
    pub vertices: Vec<DVec3>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Of each triangle the surface, and whether that looks the other way.
    pub surfaces: Vec<(u32, bool)>,
    /// The primitive that it is.
    pub origin: u32,
}

impl Region {
    pub fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|vertex| self.vertices[vertex as usize])
    }

    /// The triangles on the planes of their surfaces.
    pub fn facets(&self, surfaces: &[Surface]) -> Vec<Facet> {
        let facet = |(&triangle, &(id, flipped)): (&[u32; 3], &(u32, bool))| {
            let plane = &surfaces[id as usize];
            let normal = if flipped { -plane.linear } else { plane.linear };
            Facet {
                face: 2 * id + u32::from(flipped),
                plane: Plane::through(plane.anchor, normal),
                corners: self.corners(triangle).into(),
            }
        };
        self.triangles
            .iter()
            .zip(&self.surfaces)
            .map(facet)
            .collect()
    }
}

/// A primitive that is the intersection of half-spaces.
#[derive(Debug)]
pub(super) struct Convex {
    /// Surfaces, and whether what is before them is meant.
    pub half_spaces: SmallVec<[(u32, bool); 6]>,
    /// A box around it.
    pub bounds: Bounds,
}

/// What is known once all primitives were put in place.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    pub surfaces: &'a [Surface],
    pub regions: &'a [Region],
    /// The others, in the order in which they are met.
    pub others: &'a [Convex],
}

/// What is done about polyhedra of many faces.
pub(super) enum Polyhedra<'a> {
    /// They are put in place, and are not in the formula.
    Met(Vec<Region>),
    /// Each is a literal, of a surface behind all others.
    Outlined(Placed<'a>),
    /// Their formulas are written; outside of boxes in which faces are not needed, if there
    /// are such.
    Written(Placed<'a>, Option<IsNeeded<'a>>),
}

impl<'a> Polyhedra<'a> {
    /// What is known of all primitives.
    pub const fn placed(&self) -> Option<Placed<'a>> {
        match self {
            Self::Met(_) => None,
            Self::Outlined(placed) | Self::Written(placed, _) => Some(*placed),
        }
    }
}

/// Whether the faces of a polyhedron, by its number, are needed in a box that has parts of
/// them.
pub(super) type IsNeeded<'a> = &'a (dyn Fn(u32, &[Part], [DVec3; 2]) -> bool + Sync);
