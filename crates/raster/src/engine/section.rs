//! Section planes: what lies on one side is cut away, and the cut through
//! solid matter is capped and hatched.
//!
//! What all planes keep is convex: a ray enters it through planes that have
//! the viewer on the side cut away, the last of which is its *entry*, and
//! leaves it through others. What lies before the entry is cut off. If the
//! faces after it turn their backs more often than their fronts, the ray has
//! entered solid matter through the cut: the sample becomes part of the cap, at
//! the depth of the entry. The ray may meet faces where it has already left
//! what is kept through another plane, so faces beyond such planes are drawn
//! as well: they decide about caps, and are not shown themselves. This needs no
//! triangulation of the cut and is right for every closed mesh and every
//! sample, if the far plane is behind the whole mesh: which faces a sample
//! meets is found exactly, and a mesh whose corners are snapped is still
//! closed, so that their number does not depend on which of two faces that
//! meet at a silhouette is the nearer one.

use std::collections::HashMap;

use csg::Mesh;
use glam::{DMat4, DVec3, DVec4, Vec3};

use crate::RasterError;
use crate::deferred::ShadeContext;
use crate::frame::FrameMatrix;
use crate::normals::{CREASE_ANGLE, corner_normals};
use crate::prepared::{Prepared, finite_bounds};
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
    /// Those that have the viewer on the side cut away: rays enter through
    /// them, and leave through others.
    planes: Vec<Option<CapPlane>>,
    /// Bits of those.
    entries: u8,
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
        let [x, y, z, w] = matrix.rows;
        let viewer = matrix.viewer;
        let planes: Vec<_> = sections
            .iter()
            .map(|section| {
                // Only a cut that faces the viewer shows its cap.
                if section.normal.dot(viewer.truncate()) <= section.offset * viewer.w {
                    return None;
                }
                let plane = section.normal.extend(-section.offset);
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
        let bits = planes.iter().enumerate();
        let entries = bits.fold(0, |bits, (k, plane)| bits | u8::from(plane.is_some()) << k);
        Self { planes, entries }
    }

    /// Whether triangles beyond these planes are drawn: if some ray may meet
    /// them after its entry.
    pub fn wants(&self, beyond: u8) -> bool {
        beyond == 0 || (self.entries != 0 && beyond & self.entries == 0)
    }

    /// The point of a cap at a sample, relative to the scene's centre.
    pub fn point(&self, plane: usize, x: f64, y: f64) -> DVec3 {
        self.planes
            .get(plane)
            .copied()
            .flatten()
            .map_or(DVec3::ZERO, |plane| {
                let p = plane.at(x, y);
                p.truncate() / p.w
            })
    }

    /// Where the ray of a sample enters what is kept, if it does so
    /// beyond the near plane.
    fn entry(&self, sections: &[Section], x: f64, y: f64) -> Option<Entry> {
        let mut last: Option<(f64, usize, DVec4)> = None;
        for (k, plane) in self.planes.iter().enumerate() {
            let Some(plane) = plane else { continue };
            let p = plane.at(x, y);
            let depth = plane.depth.dot(p);
            // Behind the viewer the ray has left for good.
            if p.w <= 0.0 {
                return None;
            }
            if last.is_none_or(|(before, ..)| depth < before) {
                last = Some((depth, k, p));
            }
        }
        let (depth, plane, p) = last.filter(|(depth, ..)| *depth <= 1.0)?;
        let behind = |s: &Section| s.normal.extend(-s.offset).dot(p) <= 0.0;
        let exits = sections.iter().zip(&self.planes);
        let kept = exits
            .filter(|(_, entry)| entry.is_none())
            .all(|(s, _)| behind(s));
        Some(Entry {
            plane,
            depth: depth as f32,
            kept,
        })
    }
}

/// Where a ray enters what section planes keep.
struct Entry {
    plane: usize,
    /// Reversed.
    depth: f32,
    /// Whether it does, or has left through another plane before.
    kept: bool,
}

/// Turns the samples of a tile whose rays enter through a cut into cap, and
/// clears those that show what is cut away.
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
    for (plane, sample) in buffer.planes().zip(samples) {
        let Some(windings) = plane.winding else {
            return;
        };
        let depths = plane.depth.as_flattened_mut();
        let numbers = plane.triangle.as_flattened_mut();
        let here = depths.iter_mut().zip(numbers).zip(windings.as_flattened());
        for (index, ((depth, number), &winding)) in here.enumerate() {
            if *number == NO_TRIANGLE {
                continue;
            }
            let in_matter = winding > 0;
            let cut_away = *number as usize >= scene.kept_triangles;
            if !in_matter && !cut_away {
                continue;
            }
            let (block, lane) = (index / BLOCK_PIXELS, index % BLOCK_PIXELS);
            let column = block % BLOCKS * BLOCK + lane % BLOCK;
            let row = block / BLOCKS * BLOCK + lane / BLOCK;
            let at = |pixel: usize, axis: usize| {
                let sub = (pixel as i32 + origin[axis]) * 256 + sample[axis];
                f64::from(sub - matrix.middle[axis])
            };
            let entry = if in_matter {
                caps.entry(&scene.sections, at(column, 0), at(row, 1))
            } else {
                None
            };
            // A face that is kept proves that the matter before it is kept as
            // well, up to rounding.
            if let Some(entry) = entry.filter(|entry| entry.kept || !cut_away) {
                *depth = entry.depth;
                *number = capped(*number, entry.plane);
            } else if cut_away {
                *depth = 0.0;
                *number = NO_TRIANGLE;
            }
        }
    }
}
