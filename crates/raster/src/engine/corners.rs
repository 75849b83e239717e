//! Fetching the corners of small triangles, for pixels that show one each.
//!
//! What is fetched is nothing but waiting for memory: a vertex is one row, so
//! that it takes one wait, and the rows of many pixels are fetched in one
//! short loop, so that the waits overlap.

use crate::cluster::CLUSTER_VERTICES;
use crate::deferred::Job;
use crate::shading::ShadeContext;
use crate::simd::{LANES, triple};
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
        cluster: &mut ClusterView<'c>,
        job: &Job,
    ) -> usize {
        let scene = context.scene;
        let mut wanted = job.wanted;
        while wanted != 0 {
            let lane = wanted.trailing_zeros() as usize % LANES;
            wanted &= wanted - 1;
            let triangle = job.triangles[lane] as usize;
            // Neighbouring pixels show triangles of few clusters.
            let local = match cluster.local(triangle) {
                Some(local) => local,
                None => match scene.cluster_view(triangle) {
                    Some(view) => {
                        *cluster = view;
                        view.local(triangle).unwrap_or_default()
                    }
                    None => continue,
                },
            };
            let vertices = triple!(|K| usize::from(local[K]) % CLUSTER_VERTICES);
            for (to, vertex) in self.position.iter_mut().zip(vertices) {
                to[lane] = cluster.positions[vertex];
            }
            if cluster.smooth {
                for (to, vertex) in self.normal.iter_mut().zip(vertices) {
                    to[lane] = cluster.normals[vertex];
                }
            } else if let Some(normals) = scene.normals.get(triangle) {
                for (to, normal) in self.normal.iter_mut().zip(normals) {
                    to[lane] = normal.extend(0.0).to_array();
                }
            }
        }
        context.material_of(job)
    }
}
