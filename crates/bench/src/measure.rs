//! The same measures for every mesh, whoever made it.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use csg::{Mesh, Program};
use glam::DVec3;

use crate::scenes::Scene;
use crate::truth::Truth;

/// What is right and wrong with a mesh of a scene.
#[derive(Clone, Debug)]
pub struct Quality {
    /// How many triangles.
    pub triangles: usize,
    /// Its volume less the true one, relative to that.
    pub volume_error: f64,
    /// The largest distance of a triangle's centroid to the true boundary.
    pub chord: f64,
    /// The largest distance of a vertex to the true boundary.
    pub vertex_distance: f64,
    /// Triangles whose normal points against the outward normal of every
    /// surface that bounds the solid next to their centroid.
    pub folds: usize,
    /// Edges with other than two triangles.
    pub bad_edges: usize,
    /// Whether it is a closed, oriented manifold.
    pub manifold: bool,
    /// The sum of genera, of a manifold mesh.
    pub genus: Option<i64>,
}

/// Measures a mesh made with cells of the given size.
pub fn quality(scene: &Scene, program: &Program, mesh: &Mesh, cell: f64) -> Quality {
    let truth = Truth::new(program, scene.half);
    let check = mesh.check();
    let centroids: Vec<DVec3> = (0..mesh.triangles.len())
        .map(|i| mesh.corners(i).iter().sum::<DVec3>() / 3.0)
        .collect();
    let chord = Largest::default();
    let folds = AtomicUsize::new(0);
    truth.visit(&centroids, cell, &|i, nearest| {
        chord.add(nearest.map_or(f64::INFINITY, |n| n.distance));
        let [a, b, c] = mesh.corners(i);
        let normal = (b - a).cross(c - a);
        if nearest.is_some_and(|n| n.normals.iter().all(|&out| normal.dot(out) < 0.0)) {
            folds.fetch_add(1, Ordering::Relaxed);
        }
    });
    let vertex_distance = Largest::default();
    truth.visit(&mesh.positions, cell, &|_, nearest| {
        vertex_distance.add(nearest.map_or(f64::INFINITY, |n| n.distance));
    });
    Quality {
        triangles: mesh.triangles.len(),
        volume_error: (mesh.volume() - scene.volume) / scene.volume,
        chord: chord.value(),
        vertex_distance: vertex_distance.value(),
        folds: folds.into_inner(),
        bad_edges: check.open_edges + check.non_manifold_edges,
        manifold: check.is_manifold(),
        genus: check.genus(),
    }
}

/// The largest of non-negative numbers, gathered from many threads: their
/// bits are in the same order as they are.
#[derive(Default)]
pub struct Largest(AtomicU64);

impl Largest {
    /// Takes one more into account.
    pub fn add(&self, value: f64) {
        self.0.fetch_max(value.to_bits(), Ordering::Relaxed);
    }

    /// The largest so far, or zero.
    pub fn value(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}
