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
//! # Where the texts' formulas are
//!
//! Each is tested with the numbers that textbooks print, in `tests/textbook/`
//! unless another file is named.
//!
//! | formula | here | test |
//! | --- | --- | --- |
//! | orthographic = scaling · translation | [`projection::box_scaling`], [`projection::orthographic_translation`] | `orthographic_is_scaling_times_translation` |
//! | frustum = scaling · perspective · shear; m\[8\] | [`projection::frustum_to_box`], [`projection::shear_to_axis`] | `frustum_is_scaling_perspective_shear` |
//! | symmetric frustum, from width and height, from the field of view | [`projection::symmetric_frustum`], [`projection::perspective`] | `symmetric_frustum_has_simple_rows` |
//! | 90 degrees on 400 by 320 | [`projection::perspective`] | `ninety_degrees_on_400_by_320` |
//! | x* = h x / (z + h); z* = z / (z + h), h z / (z + h), (z - h) / (z + h) | [`projection::one_point`], [`projection::perspective_depth`], [`projection::normalised_perspective_depth`] | `perspective_with_h` |
//! | pinhole at distance d, w = z / d | [`projection::pinhole`] | `pinhole_with_d` |
//! | row vectors: T, S, Rx, Ry, Rz; (W X Y Z) | [`transform::for_row_vectors`], [`transform::for_row_vectors_w_first`] | `row_vectors_take_transposes` |
//! | A = T R from C, D and V' (U = N × V, left-handed) | [`Frame::left_handed`] | `viewing_from_c_along_n` |
//! | left-handed frames through projection and view | [`projection::left_handed`] | `left_handed_frames_give_the_same_picture` |
//! | M_v = R_v T_v | [`look_at`] | `look_at_has_the_printed_rows` |
//! | viewport as a matrix, z_max; depth range | [`Viewport::matrix`], [`viewport::depth_in_range`] | `viewport_is_a_matrix` |
//! | depth as integers up to z_max | [`Renderer::integer_depth_buffer`] | `depths_are_integers_up_to_z_max` |
//! | outcodes A to E | [`cohen_sutherland`] | `outcodes_a_to_e` |
//! | homogeneous coordinates, their difference, points and directions | [`transform::cartesian`], [`transform::homogeneous_difference`] | `homogeneous_coordinates` |
//! | affine maps as matrices of rows | [`transform::from_frame`] | `affine_maps_are_matrices` |
//! | T(-t), S(1/s), Rᵀ, and (Rᵀ, -Rᵀ t) of a rigid motion; scaling about any point | [`transform::rigid_inverse`], [`transform::scaling_about`] | `inverses_need_no_division` |
//! | shears and their inverses | [`transform::shear`] | `shears_and_their_inverses` |
//! | rotation about (l, m, n), about any point | [`transform::rotation`] | `rotation_about_l_m_n` |
//! | rotation from u to v, change of basis, scaling in a frame | [`transform::rotation_between`], [`transform::change_of_basis`], [`transform::scaling_in_frame`] | `rotation_from_u_to_v_and_changes_of_basis` |
//! | E(h, p, r) = Ry Rx Rz, its inverse, gimbal lock | [`transform::Euler`] | `euler_transform_has_the_printed_elements` |
//! | extraction in every order, either convention at the lock | [`transform::EulerOrder`], [`transform::GimbalLock`] | `euler_angles_in_every_order` |
//! | Euler angles of a camera; of a solid | [`Camera::turned`]; `csg::Solid::rotate_euler` | `cameras_turn_by_euler_angles`; `rotate_euler_is_ry_rx_rz` in `csg` |
//! | the array order of OpenGL | [`transform::opengl_array`] | `opengl_takes_columns` |
//! | G = adj(M) transposed | [`transform::normal_matrix`] | `normals_take_the_adjugate`, `model_matrices_carry_points_and_normals` in `tests/scene.rs` |
//! | M_c = M_p M_v M_m; parts with model matrices | [`View`], [`Part`] | `matrices_compose`, `tests/scene.rs` |
//! | project; unproject(x, y, z_object) | [`Viewport::project`], [`Viewport::unproject_at_z`] | `unprojecting_to_a_plane_of_the_object` |
//! | VRP, VPN, VUP, window, PRP, DOP; `csg render --vpn ...` | [`view_reference`] | `view_references_make_pictures` |
//! | textures: checkers by place, and by the parameters u, v of surfaces | [`Texture`], [`Texture::on_surface`] | `checkers_have_squares`, `checkers_go_by_the_parameters_of_surfaces` in `tests/scene.rs` |
//! | I = Ka Iamb + Σ (Kd Iin (L·N) + Ks Iin (R·V)^n), per channel, several lights | [`shade::phong`], [`Finish`], [`Light`] | `phong_with_the_printed_coefficients`, `materials_are_those_of_the_texts` in `tests/scene.rs` |
//! | interpolation along edges and rows (za, zb, xa, xb, z*) | [`scanline`] | `scan_lines_interpolate_linearly` |
//! | planes, spheres, quadrics; a cylinder as three half-spaces f <= 0 | `csg::Solid` | `equations_are_the_primitives`, `a_cylinder_is_three_half_spaces` |
//! | vertex, edge and face tables; orientation; back-face removal | [`polygon_model`] | `polygon_tables`, `concave_polygons_become_triangles`, `polygons_of_many_sides_are_scan_converted` |
//! | painter, depth buffer, scan-line depth buffer | [`hidden_surface`] | `the_painter_fails_and_depth_buffers_do_not`, `scan_line_buffers_draw_what_depth_buffers_draw` |
//! | lines clipped before and after the division | [`wireframe_reference`] | `wireframes_are_clipped` |
//!
//! Where texts have misprints the formulas hold: the third row of the matrix for
//! (z - h) / (z + h) has 1/h, not 2/h, and angles are atan2(y, x) with y first.
//!
//! # Where things are
//!
//! `textbook/` holds the formulas and the reference pipeline, `engine/` the fast
//! one, `overlay/` what is drawn over its pictures, `output/` pictures and files.
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
#![doc = include_str!(concat!(env!("OUT_DIR"), "/pictures.md"))]

