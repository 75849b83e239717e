//! Polyhedra of many faces, cut by other solids and by each other: closed, embedded, and
//! what is cut off and what is left make up the whole.

mod meshes;

use csg::glam::{DQuat, DVec3, EulerRot, dvec3};
use csg::{Mesh, Meshed, Mesher, Program, Solid, turn};

use crate::measured::measured;
use crate::random::Random;
use crate::shapes::joined;
use crate::sweeps::one_in;
use meshes::{ball, rounded_cube, star};

fn solid(mesh: &Mesh) -> Solid {
    Solid::from_mesh(mesh).unwrap_or_else(|faults| panic!("{faults}"))
}

#[track_caller]
fn evaluated(what: &str, solid: &Solid, mesher: &Mesher) -> Meshed {
    let program = Program::lower(solid).unwrap_or_else(|e| panic!("{what}: {e}"));
    let meshed = mesher.mesh(&program);
    let meshed = meshed.unwrap_or_else(|e| panic!("{what}: {e}"));
    let report = &meshed.report;
    assert_eq!(report.fallbacks, [], "{what} {:?}", report.undecided);
    assert!(report.check.is_manifold(), "{what}: {}", report.check);
    assert_eq!(meshed.mesh.self_intersections().len(), 0, "{what}");
    meshed
}

/// The volume of a solid of flat faces.
#[track_caller]
fn volume(what: &str, solid: &Solid) -> f64 {
    let meshed = evaluated(what, solid, &Mesher::new());
    assert_eq!(meshed.report.method, "polyhedral", "{what}");
    assert_eq!(meshed.report.undecided, [], "{what}");
    meshed.mesh.volume()
}

/// Of two solids of known volumes the union, the intersection and both differences: parts
/// make up wholes.
#[track_caller]
fn assert_parts(what: &str, [a, b]: [&Solid; 2], volumes: [f64; 2], within: f64) {
    let all = volume(what, &(a | b));
    let both = volume(what, &(a & b));
    let rest = [volume(what, &(a - b)), volume(what, &(b - a))];
    let off = [
        all + both - volumes[0] - volumes[1],
        rest[0] + both - volumes[0],
        rest[1] + both - volumes[1],
    ];
    assert!(off.iter().all(|off| off.abs() <= within), "{what}: {off:?}");
    assert!(both > 0.0, "{what}");
}

#[test]
fn a_ball_is_what_its_file_says() {
    let mesh = ball(4, 1.0);
    let meshed = evaluated("ball", &solid(&mesh), &Mesher::new()).mesh;
    assert_eq!(meshed.triangles.len(), mesh.triangles.len());
    assert!((meshed.volume() - mesh.volume()).abs() < 1e-14);
    // Its vertices were given, not recomputed.
    for (k, vertex) in mesh.positions.iter().enumerate() {
        let found = meshed.positions.iter().map(|p| p.distance(*vertex));
        let nearest = found.fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-15, "{k}: {nearest}");
    }
}

#[test]
fn balls_are_cut_by_cubes_and_by_each_other() {
    for n in [2, 4] {
        let mesh = ball(n, 1.0);
        let (ball, size) = (solid(&mesh), mesh.volume());
        let cube = Solid::cuboid_between([0.1, 0.2, 0.3], [2.0, 2.0, 2.0]);
        assert_parts("a cube", [&ball, &cube], [size, 1.9 * 1.8 * 1.7], 1e-12);
        let moved = ball.translate([0.11, 0.23, 0.07]);
        assert_parts("moved", [&ball, &moved], [size; 2], 1e-12);
        let turned = ball.rotate_xyz(0.1, 0.2, 0.3);
        assert_parts("turned", [&ball, &turned], [size; 2], 1e-12);
        let mirrored = ball.scale_xyz([-1.0, 1.0, 1.0]);
        assert_parts("mirrored", [&ball, &mirrored], [size; 2], 1e-12);
    }
}

/// Nothing is left of a solid without itself, and nothing is added to it.
#[test]
fn a_ball_and_itself_are_itself() {
    let mesh = ball(3, 1.0);
    let ball = solid(&mesh);
    for by in [0.0, 1e-15, 1e-13, 1e-12] {
        let moved = ball.translate([by, -by, 0.5 * by]);
        let what = format!("by {by:e}");
        let all = volume(&what, &(&ball | &moved));
        assert!((all - mesh.volume()).abs() < 1e-10, "{what}: {all}");
        assert_eq!(volume(&what, &(&ball - &moved)), 0.0, "{what}");
    }
}

