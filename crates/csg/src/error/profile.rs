//! What can be wrong with a profile.

use glam::DVec2;

/// What is wrong with a profile, or with what is to be made of it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProfileFault {
    /// A number is NaN or infinite.
    #[error("{what} must be finite and not zero: give ordinary numbers")]
    NotFinite {
        /// Which number.
        what: &'static str,
    },
    /// A length is zero, negative, NaN or infinite.
    #[error("{what} is {value}: it must be positive and finite")]
    NotPositive {
        /// Which length.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A length that must not exceed another does.
    #[error("{what} is {value}: it must be at most {limit}")]
    TooLarge {
        /// Which length.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The most it may be.
        limit: f64,
    },
    /// A number outside its range.
    #[error("{what} is {value}: it must be from {} to {}", .range[0], .range[1])]
    OutOfRange {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The least and the most it may be.
        range: [f64; 2],
    },
    /// Fewer corners than a contour needs.
    #[error(
        "a contour of {corners} corners encloses nothing: give at least three, or two with an arc"
    )]
    TooFewCorners {
        /// How many there are.
        corners: usize,
    },
    /// More corners than formulas over infinite lines can serve.
    #[error(
        "{corners} corners in one profile: at most {limit} can be made into a solid; raise the tolerance, or split the profile"
    )]
    TooManyCorners {
        /// How many there are.
        corners: usize,
        /// The most there may be.
        limit: usize,
    },
    /// Contours cross or touch themselves or others in a way that rounding leaves open, or in more
    /// than 20,000 places.
    #[error("the contours cross or touch at about ({:.6}, {:.6}) and elsewhere, and it cannot be told what they enclose: give contours that do not, and combine them with `|`, `&` and `-`", .place.x, .place.y)]
    Crossing {
        /// About where.
        place: DVec2,
    },
    /// The map flattens the plane.
    #[error(
        "the map is singular: a profile cannot be flattened; scale by something other than zero"
    )]
    SingularMap,
    /// A profile to be revolved reaches over the axis.
    #[error(
        "the profile reaches to x = {x} beyond the axis of revolution: keep it at x >= 0, or intersect it with that half-plane"
    )]
    BeyondAxis {
        /// The least x of its points.
        x: f64,
    },
}
