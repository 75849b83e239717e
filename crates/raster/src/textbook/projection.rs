//! Projection matrices: eye coordinates (camera at the origin, looking along
//! its local -Z, Y up) to OpenGL clip coordinates (-w..w in x, y and z).
//!
//! Every function returns a [`DMat4`] for column vectors. None of them checks
//! its arguments: a degenerate window (zero width, `near == far`) gives a
//! matrix that is not finite, which [`View::new`](crate::View::new) refuses.
//!
//! | function | source |
//! | --- | --- |
//! | [`orthographic`], [`frustum`] | OpenGL 1.0 specification, 2.9.2 |
//! | [`shear_to_axis`], [`scale_to_canonical`], [`normalised_perspective`] | Foley, van Dam, Feiner, Hughes, *Computer Graphics: Principles and Practice*, 2nd ed., 6.5 |
//! | [`oblique`], [`cavalier`], [`cabinet`] | Foley et al., 6.1.2 and 6.5.4 |
//! | [`orthographic_translation`], [`box_scaling`], [`frustum_to_box`] | the factors of both, as they are taught |
//! | [`pinhole`], [`perspective_depth`], [`normalised_perspective_depth`] | Foley et al., 6.4 |
//! | [`one_point`] | Rogers, Adams, *Mathematical Elements for Computer Graphics*, 2nd ed., 3-13 |
//! | [`infinite_perspective`], [`reversed_z`] | Upchurch, Desbrun, *Tightening the precision of perspective rendering*, JGT 16(1), 2012 |

use glam::{DMat4, DVec2, DVec3, DVec4};

/// The window in the near plane (perspective) or anywhere (parallel), in eye
/// coordinates, with the distances of the near and far plane in front of the
/// eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Least x.
    pub left: f64,
    /// Greatest x.
    pub right: f64,
    /// Least y.
    pub bottom: f64,
    /// Greatest y.
    pub top: f64,
    /// Distance of the near plane; positive for perspective.
    pub near: f64,
    /// Distance of the far plane.
    pub far: f64,
}

impl Window {
    /// A window of the given full width and height centred on the axis.
    #[must_use]
    pub fn centred(width: f64, height: f64, near: f64, far: f64) -> Self {
        Self {
            left: -width / 2.0,
            right: width / 2.0,
            bottom: -height / 2.0,
            top: height / 2.0,
            near,
            far,
        }
    }

    /// The centre of the window.
    #[must_use]
    pub fn centre(&self) -> DVec2 {
        self.sums().truncate() / 2.0
    }

    /// right - left, top - bottom, far - near.
    fn sides(&self) -> DVec3 {
        DVec3::new(
            self.right - self.left,
            self.top - self.bottom,
            self.far - self.near,
        )
    }

    /// right + left, top + bottom, far + near.
    fn sums(&self) -> DVec3 {
        DVec3::new(
            self.right + self.left,
            self.top + self.bottom,
            self.far + self.near,
        )
    }
}

/// Parallel projection along -Z: the box of the window between the near and
/// far planes onto the clip cube.
#[must_use]
pub fn orthographic(window: &Window) -> DMat4 {
    let (sides, sums) = (window.sides(), window.sums());
    DMat4::from_cols(
        DVec4::X * (2.0 / sides.x),
        DVec4::Y * (2.0 / sides.y),
        DVec4::Z * (-2.0 / sides.z),
        (-sums / sides).extend(1.0),
    )
}

/// Parallel projection along an arbitrary direction: points move along
/// `direction` (whose z must not be 0) onto the plane z = 0, keeping their
/// depth, and the window of that plane is then projected orthographically.
#[must_use]
pub fn oblique(window: &Window, direction: DVec3) -> DMat4 {
    orthographic(window) * shear_along(direction)
}

/// Oblique projection in which lengths along z keep their full size and
/// recede at `angle` radians counter-clockwise from the x axis.
#[must_use]
pub fn cavalier(window: &Window, angle: f64) -> DMat4 {
    oblique(window, receding(angle, 1.0))
}

/// Oblique projection in which lengths along z shrink to half and recede at
/// `angle` radians counter-clockwise from the x axis.
#[must_use]
pub fn cabinet(window: &Window, angle: f64) -> DMat4 {
    oblique(window, receding(angle, 0.5))
}