/// Faces that are flat but for the rounding of their vertices.
#[test]
fn rounded_cubes_are_cut() {
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, 0.5, 0.7);
    for turn in [DQuat::IDENTITY, turn] {
        let mesh = rounded_cube(12, turn);
        let (cube, size) = (solid(&mesh), mesh.volume());
        assert!((volume("cube", &cube) - size).abs() < 1e-12);
        let peg = Solid::cuboid([0.5, 0.7, 9.0]);
        assert_parts("a peg", [&cube, &peg], [size, 0.5 * 0.7 * 9.0], 1e-12);
        // On a side of the one that was not turned, and across edges of the other.
        let block = Solid::cuboid_between([0.25, -0.5, -0.5], [2.0, 0.5, 1.0]);
        assert_parts("a block", [&cube, &block], [size, 1.75 * 1.5], 1e-12);
    }
    // Of the one that was not turned all sides are exact, and three are shared.
    let mesh = rounded_cube(12, DQuat::IDENTITY);
    let cube = solid(&mesh);
    let other = cube.scale(0.5).translate([0.5, 0.5, 0.5]);
    assert_parts("a corner", [&cube, &other], [8.0, 1.0], 1e-12);
}

#[test]
fn random_stars_cut_each_other() {
    let mut random = Random(7);
    for round in 0..6 {
        let mut mesh = || {
            let waves: Vec<(DVec3, f64)> = (0..4)
                .map(|_| {
                    let mut unit = || 2.0 * random.unit() - 1.0;
                    (6.0 * dvec3(unit(), unit(), unit()), 6.0 * random.unit())
                })
                .collect();
            let wave = |d: DVec3| waves.iter().map(|(k, p)| (k.dot(d) + p).sin()).sum::<f64>();
            star(3, |direction| 1.0 + 0.12 * wave(direction))
        };
        let meshes = [mesh(), mesh()];
        let [one, other] = meshes.each_ref().map(solid);
        // Else edges over the same directions would cross each other.
        let solids = [one, other.rotate_xyz(0.4, 0.9, 1.3)];
        let volumes = meshes.each_ref().map(Mesh::volume);
        let what = format!("stars {round}");
        assert_parts(&what, [&solids[0], &solids[1]], volumes, 1e-12);
    }
}

/// Exact circles on facets, to a tolerance.
#[test]
fn balls_are_drilled_and_hollowed() {
    for (n, mesh) in [(2, ball(2, 1.0)), (4, ball(4, 1.0))] {
        let ball = solid(&mesh);
        let tools = [
            Solid::infinite_cylinder(0.3).rotate_xyz(0.1, 0.2, 0.0),
            Solid::infinite_cylinder(0.25).translate([0.5, 0.3, 0.0]),
            Solid::sphere(0.7).translate([0.5, 0.4, 0.6]),
            Solid::sphere(0.6),
            Solid::cone(0.8, 0.0..1.5),
        ];
        for (k, tool) in tools.iter().enumerate() {
            let what = format!("ball {n} less tool {k}");
            let mesher = Mesher::new().tolerance(1e-3);
            let [rest, both] = [&ball - tool, &ball & tool].map(|solid| {
                let meshed = evaluated(&what, &solid, &mesher);
                assert_eq!(meshed.report.method, "boundary", "{what}");
                meshed.mesh
            });
            let off = rest.volume() + both.volume() - mesh.volume();
            let most = 2e-3 * both.area();
            assert!(off.abs() <= most, "{what}: {off}");
        }
    }
}

/// Convex solids of many planes take the same road.
#[test]
fn faceted_solids_are_cut() {
    let polygon = |n: usize| (0..n).map(move |k| turn(k, n));
    for n in [50, 64, 256] {
        let area = 0.5 * n as f64 * turn(1, n).y;
        let prism = Solid::prism(polygon(n), -1.0..1.0);
        let turned = prism.scale(0.5).rotate_x(1.0).translate([0.1, 0.2, 0.3]);
        let what = format!("prisms of {n}");
        assert_parts(&what, [&prism, &turned], [2.0 * area, 0.25 * area], 1e-11);
        let points = polygon(n).map(|p| p.extend(0.0)).chain([3.0 * DVec3::Z]);
        let pyramid = Solid::hull(points);
        let what = format!("a pyramid over {n}");
        assert_parts(&what, [&prism, &pyramid], [2.0 * area, area], 1e-11);
        let clockwise: Vec<_> = polygon(n).map(|p| 0.9 * p).rev().collect();
        let peg = Solid::prism(clockwise, 0.0..2.0);
        let what = format!("a peg of {n}");
        assert_parts(&what, [&prism, &peg], [2.0 * area, 1.62 * area], 1e-11);
    }
}

