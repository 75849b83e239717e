//! The connected parts of a mesh.

use super::star::usable;
use crate::mesh::Mesh;
use crate::numeric::Groups;

/// The parts of a mesh that share no vertex.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Components {
    /// How many parts there are; lone vertices are none.
    pub count: usize,
    /// The part of each triangle, counted from 0 in the order of first
    /// appearance; `None` for a triangle with a repeated vertex or one that
    /// does not exist.
    pub of_triangles: Vec<Option<u32>>,
}

impl Components {
    /// Finds the parts of a mesh by union-find over its vertices (almost
    /// linear time).
    #[must_use]
    pub fn of(mesh: &Mesh) -> Self {
        let vertices = mesh.positions.len();
        let mut parts = Groups::new(vertices);
        for &[a, b, c] in mesh.triangles.iter().filter(|t| usable(t, vertices)) {
            parts.join([a, b]);
            parts.join([b, c]);
        }
        let mut labels = vec![None; vertices];
        let mut count = 0;
        let of_triangles = mesh
            .triangles
            .iter()
            .map(|triangle| {
                usable(triangle, vertices).then(|| {
                    let root = parts.first(triangle[0]);
                    *labels[root as usize].get_or_insert_with(|| {
                        count += 1;
                        count - 1
                    })
                })
            })
            .collect();
        Self {
            count: count as usize,
            of_triangles,
        }
    }
}

impl Mesh {
    /// The parts of the mesh that share no vertex.
    #[must_use]
    pub fn components(&self) -> Components {
        Components::of(self)
    }
}
