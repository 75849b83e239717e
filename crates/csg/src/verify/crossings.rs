//! Where the rays of a lattice cross a mesh: one pass over the triangles, most of them
//! told to be beside all rays by their corners' ranks among the places of rays.

use glam::DVec3;
use rayon::prelude::*;

use super::rays::{Lattice, Ray};
use crate::mesh::Mesh;

/// Where a ray crosses a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    /// The ray's number.
    pub ray: u32,
    /// The coordinate along it.
    pub at: f64,
    /// 1 where it enters the mesh, -1 where it leaves.
    pub step: i32,
}

/// Triangles, or vertices, per parallel task. Tunes speed only.
const CHUNK: usize = 1 << 14;

/// The crossings of rays with a mesh, ray by ray, in the order along each.
pub(super) fn along(mesh: &Mesh, lattice: &Lattice) -> Vec<Crossing> {
    let ranks = ranks(mesh, lattice);
    let cross = |number: usize, triangles: &[[u32; 3]]| {
        let mut found = Vec::new();
        for (index, triangle) in (number * CHUNK..).zip(triangles) {
            let [a, b, c] = triangle.map(|vertex| ranks[vertex as usize]);
            // All rays are beside it where two of the three coordinates have one rank.
            let between = (a ^ b) | (a ^ c);
            if between != 0 {
                let is_between = [0xff, 0xff00, 0xff_0000].map(|byte| between & byte != 0);
                if is_between.into_iter().map(u32::from).sum::<u32>() > 1 {
                    cross_triangle(lattice, [a, b, c], mesh.corners(index), &mut found);
                }
            }
        }
        found
    };
    let mut found = if mesh.triangles.len() <= CHUNK {
        cross(0, &mesh.triangles)
    } else {
        let chunks = mesh.triangles.par_chunks(CHUNK).enumerate();
        let parts: Vec<Vec<Crossing>> = chunks.map(|(n, chunk)| cross(n, chunk)).collect();
        parts.concat()
    };
    found.sort_unstable_by(|a, b| a.ray.cmp(&b.ray).then(a.at.total_cmp(&b.at)));
    found
}

/// Of each vertex, along each axis, how many places of rays lie below it or at it: a byte
/// for each axis.
fn ranks(mesh: &Mesh, lattice: &Lattice) -> Vec<u32> {
    const LANES: usize = 4;
    let padded = lattice.places.each_ref().map(|places| {
        let mut chunks: Vec<[f64; LANES]> = Vec::new();
        for chunk in places.chunks(LANES) {
            let mut lanes = [f64::INFINITY; LANES];
            lanes[..chunk.len()].copy_from_slice(chunk);
            chunks.push(lanes);
        }
        chunks
    });
    let rank = |p: &DVec3| {
        let mut rank = 0;
        for (axis, chunks) in padded.iter().enumerate() {
            for lanes in chunks {
                let below = lanes.map(|at| u32::from(at <= p[axis]));
                rank += below.into_iter().sum::<u32>() << (8 * axis);
            }
        }
        rank
    };
    if mesh.positions.len() <= CHUNK {
        return mesh.positions.iter().map(rank).collect();
    }
    let positions = mesh.positions.par_iter().with_min_len(CHUNK);
    positions.map(rank).collect()
}

/// Adds where rays between the ranks of a triangle's corners cross it.
fn cross_triangle(
    lattice: &Lattice,
    ranks: [u32; 3],
    corners: [DVec3; 3],
    found: &mut Vec<Crossing>,
) {
    let ranges = [0, 1, 2].map(|axis| {
        let [a, b, c] = ranks.map(|rank| (rank >> (8 * axis) & 0xff) as usize);
        a.min(b).min(c)..a.max(b).max(c)
    });
    for axis in 0..3 {
        let [u, v] = [1, 2].map(|k| &ranges[(axis + k) % 3]);
        for first in u.clone() {
            for second in v.clone() {
                let number = lattice.number(axis, first, second);
                let crossing = cross(&lattice.ray(number), corners);
                found.extend(crossing.map(|(at, step)| Crossing {
                    ray: number as u32,
                    at,
                    step,
                }));
            }
        }
    }
}

/// Where a ray crosses a triangle, and whether it goes in (1) or out (-1).
fn cross(ray: &Ray, corners: [DVec3; 3]) -> Option<(f64, i32)> {
    let [u, v] = [1, 2].map(|k| (ray.axis + k) % 3);
    let [a, b, c] = corners.map(|p| (p[u] - ray.through[u], p[v] - ray.through[v]));
    let turn = |p: (f64, f64), q: (f64, f64)| p.0 * q.1 - p.1 * q.0;
    let weights = DVec3::new(turn(b, c), turn(c, a), turn(a, b));
    if weights.min_element() <= 0.0 && weights.max_element() >= 0.0 {
        return None;
    }
    let sum = weights.element_sum();
    let heights = DVec3::from_array(corners.map(|p| p[ray.axis]));
    let at = (weights / sum).dot(heights);
    Some((at, if sum > 0.0 { -1 } else { 1 }))
}
