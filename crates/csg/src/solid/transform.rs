//! The transforms: every one an affine map held in the tree.

use crate::elementary;
use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::tree::{Node, Solid};
use crate::error::NodeFault;

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

impl Axis {
    /// 0, 1 or 2.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }
}

/// The matrix, for column vectors, that adds `factor` times the coordinate along
/// `by` to the coordinate along `moved`; its inverse is that of `-factor`. Of one
/// axis twice it is a scaling.
#[must_use]
pub fn shear_matrix(moved: Axis, by: Axis, factor: f64) -> DMat3 {
    let mut columns = DMat3::IDENTITY.to_cols_array_2d();
    columns[by.index()][moved.index()] = factor;
    DMat3::from_cols_array_2d(&columns)
}

/// A unit vector along `direction`, or the fault that it has none.
fn unit(direction: DVec3, what: &'static str) -> Result<DVec3, NodeFault> {
    if !direction.is_finite() {
        return Err(NodeFault::NotFinite { what });
    }
    // Scaled first, so that neither tiny nor huge vectors lose their direction.
    let scaled = direction / direction.abs().max_element();
    scaled
        .try_normalize()
        .ok_or(NodeFault::ZeroDirection { what })
}

/// The map x -> F diag(1, .., factor) Fᵀ x that scales by `factor` along the
/// unit vector `direction` and by 1 across: I + (factor - 1) d dᵀ.
fn scaling_along(direction: DVec3, factor: f64) -> DMat3 {
    let d = direction * (factor - 1.0);
    DMat3::IDENTITY + DMat3::from_cols(d * direction.x, d * direction.y, d * direction.z)
}

/// `map` with `point` instead of the origin as its fixed point.
fn about(point: DVec3, map: DMat3) -> DAffine3 {
    DAffine3 {
        matrix3: map,
        translation: point - map * point,
    }
}

/// The most that one rotation about an axis may turn: two turns. What turns
/// further was most likely meant in degrees.
const MOST_RADIANS: f64 = 4.0 * std::f64::consts::PI;

/// The angle, unless it is too large to be meant in radians.
fn radians(angle: f64) -> Result<f64, NodeFault> {
    if angle.abs() > MOST_RADIANS && angle.is_finite() {
        Err(NodeFault::AngleInDegrees { value: angle })
    } else {
        Ok(angle)
    }
}

/// Transforms. Angles are in radians where the name does not say degrees,
/// counter-clockwise seen against the axis, and at most two turns: `rotate_z(90.0)`
/// is a mistake. Lowering reports that, singular or non-finite maps and zero
/// directions.
impl Solid {
    fn transform(&self, map: Result<DAffine3, NodeFault>) -> Self {
        Self::from_node(Node::Transform(map, self.clone()))
    }

    fn linear(&self, map: Result<DMat3, NodeFault>) -> Self {
        self.transform(map.map(DAffine3::from_mat3))
    }

    /// Any invertible affine map.
    #[must_use]
    pub fn affine(&self, map: DAffine3) -> Self {
        self.transform(Ok(map))
    }

    /// Moves by `offset`.
    #[must_use]
    pub fn translate(&self, offset: impl Into<DVec3>) -> Self {
        self.affine(DAffine3::from_translation(offset.into()))
    }

    /// Moves along x, y and z.
    #[must_use]
    pub fn translate_xyz(&self, x: f64, y: f64, z: f64) -> Self {
        self.translate([x, y, z])
    }

    /// Rotates about the x axis by an angle in radians.
    #[must_use]
    pub fn rotate_x(&self, angle: f64) -> Self {
        self.linear(radians(angle).map(elementary::rotation_x))
    }

    /// Rotates about the x axis by an angle in degrees.
    #[must_use]
    pub fn rotate_x_degrees(&self, degrees: f64) -> Self {
        self.linear(Ok(elementary::rotation_x(degrees.to_radians())))
    }

    /// Rotates about the y axis by an angle in radians.
    #[must_use]
    pub fn rotate_y(&self, angle: f64) -> Self {
        self.linear(radians(angle).map(elementary::rotation_y))
    }

    /// Rotates about the y axis by an angle in degrees.
    #[must_use]
    pub fn rotate_y_degrees(&self, degrees: f64) -> Self {
        self.linear(Ok(elementary::rotation_y(degrees.to_radians())))
    }

    /// Rotates about the z axis by an angle in radians.
    #[must_use]
    pub fn rotate_z(&self, angle: f64) -> Self {
        self.linear(radians(angle).map(elementary::rotation_z))
    }

    /// Rotates about the z axis by an angle in degrees.
    #[must_use]
    pub fn rotate_z_degrees(&self, degrees: f64) -> Self {
        self.linear(Ok(elementary::rotation_z(degrees.to_radians())))
    }

