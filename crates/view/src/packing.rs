//! What a page needs to draw a model, as one block of bytes.
//!
//! Little-endian: the length of a JSON text (u32), the text, spaces until all is a multiple of eight
//! bytes, and the arrays whose lengths the text tells under `counts` and `faces`, in this order:
//!
//! | array | entries |
//! | --- | --- |
//! | `extents` | 6 × f64: the least and the greatest corner of the box around each face; the other way round, and infinite, where there is none |
//! | `points` | 3 × f32, about `center` |
//! | `faces` | f32, the number of the face that the point is of |
//! | `normals` | 4 × i8, the last one 0 |
//! | `corners` | u32, three to a triangle: numbers of points |
//! | `simplified` | as `corners`, for each entry of the count: fewer and fewer triangles, to be drawn while the camera moves; of a mesh of no more than 200,000 none |
//! | `segments` | 6 × f32: two points, about `center` |
//! | `segment_edges` | f32, the number of the edge |
//! | `edge_faces` | 2 × u32, the numbers of the faces on its sides, 2³² − 1 if it has none there |
//! | `vertices` | 3 × f32, about `center` |

use std::iter;

use csg::brep::{CurveShape, Edge};
use csg::{Color, Mesh};
use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::faces;
use crate::pick;
use crate::shown::{Settings, Shown};

/// From so many triangles on, fewer are drawn while the camera moves, where all of them take long.
const MANY: usize = 200_000;
/// The most of these, and the most where these take too long as well.
const MOST_SIMPLIFIED: [usize; 2] = [100_000, 10_000];

#[derive(Debug, Serialize)]
struct Head<'a> {
    revision: u64,
    name: &'a str,
    unit: &'static str,
    is_coarse: bool,
    /// Whether faces, edges and vertices are those of an exact boundary, which can be asked.
    is_exact: bool,
    warnings: &'a [String],
    center: [f64; 3],
    /// From the centre to the farthest point.
    radius: f64,
    parts: Vec<Part>,
    faces: Vec<FaceHead>,
    /// The vertices of each edge.
    edges: Vec<Option<[usize; 2]>>,
    counts: Counts,
}

#[derive(Debug, Serialize, PartialEq)]
struct Part {
    name: String,
}

#[derive(Debug, Serialize)]
struct FaceHead {
    part: usize,
    kind: &'static str,
    radius: Option<f64>,
    /// sRGB and opacity.
    color: Option<[f32; 4]>,
}

#[derive(Debug, Default, Serialize)]
struct Counts {
    points: usize,
    triangles: usize,
    simplified: Vec<usize>,
    segments: usize,
    vertices: usize,
}

/// Parts by their names, in the order in which they come.
#[derive(Default)]
struct Parts {
    found: Vec<Part>,
    numbers: FxHashMap<String, usize>,
}

impl Parts {
    fn number(&mut self, name: Option<&str>, kind: &str) -> usize {
        let name = name.unwrap_or(kind);
        if let Some(&known) = self.numbers.get(name) {
            return known;
        }
        let number = self.found.len();
        self.found.push(Part {
            name: name.to_owned(),
        });
        self.numbers.insert(name.to_owned(), number);
        number
    }
}

fn srgb(color: Option<Color>) -> Option<[f32; 4]> {
    let color = color?;
    let [r, g, b] = color.to_srgb();
    Some([r, g, b, color.alpha])
}

/// The middle of what is shown, and from there to the farthest corner of its bounds.
pub(crate) fn ball(shown: &Shown) -> (DVec3, f64) {
    let (low, high) = bounds(shown);
    (0.5 * (low + high), 0.5 * low.distance(high))
}

fn bounds(shown: &Shown) -> (DVec3, DVec3) {
    let exact = shown.brep.as_ref().and_then(csg::Brep::bounds);
    let exact = exact.map(|bounds| (bounds.min, bounds.max));
    exact.or(shown.mesh.bounds()).unwrap_or_default()
}

