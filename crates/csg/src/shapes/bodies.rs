//! Bodies of boxes, cylinders, cones and balls.

use std::ops::Range;

use glam::DVec3;

use super::{below, positive};
use crate::error::NodeFault;
use crate::solid::profile::Profile;
use crate::solid::{Plane, Solid};

/// The length of an extent along z.
fn height(z: &Range<f64>) -> Result<f64, NodeFault> {
    positive("the height", z.end - z.start)
}

/// Ready-made bodies. Sizes must be positive and finite; lowering reports, by the
/// name of the function, those that are not.
impl Solid {
    /// A torus around the z axis: all points within `minor` of a circle of radius
    /// `major`, which must be larger. (It is not a surface of its own yet: the
    /// circle that is turned becomes 32 chords of the same area, so that the volume
    /// is right, and the surface strays 5e-3 of `minor`.)
    #[must_use]
    pub fn torus(major: f64, minor: f64) -> Self {
        let made = || {
            below("the minor radius", minor, major)?;
            let circle = Profile::circle(minor).translate([major, 0.0]);
            Ok(Self::revolve(&circle))
        };
        Self::shaped("torus", made())
    }

    /// All points within `radius` of a stretch of the z axis.
    #[must_use]
    pub fn capsule(radius: f64, z: Range<f64>) -> Self {
        let made = || {
            positive("the radius", radius)?;
            height(&z)?;
            let ball = |z: f64| Self::sphere(radius).translate([0.0, 0.0, z]);
            let shaft = Self::cylinder(radius, z.clone());
            Ok(Self::union([shaft, ball(z.start), ball(z.end)]))
        };
        Self::shaped("capsule", made())
    }

    /// A hollow cylinder around the z axis, open at both ends.
    #[must_use]
    pub fn tube(outer: f64, inner: f64, z: Range<f64>) -> Self {
        let made = || {
            below("the inner radius", inner, outer)?;
            height(&z)?;
            Ok(Self::cylinder(outer, z) - Self::infinite_cylinder(inner))
        };
        Self::shaped("tube", made())
    }

    /// A box centred at the origin, its edges and corners rounded by balls of a
    /// radius less than half the shortest side.
    #[must_use]
    pub fn rounded_cuboid(sides: impl Into<DVec3>, radius: f64) -> Self {
        let sides = sides.into();
        let made = || {
            for side in sides.to_array() {
                positive("a side", side)?;
            }
            below("the radius", radius, 0.5 * sides.min_element())?;
            let inner = 0.5 * sides - radius;
            let centers = (0..8).map(|k| DVec3::select(upper(k), inner, -inner));
            let centers: Vec<DVec3> = centers.collect();
            let rounded = Self::hull_of_balls(&centers, radius);
            rounded.ok_or(NodeFault::Flat)
        };
        Self::shaped("rounded_cuboid", made())
    }

    /// A box centred at the origin, a strip of width `chamfer` taken off both faces
    /// at every edge, less than half the shortest side.
    #[must_use]
    pub fn chamfered_cuboid(sides: impl Into<DVec3>, chamfer: f64) -> Self {
        let sides = sides.into();
        let made = || {
            for side in sides.to_array() {
                positive("a side", side)?;
            }
            below("the chamfer", chamfer, 0.5 * sides.min_element())?;
            let mut planes = Vec::with_capacity(18);
            for axis in 0..3 {
                for sign in [-1.0, 1.0] {
                    let normal = sign * DVec3::AXES[axis];
                    planes.push(Plane::through(0.5 * sides * normal, normal));
                    for other in [-1.0, 1.0] {
                        let next = other * DVec3::AXES[(axis + 1) % 3];
                        let on_face = 0.5 * sides * (normal + next) - chamfer * next;
                        planes.push(Plane::through(on_face, normal + next));
                    }
                }
            }
            Ok(Self::convex_polyhedron(planes))
        };
        Self::shaped("chamfered_cuboid", made())
    }

    /// A cylinder around the z axis with cones of 45° at both ends: `chamfer` off
    /// its ends and its side, less than the radius and than half the height.
    #[must_use]
    pub fn chamfered_cylinder(radius: f64, z: Range<f64>, chamfer: f64) -> Self {
        let made = || {
            positive("the radius", radius)?;
            below("the chamfer", chamfer, radius.min(0.5 * height(&z)?))?;
            let (low, high) = (z.start + chamfer, z.end - chamfer);
            Ok(Self::union([
                Self::frustum(radius - chamfer, radius, z.start..low),
                Self::cylinder(radius, low..high),
                Self::frustum(radius, radius - chamfer, high..z.end),
            ]))
        };
        Self::shaped("chamfered_cylinder", made())
    }

    /// A cylinder around the z axis with its rims rounded by arcs of `fillet`, less
    /// than the radius and than half the height. (As with [`Solid::torus`] the arcs
    /// become chords.)
    #[must_use]
    pub fn rounded_cylinder(radius: f64, z: Range<f64>, fillet: f64) -> Self {
        let made = || {
            positive("the radius", radius)?;
            let height = height(&z)?;
            below("the fillet", fillet, radius.min(0.5 * height))?;
            // Half of it lies beyond the axis.
            let whole = Profile::rounded_rectangle([2.0 * radius, height], fillet);
            let side = Profile::rectangle_between([0.0, -height], [2.0 * radius, height]);
            let half = (whole & side).translate([0.0, z.start + 0.5 * height]);
            Ok(Self::revolve(&half))
        };
        Self::shaped("rounded_cylinder", made())
    }

    /// A ramp: half of the box from the origin to `sides`, full height at x = 0 and
    /// none at x = `sides.x`.
    #[must_use]
    pub fn wedge(sides: impl Into<DVec3>) -> Self {
        let sides = sides.into();
        let made = || {
            for side in sides.to_array() {
                positive("a side", side)?;
            }
            let slope = Self::half_space_through([sides.x, 0.0, 0.0], [sides.z, 0.0, sides.x]);
            Ok(Self::cuboid_between([0.0; 3], sides) & slope)
        };
        Self::shaped("wedge", made())
    }

    /// A pyramid over a regular polygon around the z axis, its tip at `z.end`; the
    /// first corner of the base is on +x.
    #[must_use]
    pub fn pyramid(corners: usize, circumradius: f64, z: Range<f64>) -> Self {
        let base = Profile::regular_polygon(corners, circumradius);
        let made = height(&z).map(|_| Self::extrude_to_point(&base, z, [0.0, 0.0]));
        Self::shaped("pyramid", made)
    }

    /// A right prism over a regular polygon around the z axis, its first corner on
    /// +x.
    #[must_use]
    pub fn regular_prism(corners: usize, circumradius: f64, z: Range<f64>) -> Self {
        let base = Profile::regular_polygon(corners, circumradius);
        let made = height(&z).map(|_| Self::extrude(&base, z));
        Self::shaped("regular_prism", made)
    }
}

/// Which coordinates of a box's corner are the greater ones.
fn upper(corner: usize) -> glam::BVec3 {
    glam::BVec3::from_array([1, 2, 4].map(|bit| corner & bit != 0))
}