    /// Rotates by Euler angles: about z by `roll`, then about x by `pitch`, then
    /// about y by `heading`: Ry(heading) Rx(pitch) Rz(roll).
    #[must_use]
    pub fn rotate_euler(&self, heading: f64, pitch: f64, roll: f64) -> Self {
        let turn = elementary::rotation_y(heading) * elementary::rotation_x(pitch);
        self.linear(Ok(turn * elementary::rotation_z(roll)))
    }

    /// Rotates about an axis through the origin by an angle in radians.
    #[must_use]
    pub fn rotate_about_axis(&self, axis: impl Into<DVec3>, angle: f64) -> Self {
        let axis = unit(axis.into(), "the rotation axis");
        self.linear(axis.and_then(|axis| Ok(elementary::rotation(axis, radians(angle)?))))
    }

    /// Rotates about an axis through the origin by an angle in degrees.
    #[must_use]
    pub fn rotate_about_axis_degrees(&self, axis: impl Into<DVec3>, degrees: f64) -> Self {
        let axis = unit(axis.into(), "the rotation axis");
        self.linear(axis.map(|axis| elementary::rotation(axis, degrees.to_radians())))
    }

    /// Rotates about an axis through `point`.
    #[must_use]
    pub fn rotate_about_line(
        &self,
        point: impl Into<DVec3>,
        axis: impl Into<DVec3>,
        angle: f64,
    ) -> Self {
        let point = point.into();
        self.transform(
            unit(axis.into(), "the rotation axis")
                .map(|axis| about(point, elementary::rotation(axis, angle))),
        )
    }

    /// Rotates by the smallest angle that takes the direction `from` to `to`;
    /// for opposite directions about some axis across them.
    #[must_use]
    pub fn rotate_from_to(&self, from: impl Into<DVec3>, to: impl Into<DVec3>) -> Self {
        let from = unit(from.into(), "the direction rotated from");
        let to = unit(to.into(), "the direction rotated to");
        self.linear(from.and_then(|from| Ok(DMat3::from_quat(DQuat::from_rotation_arc(from, to?)))))
    }

    /// Rotates by a quaternion of any positive length.
    #[must_use]
    pub fn rotate_by(&self, rotation: DQuat) -> Self {
        let fault = NodeFault::ZeroDirection {
            what: "the quaternion",
        };
        let unit = rotation.normalize();
        self.linear(if unit.is_finite() {
            Ok(DMat3::from_quat(unit))
        } else {
            Err(fault)
        })
    }

    /// Rotates about the fixed x axis, then y, then z.
    #[must_use]
    pub fn rotate_xyz(&self, x: f64, y: f64, z: f64) -> Self {
        self.linear(Ok(elementary::rotation_z(z)
            * elementary::rotation_y(y)
            * elementary::rotation_x(x)))
    }

    /// Rotates about the fixed z axis, then y, then x.
    #[must_use]
    pub fn rotate_zyx(&self, z: f64, y: f64, x: f64) -> Self {
        self.linear(Ok(elementary::rotation_x(x)
            * elementary::rotation_y(y)
            * elementary::rotation_z(z)))
    }

    /// Rotates about the fixed z axis by `first`, then x, then z again: the
    /// classical Euler angles, in fixed axes.
    #[must_use]
    pub fn rotate_zxz(&self, first: f64, x: f64, last: f64) -> Self {
        self.linear(Ok(elementary::rotation_z(last)
            * elementary::rotation_x(x)
            * elementary::rotation_z(first)))
    }

    /// Scales all lengths from the origin. A negative factor mirrors in the
    /// origin.
    #[must_use]
    pub fn scale(&self, factor: f64) -> Self {
        self.scale_xyz([factor; 3])
    }

    /// Scales along each axis from the origin.
    #[must_use]
    pub fn scale_xyz(&self, factors: impl Into<DVec3>) -> Self {
        self.linear(Ok(DMat3::from_diagonal(factors.into())))
    }

    /// Scales along each axis with `point` staying where it is.
    #[must_use]
    pub fn scale_about(&self, point: impl Into<DVec3>, factors: impl Into<DVec3>) -> Self {
        self.affine(about(point.into(), DMat3::from_diagonal(factors.into())))
    }

    /// Scales along one direction from the origin, not across it.
    #[must_use]
    pub fn scale_along(&self, direction: impl Into<DVec3>, factor: f64) -> Self {
        self.linear(
            unit(direction.into(), "the direction of scaling").map(|d| scaling_along(d, factor)),
        )
    }

    /// Shears: adds `factor` times the coordinate along `by` to the
    /// coordinate along `moved`. The two axes must differ.
    #[must_use]
    pub fn shear(&self, moved: Axis, by: Axis, factor: f64) -> Self {
        if moved == by {
            return self.transform(Err(NodeFault::ShearAlongItself));
        }
        self.linear(Ok(shear_matrix(moved, by, factor)))
    }

