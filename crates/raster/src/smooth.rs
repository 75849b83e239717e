//! Normals kept with the vertices of clusters.
//!
//! A mesh gives a normal for every corner of every triangle. On smooth
//! surfaces the corners at a vertex share theirs; kept once with the cluster's
//! vertex it takes a fifth of the memory, which is what shading many small
//! triangles waits for.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use crate::cluster::{CLUSTER_VERTICES, Cluster, split};
use crate::scene::Scene;

/// Triangles for each entry of [`Scene::cluster_starts`].
const GROUP: usize = 32;
/// Clusters per parallel task.
const CHUNK: usize = 64;

impl Scene {
    /// Finds the clusters whose vertices have one normal each, and keeps
    /// these. O(triangles). Those that are not `seen` are passed over.
    pub(crate) fn gather_normals(&mut self, seen: impl Fn(&Cluster) -> bool + Sync) {
        self.cluster_starts.clear();
        for (index, cluster) in self.clusters.iter().enumerate() {
            let end = (cluster.first_triangle + cluster.triangles) as usize;
            while self.cluster_starts.len() * GROUP < end {
                self.cluster_starts.push(index as u32);
            }
        }
        let vertices = self.cluster_vertices[0].len();
        let mut axes = [(); 3].map(|()| vec![0f32; vertices]);
        let chunks = self.clusters.chunks(CHUNK);
        let padded = |chunk: &[Cluster]| chunk.iter().map(Cluster::padded_vertices).sum();
        let lengths: Vec<usize> = chunks.map(padded).collect();
        let [x, y, z] = axes
            .each_mut()
            .map(|axis| split(axis, lengths.iter().copied()));
        let (local, normals) = (&self.local[..], &self.normals[..]);
        self.clusters
            .par_chunks_mut(CHUNK)
            .zip(x)
            .zip(y)
            .zip(z)
            .for_each(|(((clusters, x), y), z)| {
                let mut at = 0;
                for cluster in clusters {
                    let own = at..at + cluster.padded_vertices();
                    at = own.end;
                    if !seen(cluster) {
                        continue;
                    }
                    let own = [&mut x[own.clone()], &mut y[own.clone()], &mut z[own]];
                    let first = cluster.first_triangle as usize;
                    let range = first..first + cluster.triangles as usize;
                    cluster.smooth = gather(&local[range.clone()], &normals[range], own);
                }
            });
        self.cluster_normals = axes;
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

/// Puts the normals of a cluster's corners to its vertices; returns whether
/// there is but one at each.
fn gather(local: &[[u8; 4]], normals: &[[Vec3; 3]], [x, y, z]: [&mut [f32]; 3]) -> bool {
    // No normal yet.
    x.fill(f32::NAN);
    let mut smooth = true;
    for (local, corner_normals) in local.iter().zip(normals) {
        for (&vertex, normal) in local.iter().zip(corner_normals) {
            let at = usize::from(vertex);
            // A cluster of triangles that are not drawn has no vertices.
            let Some(old) = x.get(at) else { continue };
            if old.is_nan() {
                (x[at], y[at], z[at]) = (normal.x, normal.y, normal.z);
            } else if [*old, y[at], z[at]] != normal.to_array() {
                smooth = false;
            }
        }
    }
    smooth
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
