//! What can be told of a mesh from the program alone, not by the mesher's
//! word.

use std::collections::HashSet;

use csg::program::{Cell, Pruner};
use csg::{Mesh, Program};
use glam::DVec3;
use stereotomy::csg;

use super::random::Random;

/// Defects of a mesh against its program; lengths relative to the scene.
#[derive(Debug, Default)]
pub struct Measures {
    /// The largest distance of a vertex from a surface that one of its
    /// triangles claims, to first order.
    pub miss: f64,
    /// Triangles against the outward gradient of their surface.
    pub folded: usize,
    /// Triangles less high than rounding.
    pub without_area: usize,
    /// Triangles on the same three points as another.
    pub duplicates: usize,
    /// Of each defect, the first place.
    pub places: Vec<(&'static str, DVec3)>,
}

impl Measures {
    fn add(&mut self, what: &'static str, place: DVec3) {
        match what {
            "folded" => self.folded += 1,
            "without area" => self.without_area += 1,
            _ => self.duplicates += 1,
        }
        if self.places.iter().all(|(known, _)| *known != what) {
            self.places.push((what, place));
        }
    }
}

/// The length of a mesh's diagonal.
pub fn size(mesh: &Mesh) -> f64 {
    mesh.bounds().map_or(0.0, |(low, high)| low.distance(high))
}

/// The largest distance, in model units and to first order, of a vertex from
/// a surface that one of its triangles claims.
pub fn largest_miss(program: &Program, mesh: &Mesh) -> f64 {
    let mut largest = 0.0f64;
    for (triangle, &entry) in mesh.triangles.iter().zip(&mesh.triangle_surfaces) {
        let surface = &program.surfaces()[mesh.surfaces[entry as usize].surface as usize];
        for &vertex in triangle {
            let p = mesh.positions[vertex as usize];
            let value = surface.value(p).abs();
            if value > 0.0 {
                largest = largest.max(value / surface.gradient(p).length());
            }
        }
    }
    largest
}

/// Measures a mesh on whose surfaces the solid is on one side throughout.
pub fn measure(program: &Program, mesh: &Mesh) -> Measures {
    let size = size(mesh);
    let mut measures = Measures {
        miss: largest_miss(program, mesh) / size,
        ..Measures::default()
    };
    let outward = outward_signs(program, mesh);
    let mut seen = HashSet::new();
    for (index, &entry) in mesh.triangle_surfaces.iter().enumerate() {
        let corners = mesh.corners(index);
        let [a, b, c] = corners;
        let centroid = (a + b + c) / 3.0;
        let normal = (b - a).cross(c - a);
        let longest = [b - a, c - b, a - c]
            .map(DVec3::length)
            .into_iter()
            .fold(0.0, f64::max);
        if normal.length() <= 1e-13 * size * longest {
            measures.add("without area", centroid);
        } else {
            let surface = &program.surfaces()[mesh.surfaces[entry as usize].surface as usize];
            let gradient = surface.gradient(centroid);
            if outward[entry as usize] * gradient.dot(normal) < 0.0 {
                measures.add("folded", centroid);
            }
        }
        let mut points = corners.map(|p| (p + 0.0).to_array().map(f64::to_bits));
        points.sort_unstable();
        if !seen.insert(points) {
            measures.add("duplicate", centroid);
        }
    }
    measures
}

/// For each surface of the mesh, whether the gradient points out of the solid
/// (1) or into it (-1), by asking the program on both sides of some triangles.
fn outward_signs(program: &Program, mesh: &Mesh) -> Vec<f64> {
    let mut triangles = vec![Vec::new(); mesh.surfaces.len()];
    for (index, &entry) in mesh.triangle_surfaces.iter().enumerate() {
        triangles[entry as usize].push(index);
    }
    let step = 1e-8 * size(mesh);
    let vote = |triangles: &Vec<usize>, entry: usize| {
        let surface = &program.surfaces()[mesh.surfaces[entry].surface as usize];
        let mut votes = [0usize; 2];
        for &index in triangles.iter().step_by(triangles.len().div_ceil(9)) {
            let [a, b, c] = mesh.corners(index);
            if (b - a).cross(c - a).length() <= 1e-6 * size(mesh).powi(2) * 1e-3 {
                continue;
            }
            let mut on = (a + b + c) / 3.0;
            for _ in 0..3 {
                let gradient = surface.gradient(on);
                on -= surface.value(on) * gradient / gradient.length_squared();
            }
            let out = surface.gradient(on).normalize() * step;
            match (program.contains(on - out), program.contains(on + out)) {
                (true, false) => votes[0] += 1,
                (false, true) => votes[1] += 1,
                // Across an edge already.
                _ => {}
            }
        }
        assert!(votes[0] == 0 || votes[1] == 0, "two-sided: {votes:?}");
        if votes[0] > 0 {
            1.0
        } else {
            -f64::from(votes[1].min(1) as u8)
        }
    };
    triangles
        .iter()
        .enumerate()
        .map(|(entry, triangles)| vote(triangles, entry))
        .collect()
}

/// How often the mesh winds around a point: the solid angle of its triangles
/// (Van Oosterom & Strackee 1983).
pub fn winding_number(mesh: &Mesh, point: DVec3) -> f64 {
    let angle = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize] - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let volume = a.dot(b.cross(c));
        let lengths = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * volume.atan2(lengths)
    };
    mesh.triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Holds a mesh against its program at random points, where that is possible
/// at cells of side `cell`: where everything within two cells is alike, the
/// mesh winds around the point once or not at all; and the volume is between
/// that of all such places inside and that of all places but those outside.
pub fn assert_agrees(program: &Program, mesh: &Mesh, cell: f64, random: &mut Random, name: &str) {
    const POINTS: usize = 1000;
    const WOUND_AROUND: usize = 40;
    let Some((low, high)) = mesh.bounds() else {
        return;
    };
    let (low, high) = (low - 2.0 * cell, high + 2.0 * cell);
    let root = program.root_cell();
    let (mut pruner, mut pruned) = (Pruner::default(), Cell::default());
    let mut decided = [0usize; 2];
    for _ in 0..POINTS {
        let point = low + (high - low) * DVec3::from_array([(); 3].map(|()| random.unit()));
        let half = DVec3::splat(2.0 * cell);
        root.prune_into(program.surfaces(), point, half, &mut pruner, &mut pruned);
        let Some(inside) = pruned.constant() else {
            continue;
        };
        assert_eq!(
            inside,
            program.contains(point),
            "{name}: pruning at {point}"
        );
        decided[usize::from(inside)] += 1;
        if decided[0] + decided[1] <= WOUND_AROUND {
            let wound = winding_number(mesh, point);
            let expected = if inside { 1.0 } else { 0.0 };
            assert!(
                (wound - expected).abs() < 1e-6,
                "{name}: winds {wound} times around {point}"
            );
        }
    }
    let share = mesh.volume() / (high - low).element_product();
    let points = POINTS as f64;
    let [least, most] = [decided[1] as f64 / points, 1.0 - decided[0] as f64 / points];
    let slack = |share: f64| 5.0 * (share * (1.0 - share) / points).sqrt() + 5.0 / points;
    assert!(
        least - slack(least) <= share && share <= most + slack(most),
        "{name}: {share} of the box, decided {least} to {most}"
    );
}
