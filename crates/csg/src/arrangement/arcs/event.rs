//! Where stretches of a curve end.

use glam::DVec3;

use crate::arrangement::arc::Ends;
use crate::arrangement::ids::Position;
use crate::program::SurfaceId;

/// What a plane is that is no surface of the solid.
#[derive(Clone, Copy, Debug)]
pub(super) enum Cutting {
    /// A side of the block, with its span.
    Side(f64),
    /// A seam or the divider of a surface.
    Seam(SurfaceId),
}

/// Where a stretch of a curve ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    pub at: f64,
    pub ends: Ends,
    /// The surface of the cell that the curve touches here.
    pub touched: Option<Position>,
    /// Where that is, if all surfaces there agree on it.
    pub point: Option<DVec3>,
}

impl Event {
    /// Whether edges may end here though the solid does not change along the
    /// curve.
    pub fn touches(&self) -> bool {
        self.touched.is_some() || matches!(self.ends, Ends::Node)
    }

    /// The surface of the cell that the curve crosses here.
    pub fn crossed(&self) -> Option<Position> {
        match self.ends {
            Ends::Surface(position) => Some(position),
            _ => None,
        }
    }
}
