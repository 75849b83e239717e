//! From a camera to a [`View`]: the two matrices the pipeline works with.

use glam::{DMat3, DMat4, DVec3, DVec4};

use crate::RasterError;
use crate::projection::{self, Window};

/// World to eye coordinates for a camera at `eye` that looks at `target`,
/// with `up` upwards in the picture. Right-handed: the camera looks along its
/// local -Z. Not finite where eye and target coincide or `up` is along the
/// view direction.
#[must_use]
pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> DMat4 {
    let frame = Frame::right_handed(target - eye, up);
    frame.world_to_eye(eye)
}

/// The camera frame U (right), V (up in the picture), N: orthonormal, in
/// world coordinates (Foley et al., 6.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Right in the picture.
    pub u: DVec3,
    /// Up in the picture.
    pub v: DVec3,
    /// Towards the viewer in a right-handed frame, away from it in a
    /// left-handed one.
    pub n: DVec3,
}

impl Frame {
    /// The right-handed frame of a camera that looks along `view` (any
    /// length): U = view x up, N = -view, V = N x U, normalised.
    #[must_use]
    pub fn right_handed(view: DVec3, up: DVec3) -> Self {
        let n = -view.normalize();
        let u = up.cross(n).normalize();
        Self {
            u,
            v: n.cross(u),
            n,
        }
    }

    /// The left-handed frame of a camera that looks along `view`: the same U
    /// and V, N along the view.
    #[must_use]
    pub fn left_handed(view: DVec3, up: DVec3) -> Self {
        let right = Self::right_handed(view, up);
        Self {
            n: -right.n,
            ..right
        }
    }

    /// The matrix that takes the world to this frame with its origin at `eye`.
    #[must_use]
    pub fn world_to_eye(&self, eye: DVec3) -> DMat4 {
        let Self { u, v, n } = *self;
        DMat4::from_cols(
            DVec4::new(u.x, v.x, n.x, 0.0),
            DVec4::new(u.y, v.y, n.y, 0.0),
            DVec4::new(u.z, v.z, n.z, 0.0),
            DVec4::new(-u.dot(eye), -v.dot(eye), -n.dot(eye), 1.0),
        )
    }
}

/// How a [`Camera`] projects.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Lens {
    /// Perspective with a full vertical field of view in radians.
    Perspective {
        /// Full vertical angle, in 0..pi.
        fov_y: f64,
    },
    /// Parallel, at right angles to the picture plane.
    Orthographic {
        /// Height of the window in model units.
        height: f64,
    },
    /// Parallel along another direction, with the plane through the target
    /// drawn to scale.
    Oblique {
        /// Height of the window in model units.
        height: f64,
        /// Length at which a unit of depth is drawn: 1 for a cavalier, 1/2
        /// for a cabinet projection.
        ratio: f64,
        /// Direction in which depth recedes, in radians from the picture's
        /// x axis.
        angle: f64,
    },
}

impl Lens {
    /// Perspective with a vertical field of view of 30 degrees.
    pub const DEFAULT: Self = Self::Perspective {
        fov_y: std::f64::consts::FRAC_PI_6,
    };
}

/// A look-at camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the camera is.
    pub eye: DVec3,
    /// What it looks at.
    pub target: DVec3,
    /// Upwards in the picture; need not be at right angles to the view.
    pub up: DVec3,
    /// How it projects.
    pub lens: Lens,
    /// Distance of the near plane (positive for perspective).
    pub near: f64,
    /// Distance of the far plane; infinite is allowed for perspective.
    pub far: f64,
}

impl Camera {
    /// A camera at `eye` that looks at `target`: upright (Z upwards, or Y where
    /// it looks along Z), with the default lens, from a thousandth of the
    /// distance to infinity.
    #[must_use]
    pub fn looking_at(eye: DVec3, target: DVec3) -> Self {
        let direction = target - eye;
        let upright = direction.truncate() != glam::DVec2::ZERO;
        Self {
            eye,
            target,
            up: if upright { DVec3::Z } else { DVec3::Y },
            lens: Lens::DEFAULT,
            near: direction.length() * 1e-3,
            far: f64::INFINITY,
        }
    }

