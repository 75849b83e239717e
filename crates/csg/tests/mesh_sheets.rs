//! Self-intersections of meshes whose triangles share vertices, against the same triangles
//! one by one.

use std::f64::consts::TAU;

use crate::shapes::{self, torus};
use csg::{Mesh, Mesher, Program, Solid};
use glam::{DVec3, dvec3};
use proptest::prelude::*;

use crate::sweeps::one_in;

/// Each triangle with vertices of its own: no two are neighbours.
fn loose(mesh: &Mesh) -> Mesh {
    let corners = mesh.triangles.iter().flatten();
    let positions = corners.map(|&v| mesh.positions[v as usize]).collect();
    let triangles = 0..mesh.triangles.len() as u32;
    Mesh::new(
        positions,
        triangles.map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    )
}

fn assert_same_as_loose(mesh: &Mesh) -> usize {
    let pairs = mesh.self_intersections();
    assert_eq!(pairs, loose(mesh).self_intersections());
    pairs.len()
}

/// Rows of vertices, joined row by row and, if they are closed, at their ends.
fn strips(rows: &[Vec<DVec3>], is_closed: bool) -> Mesh {
    let length = rows[0].len() as u32;
    let mut triangles = Vec::new();
    for row in 1..rows.len() as u32 {
        for k in 0..length - u32::from(!is_closed) {
            let [a, b] = [k, (k + 1) % length].map(|k| (row - 1) * length + k);
            triangles.push([a, b, b + length]);
            triangles.push([a, b + length, a + length]);
        }
    }
    Mesh::new(rows.concat(), triangles)
}

/// A fan about the origin.
fn fan(rim: &[DVec3]) -> Mesh {
    let count = rim.len() as u32;
    let mut positions = rim.to_vec();
    positions.push(DVec3::ZERO);
    let triangles = (0..count).map(|k| [k, (k + 1) % count, count]).collect();
    Mesh::new(positions, triangles)
}

/// The vertex of the first index takes the place of that of the second.
fn pinched(mut mesh: Mesh, pinches: &[(prop::sample::Index, prop::sample::Index)]) -> Mesh {
    let vertices = mesh.positions.len();
    for (kept, gone) in pinches {
        let [kept, gone] = [kept, gone].map(|index| index.index(vertices) as u32);
        for vertex in mesh.triangles.as_flattened_mut() {
            *vertex = if *vertex == gone { kept } else { *vertex };
        }
    }
    mesh
}

fn polar(radius: f64, angle: f64, z: f64) -> DVec3 {
    dvec3(radius * angle.cos(), radius * angle.sin(), z)
}

/// Where the x axis goes, of all that map axes to axes.
fn turned(mesh: &Mesh, turn: u8) -> Mesh {
    let place = |p: DVec3| {
        let p = match turn % 3 {
            0 => p,
            1 => dvec3(p.z, p.x, p.y),
            _ => dvec3(p.y, p.z, p.x),
        };
        if turn < 3 { p } else { -p }
    };
    shapes::mapped(mesh, place)
}

/// Points of a lattice with few places, so that all kinds of contact occur.
fn lattice_point() -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-2..=2i32).prop_map(|[x, y, z]| dvec3(x.into(), y.into(), z.into()))
}

