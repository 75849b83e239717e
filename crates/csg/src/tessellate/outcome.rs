//! What came of refining a mesh.

use glam::DVec3;

use crate::program::SurfaceId;

/// Why a promise could not be kept at some place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unkept {
    /// The mesh is no closed manifold.
    NotManifold,
    /// A curve between two faces could not be followed.
    Lost,
    /// A vertex could not be brought to its surfaces without a fold.
    Folded,
    /// The mesh runs through itself.
    Crossing,
    /// A triangle faces into the solid.
    TurnedOver,
    /// A triangle or a chord for which the tolerance could not be proven.
    Far,
}

impl Unkept {
    pub(crate) const fn describe(self) -> &'static str {
        match self {
            Self::NotManifold => "mesh that is not manifold: left as it is, whatever the tolerance",
            Self::Lost => "curve between two faces that could not be followed: not cut up",
            Self::Folded => "vertex that could not be put on its surfaces without a fold",
            Self::Crossing => "place where the mesh runs through itself",
            Self::TurnedOver => "triangle that faces into the solid",
            Self::Far => "place where the tolerance could not be proven to be kept",
        }
    }
}

/// What came of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outcome {
    /// The largest distance between mesh and boundary, a bound; and where.
    pub deviation: f64,
    pub farthest: DVec3,
    /// In the frame of the surfaces.
    pub unkept: Vec<(Unkept, DVec3)>,
    /// Surfaces for which a smaller tolerance may help; some several times.
    pub tighter: Vec<SurfaceId>,
}

impl Outcome {
    /// Notes a bound of the distance at a place, of the mesh from surfaces.
    pub fn note(&mut self, bound: f64, place: DVec3, surfaces: &[SurfaceId], promised: f64) {
        if bound > self.deviation {
            (self.deviation, self.farthest) = (bound, place);
        }
        if bound > promised {
            self.unkept.push((Unkept::Far, place));
            self.tighter.extend(surfaces);
        }
    }

    /// Whether a smaller tolerance is all that it may take.
    pub fn is_only_far(&self) -> bool {
        self.unkept.iter().all(|(reason, _)| *reason == Unkept::Far)
    }

    /// Whether the mesh runs through itself or faces into the solid.
    pub fn is_crossed(&self) -> bool {
        let is_crossing = |reason| matches!(reason, Unkept::Crossing | Unkept::TurnedOver);
        self.unkept.iter().any(|(reason, _)| is_crossing(*reason))
    }

    /// Adds what came of another part.
    pub fn add(&mut self, other: &Self) {
        if other.deviation > self.deviation {
            (self.deviation, self.farthest) = (other.deviation, other.farthest);
        }
        self.unkept.extend_from_slice(&other.unkept);
        self.tighter.extend_from_slice(&other.tighter);
    }
}
