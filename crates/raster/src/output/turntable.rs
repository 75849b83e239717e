//! Turntables: a camera goes round a scene.

use csg::Mesh;
use glam::DQuat;

use crate::RasterError;
use crate::camera::{Camera, Lens};
use crate::framing::StandardView;
use crate::image::Image;
use crate::options::RenderOptions;
use crate::pipeline::Renderer;
use crate::prepared::{Prepared, finite_bounds};

/// Draws `frames` pictures of a scene while the camera goes once round it,
/// about the upward axis through its target.
///
/// # Errors
/// Those of [`Camera::view`] and [`Renderer::draw`].
pub fn turntable(
    scene: &Prepared,
    camera: &Camera,
    frames: u32,
    width: u32,
    height: u32,
    options: &RenderOptions,
) -> Result<Vec<Image>, RasterError> {
    let mut renderer = Renderer::default();
    let axis = camera.up.normalize_or(glam::DVec3::Z);
    (0..frames)
        .map(|frame| {
            let angle = std::f64::consts::TAU * f64::from(frame) / f64::from(frames);
            let turn = DQuat::from_axis_angle(axis, angle);
            let turned = Camera {
                eye: camera.target + turn * (camera.eye - camera.target),
                ..*camera
            };
            let mut image = Image::default();
            let view = turned.view(width, height)?;
            renderer.draw(scene, &view, width, height, options, &mut image)?;
            Ok(image)
        })
        .collect()
}

/// A camera for [`turntable`] that sees the mesh whole from all around: at
/// the distance at which its bounding sphere about the target fits.
///
/// # Errors
/// Those of [`Camera::framing`].
pub fn turntable_camera(
    mesh: &Mesh,
    view: StandardView,
    lens: Lens,
    aspect: f64,
) -> Result<Camera, RasterError> {
    let framed = Camera::standard(mesh, view, lens, aspect)?;
    let finite = || mesh.positions.iter().filter(|p| p.is_finite());
    let (low, high) = finite_bounds(&mesh.positions).ok_or(RasterError::NothingToFrame)?;
    let target = low + (high - low) / 2.0;
    let radius = finite()
        .map(|p| p.distance(target))
        .fold(0.0, f64::max)
        .max(f64::MIN_POSITIVE);
    let direction = (framed.target - framed.eye).normalize_or_zero();
    let (lens, distance) = match framed.lens {
        Lens::Perspective { fov_y } => {
            let half = (fov_y / 2.0).min(((fov_y / 2.0).tan() * aspect).atan());
            (framed.lens, radius / half.sin() * 1.05)
        }
        Lens::Orthographic { .. } => {
            let height = 2.1 * radius / aspect.min(1.0);
            (Lens::Orthographic { height }, 3.0 * radius)
        }
        Lens::Oblique { ratio, angle, .. } => {
            let height = 2.1 * radius * (1.0 + ratio) / aspect.min(1.0);
            let lens = Lens::Oblique {
                height,
                ratio,
                angle,
            };
            (lens, 3.0 * radius)
        }
    };
    Ok(Camera {
        eye: target - direction * distance,
        target,
        lens,
        near: (distance - 1.01 * radius).max(distance * 1e-3),
        far: distance + 1.01 * radius,
        ..framed
    })
}