fn index_pair() -> impl Strategy<Value = (prop::sample::Index, prop::sample::Index)> {
    (any::<prop::sample::Index>(), any::<prop::sample::Index>())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000 / one_in(5) as u32))]

    /// A height field, with some vertices moved far enough to fold it, and some made one.
    #[test]
    fn folded_height_fields(
        heights in prop::collection::vec(0..3i32, 64),
        moves in prop::collection::vec((any::<prop::sample::Index>(), lattice_point()), 0..6),
        pinches in prop::collection::vec(index_pair(), 0..2),
        turn in 0..6u8,
    ) {
        let mut rows: Vec<Vec<DVec3>> = (0..8)
            .map(|y| (0..8).map(|x| dvec3(x.into(), y.into(), 0.25 * f64::from(heights[(8 * y + x) as usize]))).collect())
            .collect();
        for (vertex, by) in moves {
            let vertex = vertex.index(64);
            rows[vertex / 8][vertex % 8] += by;
        }
        assert_same_as_loose(&turned(&pinched(strips(&rows, false), &pinches), turn));
    }

    /// Boxes on a lattice that stand on, beside and in each other, some of them with corners moved
    /// or made one with others': on what others stand triangles run through them, or not.
    #[test]
    fn boxes_that_stand_on_boxes(
        boxes in prop::collection::vec((lattice_point(), prop::array::uniform3(1..3i32)), 2..6),
        moves in prop::collection::vec((any::<prop::sample::Index>(), lattice_point()), 0..3),
        pinches in prop::collection::vec(index_pair(), 0..3),
    ) {
        let mut mesh = Mesh::default();
        for (low, size) in boxes {
            let one = shapes::cuboid(low, low + DVec3::from_array(size.map(f64::from)));
            mesh = shapes::joined(&mesh, &one);
        }
        for (vertex, by) in moves {
            let vertex = vertex.index(mesh.positions.len());
            mesh.positions[vertex] += by;
        }
        assert_same_as_loose(&pinched(mesh, &pinches));
    }

    /// A ramp that winds about the axis several times: it may touch itself or run through
    /// itself where it does not rise enough.
    #[test]
    fn helicoidal_ramps(
        steps in prop::collection::vec((0..3i32, 1..3i32, 3..5i32), 8..40),
        per_turn in 5..12i32,
        turn in 0..6u8,
    ) {
        let mut z = 0.0;
        let mut rows = [Vec::new(), Vec::new()];
        for (k, (rise, inner, outer)) in (0..).zip(steps) {
            let angle = TAU * f64::from(k % per_turn) / f64::from(per_turn);
            z += 0.25 * f64::from(rise);
            rows[0].push(polar(outer.into(), angle, z));
            rows[1].push(polar(inner.into(), angle, z));
        }
        assert_same_as_loose(&turned(&strips(&rows, false), turn));
    }

    /// Discs and rings that cover the plane twice, whose rims cross themselves, touch
    /// themselves or go through one vertex twice.
    #[test]
    fn covers_of_two_sheets(
        rim in prop::collection::vec((1..4i32, 0..3i32), 8..24),
        ring in any::<bool>(),
        pinches in prop::collection::vec(index_pair(), 0..2),
        turn in 0..6u8,
    ) {
        let count = rim.len() as f64;
        let angle = |k: usize| 2.0 * TAU * k as f64 / count;
        let rim: Vec<DVec3> = (0..).zip(rim)
            .map(|(k, (radius, height))| polar(1.0 + f64::from(radius), angle(k), 0.5 * f64::from(height)))
            .collect();
        let mesh = if ring {
            let inner = (0..rim.len()).map(|k| polar(1.0, angle(k), 0.0)).collect();
            strips(&[rim, inner], true)
        } else {
            fan(&rim)
        };
        assert_same_as_loose(&turned(&pinched(mesh, &pinches), turn));
    }

    /// Any triangles on few vertices: edges of many triangles, doubled ones, and such
    /// without area.
    #[test]
    fn heaps_on_few_vertices(
        positions in prop::collection::vec(lattice_point(), 3..20),
        triangles in prop::collection::vec(prop::array::uniform3(any::<prop::sample::Index>()), 0..40),
    ) {
        let vertices = positions.len();
        let triangles = triangles.into_iter().map(|t| t.map(|v| v.index(vertices) as u32));
        // (A loose triangle that names a vertex twice has no area.)
        assert_same_as_loose(&Mesh::new(positions, triangles.collect()));
    }

    /// Closed surfaces with some vertices elsewhere.
    #[test]
    fn damaged_tori(
        moves in prop::collection::vec((any::<prop::sample::Index>(), lattice_point()), 0..4),
        pinches in prop::collection::vec(index_pair(), 0..2),
        minor in prop::sample::select(vec![0.5, 1.0, 1.5]),
    ) {
        let mut mesh = torus(1.5, minor, 16, 10);
        for (vertex, by) in moves {
            let vertex = vertex.index(mesh.positions.len());
            mesh.positions[vertex] += 0.5 * by;
        }
        assert_same_as_loose(&pinched(mesh, &pinches));
    }
}

fn solid() -> impl Strategy<Value = Solid> {
    let size = prop::sample::select(vec![0.5, 0.75, 1.0]);
    let primitive =
        (0..3, size, lattice_point()).prop_map(|(kind, size, at): (i32, f64, DVec3)| {
            let shape = match kind {
                0 => Solid::sphere(size),
                1 => Solid::cylinder(0.75 * size, -1.0..1.0),
                _ => Solid::cube(1.5 * size),
            };
            shape.translate(0.375 * at)
        });
    primitive.prop_recursive(3, 8, 2, |inner| {
        (0..3, inner.clone(), inner).prop_map(|(kind, a, b): (i32, Solid, Solid)| match kind {
            0 => a | b,
            1 => a & b,
            _ => a - b,
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200 / one_in(5) as u32))]

    /// Meshes of solids with some vertices elsewhere.
    #[test]
    fn damaged_solids(
        solid in solid(),
        moves in prop::collection::vec((any::<prop::sample::Index>(), lattice_point()), 0..4),
        cells in prop::option::of(4..16u32),
    ) {
        let mesher = match cells {
            Some(cells) => Mesher::new().cells(cells),
            None => Mesher::new().tolerance(0.05),
        };
        let program = Program::lower(&solid).expect("a program");
        let mut mesh = mesher.mesh(&program).expect("a mesh").mesh;
        for (vertex, by) in moves {
            if !mesh.positions.is_empty() {
                let vertex = vertex.index(mesh.positions.len());
                mesh.positions[vertex] += 0.2 * by;
            }
        }
        assert_same_as_loose(&mesh);
    }
}

/// A disc whose rim goes through one vertex after each of two turns, the first inside the
/// second: two simple polygons, but the disc lies over itself within the inner one.
#[test]
fn a_rim_of_two_turns_through_one_vertex() {
    const PER_TURN: u32 = 12;
    let mut rim = Vec::new();
    for turn in 0..2 {
        for k in 0..PER_TURN {
            let angle = TAU * f64::from(k) / f64::from(PER_TURN);
            let bulge = (angle / 2.0).sin();
            let radius = if turn == 0 { 2.0 - bulge } else { 2.0 + bulge };
            rim.push(polar(radius, angle, 0.0));
        }
    }
    let mut mesh = fan(&rim);
    for vertex in mesh.triangles.as_flattened_mut() {
        if *vertex == PER_TURN {
            *vertex = 0;
        }
    }
    assert!(assert_same_as_loose(&mesh) >= 12);
}

/// Meshes of many more triangles than are looked at together.
#[test]
fn large_meshes() {
    let around = 500 / one_in(2) as u32;
    for minor in [0.5, 1.1] {
        let mesh = torus(1.0, minor, around, 200);
        assert_eq!(assert_same_as_loose(&mesh) > 0, minor > 1.0);
        // In an order without neighbours side by side.
        let mut shuffled = mesh.clone();
        let count = mesh.triangles.len();
        for (k, triangle) in shuffled.triangles.iter_mut().enumerate() {
            *triangle = mesh.triangles[k * 7919 % count];
        }
        assert_same_as_loose(&shuffled);
    }
}
