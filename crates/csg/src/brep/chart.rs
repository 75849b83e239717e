//! Coordinates in which a patch of a surface is a graph z(x, y).

use glam::{DMat3, DVec2, DVec3};

use crate::arrangement::{Frame, Side};
use crate::numeric::tolerance::OTHER_SHEET;
use crate::program::Surface;

/// Coordinates in which a patch of a surface is a graph.
pub(super) struct Chart<'a> {
    surface: &'a Surface,
    /// None for planes.
    frame: Option<&'a Frame>,
    patch: u8,
    center: DVec3,
    /// The directions of x, y and z.
    axes: DMat3,
    to_chart: DMat3,
    determinant: f64,
    /// 1 if the gradient points out of the solid, or else -1.
    outward: f64,
    /// 1 if x and y turn counter-clockwise as seen from outside, or else -1.
    turn: f64,
}

impl<'a> Chart<'a> {
    /// Of planes with coordinates about the foot of a point.
    pub fn new(surface: &'a Surface, frame: Option<&'a Frame>, side: &Side, about: DVec3) -> Self {
        let (center, axes, faces) = match frame {
            Some(frame) => frame.chart(side.patch),
            None => {
                let normal = surface.linear;
                let (x, y) = normal.any_orthonormal_pair();
                let foot = about - surface.value(about) * normal;
                (foot, DMat3::from_cols(x, y, normal), true)
            }
        };
        Self {
            surface,
            frame,
            patch: side.patch,
            center,
            axes,
            to_chart: axes.inverse(),
            determinant: axes.determinant(),
            outward: if side.along_normal { 1.0 } else { -1.0 },
            turn: if faces == side.along_normal {
                1.0
            } else {
                -1.0
            },
        }
    }

    /// 1 if x and y turn counter-clockwise as seen from outside, or else -1.
    pub fn turn(&self) -> f64 {
        self.turn
    }

    /// How much x and y may change along a unit of length.
    pub fn per_length(&self) -> f64 {
        let rows = self.to_chart.transpose();
        rows.x_axis.length().max(rows.y_axis.length())
    }

    /// The direction of z, of unit length.
    pub fn view(&self) -> DVec3 {
        self.axes.z_axis.normalize_or_zero()
    }

    pub fn is_flat(&self) -> bool {
        self.frame.is_none()
    }

    /// x and y of a point.
    pub fn flatten(&self, point: DVec3) -> DVec2 {
        (self.to_chart * (point - self.center)).truncate()
    }

    /// The point of the patch at x and y.
    pub fn lift(&self, flat: DVec2) -> DVec3 {
        let point = self.center + self.axes * flat.extend(0.0);
        match self.frame {
            Some(frame) => frame.lift(self.surface, self.patch, point),
            None => point,
        }
    }

    /// Whether a point of the surface that is seen at x and y is on the sheet that the chart
    /// shows, in a scene of this size: the other side of the surface may be seen there.
    pub fn shows(&self, point: DVec3, flat: DVec2, size: f64) -> bool {
        self.lift(flat).distance(point) < OTHER_SHEET * size
    }

    /// The outward normal of the patch at a point of it, as long as its area is to that of
    /// x and y. At an apex, which has none, zero.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        let gradient = self.surface.gradient(point);
        let along = gradient.dot(self.axes.z_axis).abs();
        if along > 0.0 {
            self.outward * self.determinant / along * gradient
        } else {
            DVec3::ZERO
        }
    }
}

/// Whether a point is within closed outlines of straight sides, by the sides that a ray along x
/// crosses.
pub(super) fn is_within(sides: impl Iterator<Item = [DVec2; 2]>, point: DVec2) -> bool {
    let crosses = |[a, b]: &[DVec2; 2]| {
        (a.y > point.y) != (b.y > point.y)
            && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    sides.filter(crosses).count() % 2 == 1
}
