//! What can go wrong, and how to mend it.

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
        "the view is singular or not finite: check that eye and target differ, that the up \
         vector is not along the view direction, and that 0 < near < far"
    )]
    SingularView,
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
    /// The PNG encoder or the file system refused.
    #[error("cannot write the PNG: {0}")]
    Png(#[from] png::EncodingError),
}
