//! Solids with curved surfaces, meshed from the curves in which surfaces meet.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

use csg::{Color, Mesh, Meshed, Mesher, Profile, Program, Solid, Surface};
use glam::DVec3;
use stereotomy::{csg, scenes};

use super::adaptive::{genus, turned};
use super::defects::measure;
use super::tolerance::sampled_deviation;
use crate::random::Random;
use crate::sweeps::one_in;

const TOLERANCE: f64 = 1e-3;

fn mesh(solid: &Solid) -> (Program, Meshed) {
    let program = Program::lower(solid).expect("a valid solid");
    let meshed = Mesher::new().tolerance(TOLERANCE).mesh(&program);
    (program, meshed.expect("a mesh"))
}

/// By Simpson's rule.
fn integral(range: Range<f64>, value: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 1000;
    let step = (range.end - range.start) / f64::from(STEPS);
    let weigh = |k: u32| match k {
        0 | STEPS => 1.0,
        k if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let at = |k: u32| value(range.start + f64::from(k) * step);
    (0..=STEPS).map(|k| weigh(k) * at(k)).sum::<f64>() * step / 3.0
}

/// Name, solid, volume, area at most, genus.
fn solids() -> Vec<(&'static str, Solid, f64, f64, i64)> {
    let ball = || Solid::sphere(1.0);
    let cap = |height: f64| PI * height * height * (1.0 - height / 3.0);
    // Its edge is in the plane z = 0.
    let pencil = || Solid::cylinder(1.0, -1.0..3.0) & Solid::cone(1.5, -1.0..2.0);
    let of_pencil = PI + PI * 2.0 / 3.0;
    // All that matters of a plane z = 0 is around the pencil, or nothing.
    let frame = || {
        Solid::cuboid_between([-4.0, -4.0, -4.0], [4.0, 4.0, 0.0]) - Solid::cuboid([4.0, 4.0, 20.0])
    };
    let bead = || {
        Solid::cuboid_between([-4.0, -4.0, 0.0], [4.0, 4.0, 2.0])
            & Solid::sphere(0.2).translate([0.7, 0.7, 1.7])
    };
    let of_bead = 4.0 / 3.0 * PI * 0.008;
    vec![
        (
            "pencil, frame",
            pencil() | frame(),
            192.0 + of_pencil,
            310.0,
            1,
        ),
        (
            "frame, pencil",
            frame() | pencil(),
            192.0 + of_pencil,
            310.0,
            1,
        ),
        (
            "pencil, bead",
            pencil() | bead(),
            of_pencil + of_bead,
            18.0,
            0,
        ),
        (
            "bead, pencil",
            bead() | pencil(),
            of_pencil + of_bead,
            18.0,
            0,
        ),
        ("sphere", ball(), scenes::SPHERE_VOLUME, 13.0, 0),
        (
            "drilled",
            scenes::drilled(),
            scenes::DRILLED_VOLUME,
            15.0,
            5,
        ),
        // Curves cross where its surfaces touch.
        (
            "tricylinder",
            scenes::tricylinder(),
            scenes::TRICYLINDER_VOLUME,
            15.0,
            0,
        ),
        ("flange", scenes::flange(), scenes::FLANGE_VOLUME, 12.0, 9),
        (
            "lens",
            ball() & ball().translate([0.0, 0.0, 1.2]),
            2.0 * cap(0.4),
            6.0,
            0,
        ),
        // The tip is where seams meet; two faces end in it.
        ("cone", Solid::cone(1.0, 0.0..2.0), PI * 2.0 / 3.0, 11.0, 0),
        (
            "half cone",
            Solid::cone(1.0, 0.0..2.0) & Solid::cuboid([4.0, 4.0, 8.0]).translate([2.0, 0.0, 0.0]),
            PI / 3.0,
            8.0,
            0,
        ),
        (
            "paraboloid",
            Solid::paraboloid([1.0, 1.0]) & Solid::cuboid([4.0, 4.0, 2.0]),
            PI / 2.0,
            12.0,
            0,
        ),
        // The wall touches the waist, and cuts it in two lines that cross there.
        (
            "hyperboloid by a wall",
            Solid::hyperboloid_one_sheet([1.0, 1.0, 1.0])
                & Solid::cuboid([6.0, 6.0, 2.0])
                & Solid::cuboid([6.0, 6.0, 6.0]).translate([-2.0, 0.0, 0.0]),
            integral(-1.0..1.0, |z| {
                let square = 1.0 + z * z;
                square * (PI - square.sqrt().recip().acos()) + z.abs()
            }),
            27.0,
            0,
        ),
        // The cone's tip is on the ball, whose points are at 2 cos of the angle at
        // which they are seen from there.
        (
            "ball and a cone from its pole",
            ball()
                & Solid::infinite_cone(0.5)
                    .rotate_xyz(PI, 0.0, 0.0)
                    .translate([0.0, 0.0, 1.0]),
            4.0 / 3.0 * PI * (1.0 - 0.5f64.cos().powi(4)),
            9.0,
            0,
        ),
        // Viviani's curve passes through itself where the two touch.
        (
            "Viviani",
            ball() & Solid::cylinder(0.5, -2.0..2.0).translate([0.5, 0.0, 0.0]),
            2.0 / 3.0 * PI - 8.0 / 9.0,
            9.0,
            0,
        ),
        // No cylinder or cone among them, nor a common plane.
        (
            "ball less a hyperboloid",
            ball() - Solid::hyperboloid_one_sheet([0.2, 0.5, 0.6]).rotate_xyz(0.3, 0.5, 0.7),
            // By slices, in polar coordinates.
            4.0 / 3.0 * PI
                - integral(-1.0..1.0, |z| {
                    integral(0.0..TAU, |angle| {
                        let (sin, cos) = angle.sin_cos();
                        let ellipse = (cos / 0.2).powi(2) + (sin / 0.5).powi(2);
                        0.5 * ((1.0 + (z / 0.6).powi(2)) / ellipse).min(1.0 - z * z)
                    })
                }),
            17.0,
            1,
        ),
        (
            "ball that touches a ball from within",
            ball() - Solid::sphere(0.5).translate([0.5, 0.0, 0.0]),
            4.0 / 3.0 * PI * 0.875,
            16.0,
            0,
        ),
        // Its apex is ten thousand times as far as its faces are long.
        (
            "near cylinder less a ball",
            Solid::frustum(1.0, 1.0 + 2e-4, 0.0..2.0)
                - Solid::sphere(0.5).translate([0.0, 0.0, 1.0]),
            2.0 / 3.0 * PI * (1.0 + (1.0 + 2e-4) + (1.0 + 2e-4_f64).powi(2)) - PI / 6.0,
            23.0,
            0,
        ),
        // Planes go on where cylinders end.
        (
            "slab with round ends",
            Solid::cuboid([2.0, 1.0, 1.0])
                | Solid::cylinder(0.5, -0.5..0.5).translate([1.0, 0.0, 0.0])
                | Solid::cylinder(0.5, -0.5..0.5).translate([-1.0, 0.0, 0.0])
                | Solid::sphere(0.2).translate([0.3, 0.5, 0.1]),
            2.0 + PI / 4.0 + 2.0 / 3.0 * PI * 0.008,
            13.0,
            0,
        ),
        // They touch at two poles.
        (
            "ball in an ellipsoid",
            Solid::ellipsoid([1.5, 1.2, 1.0]) - ball(),
            4.0 / 3.0 * PI * 0.8,
            33.0,
            0,
        ),
        // They cross in two circles, which cross at the poles.
        (
            "ball and an ellipsoid",
            ball() & Solid::ellipsoid([1.2, 1.0, 0.8]),
            2.0 / 3.0
                * integral(0.0..TAU, |angle| {
                    let (sin, cos) = angle.sin_cos();
                    let ellipse = (cos / 1.2).powi(2) + (sin / 0.8).powi(2);
                    ellipse.max(1.0).recip()
                }),
            13.0,
            0,
        ),
        (
            "cones of one tip",
            Solid::cone(1.0, 0.0..2.0) - Solid::cone(0.5, 0.0..2.0),
            PI / 2.0,
            13.0,
            0,
        ),
        // The tip touches the middle of a face.
        (
            "cone under a plate",
            Solid::cone(1.0, 0.0..2.0) | Solid::cuboid_between([-1.5, -1.0, 2.0], [1.5, 2.0, 2.5]),
            PI * 2.0 / 3.0 + 4.5,
            35.0,
            0,
        ),
        // The ball touches the rod all around.
        (
            "ball joint",
            Solid::cylinder(0.5, -1.0..0.0) | Solid::sphere(0.5),
            PI * 0.25 + 2.0 / 3.0 * PI * 0.125,
            7.0,
            0,
        ),
    ]
}

#[test]
fn known_solids_need_no_cells() {
    for (name, solid, volume, area, holes) in solids() {
        for solid in [turned(&solid), solid] {
            let (program, meshed) = mesh(&solid);
            let report = &meshed.report;
            assert_eq!(report.method, "boundary", "{name}");
            assert_eq!(report.fallbacks, [], "{name}");
            assert!(report.check.is_manifold(), "{name}: {}", report.check);
            assert_eq!(genus(&meshed), holes, "{name}");
            let off = (meshed.mesh.volume() - volume).abs();
            assert!(off < TOLERANCE * area, "{name}: {off}");
            let bound = report.deviation.expect("a bound");
            assert!(bound <= TOLERANCE, "{name}: {bound}");
            assert!(
                sampled_deviation(&program, &meshed) <= bound + 1e-10,
                "{name}"
            );
            assert_eq!(meshed.mesh.self_intersections().len(), 0, "{name}");
        }
    }
}

/// Name, solid, volume, area at most.
fn touching() -> Vec<(&'static str, Solid, f64, f64)> {
    const ANGLE: f64 = 0.5;
    let ball = || Solid::sphere(1.0);
    let above = || Solid::half_space([0.0, 0.0, -1.0], 0.0);
    let below = |z: f64| Solid::half_space([0.0, 0.0, 1.0], z);
    let (tan, cos) = (ANGLE.tan(), ANGLE.cos());
    let height = cos.recip() + tan;
    vec![
        (
            "pipe less a ball",
            Solid::cylinder(1.0, -2.0..2.0) - ball(),
            4.0 * PI - 4.0 / 3.0 * PI,
            44.0,
        ),
        (
            "spheroid less a ball",
            Solid::ellipsoid([1.0, 1.0, 2.0]) - ball(),
            4.0 / 3.0 * PI,
            36.0,
        ),
        (
            "ball less a spheroid",
            ball() - Solid::ellipsoid([1.0, 1.0, 0.5]),
            2.0 / 3.0 * PI,
            23.0,
        ),
        (
            "spheroids",
            Solid::ellipsoid([1.0, 1.0, 1.5]) - Solid::ellipsoid([1.0, 1.0, 0.5]),
            4.0 / 3.0 * PI,
            28.0,
        ),
        (
            "ellipsoids",
            Solid::ellipsoid([1.0, 0.7, 1.5]) - Solid::ellipsoid([1.0, 0.7, 0.5]),
            4.0 / 3.0 * PI * 0.7,
            24.0,
        ),
        (
            "cone less a ball",
            (Solid::infinite_cone(ANGLE) & above() & below(2.0))
                - Solid::sphere(ANGLE.sin()).translate([0.0, 0.0, 1.0]),
            8.0 / 3.0 * PI * tan * tan - 4.0 / 3.0 * PI * ANGLE.sin().powi(3),
            15.0,
        ),
        // There the solid goes on smoothly.
        (
            "egg",
            (Solid::ellipsoid([1.0, 1.0, 1.5]) & above()) | (ball() & below(0.0)),
            2.0 / 3.0 * PI * 2.5,
            16.0,
        ),
        (
            "ball under a cone",
            Solid::cone(1.0, 0.0..tan.recip())
                | Solid::sphere(cos.recip()).translate([0.0, 0.0, -tan]),
            PI / 3.0 / tan + PI * height * height * (cos.recip() - height / 3.0),
            21.0,
        ),
        (
            "cylinder in a ring with a sharp rim",
            Solid::cylinder(1.0, -1.0..2.0)
                | (Solid::cylinder(2.0, 0.0..1.0) - Solid::frustum(1.0, 1.5, 0.0..1.0)),
            PI * (3.0 + 4.0 - 19.0 / 12.0),
            80.0,
        ),
        (
            "ball less a cube in it",
            ball() - Solid::cuboid([2.0 / 3f64.sqrt(); 3]),
            4.0 / 3.0 * PI - 8.0 / 27f64.sqrt(),
            21.0,
        ),
        (
            "ball less a cone in it",
            ball() - Solid::cone(0.5, 0.0..1.0),
            4.0 / 3.0 * PI - PI / 12.0,
            16.0,
        ),
    ]
}

#[test]
fn faces_may_touch_along_conics_and_in_points() {
    for (name, solid, volume, area) in touching() {
        for (solid, tolerance) in [turned(&solid), solid]
            .iter()
            .flat_map(|solid| [0.1, 0.03, 0.01, 0.003].map(|tolerance| (solid, tolerance)))
            .step_by(one_in(3))
        {
            let program = Program::lower(solid).expect("a valid solid");
            let meshed = Mesher::new().tolerance(tolerance).mesh(&program);
            let Meshed { mesh, report, .. } = meshed.expect("a mesh");
            let name = format!("{name} to {tolerance}");
            assert_eq!(report.method, "boundary", "{name}");
            assert_eq!(report.fallbacks, [], "{name}");
            assert!(report.check.is_manifold(), "{name}: {}", report.check);
            let off = (mesh.volume() - volume).abs();
            assert!(off < tolerance * area, "{name}: {off}");
            let bound = report.deviation.expect("a bound");
            assert!(bound <= tolerance, "{name}: {bound}");
            assert_eq!(mesh.self_intersections(), [[0; 2]; 0], "{name}");
            let defects = measure(&program, &mesh);
            assert_eq!(defects.folded, 0, "{name}: {:?}", defects.places);
        }
    }
}

#[test]
fn one_and_eight_threads_give_the_same_mesh() {
    let balls = scenes::cheese(100);
    let of = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads").install(|| mesh(&balls).1)
    };
    let (one, eight) = (of(1), of(8));
    assert_eq!(one.report.method, "boundary");
    assert!(one.mesh == eight.mesh);
}

