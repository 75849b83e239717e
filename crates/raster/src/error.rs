//! What can go wrong, and how to mend it.

use glam::DVec3;
use thiserror::Error;

/// The largest width or height of a picture, in pixels.
pub const MAX_SIZE: u32 = 16_384;

/// Why a picture could not be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RasterError {
    /// The target is larger than [`MAX_SIZE`] in one direction.
    #[error(
        "a picture of {width}x{height} pixels is too large: neither side may exceed {MAX_SIZE}; \
         ask for a smaller size"
    )]
    SizeTooLarge {
        /// Width asked for, in pixels.
        width: u32,
        /// Height asked for, in pixels.
        height: u32,
    },
    /// The world-to-clip matrix has an entry that is not finite, or cannot be
    /// inverted.
    #[error(
        "the view's matrices are not finite or cannot be inverted: the model may be too far \
         away, or too flat along the view, for double precision"
    )]
    SingularView,
    /// Eye and target of a camera are the same point, or not finite.
    #[error("the camera at {eye} looks at {target}: give two different, finite points")]
    EyeAtTarget {
        /// Where the camera is.
        eye: DVec3,
        /// What it looks at.
        target: DVec3,
    },
    /// The up vector is zero, not finite, or along the view.
    #[error(
        "up vector {up} along the view direction {direction}, zero or not finite: give another"
    )]
    UpAlongView {
        /// The vector.
        up: DVec3,
        /// Along which the camera looks.
        direction: DVec3,
    },
    /// The near plane is not in front of the far plane, or not in front of the eye.
    #[error(
        "near plane at {near} and far plane at {far}: give 0 < near < far, or 0 <= near < far for \
         a parallel projection"
    )]
    BadDepthRange {
        /// Distance of the near plane.
        near: f64,
        /// Distance of the far plane.
        far: f64,
    },
    /// A field of view outside of 0 to pi.
    #[error("a field of view of {} degrees: give one above 0 and below 180", .fov_y.to_degrees())]
    BadFieldOfView {
        /// The vertical angle in radians.
        fov_y: f64,
    },
    /// A parallel lens whose window has no height, or whose shear is not finite.
    #[error("a parallel projection with a window {height} high: give a height above 0")]
    BadWindow {
        /// The window's height in model units.
        height: f64,
    },
    /// The view was made for a picture of other proportions.
    #[error(
        "a picture of {width}x{height} pixels from a view for one {aspect} times as wide as high \
         would be stretched: make the view for this size"
    )]
    OtherAspect {
        /// Width by height of the picture that the view is for.
        aspect: f64,
        /// Width asked for, in pixels.
        width: u32,
        /// Height asked for, in pixels.
        height: u32,
    },
    /// Lines of no width, or wider than any picture needs.
    #[error(
        "lines {width} pixels wide: give a width above 0 and up to {}",
        crate::edges::MAX_LINE_WIDTH
    )]
    BadLineWidth {
        /// The width in pixels.
        width: f64,
    },
    /// Too many section planes, or one without a normal.
    #[error(
        "a section plane needs a normal that is finite and not zero, and there can be at most \
         {} of them",
        crate::section::MAX_SECTIONS
    )]
    BadSection,
    /// There is nothing to frame: the mesh has no vertex, or none that is finite.
    #[error(
        "cannot frame a mesh without finite vertices: give a camera, or a mesh that is not empty"
    )]
    NothingToFrame,
    /// A picture without pixels cannot be written as PNG.
    #[error("a picture of {width}x{height} pixels cannot be encoded: PNG needs at least 1x1")]
    EmptyImage {
        /// Width of the picture.
        width: u32,
        /// Height of the picture.
        height: u32,
    },
    /// There can be no such file.
    #[error("cannot write the picture: {0}")]
    File(#[from] std::io::Error),
    /// The GIF encoder or the file system refused.
    #[error("cannot write the GIF: {0}")]
    Gif(#[from] gif::EncodingError),
    /// The PNG encoder or the file system refused.
    #[error("cannot write the PNG: {0}")]
    Png(#[from] png::EncodingError),
}
