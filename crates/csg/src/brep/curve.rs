//! What curve an edge is a piece of.

use crate::elementary;
use glam::{DVec3, DVec4};

use crate::arrangement::{Curve, rational};
use crate::numeric::tolerance::ROUND;

/// A curve as a function of a parameter t, in model units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CurveShape {
    /// point + t direction, which is of unit length.
    Line {
        /// Where t is 0.
        point: DVec3,
        /// Of unit length.
        direction: DVec3,
    },
    /// center + cos t a + sin t b: a circle if a and b are of one length and at right
    /// angles.
    Ellipse {
        /// The centre.
        center: DVec3,
        /// A half of a diameter.
        a: DVec3,
        /// A half of the conjugate diameter.
        b: DVec3,
    },
    /// center + cosh t a + sinh t b, one branch.
    Hyperbola {
        /// The centre.
        center: DVec3,
        /// From the centre to a point of the branch.
        a: DVec3,
        /// The direction of the branch there.
        b: DVec3,
    },
    /// point + (t a + t² b) / (1 + l t + k t²), a and b at right angles: a parabola where
    /// l and k are 0, and else the part near by of a conic whose centre is far away.
    Conic {
        /// Where t is 0.
        point: DVec3,
        /// The direction there.
        a: DVec3,
        /// To which side it bends.
        b: DVec3,
        /// Of t.
        l: f64,
        /// Of t².
        k: f64,
    },
    /// A curve of degree four, in which two quadrics meet. It has no shorter description than
    /// the two surfaces, and its points ([`super::Edge::at`]).
    Quartic,
}

/// The half axes of an ellipse: the long one where t is `turn`, and the short one a quarter of a
/// turn later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfAxes {
    /// From the centre to a farthest point.
    pub long: DVec3,
    /// At right angles to it.
    pub short: DVec3,
    /// The parameter at the end of the long one.
    pub turn: f64,
    /// Whether both are of one length, to rounding.
    pub is_circle: bool,
}

impl CurveShape {
    /// The half axes, of an ellipse.
    ///
    /// cos t a + sin t b = cos(t - turn) long + sin(t - turn) short, where
    /// tan(2 turn) = 2 a·b / (a² - b²).
    #[must_use]
    pub fn half_axes(&self) -> Option<HalfAxes> {
        let Self::Ellipse { a, b, .. } = *self else {
            return None;
        };
        let turn = 0.5 * elementary::atan2(2.0 * a.dot(b), a.length_squared() - b.length_squared());
        let (sin, cos) = elementary::sin_cos(turn);
        let [long, short] = [cos * a + sin * b, cos * b - sin * a];
        Some(HalfAxes {
            long,
            short,
            turn,
            is_circle: long.length() - short.length() <= ROUND * long.length(),
        })
    }

    /// Three control points of a piece as a rational curve of degree two: points times their
    /// weights, and weights. None of lines, curves of degree four, and half of an ellipse or more.
    #[must_use]
    pub fn control(&self, range: [f64; 2]) -> Option<[DVec4; 3]> {
        match *self {
            Self::Line { .. } | Self::Quartic => None,
            Self::Ellipse { center, a, b } => rational::of_ellipse([center, a, b], range),
            Self::Hyperbola { center, a, b } => Some(rational::of_hyperbola([center, a, b], range)),
            Self::Conic { point, a, b, l, k } => {
                Some(rational::of_parabola([point, a, b], [l, k], range))
            }
        }
    }

    pub(super) fn of(curve: &Curve, origin: DVec3) -> Self {
        match *curve {
            Curve::Line { point, direction } => Self::Line {
                point: point + origin,
                direction,
            },
            Curve::Ellipse { center, a, b } => Self::Ellipse {
                center: center + origin,
                a,
                b,
            },
            Curve::Hyperbola { center, a, b } => Self::Hyperbola {
                center: center + origin,
                a,
                b,
            },
            Curve::Parabola { point, a, b, l, k } => Self::Conic {
                point: point + origin,
                a,
                b,
                l,
                k,
            },
            Curve::Rulings(_) => Self::Quartic,
        }
    }
}