/// Of any number of primitives of any kind, size and place.
fn in_general_position(random: &mut Random) -> Solid {
    let primitive = |random: &mut Random| {
        let [a, b, c] = [(); 3].map(|()| random.between(0.2, 1.0));
        let solid = match random.below(6) {
            0 => Solid::cuboid([2.0 * a, 2.0 * b, 2.0 * c]),
            1 => Solid::sphere(a),
            2 => Solid::ellipsoid([a, b, c]),
            3 => Solid::cylinder(a, -b..c),
            4 => Solid::cone(a, -b..c),
            _ => Solid::elliptic_cylinder([a, b], -c..c),
        };
        let [x, y, z] = [(); 3].map(|()| random.between(0.0, TAU));
        let place = [(); 3].map(|()| random.between(-0.7, 0.7));
        solid.rotate_xyz(x, y, z).translate(place)
    };
    let mut solid = primitive(random);
    for _ in 0..random.below(16) {
        let other = primitive(random);
        solid = match random.below(5) {
            0 | 1 => solid | other,
            2 | 3 => solid - other,
            _ => solid & (other | primitive(random)),
        };
    }
    solid
}

/// Meshes solids, of which nothing must be reported nor wrong, and counts their
/// triangles.
fn assert_promises_are_kept(solids: u64, solid: impl Fn(&mut Random) -> Solid) -> usize {
    let mut triangles = 0;
    for seed in 0..solids {
        let program = Program::lower(&solid(&mut Random::new(seed))).expect("valid");
        let meshed = Mesher::new().tolerance(0.01).mesh(&program);
        let Meshed { mesh, report, .. } = meshed.expect("a mesh");
        assert_eq!(report.fallbacks, [], "seed {seed}");
        assert!(report.check.is_manifold(), "seed {seed}: {}", report.check);
        assert_eq!(mesh.self_intersections(), [[0; 2]; 0], "seed {seed}");
        assert!(report.deviation.is_none_or(|d| d <= 0.01), "seed {seed}");
        let defects = measure(&program, &mesh);
        assert_eq!(defects.folded, 0, "seed {seed}: {:?}", defects.places);
        triangles += mesh.triangles.len();
    }
    triangles
}

