//! Normals kept with the vertices of clusters.
//!
//! A mesh gives a normal for every corner of every triangle. On smooth
//! surfaces the corners at a vertex share theirs; kept once with the cluster's
//! vertex it takes a fifth of the memory, which is what shading many small
//! triangles waits for.

use glam::Vec3;
use rayon::prelude::*;

use crate::cluster::{CLUSTER_VERTICES, Cluster, split};
use crate::normals::{CornerNormals, Stars};
use crate::prepared::Prepared;

/// Triangles for each entry of [`Prepared::cluster_starts`].
const GROUP: usize = 32;
/// Clusters per parallel task.
const CHUNK: usize = 64;

impl Prepared {
    /// Finds the clusters whose vertices have one normal each, and keeps
    /// these. O(triangles). Those that are not `seen` are passed over. Corner
    /// normals that are `missing` are put down for the other clusters only.
    pub(crate) fn gather_normals(
        &mut self,
        seen: impl Fn(&Cluster) -> bool + Sync,
        missing: Option<&CornerNormals>,
    ) {
        self.cluster_starts.clear();
        for (index, cluster) in self.clusters.iter().enumerate() {
            let end = (cluster.first_triangle + cluster.triangles) as usize;
            while self.cluster_starts.len() * GROUP < end {
                self.cluster_starts.push(index as u32);
            }
        }
        // (Zeros from the system, which the threads touch first.)
        let mut all: Vec<[f32; 4]> = bytemuck::zeroed_vec(self.cluster_vertices.len());
        let rows = split(&mut all, self.clusters.iter().map(Cluster::padded_vertices));
        let lengths = self.clusters.iter().map(|c| c.triangles as usize);
        let normals = split(&mut self.normals, lengths);
        let local = &self.local[..];
        let smooth: Vec<bool> = self
            .clusters
            .par_iter()
            .zip(rows)
            .zip(normals)
            .with_min_len(CHUNK)
            .map_init(Stars::default, |stars, ((cluster, rows), normals)| {
                if !seen(cluster) {
                    return false;
                }
                let local = &local[cluster.range()];
                if let Some(missing) = missing {
                    if at_vertices(missing, cluster, local, rows) {
                        return true;
                    }
                    missing.fill(stars, cluster.range().start, normals);
                }
                gather(local, normals, rows)
            })
            .collect();
        for (cluster, smooth) in self.clusters.iter_mut().zip(smooth) {
            cluster.smooth = smooth;
        }
        self.cluster_normals = all;
    }

    /// The normals at the corners of a triangle that may be seen.
    pub(crate) fn corner_normals(&self, triangle: usize) -> Option<[Vec3; 3]> {
        let cluster = self.cluster_view(triangle)?;
        if !cluster.smooth {
            return self.normals.get(triangle).copied();
        }
        let [a, b, c, _] = cluster.local(triangle)?;
        Some([a, b, c].map(|vertex| {
            let [x, y, z, _] = cluster.normals[usize::from(vertex) % CLUSTER_VERTICES];
            Vec3::new(x, y, z)
        }))
    }

    /// The cluster that a triangle is in.
    pub(crate) fn cluster_view(&self, triangle: usize) -> Option<ClusterView<'_>> {
        let start = *self.cluster_starts.get(triangle / GROUP)? as usize;
        let mut later = self.clusters.get(start..)?.iter();
        let cluster = later.find(|c| triangle < (c.first_triangle + c.triangles) as usize)?;
        let first = cluster.first_vertex as usize;
        Some(ClusterView {
            first: cluster.first_triangle as usize,
            local: self.local.get(cluster.range())?,
            smooth: cluster.smooth,
            positions: self.cluster_vertices.get(first..)?.first_chunk()?,
            normals: self.cluster_normals.get(first..)?.first_chunk()?,
        })
    }
}

/// Puts normals to a cluster's vertices; returns false where their corners may
/// not share one.
fn at_vertices(
    normals: &CornerNormals,
    cluster: &Cluster,
    local: &[[u8; 4]],
    of_vertices: &mut [[f32; 4]],
) -> bool {
    let triangles = &normals.mesh.triangles[cluster.range()];
    triangles.iter().zip(local).all(|(triangle, local)| {
        triangle.iter().zip(local).all(|(&vertex, &own)| {
            let to = of_vertices.get_mut(usize::from(own));
            match (to, normals.at_vertex(vertex)) {
                (Some(to), Some(normal)) => {
                    *to = normal.extend(0.0).to_array();
                    true
                }
                _ => false,
            }
        })
    })
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
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClusterView<'a> {
    /// Its first triangle.
    first: usize,
    local: &'a [[u8; 4]],
    pub smooth: bool,
    /// x, y, z and 0 of its vertices, and of others after them.
    pub positions: &'a [[f32; 4]; CLUSTER_VERTICES],
    /// The same of their normals, where they have one each.
    pub normals: &'a [[f32; 4]; CLUSTER_VERTICES],
}

impl Default for ClusterView<'_> {
    /// One without triangles.
    fn default() -> Self {
        const NONE: &[[f32; 4]; CLUSTER_VERTICES] = &[[0.0; 4]; CLUSTER_VERTICES];
        Self {
            first: 0,
            local: &[],
            smooth: false,
            positions: NONE,
            normals: NONE,
        }
    }
}

impl ClusterView<'_> {
    /// The numbers of a triangle's vertices, if it is in the cluster.
    #[inline(always)]
    pub fn local(&self, triangle: usize) -> Option<[u8; 4]> {
        self.local.get(triangle.wrapping_sub(self.first)).copied()
    }
}
