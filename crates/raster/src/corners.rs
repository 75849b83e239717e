//! Fetching the corners of small triangles, for pixels that show one each.
//!
//! What is fetched is nothing but waiting for memory: a vertex is one row, so
//! that it takes one wait, and the rows of many pixels are fetched in one
//! short loop, so that the waits overlap.

use crate::cluster::CLUSTER_VERTICES;
use crate::deferred::{Job, ShadeContext, shared};
use crate::scene::Scene;
use crate::simd::LANES;
use crate::smooth::ClusterView;

/// The corners of 16 triangles and their normals: by corner, then by triangle
/// x, y, z and 0.
#[derive(Clone, Debug, Default)]
pub(crate) struct Corners {
    pub position: [[[f32; 4]; LANES]; 3],
    pub normal: [[[f32; 4]; LANES]; 3],
}

impl Corners {
    /// Fetches what the pixels of a job show, each its own triangle, and finds
    /// their material; `cluster` is the last one looked at.
    #[inline(always)]
    pub fn fetch<'c>(
        &mut self,
        context: &ShadeContext<'c>,
        cluster: &mut Option<ClusterView<'c>>,
        job: &Job,
    ) -> usize {
        let scene = context.scene;
        let mut wanted = job.wanted;
        let mut material = None;
        while wanted != 0 {
            let lane = wanted.trailing_zeros() as usize % LANES;
            wanted &= wanted - 1;
            let triangle = job.triangles[lane] as usize;
            if !cluster
                .as_ref()
                .is_some_and(|c| c.triangles.contains(&triangle))
            {
                *cluster = scene.cluster_view(triangle);
            }
            if let Some(cluster) = cluster {
                self.gather(scene, cluster, triangle, lane);
            }
            material = shared(material, context.material(triangle));
        }
        material.unwrap_or(0)
    }

    /// Fetches a triangle from its cluster, where what belongs together lies
    /// together: neighbouring pixels show triangles of few clusters.
    #[inline(always)]
    fn gather(&mut self, scene: &Scene, cluster: &ClusterView, triangle: usize, lane: usize) {
        let Some(local) = scene.local.get(triangle) else {
            return;
        };
        for (c, vertex) in local[..3].iter().enumerate() {
            let vertex = usize::from(*vertex) % CLUSTER_VERTICES;
            self.position[c][lane] = cluster.positions[vertex];
        }
        if cluster.smooth {
            for (c, vertex) in local[..3].iter().enumerate() {
                let vertex = usize::from(*vertex) % CLUSTER_VERTICES;
                self.normal[c][lane] = cluster.normals[vertex];
            }
        } else if let Some(normals) = scene.normals.get(triangle) {
            for (to, normal) in self.normal.iter_mut().zip(normals) {
                to[lane] = normal.extend(0.0).to_array();
            }
        }
    }
}
