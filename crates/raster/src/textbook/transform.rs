//! Elementary transforms, for column vectors and right-handed axes.
//!
//! glam has the common ones; here are those that textbooks add, with their
//! cheap inverses. Points move under translation, directions do not: that is
//! what [`point`] and [`direction`] say, w = 1 and w = 0.

use csg::Axis;
use glam::{DMat3, DMat4, DVec3, DVec4, Vec4Swizzles};

pub use crate::euler::{EulerOrder, GimbalLock};

/// A point in homogeneous coordinates: w = 1.
#[must_use]
pub fn point(p: DVec3) -> DVec4 {
    p.extend(1.0)
}

/// A direction in homogeneous coordinates: w = 0.
#[must_use]
pub fn direction(d: DVec3) -> DVec4 {
    d.extend(0.0)
}

/// The position of a point in homogeneous coordinates, (x, y, z) / w; `None` for
/// w = 0, a point at infinity.
#[must_use]
pub fn cartesian(p: DVec4) -> Option<DVec3> {
    (p.w != 0.0).then(|| p.truncate() / p.w)
}

/// The direction from `from` to `to`, up to a factor, without a division:
/// w0 P1 - w1 P0, whose w is 0.
#[must_use]
pub fn homogeneous_difference(to: DVec4, from: DVec4) -> DVec4 {
    to * from.w - from * to.w
}

/// The matrix for row vectors, v' = v M, that does what `m` does for column
/// vectors, v' = M v: its transpose. Products are then in the opposite order.
#[must_use]
pub fn for_row_vectors(m: DMat4) -> DMat4 {
    m.transpose()
}

/// The same for row vectors with w in front, (W X Y Z): rows and columns are
/// moved on by one.
#[must_use]
pub fn for_row_vectors_w_first(m: DMat4) -> DMat4 {
    let rows = m.transpose();
    let [x, y, z, w] = [rows.x_axis, rows.y_axis, rows.z_axis, rows.w_axis].map(DVec4::wxyz);
    DMat4::from_cols(w, x, y, z)
}

/// The sixteen numbers in the order in which OpenGL takes them: column by
/// column, so that an array written row by row looks transposed.
#[must_use]
pub fn opengl_array(m: DMat4) -> [f64; 16] {
    m.to_cols_array()
}

/// Coordinates with respect to one orthonormal frame to those with respect to
/// another: the scalar products of their axes, the columns of `from` and `to`.
#[must_use]
pub fn change_of_basis(from: DMat3, to: DMat3) -> DMat3 {
    to.transpose() * from
}

/// Translation by `offset`; its inverse is the translation by `-offset`.
#[must_use]
pub fn translation(offset: DVec3) -> DMat4 {
    DMat4::from_translation(offset)
}

/// Scaling about the origin; its inverse scales by the reciprocals.
#[must_use]
pub fn scaling(factors: DVec3) -> DMat4 {
    DMat4::from_scale(factors)
}

/// Scaling about `centre`, which stays where it is.
#[must_use]
pub fn scaling_about(centre: DVec3, factors: DVec3) -> DMat4 {
    translation(centre) * scaling(factors) * translation(-centre)
}

/// Scaling along the axes of an orthonormal frame, the columns of `frame`:
/// F S Fᵀ. Symmetric; its inverse is F S⁻¹ Fᵀ.
#[must_use]
pub fn scaling_in_frame(frame: DMat3, factors: DVec3) -> DMat4 {
    DMat4::from_mat3(frame * DMat3::from_diagonal(factors) * frame.transpose())
}

/// Which coordinate a shear changes, and by which other one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shear {
    /// x' = x + k y
    XByY,
    /// x' = x + k z
    XByZ,
    /// y' = y + k x
    YByX,
    /// y' = y + k z
    YByZ,
    /// z' = z + k x
    ZByX,
    /// z' = z + k y
    ZByY,
}

impl Shear {
    /// All six.
    pub const ALL: [Self; 6] = [
        Self::XByY,
        Self::XByZ,
        Self::YByX,
        Self::YByZ,
        Self::ZByX,
        Self::ZByY,
    ];

    /// The axis that changes, and the one it changes by.
    #[must_use]
    pub const fn axes(self) -> (Axis, Axis) {
        match self {
            Self::XByY => (Axis::X, Axis::Y),
            Self::XByZ => (Axis::X, Axis::Z),
            Self::YByX => (Axis::Y, Axis::X),
            Self::YByZ => (Axis::Y, Axis::Z),
            Self::ZByX => (Axis::Z, Axis::X),
            Self::ZByY => (Axis::Z, Axis::Y),
        }
    }
}

/// Shear by the factor `k`; its inverse is the shear by `-k`.
#[must_use]
pub fn shear(shear: Shear, k: f64) -> DMat4 {
    let (changed, by) = shear.axes();
    DMat4::from_mat3(csg::shear_matrix(changed, by, k))
}

