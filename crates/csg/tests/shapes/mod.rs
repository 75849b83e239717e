//! Meshes with known properties, for several test files.
#![allow(dead_code, reason = "not every test file uses every shape")]

use csg::Mesh;
use glam::{DVec3, dvec3};

/// An axis-aligned box from corner to corner.
pub fn cuboid(low: DVec3, high: DVec3) -> Mesh {
    let positions = (0..8)
        .map(|i| {
            let pick = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 1 { high } else { low };
            dvec3(
                pick(0, low.x, high.x),
                pick(1, low.y, high.y),
                pick(2, low.z, high.z),
            )
        })
        .collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    Mesh::new(positions, triangles)
}

/// The cube from 0 to 1.
pub fn unit_cube() -> Mesh {
    cuboid(DVec3::ZERO, DVec3::ONE)
}

/// A tetrahedron; outward if (b - a, c - a, d - a) is right-handed.
pub fn tetrahedron(corners: [DVec3; 4]) -> Mesh {
    Mesh::new(
        corners.to_vec(),
        vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    )
}

/// The tetrahedron of the origin and the three unit points.
pub fn unit_tetrahedron() -> Mesh {
    tetrahedron([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z])
}

/// A torus about z: a ring of `around` polygons of `section` corners each.
pub fn torus(major: f64, minor: f64, around: u32, section: u32) -> Mesh {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..around {
        let (sin_u, cos_u) = (std::f64::consts::TAU * f64::from(i) / f64::from(around)).sin_cos();
        for j in 0..section {
            let v = std::f64::consts::TAU * f64::from(j) / f64::from(section);
            let radius = major + minor * v.cos();
            positions.push(dvec3(radius * cos_u, radius * sin_u, minor * v.sin()));
            let at = |i: u32, j: u32| i % around * section + j % section;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
    }
    Mesh::new(positions, triangles)
}

/// Both meshes side by side in one, sharing nothing.
pub fn joined(first: &Mesh, second: &Mesh) -> Mesh {
    let mut mesh = first.clone();
    let offset = first.positions.len() as u32;
    mesh.positions.extend(&second.positions);
    mesh.triangles
        .extend(second.triangles.iter().map(|t| t.map(|v| v + offset)));
    mesh
}

/// The mesh moved point by point.
pub fn mapped(mesh: &Mesh, map: impl Fn(DVec3) -> DVec3) -> Mesh {
    Mesh {
        positions: mesh.positions.iter().map(|&p| map(p)).collect(),
        ..mesh.clone()
    }
}