    /// A camera at `eye` that has been turned from where it looks along -Z, Y
    /// upwards: by the columns of a rotation, such as that of
    /// [`Euler`](crate::transform::Euler) angles. It looks at a point at that
    /// distance.
    #[must_use]
    pub fn turned(eye: DVec3, rotation: DMat3, distance: f64) -> Self {
        let target = eye - rotation.z_axis * distance;
        Self::looking_at(eye, target).up(rotation.y_axis)
    }

    /// Sets what is upwards in the picture.
    #[must_use]
    pub fn up(self, up: DVec3) -> Self {
        Self { up, ..self }
    }

    /// Sets the lens; a parallel one sees to a thousand times the target's
    /// distance where the far plane was infinitely far.
    #[must_use]
    pub fn lens(self, lens: Lens) -> Self {
        let far = match lens {
            Lens::Perspective { .. } => self.far,
            _ if self.far.is_finite() => self.far,
            _ => self.eye.distance(self.target) * 1e3,
        };
        Self { lens, far, ..self }
    }

    /// Sets the distances of the near and the far plane.
    #[must_use]
    pub fn depths(self, near: f64, far: f64) -> Self {
        Self { near, far, ..self }
    }

    /// World to eye coordinates.
    #[must_use]
    pub fn world_to_eye(&self) -> DMat4 {
        look_at(self.eye, self.target, self.up)
    }

    /// Eye to clip coordinates for a picture of the given aspect ratio (width
    /// / height).
    #[must_use]
    pub fn eye_to_clip(&self, aspect: f64) -> DMat4 {
        let parallel = |height: f64| Window::centred(height * aspect, height, self.near, self.far);
        match self.lens {
            Lens::Perspective { fov_y } if self.far.is_infinite() => {
                projection::infinite_perspective(fov_y, aspect, self.near)
            }
            Lens::Perspective { fov_y } => {
                projection::perspective(fov_y, aspect, self.near, self.far)
            }
            Lens::Orthographic { height } => projection::orthographic(&parallel(height)),
            Lens::Oblique {
                height,
                ratio,
                angle,
            } => {
                // The plane through the target stays put.
                let distance = self.eye.distance(self.target);
                let direction = projection::receding(angle, ratio);
                let shear = projection::shear_about(direction, -distance);
                projection::orthographic(&parallel(height)) * shear
            }
        }
    }

    /// The view of this camera in a picture of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`RasterError::EyeAtTarget`], [`RasterError::UpAlongView`],
    /// [`RasterError::BadDepthRange`], [`RasterError::BadFieldOfView`] and
    /// [`RasterError::BadWindow`] where the camera cannot see;
    /// [`RasterError::SingularView`] beyond double precision.
    pub fn view(&self, width: u32, height: u32) -> Result<View, RasterError> {
        self.check()?;
        let aspect = f64::from(width.max(1)) / f64::from(height.max(1));
        let view = View::new(self.world_to_eye(), self.eye_to_clip(aspect))?;
        Ok(View {
            aspect: Some(aspect),
            ..view
        })
    }

    /// Says what is wrong with the camera, if anything is.
    fn check(&self) -> Result<(), RasterError> {
        let Self {
            eye,
            target,
            up,
            near,
            far,
            ..
        } = *self;
        let direction = target - eye;
        if direction.try_normalize().is_none() {
            return Err(RasterError::EyeAtTarget { eye, target });
        }
        let frame = Frame::right_handed(direction, up);
        if !(frame.u.is_finite() && frame.v.is_finite()) {
            return Err(RasterError::UpAlongView { up, direction });
        }
        let (nearest, farthest) = match self.lens {
            Lens::Perspective { fov_y } => {
                if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) {
                    return Err(RasterError::BadFieldOfView { fov_y });
                }
                (f64::MIN_POSITIVE, f64::INFINITY)
            }
            Lens::Orthographic { height } | Lens::Oblique { height, .. } => {
                if !(height > 0.0 && height.is_finite()) {
                    return Err(RasterError::BadWindow { height });
                }
                (0.0, f64::MAX)
            }
        };
        if !(near >= nearest && near < far && far <= farthest && near.is_finite()) {
            return Err(RasterError::BadDepthRange { near, far });
        }
        Ok(())
    }
}

