//! The projection and Z-buffer pipeline: from a [`Mesh`] and a camera to a
//! picture.
//!
//! ```no_run
//! use raster::{RenderOptions, Scene};
//! # use glam::DVec3;
//! # let part = csg::Mesh::new(
//! #     vec![DVec3::X, DVec3::Y, DVec3::Z],
//! #     vec![[0, 1, 2]],
//! # );
//! let scene = Scene::new().add(part);
//! let options = RenderOptions::presentation().size(640, 480);
//! let image = scene.render(&scene.camera(&options)?, &options)?;
//! image.save("part.png")?;
//! # Ok::<(), raster::RasterError>(())
//! ```
//!
//! A [`Scene`] has [`Part`]s, each a mesh with its places, colour,
//! [`Finish`], [`Material`] or [`Texture`], and [`Light`]s. To draw it more
//! than once, [`Scene::prepare`] it and keep a [`Renderer`]; what a frame did
//! and did not have to do is in its [`Stats`].
//!
//! # A tour of the pipeline
//!
//! Every stage has a page that names its formulas and where they come from,
//! and one picture. The pictures are drawn by the example `tour`, which shows
//! how, and are kept as a test.
//!
//! ## 1. Transforms: [`transform`]
//!
//! Translation, scaling, shear, rotation, change of basis, Euler angles, and
//! the matrix that normals need. Column vectors, right-handed axes, Z up.
//! Points move, directions do not: w = 1 and w = 0. A letter as it is, scaled
//! along a slanted frame, sheared, rotated about (1, 1, 1) and mirrored:
//!
//! ![transforms]
//!
//! ## 2. Viewing: [`Camera`], [`view_reference`]
//!
//! [`look_at`] and the camera's [`Frame`] U, V, N take the world to eye
//! coordinates: the camera at the origin, looking along -Z. The
//! view-reference model does the same from VRP, VPN and VUP. Either gives a
//! [`View`], proven to be finite and invertible; [`Camera::framing`] finds the
//! camera that shows the whole of a mesh. On the left a camera with U (red),
//! V (green) and N (blue) and the box that it sees, on the right what it sees:
//!
//! ![viewing]
//!
//! ## 3. Projection: [`projection`]
//!
//! Eye to clip coordinates: perspective, orthographic and oblique (cavalier
//! and cabinet).
//!
//! ![projection]
//!
//! ## 4. Clipping: [`clip`], [`cohen_sutherland`]
//!
//! Before the division by w, so that what lies behind the eye is cut off, not
//! turned inside out. A guard band of 16,384 pixels around the picture spares
//! nearly all triangles the clipping at its sides. Here the camera is inside
//! a hollow ball, and most triangles reach behind it:
//!
//! ![clipping]
//!
//! ## 5. Viewport: [`viewport`]
//!
//! Division by w, and pixels. [`Viewport::unproject`] goes the other way, and
//! [`Renderer::pick`] says what a pixel shows. One view on two screens, and
//! where [`Viewport::project`] finds a point of the small ball on either:
//!
//! ![viewport]
//!
//! ## 6. Filling: [`fixed`], [`scanline`]
//!
//! Corners are snapped to 1/256 pixel; from there on coverage is exact integer
//! arithmetic with the top-left rule, so that triangles that share an edge
//! leave no gap and draw no pixel twice. [`fixed::covers`] is the definition,
//! [`scanline`] the classical way of filling, and the fast filler takes
//! sixteen pixels at a time. Attributes are interpolated perspective-correctly.
//! Which triangle covers each pixel:
//!
//! ![filling]
//!
//! ## 7. Hidden surfaces: [`hidden_surface`]
//!
//! The painter's algorithm sorts triangles, which fails where they cut each
//! other (left); the depth buffer compares pixels (right).
//!
//! ![hidden-surfaces]
//!
//! The fast pipeline keeps depth reversed (1 near, 0 far), which spreads the
//! precision of floats evenly, and the farthest depth of each 8x8 square, to
//! leave out whole triangles and clusters behind it.
//!
//! ## 8. Shading: [`shade`]
//!
//! The Phong reflection model, evaluated once a triangle (flat), at its
//! corners (Gouraud) or at each pixel (Phong). Light is linear inside and
//! encoded as sRGB at the end.
//!
//! ![shading]
//!
//! ## 9. Anti-aliasing: [`AntiAliasing`]
//!
//! Coverage at four or eight samples a pixel with shading once, or everything
//! at more samples. None, four, eight, and supersampling; pixels enlarged:
//!
//! ![anti-aliasing]
//!
//! ## 10. Other outputs: [`Buffer`]
//!
//! Depth, normals, surfaces, and how open each pixel is to light from
//! everywhere.
//!
//! ![outputs]
//!
//! ## 11. What engineers look at: [`EdgeOptions`], [`SectionPlane`]
//!
//! Feature edges, silhouettes and, dashed, hidden ones; wireframe and
//! vertices; sections with hatched caps; ambient occlusion, a ground shadow
//! and the axes.
//!
//! ![engineering]
//!
//! ## 12. Series: [`contact_sheet`], [`turntable`]
//!
//! Four views on one sheet, and the frames of an animation.
//!
//! ![series]
//!
//! # How the fast pipeline works
//!
//! 1. A [`Prepared`] scene holds all meshes in single precision around its centre, cut
//!    into clusters of at most 256 triangles.
//! 2. Clusters outside the view volume, facing away or behind what is drawn
//!    are left out whole; the others are taken front to back in a few
//!    batches.
//! 3. Vertices of a cluster are transformed once, triangles set up sixteen at
//!    a time and sorted into tiles of 64x64 pixels.
//! 4. Each tile is filled by one thread into a visibility buffer: depth and
//!    triangle number, in blocks of 4x4 pixels.
//! 5. Each pixel is shaded once, from the triangle it shows.
//!
//! Equal depths go to the triangle that comes first in the mesh, every vector
//! operation has one defined result, and so pictures are the same to the byte
//! for any number of threads and at every [`Level`] of instruction set.
//! [`render_reference`] is the pipeline by the book, which the fast one is
//! tested against.
//!
#![doc = include_str!("../docs/pictures.md")]

