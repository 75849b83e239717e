//! Silhouettes: edges between a triangle that faces the viewer and one that
//! turns away. Where they are seen they are exactly the outline of what is
//! drawn, up to the apex of a cone; how near that is to the outline of the
//! surface is for the mesh's tolerance to say.

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

/// The edges of the silhouette, as pairs of vertices.
pub(crate) fn silhouettes(scene: &Prepared, matrix: &FrameMatrix) -> Vec<[u32; 2]> {
    let faces: Vec<bool> = (0..scene.kept_triangles)
        .into_par_iter()
        .map(|index| {
            scene.corners(index).is_some_and(|[a, b, c]| {
                let viewer = matrix.viewer.truncate() - a * matrix.viewer.w;
                (b - a).cross(c - a).dot(viewer) > 0.0
            })
        })
        .collect();
    let edges = scene.shared_edges().iter();
    edges
        .filter(|edge| {
            let [one, other] = edge.triangles.map(|t| faces.get(t as usize));
            one != other
        })
        .map(|edge| edge.ends)
        .collect()
}

/// The edges that two triangles share, by their lesser ends and then by their
/// others. O(n).
pub(crate) fn find_shared_edges(scene: &Prepared) -> Vec<SharedEdge> {
    let kept = &scene.triangles[..scene.kept_triangles];
    let vertices = scene.positions.len();
    let sides = || {
        kept.iter().zip(0..).flat_map(|(&[a, b, c], index)| {
            let sides = [(a, b), (b, c), (c, a)];
            sides.map(|(i, j)| ([i.min(j), i.max(j)], index))
        })
    };
    let known = |ends: [u32; 2]| (ends[1] as usize) < vertices;
    // Where the edges of each lesser end begin, and the edges in that order.
    let mut ends = vec![0u32; vertices + 1];
    for (edge, _) in sides().filter(|side| known(side.0)) {
        ends[edge[0] as usize] += 1;
    }
    let mut sum = 0;
    for count in &mut ends {
        sum += std::mem::replace(count, sum);
    }
    let mut edges = vec![[0u32; 2]; sum as usize];
    for ([lesser, greater], triangle) in sides().filter(|side| known(side.0)) {
        let place = &mut ends[lesser as usize];
        edges[*place as usize] = [greater, triangle];
        *place += 1;
    }
    // (Now each is where those of its vertex end.)
    let mut shared = Vec::with_capacity(edges.len() / 2);
    let mut rest = &mut edges[..];
    let mut start = 0;
    for (&end, vertex) in ends.iter().zip(0..) {
        let own = rest.split_off_mut(..(end - start) as usize);
        start = end;
        let own = own.unwrap_or_default();
        own.sort_unstable();
        let groups = own.chunk_by(|a, b| a[0] == b[0]);
        shared.extend(groups.filter_map(|group| match *group {
            [[other, s], [_, t]] if vertex != other => Some(SharedEdge {
                ends: [vertex, other],
                triangles: [s, t],
            }),
            _ => None,
        }));
    }
    shared
}
