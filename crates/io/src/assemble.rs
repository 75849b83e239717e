//! What readers build a mesh with.

use std::sync::Arc;

use csg::{Color, LengthUnit, Mesh, MeshSurface};
use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;

use crate::parts::{ColorBits, color_bits, in_gamut};
use crate::weld::Weld;

/// Collects vertices and triangles into a mesh.
pub(crate) struct Assembler {
    mesh: Mesh,
    welded: Weld,
    /// Surfaces by name and colour.
    parts: FxHashMap<(Option<Arc<str>>, Option<ColorBits>), u32>,
    part: u32,
    /// Whether every triangle so far came with normals.
    has_normals: bool,
}

impl Assembler {
    pub(crate) fn new(unit: LengthUnit) -> Self {
        Self {
            mesh: Mesh {
                unit,
                ..Mesh::default()
            },
            welded: Weld::default(),
            parts: FxHashMap::default(),
            part: 0,
            has_normals: true,
        }
    }

    /// Makes room for that many more vertices to weld and triangles. (What a
    /// file promises is no reason to reserve: pass what is really there.)
    pub(crate) fn reserve(&mut self, vertices: usize, triangles: usize) {
        let mesh = &mut self.mesh;
        self.welded
            .reserve(mesh.positions.len() + vertices, &mesh.positions);
        mesh.positions.reserve(vertices);
        mesh.triangles.reserve(triangles);
        mesh.triangle_surfaces.reserve(triangles);
    }

    /// The vertex at exactly this place; `None` if the place is not finite or
    /// there are too many vertices.
    pub(crate) fn weld(&mut self, place: DVec3) -> Option<u32> {
        if !place.is_finite() {
            return None;
        }
        // (The greatest number stands for no vertex.)
        let new = u32::try_from(self.mesh.positions.len()).ok()?;
        if new == u32::MAX {
            return None;
        }
        let vertex = self.welded.find_or_insert(place, new, &self.mesh.positions);
        if vertex == new {
            self.mesh.positions.push(place);
        }
        Some(vertex)
    }

    /// A new vertex, wherever others are; `None` as for `weld`.
    pub(crate) fn vertex(&mut self, place: DVec3) -> Option<u32> {
        let vertex = u32::try_from(self.mesh.positions.len()).ok()?;
        place.is_finite().then(|| {
            self.mesh.positions.push(place);
            vertex
        })
    }

    /// How many vertices there are.
    pub(crate) fn vertex_count(&self) -> usize {
        self.mesh.positions.len()
    }

    /// The triangles that follow have this name and colour.
    pub(crate) fn begin_part(&mut self, name: Option<&str>, color: Option<Color>) {
        let name: Option<Arc<str>> = name.map(Arc::from);
        let color = color.map(in_gamut);
        let bits = color.map(color_bits);
        let surfaces = &mut self.mesh.surfaces;
        self.part = *self
            .parts
            .entry((name, bits))
            .or_insert_with_key(|(name, _)| {
                let index = surfaces.len() as u32;
                surfaces.push(MeshSurface {
                    surface: index,
                    primitive: index,
                    name: name.clone(),
                    color,
                });
                index
            });
    }

    /// Adds a triangle to the current part, unless two of its vertices are one.
    pub(crate) fn triangle(&mut self, corners: [u32; 3], normals: Option<[Vec3; 3]>) {
        let [a, b, c] = corners;
        if a == b || b == c || c == a {
            return;
        }
        if self.mesh.surfaces.is_empty() {
            self.begin_part(None, None);
        }
        self.mesh.triangles.push(corners);
        self.mesh.triangle_surfaces.push(self.part);
        match normals {
            Some(normals) if self.has_normals => self.mesh.corner_normals.push(normals),
            _ => self.has_normals = false,
        }
    }

    /// The mesh: with normals if all triangles have them, with surfaces if
    /// any of them has a name or a colour.
    pub(crate) fn finish(self) -> Mesh {
        let mut mesh = self.mesh;
        if !self.has_normals {
            mesh.corner_normals.clear();
        }
        if mesh
            .surfaces
            .iter()
            .all(|s| s.name.is_none() && s.color.is_none())
        {
            mesh.surfaces.clear();
            mesh.triangle_surfaces.clear();
        }
        mesh
    }
}
