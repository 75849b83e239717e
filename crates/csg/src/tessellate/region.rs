//! A face of a mesh, and how far its surface bends along an edge.

use glam::DVec3;

use super::deviation::{self, Shrinkage};
use super::project::project;
use crate::program::{Kind, Surface, SurfaceId};
use crate::surface::round::Round;

/// How a surface bends, which says what triangles suit it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bend {
    /// A plane.
    Flat,
    /// A developable surface: cylinders and cones, with a ruling along which
    /// nothing bends.
    Single,
    /// Ellipsoids, paraboloids, hyperboloids of two sheets.
    Double,
    /// Hyperboloids of one sheet and hyperbolic paraboloids, with two rulings.
    Saddle,
}

/// A connected face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Region {
    pub surface: SurfaceId,
    pub group: u32,
    pub bend: Bend,
    /// 1 where the surface's gradient points out of the solid, else -1.
    pub outward: f64,
    pub shrinkage: Shrinkage,
    pub round: Option<Round>,
    pub way: Way,
}

impl Region {
    /// A point of the region's surface near another one.
    pub fn project(&self, surface: &Surface, start: DVec3) -> Option<DVec3> {
        match &self.round {
            Some(round) => round.project(start),
            None => project(surface, start),
        }
    }

    /// A bound of the distance of any point of a triangle to the region's surface.
    pub fn bound(&self, surface: &Surface, corners: [DVec3; 3]) -> f64 {
        let bound = deviation::with_shrinkage(surface, self.shrinkage, corners);
        let round = self.round.as_ref();
        round.map_or(bound, |round| bound.min(round.bound(&corners)))
    }

    /// How far the surface turns from one point of it to another, about in radians.
    pub fn turn(&self, surface: &Surface, ends: [DVec3; 2]) -> f64 {
        if let Some(round) = &self.round {
            return round.turn(ends);
        }
        let [a, b] = ends.map(|at| surface.gradient(at).normalize_or_zero());
        a.distance(b)
    }
}

/// How the triangles of a face come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// By cutting edges.
    OneByOne,
    /// Large ones by cutting edges, the small ones by tessellation.
    AtOnce,
    /// They were tessellated: the large ones only keep the mesh closed.
    Done,
}

impl Bend {
    /// Whether the surface bends in all directions, but for two at most.
    pub fn is_twice(self) -> bool {
        matches!(self, Self::Double | Self::Saddle)
    }

    pub fn of(surface: &Surface) -> Self {
        match surface.kind {
            Kind::Plane => Self::Flat,
            Kind::Cone
            | Kind::EllipticCylinder
            | Kind::HyperbolicCylinder
            | Kind::ParabolicCylinder
            | Kind::ParallelPlanes => Self::Single,
            Kind::Ellipsoid | Kind::HyperboloidTwoSheets | Kind::EllipticParaboloid => Self::Double,
            Kind::HyperboloidOneSheet | Kind::HyperbolicParaboloid => Self::Saddle,
        }
    }
}

/// The squared length of an edge in the metric in which triangles on a surface
/// should be well shaped: by how far the surface bends along it, and a little
/// by its length, so that no direction counts for nothing.
#[inline(always)]
pub(super) fn metric(surface: &Surface, bend: Bend, edge: DVec3) -> f64 {
    /// Rulings count as a thousandth of their length. Tunes counts only.
    const ALONG_RULINGS: f64 = 1e-6;
    match bend {
        Bend::Flat | Bend::Saddle => edge.length_squared(),
        Bend::Single | Bend::Double => {
            0.5 * surface.curvature_along(edge).abs() + ALONG_RULINGS * edge.length_squared()
        }
    }
}
