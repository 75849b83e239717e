//! What a page needs to draw a model, as one block of bytes.
//!
//! Little-endian: the length of a JSON text (u32), the text, spaces up to a multiple of four
//! bytes, and the arrays whose lengths the text tells under `counts`, in this order:
//!
//! | array | entries |
//! | --- | --- |
//! | `points` | 3 × f32, about `center` |
//! | `faces` | f32, the number of the face that the point is of |
//! | `normals` | 4 × i8, the last one 0 |
//! | `corners` | u32, three to a triangle: numbers of points |
//! | `segments` | 6 × f32: two points, about `center` |
//! | `segment_edges` | f32, the number of the edge |
//! | `vertices` | 3 × f32, about `center` |

use csg::brep::{CurveShape, Edge};
use csg::{Color, Mesh};
use glam::DVec3;
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::faces;
use crate::pick;
use crate::shown::{Settings, Shown};

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
    let (mut heads, of_triangles) = faces_of(shown, &mut parts);
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
    let drawn = Triangles::of(mesh, center, &of_triangles, rest as u32);
    let lines = Lines::of(shown);
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
            segments: lines.segments.len(),
            vertices: vertices.len(),
        },
    };
    let mut text = serde_json::to_vec(&head).unwrap_or_default();
    text.resize(text.len().next_multiple_of(4), b' ');
    let floats = 4 * drawn.points.len() + 7 * lines.segments.len() + 3 * vertices.len();
    let bytes = 4 + text.len() + 4 * (floats + drawn.normals.len() + drawn.corners.len());
    let mut out = Vec::with_capacity(bytes);
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text);
    out.extend(drawn.points.iter().flatten().flat_map(|x| x.to_le_bytes()));
    out.extend(drawn.faces.iter().flat_map(|x| x.to_le_bytes()));
    out.extend(drawn.normals.iter().flatten().map(|&x| x as u8));
    out.extend(drawn.corners.iter().flat_map(|x| x.to_le_bytes()));
    out.extend(
        lines
            .segments
            .iter()
            .flatten()
            .flatten()
            .flat_map(|x| x.to_le_bytes()),
    );
    out.extend(lines.of.iter().flat_map(|x| x.to_le_bytes()));
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
            .and_then(|program| program.surfaces().get(surface.surface as usize))
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
}

impl Triangles {
    fn of(mesh: &Mesh, center: DVec3, faces: &[u32], rest: u32) -> Self {
        let mut drawn = Self::default();
        let mut known: FxHashMap<(u32, u32, [i8; 4]), u32> = FxHashMap::default();
        known.reserve(mesh.positions.len());
        for (triangle, vertices) in mesh.triangles.iter().enumerate() {
            let face = faces[triangle].min(rest);
            let normals = mesh
                .corner_normals
                .get(triangle)
                .copied()
                .unwrap_or_else(|| {
                    let [a, b, c] = mesh.corners(triangle);
                    [(b - a).cross(c - a).normalize_or_zero().as_vec3(); 3]
                });
            for (&vertex, normal) in vertices.iter().zip(normals) {
                let [x, y, z] = (127.0 * normal).round().to_array().map(|x: f32| x as i8);
                let normal = [x, y, z, 0];
                let corner = *known.entry((vertex, face, normal)).or_insert_with(|| {
                    drawn
                        .points
                        .push(single(mesh.positions[vertex as usize] - center));
                    drawn.faces.push(face as f32);
                    drawn.normals.push(normal);
                    drawn.points.len() as u32 - 1
                });
                drawn.corners.push(corner);
            }
        }
        drawn
    }
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
