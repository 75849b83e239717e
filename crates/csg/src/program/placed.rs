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
    pub fn facets(&self, surface: impl Fn(u32) -> Surface) -> Vec<Facet> {
        let facet = |(&triangle, &(id, flipped)): (&[u32; 3], &(u32, bool))| {
            let plane = surface(id);
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

/// What is done about polyhedra of many faces.
pub(super) enum Polyhedra<'a> {
    /// They are put in place, and are not in the formula.
    Met(Vec<Region>),
    /// Each is a literal. So many surfaces are there besides: theirs come behind.
    Outlined(u32),
    /// Their formulas are written; outside of boxes in which faces are not needed, if there
    /// are such.
    Written(&'a [Region], Option<IsNeeded<'a>>),
}

/// Whether the faces of a polyhedron, by its number, are needed in a box that has parts of
/// them.
pub(super) type IsNeeded<'a> = &'a (dyn Fn(u32, &[Part], [DVec3; 2]) -> bool + Sync);