/// All that a page draws.
pub(crate) fn pack(shown: &Shown) -> Vec<u8> {
    let mesh = &shown.mesh;
    let (center, radius) = ball(shown);
    let mut parts = Parts::default();
    let (mut heads, mut of_triangles) = faces_of(shown, &mut parts);
    // What belongs to no face is drawn, but cannot be asked for.
    let rest = heads.len();
    if of_triangles.contains(&faces::NONE) {
        let part = parts.number(None, "other");
        heads.push(FaceHead {
            part,
            kind: "surface",
            radius: None,
            color: None,
        });
    }
    for face in &mut of_triangles {
        *face = (*face).min(rest as u32);
    }
    let extents = extents(shown, &of_triangles, heads.len());
    let drawn = Triangles::of(mesh, center, &of_triangles);
    let lines = Lines::of(shown);
    let edge_faces = edge_faces(shown, &of_triangles);
    let vertices: Vec<[f32; 3]> = match &shown.brep {
        Some(brep) => brep
            .vertices()
            .map(|v| single(v.point() - center))
            .collect(),
        None => Vec::new(),
    };
    let head = Head {
        revision: shown.revision,
        name: &shown.name,
        unit: shown.unit.symbol(),
        is_coarse: shown.is_coarse,
        is_exact: shown.brep.is_some(),
        warnings: &shown.warnings,
        center: center.to_array(),
        radius,
        parts: parts.found,
        faces: heads,
        edges: lines.edges,
        counts: Counts {
            points: drawn.points.len(),
            triangles: mesh.triangles.len(),
            simplified: drawn.simplified.iter().map(|few| few.len() / 3).collect(),
            segments: lines.segments.len(),
            vertices: vertices.len(),
        },
    };
    let mut text = serde_json::to_vec(&head).unwrap_or_default();
    text.resize((4 + text.len()).next_multiple_of(8) - 4, b' ');
    let floats = 4 * drawn.points.len() + 7 * lines.segments.len() + 3 * vertices.len();
    let corners = || {
        iter::once(&drawn.corners)
            .chain(&drawn.simplified)
            .flatten()
    };
    let words = floats + drawn.normals.len() + corners().count() + 2 * edge_faces.len();
    let bytes = 4 + text.len() + 48 * extents.len() + 4 * words;
    let mut out = Vec::with_capacity(bytes);
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text);
    let ends = extents.iter().flatten().flat_map(DVec3::to_array);
    out.extend(ends.flat_map(f64::to_le_bytes));
    out.extend(drawn.points.iter().flatten().flat_map(|x| x.to_le_bytes()));
    out.extend(drawn.faces.iter().flat_map(|x| x.to_le_bytes()));
    out.extend(drawn.normals.iter().flatten().map(|&x| x as u8));
    out.extend(corners().flat_map(|x| x.to_le_bytes()));
    out.extend(
        lines
            .segments
            .iter()
            .flatten()
            .flatten()
            .flat_map(|x| x.to_le_bytes()),
    );
    out.extend(lines.of.iter().flat_map(|x| x.to_le_bytes()));
    let sides = edge_faces.iter().flatten();
    out.extend(sides.flat_map(|face| face.to_le_bytes()));
    out.extend(vertices.iter().flatten().flat_map(|x| x.to_le_bytes()));
    out
}

