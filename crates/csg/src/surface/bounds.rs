//! Boxes.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Surface;
use crate::numeric::tolerance::{COORDINATE, VALUE};

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Least corner.
    pub min: DVec3,
    /// Greatest corner.
    pub max: DVec3,
}

impl Bounds {
    /// The middle.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// The side lengths.
    #[must_use]
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    pub(crate) fn around(center: DVec3, half: DVec3) -> Self {
        Self {
            min: center - half,
            max: center + half,
        }
    }

    pub(crate) fn united(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    pub(crate) fn intersected(self, other: Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }
}

/// The box of f <= 0 of one surface, as far as it is easily told.
pub(crate) fn half_space_bounds(surface: &Surface) -> Bounds {
    let mut bounds = Bounds {
        min: DVec3::NEG_INFINITY,
        max: DVec3::INFINITY,
    };
    let anchor = surface.anchor;
    // Coordinates are computed with a few roundings.
    let slack = |value: f64| COORDINATE * value.abs();
    if surface.is_plane() {
        for axis in 0..3 {
            // Of a normal that is turned by less than 1e-8 one coordinate is rounded to 1.
            let turned = surface.linear.reject_from_normalized(DVec3::AXES[axis]);
            if turned.abs().max_element() <= VALUE {
                let at = anchor[axis];
                if surface.linear[axis] > 0.0 {
                    bounds.max[axis] = at + slack(at);
                } else {
                    bounds.min[axis] = at - slack(at);
                }
            }
        }
        return bounds;
    }
    let [xx, yy, zz, xy, yz, zx] = surface.quadratic;
    let squares = DVec3::new(xx, yy, zz);
    let separable = [xy, yz, zx] == [0.0; 3] && surface.linear == DVec3::ZERO;
    if separable && squares.min_element() >= 0.0 && surface.constant < 0.0 {
        for axis in 0..3 {
            if squares[axis] > 0.0 {
                let reach = (-surface.constant / squares[axis]).sqrt();
                let reach = reach + slack(reach) + slack(anchor[axis]);
                bounds.min[axis] = anchor[axis] - reach;
                bounds.max[axis] = anchor[axis] + reach;
            }
        }
    }
    bounds
}
