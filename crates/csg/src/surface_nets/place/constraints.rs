//! The surfaces that a vertex is to lie on.

use glam::DVec3;

/// The surfaces of one vertex, as positions in the brick's list. More than
/// this never have a common point but by construction of the model.
pub(super) const MOST_CONSTRAINTS: usize = 8;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Constraints {
    pub len: usize,
    list: [u16; MOST_CONSTRAINTS],
}

impl Constraints {
    pub fn of(surface: u16) -> Self {
        Self::default().with(surface)
    }

    pub fn insert(&mut self, surface: u16) {
        if !self.as_slice().contains(&surface) && self.len < MOST_CONSTRAINTS {
            self.list[self.len] = surface;
            self.len += 1;
        }
    }

    pub fn as_slice(&self) -> &[u16] {
        &self.list[..self.len]
    }

    pub fn with(mut self, surface: u16) -> Self {
        self.insert(surface);
        self
    }

    pub fn without(&self, index: usize) -> Self {
        let mut rest = Self::default();
        for (i, &surface) in self.as_slice().iter().enumerate() {
            if i != index {
                rest.insert(surface);
            }
        }
        rest
    }
}

/// A vertex in place, and what is to be known should it not be valid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// Index into the part's vertices.
    pub vertex: usize,
    pub constraints: Constraints,
    /// The mean of its crossed edges' middles.
    pub start: DVec3,
    /// The middle of the cell or face.
    pub middle: DVec3,
}
