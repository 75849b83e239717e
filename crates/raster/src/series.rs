//! Several pictures in one: turntables and contact sheets.

use std::io::Write;

use csg::Mesh;
use glam::DQuat;

use crate::camera::{Camera, Lens};
use crate::framing::StandardView;
use crate::image::Image;
use crate::options::RenderOptions;
use crate::pipeline::Renderer;
use crate::prepared::Prepared;
use crate::{MAX_SIZE, RasterError};

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
    let (low, high) = mesh_bounds(mesh);
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

fn mesh_bounds(mesh: &Mesh) -> (glam::DVec3, glam::DVec3) {
    let finite = || mesh.positions.iter().copied().filter(|p| p.is_finite());
    let first = finite().next().unwrap_or_default();
    finite().fold((first, first), |(low, high), p| (low.min(p), high.max(p)))
}

/// Writes pictures of one size as an animated PNG that repeats for ever.
///
/// # Errors
/// [`RasterError::EmptyImage`] without frames or pixels, or if the frames
/// differ in size; [`RasterError::Png`] if the writer fails.
pub fn write_apng(
    frames: &[Image],
    frames_per_second: u16,
    writer: impl Write,
) -> Result<(), RasterError> {
    let (width, height) = frames.first().map_or((0, 0), |f| (f.width, f.height));
    let alike = frames
        .iter()
        .all(|f| (f.width, f.height) == (width, height));
    if width == 0 || height == 0 || !alike {
        return Err(RasterError::EmptyImage { width, height });
    }
    let mut encoder = png::Encoder::new(writer, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_animated(frames.len() as u32, 0)?;
    encoder.set_frame_delay(1, frames_per_second.max(1))?;
    let mut writer = encoder.write_header()?;
    for frame in frames {
        writer.write_image_data(frame.pixels.as_flattened())?;
    }
    writer.finish()?;
    Ok(())
}

/// Four views of a mesh on one sheet of `width` x `height` pixels: top and
/// iso above, front and right below, as in third-angle drawing; the three
/// orthographic ones to one scale.
///
/// # Errors
/// Those of [`Camera::standard`] and [`Renderer::draw`].
pub fn contact_sheet(
    mesh: &Mesh,
    scene: &Prepared,
    lens: Lens,
    width: u32,
    height: u32,
    options: &RenderOptions,
) -> Result<Image, RasterError> {
    if width.max(height) > MAX_SIZE {
        return Err(RasterError::SizeTooLarge { width, height });
    }
    let (w, h) = (width / 2, height / 2);
    let aspect = f64::from(w.max(1)) / f64::from(h.max(1));
    let plain = Lens::Orthographic { height: 1.0 };
    let mut cameras = Vec::new();
    for view in [StandardView::Top, StandardView::Front, StandardView::Right] {
        cameras.push(Camera::standard(mesh, view, plain, aspect)?);
    }
    let tallest = cameras
        .iter()
        .fold(0.0f64, |most, camera| match camera.lens {
            Lens::Orthographic { height } => most.max(height),
            _ => most,
        });
    for camera in &mut cameras {
        camera.lens = Lens::Orthographic { height: tallest };
    }
    cameras.insert(1, Camera::standard(mesh, StandardView::Iso, lens, aspect)?);
    let mut sheet = Image::new(width, height, crate::resolve::encode(options.background));
    let mut renderer = Renderer::default();
    for (k, camera) in cameras.iter().enumerate() {
        let mut image = Image::default();
        renderer.draw(scene, &camera.view(w, h)?, w, h, options, &mut image)?;
        let (x, y) = (k as u32 % 2 * (width - w), k as u32 / 2 * (height - h));
        sheet.paste(&image, x, y);
    }
    Ok(sheet)
}

impl Image {
    /// Copies a picture into this one, its top left corner at (`x`, `y`);
    /// what does not fit is left out.
    pub fn paste(&mut self, other: &Self, x: u32, y: u32) {
        let columns = other.width.min(self.width.saturating_sub(x)) as usize;
        let rows = other.height.min(self.height.saturating_sub(y)) as usize;
        for row in 0..rows {
            let from = row * other.width as usize;
            let to = (row + y as usize) * self.width as usize + x as usize;
            self.pixels[to..to + columns].copy_from_slice(&other.pixels[from..from + columns]);
        }
    }
}
