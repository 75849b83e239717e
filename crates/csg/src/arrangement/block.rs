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
    /// How long those boxes were that its sides, the lower and the upper ones, have cut in halves;
    /// infinite for others.
    pub spans: [DVec3; 2],
    pub cell: Cell,
}

impl Block {
    /// One that has cut nothing in halves.
    pub fn new([low, high]: [DVec3; 2], cell: Cell) -> Self {
        Self {
            low,
            high,
            spans: [DVec3::INFINITY; 2],
            cell,
        }
    }

    /// One of the eight that its halves along all axes have in common, with nothing in it: of the
    /// upper halves where a bit is set.
    pub fn octant(&self, octant: u32) -> Self {
        let mut part = Self {
            spans: self.spans,
            ..Self::new([self.low, self.high], Cell::default())
        };
        let (middle, size) = (self.center(), self.high - self.low);
        for axis in 0..3 {
            let (side, spans) = match octant >> axis & 1 {
                0 => (&mut part.high, &mut part.spans[1]),
                _ => (&mut part.low, &mut part.spans[0]),
            };
            (side[axis], spans[axis]) = (middle[axis], size[axis]);
        }
        part
    }

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

    /// The planes of its six sides, each with its span.
    pub fn sides(&self) -> impl Iterator<Item = (Surface, f64)> {
        let corners = [self.low, self.high].into_iter().zip(self.spans);
        corners.flat_map(|(corner, spans)| {
            [0, 1, 2].map(|k| {
                let axis = DVec3::AXES[k];
                (Surface::plane(corner * axis, axis), spans[k])
            })
        })
    }
}
