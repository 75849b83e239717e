//! Polyhedra from faces, hulls from points: volumes against what the faces
//! themselves enclose, membership against brute force, mistakes by name.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::random::Random;
use crate::sweeps::one_in;
use csg::glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, EulerRot, dvec3};
use csg::{
    BoundaryOptions, Error, Mesh, Mesher, NodeFault, PolyhedronFault, Profile, Program, Solid,
    Twist, turn,
};

fn meshed(what: &str, solid: &Solid) -> Mesh {
    let program = Program::lower(solid).unwrap_or_else(|e| panic!("{what}: {e}"));
    let meshed = Mesher::new().mesh(&program);
    let meshed = meshed.unwrap_or_else(|e| panic!("{what}: {e}"));
    assert_eq!(meshed.report.method, "polyhedral", "{what}");
    assert_eq!(meshed.report.fallbacks, [], "{what}");
    assert!(meshed.report.check.is_manifold(), "{what}");
    assert_eq!(meshed.mesh.self_intersections().len(), 0, "{what}");
    meshed.mesh
}

fn assert_volume(what: &str, solid: &Solid, volume: f64) {
    let found = meshed(what, solid).volume();
    assert!(
        (found - volume).abs() <= 1e-11 * volume,
        "{what}: {found}, not {volume}"
    );
}

/// The regular polygon with a corner on the x axis, turned.
fn regular(corners: u32, radius: f64, turn: f64) -> impl Iterator<Item = DVec2> {
    let corner = move |k| turn + TAU * f64::from(k) / f64::from(corners);
    (0..corners).map(move |k| radius * DVec2::from_angle(corner(k)))
}

/// Prisms over polygons in one circle, of which each corner of the one is one of the other's, with a hole
/// of many sides: of some the lines between two sides are those of two sides of the other.
#[test]
fn prisms_that_share_corners_are_exact() {
    let mut random = Random(11);
    let mut number =
        |least: u32, most: u32| least + (random.unit() * f64::from(most - least + 1)) as u32;
    for case in 0..60 {
        let (plate, times, hole) = (number(5, 20), number(2, 6), number(3, 60));
        let turn = f64::from(number(0, 3)) * 0.1;
        let radius = 3.2 - 0.1 * f64::from(number(0, 10));
        let base = f64::from(number(0, 2));
        let post = Solid::prism(regular(plate * times, 4.0, turn), 0.0..7.0);
        let post = post - Solid::prism(regular(hole, radius, 0.2 + turn), -1.0..8.0);
        let solid = post | Solid::prism(regular(plate, 4.0, turn), base..base + 1.0);
        let area = |corners: u32, radius: f64| {
            0.5 * f64::from(corners) * radius * radius * (TAU / f64::from(corners)).sin()
        };
        let volume = 7.0 * area(plate * times, 4.0) - 6.0 * area(hole, radius);
        let what = format!("{case}: {plate} by {times}, {hole} of {radius}");
        assert_volume(&what, &solid, volume);
        let moved = solid.translate([25.0, 0.0, 46.5]).rotate_x(0.3);
        assert_volume(&what, &moved, volume);
    }
}

fn random_point(random: &mut Random) -> DVec3 {
    dvec3(random.unit(), random.unit(), random.unit()) - 0.5
}

#[test]
fn hulls_hold_their_points_and_touch_them() {
    let mut random = Random(3);
    for count in [4, 5, 8, 20, 100] {
        for _ in 0..4 {
            let points: Vec<DVec3> = (0..count).map(|_| random_point(&mut random)).collect();
            let mesh = meshed("a hull", &Solid::hull(points.clone()));
            // Its corners are points given, and all points are within.
            for corner in &mesh.positions {
                let nearest = points
                    .iter()
                    .map(|p| p.distance(*corner))
                    .fold(1.0, f64::min);
                assert!(nearest < 1e-9, "{nearest:e}");
            }
            for index in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.corners(index);
                let normal = (b - a).cross(c - a).normalize();
                assert!(points.iter().all(|p| normal.dot(*p - a) < 1e-9));
            }
        }
    }
}

