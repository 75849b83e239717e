//! Rays and distances against closed forms, and against membership.

use std::f64::consts::PI;

use crate::random::Random;
use csg::glam::{DVec2, DVec3, dvec2, dvec3};
use csg::{Error, Mesher, Profile, Program, RayHit, Solid};

fn lowered(solid: &Solid) -> Program {
    Program::lower(solid).unwrap_or_else(|e| panic!("{e}"))
}

fn ray(solid: &Solid, origin: [f64; 3], direction: [f64; 3]) -> Vec<RayHit> {
    let hits = lowered(solid).ray(origin, direction);
    hits.unwrap_or_else(|e| panic!("{e}"))
}

fn random_vector(random: &mut Random) -> DVec3 {
    2.0 * dvec3(random.unit(), random.unit(), random.unit()) - 1.0
}

/// A star, which is a polyhedron of many faces when extruded.
fn star(points: u32) -> Solid {
    let corner = |k: u32| {
        let angle = PI * f64::from(k) / f64::from(points);
        (1.0 + 0.5 * f64::from(k % 2)) * DVec2::from_angle(angle)
    };
    Solid::extrude(&Profile::polygon((0..2 * points).map(corner)), -0.4..0.5)
}

/// Shapes whose roots are known, hit from outside and from within.
#[test]
fn roots_are_those_of_closed_forms() {
    let places = |solid: &Solid, origin, direction| -> Vec<f64> {
        let hits = ray(solid, origin, direction);
        hits.iter().map(|hit| hit.t).collect()
    };
    let near = |found: &[f64], truth: &[f64]| {
        assert!(
            found.len() == truth.len()
                && found.iter().zip(truth).all(|(a, b)| (a - b).abs() < 1e-14),
            "{found:?}, not {truth:?}"
        );
    };
    let half = 0.5f64.sqrt();
    let ball = Solid::sphere(1.0);
    // At a height h the chord's half is the root of 1 - h².
    near(
        &places(&ball, [-3.0, 0.0, 0.6], [1.0, 0.0, 0.0]),
        &[2.2, 3.8],
    );
    near(&places(&ball, [0.0, 0.0, 0.6], [2.0, 0.0, 0.0]), &[0.4]);
    near(&places(&ball, [-3.0, 0.0, 1.1], [1.0, 0.0, 0.0]), &[]);
    near(&places(&ball, [3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), &[]);
    let bar = Solid::cylinder(1.0, -2.0..2.0);
    near(
        &places(&bar, [0.0, 0.0, -4.0], [0.0, 0.0, 0.5]),
        &[4.0, 12.0],
    );
    near(
        &places(&bar, [-2.0, -2.0, 0.0], [1.0, 1.0, 0.0]),
        &[2.0 - half, 2.0 + half],
    );
    let cone = Solid::cone(1.0, 0.0..2.0);
    near(
        &places(&cone, [-3.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        &[2.5, 3.5],
    );
    let shell = &Solid::sphere(2.0) - &ball;
    near(&places(&shell, [0.0; 3], [0.0, 3.0, 4.0]), &[0.2, 0.4]);
    let without_end = Solid::half_space([0.0, 0.0, 1.0], 0.25);
    near(
        &places(&without_end, [0.0, 0.0, 1.0], [1.0, 0.0, -1.0]),
        &[0.75],
    );
    near(&places(&!&without_end, [0.0; 3], [0.0, 0.0, 1.0]), &[0.25]);
}

#[test]
fn edges_tangents_and_starts_on_the_boundary() {
    let cube = Solid::cube(2.0).named("cube");
    // Through two opposite edges, and two opposite corners.
    for direction in [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [-0.1, 0.1, 0.1]] {
        let hits = ray(&cube, direction.map(|x: f64| -40.0 * x), direction);
        let enters: Vec<bool> = hits.iter().map(|hit| hit.enters).collect();
        assert_eq!(enters, [true, false], "{direction:?}");
    }
    // Past an edge and a corner, along a ball and a cylinder.
    assert_eq!(ray(&cube, [-1.0, -3.0, 0.0], [-1.0, 1.0, 0.0]), []);
    assert_eq!(ray(&cube, [0.0, 2.0, 0.3], [1.0, -1.0, 0.0]), []);
    for turn in 0..50 {
        let along = DVec2::from_angle(0.1 * f64::from(turn));
        let from = (along.perp() - 3.0 * along).extend(0.2);
        let bar = Solid::cylinder(1.0, -1.0..1.0);
        let hits = ray(&bar, from.into(), along.extend(0.0).into());
        // Rounding may put the line a bit within.
        let long = hits
            .last()
            .zip(hits.first())
            .map_or(0.0, |(b, a)| b.t - a.t);
        assert!(hits.len() != 1 && long < 1e-7, "{hits:?}");
    }
    let hits = ray(&cube, [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    assert_eq!((hits.len(), hits[0].t, hits[1].t), (2, 0.0, 2.0));
    // Where parts touch, or a cut ends, there is no wall.
    let pair = &cube | Solid::cube(2.0).translate([2.0, 0.0, 0.0]);
    assert_eq!(ray(&pair, [-3.0, 0.1, 0.2], [1.0, 0.0, 0.0]).len(), 2);
    let nothing = &cube - &cube;
    assert_eq!(ray(&nothing, [-3.0, 0.1, 0.2], [1.0, 0.0, 0.0]), []);
}

#[test]
fn faces_are_named_as_in_meshes() {
    let block = Solid::cuboid([4.0, 4.0, 2.0]).named("block");
    let lid = Solid::cuboid_between([-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]).named("lid");
    let bore = Solid::cylinder(0.5, -3.0..3.0)
        .named("bore")
        .translate([1.5, 0.0, 0.0]);
    let part = (&block | lid) - bore;
    let program = lowered(&part);
    let meshed = Mesher::new().mesh(&program).expect("a mesh");
    let mut random = Random(8);
    let mut coincident = 0;
    for _ in 0..300 {
        let origin = 5.0 * random_vector(&mut random);
        let direction = 1.5 * random_vector(&mut random) - origin;
        for hit in program.ray(origin, direction).expect("hits") {
            let nearest = meshed.mesh.nearest(&[hit.point]).expect("triangles")[0];
            assert!(nearest.distance < 0.01);
            // (Beside an edge the nearest triangle may be another face's.)
            let [a, b, c] = meshed.mesh.corners(nearest.triangle as usize);
            let normal = (b - a).cross(c - a).normalize();
            let is_in_lid = hit.point.truncate().abs().max_element() < 0.99;
            if normal.dot(hit.normal) > 0.9 {
                let named = meshed.mesh.surface_of(nearest.triangle as usize);
                assert_eq!(
                    Some(&hit.face.name),
                    named.map(|face| &face.name),
                    "{hit:?}"
                );
                coincident += u32::from(is_in_lid && hit.normal.z > 0.9);
            }
        }
    }
    assert!(coincident > 20);
}

#[test]
fn hits_of_random_solids_are_where_membership_changes() {
    let mut random = Random(21);
    let mut hits_in_all = 0;
    for round in 0..60 {
        let mut solid = Solid::cube(1.6);
        for _ in 0..1 + random.below(7) {
            let shape = match random.below(7) {
                0 => Solid::sphere(0.3 + random.unit()),
                1 => Solid::cuboid(DVec3::splat(0.2) + 0.8 * random_vector(&mut random).abs()),
                2 => Solid::cylinder(0.2 + 0.4 * random.unit(), -1.0..0.7),
                3 => Solid::cone(0.4 + random.unit(), -0.5..0.5),
                4 => Solid::hyperboloid_one_sheet([0.3, 0.4, 0.5]),
                5 => star(40),
                _ => Solid::hull((0..80).map(|_| random_vector(&mut random))),
            };
            let turned = shape
                .rotate_x(random.below(4) as f64 * 0.3)
                .rotate_z(random.unit())
                .translate(0.6 * random_vector(&mut random));
            solid = match random.below(3) {
                0 => solid | turned,
                1 => solid - turned,
                _ => Solid::cube(3.0) & (solid | !turned),
            };
        }
        let program = lowered(&solid);
        for _ in 0..40 {
            let origin = 3.0 * random_vector(&mut random);
            let direction = random_vector(&mut random) - 0.5 * origin;
            let hits = program.ray(origin, direction).expect("hits");
            hits_in_all += hits.len();
            let mut is_in = program.contains(origin);
            let mut before = 0.0;
            for hit in &hits {
                assert!(hit.t > before && hit.enters != is_in, "{round}: {hits:?}");
                let cosine = hit.normal.dot(direction) / direction.length();
                let coordinates = 1.0 + hit.point.length() + hit.point.length_squared();
                let bound = 1e-13 * coordinates / cosine.abs() / direction.length();
                assert!(hit.error < bound, "{:e}, not {bound:e}: {hit:?}", hit.error);
                assert!((hit.normal.dot(direction) < 0.0) == hit.enters);
                assert!((origin + hit.t * direction).distance(hit.point) < 1e-15 * coordinates);
                // Membership flips at once before and after.
                let step = (2.0 * hit.error).max(1e-12);
                for (t, side) in [(hit.t - step, is_in), (hit.t + step, !is_in)] {
                    assert_eq!(
                        program.contains(origin + t * direction),
                        side,
                        "{round}: {hit:?}"
                    );
                }
                (before, is_in) = (hit.t, hit.enters);
            }
            // And nowhere else.
            let sides = (0..400).map(|k| 0.01 * (f64::from(k) + random.unit()));
            for t in sides {
                let known = hits.iter().rfind(|hit| hit.t < t).map(|hit| hit.enters);
                let is_near = hits.iter().any(|hit| (hit.t - t).abs() < 1e-9);
                let inside = program.contains(origin + t * direction);
                assert!(
                    is_near || inside == known.unwrap_or(program.contains(origin)),
                    "{round}: at {t} of {hits:?}"
                );
            }
        }
    }
    assert!(hits_in_all > 2000, "{hits_in_all}");
}

#[test]
fn rays_without_a_direction_are_refused() {
    let ball = lowered(&Solid::sphere(1.0));
    for (origin, direction) in [
        ([0.0; 3], [0.0; 3]),
        ([f64::NAN, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ([0.0; 3], [f64::INFINITY, 0.0, 0.0]),
    ] {
        let error = ball.ray(origin, direction).expect_err("bad input");
        assert!(error.to_string().contains("give finite numbers"), "{error}");
    }
    // Lengths and places that overflow are no panic.
    for far in [1e-300, 1e160, 1e300] {
        let hits = ball.ray([-2.0, 0.0, 0.0], [far, 0.0, 0.0]).expect("hits");
        assert!((hits[0].t * far - 1.0).abs() < 1e-14);
        drop(ball.ray([far; 3], [-1.0; 3]));
    }
}

/// The mesh is off no more than it says.
#[test]
fn distances_are_those_of_closed_forms() {
    let ball = |p: DVec3| p.length() - 1.0;
    let cylinder = |p: DVec3| {
        let off = dvec2(p.truncate().length() - 0.8, p.z.abs() - 1.2);
        off.max(DVec2::ZERO).length() + off.max_element().min(0.0)
    };
    let cuboid = |p: DVec3| {
        let off = p.abs() - dvec3(0.5, 1.0, 1.5);
        off.max(DVec3::ZERO).length() + off.max_element().min(0.0)
    };
    // A hollow ball: the nearer one of two spheres.
    let hollow = |p: DVec3| (p.length() - 1.5).max(0.7 - p.length());
    let cases: [(Solid, &dyn Fn(DVec3) -> f64); 4] = [
        (Solid::sphere(1.0), &ball),
        (Solid::cylinder(0.8, -1.2..1.2), &cylinder),
        (Solid::cuboid([1.0, 2.0, 3.0]), &cuboid),
        (Solid::sphere(1.5) - Solid::sphere(0.7), &hollow),
    ];
    let mut random = Random(5);
    let points: Vec<DVec3> = (0..500).map(|_| 3.0 * random_vector(&mut random)).collect();
    for (solid, truth) in cases {
        let nearest = lowered(&solid).nearest(&points, &Mesher::new().tolerance(1e-3));
        let nearest = nearest.expect("distances").expect("no empty solid");
        for (found, &point) in nearest.iter().zip(&points) {
            let error = found.error.expect("proven");
            let truth = truth(point);
            assert!(error <= 1e-3 && (found.distance - truth).abs() <= error + 1e-14);
            let far = found.point.distance(point);
            assert!((far - found.distance.abs()).abs() < 1e-14);
        }
    }
}

#[test]
fn nothing_is_near_an_empty_solid() {
    let nothing = Solid::cube(1.0) & Solid::cube(1.0).translate([5.0, 0.0, 0.0]);
    assert_eq!(
        lowered(&nothing).nearest(&[DVec3::ZERO], &Mesher::new()),
        Ok(None)
    );
    let nan = lowered(&Solid::cube(1.0)).nearest(&[DVec3::ZERO, DVec3::NAN], &Mesher::new());
    assert!(matches!(nan, Err(Error::InvalidOption(text)) if text.starts_with("point 1 is")));
}
