//! Ready-made profiles.

use glam::{DAffine2, DVec2};

use super::turn::turn;
use super::{Contour, Corner, FillRule, Profile, Shape};
use crate::error::ProfileFault;

/// The bulge of a quarter of a turn: the tangent of its quarter.
const QUARTER: f64 = std::f64::consts::SQRT_2 - 1.0;

fn positive(what: &'static str, value: f64) -> Result<f64, ProfileFault> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(ProfileFault::NotPositive { what, value })
    }
}

/// Ready-made profiles, centred at the origin where nothing else is said.
/// Lengths must be positive and finite.
impl Profile {
    /// A disc.
    #[must_use]
    pub fn circle(radius: f64) -> Self {
        Self::ellipse([radius; 2])
    }

    /// An ellipse with semi-axes along x and y.
    #[must_use]
    pub fn ellipse(radii: impl Into<DVec2>) -> Self {
        let radii = radii.into();
        Self::of((|| {
            positive("a radius", radii.x)?;
            positive("a radius", radii.y)?;
            Ok(Self::shape(Shape::Disc, DAffine2::from_scale(radii)))
        })())
    }

    /// A rectangle of the given side lengths.
    #[must_use]
    pub fn rectangle(sides: impl Into<DVec2>) -> Self {
        let half = sides.into() * 0.5;
        Self::rectangle_between(-half, half)
    }

    /// The rectangle from its least to its greatest corner.
    #[must_use]
    pub fn rectangle_between(min: impl Into<DVec2>, max: impl Into<DVec2>) -> Self {
        let (min, max) = (min.into(), max.into());
        Self::of((|| {
            positive("a side", max.x - min.x)?;
            positive("a side", max.y - min.y)?;
            let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
            Ok(Self::contour(corners.map(Corner::straight).to_vec()))
        })())
    }

    /// A rectangle of the given side lengths with its corners rounded: at most
    /// half the shorter side, which makes its ends half circles.
    #[must_use]
    pub fn rounded_rectangle(sides: impl Into<DVec2>, radius: f64) -> Self {
        let half = sides.into() * 0.5;
        Self::of((|| {
            positive("a side", 2.0 * half.x)?;
            positive("a side", 2.0 * half.y)?;
            positive("the radius", radius)?;
            let limit = half.min_element();
            if radius > limit {
                return Err(ProfileFault::TooLarge {
                    what: "the radius",
                    value: radius,
                    limit,
                });
            }
            let inner = half - radius;
            let mut corners = Vec::with_capacity(8);
            for k in 0..4 {
                let (from, to) = (turn(3 + k, 4), turn(k, 4));
                // Of the quarters only the signs differ.
                let sign = turn(2 * k + 7, 8).signum();
                for (direction, bulge) in [(from, QUARTER), (to, 0.0)] {
                    let point = sign * inner + direction * radius;
                    corners.push(Corner::arc(point, bulge));
                }
            }
            Ok(Self::contour(corners))
        })())
    }

    /// A regular polygon with its corners on a circle, the first on +x.
    #[must_use]
    pub fn regular_polygon(corners: usize, circumradius: f64) -> Self {
        Self::of((|| {
            positive("the radius", circumradius)?;
            if corners < 3 {
                return Err(ProfileFault::TooFewCorners { corners });
            }
            let corner = |k| Corner::straight(circumradius * turn(k, corners));
            Ok(Self::contour((0..corners).map(corner).collect()))
        })())
    }

    /// All points within `radius` of a stretch of the x axis of the given
    /// length: a rectangle with a half circle at either end.
    #[must_use]
    pub fn slot(length: f64, radius: f64) -> Self {
        Self::of((|| {
            positive("the length", length)?;
            positive("the radius", radius)?;
            Ok(Self::rounded_rectangle(
                [length + 2.0 * radius, 2.0 * radius],
                radius,
            ))
        })())
    }

    /// What one closed polygon encloses by the even-odd rule; it may cross
    /// itself.
    #[must_use]
    pub fn polygon<P: Into<DVec2>>(corners: impl IntoIterator<Item = P>) -> Self {
        Self::polygons_of([corners], FillRule::EvenOdd)
    }

    /// What several closed polygons enclose by a rule; they may cross.
    #[must_use]
    pub fn polygons_of<P: Into<DVec2>, C: IntoIterator<Item = P>>(
        contours: impl IntoIterator<Item = C>,
        rule: FillRule,
    ) -> Self {
        let contours: Vec<Contour> = contours
            .into_iter()
            .map(|corners| {
                let points = corners.into_iter().map(Into::into);
                points.map(Corner::straight).collect()
            })
            .collect();
        if let Some(short) = contours.iter().find(|contour| contour.len() < 3) {
            let corners = short.len();
            return Self::faulty(ProfileFault::TooFewCorners { corners });
        }
        Self::shape(Shape::Contours(contours.into(), rule), DAffine2::IDENTITY)
    }

    pub(super) fn contour(contour: Contour) -> Self {
        Self::shape(
            Shape::Contours([contour].into(), FillRule::EvenOdd),
            DAffine2::IDENTITY,
        )
    }
}
