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

/// A curve in which surfaces meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum CurveId {
    /// Which of the curves that two surfaces have in common.
    Common {
        surfaces: [SurfaceId; 2],
        branch: u16,
    },
    /// Which of the curves in one of a surface's seams: it parts patches of that.
    Seam {
        surface: SurfaceId,
        seam: u16,
        branch: u16,
    },
}

impl CurveId {
    /// The first curve of two surfaces.
    pub fn first_of(surfaces: [SurfaceId; 2]) -> Self {
        let branch = 0;
        Self::Common { surfaces, branch }
    }

    /// Another one of the same surfaces, or in the same seam.
    pub fn with_branch(mut self, number: u16) -> Self {
        let (Self::Common { branch, .. } | Self::Seam { branch, .. }) = &mut self;
        *branch = number;
        self
    }

    pub fn branch(self) -> u16 {
        let (Self::Common { branch, .. } | Self::Seam { branch, .. }) = self;
        branch
    }

    /// The surfaces that meet in it; on seams there is one alone.
    pub fn pair(self) -> (SurfaceId, Option<SurfaceId>) {
        match self {
            Self::Common {
                surfaces: [first, second],
                ..
            } => (first, Some(second)),
            Self::Seam { surface, .. } => (surface, None),
        }
    }

    /// The same, one after another.
    pub fn surfaces(self) -> impl Iterator<Item = SurfaceId> {
        let (first, second) = self.pair();
        iter::once(first).chain(second)
    }

    /// Whether it parts patches of one surface.
    pub fn is_seam(self) -> bool {
        matches!(self, Self::Seam { .. })
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
}