/// The direction of projection that draws a unit vector along -Z with the
/// given length (`ratio`) at `angle` to the x axis.
#[must_use]
pub fn receding(angle: f64, ratio: f64) -> DVec3 {
    // (0,0,-1) + s d lies on z = 0 for s = 1 with d.z = 1.
    DVec3::new(ratio * angle.cos(), ratio * angle.sin(), 1.0)
}

/// The shear that makes `direction` parallel to the z axis and keeps the plane
/// at that z.
#[must_use]
pub fn shear_about(direction: DVec3, z: f64) -> DMat4 {
    let to_plane = DVec3::new(0.0, 0.0, z);
    DMat4::from_translation(to_plane) * shear_along(direction) * DMat4::from_translation(-to_plane)
}

/// The shear that makes `direction` parallel to the z axis and keeps the
/// plane z = 0: x' = x - z dx/dz, y' = y - z dy/dz.
fn shear_along(direction: DVec3) -> DMat4 {
    DMat4::from_cols(
        DVec4::X,
        DVec4::Y,
        DVec4::new(
            -direction.x / direction.z,
            -direction.y / direction.z,
            1.0,
            0.0,
        ),
        DVec4::W,
    )
}

/// The one-point perspective of drawing: the eye at (0, 0, -h), the picture
/// plane z = 0, the scene at z > -h. Here (x, y, z) goes to
/// x* = h x / (z + h), y* = h y / (z + h), z* = z / (z + h): the *normalised
/// perspective depth*, 0 on the picture plane and 1 at infinity, in which
/// straight lines stay straight. Left-handed (z into the picture), as in the
/// texts.
#[must_use]
pub fn one_point(h: f64) -> DMat4 {
    DMat4::from_cols(
        DVec4::new(h, 0.0, 0.0, 0.0),
        DVec4::new(0.0, h, 0.0, 0.0),
        DVec4::new(0.0, 0.0, 1.0, 1.0),
        DVec4::new(0.0, 0.0, 0.0, h),
    )
}

/// First factor of the off-axis frustum: the shear that moves the centre line
/// of the window onto the -Z axis.
#[must_use]
pub fn shear_to_axis(window: &Window) -> DMat4 {
    shear_along(window.centre().extend(-window.near))
}

/// Third factor of the off-axis frustum: the scaling of x and y that makes
/// the sides of the (already centred) frustum planes at 45 degrees.
#[must_use]
pub fn scale_to_canonical(window: &Window) -> DMat4 {
    let scale = 2.0 * window.near / window.sides().truncate();
    DMat4::from_scale(scale.extend(1.0))
}

/// Second factor of the off-axis frustum: w = -z, and z so that the plane
/// z = -near goes to depth -1 and z = -far to 1.
#[must_use]
pub fn normalised_perspective(near: f64, far: f64) -> DMat4 {
    DMat4::from_cols(
        DVec4::X,
        DVec4::Y,
        DVec4::new(0.0, 0.0, -(far + near) / (far - near), -1.0),
        DVec4::new(0.0, 0.0, -2.0 * far * near / (far - near), 0.0),
    )
}

/// Perspective through an off-axis window in the near plane, in one step; the
/// product of [`scale_to_canonical`], [`normalised_perspective`] and
/// [`shear_to_axis`].
#[must_use]
pub fn frustum(window: &Window) -> DMat4 {
    let (sides, sums) = (window.sides(), window.sums());
    let doubled = 2.0 * window.near;
    DMat4::from_cols(
        DVec4::X * (doubled / sides.x),
        DVec4::Y * (doubled / sides.y),
        (sums / sides * DVec3::new(1.0, 1.0, -1.0)).extend(-1.0),
        DVec4::Z * (-doubled * window.far / sides.z),
    )
}

/// Perspective through a window of the given full width and height centred in
/// the near plane.
#[must_use]
pub fn symmetric_frustum(width: f64, height: f64, near: f64, far: f64) -> DMat4 {
    frustum(&Window::centred(width, height, near, far))
}

/// Perspective from the full vertical field of view in radians and the aspect
/// ratio width / height.
#[must_use]
pub fn perspective(fov_y: f64, aspect: f64, near: f64, far: f64) -> DMat4 {
    let cot = 1.0 / (fov_y / 2.0).tan();
    DMat4::from_scale(DVec3::new(cot / aspect, cot, 1.0)) * normalised_perspective(near, far)
}

