//! The view-reference model of GKS-3D, PHIGS and Foley–van Dam (6.2, 6.5).

use glam::{DVec2, DVec3};

use crate::RasterError;
use crate::camera::{Frame, View};
use crate::projection::{self, Window};

/// How a [`ViewReference`] projects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProjectionType {
    /// From the projection reference point.
    Perspective,
    /// Along the direction of projection, from the projection reference point
    /// to the window's centre; oblique unless that is along VPN.
    Parallel,
}

/// A view by its reference point and frame: everything but VRP, VPN and VUP is in
/// viewing-reference coordinates u (right), v (up), n (along VPN, towards
/// the viewer).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewReference {
    /// View reference point, the origin of the view plane, in world
    /// coordinates.
    pub vrp: DVec3,
    /// View-plane normal, towards the viewer; any length.
    pub vpn: DVec3,
    /// View-up vector: its projection onto the view plane is v.
    pub vup: DVec3,
    /// Projection reference point (u, v, n).
    pub prp: DVec3,
    /// Lower left corner of the window in the view plane.
    pub window_low: DVec2,
    /// Upper right corner of the window in the view plane.
    pub window_high: DVec2,
    /// n of the front clipping plane (the greater one).
    pub front: f64,
    /// n of the back clipping plane.
    pub back: f64,
    /// Perspective or parallel.
    pub projection: ProjectionType,
}

impl ViewReference {
    /// The direction of projection (u, v, n): from the projection reference
    /// point to the centre of the window.
    #[must_use]
    pub fn direction_of_projection(&self) -> DVec3 {
        ((self.window_low + self.window_high) / 2.0).extend(0.0) - self.prp
    }

    /// The matrices of this view, which is, as a camera's, for pictures of the
    /// window's proportions.
    ///
    /// # Errors
    /// [`RasterError::SingularView`] where VPN is zero or along VUP, the
    /// window or the depth range is empty, the projection reference point
    /// lies in the view plane, or (perspective) the front plane is not in
    /// front of it.
    pub fn view(&self) -> Result<View, RasterError> {
        let size = self.window_high - self.window_low;
        let aspect = (size.x / size.y).abs();
        Ok(self.unchecked_view()?.for_aspect(aspect))
    }

    fn unchecked_view(&self) -> Result<View, RasterError> {
        let frame = Frame::right_handed(-self.vpn, self.vup);
        match self.projection {
            ProjectionType::Perspective => {
                let (near, far) = (self.prp.z - self.front, self.prp.z - self.back);
                if !(near > 0.0 && self.prp.z > 0.0) {
                    return Err(RasterError::SingularView);
                }
                // The window lies at distance prp.n; similar triangles bring
                // it to the near plane.
                let scale = near / self.prp.z;
                let window = Window {
                    left: (self.window_low.x - self.prp.x) * scale,
                    right: (self.window_high.x - self.prp.x) * scale,
                    bottom: (self.window_low.y - self.prp.y) * scale,
                    top: (self.window_high.y - self.prp.y) * scale,
                    near,
                    far,
                };
                let eye =
                    self.vrp + frame.u * self.prp.x + frame.v * self.prp.y + frame.n * self.prp.z;
                View::new(frame.world_to_eye(eye), projection::frustum(&window))
            }
            ProjectionType::Parallel => {
                let window = Window {
                    left: self.window_low.x,
                    right: self.window_high.x,
                    bottom: self.window_low.y,
                    top: self.window_high.y,
                    near: -self.front,
                    far: -self.back,
                };
                let along = self.direction_of_projection();
                View::new(
                    frame.world_to_eye(self.vrp),
                    projection::oblique(&window, along),
                )
            }
        }
    }
}
