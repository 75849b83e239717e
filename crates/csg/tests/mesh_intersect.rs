//! Self-intersections against exact integer arithmetic and known shapes.

use crate::shapes::{cuboid, joined, mapped, tetrahedron, torus, unit_cube};
use csg::Mesh;
use glam::{DQuat, DVec3, I64Vec3, dvec3};
use proptest::prelude::*;

use crate::sweeps::one_in;

/// The points common to two triangles with integer corners, up to their
/// convex hull, each as (numerators, denominator): corners of one inside the
/// other, and edges of one through the other. Exact in 64 bits for small
/// coordinates.
fn common_points(first: [I64Vec3; 3], second: [I64Vec3; 3]) -> Vec<(I64Vec3, i64)> {
    let mut points = Vec::new();
    for (one, other) in [(first, second), (second, first)] {
        let [a, b, c] = other;
        let normal = (b - a).cross(c - a);
        // Inside the other, seen along its normal; edges count.
        let inside = |n: I64Vec3, d: i64| {
            [(a, b), (b, c), (c, a)]
                .into_iter()
                .all(|(u, v)| (v - u).cross(n - u * d).dot(normal) >= 0)
        };
        for i in 0..3 {
            let (p, q) = (one[i], one[(i + 1) % 3]);
            let (hp, hq) = ((p - a).dot(normal), (q - a).dot(normal));
            if hp == 0 && inside(p, 1) {
                points.push((p, 1));
            }
            if hp.signum() * hq.signum() < 0 {
                // p + t (q - p) with t = hp / (hp - hq), denominator positive.
                let d = (hp - hq).abs();
                let n = p * d + (q - p) * (hp * (hp - hq).signum());
                if inside(n, d) {
                    points.push((n, d));
                }
            }
            if hp == 0 && hq == 0 {
                // In the other's plane: crossings with its edges.
                for (u, v) in [(a, b), (b, c), (c, a)] {
                    let outer = (v - u).cross(normal);
                    let (kp, kq) = ((p - u).dot(outer), (q - u).dot(outer));
                    if kp.signum() * kq.signum() < 0 {
                        let d = (kp - kq).abs();
                        let n = p * d + (q - p) * (kp * (kp - kq).signum());
                        if inside(n, d) {
                            points.push((n, d));
                        }
                    }
                }
            }
        }
    }
    points
}

/// The definition of an intersection, from the common points: more than one
/// of them, and not all on a line that holds an edge of both.
fn intersect_exactly(first: [I64Vec3; 3], second: [I64Vec3; 3]) -> bool {
    let points = common_points(first, second);
    let same = |(n, d): (I64Vec3, i64), (m, e): (I64Vec3, i64)| n * e == m * d;
    let several = points.iter().any(|&p| !same(p, points[0]));
    let on_line =
        |u: I64Vec3, v: I64Vec3, n: I64Vec3, d: i64| (v - u).cross(n - u * d) == I64Vec3::ZERO;
    let edges = |t: [I64Vec3; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    let along_edges = edges(first).into_iter().any(|(u, v)| {
        edges(second)
            .into_iter()
            .any(|(p, q)| on_line(u, v, p, 1) && on_line(u, v, q, 1))
            && points.iter().all(|&(n, d)| on_line(u, v, n, d))
    });
    several && !along_edges
}

/// Two triangles as a mesh without shared vertices.
fn pair(first: [I64Vec3; 3], second: [I64Vec3; 3]) -> Mesh {
    let corners = first.into_iter().chain(second);
    Mesh::new(
        corners.map(I64Vec3::as_dvec3).collect(),
        vec![[0, 1, 2], [3, 4, 5]],
    )
}

fn triangle(size: i64) -> impl Strategy<Value = [I64Vec3; 3]> {
    let corner = prop::array::uniform3(0..=size).prop_map(I64Vec3::from_array);
    prop::array::uniform3(corner).prop_filter("has an area", |[a, b, c]| {
        (*b - *a).cross(*c - *a) != I64Vec3::ZERO
    })
}

/// A triangle with an area in a plane skew to the axes.
fn flat_triangle() -> impl Strategy<Value = [I64Vec3; 3]> {
    let corner = (0..4i64, 0..4i64)
        .prop_map(|(u, v)| I64Vec3::new(1, 2, -1) * u + I64Vec3::new(3, -1, 2) * v);
    prop::array::uniform3(corner).prop_filter("has an area", |[a, b, c]| {
        (*b - *a).cross(*c - *a) != I64Vec3::ZERO
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000 / one_in(5) as u32))]

    /// Corners on a tiny lattice: every kind of contact occurs.
    #[test]
    fn pairs_on_a_lattice_agree_with_integer_arithmetic(
        first in triangle(2), second in triangle(2),
    ) {
        let found = !pair(first, second).self_intersections().is_empty();
        prop_assert_eq!(found, intersect_exactly(first, second));
        let swapped = !pair(second, first).self_intersections().is_empty();
        prop_assert_eq!(found, swapped);
    }

    /// The same in one plane, skew to the axes.
    #[test]
    fn pairs_in_a_plane_agree_with_integer_arithmetic(
        first in flat_triangle(), second in flat_triangle(),
    ) {
        let found = !pair(first, second).self_intersections().is_empty();
        prop_assert_eq!(found, intersect_exactly(first, second));
    }
}

