//! Section planes: what lies on one side of them is cut away.
//!
//! What is cut away but may be met by a ray after it has entered what is kept is
//! kept apart: it decides about [`caps`](crate::caps).

use std::collections::HashMap;

use csg::Mesh;
use glam::{DVec3, Vec3};

use crate::RasterError;
use crate::normals::{CREASE_ANGLE, corner_normals};
use crate::prepared::{Prepared, finite_bounds};

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
    pub normal: DVec3,
    pub offset: f64,
    /// Unit vector in the plane across the hatching.
    pub hatch: DVec3,
}

impl Prepared {
    /// Makes a mesh ready with parts of it cut away. Triangles are numbered
    /// after cutting: first those kept, then those that are not but still
    /// decide where caps are. For caps to be whole, a view's far plane must be
    /// behind the whole mesh.
    ///
    /// Costs O(vertices + triangles) for each part that the planes cut the
    /// mesh into.
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
        let mut whole = mesh.clone();
        whole.corner_normals = corner_normals(mesh, CREASE_ANGLE);
        // Parts of the mesh with bits for the planes they lie beyond; the
        // first is the one kept. None is wanted that lies beyond all planes:
        // every ray meets it before its entry.
        let beyond_all = (1u8 << planes.len()) - 1;
        let mut parts = vec![(0, whole)];
        for (k, plane) in planes.iter().enumerate() {
            let mut cut = Vec::with_capacity(parts.len() * 2);
            for (beyond, part) in parts {
                cut.push((beyond, cut_mesh(&part, plane, Side::Behind)));
                let beyond = beyond | 1 << k;
                if beyond != beyond_all {
                    cut.push((beyond, cut_mesh(&part, plane, Side::Beyond)));
                }
            }
            parts = cut;
        }
        let mut scene = Self::of_parts(parts);
        for (k, plane) in planes.iter().enumerate() {
            let normal = plane.normal.normalize();
            let (u, v) = normal.any_orthonormal_pair();
            let hatch = if k % 2 == 0 { u + v } else { u - v };
            scene.sections.push(Section {
                normal,
                offset: normal.dot(plane.point - scene.centre),
                hatch: hatch.normalize(),
            });
        }
        Ok(scene)
    }

    /// A scene of a mesh's parts, the first of them what is kept; with bits of
    /// the planes that each lies beyond.
    fn of_parts(parts: Vec<(u8, Mesh)>) -> Self {
        let groups: Vec<usize> = parts.iter().map(|(_, part)| part.triangles.len()).collect();
        let mut ends = Vec::with_capacity(parts.len());
        let (mut all, mut kept) = (Mesh::default(), None);
        for (beyond, part) in parts {
            if kept.is_none() {
                let bounds = finite_bounds(&part.positions).unwrap_or_default();
                kept = Some((part.positions.len(), part.triangles.len(), bounds));
                all = part;
            } else {
                append(&mut all, &part);
            }
            ends.push((all.triangles.len(), beyond));
        }
        let triangles = std::mem::take(&mut all.triangles);
        let normals = std::mem::take(&mut all.corner_normals);
        let mut scene = Self::without_normals(&all, triangles, &groups).with_normals(normals);
        for cluster in &mut scene.clusters {
            let first = cluster.first_triangle as usize;
            let part = ends.iter().find(|(end, _)| first < *end);
            cluster.beyond = part.map_or(0, |(_, beyond)| *beyond);
        }
        if let Some((vertices, triangles, (low, high))) = kept {
            (scene.kept_vertices, scene.kept_triangles) = (vertices, triangles);
            (scene.low, scene.high) = (low, high);
        }
        scene
    }
}

/// Adds the triangles of a part, and the vertices they name, to a mesh.
fn append(mesh: &mut Mesh, part: &Mesh) {
    let mut numbers = vec![None; part.positions.len()];
    for triangle in &part.triangles {
        let triangle = triangle.map(|v| {
            *numbers[v as usize].get_or_insert_with(|| {
                mesh.positions.push(part.positions[v as usize]);
                mesh.positions.len() as u32 - 1
            })
        });
        mesh.triangles.push(triangle);
    }
    mesh.corner_normals.extend(&part.corner_normals);
    mesh.triangle_surfaces.extend(&part.triangle_surfaces);
}

/// A side of a section plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    /// What the plane keeps.
    Behind,
    /// What it cuts away.
    Beyond,
}

/// The part of a mesh on one side of a plane, with its feature edges where it
/// is kept. Vertices on cut edges are shared, and the same for both sides. A
/// face in the plane goes with the matter behind it.
fn cut_mesh(mesh: &Mesh, plane: &SectionPlane, side: Side) -> Mesh {
    let normal = plane.normal.normalize();
    let distance = |p: DVec3| normal.dot(p - plane.point);
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
        let [a, b, c] = corners;
        let behind = if d == [0.0; 3] {
            [(b - a).cross(c - a).dot(normal) > 0.0; 3]
        } else {
            d.map(|d| d <= 0.0)
        };
        let inside = behind.map(|behind| behind == (side == Side::Behind));
        let normals = mesh.corner_normals[index];
        let mut polygon: Vec<(u32, Vec3)> = Vec::with_capacity(4);
        let mut on_plane = Vec::with_capacity(2);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if inside[i] {
                polygon.push((triangle[i], normals[i]));
            }
            if inside[i] != inside[j] {
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
    if side == Side::Behind && !mesh.feature_edges.is_empty() {
        let kept = |vertex: u32| {
            let position = mesh.positions.get(vertex as usize);
            position.map(|&p| distance(p) <= 0.0)
        };
        cut.feature_edges = cut_lines(&mesh.feature_edges, kept, &crossings);
        cut.feature_edges.extend(outline);
    }
    gather_unused(&mut cut);
    cut
}

/// What is kept of polylines, piece by piece, given which vertices are kept and
/// those on the edges that are cut.
fn cut_lines(
    lines: &[Vec<u32>],
    kept: impl Fn(u32) -> Option<bool>,
    crossings: &HashMap<(u32, u32), u32>,
) -> Vec<Vec<u32>> {
    let piece = |pair: &[u32]| {
        let (a, b) = (pair[0], pair[1]);
        let middle = crossings.get(&(a.min(b), a.max(b)));
        match (kept(a)?, kept(b)?, middle) {
            (true, true, _) => Some(vec![a, b]),
            (true, false, Some(&middle)) => Some(vec![a, middle]),
            (false, true, Some(&middle)) => Some(vec![middle, b]),
            _ => None,
        }
    };
    let pairs = lines.iter().flat_map(|line| line.windows(2));
    pairs.filter_map(piece).collect()
}

/// Puts vertices that no triangle uses where one is that does: they would still
/// count for framing.
fn gather_unused(mesh: &mut Mesh) {
    let mut used = vec![false; mesh.positions.len()];
    for v in mesh.triangles.iter().flatten() {
        used[*v as usize] = true;
    }
    let kept = used.iter().position(|u| *u).map(|k| mesh.positions[k]);
    if let Some(kept) = kept {
        for (position, used) in mesh.positions.iter_mut().zip(used) {
            if !used {
                *position = kept;
            }
        }
    }
}

fn corners(mesh: &Mesh, triangle: [u32; 3]) -> Option<[DVec3; 3]> {
    let at = |v: u32| mesh.positions.get(v as usize).copied();
    Some([at(triangle[0])?, at(triangle[1])?, at(triangle[2])?])
}
