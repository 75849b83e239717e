//! A contour drawn side by side.

use crate::elementary;
use glam::{DAffine2, DVec2};

use super::monotone::orient;
use super::parabola::Parabola;
use super::{Contour, Corner, FillRule, Profile, Shape};
use crate::error::ProfileFault;
use crate::numeric::tolerance::IN_PROFILE;

/// A closed contour of lines, arcs and curves, drawn side by side; the last side back
/// to the start is added where it is missing. It may cross itself: what it winds around an even
/// number of times is outside then.
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
            *last = Corner::arc(last.point, elementary::tan(radians / 4.0));
            self.corners.push(Corner::straight(end.into()));
        }
        self
    }

    /// An arc by its bulge, the tangent of a quarter of the angle in radians that it turns through,
    /// counter-clockwise positive: as DXF has it. 0 is a straight side.
    #[must_use]
    pub fn bulge_to(mut self, end: impl Into<DVec2>, bulge: f64) -> Self {
        if !bulge.is_finite() {
            let what = "the bulge of an arc";
            self.fault.get_or_insert(ProfileFault::NotFinite { what });
        } else if let Some(last) = self.corners.last_mut() {
            *last = Corner::arc(last.point, bulge);
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

    /// A quadratic Bézier curve: a piece of a parabola, which stays one. Where contours with
    /// parabolas cross, and in Booleans, offsets, hulls, twists and revolutions, it is chords, as near
    /// as those of ellipses there.
    ///
    /// ```
    /// use csg::{Path, Solid};
    ///
    /// // Between y = x² - 1 and the x axis.
    /// let bowl = Path::from([-1.0, 0.0]).quadratic_to([0.0, -2.0], [1.0, 0.0]).close();
    /// let trough = Solid::extrude(&bowl, 0.0..1.0);
    /// let boundary = csg::Program::lower(&trough)?.boundary(&csg::BoundaryOptions::default())?;
    /// assert!((boundary.measure().volume.value - 4.0 / 3.0).abs() < 1e-13);
    /// # Ok::<(), csg::Error>(())
    /// ```
    #[must_use]
    pub fn quadratic_to(mut self, control: impl Into<DVec2>, end: impl Into<DVec2>) -> Self {
        let (control, end) = (control.into(), end.into());
        if let Some(last) = self.corners.last_mut() {
            let curve = Parabola::new(last.point, control, end);
            if !curve.is_straight() {
                last.bend = curve.bend();
            }
            self.corners.push(Corner::straight(end));
        }
        self
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
    pub fn close(self) -> Profile {
        match self.contour() {
            Ok(contour) => Profile::contour(contour),
            Err(fault) => Profile::faulty(fault),
        }
    }

    fn contour(mut self) -> Result<Contour, ProfileFault> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        let (start, end) = (self.corners[0].point, self.end());
        let size = self.corners.iter().map(|c| c.point.abs().max_element());
        // Back where it began, but for rounding.
        if self.corners.len() > 1 && start.distance(end) <= IN_PROFILE * size.fold(0.0, f64::max) {
            self.corners.pop();
        }
        let corners = self.corners.len();
        let is_bent = !self.corners.iter().all(Corner::is_straight);
        if corners < if is_bent { 2 } else { 3 } {
            return Err(ProfileFault::TooFewCorners { corners });
        }
        Ok(self.corners)
    }

    fn end(&self) -> DVec2 {
        self.corners
            .last()
            .map_or(DVec2::ZERO, |corner| corner.point)
    }
}

impl Profile {
    /// What several closed paths enclose by a rule; they may cross themselves and each other.
    ///
    /// ```
    /// use csg::{FillRule, Path, Profile};
    ///
    /// let ring = [2.0, 1.0].map(|radius| {
    ///     Path::from([radius, 0.0]).bulge_to([-radius, 0.0], 1.0).bulge_to([radius, 0.0], 1.0)
    /// });
    /// let ring = Profile::paths(ring, FillRule::EvenOdd);
    /// let area = ring.exact_area().expect("circles");
    /// assert!((area - 3.0 * std::f64::consts::PI).abs() < 1e-14);
    /// ```
    #[must_use]
    pub fn paths(paths: impl IntoIterator<Item = Path>, rule: FillRule) -> Self {
        let contours = paths.into_iter().map(Path::contour);
        Self::of(contours.collect::<Result<Vec<_>, _>>().map(|contours| {
            Self::shape(Shape::Contours(contours.into(), rule), DAffine2::IDENTITY)
        }))
    }
}
