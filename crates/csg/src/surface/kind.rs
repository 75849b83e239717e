//! The affine types of quadrics, decided once.
//!
//! Whether a form has a value 0, whether a surface goes through its centre: rounding hides
//! that, and no threshold finds it again. A primitive knows what it is; of ten coefficients
//! it is asked once, when the solid is lowered. Affine maps keep it.

use serde::{Deserialize, Serialize};

use crate::error::NodeFault;

/// What a surface is, up to an affine map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Kind {
    /// x = 0.
    Plane,
    /// x² + y² + z² = 1.
    Ellipsoid,
    /// x² + y² - z² = 1.
    HyperboloidOneSheet,
    /// x² + y² - z² = -1.
    HyperboloidTwoSheets,
    /// x² + y² - z² = 0.
    Cone,
    /// x² + y² = z.
    EllipticParaboloid,
    /// x² - y² = z.
    HyperbolicParaboloid,
    /// x² + y² = 1.
    EllipticCylinder,
    /// x² - y² = 1.
    HyperbolicCylinder,
    /// x² = z.
    ParabolicCylinder,
    /// x² = 1.
    ParallelPlanes,
}

impl Kind {
    /// The kind of a quadric by how many values of its quadratic form are positive and negative,
    /// and by what is left beside it: a slope that no centre takes away, or else the value
    /// at the centre.
    pub(crate) fn of_signature(
        (positive, negative): (usize, usize),
        has_slope: bool,
        at_center: f64,
    ) -> Result<Self, NodeFault> {
        // f and -f are 0 in the same points.
        let (most, least, rest) = if positive >= negative {
            (positive, negative, at_center)
        } else {
            (negative, positive, -at_center)
        };
        Ok(match (most, least) {
            (1, 0) if has_slope => Self::ParabolicCylinder,
            (1, 1) if has_slope => Self::HyperbolicParaboloid,
            (2, 0) if has_slope => Self::EllipticParaboloid,
            (1, 1) if rest == 0.0 => return Err(NodeFault::QuadricOfCrossingPlanes),
            (1, 1) => Self::HyperbolicCylinder,
            (2, 1) if rest == 0.0 => Self::Cone,
            (2, 1) if rest > 0.0 => Self::HyperboloidTwoSheets,
            (2, 1) => Self::HyperboloidOneSheet,
            (1, 0) if rest < 0.0 => Self::ParallelPlanes,
            (2, 0) if rest < 0.0 => Self::EllipticCylinder,
            (3, 0) if rest < 0.0 => Self::Ellipsoid,
            _ => return Err(NodeFault::QuadricWithoutSurface),
        })
    }

    /// How many values of the quadratic form are not 0.
    pub fn rank(self) -> usize {
        match self {
            Self::Plane => 0,
            Self::ParabolicCylinder | Self::ParallelPlanes => 1,
            Self::EllipticParaboloid
            | Self::HyperbolicParaboloid
            | Self::EllipticCylinder
            | Self::HyperbolicCylinder => 2,
            Self::Ellipsoid
            | Self::HyperboloidOneSheet
            | Self::HyperboloidTwoSheets
            | Self::Cone => 3,
        }
    }

    /// Whether the quadratic form takes both signs.
    pub fn is_indefinite(self) -> bool {
        matches!(
            self,
            Self::HyperboloidOneSheet
                | Self::HyperboloidTwoSheets
                | Self::Cone
                | Self::HyperbolicParaboloid
                | Self::HyperbolicCylinder
        )
    }

    /// Whether f of a quadric has a slope that no centre takes away.
    pub(crate) fn has_slope(self) -> bool {
        matches!(
            self,
            Self::EllipticParaboloid | Self::HyperbolicParaboloid | Self::ParabolicCylinder
        )
    }
}
