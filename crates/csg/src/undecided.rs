//! Where and why a solid's exact boundary could not be told.

use std::fmt;

use glam::DVec3;

/// A place at which the exact boundary could not be told, and another way of meshing
/// had to do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Undecided {
    /// What could not be told.
    pub why: Why,
    /// About where, in model units.
    pub place: DVec3,
}

/// What could not be told of a solid's boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Why {
    /// Along which curves two surfaces meet.
    Curve,
    /// How a surface can be parted so that each part is seen without overlap.
    Chart,
    /// Where a curve crosses a surface: it may run along it too closely.
    Crossing,
    /// In which order surfaces lie around a curve.
    Order,
    /// Which edge of a face follows which.
    Contour,
    /// How a face is cut into triangles.
    Face,
    /// How faces meet along an edge that occurs twice.
    Edge,
}

impl Why {
    /// In words.
    #[must_use]
    pub fn describe(self) -> &'static str {
        match self {
            Self::Curve => "the curves in which two surfaces meet are not known",
            Self::Chart => "a surface cannot be parted so that each part is seen whole",
            Self::Crossing => "it could not be told where a curve crosses a surface",
            Self::Order => "surfaces around a curve are too close to tell their order",
            Self::Contour => "edges around a face do not close",
            Self::Face => "a face could not be cut into triangles",
            Self::Edge => "faces meet twice along one edge",
        }
    }
}

impl fmt::Display for Undecided {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (near {})", self.why.describe(), self.place)
    }
}

/// Why the evaluation of a boundary ended early.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stop {
    /// Something could not be told.
    Undecided(Undecided),
    /// The caller wanted no more of it, or a limit was reached: [`crate::control::Control`]
    /// tells which.
    Halted,
}

impl Stop {
    pub fn undecided(why: Why, place: DVec3) -> Self {
        Self::Undecided(Undecided { why, place })
    }
}
