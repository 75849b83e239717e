//! What is said of the curves of two surfaces, and those of two planes.

use glam::DVec3;
use smallvec::SmallVec;

use super::curve::Curve;
use crate::numeric::tolerance::{NEAR, PARALLEL_PLANES, TOUCH};
use crate::program::Surface;

/// Why the curves of two surfaces are not known.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Unknown {
    /// They have only single points in common, where they touch.
    Touch(Contacts),
    /// There is no closed form for them here.
    NoForm,
}

/// Distances below which surfaces agree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearness {
    /// Of what is placed alike, as [`NEAR`] says.
    pub near: f64,
    /// Of what touches, as [`TOUCH`] says.
    pub touch: f64,
}

impl Nearness {
    /// In a scene around the origin in which so much is near.
    pub fn of(near: f64) -> Self {
        let touch = near / NEAR * TOUCH;
        Self { near, touch }
    }

    /// In a part of the scene that is such a share of it.
    pub fn within(self, share: f64) -> Self {
        Self {
            near: self.near * share,
            touch: self.touch * share,
        }
    }

    /// How large the scene is.
    pub fn scene(self) -> f64 {
        self.near / NEAR
    }
}

pub(super) type Contacts = SmallVec<[DVec3; 2]>;

/// The line common to two planes.
pub(super) fn line(p: &Surface, q: &Surface) -> Option<Curve> {
    let direction = p.linear.cross(q.linear);
    let square = direction.length_squared();
    if square < PARALLEL_PLANES * PARALLEL_PLANES {
        return None;
    }
    let offsets = [p, q].map(|s| s.linear.dot(s.anchor));
    let point =
        (q.linear.cross(direction) * offsets[0] + direction.cross(p.linear) * offsets[1]) / square;
    Some(Curve::Line {
        point,
        direction: direction / square.sqrt(),
    })
}
