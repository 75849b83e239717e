//! What is asked of a mesh.

use rustc_hash::FxHashMap;

use crate::program::SurfaceId;

/// What is asked of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Goal {
    /// The largest distance between mesh and boundary, both ways.
    pub tolerance: f64,
    /// What is farther off than this is reported.
    pub promised: f64,
    /// Whether vertices lie evenly along curves, and not as chance would have it:
    /// those that the tolerance needs are kept.
    pub even_curves: bool,
    /// Whether all vertices that are given stay, and where they are, but on whole ellipsoids,
    /// which are made anew: a mesh that does not run through itself then hardly ever comes to.
    pub keeps_vertices: bool,
    /// The largest angle that a surface may turn along an edge, in radians.
    pub angle: Option<f64>,
    /// For every surface that needs a smaller tolerance the share that it gets:
    /// where faces run close to each other.
    pub tight: FxHashMap<SurfaceId, f64>,
}

impl Goal {
    /// Coarser by a factor, about evenly in chords and angles.
    pub fn loosened(&self, factor: f64) -> Self {
        Self {
            tolerance: factor * self.tolerance,
            angle: self
                .angle
                .map(|angle| (factor.sqrt() * angle).min(std::f64::consts::PI)),
            ..self.clone()
        }
    }

    /// What is left of it for the mesh if surfaces were moved by a distance.
    pub fn less(&self, moved: f64) -> Self {
        Self {
            tolerance: self.tolerance - moved,
            promised: self.promised - moved,
            ..self.clone()
        }
    }

    /// The tolerance on a surface.
    pub fn tolerance_on(&self, surface: SurfaceId) -> f64 {
        self.tolerance * self.tight.get(&surface).unwrap_or(&1.0)
    }

    /// The distance to aim for on a surface, so that what is found by curvature
    /// meets the tolerance as it is bounded.
    pub fn aim_on(&self, surface: SurfaceId) -> f64 {
        0.98 * self.tolerance_on(surface)
    }
}
