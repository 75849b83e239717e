//! The projection and Z-buffer pipeline: from a [`Mesh`] and a camera to a
//! picture.
//!
//! ```
//! use raster::{Camera, Lens, RenderOptions, StandardView, render};
//! # use glam::DVec3;
//! # let mesh = csg::Mesh::new(
//! #     vec![DVec3::X, DVec3::Y, DVec3::Z],
//! #     vec![[0, 1, 2]],
//! # );
//! let (width, height) = (64, 48);
//! let aspect = f64::from(width) / f64::from(height);
//! let camera = Camera::standard(&mesh, StandardView::Iso, Lens::DEFAULT, aspect)?;
//! let image = render(&mesh, &camera.view(width, height)?, width, height, &RenderOptions::default())?;
//! let file = image.to_png()?;
//! # assert!(!file.is_empty());
//! # Ok::<(), raster::RasterError>(())
//! ```

mod camera;
pub mod clip;
mod error;
pub mod fixed;
mod framing;
mod image;
mod normals;
mod pipeline;
mod png_file;
pub mod projection;
pub mod shade;
pub mod viewport;

pub use camera::{Camera, Frame, Lens, View, look_at};
pub use csg::Mesh;
pub use error::{MAX_SIZE, RasterError};
pub use framing::StandardView;
pub use image::Image;
pub use normals::{CREASE_ANGLE, corner_normals};
pub use pipeline::{RenderOptions, render};
pub use shade::{Light, Material};
pub use viewport::{Viewport, YAxis};
