//! Normals kept with the vertices of clusters.
//!
//! A mesh gives a normal for every corner of every triangle. On smooth
//! surfaces the corners at a vertex share theirs; kept once with the cluster's
//! vertex it takes a fifth of the memory, which is what shading many small
//! triangles waits for.

use std::ops::Range;

use crate::scene::{CLUSTER_VERTICES, Scene};

/// Triangles for each entry of [`Scene::cluster_starts`].
const GROUP: usize = 32;

impl Scene {
    /// Finds the clusters whose vertices have one normal each, and keeps
    /// these. O(triangles).
    pub(crate) fn gather_normals(&mut self) {
        for axis in &mut self.cluster_vertices {
            // So that every cluster's part can be taken for a full one.
            axis.resize(axis.len() + CLUSTER_VERTICES, 0.0);
        }
        let vertices = self.cluster_vertices[0].len();
        let mut normals = [(); 3].map(|()| vec![f32::NAN; vertices]);
        self.cluster_starts.clear();
        for (index, cluster) in self.clusters.iter_mut().enumerate() {
            let first = cluster.first_triangle as usize;
            let end = first + cluster.triangles as usize;
            while self.cluster_starts.len() * GROUP < end {
                self.cluster_starts.push(index as u32);
            }
            let corners = self.local[first..end].iter().zip(&self.normals[first..end]);
            let [x, y, z] = &mut normals;
            cluster.smooth = true;
            for (local, corner_normals) in corners {
                for (vertex, normal) in local.iter().zip(corner_normals) {
                    let at = cluster.first_vertex as usize + usize::from(*vertex);
                    let Some(old) = x.get(at) else { continue };
                    if old.is_nan() {
                        (x[at], y[at], z[at]) = (normal.x, normal.y, normal.z);
                    } else if [*old, y[at], z[at]] != normal.to_array() {
                        cluster.smooth = false;
                    }
                }
            }
        }
        self.cluster_normals = normals;
    }

    /// The cluster that a triangle is in.
    pub(crate) fn cluster_view(&self, triangle: usize) -> Option<ClusterView<'_>> {
        let start = *self.cluster_starts.get(triangle / GROUP)? as usize;
        let mut later = self.clusters.get(start..)?.iter();
        let cluster = later.find(|c| triangle < (c.first_triangle + c.triangles) as usize)?;
        let first = cluster.first_vertex as usize;

        let [px, py, pz] = &self.cluster_vertices;
        let [nx, ny, nz] = &self.cluster_normals;
        let end = (cluster.first_triangle + cluster.triangles) as usize;
        Some(ClusterView {
            triangles: cluster.first_triangle as usize..end,
            smooth: cluster.smooth,
            positions: [part(px, first)?, part(py, first)?, part(pz, first)?],
            normals: [part(nx, first)?, part(ny, first)?, part(nz, first)?],
        })
    }
}

fn part(axis: &[f32], first: usize) -> Option<&[f32; CLUSTER_VERTICES]> {
    axis.get(first..)?.first_chunk()
}

/// What shading needs of a cluster.
pub(crate) struct ClusterView<'a> {
    pub triangles: Range<usize>,
    pub smooth: bool,
    /// x, y and z of its vertices, and of others after them.
    pub positions: [&'a [f32; CLUSTER_VERTICES]; 3],
    /// The same of their normals, where they have one each.
    pub normals: [&'a [f32; CLUSTER_VERTICES]; 3],
}
