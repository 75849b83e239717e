//! A piece of an edge and the faces that meet along it.

use glam::DVec3;

/// One of the two faces that meet along an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Side {
    /// The plane it lies on, by number.
    pub plane: u32,
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

/// The position of what is no surface of the formula.
pub(crate) const NOTHING: u32 = u32::MAX;

/// A curve in which surfaces meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct CurveId {
    /// The two surfaces, by number; the second [`NOTHING`] on seams.
    pub surfaces: [u32; 2],
    /// Which of the first one's seams, if it is on one.
    pub seam: u16,
    /// Which of the curves that the two have in common.
    pub branch: u16,
}

impl CurveId {
    /// The first curve of two surfaces.
    pub fn first_of(surfaces: [u32; 2]) -> Self {
        Self {
            surfaces,
            seam: 0,
            branch: 0,
        }
    }

    /// Whether it parts patches of one surface.
    pub fn is_seam(&self) -> bool {
        self.surfaces[1] == NOTHING
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
