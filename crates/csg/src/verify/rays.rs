//! Which rays are sent through a mesh.

use glam::DVec3;

use super::spread::Spread;
use crate::program::Bounds;

/// Lines along the axes through a box: those along one pass through all pairs of places
/// along the other two.
pub(super) struct Lattice {
    /// Ascending, as many along each axis.
    pub places: [Vec<f64>; 3],
}

/// A line along an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub axis: usize,
    /// A point of it.
    pub through: DVec3,
}

impl Ray {
    pub fn at(&self, t: f64) -> DVec3 {
        let mut point = self.through;
        point[self.axis] = t;
        point
    }

    /// The part between two places as a box without width: its centre and half extents.
    pub fn part(&self, [low, high]: [f64; 2]) -> (DVec3, DVec3) {
        let mut half = DVec3::ZERO;
        half[self.axis] = 0.5 * (high - low);
        (self.at(low.midpoint(high)), half)
    }
}

/// A root of a surface along a ray costs about as much as so many triangles, times the
/// share of that which all of them may take.
const TRIANGLES_PER_ROOT: f64 = 8.0;
/// The more rays, the more triangles are near one: for each ray along an axis so many.
const TRIANGLES_PER_RAY: f64 = 160.0;

impl Lattice {
    /// Rows of rays, and rays in each, along each axis, at least and at most.
    const FEWEST: usize = 3;
    const MOST: usize = 10;

    /// Of as many rays as are a small part of the work that a mesh is.
    pub fn new(bounds: &Bounds, triangles: usize, surfaces: usize) -> Self {
        let cost = (TRIANGLES_PER_ROOT * surfaces as f64).max(TRIANGLES_PER_RAY);
        let affordable = triangles as f64 / cost;
        let side = (affordable.sqrt() as usize).clamp(Self::FEWEST, Self::MOST);
        let mut spread = Spread::default();
        let shares: Vec<DVec3> = (0..side)
            .map(|i| (0.2 + 0.6 * spread.next() + i as f64) / side as f64)
            .collect();
        let place = |axis: usize, share: &DVec3| {
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            low + share[axis] * (high - low)
        };
        Self {
            places: [0, 1, 2].map(|axis| shares.iter().map(|share| place(axis, share)).collect()),
        }
    }

    /// Rays in all.
    pub fn len(&self) -> usize {
        3 * self.places[0].len().pow(2)
    }

    /// The number of the ray along an axis through two places along the two after it.
    pub fn number(&self, axis: usize, first: usize, second: usize) -> usize {
        (axis * self.places[0].len() + first) * self.places[0].len() + second
    }

    pub fn ray(&self, number: usize) -> Ray {
        let side = self.places[0].len();
        let (axis, first, second) = (number / (side * side), number / side % side, number % side);
        let mut through = DVec3::ZERO;
        through[(axis + 1) % 3] = self.places[(axis + 1) % 3][first];
        through[(axis + 2) % 3] = self.places[(axis + 2) % 3][second];
        Ray { axis, through }
    }
}
