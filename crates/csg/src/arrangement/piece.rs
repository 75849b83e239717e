//! A piece of an edge and the faces that meet along it.

use std::iter;

use glam::DVec3;

use crate::program::SurfaceId;

/// One of the two faces that meet along an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Side {
    /// The plane it lies on, by number.
    pub plane: SurfaceId,
    /// The first primitive of those that look like its own, by number.
    pub look: u32,
    /// Whether its outward normal is that of the plane.
    pub along_normal: bool,
    /// Which of the parts that its surface is cut into: 0 on a plane.
    pub patch: u8,
}

impl Side {
    /// Whether it is the same patch of the same surface as another one.
    pub fn shares_patch(&self, other: &Self) -> bool {
        self.plane == other.plane && self.patch == other.patch
    }
}

/// A curve in which a surface meets another one, or one of its own seams.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct CurveId {
    pub first: SurfaceId,
    pub other: Other,
    /// Which of the curves that the two have in common.
    pub branch: u16,
}

/// What a surface meets in a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Other {
    Surface(SurfaceId),
    /// One of its seams, which part its patches.
    Seam(u16),
}

impl CurveId {
    /// The first curve of two surfaces.
    pub fn first_of([first, second]: [SurfaceId; 2]) -> Self {
        Self {
            first,
            other: Other::Surface(second),
            branch: 0,
        }
    }

    pub fn second(&self) -> Option<SurfaceId> {
        match self.other {
            Other::Surface(second) => Some(second),
            Other::Seam(_) => None,
        }
    }

    /// The two surfaces that meet in it; none on a seam.
    pub fn pair(&self) -> Option<[SurfaceId; 2]> {
        Some([self.first, self.second()?])
    }

    /// The surfaces that it is on.
    pub fn surfaces(&self) -> impl Iterator<Item = SurfaceId> {
        iter::once(self.first).chain(self.second())
    }

    /// Whether it parts patches of one surface.
    pub fn is_seam(&self) -> bool {
        self.second().is_none()
    }
}

/// A piece of an edge: the boundary of the first face runs from `from` to `to`
/// there, with the face on its left as seen from outside, and that of the
/// second back.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub from: DVec3,
    pub to: DVec3,
    pub sides: [Side; 2],
    pub curve: CurveId,
    /// Where on the curve it begins and ends, but for rounding.
    pub places: [f64; 2],
    /// Whether nothing but a block's side ends it there, and it may as well go on.
    pub goes_on: [bool; 2],
}
