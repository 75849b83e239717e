//! Meshes held against programs at random points: do both agree on what is
//! inside, and how much of it there is?

use csg::program::{Cell, Pruner};
use csg::{Mesh, Program};
use glam::DVec3;
use stereotomy::csg;

use crate::random::Random;

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
