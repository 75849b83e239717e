//! Meshes that are drawn.

use std::collections::HashMap;

use csg::{Mesh, Mesher, Program, Solid};
use glam::{DVec3, Vec3};

/// A subdivided icosahedron of radius 1 with 20 * 4^level triangles and exact
/// normals.
#[must_use]
pub fn icosphere(level: u32) -> Mesh {
    let t = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points: Vec<DVec3> = [
        [-1.0, t, 0.0],
        [1.0, t, 0.0],
        [-1.0, -t, 0.0],
        [1.0, -t, 0.0],
        [0.0, -1.0, t],
        [0.0, 1.0, t],
        [0.0, -1.0, -t],
        [0.0, 1.0, -t],
        [t, 0.0, -1.0],
        [t, 0.0, 1.0],
        [-t, 0.0, -1.0],
        [-t, 0.0, 1.0],
    ]
    .into_iter()
    .map(|p| DVec3::from_array(p).normalize())
    .collect();
    let mut triangles: Vec<[u32; 3]> = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ]
    .to_vec();
    for _ in 0..level {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut next = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(i, j)| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    points.push((points[i as usize] + points[j as usize]).normalize());
                    points.len() as u32 - 1
                })
            });
            next.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = next;
    }
    let normals = triangles
        .iter()
        .map(|t| t.map(|v| points[v as usize].as_vec3()))
        .collect();
    let mut mesh = Mesh::new(points, triangles);
    mesh.corner_normals = normals;
    mesh
}

/// n^3 icospheres in a cube from -1 to 1.
#[must_use]
pub fn sphere_grid(n: u32, level: u32) -> Mesh {
    let sphere = icosphere(level);
    let mut mesh = Mesh::default();
    let pitch = 2.0 / f64::from(n);
    for cell in 0..n * n * n {
        let at = [cell % n, cell / n % n, cell / n / n].map(|i| (f64::from(i) + 0.5) * pitch - 1.0);
        let base = mesh.positions.len() as u32;
        let place = |p: &DVec3| DVec3::from_array(at) + *p * (pitch * 0.45);
        mesh.positions.extend(sphere.positions.iter().map(place));
        let shifted = sphere.triangles.iter().map(|t| t.map(|v| v + base));
        mesh.triangles.extend(shifted);
        mesh.corner_normals.extend(&sphere.corner_normals);
    }
    mesh
}

/// A cube from -1 to 1 with flat normals.
#[must_use]
pub fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let corner = |u: f64, v: f64| {
                let mut p = DVec3::ZERO;
                p[axis] = sign;
                p[(axis + 1) % 3] = u * sign;
                p[(axis + 2) % 3] = v;
                p
            };
            let base = mesh.positions.len() as u32;
            mesh.positions.extend([
                corner(-1., -1.),
                corner(1., -1.),
                corner(1., 1.),
                corner(-1., 1.),
            ]);
            mesh.triangles
                .extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
            let mut normal = Vec3::ZERO;
            normal[axis] = sign as f32;
            mesh.corner_normals.extend([[normal; 3]; 2]);
        }
    }
    mesh
}

/// A mesh as graphics interfaces want it: one normal for each vertex.
#[derive(Clone, Debug, Default)]
pub struct Indexed {
    /// Positions and normals.
    pub vertices: Vec<[Vec3; 2]>,
    /// Three vertices for each triangle.
    pub indices: Vec<u32>,
}

/// Splits the vertices of a mesh where its corners have different normals.
#[must_use]
pub fn indexed(mesh: &Mesh) -> Indexed {
    let mut numbers: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    let mut result = Indexed::default();
    let normals = raster::corner_normals(mesh, raster::CREASE_ANGLE);
    for (triangle, normals) in mesh.triangles.iter().zip(&normals) {
        for (&v, normal) in triangle.iter().zip(normals) {
            let key = (v, normal.to_array().map(f32::to_bits));
            let number = *numbers.entry(key).or_insert_with(|| {
                let position = mesh.positions[v as usize].as_vec3();
                result.vertices.push([position, *normal]);
                result.vertices.len() as u32 - 1
            });
            result.indices.push(number);
        }
    }
    result
}

/// The scene S2 (a cube and a ball, drilled through three times), meshed.
#[must_use]
pub fn drilled() -> Mesh {
    own(&stereotomy::scenes::drilled(), 256)
}

/// The scene S4, level 3 (a Menger sponge), meshed.
#[must_use]
pub fn sponge() -> Mesh {
    own(&stereotomy::scenes::menger(3), 128)
}

fn own(solid: &Solid, cells: u32) -> Mesh {
    let program = Program::lower(solid).expect("a sound solid");
    let meshed = Mesher::new().cells(cells).mesh(&program);
    meshed.expect("a mesh").mesh
}
