//! Patterns: one solid in many places, its subtree shared.

use crate::elementary;
use std::f64::consts::TAU;

use glam::{DAffine3, DMat3, DVec3};

use crate::error::NodeFault;
use crate::solid::Solid;

/// The solid in many places at once.
impl Solid {
    fn pattern(&self, function: &'static str, places: impl IntoIterator<Item = DAffine3>) -> Self {
        let copies: Vec<Self> = places.into_iter().map(|place| self.affine(place)).collect();
        let made = if copies.is_empty() {
            let (what, count, least) = ("places", 0, 1);
            Err(NodeFault::TooFew { what, count, least })
        } else {
            Ok(Self::union(copies))
        };
        Self::shaped(function, made)
    }

    /// `count` copies in a row, the first where the solid is, each `step` further.
    #[must_use]
    pub fn linear_pattern(&self, count: usize, step: impl Into<DVec3>) -> Self {
        let step = step.into();
        let place = |k: usize| DAffine3::from_translation(k as f64 * step);
        self.pattern("linear_pattern", (0..count).map(place))
    }

    /// Copies at the nodes of a grid: so many along x, y and z, the first where the
    /// solid is.
    #[must_use]
    pub fn grid_pattern(&self, counts: [usize; 3], steps: impl Into<DVec3>) -> Self {
        let steps = steps.into();
        let [nx, ny, nz] = counts;
        let places = (0..nx * ny * nz).map(|k| {
            let node = [k % nx, k / nx % ny, k / nx / ny].map(|i| i as f64);
            DAffine3::from_translation(steps * DVec3::from_array(node))
        });
        self.pattern("grid_pattern", places)
    }

    /// `count` copies around the z axis, turned with it, the first where the solid
    /// is.
    #[must_use]
    pub fn polar_pattern(&self, count: usize) -> Self {
        let place = |k: usize| {
            // Quarter turns come out exact.
            let turn = crate::solid::profile::turn(k, count);
            DAffine3::from_mat3(DMat3::from_cols(
                DVec3::new(turn.x, turn.y, 0.0),
                DVec3::new(-turn.y, turn.x, 0.0),
                DVec3::Z,
            ))
        };
        self.pattern("polar_pattern", (0..count).map(place))
    }

    /// Copies along a path of straight pieces: `count` of them at equal distances
    /// from its first point to its last, the solid's x axis along the way and its z
    /// axis as far up as that allows. Pieces without length are passed over.
    #[must_use]
    pub fn path_pattern<P: Into<DVec3>>(
        &self,
        path: impl IntoIterator<Item = P>,
        count: usize,
    ) -> Self {
        let points: Vec<DVec3> = path.into_iter().map(Into::into).collect();
        let pieces: Vec<(DVec3, DVec3)> = points
            .windows(2)
            .map(|pair| (pair[0], pair[1] - pair[0]))
            .filter(|(_, way)| way.length() > 0.0)
            .collect();
        let total: f64 = pieces.iter().map(|(_, way)| way.length()).sum();
        if pieces.is_empty() || !total.is_finite() {
            let what = "pieces of the path with a length";
            let fault = NodeFault::TooFew {
                what,
                count: 0,
                least: 1,
            };
            return Self::shaped("path_pattern", Err(fault));
        }
        let place = |k: usize| {
            let share = k as f64 / (count.max(2) - 1) as f64;
            let mut rest = share * total;
            let mut at = 0;
            while at + 1 < pieces.len() && rest > pieces[at].1.length() {
                rest -= pieces[at].1.length();
                at += 1;
            }
            let (start, way) = pieces[at];
            let x = way.normalize();
            let y = DVec3::Z.cross(x).try_normalize().unwrap_or(DVec3::Y);
            DAffine3 {
                matrix3: DMat3::from_cols(x, y, x.cross(y)),
                translation: start + rest * x,
            }
        };
        self.pattern("path_pattern", (0..count).map(place))
    }

    /// `count` copies up a helix around the z axis: each turned by a turn over
    /// `per_turn` and raised by `pitch` over `per_turn` against the one before.
    #[must_use]
    pub fn helical_pattern(&self, count: usize, per_turn: f64, pitch: f64) -> Self {
        let place = |k: usize| {
            let turns = k as f64 / per_turn;
            let lift = DAffine3::from_translation(pitch * turns * DVec3::Z);
            lift * DAffine3::from_mat3(elementary::rotation_z(TAU * turns))
        };
        self.pattern("helical_pattern", (0..count).map(place))
    }
}
