//! The sampling lattice: where samples, cells and bricks lie.
//!
//! Every sample coordinate comes from one formula of its global index, so that
//! all bricks that share a sample compute it, and every surface's sign there,
//! bit for bit alike.

use glam::{DVec3, UVec3};

use crate::error::Error;
use crate::numeric::tolerance::COORDINATE;
use crate::program::Bounds;

/// Samples along each side of a brick; rows of 16 pack four to a word.
pub(super) const SAMPLES: usize = 16;
/// Cells along each side of a brick: neighbours share a layer of samples.
pub(super) const CELLS: usize = SAMPLES - 1;

/// The fractions of a cell by which the lattice starts before the bounds:
/// irrational and different along the axes, so that the faces of models,
/// which lie at round coordinates and often symmetrically, meet no sample.
const SHIFT: DVec3 = DVec3::new(
    0.381_966_011_250_105,
    0.414_213_562_373_095,
    0.302_775_637_731_995,
);

/// More bricks along a side than this and indices would not fit their types.
const MOST_BRICKS: f64 = 65_535.0;

/// A uniform lattice of samples, grouped into bricks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    first: DVec3,
    pub step: f64,
    /// Bricks along each axis.
    pub bricks: UVec3,
}

impl Lattice {
    /// The lattice of cells of side `step` that covers `bounds` with more than
    /// one cell to spare on every side.
    pub fn around(bounds: &Bounds, step: f64) -> Result<Self, Error> {
        let first = bounds.min - (DVec3::ONE + SHIFT) * step;
        let cells = ((bounds.max - first) / step).ceil() + 1.0;
        let bricks = (cells / CELLS as f64).ceil();
        if !(bricks.max_element() <= MOST_BRICKS && bricks.min_element() >= 1.0) {
            return Err(Error::InvalidOption(format!(
                "cells of side {step:e} in a box of {:?}: at most {} cells fit along a side; use larger cells",
                bounds.size().to_array(),
                MOST_BRICKS * CELLS as f64,
            )));
        }
        Ok(Self {
            first,
            step,
            bricks: bricks.as_uvec3(),
        })
    }

    /// The coordinate of a sample along one axis.
    #[inline]
    pub fn coordinate(&self, axis: usize, sample: u32) -> f64 {
        f64::from(sample) * self.step + self.first[axis]
    }

    /// Centre and half extents of the box of all samples of the bricks from
    /// `from` to before `to`, a little enlarged against rounding.
    pub fn bricks_box(&self, from: UVec3, to: UVec3) -> (DVec3, DVec3) {
        let corner = |brick: UVec3| {
            DVec3::from_array([0, 1, 2].map(|a| self.coordinate(a, brick[a] * CELLS as u32)))
        };
        let (low, high) = (corner(from), corner(to));
        let center = 0.5 * (low + high);
        let slack = COORDINATE * (low.abs() + high.abs());
        (center, 0.5 * (high - low) + slack)
    }
}