mod camera;
mod engine;
mod error;
mod framing;
mod options;
mod output;
mod overlay;
mod part;
mod scene;
mod textbook;
mod viewpoint;

use engine::{
    caps, cluster, corners, cull, deferred, fill, fill_tile, frame, geometry, hatch, interpolant,
    interpolate, light, look, normals, pipeline, prepared, resolve, section, set_up, shading, simd,
    smooth, stats, texture, tile, transparent,
};
use output::{buffer_images, buffers, gif_file, image, png_file, sheet, show, turntable};
use overlay::{
    blend, color_map, deviation, dimension, edges, explode, ground, lettering, line, occlusion,
    refine, silhouette, thickness, triad, visible,
};
pub use textbook::{
    clip, cohen_sutherland, fixed, hidden_surface, polygon_model, projection, scanline, shade,
    transform, view_reference, viewport,
};
use textbook::{euler, reference};

pub use buffer_images::{depth_image, id_image, normal_image};
pub use buffers::{Buffer, Pick};
pub use camera::{Camera, Frame, Lens, View, look_at};
pub use color_map::{ColorBy, Legend, draw_legend, name_color, ramp};
pub use csg::Mesh;
pub use deviation::color_by_deviation;
pub use dimension::{Dimension, draw_dimensions, draw_scale_bar, written, written_within};
pub use edges::{EdgeOptions, HiddenEdges, MAX_LINE_WIDTH};
pub use error::{MAX_SIZE, RasterError};
pub use explode::exploded;
pub use framing::{Framing, StandardView};
pub use gif_file::write_gif;
pub use image::Image;
pub use light::Light;
pub use normals::{CREASE_ANGLE, corner_normals};
pub use occlusion::occlusion_image;
pub use options::{AntiAliasing, RenderOptions};
pub use part::Part;
pub use pipeline::{Renderer, render};
pub use png_file::{integer_depth_png, write_apng};
pub use prepared::Prepared;
pub use reference::{render_reference, wireframe_reference};
pub use scene::Scene;
pub use section::{MAX_SECTIONS, SectionPlane};
pub use shade::{Finish, Interpolation, Material};
pub use sheet::{ProjectionAngle, contact_sheet, ink_on};
pub use show::Show;
pub use simd::Level;
pub use stats::Stats;
pub use texture::{Mapping, Texture};
pub use turntable::{turntable, turntable_camera};
pub use viewpoint::clear_view;
pub use viewport::{Viewport, YAxis};
