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

mod buffers;
mod camera;
pub mod clip;
pub mod cohen_sutherland;
mod cull;
mod deferred;
mod edges;
mod error;
mod fill;
pub mod fixed;
mod frame;
mod framing;
mod geometry;
mod ground;
pub mod hidden_surface;
mod image;
mod line;
mod normals;
mod occlusion;
mod options;
mod pipeline;
mod png_file;
pub mod projection;
mod reference;
mod resolve;
pub mod scanline;
mod scene;
mod section;
mod series;
pub mod shade;
mod simd;
mod stats;
mod tile;
pub mod transform;
mod triad;
pub mod view_reference;
pub mod viewport;

pub use buffers::{Buffer, Pick, depth_image, id_image, normal_image};
pub use camera::{Camera, Frame, Lens, View, look_at};
pub use csg::Mesh;
pub use edges::{EdgeOptions, HiddenEdges};
pub use error::{MAX_SIZE, RasterError};
pub use framing::StandardView;
pub use image::Image;
pub use normals::{CREASE_ANGLE, corner_normals};
pub use occlusion::occlusion_image;
pub use options::{AntiAliasing, RenderOptions};
pub use pipeline::{Renderer, render};
pub use reference::render_reference;
pub use scene::Scene;
pub use section::{MAX_SECTIONS, SectionPlane};
pub use series::{contact_sheet, turntable, turntable_camera, write_apng};
pub use shade::{Interpolation, Light, Material};
pub use simd::Level;
pub use stats::Stats;
pub use viewport::{Viewport, YAxis};