#[test]
fn promises_are_kept_in_general_position() {
    let solids = 80 / one_in(4);
    let triangles = assert_promises_are_kept(solids as u64, in_general_position);
    // Otherwise little was tried.
    assert!(triangles > 200 * solids, "{triangles}");
}

/// Its cylinder touches its planes, and so do the curves in which balls meet it.
#[test]
fn curves_may_touch_planes_anywhere() {
    let triangles = assert_promises_are_kept(60, |random| {
        let corners = Solid::cube(2.0) - Solid::cylinder(1.0, -2.0..2.0);
        let ball = Solid::sphere(random.between(0.8, 1.3));
        let place = [(); 3].map(|()| random.between(0.0, 0.6));
        let [x, y, z] = [(); 3].map(|()| random.between(0.0, TAU));
        (corners & ball.translate(place)).rotate_xyz(x, y, z)
    });
    assert!(triangles > 60 * 60, "{triangles}");
}

/// The edges, one way, at which triangles of different colours meet.
fn borders(mesh: &Mesh) -> Vec<[DVec3; 2]> {
    let mut color_of = HashMap::new();
    for (triangle, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        let color = mesh.surface_of(triangle).and_then(|s| s.color);
        color_of.extend([[a, b], [b, c], [c, a]].map(|edge| (edge, color)));
    }
    let color = |edge: [u32; 2]| color_of.get(&edge).copied().flatten();
    let edges = color_of.keys().copied().filter(|&[a, b]| a < b);
    let on_borders = edges.filter(|&[a, b]| color([a, b]) != color([b, a]));
    on_borders
        .map(|edge| edge.map(|vertex| mesh.positions[vertex as usize]))
        .collect()
}