/// Sums of a box's corners and a faceted ball's, thousands of which are on flat sides but for
/// rounding: a polynomial in the box's sides (Steiner; Minkowski, *Volumen und Oberfläche*, 1903).
#[test]
fn hulls_of_sums_have_the_mixed_volumes() {
    for (count, sides) in [
        (14, dvec3(3.0, 1.0, 2.0)),
        (72, DVec3::splat(10.0)),
        (100, dvec3(10.0, 8.0, 6.0)),
        (128, DVec3::splat(10.0)),
    ] {
        let rings = count / 2;
        let ring = |ring: usize| {
            let polar = turn(2 * ring + 1, 4 * rings);
            (0..count).map(move |k| (polar.y * turn(k, count)).extend(polar.x))
        };
        let ball: Vec<DVec3> = (0..rings).flat_map(ring).collect();
        let corner =
            |k: usize| DVec3::select([1, 2, 4].map(|bit| k & bit != 0).into(), sides, DVec3::ZERO);
        let sums = (0..8).flat_map(|k| ball.iter().map(move |&p| p + corner(k)));
        let alone = meshed("a ball", &Solid::hull(ball.clone()));
        let doubled = (0..alone.triangles.len()).map(|index| {
            let [a, b, c] = alone.corners(index);
            (b - a).cross(c - a).max(DVec3::ZERO)
        });
        let shadows = 0.5 * doubled.sum::<DVec3>();
        let (low, high) = alone.bounds().expect("a ball");
        let across = dvec3(sides.y * sides.z, sides.z * sides.x, sides.x * sides.y);
        let volume =
            alone.volume() + sides.dot(shadows) + across.dot(high - low) + sides.element_product();
        assert_volume(&format!("{count}"), &Solid::hull(sums), volume);
    }
}

/// Flat sides with many points on them, some inside, all moved and rounded.
#[test]
fn hulls_of_regular_points_have_few_faces() {
    let grid = |n: u32| {
        let at = move |k: u32| f64::from(k) / f64::from(n - 1);
        (0..n * n * n).map(move |k| dvec3(at(k % n), at(k / n % n), at(k / n / n)))
    };
    let turned = DAffine3::from_axis_angle(dvec3(1.0, 2.0, 3.0).normalize(), 0.7);
    for n in [2, 3, 6] {
        let solid = Solid::hull(grid(n).map(|p| turned.transform_point3(p) + 0.3));
        let program = Program::lower(&solid).expect("a program");
        assert_eq!(program.surfaces().len(), 6);
        assert_volume("a cube", &solid, 1.0);
    }
    let rings = |z: f64, n: usize| (0..n).map(move |k| turn(k, n).extend(z));
    for n in [3, 7, 30, 64] {
        let solid = Solid::hull(rings(0.0, n).chain(rings(2.0, n)));
        assert_eq!(meshed("a prism", &solid).surfaces.len(), n + 2);
        assert_volume("a prism", &solid, n as f64 * turn(1, n).y);
    }
    for flat in [
        vec![],
        vec![DVec3::ZERO; 5],
        grid(3).map(|p| p * dvec3(1.0, 1.0, 0.0)).collect(),
    ] {
        let error = Program::lower(&Solid::hull(flat)).expect_err("no volume");
        assert!(
            matches!(
                error,
                Error::InvalidNode {
                    fault: NodeFault::Flat,
                    ..
                }
            ),
            "{error}"
        );
    }
}

/// The faces of a prism over a polygon.
fn prism(polygon: &[DVec2], height: f64) -> (Vec<DVec3>, Vec<Vec<u32>>) {
    let n = polygon.len() as u32;
    let at = |z: f64| polygon.iter().map(move |p| p.extend(z));
    let vertices = at(0.0).chain(at(height)).collect();
    let mut faces = vec![(0..n).rev().collect(), (n..2 * n).collect::<Vec<u32>>()];
    for k in 0..n {
        let next = (k + 1) % n;
        faces.push(vec![k, next, n + next, n + k]);
    }
    (vertices, faces)
}