/// A way to look at a scene: world to eye to clip coordinates, proven finite
/// and invertible. Made from a [`Camera`], or from any two matrices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    world_to_eye: DMat4,
    eye_to_clip: DMat4,
    world_to_clip: DMat4,
    clip_to_world: DMat4,
    /// Width by height of the picture that it is for, if it is for one.
    aspect: Option<f64>,
}

impl View {
    /// A view from its matrices; `eye_to_clip` ends in OpenGL's clip space
    /// (-w..w in x, y and z).
    ///
    /// # Errors
    /// [`RasterError::SingularView`] if the product or its inverse is not
    /// finite.
    pub fn new(world_to_eye: DMat4, eye_to_clip: DMat4) -> Result<Self, RasterError> {
        let world_to_clip = eye_to_clip * world_to_eye;
        if !world_to_clip.is_finite() || world_to_clip.determinant() == 0.0 {
            return Err(RasterError::SingularView);
        }
        let clip_to_world = world_to_clip.inverse();
        if !clip_to_world.is_finite() {
            return Err(RasterError::SingularView);
        }
        Ok(Self {
            world_to_eye,
            eye_to_clip,
            world_to_clip,
            clip_to_world,
            aspect: None,
        })
    }

    /// The same for pictures of that width by height.
    pub(crate) fn for_aspect(mut self, aspect: f64) -> Self {
        self.aspect = Some(aspect);
        self
    }

    /// Refuses a picture that the view would be stretched into.
    pub(crate) fn check_size(&self, width: u32, height: u32) -> Result<(), RasterError> {
        let fits = |aspect: f64| {
            let wanted = aspect * f64::from(height);
            // As good as the next whole pixel.
            (wanted - f64::from(width)).abs() <= 1.0
                || (f64::from(width) / aspect - f64::from(height)).abs() <= 1.0
        };
        match self.aspect {
            Some(aspect) if width > 0 && height > 0 && !fits(aspect) => {
                Err(RasterError::OtherAspect {
                    aspect,
                    width,
                    height,
                })
            }
            _ => Ok(()),
        }
    }

    /// World to eye coordinates.
    #[must_use]
    pub fn world_to_eye(&self) -> DMat4 {
        self.world_to_eye
    }

    /// Eye to clip coordinates.
    #[must_use]
    pub fn eye_to_clip(&self) -> DMat4 {
        self.eye_to_clip
    }

    /// World to clip coordinates.
    #[must_use]
    pub fn world_to_clip(&self) -> DMat4 {
        self.world_to_clip
    }

    /// Clip to world coordinates.
    #[must_use]
    pub fn clip_to_world(&self) -> DMat4 {
        self.clip_to_world
    }

    /// The centre of projection in homogeneous world coordinates, the one
    /// point that has no image: the eye (w = 1) of a perspective, the unit
    /// direction towards the viewer (w = 0) of a parallel projection.
    #[must_use]
    pub fn centre_of_projection(&self) -> DVec4 {
        // x = y = w = 0 in clip space, so what is left is the z axis; its
        // sign is that of the near side, z -> -infinity.
        let centre = -self.clip_to_world.z_axis;
        if centre.w.abs() > 1e-12 * centre.truncate().length() {
            centre / centre.w
        } else {
            centre.truncate().normalize().extend(0.0)
        }
    }

    /// The unit direction from `point` (world) towards the viewer.
    #[must_use]
    pub fn towards_viewer(&self, point: DVec3) -> DVec3 {
        let centre = self.centre_of_projection();
        (centre.truncate() - point * centre.w).normalize_or_zero()
    }
}