proptest! {
    /// The tree misses no pair and invents none.
    #[test]
    fn heaps_agree_with_all_pairs(triangles in prop::collection::vec(triangle(9), 0..60)) {
        let positions = triangles.iter().flatten().map(|p| p.as_dvec3()).collect();
        let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mut expected = Vec::new();
        for j in 0..triangles.len() {
            for i in 0..j {
                if intersect_exactly(triangles[i], triangles[j]) {
                    expected.push([i as u32, j as u32]);
                }
            }
        }
        expected.sort_unstable();
        prop_assert_eq!(Mesh::new(positions, indices).self_intersections(), expected);
    }
}

#[test]
fn simple_meshes_have_none() {
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.7);
    for mesh in [
        unit_cube(),
        torus(2.0, 0.5, 60, 30),
        tetrahedron([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]),
        Mesh::default(),
    ] {
        assert_eq!(mesh.self_intersections(), [[0u32; 2]; 0]);
        for scale in [1e-6, 1.0, 1e6] {
            let moved = mapped(&mesh, |p| turn * (p * scale) + dvec3(0.1, 0.2, 0.3) * scale);
            assert_eq!(moved.self_intersections(), [[0u32; 2]; 0]);
        }
    }
}

#[test]
fn a_spindle_torus_runs_through_itself() {
    // The tube is wider than the hole.
    let mesh = torus(1.0, 1.5, 40, 20);
    assert!(mesh.check().is_manifold());
    let pairs = mesh.self_intersections();
    assert!(!pairs.is_empty());
    // They cross at the two poles of the lens inside, |z| = sqrt(1.5² - 1).
    let pole = (1.5f64 * 1.5 - 1.0).sqrt();
    for pair in &pairs {
        for &index in pair {
            let reach = mesh
                .corners(index as usize)
                .map(|p| (p - dvec3(0.0, 0.0, pole.copysign(p.z))).length());
            assert!(reach.iter().any(|&r| r < 0.6), "{reach:?}");
        }
    }
}

#[test]
fn touching_is_no_intersection_but_overlapping_is() {
    let cube = unit_cube();
    let with =
        |low: DVec3, high: DVec3| joined(&cube, &cuboid(low, high)).self_intersections().len();
    // Corner on corner, edge on edge, part of an edge on part of an edge.
    assert_eq!(with(DVec3::ONE, DVec3::splat(2.0)), 0);
    assert_eq!(with(dvec3(1.0, 1.0, 0.0), dvec3(2.0, 2.0, 1.0)), 0);
    assert_eq!(with(dvec3(1.0, 1.0, 0.25), dvec3(2.0, 2.0, 0.5)), 0);
    // Apart.
    assert_eq!(with(dvec3(1.5, 0.0, 0.0), dvec3(2.0, 1.0, 1.0)), 0);
    // A tip that just reaches a face.
    let tip = [
        dvec3(1.0, 0.4, 0.5),
        dvec3(2.0, 0.0, 0.0),
        dvec3(2.0, 1.0, 0.0),
        dvec3(2.0, 0.5, 1.0),
    ];
    assert_eq!(
        joined(&cube, &tetrahedron(tip)).self_intersections().len(),
        0
    );
    // ... and one that goes on by the least step there is, through the one
    // triangle of that face it points at: three triangles meet at the tip.
    let mut through = tip;
    through[0].x = 1.0f64.next_down();
    assert_eq!(
        joined(&cube, &tetrahedron(through))
            .self_intersections()
            .len(),
        3
    );
    // Face on face, in whole and in part.
    assert!(with(dvec3(1.0, 0.0, 0.0), dvec3(2.0, 1.0, 1.0)) >= 2);
    assert!(with(dvec3(1.0, 0.5, 0.25), dvec3(2.0, 1.5, 0.75)) >= 2);
    // Twice the same: each triangle on itself, and across the diagonals.
    assert!(with(DVec3::ZERO, DVec3::ONE) >= 12);
    // Through each other.
    assert!(with(DVec3::splat(0.5), DVec3::splat(1.5)) >= 6);
}

#[test]
fn what_is_no_triangle_is_passed_over() {
    let mut mesh = unit_cube();
    mesh.positions
        .extend([DVec3::NAN, DVec3::splat(0.5), dvec3(2.0, 0.5, 0.5)]);
    // Out of range, repeated, not finite, without area (through a face).
    mesh.triangles
        .extend([[0, 1, 99], [0, 0, 7], [0, 8, 7], [9, 10, 9]]);
    mesh.positions.push(dvec3(1.25, 0.5, 0.5));
    mesh.triangles.push([9, 10, 11]);
    assert_eq!(mesh.self_intersections(), [[0u32; 2]; 0]);
}

#[test]
fn pairs_do_not_depend_on_the_number_of_threads() {
    let mesh = joined(
        &torus(1.0, 1.5, 100, 50),
        &mapped(&torus(2.0, 0.5, 100, 50), |p| p + DVec3::X),
    );
    let run = |threads: usize| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a thread pool")
            .install(|| mesh.self_intersections())
    };
    let one = run(1);
    assert!(one.len() > 100);
    assert_eq!(one, run(2));
    assert_eq!(one, run(8));
}