    /// Mirrors in the plane through `point` with the given normal.
    #[must_use]
    pub fn mirror(&self, point: impl Into<DVec3>, normal: impl Into<DVec3>) -> Self {
        let point = point.into();
        self.transform(
            unit(normal.into(), "the mirror's normal")
                .map(|normal| about(point, scaling_along(normal, -1.0))),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn map_of(solid: &Solid) -> DAffine3 {
        match solid.node() {
            Node::Transform(Ok(map), _) => *map,
            other => panic!("not a valid transform: {other:?}"),
        }
    }

    fn assert_maps(solid: &Solid, from: [f64; 3], to: [f64; 3]) {
        let image = map_of(solid).transform_point3(from.into());
        assert!(
            image.distance(to.into()) < 1e-12,
            "{from:?} goes to {image}, not {to:?}"
        );
    }

    #[test]
    fn transforms_move_known_points() {
        let s = Solid::sphere(1.0);
        let q = FRAC_PI_2;
        assert_maps(&s.translate([1.0, 2.0, 3.0]), [1.0; 3], [2.0, 3.0, 4.0]);
        assert_maps(&s.translate_xyz(1.0, 2.0, 3.0), [1.0; 3], [2.0, 3.0, 4.0]);
        assert_maps(&s.rotate_x_degrees(90.0), [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_maps(&s.rotate_y_degrees(90.0), [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        assert_maps(&s.rotate_z_degrees(90.0), [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        assert_maps(
            &s.rotate_about_axis_degrees([0.0, 0.0, 5.0], 450.0),
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
        );
        assert_maps(&s.rotate_x(q), [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_maps(&s.rotate_y(q), [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        assert_maps(&s.rotate_z(q), [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        assert_maps(
            &s.rotate_about_axis([0.0, 0.0, 5.0], q),
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
        );
        assert_maps(
            &s.rotate_about_line([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], q),
            [2.0, 0.0, 7.0],
            [1.0, 1.0, 7.0],
        );
        assert_maps(
            &s.rotate_from_to([0.0, 0.0, 2.0], [3.0, 0.0, 0.0]),
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0],
        );
        assert_maps(
            &s.rotate_from_to([0.0, 0.0, 2.0], [0.0, 0.0, -1.0]),
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        );
        // x first: (0,1,0) -> (0,0,1) by x, -> (1,0,0) by y, -> (0,1,0) by z.
        assert_maps(&s.rotate_xyz(q, q, q), [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]);
        // z first: (1,0,0) -> (0,1,0) by z, stays by y, -> (0,0,1) by x.
        assert_maps(&s.rotate_zyx(q, q, q), [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        // (1,0,0) -> (0,1,0) by z, -> (0,0,1) by x, stays by z.
        assert_maps(&s.rotate_zxz(q, q, q), [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        assert_maps(
            &s.rotate_by(DQuat::from_rotation_z(q) * 3.0),
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
        );
        assert_maps(&s.scale(-2.0), [1.0, 2.0, 3.0], [-2.0, -4.0, -6.0]);
        assert_maps(
            &s.scale_about([1.0; 3], [2.0, 3.0, 4.0]),
            [2.0, 2.0, 2.0],
            [3.0, 4.0, 5.0],
        );
        assert_maps(
            &s.scale_along([1.0, 1.0, 0.0], 3.0),
            [1.0, 1.0, 1.0],
            [3.0, 3.0, 1.0],
        );
        assert_maps(
            &s.scale_along([1.0, 1.0, 0.0], 3.0),
            [1.0, -1.0, 0.0],
            [1.0, -1.0, 0.0],
        );
        assert_maps(
            &s.shear(Axis::X, Axis::Z, 0.5),
            [1.0, 1.0, 2.0],
            [2.0, 1.0, 2.0],
        );
        assert_maps(
            &s.mirror([0.0, 0.0, 1.0], [0.0, 0.0, -4.0]),
            [1.0, 2.0, 3.0],
            [1.0, 2.0, -1.0],
        );
    }

    #[test]
    fn bad_directions_are_faults() {
        let s = Solid::sphere(1.0);
        for bad in [
            s.rotate_about_axis([0.0; 3], 1.0),
            // Degrees where radians are asked for.
            s.rotate_x(90.0),
            s.rotate_y(-30.0),
            s.rotate_z(45.0),
            s.rotate_about_axis([0.0, 0.0, 1.0], 180.0),
            s.rotate_about_axis([f64::NAN, 0.0, 0.0], 1.0),
            s.rotate_about_line([0.0; 3], [0.0; 3], 1.0),
            s.rotate_from_to([0.0; 3], [1.0; 3]),
            s.rotate_from_to([1.0; 3], [0.0; 3]),
            s.rotate_by(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
            s.scale_along([0.0; 3], 2.0),
            s.mirror([0.0; 3], [0.0; 3]),
            s.shear(Axis::X, Axis::X, 2.0),
        ] {
            assert!(matches!(bad.node(), Node::Transform(Err(_), _)), "{bad:?}");
        }
        // Neither tiny nor huge axes are zero.
        for length in [1e-300, 1e300] {
            let turned = s.rotate_about_axis([0.0, 0.0, length], FRAC_PI_2);
            assert_maps(&turned, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        }
    }
}
