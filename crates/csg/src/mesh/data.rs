//! The mesh itself.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::color::Color;

/// The unit of a model's lengths. Formats that fix a unit of their own
/// (glTF: metres) are converted into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum LengthUnit {
    /// 1e-6 m.
    Micrometre,
    /// 1e-3 m, the default.
    #[default]
    Millimetre,
    /// 1e-2 m.
    Centimetre,
    /// 1 m.
    Metre,
    /// 0.0254 m.
    Inch,
    /// 0.3048 m.
    Foot,
}

impl LengthUnit {
    /// How many metres one unit is.
    #[must_use]
    pub const fn in_metres(self) -> f64 {
        match self {
            Self::Micrometre => 1e-6,
            Self::Millimetre => 1e-3,
            Self::Centimetre => 1e-2,
            Self::Metre => 1.0,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
        }
    }

    /// How it is written: µm, mm, cm, m, in or ft.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Micrometre => "µm",
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
            Self::Foot => "ft",
        }
    }
}

/// Where triangles come from: one surface of one primitive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshSurface {
    /// Index of the surface in the program that was meshed.
    pub surface: u32,
    /// Index of the primitive in the program that was meshed.
    pub primitive: u32,
    /// The number, from 1, of the extrusion, revolution, hull or other body that was made of
    /// primitives and that this one is part of, the outermost; 0 of others. Surfaces of one body
    /// that hardly turn where they meet are facets of one.
    pub body: u32,
    /// The innermost name around the primitive, if any.
    pub name: Option<Arc<str>>,
    /// The names around that one, the outermost first.
    pub parts: Arc<[Arc<str>]>,
    /// The innermost colour around the primitive, if any.
    pub color: Option<Color>,
}

/// A triangle mesh, Z up, right-handed; triangles are counter-clockwise seen
/// from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions, in [`Mesh::unit`].
    pub positions: Vec<DVec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle its index into [`Mesh::surfaces`]. Empty, or as long
    /// as [`Mesh::triangles`].
    pub triangle_surfaces: Vec<u32>,
    /// What the triangles' surfaces are.
    pub surfaces: Vec<MeshSurface>,
    /// Outward unit normals at the three corners of each triangle (the
    /// gradient of the triangle's own surface there). Empty where nobody
    /// computed them, or as long as [`Mesh::triangles`].
    pub corner_normals: Vec<[Vec3; 3]>,
    /// Feature edges as polylines of vertex indices; a closed one ends with
    /// its first vertex. Empty where nobody computed them.
    pub feature_edges: Vec<Vec<u32>>,
    /// The unit of the positions.
    pub unit: LengthUnit,
}

impl Mesh {
    /// A bare mesh from positions and triangles.
    #[must_use]
    pub fn new(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        Self {
            positions,
            triangles,
            ..Self::default()
        }
    }

    /// The three corners of triangle `index`.
    ///
    /// # Panics
    /// If `index` is out of range, or the triangle names a vertex that is.
    #[must_use]
    pub fn corners(&self, index: usize) -> [DVec3; 3] {
        self.triangles[index].map(|vertex| self.positions[vertex as usize])
    }

    /// The surface entry of triangle `index`, if the mesh carries provenance.
    #[must_use]
    pub fn surface_of(&self, index: usize) -> Option<&MeshSurface> {
        let surface = *self.triangle_surfaces.get(index)?;
        self.surfaces.get(surface as usize)
    }

    /// The smallest axis-aligned box around all vertices, as its least and
    /// greatest corner; `None` for a mesh without vertices.
    #[must_use]
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.positions.first()?;
        Some(
            self.positions
                .iter()
                .fold((first, first), |(low, high), &p| (low.min(p), high.max(p))),
        )
    }
}
