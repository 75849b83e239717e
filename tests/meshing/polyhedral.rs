//! Solids bounded by planes alone: their boundary without sampling.

use std::f64::consts::TAU;

use csg::{Axis, Color, Meshed, Mesher, Plane, Program, Solid};
use glam::{DVec3, dvec3};
use stereotomy::csg;

use super::hard_models;
use super::measures::assert_agrees;
use crate::random::Random;
use crate::sweeps::one_in;

/// How many random solids are tried.
const SOLIDS: u64 = 400;

fn mesh(solid: &Solid) -> (Program, Meshed) {
    let program = Program::lower(solid).expect("a valid solid");
    let meshed = Mesher::new().tolerance(0.1).mesh(&program).expect("a mesh");
    (program, meshed)
}

/// Everything that holds of every such mesh.
fn assert_exact(name: &str, program: &Program, meshed: &Meshed) {
    let Meshed { mesh, report, .. } = meshed;
    assert_eq!(report.method, "polyhedral", "{name}");
    assert!(report.check.is_manifold(), "{name}: {}", report.check);
    let Some((low, high)) = mesh.bounds() else {
        assert_eq!(mesh.triangles.len(), 0, "{name}");
        return;
    };
    let size = (high - low).max_element();
    let rounding = 1e-12 * size + 1e-14 * low.abs().max(high.abs()).max_element();
    for (index, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(index);
        assert!((b - a).cross(c - a).length() > 0.0, "{name}: {a} {b} {c}");
        let surface = mesh.surface_of(index).expect("a surface").surface;
        let plane = &program.surfaces()[surface as usize];
        for &corner in corners {
            let off = plane.value(mesh.positions[corner as usize]).abs();
            assert!(off <= rounding, "{name}: off its plane by {off:e}");
        }
    }
    let deviation = report.deviation.expect("a deviation");
    assert!(deviation <= rounding, "{name}: {deviation:e}");
}

/// Nor does it run through itself.
fn assert_sound(name: &str, program: &Program, meshed: &Meshed) {
    assert_exact(name, program, meshed);
    let fallbacks = &meshed.report.fallbacks;
    assert!(fallbacks.is_empty(), "{name}: {fallbacks:?}");
    let crossings = meshed.mesh.self_intersections();
    assert!(crossings.is_empty(), "{name}: {}", crossings.len());
}

#[test]
fn random_solids_are_exact() {
    let solids = SOLIDS / one_in(4) as u64;
    let (mut meshed_solids, mut touching) = (0, 0);
    for seed in 0..solids {
        let mut random = Random::new(seed);
        let solid = random.polyhedron();
        let (program, meshed) = mesh(&solid);
        let name = format!("seed {seed}");
        assert_exact(&name, &program, &meshed);
        assert_agrees(&program, &meshed.mesh, 1e-9, &mut random, &name);
        meshed_solids += u64::from(!meshed.mesh.triangles.is_empty());
        // A corner may touch the middle of a face, on either side of it but for
        // rounding: this is reported.
        let crosses = !meshed.mesh.self_intersections().is_empty();
        assert_eq!(crosses, !meshed.report.fallbacks.is_empty(), "{name}");
        touching += u64::from(crosses);
    }
    assert!(touching * 200 <= solids, "{touching}");
    // Otherwise little was tried.
    assert!(meshed_solids > solids / 2, "{meshed_solids}");
}

#[test]
fn few_triangles_and_the_right_volume() {
    let mut sponge = Solid::cube(2.0);
    for level in 1..=2 {
        let count = 3i32.pow(level - 1);
        let side = 2.0 / f64::from(count);
        for place in 0..count * count {
            let [x, y] = [place % count, place / count].map(|k| side * (f64::from(k) + 0.5) - 1.0);
            let hole = Solid::cuboid([side / 3.0, side / 3.0, 3.0]).translate([x, y, 0.0]);
            let along = |axis: Axis| match axis {
                Axis::X => hole.rotate_y(TAU / 4.0),
                Axis::Y => hole.rotate_x(TAU / 4.0),
                Axis::Z => hole.clone(),
            };
            sponge = sponge - along(Axis::X) - along(Axis::Y) - along(Axis::Z);
        }
    }
    let turned_box = Solid::cuboid([1.2, 1.0, 1.2]).rotate_xyz(0.3, 0.5, 0.7);
    let prism = Solid::prism(
        (0..24).map(|k| {
            [
                (TAU * f64::from(k) / 24.0).cos(),
                (TAU * f64::from(k) / 24.0).sin(),
            ]
        }),
        0.0..1.0,
    );
    let octagonal_hole = Solid::cuboid([2.0, 2.0, 1.0])
        - Solid::prism(
            [[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0], [0.0, -0.5]],
            -1.0..1.0,
        );
    for (name, solid, triangles, volume, genus) in [
        ("turned box", turned_box, 12, 1.44, 0),
        ("sponge", sponge, 1296, 8.0 * (20.0f64 / 27.0).powi(2), 81),
        ("prism", prism, 4 * 24 - 4, 12.0 * (TAU / 24.0).sin(), 0),
        ("hole", octagonal_hole, 2 * (4 + 4) + 4 * 4, 4.0 - 0.5, 1),
    ] {
        let (program, meshed) = mesh(&solid);
        assert_sound(name, &program, &meshed);
        assert_eq!(meshed.mesh.triangles.len(), triangles, "{name}");
        let error = meshed.mesh.volume() - volume;
        assert!(error.abs() < 1e-14 * volume.max(1.0), "{name}: {error:e}");
        assert_eq!(meshed.report.check.genus(), Some(genus), "{name}");
    }
}