mod blend;
mod buffers;
mod camera;
pub mod clip;
mod cluster;
pub mod cohen_sutherland;
mod corners;
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
mod hatch;
pub mod hidden_surface;
mod image;
mod interpolate;
mod light;
mod line;
mod look;
mod normals;
mod occlusion;
mod options;
mod part;
mod pipeline;
mod png_file;
mod prepared;
pub mod projection;
mod reference;
mod resolve;
pub mod scanline;
mod scene;
mod section;
mod series;
mod set_up;
pub mod shade;
mod show;
mod silhouette;
mod simd;
mod smooth;
mod stats;
mod texture;
mod tile;
pub mod transform;
mod transparent;
mod triad;
pub mod view_reference;
mod viewpoint;
pub mod viewport;

pub use buffers::{Buffer, Pick, depth_image, id_image, normal_image};
pub use camera::{Camera, Frame, Lens, View, look_at};
pub use csg::Mesh;
pub use edges::{EdgeOptions, HiddenEdges, MAX_LINE_WIDTH};
pub use error::{MAX_SIZE, RasterError};
pub use framing::{Framing, StandardView};
pub use image::Image;
pub use light::Light;
pub use normals::{CREASE_ANGLE, corner_normals};
pub use occlusion::occlusion_image;
pub use options::{AntiAliasing, RenderOptions};
pub use part::Part;
pub use pipeline::{Renderer, render};
pub use prepared::Prepared;
pub use reference::render_reference;
pub use scene::Scene;
pub use section::{MAX_SECTIONS, SectionPlane};
pub use series::{contact_sheet, turntable, turntable_camera, write_apng};
pub use shade::{Finish, Interpolation, Material};
pub use show::Show;
pub use simd::Level;
pub use stats::Stats;
pub use texture::{Mapping, Texture};
pub use viewpoint::clear_view;
pub use viewport::{Viewport, YAxis};
