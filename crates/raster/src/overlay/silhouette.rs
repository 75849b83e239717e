//! Silhouettes: edges between a triangle that faces the viewer and one that
//! turns away. Where they are seen they are exactly the outline of what is
//! drawn, up to the apex of a cone; how near that is to the outline of the
//! surface is for the mesh's tolerance to say.

use glam::DVec3;
use rayon::prelude::*;

use crate::frame::FrameMatrix;
use crate::prepared::Prepared;

/// An edge, and the triangles on both of its sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct SharedEdge {
    /// Its vertices, the lesser first.
    pub ends: [u32; 2],
    pub triangles: [u32; 2],
}

/// Calls `segment` for each edge of the silhouette.
pub(crate) fn draw_silhouettes(
    scene: &Prepared,
    matrix: &FrameMatrix,
    mut segment: impl FnMut(DVec3, DVec3),
) {
    let faces: Vec<bool> = (0..scene.kept_triangles)
        .into_par_iter()
        .map(|index| {
            scene.corners(index).is_some_and(|[a, b, c]| {
                let viewer = matrix.viewer.truncate() - a * matrix.viewer.w;
                (b - a).cross(c - a).dot(viewer) > 0.0
            })
        })
        .collect();
    for edge in scene.shared_edges() {
        let [one, other] = edge.triangles.map(|t| faces.get(t as usize));
        if one != other
            && let (Some(a), Some(b)) = (scene.position(edge.ends[0]), scene.position(edge.ends[1]))
        {
            segment(a, b);
        }
    }
}

/// The edges that two triangles share. O(n log n).
pub(crate) fn find_shared_edges(scene: &Prepared) -> Vec<SharedEdge> {
    let mut edges: Vec<[u32; 3]> = scene.triangles[..scene.kept_triangles]
        .par_iter()
        .enumerate()
        .flat_map_iter(|(index, &[a, b, c])| {
            let sides = [(a, b), (b, c), (c, a)];
            sides.map(|(i, j)| [i.min(j), i.max(j), index as u32])
        })
        .collect();
    edges.par_sort_unstable();
    edges
        .chunk_by(|a, b| a[..2] == b[..2])
        .filter_map(|group| match *group {
            [[a, b, s], [_, _, t]] if a != b => Some(SharedEdge {
                ends: [a, b],
                triangles: [s, t],
            }),
            _ => None,
        })
        .collect()
}
