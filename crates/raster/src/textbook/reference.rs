//! The pipeline as it is taught, in double precision and one thread: clip,
//! divide, snap, sort, fill by scan lines, shade. The fast pipeline is tested
//! against it.

use std::ops::Range;

use csg::{Color, Mesh};
use glam::{DVec2, DVec3, Vec3};

use crate::RasterError;
use crate::camera::View;
use crate::clip::{ClipVertex, clip_triangle};
use crate::cohen_sutherland::Rectangle;
use crate::error::MAX_SIZE;
use crate::fixed::{doubled_area, snap};
use crate::hidden_surface::{HiddenSurface, WindowTriangle};
use crate::image::Image;
use crate::normals::{CREASE_ANGLE, corner_normals};
use crate::options::RenderOptions;
use crate::resolve::encode;
use crate::scanline::{rows_of, scan_convert_rows};
use crate::shade::{Incident, Interpolation, Material, phong};
use crate::viewport::Viewport;

/// Draws a mesh like [`render`](crate::render), slowly and by the book, with
/// either way of finding hidden surfaces. Anti-aliasing is not part of it.
///
/// # Errors
/// [`RasterError::SizeTooLarge`] above [`MAX_SIZE`] pixels a side.
pub fn render_reference(
    mesh: &Mesh,
    view: &View,
    width: u32,
    height: u32,
    options: &RenderOptions,
    hidden_surface: &mut dyn HiddenSurface,
) -> Result<Image, RasterError> {
    if width.max(height) > MAX_SIZE {
        return Err(RasterError::SizeTooLarge { width, height });
    }
    let mut image = Image::new(width, height, encode(options.background));
    let mut triangles = project_triangles(mesh, view, width, height, options.cull_back_faces);
    hidden_surface.sort(&mut triangles);
    let shader = Shader {
        mesh,
        view,
        options,
        normals: corner_normals(mesh, CREASE_ANGLE),
    };
    let mut fill =
        |hidden_surface: &mut dyn HiddenSurface, triangle: &WindowTriangle, rows: Range<i32>| {
            // Interpolated linearly: depth, 1/w and the weights divided by w.
            let values = std::array::from_fn(|k| {
                let w = triangle.inverse_w[k];
                let [a, b, c] = triangle.weights[k].map(|weight| weight * w);
                [triangle.depth[k], w, a, b, c]
            });
            scan_convert_rows(triangle.corners, values, width as i32, rows, |span| {
                for x in span.start..span.end {
                    let at = |k: usize| span.values[k] + span.step[k] * f64::from(x - span.start);
                    let pixel = span.y as usize * width as usize + x as usize;
                    if hidden_surface.accepts(pixel, at(0)) {
                        let weights = [at(2), at(3), at(4)].map(|weight| weight / at(1));
                        image.pixels[pixel] = encode(shader.colour(triangle.triangle, weights));
                    }
                }
            });
        };
    if !hidden_surface.is_by_rows() {
        for triangle in &triangles {
            fill(hidden_surface, triangle, 0..height as i32);
        }
        return Ok(image);
    }
    // Triangles by the row where they begin.
    let mut waiting = vec![Vec::new(); height as usize];
    for (index, triangle) in triangles.iter().enumerate() {
        let rows = rows_of(triangle.corners);
        if let Some(row) = waiting.get_mut(rows.start.max(0) as usize) {
            row.push(index);
        }
    }
    let mut active: Vec<usize> = Vec::new();
    for (y, beginning) in (0..height as i32).zip(waiting) {
        hidden_surface.begin_row();
        active.retain(|&index| rows_of(triangles[index].corners).end > y);
        active.extend(beginning);
        // Equal depths show what comes first.
        active.sort_unstable();
        for &index in &active {
            fill(hidden_surface, &triangles[index], y..y + 1);
        }
    }
    Ok(image)
}

/// Draws the edges of a mesh's triangles, hidden ones as well, one pixel wide:
/// clipped to the near plane, divided, clipped to the window
/// ([`cohen_sutherland`](crate::cohen_sutherland)), and stepped along the longer
/// axis (digital differential analyser).
///
/// # Errors
/// [`RasterError::SizeTooLarge`] above [`MAX_SIZE`] pixels a side.
pub fn wireframe_reference(
    mesh: &Mesh,
    view: &View,
    width: u32,
    height: u32,
    color: Color,
    background: Color,
) -> Result<Image, RasterError> {
    if width.max(height) > MAX_SIZE {
        return Err(RasterError::SizeTooLarge { width, height });
    }
    let mut image = Image::new(width, height, encode(background));
    let viewport = Viewport::of_image(width, height);
    let window = Rectangle {
        low: DVec2::ZERO,
        high: DVec2::new(viewport.width, viewport.height),
    };
    let ink = encode(color);
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for &[a, b, c] in &mesh.triangles {
        edges.extend([[a, b], [b, c], [c, a]].map(|[i, j]| [i.min(j), i.max(j)]));
    }
    edges.sort_unstable();
    edges.dedup();
    let clip = |v: u32| {
        let p = mesh.positions.get(v as usize)?;
        Some(view.world_to_clip() * p.extend(1.0))
    };
    for [a, b] in edges {
        let (Some(a), Some(b)) = (clip(a), clip(b)) else {
            continue;
        };
        // What is before the near plane: z >= -w.
        let (da, db) = (a.z + a.w, b.z + b.w);
        if !(da > 0.0 || db > 0.0) {
            continue;
        }
        let crossing = a.lerp(b, da / (da - db));
        let ends = [
            if da > 0.0 { a } else { crossing },
            if db > 0.0 { b } else { crossing },
        ];
        let [p, q] = ends.map(|p| viewport.from_ndc(p.truncate() / p.w).truncate());
        let Some((p, q)) = window.clip(p, q) else {
            continue;
        };
        let steps = (q - p).abs().max_element().ceil().max(1.0) as u32;
        for k in 0..=steps {
            let at = p.lerp(q, f64::from(k) / f64::from(steps));
            let (x, y) = (at.x as u32, at.y as u32);
            if x < width && y < height {
                image.pixels[(y * width + x) as usize] = ink;
            }
        }
    }
    Ok(image)
}