#[test]
fn solids_that_touch_are_split() {
    let unit = Solid::cuboid_between(DVec3::ZERO, DVec3::ONE);
    let at = |x: f64, y: f64, z: f64| unit.translate([x, y, z]);
    // Two slabs, and between them two posts with an edge in common: both its
    // ends are points of one and the same fan.
    let posts = Solid::cuboid_between([0.0, 0.0, -1.0], [2.0, 2.0, 0.0])
        | at(0.0, 0.0, 0.0)
        | at(1.0, 1.0, 0.0)
        | Solid::cuboid_between([0.0, 0.0, 1.0], [2.0, 2.0, 2.0]);
    // The tip of a wedge touches the middle of an edge.
    let wedge = Solid::convex_polyhedron([
        Plane::through([0.0, 0.0, 0.5], [-1.0, 0.0, 2.0]),
        Plane::through([0.0, 0.0, 0.5], [-1.0, 0.0, -2.0]),
        Plane::through([0.0, 0.0, 0.5], [-1.0, 2.0, 0.0]),
        Plane::through([0.0, 0.0, 0.5], [-1.0, -2.0, 0.0]),
        Plane::through([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]),
    ]);
    let block = Solid::cuboid_between([-1.0, -1.0, 0.0], [0.0, 0.0, 1.0]);
    // The edge of a hollow touches the middle of a face from inside.
    let hollow = Solid::cuboid([0.2, 0.2, 0.5]).rotate_z(TAU / 8.0);
    let hollow = Solid::cube(1.0) - hollow.translate([0.5 - 0.1 * 2.0f64.sqrt(), 0.0, 0.0]);
    let wedge_volume = 0.5 * 0.5 * 0.5 / 3.0;
    for (name, solid, volume, parts) in [
        ("edge", at(0.0, 0.0, 0.0) | at(1.0, 1.0, 0.0), 2.0, 2),
        ("corner", at(0.0, 0.0, 0.0) | at(1.0, 1.0, 1.0), 2.0, 2),
        ("face", at(0.0, 0.0, 0.0) | at(1.0, 0.0, 0.0), 2.0, 1),
        ("posts", posts, 10.0, 1),
        ("tip", block | wedge, 1.0 + wedge_volume, 2),
        ("hollow", hollow, 1.0 - 0.2 * 0.2 * 0.5, 1),
    ] {
        for turn in [0.0, 0.7] {
            let (program, meshed) = mesh(&solid.rotate_xyz(turn, 2.0 * turn, 3.0 * turn));
            assert_sound(name, &program, &meshed);
            let error = meshed.mesh.volume() - volume;
            assert!(error.abs() < 1e-13, "{name}: {error:e}");
            assert_eq!(meshed.report.check.components, parts, "{name} {turn}");
        }
    }
}

