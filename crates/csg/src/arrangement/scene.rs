//! What all blocks have in common.

use glam::{DVec2, DVec3};

use super::frame::Frame;
use super::piece::Side;
use crate::control::Control;
use crate::numeric::tolerance::{NEAR, SAME_BEND, TOUCHING_REACH};
use crate::program::Surface;
use crate::undecided::Stop;

/// n·x - offset, at most 0 inside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub normal: DVec3,
    pub offset: f64,
}

impl Plane {
    pub fn of(surface: &Surface) -> Self {
        Self {
            normal: surface.linear,
            offset: surface.linear.dot(surface.anchor),
        }
    }

    pub fn value(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// What all blocks have in common.
pub(super) struct Scene<'a> {
    pub surfaces: &'a [Surface],
    pub planes: &'a [Plane],
    /// For each curved surface its frame, if it has one.
    pub frames: &'a [Option<Frame>],
    /// For each primitive the first that looks like it.
    pub looks: &'a [u32],
    pub on_plane: f64,
    pub near: f64,
    /// No point of the solid is farther from the origin.
    pub reach: f64,
    pub weld: f64,
    /// Distances that rounding may make.
    pub rounding: f64,
    pub control: &'a Control,
}

impl Scene<'_> {
    /// Whether the caller wants more.
    pub fn go_on(&self) -> Result<(), Stop> {
        self.control.check().map_err(|_| Stop::Halted)
    }

    /// Curvatures that differ by less are the same: those of curves that over the
    /// length of the scene part by less than what is near.
    pub fn same_bend(&self) -> f64 {
        SAME_BEND * NEAR / self.near
    }

    /// Next to where surfaces touch, points nearer to each other may not be told apart:
    /// where a curve touches a surface to the fourth order, the place is known to a
    /// quarter of the digits.
    pub fn touching_reach(&self) -> f64 {
        TOUCHING_REACH * self.weld
    }

    /// By how much rounding may move points of a surface before its values are to be
    /// known to more digits.
    pub fn blur(&self) -> f64 {
        4.0 * self.rounding
    }

    /// The point common to three planes, the same to the bit in whatever order
    /// they are named.
    pub fn common_point(&self, mut ids: [u32; 3]) -> DVec3 {
        ids.sort_unstable();
        let planes = ids.map(|id| self.planes[id as usize]);
        let [p, q, r] = planes.map(|plane| plane.normal);
        let crosses = [q.cross(r), r.cross(p), p.cross(q)];
        let solve = |values: [f64; 3]| {
            (values[0] * crosses[0] + values[1] * crosses[1] + values[2] * crosses[2])
                / p.dot(crosses[0])
        };
        let point = solve(planes.map(|plane| plane.offset));
        // A step of iterative refinement.
        point - solve(planes.map(|plane| plane.value(point)))
    }

    /// A point of a face seen from outside, along the axis that its plane faces
    /// most: no coordinate is rounded.
    pub fn flatten(&self, side: &Side, point: DVec3) -> DVec2 {
        if let Some(frame) = &self.frames[side.plane as usize] {
            return frame.flatten(side.patch, side.along_normal, point);
        }
        let normal = self.planes[side.plane as usize].normal;
        let axis = normal.abs().max_position();
        let (u, v) = (point[(axis + 1) % 3], point[(axis + 2) % 3]);
        if (normal[axis] > 0.0) == side.along_normal {
            DVec2::new(u, v)
        } else {
            DVec2::new(v, u)
        }
    }
}
