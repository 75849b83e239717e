//! A place of some extent.

use glam::DVec3;

/// Where three surfaces cannot be told from having a curve in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub center: DVec3,
    pub radius: f64,
}