#[test]
fn many_planes_through_one_point_or_one_line() {
    // A cone of 100 sides, cut off and not; and half of a star of slices that
    // all have one edge in common.
    let sides = 100;
    let angle = |k: u32| TAU * f64::from(k) / f64::from(sides);
    let side = |k| Plane::through(DVec3::Z, [angle(k).cos(), angle(k).sin(), 1.0]);
    let base = Plane::through(DVec3::ZERO, -DVec3::Z);
    let cone = Solid::convex_polyhedron((0..sides).map(side).chain([base]));
    let polygon = f64::from(sides) / 2.0 * (2.0 * (TAU / f64::from(sides) / 2.0).tan());
    let volume = polygon / 3.0;
    let blades = (0..7).map(|k| {
        let turn = TAU * f64::from(k) / 14.0;
        let wedge = Solid::half_space([0.0, -1.0, 0.0], 0.0)
            & Solid::half_space([0.0, 1.0, 0.0], 0.0).rotate_z(TAU / 28.0);
        wedge.rotate_z(2.0 * turn)
    });
    let star = Solid::union(blades) & Solid::cuboid([2.0, 2.0, 1.0]);
    for turn in [0.0, 0.4] {
        let (program, meshed) = mesh(&cone.rotate_xyz(turn, turn, turn));
        assert_sound("cone", &program, &meshed);
        assert_eq!(meshed.mesh.positions.len(), 101);
        // Neighbouring sides meet at a small angle: rounding grows by as much.
        let error = meshed.mesh.volume() - volume;
        assert!(error.abs() < 1e-14 * f64::from(sides), "{error:e}");
        let (program, meshed) = mesh(&star.rotate_xyz(turn, turn, turn));
        assert_sound("star", &program, &meshed);
        assert_eq!(meshed.report.check.components, 7, "{turn}");
    }
}

#[test]
fn colours_end_where_their_primitives_do() {
    let red = Color::from_linear([1.0, 0.0, 0.0]);
    let blue = Color::from_linear([0.0, 0.0, 1.0]);
    let left = Solid::cuboid_between([0.0; 3], [1.0; 3]).colored(red);
    let right = Solid::cuboid_between([1.0, 0.0, 0.0], [3.0, 1.0, 1.0]).colored(blue);
    let (program, meshed) = mesh(&(left | right));
    assert_sound("colours", &program, &meshed);
    let mut areas = [0.0; 2];
    for index in 0..meshed.mesh.triangles.len() {
        let [a, b, c] = meshed.mesh.corners(index);
        let color = meshed.mesh.surface_of(index).and_then(|s| s.color);
        areas[usize::from(color == Some(blue))] += 0.5 * (b - a).cross(c - a).length();
    }
    assert!(
        (areas[0] - 5.0).abs() < 1e-14 && (areas[1] - 9.0).abs() < 1e-14,
        "{areas:?}"
    );
}

#[test]
fn walls_and_gaps_of_a_billionth_are_there() {
    for thickness in [1e-3, 1e-6, 1e-9] {
        let walls = Solid::cube(1.0) - Solid::cube(1.0 - 2.0 * thickness);
        let gap = Solid::cube(1.0) - Solid::cuboid([thickness, 0.5, 2.0]);
        for (solid, genus, volume) in [
            (walls, 0, 1.0 - (1.0 - 2.0 * thickness).powi(3)),
            (gap, 1, 1.0 - 0.5 * thickness),
        ] {
            let (program, meshed) = mesh(&solid.rotate_xyz(0.3, 0.5, 0.7));
            assert_sound("thin", &program, &meshed);
            assert_eq!(meshed.report.check.genus(), Some(genus), "{thickness}");
            let error = meshed.mesh.volume() - volume;
            assert!(error.abs() < 1e-14, "{thickness}: {error:e}");
        }
    }
}

#[test]
fn flat_hard_models_are_exact_wherever_they_are() {
    for (name, solid) in hard_models::all() {
        let program = Program::lower(&solid).expect("a valid solid");
        if !program.surfaces().iter().all(csg::Surface::is_plane) {
            continue;
        }
        let home = mesh(&solid).1;
        for offset in [DVec3::ZERO, dvec3(1e6, -2e6, 1e6)] {
            for scale in [1.0, 1e-6, 1e6] {
                let moved = solid
                    .rotate_xyz(0.3, 0.5, 0.7)
                    .scale(scale)
                    .translate(offset * scale);
                let (program, meshed) = mesh(&moved);
                assert_sound(name, &program, &meshed);
                let (report, at_home) = (&meshed.report, &home.report);
                assert_eq!(report.check.genus(), at_home.check.genus(), "{name}");
                assert_eq!(report.check.components, at_home.check.components, "{name}");
            }
        }
    }
}

#[test]
fn one_and_eight_threads_give_the_same_mesh() {
    let pools = [1, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads")
    });
    let mut solid = Random::new(7).polyhedron();
    for seed in 8..40u8 {
        let at = dvec3(f64::from(seed % 4), f64::from(seed / 4), 0.0);
        solid = solid | Random::new(seed.into()).polyhedron().translate(1.7 * at);
    }
    let [one, eight] = pools.map(|pool| pool.install(|| mesh(&solid).1.mesh));
    assert!(one.triangles.len() > 1000);
    assert!(one == eight);
}
