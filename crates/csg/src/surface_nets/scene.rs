//! What the whole mesh has in common.

use super::lattice::Lattice;
use crate::program::{Origin, Reach, Surface};

/// What the whole mesh has in common.
pub(super) struct Scene<'a> {
    /// The program's surfaces, in the local frame.
    pub surfaces: &'a [Surface],
    /// How far each of them reaches.
    pub reaches: &'a [Reach],
    pub lattice: Lattice,
    /// The primitives that literals come from.
    pub origins: &'a [Origin],
    /// Distance to a surface below which a point lies on it.
    pub tolerance: f64,
}

impl Scene<'_> {
    /// What pruning needs to know of the surfaces.
    pub fn table(&self) -> (&[Surface], &[Reach]) {
        (self.surfaces, self.reaches)
    }

    /// Whether two primitives have the same kind, name and colour.
    pub fn look_alike(&self, a: u32, b: u32) -> bool {
        a == b || self.origins[a as usize].looks_like(&self.origins[b as usize])
    }
}