#[test]
fn polyhedra_enclose_what_their_faces_do() {
    let mut random = Random(4);
    let star: Vec<DVec2> = (0..24)
        .map(|k| turn(k, 24) * if k % 2 == 0 { 1.0 } else { 0.4 })
        .collect();
    let (vertices, faces) = prism(&star, 0.5);
    let area = 12.0 * 0.4 * turn(1, 24).y;
    assert_volume("a star", &Solid::polyhedron(vertices, faces), 0.5 * area);
    // A terrain: triangles that bend every way, above a flat bottom.
    for n in [3_u32, 6] {
        let mut vertices = Vec::new();
        for height in [0.0, 1.0] {
            for k in 0..(n + 1) * (n + 1) {
                let bumps = height * (1.0 + 0.5 * random.unit());
                vertices.push(dvec3(f64::from(k % (n + 1)), f64::from(k / (n + 1)), bumps));
            }
        }
        let lift = (n + 1) * (n + 1);
        let mut faces = Vec::new();
        let index = |x: u32, y: u32| x + y * (n + 1);
        for k in 0..n * n {
            let (x, y) = (k % n, k / n);
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| index(x + i, y + j));
            faces.push([a + lift, b + lift, c + lift]);
            faces.push([a + lift, c + lift, d + lift]);
            faces.push([c, b, a]);
            faces.push([d, c, a]);
        }
        for k in 0..n {
            for (from, to) in [
                (index(k, 0), index(k + 1, 0)),
                (index(n, k), index(n, k + 1)),
                (index(k + 1, n), index(k, n)),
                (index(0, k + 1), index(0, k)),
            ] {
                faces.push([from, to, to + lift]);
                faces.push([from, to + lift, from + lift]);
            }
        }
        let volume = Mesh::new(vertices.clone(), faces.clone()).volume();
        assert_volume("a terrain", &Solid::polyhedron(vertices, faces), volume);
    }
}

#[test]
fn convex_parts_make_up_the_whole() {
    let corners = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]].map(DVec2::from);
    let (vertices, faces) = prism(&corners, 1.0);
    let mesh = meshed("an l", &Solid::polyhedron(vertices, faces));
    let parts = Solid::convex_parts(&mesh).expect("parts");
    assert_eq!(parts.len(), 2);
    let volume: f64 = parts
        .into_iter()
        .map(|planes| meshed("a part", &Solid::convex_polyhedron(planes)).volume())
        .sum();
    assert!((volume - 3.0).abs() < 1e-12);
}

#[test]
fn twisted_extrusions_enclose_what_their_triangles_do() {
    let square = Profile::rectangle([2.0, 1.0]);
    // Between levels turned by a the sections of ruled sides would shrink to
    // (2 + cos a) / 3 of their area in the mean; the shorter diagonal of a side
    // of length l adds half of the tetrahedron l² sin a / 6 per height.
    let plain = Twist {
        radians: 0.0,
        scale: DVec2::ONE,
        steps: 3,
    };
    assert_volume(
        "plain",
        &Solid::extrude_in_steps(&square, 0.0..2.0, plain),
        4.0,
    );
    let narrow = Twist {
        radians: 0.0,
        scale: DVec2::new(0.5, 0.0),
        steps: 1,
    };
    assert_volume(
        "roof",
        &Solid::extrude_in_steps(&square, 0.0..2.0, narrow),
        2.0 * 2.0 * 2.5 / 6.0,
    );
    for (radians, steps) in [(FRAC_PI_2, 6), (-1.0, 4), (TAU, 24)] {
        let twist = Twist {
            radians,
            scale: DVec2::ONE,
            steps,
        };
        let frame = &square - Profile::rectangle([0.5, 0.5]);
        // Sides of both, squared.
        for (what, profile, area, squares) in
            [("bar", &square, 2.0, 10.0), ("pipe", &frame, 1.75, 9.0)]
        {
            let mesh = meshed(what, &Solid::extrude_in_steps(profile, 0.0..2.0, twist));
            let (sin, cos) = (radians.abs() / steps as f64).sin_cos();
            let volume = 2.0 * (area * (2.0 + cos) / 3.0 + squares * sin / 12.0);
            let off = (mesh.volume() / volume - 1.0).abs();
            assert!(
                off < 1e-11,
                "{what} {steps}: {}, not {volume}",
                mesh.volume()
            );
        }
    }
}

