//! Boxes with the surfaces that matter in them.

use glam::DVec3;

use super::ids::Position;
use crate::program::{Cell, Surface, SurfaceId};

/// A box, half-open, with the program pruned to it. The boxes of one scene
/// share their coordinates to the bit, so that they partition every line.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    pub low: DVec3,
    pub high: DVec3,
    pub cell: Cell,
}

impl Block {
    /// The surfaces that matter in it, in ascending order.
    pub fn surfaces(&self) -> impl Iterator<Item = (Position, SurfaceId)> {
        Position::all(self.cell.surfaces.len()).zip(self.cell.ids())
    }

    /// All pairs of them, each with the lesser first.
    pub fn pairs(&self) -> impl Iterator<Item = [Position; 2]> {
        let count = self.cell.surfaces.len() as u32;
        let pairs = (1..count).flat_map(|b| (0..b).map(move |a| [a, b]));
        pairs.map(|pair| pair.map(Position))
    }

    pub fn id(&self, position: Position) -> SurfaceId {
        SurfaceId(self.cell.surfaces[position.index()])
    }

    /// Where a surface is, if it matters in it.
    pub fn position_of(&self, id: SurfaceId) -> Option<Position> {
        self.cell.position_of(id.0).map(Position)
    }

    pub fn center(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    /// Whether a point is in this block and in no neighbour.
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.low).all() && point.cmplt(self.high).all()
    }

    /// The planes of its six sides.
    pub fn sides(&self) -> impl Iterator<Item = Surface> {
        [self.low, self.high]
            .into_iter()
            .flat_map(|corner| DVec3::AXES.map(|axis| Surface::plane(corner * axis, axis)))
    }
}
