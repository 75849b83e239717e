//! The viewport: clip coordinates to window coordinates and back.
//!
//! Window x grows to the right, window y downwards (row 0 is the top row of
//! the picture) or upwards, as [`YAxis`] says. Pixel (i, j) covers
//! i..i+1 by j..j+1 and is sampled at its centre (i + 0.5, j + 0.5).

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use crate::camera::View;

/// Where row 0 of the window is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum YAxis {
    /// Row 0 is the top row, as in picture files.
    #[default]
    Down,
    /// Row 0 is the bottom row, as in OpenGL.
    Up,
}

/// A rectangle of pixels that the clip square -1..1 is mapped onto.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewport {
    /// Left edge in pixels.
    pub x: f64,
    /// Edge of row 0, in pixels.
    pub y: f64,
    /// Width in pixels.
    pub width: f64,
    /// Height in pixels.
    pub height: f64,
    /// Which way window y grows.
    pub y_axis: YAxis,
}

/// A point on the window: x and y in pixels, depth from 0 (near plane) to 1
/// (far plane).
pub type WindowPoint = DVec3;

impl Viewport {
    /// The whole of a picture, row 0 at the top.
    #[must_use]
    pub fn of_image(width: u32, height: u32) -> Self {
        Self {
            x: 0.0,
            y: 0.0,
            width: f64::from(width),
            height: f64::from(height),
            y_axis: YAxis::Down,
        }
    }

    /// Normalised device coordinates (-1..1) to the window.
    #[must_use]
    pub fn from_ndc(&self, ndc: DVec3) -> WindowPoint {
        let y = match self.y_axis {
            YAxis::Down => -ndc.y,
            YAxis::Up => ndc.y,
        };
        DVec3::new(
            self.x + (ndc.x + 1.0) / 2.0 * self.width,
            self.y + (y + 1.0) / 2.0 * self.height,
            (ndc.z + 1.0) / 2.0,
        )
    }

    /// [`Viewport::from_ndc`] as a matrix, with depths from 0 to `z_max` (1 for
    /// window coordinates; the greatest number of an integer depth buffer).
    #[must_use]
    pub fn matrix(&self, z_max: f64) -> DMat4 {
        let [w, h, z] = [self.width, self.height, z_max].map(|size| size / 2.0);
        let up = match self.y_axis {
            YAxis::Down => -h,
            YAxis::Up => h,
        };
        DMat4::from_cols(
            DVec4::X * w,
            DVec4::Y * up,
            DVec4::Z * z,
            DVec4::new(w + self.x, h + self.y, z, 1.0),
        )
    }

    /// The point of an object that appears at a position of the window, given
    /// its z in the object's own coordinates, from which `model` leads to the
    /// world: where the ray through the position meets that plane. `None` if it
    /// does not, or the model cannot be inverted.
    #[must_use]
    pub fn unproject_at_z(
        &self,
        view: &View,
        model: DMat4,
        position: DVec2,
        z_object: f64,
    ) -> Option<DVec3> {
        // (x, y, w) of the clip coordinates, for a point (x, y, 1) of the plane.
        let m = (view.world_to_clip() * model).transpose();
        let row = |r: DVec4| DVec3::new(r.x, r.y, r.z * z_object + r.w);
        let to_clip = DMat3::from_cols(row(m.x_axis), row(m.y_axis), row(m.w_axis)).transpose();
        let ndc = self.to_ndc(position.extend(0.0));
        let p = to_clip.inverse() * DVec3::new(ndc.x, ndc.y, 1.0);
        let point = (p.truncate() / p.z).extend(z_object);
        point.is_finite().then_some(point)
    }

    /// The inverse of [`Viewport::from_ndc`].
    #[must_use]
    pub fn to_ndc(&self, window: WindowPoint) -> DVec3 {
        let y = (window.y - self.y) / self.height * 2.0 - 1.0;
        DVec3::new(
            (window.x - self.x) / self.width * 2.0 - 1.0,
            match self.y_axis {
                YAxis::Down => -y,
                YAxis::Up => y,
            },
            window.z * 2.0 - 1.0,
        )
    }

    /// Where a world point appears; `None` at or behind the eye (w <= 0).
    #[must_use]
    pub fn project(&self, view: &View, world: DVec3) -> Option<WindowPoint> {
        let clip: DVec4 = view.world_to_clip() * world.extend(1.0);
        (clip.w > 0.0).then(|| self.from_ndc(clip.truncate() / clip.w))
    }

    /// The world point that appears at a window point: the inverse of
    /// [`Viewport::project`], exact to about 1e-15 of the distance divided by
    /// `near / distance` (depth is coarse far from the near plane). `None`
    /// where that point is at infinity.
    #[must_use]
    pub fn unproject(&self, view: &View, window: WindowPoint) -> Option<DVec3> {
        let world = view.clip_to_world() * self.to_ndc(window).extend(1.0);
        let point = world.truncate() / world.w;
        point.is_finite().then_some(point)
    }

    /// The ray through a position of the window: its points on the near and
    /// the far plane. `None` where one of them is at infinity.
    #[must_use]
    pub fn ray(&self, view: &View, position: DVec2) -> Option<(DVec3, DVec3)> {
        Some((
            self.unproject(view, position.extend(0.0))?,
            self.unproject(view, position.extend(1.0))?,
        ))
    }
}

/// A depth of -1..1 in the range between two numbers: what `glDepthRange` sets.
#[must_use]
pub fn depth_in_range(ndc: f64, near: f64, far: f64) -> f64 {
    (ndc * (far - near) + (near + far)) / 2.0
}

/// The integer depth of a buffer of `bits` (1..=32) for a depth in 0..=1:
/// 0..=z_max with z_max = 2^bits - 1, rounded to nearest; values outside are
/// clamped, NaN is the farthest.
#[must_use]
pub fn integer_depth(depth: f64, bits: u32) -> u32 {
    let z_max = f64::from(u32::MAX >> (32 - bits.clamp(1, 32)));
    if depth.is_nan() {
        return z_max as u32;
    }
    // Float to integer conversion saturates.
    (depth.clamp(0.0, 1.0) * z_max).round() as u32
}
