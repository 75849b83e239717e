//! A mesh whose triangles know their surfaces.

use std::sync::Arc;

use glam::DVec3;

use crate::arrangement::Borders;
use crate::numeric::tolerance::ON_REFINED;
use crate::program::SurfaceId;

/// A mesh whose triangles know their surfaces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surfaced {
    /// In the frame of the surfaces.
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle its group. Groups are kept apart.
    pub groups: Vec<u32>,
    /// For each group its surface.
    pub surface_of_group: Arc<[SurfaceId]>,
    /// Edges between groups of one surface whose curves are known.
    pub borders: Borders,
    /// How near points must come to their surfaces.
    pub precision: f64,
    /// No point of the solid is farther from the origin of the surfaces.
    pub reach: f64,
}

impl Surfaced {
    /// Without triangles, for some on the same surfaces.
    pub fn empty(&self) -> Self {
        Self {
            surface_of_group: Arc::clone(&self.surface_of_group),
            precision: self.precision,
            reach: self.reach,
            ..Self::default()
        }
    }
}

/// About what is held for each triangle at a time.
pub(super) const BYTES_PER_TRIANGLE: usize = 200;

/// About what a triangle that is finished takes, in its part and in the whole.
pub(super) const BYTES_PER_FINISHED: usize = 64;

/// How near points in a frame must come to their surfaces.
pub(crate) fn precision(positions: &[DVec3]) -> f64 {
    let size = positions
        .iter()
        .fold(0.0f64, |m, p| m.max(p.abs().max_element()));
    ON_REFINED * size
}
