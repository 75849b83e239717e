//! The connected parts of a mesh.

use super::star::usable;
use crate::mesh::Mesh;

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
        // (Vertices beyond the range of indices belong to no triangle.)
        let mut parents: Vec<u32> = (0..=u32::MAX).take(vertices).collect();
        for triangle in mesh.triangles.iter().filter(|t| usable(t, vertices)) {
            let [a, b, c] = triangle.map(|vertex| find(&mut parents, vertex));
            let root = a.min(b).min(c);
            for other in [a, b, c] {
                parents[other as usize] = root;
            }
        }
        let mut labels = vec![None; vertices];
        let mut count = 0;
        let of_triangles = mesh
            .triangles
            .iter()
            .map(|triangle| {
                usable(triangle, vertices).then(|| {
                    let root = find(&mut parents, triangle[0]);
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

/// The root of a vertex's tree, halving the path on the way.
pub(super) fn find(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        let grandparent = parents[parents[vertex as usize] as usize];
        parents[vertex as usize] = grandparent;
        vertex = grandparent;
    }
    vertex
}
