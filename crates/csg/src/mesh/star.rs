//! The star of every vertex: which triangles meet there, and their opposite
//! edges (together the vertex's link).

use crate::mesh::Mesh;

/// For every vertex the opposite edges of its triangles, in one flat array
/// (compressed rows, filled by a counting sort: linear time, two passes).
pub(super) struct Stars {
    /// Vertex `v` owns `links[starts[v]..starts[v + 1]]`.
    starts: Vec<usize>,
    /// For a triangle (v, next, previous) the pair `[next, previous]`.
    links: Vec<[u32; 2]>,
}

impl Stars {
    /// Gathers the stars of all triangles that are [`usable`].
    pub(super) fn new(mesh: &Mesh) -> Self {
        let vertices = mesh.positions.len();
        let mut starts = vec![0usize; vertices + 1];
        for triangle in mesh.triangles.iter().filter(|t| usable(t, vertices)) {
            for &vertex in triangle {
                starts[vertex as usize] += 1;
            }
        }
        // Exclusive prefix sums, shifted back by the filling pass below.
        let mut total = 0;
        for start in &mut starts {
            let count = *start;
            *start = total;
            total += count;
        }
        let mut links = vec![[0u32; 2]; total];
        for triangle in mesh.triangles.iter().filter(|t| usable(t, vertices)) {
            let [a, b, c] = *triangle;
            for (vertex, link) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                let slot = &mut starts[vertex as usize];
                links[*slot] = link;
                *slot += 1;
            }
        }
        // Every start now is its row's end: move them one row on.
        starts.copy_within(0..vertices, 1);
        starts[0] = 0;
        Self { starts, links }
    }

    /// The opposite edges of the triangles around `vertex`.
    pub(super) fn of(&self, vertex: usize) -> &[[u32; 2]] {
        &self.links[self.starts[vertex]..self.starts[vertex + 1]]
    }
}

/// Whether a triangle has three different vertices that all exist.
pub(super) fn usable(triangle: &[u32; 3], vertices: usize) -> bool {
    in_range(triangle, vertices) && !degenerate(triangle)
}

/// Whether all of a triangle's vertices exist.
pub(super) fn in_range(triangle: &[u32; 3], vertices: usize) -> bool {
    triangle.iter().all(|&vertex| (vertex as usize) < vertices)
}

/// Whether a triangle names a vertex twice.
pub(super) fn degenerate(&[a, b, c]: &[u32; 3]) -> bool {
    a == b || b == c || c == a
}
