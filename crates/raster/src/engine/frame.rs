//! The matrix of one frame, in the forms that the stages need.

use glam::{DMat3, DMat4, DVec3, DVec4, Vec3};

use crate::camera::View;
use crate::fixed::SUBPIXELS;
use crate::viewport::Viewport;

/// Half the guard band in sub-pixels: a vertex at most this far from the
/// middle of the picture needs no clipping at the sides. With pictures of at
/// most 2^14 pixels this keeps every fixed-point coordinate within 2^23 and
/// every edge vector within 2^24.
pub(crate) const GUARD: f32 = (16_384 * SUBPIXELS) as f32;

/// See [`FrameMatrix::towards_viewer`]. A ray leaves the eye in the direction
/// d with (X, Y, W) of d = (x, y, 1).
fn towards_viewer([x, y, _, w]: [DVec4; 4], viewer: DVec4) -> [Vec3; 3] {
    if viewer.w == 0.0 {
        return [viewer.truncate().as_vec3(), Vec3::ZERO, Vec3::ZERO];
    }
    let to_window = DMat3::from_cols(x.truncate(), y.truncate(), w.truncate()).transpose();
    let rays = to_window.inverse();
    [rays.z_axis, rays.x_axis, rays.y_axis].map(|ray| -ray.as_vec3())
}

/// World (relative to a scene's centre) to *raster space*: homogeneous
/// (X, Y, Z, W) with X/W, Y/W in sub-pixels from the middle of the picture, y
/// downwards, and Z/W the reversed depth, 1 at the near plane and 0 at the far
/// plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameMatrix {
    /// The scene's centre.
    pub centre: DVec3,
    /// The four rows.
    pub rows: [DVec4; 4],
    /// The middle of the picture, in sub-pixels from its top left corner.
    pub middle: [i32; 2],
    pub width: u32,
    pub height: u32,
    /// 1, or -1 if the view mirrors: the sign of a front face's area.
    pub orientation: i32,
    /// Centre of projection relative to the scene's centre, homogeneous.
    pub viewer: DVec4,
    /// The direction towards the viewer, of some length, from what the sample
    /// (x, y) shows: the first plus x times the second plus y times the third
    /// (sub-pixels from the middle of the picture).
    pub towards_viewer: [Vec3; 3],
}

impl FrameMatrix {
    pub fn new(view: &View, centre: DVec3, width: u32, height: u32) -> Self {
        let from_scene = view.world_to_clip() * DMat4::from_translation(centre);
        let half = f64::from(SUBPIXELS) / 2.0;
        let to_raster = DMat4::from_cols(
            DVec4::new(f64::from(width) * half, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -f64::from(height) * half, 0.0, 0.0),
            DVec4::new(0.0, 0.0, -0.5, 0.0),
            DVec4::new(0.0, 0.0, 0.5, 1.0),
        );
        let matrix = (to_raster * from_scene).transpose();
        let rows = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis];
        let viewer = view.centre_of_projection();
        let relative = viewer.truncate() - centre * viewer.w;
        Self {
            centre,
            rows,
            middle: [width, height].map(|side| side.cast_signed() * SUBPIXELS / 2),
            width,
            height,
            orientation: if view.world_to_clip().determinant() < 0.0 {
                1
            } else {
                -1
            },
            viewer: relative.extend(viewer.w),
            towards_viewer: towards_viewer(rows, viewer),
        }
    }

    /// One row applied to a point, in the order of operations that the vector
    /// code uses, so that both give the same bits.
    #[inline(always)]
    pub fn row(&self, row: usize, p: DVec3) -> f64 {
        let r = self.rows[row];
        (r.x * p.x + r.y * p.y) + (r.z * p.z + r.w)
    }
}

impl FrameMatrix {
    /// OpenGL clip coordinates of a point relative to the scene's centre.
    pub fn clip(&self, p: DVec3) -> DVec4 {
        let [x, y, z, w] = [0, 1, 2, 3].map(|row| self.row(row, p));
        let half = f64::from(SUBPIXELS) / 2.0;
        DVec4::new(
            x / (f64::from(self.width.max(1)) * half),
            -y / (f64::from(self.height.max(1)) * half),
            w - 2.0 * z,
            w,
        )
    }

    /// Clip coordinates to pixels (y downwards) and reversed depth.
    pub fn window(&self, clip: DVec4) -> DVec3 {
        let viewport = Viewport::of_image(self.width, self.height);
        let mut window = viewport.from_ndc(clip.truncate() / clip.w);
        window.z = 1.0 - window.z;
        window
    }
}
