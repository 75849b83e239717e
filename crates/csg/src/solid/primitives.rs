//! The primitives: every one a Boolean combination of half-spaces f(p) <= 0.

use crate::elementary;
use std::ops::Range;

use glam::{DVec2, DVec3};

use super::primitive::{Plane, Primitive};
use super::tree::{Node, Solid};
use crate::surface::{Kind, from_coefficients};

/// Primitives. Sizes must be positive and finite and directions not zero;
/// lowering reports the node where one is not.
impl Solid {
    /// The leaf for `primitive`.
    #[must_use]
    pub fn primitive(primitive: Primitive) -> Self {
        Self::from_node(Node::Primitive(primitive))
    }

    /// All of space.
    #[must_use]
    pub fn space() -> Self {
        Self::primitive(Primitive::Space)
    }

    /// The half-space `normal · p <= offset · |normal|`: `offset` is the
    /// plane's signed distance from the origin along the outward normal.
    #[must_use]
    pub fn half_space(normal: impl Into<DVec3>, offset: f64) -> Self {
        let normal = normal.into();
        let point = normal.normalize() * offset;
        Self::primitive(Primitive::HalfSpace { point, normal })
    }

    /// The half-space behind the plane through `point` with the given outward
    /// normal.
    #[must_use]
    pub fn half_space_through(point: impl Into<DVec3>, normal: impl Into<DVec3>) -> Self {
        Self::primitive(Primitive::HalfSpace {
            point: point.into(),
            normal: normal.into(),
        })
    }

    /// The half-space f(p) <= 0 of a quadric: f = c0 x² + c1 y² + c2 z² +
    /// c3 xy + c4 yz + c5 zx + c6 x + c7 y + c8 z + c9.
    ///
    /// Parallel planes become two half-spaces. Lowering rejects coefficients whose zero set is no
    /// surface (f of one sign, as in x² + 1) or crosses itself along a line (as in xy = 0, which is
    /// two half-spaces to be combined).
    #[must_use]
    pub fn quadric(coefficients: [f64; 10]) -> Self {
        match from_coefficients(coefficients) {
            Ok(surface) if surface.kind == Kind::ParallelPlanes => {
                let form = surface.standard_form();
                let [across, ..] = form.axes;
                let half = form.half_axes()[0] * across;
                let between = Self::half_space_through(form.center + half, across)
                    & Self::half_space_through(form.center - half, -across);
                if form.values[0] > 0.0 {
                    between
                } else {
                    !between
                }
            }
            // (What is wrong with it is said where it is lowered.)
            _ => Self::primitive(Primitive::Quadric(coefficients)),
        }
    }

    /// A cube of the given side, centred at the origin.
    #[must_use]
    pub fn cube(side: f64) -> Self {
        Self::cuboid([side; 3])
    }

    /// A box of the given side lengths, centred at the origin.
    #[must_use]
    pub fn cuboid(sides: impl Into<DVec3>) -> Self {
        let half = sides.into() * 0.5;
        Self::primitive(Primitive::Cuboid {
            min: -half,
            max: half,
        })
    }

    /// The box from its least to its greatest corner.
    #[must_use]
    pub fn cuboid_between(min: impl Into<DVec3>, max: impl Into<DVec3>) -> Self {
        Self::primitive(Primitive::Cuboid {
            min: min.into(),
            max: max.into(),
        })
    }

    /// A sphere around the origin.
    #[must_use]
    pub fn sphere(radius: f64) -> Self {
        Self::ellipsoid([radius; 3])
    }

    /// An ellipsoid around the origin with the given semi-axes.
    #[must_use]
    pub fn ellipsoid(radii: impl Into<DVec3>) -> Self {
        Self::primitive(Primitive::Ellipsoid {
            radii: radii.into(),
        })
    }

    /// A circular cylinder around the z axis, from `z.start` to `z.end`.
    #[must_use]
    pub fn cylinder(radius: f64, z: Range<f64>) -> Self {
        Self::elliptic_cylinder([radius; 2], z)
    }

    /// An infinite circular cylinder around the z axis.
    #[must_use]
    pub fn infinite_cylinder(radius: f64) -> Self {
        Self::infinite_elliptic_cylinder([radius; 2])
    }

    /// An elliptic cylinder around the z axis with semi-axes along x and y.
    #[must_use]
    pub fn elliptic_cylinder(radii: impl Into<DVec2>, z: Range<f64>) -> Self {
        Self::primitive(Primitive::Cylinder {
            radii: radii.into(),
            z: Some(z),
        })
    }

    /// An infinite elliptic cylinder around the z axis.
    #[must_use]
    pub fn infinite_elliptic_cylinder(radii: impl Into<DVec2>) -> Self {
        Self::primitive(Primitive::Cylinder {
            radii: radii.into(),
            z: None,
        })
    }

    /// A cone around the z axis: its base at `z.start`, its apex at `z.end`.
    #[must_use]
    pub fn cone(radius: f64, z: Range<f64>) -> Self {
        Self::frustum(radius, 0.0, z)
    }

    /// A frustum of a cone around the z axis, `bottom` and `top` its radii at
    /// `z.start` and `z.end`; equal radii make a cylinder.
    #[must_use]
    pub fn frustum(bottom: f64, top: f64, z: Range<f64>) -> Self {
        Self::primitive(Primitive::Frustum { bottom, top, z })
    }

    /// The infinite cone (one nappe) with its apex at the origin, opening
    /// towards +z, `half_angle` radians between axis and side, below a right
    /// angle.
    #[must_use]
    pub fn infinite_cone(half_angle: f64) -> Self {
        let slope = if half_angle < std::f64::consts::FRAC_PI_2 {
            elementary::tan(half_angle)
        } else {
            f64::NAN
        };
        Self::primitive(Primitive::InfiniteCone { slope })
    }

    /// The inside of the paraboloid z = (x/a)² + (y/b)², infinite upwards.
    #[must_use]
    pub fn paraboloid(scales: impl Into<DVec2>) -> Self {
        Self::primitive(Primitive::Paraboloid {
            scales: scales.into(),
        })
    }

    /// The inside of the one-sheet hyperboloid (x/a)² + (y/b)² - (z/c)² = 1,
    /// infinite both ways along z.
    #[must_use]
    pub fn hyperboloid_one_sheet(radii: impl Into<DVec3>) -> Self {
        Self::primitive(Primitive::HyperboloidOneSheet {
            radii: radii.into(),
        })
    }

    /// The inside of the two-sheet hyperboloid (z/c)² - (x/a)² - (y/b)² = 1:
    /// two infinite bowls.
    #[must_use]
    pub fn hyperboloid_two_sheets(radii: impl Into<DVec3>) -> Self {
        Self::primitive(Primitive::HyperboloidTwoSheets {
            radii: radii.into(),
        })
    }

    /// The intersection of the half-spaces behind the given planes.
    #[must_use]
    pub fn convex_polyhedron(planes: impl IntoIterator<Item = Plane>) -> Self {
        Self::primitive(Primitive::ConvexPolyhedron(planes.into_iter().collect()))
    }

    /// The right prism over a convex polygon in the xy plane, its corners in
    /// order either way round.
    #[must_use]
    pub fn prism<P: Into<DVec2>>(polygon: impl IntoIterator<Item = P>, z: Range<f64>) -> Self {
        Self::primitive(Primitive::Prism {
            polygon: polygon.into_iter().map(Into::into).collect(),
            z,
        })
    }
}