/// A block of faces of so many squares each, in place.
fn block([low, high]: [DVec3; 2], squares: u32, place: impl Fn(DVec3) -> DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for is_high in [false, true] {
            let at = |i: u32, j: u32| {
                let mut share = DVec3::ZERO;
                share[axis] = f64::from(u8::from(is_high));
                share[u] = f64::from(i) / f64::from(squares);
                share[v] = f64::from(j) / f64::from(squares);
                low + share * (high - low)
            };
            for (i, j) in (0..squares).flat_map(|i| (0..squares).map(move |j| (i, j))) {
                let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(corners.map(&place));
                let quad = [0, 1, 2, 3].map(|k| first + if is_high { k } else { 3 - k });
                let [a, b, c, d] = quad;
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

/// One polyhedron of blocks with cracks between them that are as thin as rounding makes them, or
/// a little thicker: faces that look at each other are on one plane or on two, and parts of them
/// are in the open.
#[test]
fn blocks_a_hair_apart_are_all_there() {
    let mut random = Random(3);
    let mut taken = 0;
    for case in (0..400).step_by(one_in(7)) {
        let mut unit = || random.unit();
        let squares = [1, 1, 3, 5][(4.0 * unit()) as usize];
        let turn = if unit() < 0.5 {
            DQuat::IDENTITY
        } else {
            DQuat::from_euler(EulerRot::XYZ, 6.0 * unit(), 6.0 * unit(), 6.0 * unit())
        };
        let mut round = |least: f64, most: f64| (least + unit() * (most - least)).round();
        let size = dvec3(round(2.0, 8.0), round(2.0, 8.0), round(2.0, 8.0));
        let core = [-size, size];
        let others = round(1.0, 4.0) as usize;
        let mut blocks = vec![core];
        let mut sides: Vec<usize> = (0..6).collect();
        let mut thickest: f64 = 0.0;
        for _ in 0..others {
            let side = sides.swap_remove(round(0.0, sides.len() as f64 - 1.0) as usize);
            let (axis, is_above) = (side / 2, side.is_multiple_of(2));
            let gap = 10.0_f64.powf(-round(8.0, 16.0));
            thickest = thickest.max(gap);
            // Beside the block, within what is beside it alone.
            let mut low = DVec3::ZERO;
            let mut high = DVec3::ZERO;
            for across in [(axis + 1) % 3, (axis + 2) % 3] {
                low[across] = -round(0.0, size[across]);
                high[across] = round(1.0, size[across]);
            }
            let near = size[axis] + gap;
            let far = size[axis] + round(1.0, 5.0);
            (low[axis], high[axis]) = if is_above { (near, far) } else { (-far, -near) };
            blocks.push([low, high]);
        }
        let place = |point: DVec3| turn * point;
        let meshes = blocks.iter().map(|&ends| block(ends, squares, place));
        let mesh = meshes.fold(Mesh::default(), |all, own| joined(&all, &own));
        // Turned, some of them overlap.
        let Ok(all) = Solid::from_mesh(&mesh) else {
            continue;
        };
        taken += 1;
        let whole = mesh.volume();
        let area = mesh.area();
        let what = format!("{case}: {blocks:?}, {squares}, {turn}");
        let within = area * thickest + 1e-10 * whole;
        let found = volume(&what, &all);
        assert!(
            (found - whole).abs() <= within,
            "{what}: {found} for {whole}"
        );
        // About a corner of the first.
        let cut = |tool: &Solid| tool.translate(turn * core[1]);
        let block = cut(&Solid::cuboid(DVec3::splat(7.0)).rotate_xyz(0.1, 0.2, 0.3));
        let parts = volume(&what, &(&all & &block)) + volume(&what, &(&all - &block));
        assert!(
            (parts - whole).abs() <= 2.0 * within,
            "{what}: {parts} for {whole}"
        );
        let rod = Solid::cylinder(2.0, -4.0..4.0);
        for tool in [Solid::sphere(4.0), rod.rotate_xyz(0.1, 0.2, 0.3), rod] {
            let tool = cut(&tool);
            let parts =
                measured(&what, &(&all & &tool)).value + measured(&what, &(&all - &tool)).value;
            assert!(
                (parts - whole).abs() <= 2.0 * within,
                "{what}: {parts} for {whole}"
            );
        }
    }
    assert!(taken >= 40, "{taken}");
}