fn red_and_blue() -> [Color; 2] {
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]].map(Color::from_linear)
}

/// It is no face of two corners without width, and its edges are not straight.
#[test]
fn a_narrow_patch_of_another_colour_keeps_to_its_curves() {
    let [red, blue] = red_and_blue();
    let ball = || Solid::sphere(1.0);
    for width in [2e-2, 2e-3, 2e-4, 2e-5] {
        let rod = |x: f64| Solid::cylinder(0.3, 0.0..2.0).translate([x, 0.2, 0.0]);
        let off = 0.3 - 0.5 * width;
        let lens = rod(0.1 - off) & rod(0.1 + off);
        let solid = (ball().colored(red) - &lens) | (ball().colored(blue) & lens);
        for solid in [turned(&solid), solid] {
            let program = Program::lower(&solid).expect("a valid solid");
            let meshed = Mesher::new().tolerance(0.1).mesh(&program);
            let Meshed { mesh, report, .. } = meshed.expect("a mesh");
            assert_eq!(report.fallbacks, [], "{width}");
            let is_on = |s: &Surface, p: DVec3| s.value(p).abs() < 1e-12 * s.gradient(p).length();
            let count = |p: DVec3| program.surfaces().iter().filter(|s| is_on(s, p)).count();
            let borders = borders(&mesh);
            assert!(borders.len() >= 3, "{width}: {}", borders.len());
            // On the ball and a rod.
            let mut points = borders.into_iter().flatten();
            assert!(points.all(|p| count(p) >= 2), "{width}");
        }
    }
}