/// The faces, and which of them each triangle is part of: of the exact boundary, or else the
/// surfaces that the mesh knows of.
fn faces_of(shown: &Shown, parts: &mut Parts) -> (Vec<FaceHead>, Vec<u32>) {
    if let Some(brep) = &shown.brep {
        let heads = brep.faces().map(|face| {
            let origin = face.origin();
            let shape = face.surface().shape();
            FaceHead {
                part: parts.number(origin.name.as_deref(), origin.kind),
                kind: pick::kind(&shape),
                radius: pick::radius(&shape),
                color: srgb(origin.color),
            }
        });
        let heads = heads.collect();
        return (heads, faces::of_triangles(&shown.mesh, brep));
    }
    let heads = shown.mesh.surfaces.iter().map(|surface| {
        let program = shown.program.as_ref();
        let shape = program
            .and_then(|program| program.carriers().get(surface.surface as usize))
            .map(csg::Surface::shape);
        let origin = program.and_then(|program| program.origins().get(surface.primitive as usize));
        let kind = origin.map_or("mesh", |origin| origin.kind);
        FaceHead {
            part: parts.number(surface.name.as_deref(), kind),
            kind: shape.as_ref().map_or("surface", pick::kind),
            radius: shape.as_ref().and_then(pick::radius),
            color: srgb(surface.color),
        }
    });
    let heads = heads.collect();
    let mut of = shown.mesh.triangle_surfaces.clone();
    of.resize(shown.mesh.triangles.len(), faces::NONE);
    (heads, of)
}

/// The faces on the sides of each edge.
fn edge_faces(shown: &Shown, of_triangles: &[u32]) -> Vec<[u32; 2]> {
    if let Some(brep) = &shown.brep {
        let faces = brep.edges().map(|edge| edge.faces());
        let numbers = faces.map(|sides| sides.map(|face| face.id().index() as u32));
        return numbers.collect();
    }
    // By the first chord of each, in the triangles that have it.
    let mesh = &shown.mesh;
    let mut sides = vec![[faces::NONE; 2]; mesh.feature_edges.len()];
    let chords = mesh.feature_edges.iter().enumerate();
    let chords = chords.filter_map(|(k, chain)| Some(((*chain.first()?, *chain.get(1)?), k)));
    let known: FxHashMap<(u32, u32), usize> = chords.collect();
    for (&[a, b, c], &face) in mesh.triangles.iter().zip(of_triangles) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            for (ends, side) in [((from, to), 0), ((to, from), 1)] {
                if let Some(&edge) = known.get(&ends) {
                    sides[edge][side] = face;
                }
            }
        }
    }
    sides
}

/// The box around each of so many faces: of the exact boundary's to rounding.
fn extents(shown: &Shown, of_triangles: &[u32], count: usize) -> Vec<[DVec3; 2]> {
    let mut boxes = vec![[DVec3::INFINITY, DVec3::NEG_INFINITY]; count];
    if let Some(brep) = &shown.brep {
        for (entry, face) in boxes.iter_mut().zip(brep.faces()) {
            if let Some(found) = face.bounds() {
                *entry = [found.min, found.max];
            }
        }
        return boxes;
    }
    for (k, &face) in of_triangles.iter().enumerate() {
        if let Some([low, high]) = boxes.get_mut(face as usize) {
            for corner in shown.mesh.corners(k) {
                *low = low.min(corner);
                *high = high.max(corner);
            }
        }
    }
    boxes
}

fn single(point: DVec3) -> [f32; 3] {
    point.as_vec3().to_array()
}

/// Triangles whose points are apart where faces or normals are.
#[derive(Default)]
struct Triangles {
    points: Vec<[f32; 3]>,
    faces: Vec<f32>,
    normals: Vec<[i8; 4]>,
    corners: Vec<u32>,
    /// Corners of fewer and fewer ones.
    simplified: Vec<Vec<u32>>,
}

impl Triangles {
    fn of(mesh: &Mesh, center: DVec3, faces: &[u32]) -> Self {
        let mut drawn = Self::default();
        let whole = mesh.triangles.iter().copied().enumerate();
        drawn.corners = drawn.add(mesh, center, faces, 127.0, whole);
        if mesh.triangles.len() > MANY {
            for most in MOST_SIMPLIFIED {
                let few = clustered(mesh, most);
                if !few.is_empty() {
                    let corners = drawn.add(mesh, center, faces, 2.0, few.into_iter());
                    drawn.simplified.push(corners);
                }
            }
        }
        drawn
    }

