//! Where what is measured is drawn in the picture.

use glam::DVec3;
use serde::Serialize;

/// What is measured where: in the model's unit, directions of unit length.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[non_exhaustive]
pub enum Dimension {
    /// A distance.
    Distance {
        /// From where to where.
        ends: [DVec3; 2],
    },
    /// An angle.
    Angle {
        /// Its vertex.
        at: DVec3,
        /// Its sides.
        along: [DVec3; 2],
    },
    /// The radius of a circle.
    Circle {
        /// The centre; of a cylinder's face those at its two ends.
        centers: [DVec3; 2],
        /// The axis.
        axis: DVec3,
    },
    /// The radius of a sphere.
    Sphere {
        /// The centre.
        center: DVec3,
    },
}

impl Dimension {
    /// A distance that is more than nothing.
    pub(crate) fn distance(from: DVec3, to: DVec3) -> Option<Self> {
        let ends = [from, to];
        (from.distance(to) > 0.0).then_some(Self::Distance { ends })
    }
}