/// Name, what is blue on a body, that body, and the border between the two by angle.
#[allow(clippy::type_complexity)]
fn painted() -> Vec<(&'static str, Solid, Solid, Box<dyn Fn(f64) -> DVec3>)> {
    let around = |angle: f64, z: f64| DVec3::new(angle.cos(), angle.sin(), z);
    let rod = || Solid::cylinder(1.0, -2.0..2.0);
    let slanted = Solid::half_space([-0.6, 0.2, 1.0], 0.0);
    // Off the axis.
    let ball = Solid::sphere(1.6).translate([0.3, 0.0, 0.0]);
    let across = Solid::cylinder(1.3, -3.0..3.0).rotate_x(0.5 * PI);
    let inlay = Solid::cylinder(1.0, 0.0..3.0);
    let slanted_at = move |angle: f64| around(angle, 0.6 * angle.cos() - 0.2 * angle.sin());
    let ball_at = move |angle: f64| {
        let [x, y] = [angle.cos() - 0.3, angle.sin()];
        around(angle, (1.6 * 1.6 - x * x - y * y).sqrt())
    };
    let across_at = move |angle: f64| around(angle, (1.3 * 1.3 - angle.cos().powi(2)).sqrt());
    let above = Solid::half_space([0.0, 0.0, -1.0], 0.0);
    vec![
        ("slanted plane", slanted, rod(), Box::new(slanted_at)),
        ("ball", ball | !&above, rod(), Box::new(ball_at)),
        ("cylinder", across | !above, rod(), Box::new(across_at)),
        (
            "inlay",
            inlay.clone(),
            Solid::cube(4.0),
            Box::new(move |angle| around(angle, 2.0)),
        ),
        (
            "pole",
            inlay,
            Solid::sphere(2.0),
            Box::new(move |angle| around(angle, 3.0f64.sqrt())),
        ),
    ]
}

