//! Boxes as meshes, for tests.

use glam::DVec3;

use crate::mesh::Mesh;

/// A box as eight vertices and twelve triangles, each face cut in two.
pub(crate) fn cuboid(low: DVec3, high: DVec3) -> Mesh {
    let corner = |k: u32| DVec3::select([1, 2, 4].map(|bit| k & bit != 0).into(), high, low);
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = faces.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Mesh::new((0..8).map(corner).collect(), triangles.concat())
}