/// Points beside the boundary of the profile at their height, turned and scaled back.
#[test]
fn even_twists_are_as_near_as_they_say() {
    let mut random = Random(11);
    let bar = Profile::rectangle([3.0, 2.0]);
    let pipe = &bar - Profile::circle(0.75).translate([0.25, 0.0]);
    for (profile, radians, scale) in [
        (&bar, FRAC_PI_2, [1.0, 1.0]),
        (&bar, -0.5, [0.5, 1.5]),
        (&pipe, 0.75, [1.0, 1.0]),
        (&pipe, 0.0, [0.5, 1.0]),
    ] {
        let what = format!("{radians} {scale:?}");
        let near = Solid::twist_accuracy(profile, radians, scale, None).expect("valid");
        assert!(near.faces <= 50_000 && near.deviation <= 1e-3, "{near:?}");
        let solid = Solid::extrude_twisted(profile, 0.0..4.0, radians, scale);
        let program = Program::lower(&solid).expect("valid");
        let fine = profile.contours(1e-6).expect("valid");
        let inside = |p: DVec2| {
            let sides = fine.iter().flat_map(|contour| {
                let next = contour.iter().cycle().skip(1);
                contour.iter().zip(next)
            });
            let crossed = sides.filter(|(a, b)| {
                (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
            });
            crossed.count() % 2 == 1
        };
        let corners: Vec<DVec2> = fine.iter().flatten().copied().collect();
        for _ in 0..500 {
            let share = random.unit();
            let at = corners[random.below(corners.len())];
            let factor = DVec2::ONE + (DVec2::from(scale) - 1.0) * share;
            let turn = DVec2::from_angle(radians * share);
            // Across a straight side, or about a corner, or across an arc.
            let next = corners[random.below(corners.len())];
            let on = if random.below(2) == 0 {
                at
            } else {
                at.lerp(next, random.unit())
            };
            let off = near.deviation * DVec2::from_angle(TAU * random.unit());
            let place = |p: DVec2| factor * turn.rotate(p);
            let point = place(on) + 1.01 * off;
            let back = |p: DVec2| DVec2::new(turn.x, -turn.y).rotate(p / factor);
            // If all around it as far as the deviation is on one side.
            let around = (0..16).map(|k| {
                let step = 1.05 * near.deviation * DVec2::from_angle(TAU * f64::from(k) / 16.0);
                inside(back(point + step))
            });
            let around: Vec<bool> = around.collect();
            if around.iter().all(|&side| side == around[0]) {
                let point = point.extend(4.0 * share);
                assert_eq!(program.contains(point), around[0], "{what}: {point}");
            }
        }
        if scale == [1.0, 1.0] {
            let mesh = meshed(&what, &solid);
            let volume = 4.0 * profile.area(1e-9).expect("valid");
            let off = (mesh.volume() - volume).abs();
            assert!(off <= 0.5 * near.deviation * mesh.area(), "{what}: {off}");
        }
    }
    let many = Solid::twist_accuracy(&bar, 100.0, [1.0, 1.0], None).expect("valid");
    assert!(many.faces <= 200_000 && many.deviation > 1e-3, "{many:?}");
    for (radians, what) in [(1e300, "too few"), (f64::NAN, "not finite")] {
        assert!(
            Solid::twist_accuracy(&bar, radians, [1.0, 1.0], None).is_err(),
            "{what}"
        );
    }
}

#[test]
fn mistakes_are_named() {
    let corners = [[0., 0.], [1., 0.], [0., 1.]].map(DVec2::from);
    let (vertices, faces) = prism(&corners, 1.0);
    let fault = |vertices: &[DVec3], faces: &[Vec<u32>]| {
        let solid = Solid::polyhedron(vertices.iter().copied(), faces.iter().cloned());
        match Program::lower(&solid) {
            Err(Error::InvalidNode {
                fault: NodeFault::Polyhedron(fault),
                ..
            }) => *fault,
            other => panic!("{other:?}"),
        }
    };
    let open = fault(&vertices, &faces[1..]);
    assert!(matches!(open, PolyhedronFault::Open { .. }), "{open}");
    let turned: Vec<Vec<u32>> = faces
        .iter()
        .map(|f| f.iter().rev().copied().collect())
        .collect();
    assert_eq!(fault(&vertices, &turned), PolyhedronFault::InsideOut);
    let mut mixed = faces.clone();
    mixed[3].reverse();
    assert!(matches!(
        fault(&vertices, &mixed),
        PolyhedronFault::Open { .. }
    ));
    let mut beyond = faces.clone();
    beyond[2][0] = 77;
    assert!(matches!(
        fault(&vertices, &beyond),
        PolyhedronFault::NoSuchVertex {
            face: 2,
            vertex: 77,
            vertices: 6
        }
    ));
    let mut infinite = vertices.clone();
    infinite[4].y = f64::INFINITY;
    assert_eq!(
        fault(&infinite, &faces),
        PolyhedronFault::NotFinite { vertex: 4 }
    );
    assert_eq!(fault(&vertices, &[]), PolyhedronFault::Degenerate);
    // Two prisms through each other.
    let both: Vec<DVec3> = vertices
        .iter()
        .copied()
        .chain(vertices.iter().map(|v| *v + 0.1))
        .collect();
    let twice: Vec<Vec<u32>> = faces
        .iter()
        .cloned()
        .chain(faces.iter().map(|f| f.iter().map(|i| i + 6).collect()))
        .collect();
    assert!(matches!(
        fault(&both, &twice),
        PolyhedronFault::Crossing { .. }
    ));
}

/// Held against the hull of thousands of points on the balls, which is within, by less than these are
/// apart; two balls against the closed form.
#[test]
fn hulls_of_unequal_balls_are_round() {
    let mut random = Random(11);
    let exact = |balls: &[(DVec3, f64)]| {
        let solid = Solid::hull_of_unequal_balls(balls).expect("a solid");
        let program = Program::lower(&solid).expect("a program");
        let meshed = Mesher::new()
            .tolerance(0.01)
            .mesh(&program)
            .expect("a mesh");
        assert_eq!(meshed.report.fallbacks, [], "{balls:?}");
        assert_eq!(meshed.mesh.components().count, 1, "{balls:?}");
        assert_eq!(meshed.mesh.check().euler_characteristic(), 2, "{balls:?}");
        let boundary = program
            .boundary(&BoundaryOptions::new())
            .expect("a boundary");
        boundary.measure().volume.value
    };
    let [r, s, height]: [f64; 3] = [3.0, 1.0, 2.5];
    let sine = (r - s) / height;
    let cosine = (1.0 - sine * sine).sqrt();
    let below = |r: f64, z: f64| PI * (2.0 * r.powi(3) / 3.0 + r * r * z - z.powi(3) / 3.0);
    let radii = [r * cosine, s * cosine];
    let squares = radii[0] * radii[0] + radii[0] * radii[1] + radii[1] * radii[1];
    let cone = PI / 3.0 * (height + (s - r) * sine) * squares;
    let volume = below(r, r * sine) + cone + below(s, -s * sine);
    let direction = dvec3(2.0, -1.0, 2.0) / 3.0;
    let place = dvec3(0.3, 5.0, -2.0);
    let found = exact(&[
        (place + height * direction, s),
        (place, r),
        (place + 0.1, 0.5),
    ]);
    assert!((found - volume).abs() <= 1e-11 * volume, "{found} {volume}");
    for case in (0..40).step_by(one_in(3)) {
        let count = 2 + case % 5;
        let mut balls: Vec<(DVec3, f64)> = (0..count)
            .map(|_| (3.0 * random_point(&mut random), 0.1 + random.unit()))
            .collect();
        match case / 5 % 4 {
            // In one plane; in line; of few radii.
            1 => balls.iter_mut().for_each(|ball| ball.0.z = 0.25),
            2 => balls
                .iter_mut()
                .for_each(|ball| ball.0 = dvec3(ball.0.x, 1.0, 0.0)),
            3 => balls.iter_mut().for_each(|ball| {
                ball.0 = (2.0 * ball.0).round();
                ball.1 = (2.0 * ball.1).ceil();
            }),
            _ => {}
        }
        let points = 400;
        let golden = PI * (3.0 - 5.0_f64.sqrt());
        let on_balls = balls.iter().flat_map(|&(center, radius)| {
            (0..points).map(move |k| {
                let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(points);
                let (y, x) = (golden * f64::from(k)).sin_cos();
                let across = (1.0 - z * z).sqrt();
                center + radius * dvec3(across * x, across * y, z)
            })
        });
        let within = Program::lower(&Solid::hull(on_balls)).expect("a hull");
        let within = Mesher::new().mesh(&within).expect("a mesh").mesh;
        // No point of a ball is farther from the next of these than four times their mean distance.
        let largest = balls.iter().map(|ball| ball.1).fold(0.0, f64::max);
        let angle = 4.0 * (1.0 / f64::from(points)).sqrt();
        let gap = largest * (1.0 - angle.cos()) * 1.1 * within.area();
        let found = exact(&balls);
        let off = found - within.volume();
        assert!((-1e-9..gap).contains(&off), "{case}: {off} {gap} {balls:?}");
    }
}

/// Steiner's formula: volume, area, edges by their angles, a ball.
#[test]
fn hulls_of_balls_are_rounded() {
    let r: f64 = 0.25;
    let ball = 4.0 / 3.0 * PI * r.powi(3);
    let cube: Vec<DVec3> = (0..8)
        .map(|k| dvec3(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
        .collect();
    let tetrahedron =
        [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]].map(DVec3::from);
    let edge = 8.0_f64.sqrt();
    let outer = PI - (1.0_f64 / 3.0).acos();
    for (what, centers, volume) in [
        ("ball", cube[..1].to_vec(), ball),
        (
            "capsule",
            vec![cube[0], cube[7]],
            ball + PI * r * r * 3.0_f64.sqrt(),
        ),
        (
            "capsule, and more in line",
            vec![
                cube[0],
                cube[0].midpoint(cube[7]),
                cube[7],
                cube[0].lerp(cube[7], 0.25),
            ],
            ball + PI * r * r * 3.0_f64.sqrt(),
        ),
        (
            "plate",
            vec![
                cube[0],
                cube[1],
                cube[3],
                cube[2],
                cube[0].midpoint(cube[1]),
                cube[0].midpoint(cube[3]),
            ],
            2.0 * r + 2.0 * PI * r * r + ball,
        ),
        (
            "triangle",
            vec![cube[0], cube[1], cube[2]],
            r + 0.5 * PI * r * r * (2.0 + 2.0_f64.sqrt()) + ball,
        ),
        (
            "rounded box",
            cube.clone(),
            1.0 + 6.0 * r + 3.0 * PI * r * r + ball,
        ),
        (
            "tetrahedron",
            tetrahedron.to_vec(),
            edge.powi(3) / (6.0 * 2.0_f64.sqrt())
                + 3.0_f64.sqrt() * edge * edge * r
                + 6.0 * edge * 0.5 * outer * r * r
                + ball,
        ),
    ] {
        let turned = centers.iter().map(|c| DQuat::from_rotation_y(0.3) * *c);
        for centers in [centers.clone(), turned.collect()] {
            let solid = Solid::hull_of_balls(&centers, r).expect("a solid");
            let program = Program::lower(&solid).expect("a program");
            let meshed = Mesher::new()
                .tolerance(1e-3)
                .mesh(&program)
                .expect("a mesh");
            assert!(meshed.report.check.is_manifold(), "{what}");
            assert_eq!(meshed.report.fallbacks, [], "{what}");
            let off = (meshed.mesh.volume() - volume).abs();
            assert!(off <= 1e-3 * meshed.mesh.area(), "{what}: {off}");
        }
    }
}

/// Unit cubes beside each other, turned there and back by matrices of six digits: each is off by a
/// millionth, and planes that are nearly one cross anywhere. What two of them have together and in
/// common is what both have.
#[test]
fn cubes_turned_there_and_back_add_up() {
    let mut random = Random(11);
    let six_digits = |turn: DMat3| {
        DMat3::from_cols_array(&turn.to_cols_array().map(|x| (1e6 * x).round() * 1e-6))
    };
    let cube = Solid::cube(1.0).translate([0.5, 0.5, 0.5]);
    let (mut moved, cases) = (0, 60);
    for case in 0..cases {
        let mut part = || {
            let [x, y, z] = [(); 3].map(|()| 6.0 * random.unit());
            let turn = DMat3::from_euler(EulerRot::XYZ, x, y, z);
            let [there, back] = [turn, turn.transpose()].map(six_digits);
            let map = there * back;
            let at = [(); 3].map(|()| (1.5 * random.unit()).round());
            let solid = cube.affine(DAffine3::from_mat3(back));
            let solid = solid.affine(DAffine3::from_mat3(there)).translate(at);
            (solid, map.determinant())
        };
        let [(a, of_a), (b, of_b)] = [part(), part()];
        let mut volume = |solid: &Solid| {
            let program = Program::lower(solid).expect("valid");
            let brep = program.boundary(&BoundaryOptions::new());
            let brep = brep.unwrap_or_else(|e| panic!("{case}: {e}"));
            moved += usize::from(brep.moved().is_some());
            brep.measure().volume
        };
        let [both, common] = [&a | &b, &a & &b].map(|solid| volume(&solid));
        let off = (both.value + common.value - of_a - of_b).abs();
        assert!(off <= both.error + common.error + 1e-14, "{case}: {off:e}");
    }
    assert!(20 * moved <= 2 * cases, "{moved}");
}
