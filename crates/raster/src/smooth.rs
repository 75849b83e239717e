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
        // (Zeros from the system, which the threads touch first.)
        let mut all: Vec<[f32; 4]> = bytemuck::zeroed_vec(self.cluster_vertices.len());
        let chunks = self.clusters.chunks(CHUNK);
        let padded = |chunk: &[Cluster]| chunk.iter().map(Cluster::padded_vertices).sum();
        let lengths: Vec<usize> = chunks.map(padded).collect();
        let parts = split(&mut all, lengths.into_iter());
        let (local, normals) = (&self.local[..], &self.normals[..]);
        self.clusters
            .par_chunks_mut(CHUNK)
            .zip(parts)
            .for_each(|(clusters, part)| {
                let mut at = 0;
                for cluster in clusters {
                    let own = at..at + cluster.padded_vertices();
                    at = own.end;
                    if !seen(cluster) {
                        continue;
                    }
                    let first = cluster.first_triangle as usize;
                    let range = first..first + cluster.triangles as usize;
                    cluster.smooth = gather(&local[range.clone()], &normals[range], &mut part[own]);
                }
            });
        self.cluster_normals = all;
    }

    /// The cluster that a triangle is in.
    pub(crate) fn cluster_view(&self, triangle: usize) -> Option<ClusterView<'_>> {
        let start = *self.cluster_starts.get(triangle / GROUP)? as usize;
        let mut later = self.clusters.get(start..)?.iter();
        let cluster = later.find(|c| triangle < (c.first_triangle + c.triangles) as usize)?;
        let first = cluster.first_vertex as usize;
        let end = (cluster.first_triangle + cluster.triangles) as usize;
        Some(ClusterView {
            triangles: cluster.first_triangle as usize..end,
            smooth: cluster.smooth,
            positions: self.cluster_vertices.get(first..)?.first_chunk()?,
            normals: self.cluster_normals.get(first..)?.first_chunk()?,
        })
    }
}

/// Puts the normals of a cluster's corners to its vertices; returns whether
/// there is but one at each.
fn gather(local: &[[u8; 4]], normals: &[[Vec3; 3]], of_vertices: &mut [[f32; 4]]) -> bool {
    // No normal yet.
    of_vertices.fill([f32::NAN; 4]);
    let mut smooth = true;
    for (local, corner_normals) in local.iter().zip(normals) {
        for (&vertex, normal) in local.iter().zip(corner_normals) {
            // A cluster of triangles that are not drawn has no vertices.
            let Some(known) = of_vertices.get_mut(usize::from(vertex)) else {
                continue;
            };
            let normal = normal.extend(0.0).to_array();
            if known[3].is_nan() {
                *known = normal;
            } else if *known != normal {
                smooth = false;
            }
        }
    }
    smooth
}

/// What shading needs of a cluster.
pub(crate) struct ClusterView<'a> {
    pub triangles: Range<usize>,
    pub smooth: bool,
    /// x, y, z and 0 of its vertices, and of others after them.
    pub positions: &'a [[f32; 4]; CLUSTER_VERTICES],
    /// The same of their normals, where they have one each.
    pub normals: &'a [[f32; 4]; CLUSTER_VERTICES],
}