/// Clips, divides and snaps the triangles of a mesh.
fn project_triangles(
    mesh: &Mesh,
    view: &View,
    width: u32,
    height: u32,
    cull: bool,
) -> Vec<WindowTriangle> {
    let viewport = Viewport::of_image(width, height);
    // The sign of a front face's area, with y downwards.
    let front = if view.world_to_clip().determinant() < 0.0 {
        -1
    } else {
        1
    };
    let (mut polygon, mut scratch) = (Vec::new(), Vec::new());
    let mut triangles = Vec::new();
    for (index, &triangle) in mesh.triangles.iter().enumerate() {
        let Some(corners) = positions(mesh, triangle) else {
            continue;
        };
        let clip = corners.map(|p| view.world_to_clip() * p.extend(1.0));
        clip_triangle(clip, &mut polygon, &mut scratch);
        let project = |v: &ClipVertex| {
            let p = viewport.from_ndc(v.position.truncate() / v.position.w);
            Some(([snap(p.x)?, snap(p.y)?], p.z, v.position.w.recip()))
        };
        for k in 2..polygon.len() {
            let fan = [polygon[0], polygon[k - 1], polygon[k]];
            let [Some(a), Some(b), Some(c)] =
                [project(&fan[0]), project(&fan[1]), project(&fan[2])]
            else {
                continue;
            };
            let area = doubled_area([a.0, b.0, c.0]) * front;
            if area == 0 || (cull && area < 0) {
                continue;
            }
            triangles.push(WindowTriangle {
                corners: [a.0, b.0, c.0],
                depth: [a.1, b.1, c.1],
                inverse_w: [a.2, b.2, c.2],
                weights: fan.map(|v| v.weights),
                triangle: index as u32,
            });
        }
    }
    triangles
}

/// The corners of a triangle, unless it names a vertex that is not there.
fn positions(mesh: &Mesh, triangle: [u32; 3]) -> Option<[DVec3; 3]> {
    let at = |i: u32| mesh.positions.get(i as usize).copied();
    Some([at(triangle[0])?, at(triangle[1])?, at(triangle[2])?])
}

struct Shader<'a> {
    mesh: &'a Mesh,
    view: &'a View,
    options: &'a RenderOptions,
    normals: Vec<[Vec3; 3]>,
}

impl Shader<'_> {
    /// The colour of a triangle at the point of the given weights.
    fn colour(&self, triangle: u32, weights: [f64; 3]) -> Color {
        let index = triangle as usize;
        let Some(corners) = positions(self.mesh, self.mesh.triangles[index]) else {
            return self.options.background;
        };
        let surface = self.mesh.surface_of(index);
        let color = surface
            .and_then(|surface| surface.color)
            .unwrap_or(self.options.default_color);
        let material = Material::new(color, self.options.finish);
        let normals = self.normals[index].map(Vec3::as_dvec3);
        let mix = |v: [DVec3; 3]| v[0] * weights[0] + v[1] * weights[1] + v[2] * weights[2];
        let rgb = match self.options.interpolation {
            Interpolation::Phong => self.reflect(&material, mix(corners), mix(normals)),
            Interpolation::Gouraud => {
                let at = |k: usize| self.reflect(&material, corners[k], normals[k]).as_dvec3();
                mix([at(0), at(1), at(2)]).as_vec3()
            }
            Interpolation::Flat => {
                let [a, b, c] = corners;
                self.reflect(&material, (a + b + c) / 3.0, (b - a).cross(c - a))
            }
        };
        Color::from_linear(rgb.clamp(Vec3::ZERO, Vec3::ONE).to_array())
    }

    fn reflect(&self, material: &Material, point: DVec3, normal: DVec3) -> Vec3 {
        let viewer = self.view.towards_viewer(point);
        let mut normal = normal.normalize_or_zero();
        if self.options.two_sided && normal.dot(viewer) < 0.0 {
            normal = -normal;
        }
        let lights: Vec<Incident> = self
            .options
            .lights
            .iter()
            .filter_map(|light| {
                let source = light.source(self.view)?;
                Some(source.at(point, normal.as_vec3(), viewer.as_vec3(), light.intensity()))
            })
            .collect();
        phong(material, &lights, normal.as_vec3(), viewer.as_vec3())
    }
}
