//! The fast paths of a brick held against the plain ones, on random programs:
//! signs of 64 samples at a time against the whole program at each sample, and
//! validity of 64 vertices at a time against one by one.

use glam::{DVec3, UVec3};

use super::Placer;
use super::constraints::Constraints;
use super::vertices::NEAR;
use crate::program::{Bounds, Cell, Program, Pruner, Reach};
use crate::random::Random;
use crate::solid::Solid;
use crate::surface_nets::brick;
use crate::surface_nets::lattice::{CELLS, Lattice, SAMPLES};
use crate::surface_nets::scene::Scene;
use crate::surface_nets::validity::{self, Tests};

fn leaf(random: &mut Random) -> Solid {
    let mut size = || 0.2 + 0.8 * random.unit();
    let (a, b, c) = (size(), size(), size());
    match random.below(6) {
        0 => Solid::sphere(a),
        1 => Solid::cuboid([a, b, c]),
        2 => Solid::ellipsoid([a, b, c]),
        3 => Solid::cylinder(0.5 * a, -b..c),
        4 => Solid::cone(a, -b..c),
        _ => Solid::hyperboloid_one_sheet([0.5 * a, 0.5 * b, c]) & Solid::cube(1.5),
    }
}

/// One to eight primitives, some placed alike, so that faces coincide.
fn solid(random: &mut Random) -> Solid {
    let placed = |random: &mut Random| {
        let leaf = leaf(random);
        if random.below(3) == 0 {
            return leaf;
        }
        let mut number = || 2.0 * random.unit() - 1.0;
        let (angles, offset) = ([(); 3].map(|()| 3.0 * number()), [(); 3].map(|()| number()));
        leaf.rotate_xyz(angles[0], angles[1], angles[2])
            .translate(0.5 * DVec3::from_array(offset))
    };
    let mut solid = placed(random);
    for _ in 0..random.below(8) {
        let next = placed(random);
        solid = match random.below(4) {
            0 => solid & next,
            1 => solid - next,
            2 => next - solid,
            _ => solid | next,
        };
    }
    solid
}

/// Calls `visit` for every brick of random programs in which something varies.
fn bricks(mut visit: impl FnMut(&mut Random, &Program, &Scene<'_>, &Cell, &mut Placer)) {
    let bounds = Bounds {
        min: DVec3::splat(-1.5),
        max: DVec3::splat(1.5),
    };
    let (mut pruner, mut cell) = (Pruner::default(), Cell::default());
    let mut placer = Placer::default();
    for seed in 0..60 {
        let mut random = Random(seed);
        let program = Program::lower(&solid(&mut random)).expect("a valid solid");
        let reaches: Vec<Reach> = program.surfaces().iter().map(Reach::of).collect();
        let scene = Scene {
            surfaces: program.surfaces(),
            reaches: &reaches,
            origins: program.origins(),
            lattice: Lattice::around(&bounds, 0.11).expect("few cells"),
            tolerance: 1e-12,
        };
        let along = scene.lattice.bricks;
        for index in 0..along.element_product() {
            let position = UVec3::new(
                index % along.x,
                index / along.x % along.y,
                index / along.x / along.y,
            );
            let (center, half) = scene.lattice.bricks_box(position, position + 1);
            let root = program.root_cell();
            root.prune_reaching_into(scene.table(), center, half, &mut pruner, &mut cell);
            if cell.constant().is_some() {
                continue;
            }
            let first = position * CELLS as u32;
            for i in 0..SAMPLES {
                let along = |axis: usize| scene.lattice.coordinate(axis, first[axis] + i as u32);
                placer.samples.x[i] = along(0);
                placer.samples.y[i] = along(1);
                placer.samples.z[i] = along(2);
            }
            visit(&mut random, &program, &scene, &cell, &mut placer);
        }
    }
}

#[test]
fn signs_of_whole_bricks_are_those_of_single_samples() {
    let mut seen = [0usize; 2];
    bricks(|_, program, scene, cell, placer| {
        let Placer {
            classified,
            samples,
            ..
        } = placer;
        classified.classify(cell, scene.table(), samples);
        for sample in 0..SAMPLES.pow(3) {
            let point = samples.point(sample);
            for (signs, &id) in classified.signs.iter().zip(&cell.surfaces) {
                let inside = scene.surfaces[id as usize].value(point) <= 0.0;
                assert_eq!(brick::is_set(signs, sample), inside, "{point}");
            }
            // The whole program, nothing pruned.
            let inside = program.contains(point);
            assert_eq!(
                brick::is_set(&classified.solid, sample),
                inside,
                "{point} of {program}"
            );
            seen[usize::from(inside)] += 1;
        }
    });
    assert!(seen[0] > 10_000 && seen[1] > 10_000, "{seen:?}");
}

#[test]
fn validity_of_many_vertices_is_that_of_each() {
    let (mut decided, mut undecided) = ([0usize; 2], 0);
    bricks(|random, program, scene, cell, placer| {
        let mut vertices: Vec<(Constraints, DVec3)> = Vec::new();
        for _ in 0..400 {
            let mut constraints = Constraints::default();
            for _ in 0..1 + random.below(3) {
                constraints.insert(random.below(cell.surfaces.len()) as u16);
            }
            let start = placer.samples.point(random.below(SAMPLES.pow(3)));
            let point = placer.try_constraints(scene, cell, &constraints, start, start, NEAR);
            vertices.extend(point.map(|point| (constraints, point)));
        }
        let mut tests = Tests::default();
        for batch in vertices.chunks(validity::LANES) {
            let points = batch.iter().map(|&(_, point)| point);
            tests.begin(points, scene, cell);
            for (lane, (constraints, _)) in batch.iter().enumerate() {
                tests.free(lane, constraints.as_slice());
            }
            let verdicts = tests.evaluate(&cell.formula);
            for (lane, (constraints, point)) in batch.iter().enumerate() {
                let Some(valid) = verdicts.get(lane, constraints.len) else {
                    undecided += 1;
                    continue;
                };
                let expected = placer.is_valid(scene, cell, constraints, *point);
                assert_eq!(valid, expected, "{constraints:?} at {point} of {program}");
                decided[usize::from(valid)] += 1;
            }
        }
    });
    assert!(decided[0] > 1000 && decided[1] > 1000, "{decided:?}");
    assert!(undecided < decided[1] / 4, "{undecided} of {decided:?}");
}