    /// The corners of triangles, whose points are added. Corners share a point if their normals
    /// are the same in so many steps.
    fn add(
        &mut self,
        mesh: &Mesh,
        center: DVec3,
        faces: &[u32],
        steps: f32,
        triangles: impl Iterator<Item = (usize, [u32; 3])>,
    ) -> Vec<u32> {
        let mut corners = Vec::with_capacity(3 * triangles.size_hint().0);
        let mut known: FxHashMap<(u32, u32, [i8; 3]), u32> = FxHashMap::default();
        known.reserve(triangles.size_hint().0 / 2);
        let rounded = |normal: Vec3, steps: f32| {
            let parts = (steps * normal).round().to_array();
            parts.map(|x: f32| x as i8)
        };
        for (triangle, vertices) in triangles {
            let face = faces[triangle];
            let normals = mesh
                .corner_normals
                .get(triangle)
                .copied()
                .unwrap_or_else(|| {
                    let [a, b, c] = mesh.corners(triangle);
                    [(b - a).cross(c - a).normalize_or_zero().as_vec3(); 3]
                });
            for (&vertex, normal) in vertices.iter().zip(normals) {
                let key = (vertex, face, rounded(normal, steps));
                let corner = *known.entry(key).or_insert_with(|| {
                    let place = mesh.positions[vertex as usize] - center;
                    self.points.push(single(place));
                    self.faces.push(face as f32);
                    let [x, y, z] = rounded(normal, 127.0);
                    self.normals.push([x, y, z, 0]);
                    self.points.len() as u32 - 1
                });
                corners.push(corner);
            }
        }
        corners
    }
}

/// The triangles that are left, by number and with their vertices, if one vertex stands for all
/// in its cell of a grid (Rossignac and Borrel, *Multi-resolution 3D Approximations for Rendering
/// Complex Scenes*, 1993), of the finest grid that leaves no more than this; none if there is no
/// such grid.
fn clustered(mesh: &Mesh, most: usize) -> Vec<(usize, [u32; 3])> {
    let (low, high) = mesh.bounds().unwrap_or_default();
    let size = (high - low).max_element();
    for cells in [
        256.0, 192.0, 128.0, 96.0, 64.0, 48.0, 32.0, 24.0, 16.0, 12.0, 8.0,
    ] {
        let mut first: FxHashMap<[i32; 3], u32> = FxHashMap::default();
        let places = mesh.positions.iter().zip(0..);
        let stand_ins: Vec<u32> = places
            .map(|(&place, vertex)| {
                let cell = (cells / size * (place - low)).as_ivec3();
                *first.entry(cell.to_array()).or_insert(vertex)
            })
            .collect();
        let left = mesh
            .triangles
            .iter()
            .enumerate()
            .filter_map(|(k, corners)| {
                let [a, b, c] = corners.map(|vertex| stand_ins[vertex as usize]);
                (a != b && b != c && c != a).then_some((k, [a, b, c]))
            });
        let left: Vec<_> = left.take(most + 1).collect();
        if left.len() <= most {
            return left;
        }
    }
    Vec::new()
}

/// Edges as chords, about the middle of what is shown.
#[derive(Default)]
pub(crate) struct Lines {
    edges: Vec<Option<[usize; 2]>>,
    pub(crate) segments: Vec<[[f32; 3]; 2]>,
    of: Vec<f32>,
}

impl Lines {
    pub(crate) fn of(shown: &Shown) -> Self {
        let (low, high) = bounds(shown);
        let (center, size) = (0.5 * (low + high), (high - low).max_element());
        let mut lines = Self::default();
        match &shown.brep {
            Some(brep) => {
                let mut chain = Vec::new();
                for edge in brep.edges() {
                    let vertices = edge.vertices();
                    lines
                        .edges
                        .push(vertices.map(|ends| ends.map(|v| v.id().index())));
                    chain.clear();
                    chords(&edge, Settings::TOLERANCE * size, &mut chain);
                    lines.add(edge.id().index(), chain.iter().copied(), center);
                }
            }
            None => {
                for (k, chain) in shown.mesh.feature_edges.iter().enumerate() {
                    lines.edges.push(None);
                    let points = chain.iter().map(|&v| shown.mesh.positions[v as usize]);
                    lines.add(k, points, center);
                }
            }
        }
        lines
    }

