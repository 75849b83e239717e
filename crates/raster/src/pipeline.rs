//! The pipeline from a mesh and a view to a picture.

use csg::{Color, Mesh};
use glam::{DVec3, DVec4, Vec3};

use crate::camera::View;
use crate::clip::{ClipVertex, clip_triangle};
use crate::error::{MAX_SIZE, RasterError};
use crate::fixed::{FixedPoint, SUBPIXELS, covers, doubled_area, snap};
use crate::image::Image;
use crate::normals::{CREASE_ANGLE, corner_normals};
use crate::shade::{Incident, Light, Material, phong};
use crate::viewport::Viewport;

/// What a picture looks like, apart from the mesh and the view.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RenderOptions {
    /// Colour behind the mesh; transparent by default.
    pub background: Color,
    /// Colour of surfaces that have none.
    pub default_color: Color,
    /// Lights of the scene.
    pub lights: Vec<Light>,
    /// Whether triangles that face away from the viewer are left out.
    pub cull_back_faces: bool,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            background: Color::from_linear([0.0; 3]).with_alpha(0.0),
            default_color: Material::default_color(),
            lights: Light::default_rig(),
            cull_back_faces: true,
        }
    }
}

/// Draws a mesh as seen by `view` into a picture of `width` x `height`
/// pixels.
///
/// # Errors
/// [`RasterError::SizeTooLarge`] above [`MAX_SIZE`] pixels a side.
pub fn render(
    mesh: &Mesh,
    view: &View,
    width: u32,
    height: u32,
    options: &RenderOptions,
) -> Result<Image, RasterError> {
    if width.max(height) > MAX_SIZE {
        return Err(RasterError::SizeTooLarge { width, height });
    }
    let mut image = Image::new(width, height, encode(options.background));
    if image.pixels.is_empty() {
        return Ok(image);
    }
    let viewport = Viewport::of_image(width, height);
    let normals = corner_normals(mesh, CREASE_ANGLE);
    let mut depth = vec![1.0f64; image.pixels.len()];
    let (mut polygon, mut scratch) = (Vec::new(), Vec::new());
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let Some(corners) = positions(mesh, *triangle) else {
            continue;
        };
        clip_triangle(
            corners.map(|p| view.world_to_clip() * p.extend(1.0)),
            &mut polygon,
            &mut scratch,
        );
        let color = mesh
            .surface_of(index)
            .and_then(|surface| surface.color)
            .unwrap_or(options.default_color);
        let material = Material::of_color(color);
        let shade = |weights: [f64; 3]| {
            let mix = |v: [DVec3; 3]| v[0] * weights[0] + v[1] * weights[1] + v[2] * weights[2];
            let point = mix(corners);
            let normal = mix(normals[index].map(Vec3::as_dvec3)).normalize_or_zero();
            let viewer = view.towards_viewer(point);
            let lights: Vec<Incident> = options
                .lights
                .iter()
                .map(|light| incident(light, view, point, viewer))
                .collect();
            let rgb = phong(&material, &lights, normal.as_vec3(), viewer.as_vec3());
            encode(Color::from_linear(
                rgb.clamp(Vec3::ZERO, Vec3::ONE).to_array(),
            ))
        };
        for i in 2..polygon.len() {
            let fan = [polygon[0], polygon[i - 1], polygon[i]];
            fill(
                fan,
                &viewport,
                options.cull_back_faces,
                |x, y, z, weights| {
                    let at = y as usize * width as usize + x as usize;
                    if z < depth[at] {
                        depth[at] = z;
                        image.pixels[at] = shade(weights);
                    }
                },
            );
        }
    }
    Ok(image)
}

/// The corners of a triangle, unless it names a vertex that is not there.
fn positions(mesh: &Mesh, triangle: [u32; 3]) -> Option<[DVec3; 3]> {
    let at = |i: u32| mesh.positions.get(i as usize).copied();
    Some([at(triangle[0])?, at(triangle[1])?, at(triangle[2])?])
}

/// The light of one source at a point.
fn incident(light: &Light, view: &View, point: DVec3, viewer: DVec3) -> Incident {
    let (towards, intensity) = match *light {
        Light::Ambient { intensity } => (DVec3::ZERO, intensity),
        Light::Directional { towards, intensity } => (towards, intensity),
        Light::Point {
            position,
            intensity,
        } => (position - point, intensity),
        Light::Head { intensity } => (viewer, intensity),
        Light::Camera { towards, intensity } => (
            view.world_to_eye().inverse().transform_vector3(towards),
            intensity,
        ),
    };
    Incident {
        towards: towards.normalize_or_zero().as_vec3(),
        intensity,
    }
}

/// A linear colour as an 8-bit sRGB pixel.
fn encode(color: Color) -> [u8; 4] {
    let [r, g, b] = color.to_srgb();
    [r, g, b, color.alpha].map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// Calls `fragment` with column, row, depth and perspective-correct weights
/// for every pixel that a clipped triangle covers.
fn fill(
    triangle: [ClipVertex; 3],
    viewport: &Viewport,
    cull: bool,
    mut fragment: impl FnMut(i32, i32, f64, [f64; 3]),
) {
    let inverse_w = triangle.map(|v| 1.0 / v.position.w);
    let window = triangle.map(|v: ClipVertex| {
        let p: DVec4 = v.position;
        viewport.from_ndc(p.truncate() / p.w)
    });
    let mut points: [FixedPoint; 3] = [[0; 2]; 3];
    for (point, p) in points.iter_mut().zip(window) {
        let (Some(x), Some(y)) = (snap(p.x), snap(p.y)) else {
            return;
        };
        *point = [x, y];
    }
    // Counter-clockwise in space is clockwise's opposite with y downwards.
    let area = doubled_area(points);
    if area == 0 || (cull && area > 0) {
        return;
    }
    let pixel = |v: i32| v >> crate::fixed::SUBPIXEL_BITS;
    let low = |axis: usize| pixel(points.iter().map(|p| p[axis]).min().unwrap_or(0)).max(0);
    let high = |axis: usize, size: f64| {
        pixel(points.iter().map(|p| p[axis]).max().unwrap_or(-1)).min(size as i32 - 1)
    };
    for y in low(1)..=high(1, viewport.height) {
        for x in low(0)..=high(0, viewport.width) {
            let sample = [x, y].map(|v| v * SUBPIXELS + SUBPIXELS / 2);
            if !covers(points, sample) {
                continue;
            }
            let area = area as f64;
            let e =
                |a: usize, b: usize| crate::fixed::edge(points[a], points[b], sample) as f64 / area;
            let flat = [e(1, 2), e(2, 0), e(0, 1)];
            let z = (0..3).map(|i| flat[i] * window[i].z).sum();
            let w: f64 = (0..3).map(|i| flat[i] * inverse_w[i]).sum();
            let mut weights = [0.0; 3];
            for (i, vertex) in triangle.iter().enumerate() {
                for (weight, part) in weights.iter_mut().zip(vertex.weights) {
                    *weight += part * flat[i] * inverse_w[i] / w;
                }
            }
            fragment(x, y, z, weights);
        }
    }
}
