//! Section planes: what lies on one side is cut away, and the cut through
//! solid matter is capped and hatched.
//!
//! Cutting leaves an open mesh. Where a pixel then shows the back of a face,
//! its ray has entered solid matter through the cut: the pixel becomes part of
//! the cap, at the depth of the section plane. This needs no triangulation of
//! the cut and is right for every closed mesh and every sample.

use std::collections::HashMap;

use csg::Mesh;
use glam::{DMat4, DVec3, DVec4, Vec3, Vec4};

use crate::RasterError;
use crate::deferred::ShadeContext;
use crate::frame::FrameMatrix;
use crate::normals::{CREASE_ANGLE, corner_normals};
use crate::scene::Scene;
use crate::tile::{BLOCK, BLOCK_PIXELS, BLOCKS, NO_TRIANGLE, TileBuffer, capped};

/// Most section planes at once.
pub const MAX_SECTIONS: usize = 4;

/// A plane that cuts away the half-space on the side its normal points to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPlane {
    /// Normal, towards what is cut away; any length but zero.
    pub normal: DVec3,
    /// Any point of the plane.
    pub point: DVec3,
}

/// A section plane relative to a scene's centre: unit normal, and its product
/// with points on the plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    pub normal: Vec3,
    pub offset: f32,
    /// Unit vector in the plane across the hatching.
    pub hatch: Vec3,
}

impl Scene {
    /// Makes a mesh ready with parts of it cut away. Triangles are numbered
    /// after cutting.
    ///
    /// # Errors
    /// [`RasterError::BadSection`] for more than [`MAX_SECTIONS`] planes, or
    /// one whose normal is zero or not finite.
    pub fn with_sections(mesh: &Mesh, planes: &[SectionPlane]) -> Result<Self, RasterError> {
        let sound = |plane: &SectionPlane| {
            plane.normal.try_normalize().is_some() && plane.point.is_finite()
        };
        if planes.len() > MAX_SECTIONS || !planes.iter().all(sound) {
            return Err(RasterError::BadSection);
        }
        let mut cut = mesh.clone();
        if !planes.is_empty() {
            cut.corner_normals = corner_normals(mesh, CREASE_ANGLE);
        }
        for plane in planes {
            cut = cut_mesh(&cut, plane.normal.normalize(), plane.point);
        }
        let mut scene = Self::new(&cut);
        for (k, plane) in planes.iter().enumerate() {
            let normal = plane.normal.normalize();
            let (u, v) = normal.any_orthonormal_pair();
            let hatch = if k % 2 == 0 { u + v } else { u - v };
            scene.sections.push(Section {
                normal: normal.as_vec3(),
                offset: normal.dot(plane.point - scene.centre) as f32,
                hatch: hatch.normalize().as_vec3(),
            });
        }
        Ok(scene)
    }
}

/// The part of a mesh behind a plane. Vertices on cut edges are shared.
fn cut_mesh(mesh: &Mesh, normal: DVec3, point: DVec3) -> Mesh {
    let distance = |p: DVec3| normal.dot(p - point);
    let mut cut = Mesh {
        positions: mesh.positions.clone(),
        surfaces: mesh.surfaces.clone(),
        unit: mesh.unit,
        ..Mesh::default()
    };
    let with_surfaces = mesh.triangle_surfaces.len() == mesh.triangles.len();
    let mut crossings: HashMap<(u32, u32), u32> = HashMap::new();
    let mut outline = Vec::new();
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let Some(corners) = corners(mesh, *triangle) else {
            continue;
        };
        let d = corners.map(distance);
        let normals = mesh.corner_normals[index];
        let mut polygon: Vec<(u32, Vec3)> = Vec::with_capacity(4);
        let mut on_plane = Vec::with_capacity(2);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if d[i] <= 0.0 {
                polygon.push((triangle[i], normals[i]));
            }
            if (d[i] <= 0.0) != (d[j] <= 0.0) {
                let (from, to) = (triangle[i].min(triangle[j]), triangle[i].max(triangle[j]));
                let t = d[i] / (d[i] - d[j]);
                let at = corners[i].lerp(corners[j], t);
                let vertex = *crossings.entry((from, to)).or_insert_with(|| {
                    cut.positions.push(at);
                    cut.positions.len() as u32 - 1
                });
                polygon.push((vertex, normals[i].lerp(normals[j], t as f32)));
                on_plane.push(vertex);
            }
        }
        for k in 2..polygon.len() {
            let fan = [polygon[0], polygon[k - 1], polygon[k]];
            cut.triangles.push(fan.map(|(vertex, _)| vertex));
            cut.corner_normals.push(fan.map(|(_, normal)| normal));
            if with_surfaces {
                cut.triangle_surfaces.push(mesh.triangle_surfaces[index]);
            }
        }
        if on_plane.len() == 2 {
            outline.push(on_plane);
        }
    }
    if !mesh.feature_edges.is_empty() {
        for line in &mesh.feature_edges {
            for pair in line.windows(2) {
                let ends = [pair[0], pair[1]];
                let Some([a, b]) = ends_of(mesh, ends) else {
                    continue;
                };
                let (da, db) = (distance(a), distance(b));
                let key = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                match (da <= 0.0, db <= 0.0, crossings.get(&key)) {
                    (true, true, _) => cut.feature_edges.push(ends.to_vec()),
                    (true, false, Some(&middle)) => cut.feature_edges.push(vec![ends[0], middle]),
                    (false, true, Some(&middle)) => cut.feature_edges.push(vec![middle, ends[1]]),
                    _ => {}
                }
            }
        }
        cut.feature_edges.extend(outline);
    }
    // Vertices that were cut away would still count for framing.
    let mut used = vec![false; cut.positions.len()];
    for v in cut.triangles.iter().flatten() {
        used[*v as usize] = true;
    }
    let kept = used.iter().position(|u| *u).map(|k| cut.positions[k]);
    if let Some(kept) = kept {
        for (position, used) in cut.positions.iter_mut().zip(used) {
            if !used {
                *position = kept;
            }
        }
    }
    cut
}