/// Rotation by `angle` radians about a unit `axis` through the origin,
/// counter-clockwise as seen from its tip: Rodrigues' formula,
/// R = I + sin a K + (1 - cos a) K², with K v = axis × v. Its inverse is its
/// transpose.
#[must_use]
pub fn rotation(axis: DVec3, angle: f64) -> DMat4 {
    let (sin, cos) = angle.sin_cos();
    DMat4::from_mat3(rodrigues(axis, sin, cos))
}

fn rodrigues(axis: DVec3, sin: f64, cos: f64) -> DMat3 {
    let column = |e: DVec3| {
        let k = axis.cross(e);
        e + k * sin + axis.cross(k) * (1.0 - cos)
    };
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

/// The smallest rotation that takes the direction `from` to `to` (any
/// lengths). For opposite directions, half a turn about some axis at right
/// angles; for a zero direction, the identity.
#[must_use]
pub fn rotation_between(from: DVec3, to: DVec3) -> DMat4 {
    let (from, to) = (from.normalize_or_zero(), to.normalize_or_zero());
    if from == DVec3::ZERO || to == DVec3::ZERO {
        return DMat4::IDENTITY;
    }
    let cross = from.cross(to);
    // 1 + cos as |from + to|² / 2, which cancels nothing near opposite
    // directions.
    let one_plus_cos = 0.5 * (from + to).length_squared();
    if one_plus_cos > 1e-6 {
        // R = I + K + K² / (1 + cos): no angle is needed.
        let column = |e: DVec3| {
            let k = cross.cross(e);
            e + k + cross.cross(k) / one_plus_cos
        };
        return DMat4::from_mat3(DMat3::from_cols(
            column(DVec3::X),
            column(DVec3::Y),
            column(DVec3::Z),
        ));
    }
    // Nearly opposite: mirror in the plane across `from`, then in the one
    // across the bisector of -from and to, two well-conditioned reflections.
    let axis = from.any_orthonormal_vector();
    let half_turn = rodrigues(axis, 0.0, -1.0);
    DMat4::from_mat3(half_turn).mul_mat4(&rotation_between(from, half_turn.transpose() * to))
}

/// Coordinates with respect to a frame to world coordinates: the frame's axes
/// are the columns of `axes`, its origin is `origin`.
#[must_use]
pub fn from_frame(axes: DMat3, origin: DVec3) -> DMat4 {
    let mut m = DMat4::from_mat3(axes);
    m.w_axis = origin.extend(1.0);
    m
}

/// World coordinates to coordinates with respect to an orthonormal frame:
/// the inverse of [`from_frame`], by [`rigid_inverse`].
#[must_use]
pub fn to_frame(axes: DMat3, origin: DVec3) -> DMat4 {
    rigid_inverse(from_frame(axes, origin))
}

/// The inverse of a rotation followed by a translation, without division:
/// Rᵀ and -Rᵀ t.
#[must_use]
pub fn rigid_inverse(m: DMat4) -> DMat4 {
    let transposed = DMat3::from_mat4(m).transpose();
    from_frame(transposed, -(transposed * m.w_axis.truncate()))
}

/// Euler angles of a camera in its Y-up frame, in radians:
/// E = Ry(heading) Rx(pitch) Rz(roll).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Euler {
    /// About the vertical axis Y.
    pub heading: f64,
    /// About the camera's X, in -pi/2..=pi/2 as extracted.
    pub pitch: f64,
    /// About the camera's Z.
    pub roll: f64,
}

impl Euler {
    /// E = Ry(heading) Rx(pitch) Rz(roll).
    #[must_use]
    pub fn to_matrix(self) -> DMat3 {
        EulerOrder::Yxz.to_matrix([self.heading, self.pitch, self.roll])
    }

    /// The angles of a rotation. Looking straight up or down (gimbal lock)
    /// heading and roll turn about the same axis; all of it is then given as
    /// heading, and roll is 0 ([`EulerOrder::from_matrix`] gives the choice).
    #[must_use]
    pub fn from_matrix(m: DMat3) -> Self {
        let [heading, pitch, roll] = EulerOrder::Yxz.from_matrix(m, GimbalLock::LastIsZero);
        Self {
            heading,
            pitch,
            roll,
        }
    }
}

/// The matrix for normals of surfaces transformed by `m`: the transposed
/// adjugate times the sign of the determinant. It needs no division, exists
/// for singular `m`, and keeps outward normals outward under mirroring. Its
/// results are not of unit length.
#[must_use]
pub fn normal_matrix(m: DMat3) -> DMat3 {
    let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
    let cofactors = DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b));
    if a.dot(b.cross(c)) < 0.0 {
        -cofactors
    } else {
        cofactors
    }
}
