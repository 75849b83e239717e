//! Pictures and buffers, and the files they are written to.

pub(crate) mod buffer_images;
pub(crate) mod buffers;
pub(crate) mod gif_file;
pub(crate) mod image;
pub(crate) mod png_file;
pub(crate) mod sheet;
pub(crate) mod show;
pub(crate) mod turntable;