fn corners(mesh: &Mesh, triangle: [u32; 3]) -> Option<[DVec3; 3]> {
    let at = |v: u32| mesh.positions.get(v as usize).copied();
    Some([at(triangle[0])?, at(triangle[1])?, at(triangle[2])?])
}

fn ends_of(mesh: &Mesh, [a, b]: [u32; 2]) -> Option<[DVec3; 2]> {
    let at = |v: u32| mesh.positions.get(v as usize).copied();
    Some([at(a)?, at(b)?])
}

/// The section planes of one frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Caps {
    planes: Vec<Option<CapPlane>>,
}

/// A section plane as seen: at the sample (x, y), in sub-pixels from the
/// middle of the picture, it shows the homogeneous point x·x_step + y·y_step +
/// origin, scaled so that W is 1.
#[derive(Clone, Copy, Debug)]
struct CapPlane {
    x_step: DVec4,
    y_step: DVec4,
    origin: DVec4,
    /// The row of the matrix that gives depth.
    depth: DVec4,
}

impl CapPlane {
    fn at(&self, x: f64, y: f64) -> DVec4 {
        self.x_step * x + self.y_step * y + self.origin
    }
}

impl Caps {
    pub fn new(sections: &[Section], matrix: &FrameMatrix) -> Self {
        let [x, y, z, w] = matrix.rows.map(Vec4::as_dvec4);
        let viewer = matrix.viewer;
        let planes = sections
            .iter()
            .map(|section| {
                // Only a cut that faces the viewer shows its cap.
                if section.normal.dot(viewer.truncate()) <= section.offset * viewer.w {
                    return None;
                }
                let plane = section.normal.extend(-section.offset).as_dvec4();
                let to_window = DMat4::from_cols(x, y, w, plane).transpose();
                let inverse = to_window.inverse();
                inverse.is_finite().then_some(CapPlane {
                    x_step: inverse.x_axis,
                    y_step: inverse.y_axis,
                    origin: inverse.z_axis,
                    depth: z,
                })
            })
            .collect();
        Self { planes }
    }

    /// The point of a cap at a sample, relative to the scene's centre.
    pub fn point(&self, plane: usize, x: f64, y: f64) -> Vec3 {
        self.planes
            .get(plane)
            .copied()
            .flatten()
            .map_or(Vec3::ZERO, |plane| {
                let p = plane.at(x, y);
                (p.truncate() / p.w).as_vec3()
            })
    }

    /// The section plane through which the ray of a sample enters what is
    /// left, with its reversed depth; it must lie in front of `behind`.
    fn entry(&self, sections: &[Section], x: f64, y: f64, behind: f32) -> Option<(usize, f32)> {
        let mut found: Option<(usize, f32)> = None;
        for (k, plane) in self.planes.iter().enumerate() {
            let Some(plane) = plane else { continue };
            let p = plane.at(x, y);
            let depth = plane.depth.dot(p) as f32;
            if p.w > 0.0 && depth >= behind && found.is_none_or(|(_, kept)| depth < kept) {
                found = Some((k, depth));
            }
        }
        // What the other planes cut away there is not solid any more.
        let (k, depth) = found?;
        let point = self.point(k, x, y);
        let inside = sections
            .iter()
            .enumerate()
            .all(|(j, s)| j == k || s.normal.dot(point) <= s.offset * 1.0001 + 1e-6);
        inside.then_some((k, depth))
    }
}

/// Turns the samples of a tile that show the back of a face into cap.
pub(crate) fn cap_tile(
    buffer: &mut TileBuffer,
    origin: [i32; 2],
    samples: &[[i32; 2]],
    context: &ShadeContext,
) {
    let (scene, matrix, caps) = (context.scene, context.matrix, &context.caps);
    if !buffer.tile.drawn {
        return;
    }
    let mut last = (NO_TRIANGLE, false);
    for ((depths, numbers), sample) in buffer.planes().zip(samples) {
        for block in 0..BLOCKS * BLOCKS {
            for lane in 0..BLOCK_PIXELS {
                let id = numbers[block][lane];
                if id == NO_TRIANGLE {
                    continue;
                }
                if id != last.0 {
                    last = (id, faces_away(scene, matrix, id as usize));
                }
                if !last.1 {
                    continue;
                }
                let column = block % BLOCKS * BLOCK + lane % BLOCK;
                let row = block / BLOCKS * BLOCK + lane / BLOCK;
                let at = |pixel: usize, axis: usize| {
                    let sub = (pixel as i32 + origin[axis]) * 256 + sample[axis];
                    f64::from(sub - matrix.middle[axis])
                };
                let depth = &mut depths[block][lane];
                let (x, y) = (at(column, 0), at(row, 1));
                if let Some((k, cap)) = caps.entry(&scene.sections, x, y, *depth) {
                    *depth = cap;
                    numbers[block][lane] = capped(id, k);
                }
            }
        }
    }
}

/// Whether a triangle shows its back: by the side of its plane the viewer is
/// on.
fn faces_away(scene: &Scene, matrix: &FrameMatrix, triangle: usize) -> bool {
    let Some(corners) = scene.corners(triangle) else {
        return false;
    };
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let viewer = matrix.viewer.as_dvec4();
    let normal = (b - a).cross(c - a);
    normal.dot(viewer.truncate() - a * viewer.w) < 0.0
}
