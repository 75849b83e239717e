//! Where three surfaces meet that rounding does not tell apart: a place of some extent.

use glam::DVec3;
use smallvec::SmallVec;

/// Where three surfaces cannot be told from having a curve in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub center: DVec3,
    pub radius: f64,
}

/// A place at which one of the curves of three surfaces tells that they touch.
pub(super) struct Touching {
    /// In it is one point of all three, its centre.
    pub ball: Ball,
    /// Where another one of their curves crosses the third surface, but no farther from it than the
    /// two are from each other that are said to touch: parts of the contact.
    pub crossings: SmallVec<[Ball; 2]>,
}
