//! What the ways of meshing are handed.

use std::sync::Arc;

use glam::DVec3;

use crate::control::Control;
use crate::mesh::MeshSurface;
use crate::program::{Bounds, Program, Surface, SurfaceId};

/// What there is to mesh. All geometry is relative to `origin`, the middle
/// of the solid's bounds, so that a model far away loses no digits.
pub(crate) struct Task<'a> {
    pub(crate) program: &'a Program,
    /// The program's surfaces about `origin`.
    pub(crate) surfaces: Vec<Surface>,
    pub(crate) origin: DVec3,
    /// The lengths of the sides of the bounds.
    pub(crate) size: DVec3,
    /// Side of a cell.
    pub(crate) cell: f64,
    pub(crate) control: &'a Control,
}

impl<'a> Task<'a> {
    pub(crate) fn new(
        program: &'a Program,
        bounds: Bounds,
        cell: f64,
        control: &'a Control,
    ) -> Self {
        let origin = bounds.center();
        Self {
            program,
            surfaces: program.surfaces_about(origin),
            origin,
            size: bounds.size(),
            cell,
            control,
        }
    }

    /// The solid's bounds.
    pub(crate) fn bounds(&self) -> Bounds {
        Bounds {
            min: self.origin - 0.5 * self.size,
            max: self.origin + 0.5 * self.size,
        }
    }

    /// The same under another control.
    pub(crate) fn with<'b>(&self, control: &'b Control) -> Task<'b>
    where
        'a: 'b,
    {
        Task {
            program: self.program,
            surfaces: self.surfaces.clone(),
            origin: self.origin,
            size: self.size,
            cell: self.cell,
            control,
        }
    }

    /// The entry of triangles on a surface of a primitive.
    pub(crate) fn mesh_surface(&self, surface: SurfaceId, primitive: u32) -> MeshSurface {
        mesh_surface(self.program, surface, primitive)
    }
}

/// The entry of triangles on a surface of a program's primitive.
pub(crate) fn mesh_surface(program: &Program, surface: SurfaceId, primitive: u32) -> MeshSurface {
    let origin = &program.origins()[primitive as usize];
    MeshSurface {
        surface: surface.0,
        primitive,
        body: origin.body,
        name: origin.name.as_ref().map(Arc::clone),
        parts: Arc::clone(&origin.parts),
        color: origin.color,
    }
}