/// [`perspective`] in the limit of an infinitely far plane: nothing is cut
/// off behind, and depth 1 is infinity.
#[must_use]
pub fn infinite_perspective(fov_y: f64, aspect: f64, near: f64) -> DMat4 {
    let cot = 1.0 / (fov_y / 2.0).tan();
    DMat4::from_cols(
        DVec4::new(cot / aspect, 0.0, 0.0, 0.0),
        DVec4::new(0.0, cot, 0.0, 0.0),
        DVec4::new(0.0, 0.0, -1.0, -1.0),
        DVec4::new(0.0, 0.0, -2.0 * near, 0.0),
    )
}

/// Turns a projection with depth -w..w into one with *reversed* depth w..0:
/// near goes to 1, far to 0, which spreads the precision of floating-point
/// depth evenly over distance (floats are densest around 0, where the far
/// part of the scene is crowded).
#[must_use]
pub fn reversed_z(projection: DMat4) -> DMat4 {
    let rows = projection.transpose();
    let z = (rows.w_axis - rows.z_axis) / 2.0;
    DMat4::from_cols(rows.x_axis, rows.y_axis, z, rows.w_axis).transpose()
}

/// Second factor of [`orthographic`]: the translation that brings the middle
/// of the box to the origin.
#[must_use]
pub fn orthographic_translation(window: &Window) -> DMat4 {
    let middle = -(window.near + window.far) / 2.0;
    DMat4::from_translation(-window.centre().extend(middle))
}

/// First factor of [`orthographic`], and of a perspective: the scaling of a
/// centred box to the clip cube; z is turned round.
#[must_use]
pub fn box_scaling(window: &Window) -> DMat4 {
    let sides = window.sides();
    DMat4::from_scale(2.0 / DVec3::new(sides.x, sides.y, -sides.z))
}

/// The perspective of textbooks between [`box_scaling`] and [`shear_to_axis`]:
/// x* = -near x / z, y* = -near y / z, z* = -(far + near) / 2 - far near / z,
/// which takes the (sheared) frustum to the box with the same planes.
/// [`frustum`] is the product of the three; [`scale_to_canonical`] and
/// [`normalised_perspective`] share out the factors otherwise.
#[must_use]
pub fn frustum_to_box(near: f64, far: f64) -> DMat4 {
    DMat4::from_cols(
        DVec4::X * near,
        DVec4::Y * near,
        DVec4::new(0.0, 0.0, (far + near) / 2.0, -1.0),
        DVec4::new(0.0, 0.0, far * near, 0.0),
    )
}

/// A pinhole at the origin and a screen at z = d: (x, y, z) is seen at
/// (x d / z, y d / z, d), with w = z / d. Depth is lost, so that the matrix has
/// no inverse. Left-handed (z into the picture) for d > 0; a screen behind the
/// pinhole, d < 0, turns the picture round.
#[must_use]
pub fn pinhole(d: f64) -> DMat4 {
    DMat4::from_cols(
        DVec4::X,
        DVec4::Y,
        DVec4::new(0.0, 0.0, 1.0, 1.0 / d),
        DVec4::ZERO,
    )
}

/// Like [`one_point`], with *perspective depth* before it is normalised:
/// x* = h x / (z + h), y* = h y / (z + h), z* = h z / (z + h), 0 on the picture
/// plane and h at infinity; w = z / h + 1.
#[must_use]
pub fn perspective_depth(h: f64) -> DMat4 {
    let mut matrix = DMat4::IDENTITY;
    matrix.z_axis.w = 1.0 / h;
    matrix
}

/// Like [`perspective_depth`], with depth normalised to -1..1:
/// z* = (z - h) / (z + h), -1 on the picture plane and 1 at infinity. That is
/// z' = z / h - 1 and w' = z / h + 1, so that the third row is (0, 0, 1/h, -1).
#[must_use]
pub fn normalised_perspective_depth(h: f64) -> DMat4 {
    let mut matrix = perspective_depth(h);
    (matrix.z_axis.z, matrix.w_axis.z) = (1.0 / h, -1.0);
    matrix
}

/// A projection for eye coordinates in a left-handed frame (N along the view,
/// [`Frame::left_handed`](crate::Frame::left_handed)): one for a right-handed
/// frame, behind the mirroring of z.
#[must_use]
pub fn left_handed(projection: DMat4) -> DMat4 {
    projection * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0))
}
