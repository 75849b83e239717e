//! A contour drawn side by side.

use crate::elementary;
use glam::DVec2;

use super::monotone::orient;
use super::{Corner, Profile};
use crate::error::ProfileFault;
use crate::numeric::tolerance::IN_PROFILE;

/// A closed contour of lines and arcs, drawn side by side; the last side back
/// to the start is added where it is missing. It must not cross itself.
///
/// ```
/// use csg::{Path, Profile};
///
/// // A door: a rectangle with a half circle on top.
/// let door = Path::from([0.0, 0.0])
///     .line_to([2.0, 0.0])
///     .line_to([2.0, 3.0])
///     .arc_through([1.0, 4.0], [0.0, 3.0])
///     .close();
/// let area = 6.0 + std::f64::consts::FRAC_PI_2;
/// assert!((door.area(1e-9)? - area).abs() < 1e-8);
/// # Ok::<(), csg::ProfileFault>(())
/// ```
#[derive(Clone, Debug)]
pub struct Path {
    corners: Vec<Corner>,
    fault: Option<ProfileFault>,
}

impl Path {
    /// A path that starts at a point.
    #[must_use]
    pub fn from(start: impl Into<DVec2>) -> Self {
        Self {
            corners: vec![Corner::straight(start.into())],
            fault: None,
        }
    }

    /// A straight side.
    #[must_use]
    pub fn line_to(self, end: impl Into<DVec2>) -> Self {
        self.arc_to(end, 0.0)
    }

    /// An arc that turns through an angle in radians, counter-clockwise
    /// positive, less than a whole turn either way.
    #[must_use]
    pub fn arc_to(mut self, end: impl Into<DVec2>, radians: f64) -> Self {
        let limit = std::f64::consts::TAU;
        if radians.is_nan() || radians.abs() >= limit {
            self.fault.get_or_insert(ProfileFault::TooLarge {
                what: "the angle of an arc",
                value: radians,
                limit,
            });
        } else if let Some(last) = self.corners.last_mut() {
            last.bulge = elementary::tan(radians / 4.0);
            self.corners.push(Corner::straight(end.into()));
        }
        self
    }

    /// The arc that passes through a point on its way; a straight side if the
    /// three points lie on a line.
    #[must_use]
    pub fn arc_through(self, middle: impl Into<DVec2>, end: impl Into<DVec2>) -> Self {
        let (middle, end) = (middle.into(), end.into());
        let start = self.end();
        // Half the arc's angle is what the directions to and from the middle
        // turn through.
        let (to, from) = (middle - start, end - middle);
        if orient(start, middle, end) == 0.0 {
            return self.line_to(end);
        }
        let half = elementary::atan2(to.perp_dot(from), to.dot(from));
        self.arc_to(end, 2.0 * half)
    }

    /// A quadratic Bézier curve, as chords that stray at most `tolerance`.
    #[must_use]
    pub fn quadratic_to(
        self,
        control: impl Into<DVec2>,
        end: impl Into<DVec2>,
        tolerance: f64,
    ) -> Self {
        let (start, control, end) = (self.end(), control.into(), end.into());
        // As a cubic it is the same curve.
        let first = start.lerp(control, 2.0 / 3.0);
        let second = end.lerp(control, 2.0 / 3.0);
        self.cubic_to(first, second, end, tolerance)
    }

    /// A cubic Bézier curve, as chords that stray at most `tolerance`: a chord
    /// over 1/n of the parameter strays at most a (2n)⁻² share of half the
    /// greatest second derivative, which is 6 times the greatest second
    /// difference of the control points.
    #[must_use]
    pub fn cubic_to(
        mut self,
        first: impl Into<DVec2>,
        second: impl Into<DVec2>,
        end: impl Into<DVec2>,
        tolerance: f64,
    ) -> Self {
        const MOST: f64 = 1e4;
        let start = self.end();
        let (first, second, end) = (first.into(), second.into(), end.into());
        if tolerance.is_nan() || tolerance <= 0.0 {
            let what = "the tolerance of a curve";
            self.fault.get_or_insert(ProfileFault::NotPositive {
                what,
                value: tolerance,
            });
            return self;
        }
        let bend = (start - 2.0 * first + second)
            .length()
            .max((first - 2.0 * second + end).length());
        let count = (0.75 * bend / tolerance).sqrt().ceil().clamp(1.0, MOST);
        for k in 1..=count as usize {
            let t = k as f64 / count;
            let s = 1.0 - t;
            let inner = 3.0 * s * t * (s * first + t * second);
            self = self.line_to(s * s * s * start + inner + t * t * t * end);
        }
        self
    }

    /// What the path encloses.
    #[must_use]
    pub fn close(mut self) -> Profile {
        if let Some(fault) = self.fault {
            return Profile::faulty(fault);
        }
        let (start, end) = (self.corners[0].point, self.end());
        let size = self.corners.iter().map(|c| c.point.abs().max_element());
        // Back where it began, but for rounding.
        if self.corners.len() > 1 && start.distance(end) <= IN_PROFILE * size.fold(0.0, f64::max) {
            self.corners.pop();
        }
        let corners = self.corners.len();
        let has_arc = self.corners.iter().any(|corner| corner.bulge != 0.0);
        if corners < if has_arc { 2 } else { 3 } {
            return Profile::faulty(ProfileFault::TooFewCorners { corners });
        }
        Profile::contour(self.corners)
    }

    fn end(&self) -> DVec2 {
        self.corners
            .last()
            .map_or(DVec2::ZERO, |corner| corner.point)
    }
}