    fn add(&mut self, edge: usize, mut points: impl Iterator<Item = DVec3>, center: DVec3) {
        let Some(mut last) = points.next() else {
            return;
        };
        for point in points {
            self.segments
                .push([last - center, point - center].map(single));
            self.of.push(edge as f32);
            last = point;
        }
    }
}

/// Points along an edge, whose chords stray from it by no more than about the tolerance.
fn chords(edge: &Edge<'_>, tolerance: f64, out: &mut Vec<DVec3>) {
    /// Of a curve at first: it may pass through one point twice.
    const LEAST: u32 = 8;
    const DEEPEST: u32 = 10;
    fn halve(
        edge: &Edge<'_>,
        [from, to]: [(f64, DVec3); 2],
        tolerance: f64,
        deeper: u32,
        out: &mut Vec<DVec3>,
    ) {
        let t = 0.5 * (from.0 + to.0);
        let middle = edge.at(t);
        let off = middle.distance(0.5 * (from.1 + to.1));
        if off > tolerance && deeper > 0 {
            halve(edge, [from, (t, middle)], tolerance, deeper - 1, out);
            halve(edge, [(t, middle), to], tolerance, deeper - 1, out);
        } else {
            out.push(to.1);
        }
    }
    let [from, to] = edge.range();
    out.push(edge.at(from));
    if matches!(edge.curve(), CurveShape::Line { .. }) {
        out.push(edge.at(to));
        return;
    }
    let place = |k: u32| {
        let t = from + f64::from(k) / f64::from(LEAST) * (to - from);
        (t, edge.at(t))
    };
    for k in 0..LEAST {
        halve(edge, [place(k), place(k + 1)], tolerance, DEEPEST, out);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    /// A wavy square of so many quads a side.
    fn waves(side: u32) -> Mesh {
        let place = |k: u32| {
            let [x, y] = [k % (side + 1), k / (side + 1)].map(|i| f64::from(i) / f64::from(side));
            DVec3::new(x, y, 0.05 * x * y)
        };
        let corners = (0..side).flat_map(|y| (0..side).map(move |x| y * (side + 1) + x));
        let triangles =
            corners.flat_map(|a| [[a, a + 1, a + side + 2], [a, a + side + 2, a + side + 1]]);
        Mesh {
            positions: (0..(side + 1).pow(2)).map(place).collect(),
            triangles: triangles.collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn few_triangles_stand_for_many() {
        let mesh = waves(400);
        assert!(mesh.triangles.len() > MANY);
        for most in MOST_SIMPLIFIED {
            assert!((most / 4..=most).contains(&clustered(&mesh, most).len()));
        }
        let left = clustered(&mesh, MOST_SIMPLIFIED[0]);
        let at = |vertex: u32| mesh.positions[vertex as usize];
        let mut area = 0.0;
        for (k, corners) in &left {
            assert_eq!(corners.iter().collect::<HashSet<_>>().len(), 3);
            // In the same cell.
            for (&old, &new) in mesh.triangles[*k].iter().zip(corners) {
                assert!(at(old).distance(at(new)) < 3f64.sqrt() / 96.0);
            }
            let [a, b, c] = corners.map(at);
            area += 0.5 * (b - a).cross(c - a).z;
        }
        // What is lost is at the rim.
        assert!((0.97..=1.0).contains(&area), "{area}");
    }

    #[test]
    fn few_triangles_are_drawn_as_they_are() {
        let mesh = waves(30);
        let faces = vec![0; mesh.triangles.len()];
        let drawn = Triangles::of(&mesh, DVec3::ZERO, &faces);
        assert_eq!(drawn.corners.len(), 3 * mesh.triangles.len());
        assert!(drawn.simplified.is_empty());
    }
}