/// How far an arc between two angles is from its chord.
fn sag(at: &dyn Fn(f64) -> DVec3, from: f64, to: f64) -> f64 {
    const STEPS: u32 = 64;
    let [p, q] = [from, to].map(at);
    let along = (q - p).normalize();
    let share = |k: u32| f64::from(k) / f64::from(STEPS);
    let points = (1..STEPS).map(|k| at(from + share(k) * (to - from)));
    points
        .map(|x| (x - p).cross(along).length())
        .fold(0.0, f64::max)
}

/// Where colours change within one surface there is a curve like any other.
#[test]
fn borders_between_colours_are_as_near_to_their_curves_as_any_edge() {
    let [red, blue] = red_and_blue();
    for (name, part, body, at) in painted() {
        let solid = (&body - &part).colored(red) | (&body & &part).colored(blue);
        let program = Program::lower(&solid).expect("a valid solid");
        for tolerance in [1e-2, 1e-3, 1e-4] {
            let meshed = Mesher::new().tolerance(tolerance).mesh(&program);
            let Meshed { mesh, report, .. } = meshed.expect("a mesh");
            assert_eq!(report.fallbacks, [], "{name}");
            assert!(report.check.is_manifold(), "{name}: {}", report.check);
            assert!(report.deviation.is_some_and(|d| d <= tolerance), "{name}");
            let borders = borders(&mesh);
            let mut turned = 0.0;
            let mut sags = Vec::new();
            for edge in &borders {
                let [from, mut to] = edge.map(|p| p.y.atan2(p.x));
                to -= TAU * ((to - from) / TAU).round();
                for (p, angle) in edge.iter().zip([from, to]) {
                    assert!(p.distance(at(angle)) < 1e-11, "{name}: {p}");
                }
                turned += (to - from).abs();
                sags.push(sag(&at, from, to));
            }
            // All around, and once.
            assert!((turned - TAU).abs() < 1e-9, "{name}: {turned}");
            let farthest = sags.iter().copied().fold(0.0, f64::max);
            assert!(farthest <= tolerance, "{name}: {farthest}");
            // Evenly, and as few as will do.
            let nearest = sags.iter().copied().fold(f64::INFINITY, f64::min);
            assert!(nearest >= 0.5 * farthest, "{name}: {nearest} {farthest}");
            assert!(farthest >= 0.5 * tolerance, "{name}: {farthest}");
        }
    }
}

/// Gears of so many corners that they are taken for polyhedra, bored, hubbed and stacked: what
/// ends in the planes of their faces shares these, and their edges begin on them.
#[test]
fn polyhedra_are_proven_with_curved_parts_that_end_in_their_planes() {
    let gear = |teeth: u32, tip: f64, z: Range<f64>| {
        let corners = (0..2 * teeth).map(|k| {
            let angle = PI * f64::from(k) / f64::from(teeth);
            let radius = if k % 2 == 0 { tip } else { 5.0 };
            // As a file has them.
            let digits = |x: f64| (1e4 * x).round() / 1e4;
            [digits(radius * angle.cos()), digits(radius * angle.sin())]
        });
        Solid::extrude(&Profile::polygon(corners), z)
    };
    for teeth in [25, 30, 64] {
        let plain = gear(teeth, 6.0, 0.0..4.0);
        let stacked = gear(teeth, 6.0, 0.0..2.0) | gear(teeth, 6.0, 2.0..4.0);
        let smaller = gear(teeth, 6.0, 0.0..2.0) | gear(teeth, 5.5, 2.0..4.0);
        let cases = [
            ("bored", plain.clone() - Solid::cylinder(2.0, 0.0..4.0)),
            (
                "countersunk",
                plain.clone() - Solid::frustum(1.0, 2.0, 0.0..4.0),
            ),
            ("hubbed", plain | Solid::cylinder(3.0, 0.0..7.0)),
            (
                "stacked on a pin",
                stacked | Solid::cylinder(1.0, -1.0..6.0),
            ),
            ("stepped on a pin", smaller | Solid::cylinder(1.0, 0.0..4.0)),
        ];
        for (name, solid) in cases {
            for turn in [0.0, 0.5, 1.3] {
                let turned = solid.rotate_x(turn).rotate_z(0.5 * turn);
                let program = Program::lower(&turned).expect("a valid solid");
                let meshed = Mesher::new().tolerance(0.01).mesh(&program);
                let report = meshed.expect("a mesh").report;
                assert!(
                    report.is_proven(),
                    "{teeth} teeth, {name}, {turn}: {report:?}"
                );
                assert_eq!(report.undecided, [], "{teeth} teeth, {name}, {turn}");
            }
        }
    }
}
