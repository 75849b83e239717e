//! The global lattice of sample points that all bricks share.

use crate::numeric::tolerance::COORDINATE;
use glam::{DVec3, IVec3};

/// Fractions of a cell by which the lattice is shifted off the middle of the
/// bounds: irrational and different, so that faces at round coordinates fall
/// on no sample. (Fractional parts of the golden ratio and of the square roots
/// of 3 and 2.)
const SHIFT: DVec3 = DVec3::new(
    0.618_033_988_749_894_8,
    0.732_050_807_568_877_2,
    std::f64::consts::SQRT_2 - 1.0,
);

/// Sample points at `cell * (index + SHIFT)` relative to the middle of the
/// bounds, and the range of cells that matters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lattice {
    /// Side of a cell.
    pub(crate) cell: f64,
    /// First cell along each axis.
    pub(crate) first: IVec3,
    /// One past the last cell.
    pub(crate) end: IVec3,
}

impl Lattice {
    /// A lattice over a box of the given size, with at least one cell to
    /// spare on every side.
    pub(crate) fn new(size: DVec3, cell: f64) -> Self {
        let reach = 0.5 * size / cell;
        Self {
            cell,
            first: (-reach - SHIFT).floor().as_ivec3() - 1,
            end: (reach - SHIFT).ceil().as_ivec3() + 1,
        }
    }

    /// The sample point of an index: the same f64 whoever asks.
    pub(crate) fn point(&self, index: IVec3) -> DVec3 {
        (index.as_dvec3() + SHIFT) * self.cell
    }

    /// Centre and half extents of a box around the samples from `low` to
    /// `high`, wide enough to hold each of them despite rounding.
    pub(crate) fn box_around(&self, low: IVec3, high: IVec3) -> (DVec3, DVec3) {
        let (low, high) = (self.point(low), self.point(high));
        let margin = COORDINATE * low.abs().max(high.abs());
        (0.5 * (low + high), 0.5 * (high - low) + margin)
    }
}
