//! Models of polygons with many sides, as textbooks store them: tables of
//! vertices, edges and faces.

use std::collections::HashMap;

use csg::Mesh;
use glam::DVec3;

/// A table of vertices and one of faces; corners of a face are counter-clockwise
/// as seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonModel {
    /// The vertex table.
    pub vertices: Vec<DVec3>,
    /// The face table: the numbers of each face's vertices, three or more.
    pub faces: Vec<Vec<u32>>,
}

/// An entry of the edge table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PolygonEdge {
    /// Its vertices, the lesser number first.
    pub ends: [u32; 2],
    /// The faces that run along it from the first to the second, and back.
    pub faces: [Vec<u32>; 2],
}

impl PolygonModel {
    fn sides(face: &[u32]) -> impl Iterator<Item = (u32, u32)> {
        let next = face.iter().cycle().skip(1);
        face.iter().copied().zip(next.copied())
    }

    /// The edge table, in the order in which faces name them first.
    #[must_use]
    pub fn edges(&self) -> Vec<PolygonEdge> {
        let mut table: Vec<PolygonEdge> = Vec::new();
        let mut numbers: HashMap<[u32; 2], usize> = HashMap::new();
        for (index, face) in self.faces.iter().enumerate() {
            for (a, b) in Self::sides(face) {
                let ends = [a.min(b), a.max(b)];
                let number = *numbers.entry(ends).or_insert_with(|| {
                    table.push(PolygonEdge {
                        ends,
                        faces: [Vec::new(), Vec::new()],
                    });
                    table.len() - 1
                });
                table[number].faces[usize::from(a > b)].push(index as u32);
            }
        }
        table
    }

    /// Whether every edge has two faces, which run along it in opposite
    /// directions: the model is closed, and all faces agree on what is outside.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        let edges = self.edges();
        edges
            .iter()
            .all(|edge| edge.faces.iter().all(|faces| faces.len() == 1))
    }

    /// The vector area of a face, whose direction is its normal: half the sum
    /// of the cross products of consecutive corners (Newell's method), which
    /// holds for concave faces, too. Zero for one that names a vertex that is
    /// not there.
    #[must_use]
    pub fn vector_area(&self, face: usize) -> DVec3 {
        let at = |v: u32| self.vertices.get(v as usize).copied();
        let corners: Option<Vec<DVec3>> = self
            .faces
            .get(face)
            .and_then(|face| face.iter().map(|&v| at(v)).collect());
        let Some(corners) = corners else {
            return DVec3::ZERO;
        };
        let Some(&first) = corners.first() else {
            return DVec3::ZERO;
        };
        let fans = corners.windows(2);
        fans.map(|p| (p[0] - first).cross(p[1] - first))
            .sum::<DVec3>()
            / 2.0
    }

    /// Whether a face turns its outside to a viewer (back-face removal): by its
    /// normal and the direction from the viewer to it alone.
    #[must_use]
    pub fn faces_viewer(&self, face: usize, eye: DVec3) -> bool {
        let corner = self.faces.get(face).and_then(|f| f.first());
        let corner = corner.and_then(|&v| self.vertices.get(v as usize));
        corner.is_some_and(|&p| self.vector_area(face).dot(eye - p) > 0.0)
    }

    /// The model in triangles, each with the number of its face as surface.
    /// Faces may be concave; their corners are cut off one by one (ears; Meisters,
    /// *Polygons have ears*, 1975). O(n²) for a face of n corners. Faces that name
    /// vertices that are not there are left out.
    #[must_use]
    pub fn to_mesh(&self) -> Mesh {
        let mut mesh = Mesh::new(self.vertices.clone(), Vec::new());
        for (index, face) in self.faces.iter().enumerate() {
            mesh.surfaces.push(csg::MeshSurface {
                surface: index as u32,
                ..csg::MeshSurface::default()
            });
            if face.iter().any(|&v| v as usize >= self.vertices.len()) {
                continue;
            }
            let triangles = self.ears(face, self.vector_area(index));
            let own = std::iter::repeat_n(index as u32, triangles.len());
            mesh.triangle_surfaces.extend(own);
            mesh.triangles.extend(triangles);
        }
        mesh
    }

    fn ears(&self, face: &[u32], normal: DVec3) -> Vec<[u32; 3]> {
        let at = |v: u32| self.vertices[v as usize];
        let side = |a: u32, b: u32, c: u32| (at(b) - at(a)).cross(at(c) - at(a)).dot(normal);
        let mut rest = face.to_vec();
        let mut triangles = Vec::new();
        while rest.len() > 3 {
            let n = rest.len();
            let corner = |k: usize| [rest[(k + n - 1) % n], rest[k], rest[(k + 1) % n]];
            let is_ear = |&k: &usize| {
                let [a, b, c] = corner(k);
                let inside = |&p: &u32| {
                    ![a, b, c].contains(&p)
                        && side(a, b, p) >= 0.0
                        && side(b, c, p) >= 0.0
                        && side(c, a, p) >= 0.0
                };
                side(a, b, c) > 0.0 && !rest.iter().any(inside)
            };
            // (A face that runs through itself has none: any corner does.)
            let ear = (0..n).find(is_ear).unwrap_or(0);
            triangles.push(corner(ear));
            rest.remove(ear);
        }
        if let [a, b, c] = rest[..] {
            triangles.push([a, b, c]);
        }
        triangles
    }
}
