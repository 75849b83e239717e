use std::f64::consts::TAU;

use glam::DVec3;

use super::*;
use crate::{Mesher, Solid, elementary};

const TOLERANCE: f64 = 0.01;
const HELD: Tolerances = Tolerances {
    tolerance: TOLERANCE,
    unseen: 1e-9,
};

/// A solid's program and bounds, and its mesh.
fn meshed(solid: &Solid) -> (Program, Bounds, Mesh) {
    let program = Program::lower(solid).expect("valid");
    let meshed = Mesher::new().tolerance(TOLERANCE).mesh(&program);
    let mesh = meshed.expect("a mesh").mesh;
    let bounds = program.bounds().expect("bounded").expect("not empty");
    (program, bounds, mesh)
}

fn share(solid: &Solid, mesh: &Mesh) -> Option<f64> {
    let (program, bounds, _) = meshed(solid);
    let found = differences(&program, mesh, &bounds, HELD);
    (!found.places.is_empty()).then_some(found.share)
}

fn mesh(solid: &Solid) -> Mesh {
    meshed(solid).2
}

/// Two blocks, one of them drilled, a ball, and a cone on a cylinder beside each other; the second
/// block is a polyhedron of many faces on request.
fn parts(faceted: bool) -> Vec<Solid> {
    let block = Solid::cuboid([1.0, 0.8, 0.6]) - Solid::infinite_cylinder(0.2);
    let other = if faceted {
        let corner = |k: i32| 0.5 * elementary::direction(TAU * f64::from(k) / 60.0);
        Solid::prism((0..60).map(corner), -0.45..0.45)
    } else {
        Solid::cube(0.9)
    };
    vec![
        block.rotate_x(0.3),
        other.rotate_z(0.5).translate([2.0, 0.0, 0.0]),
        Solid::sphere(0.5).translate([0.0, 2.0, 0.3]),
        (Solid::cone(0.5, 0.0..1.0) | Solid::cylinder(0.3, -0.5..0.2)).translate([2.0, 2.0, 0.0]),
    ]
}

fn all(faceted: bool) -> Solid {
    Solid::union(parts(faceted))
}

/// Each part, and whether polyhedra are among them.
fn cases() -> impl Iterator<Item = (bool, usize)> {
    [false, true]
        .into_iter()
        .flat_map(|faceted| (0..4).map(move |part| (faceted, part)))
}

/// The triangles of each part, by where their first corner is.
fn is_of(mesh: &Mesh, triangle: usize, part: usize) -> bool {
    let corner = mesh.corners(triangle)[0];
    (corner.x > 1.0, corner.y > 1.2) == (part % 2 == 1, part > 1)
}

/// The mesh with the triangles of a part changed into others.
fn broken(faceted: bool, part: usize, change: impl Fn([DVec3; 3]) -> Vec<[DVec3; 3]>) -> Mesh {
    let whole = mesh(&all(faceted));
    let mut mesh = Mesh {
        surfaces: whole.surfaces.clone(),
        ..Mesh::default()
    };
    for index in 0..whole.triangles.len() {
        let corners = whole.corners(index);
        let made = if is_of(&whole, index, part) {
            change(corners)
        } else {
            vec![corners]
        };
        for corners in made {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.triangle_surfaces.push(whole.triangle_surfaces[index]);
        }
    }
    mesh
}

#[test]
fn a_whole_mesh_is_right() {
    for faceted in [false, true] {
        let same = broken(faceted, 0, |corners| vec![corners]);
        for mesh in [mesh(&all(faceted)), same] {
            assert_eq!(share(&all(faceted), &mesh), None);
        }
    }
}

#[test]
fn a_part_that_is_not_there_is_missed() {
    for (faceted, part) in cases() {
        let found = share(&all(faceted), &broken(faceted, part, |_| Vec::new()));
        assert!(found.is_some(), "part {part}");
    }
}

#[test]
fn a_part_inside_out_is_seen() {
    for (faceted, part) in cases() {
        let found = share(
            &all(faceted),
            &broken(faceted, part, |[a, b, c]| vec![[a, c, b]]),
        );
        assert!(
            found.is_some_and(|share| share > 0.05),
            "part {part}: {found:?}"
        );
    }
}

#[test]
fn a_part_elsewhere_is_seen() {
    for (faceted, part) in cases() {
        for by in [0.04, 0.1, 0.5] {
            let by = DVec3::new(1.0, -0.8, 0.7) * by;
            let found = share(
                &all(faceted),
                &broken(faceted, part, |corners| vec![corners.map(|p| p + by)]),
            );
            assert!(found.is_some(), "part {part} by {by}");
        }
    }
}

#[test]
fn a_part_that_is_there_twice_is_seen() {
    for (faceted, part) in cases() {
        let found = share(
            &all(faceted),
            &broken(faceted, part, |corners| vec![corners; 2]),
        );
        assert!(found.is_some(), "part {part}");
    }
}

#[test]
fn solids_whose_near_surfaces_were_lost_are_seen() {
    let ball = Solid::sphere(1.0);
    let cube = Solid::cube(1.0).translate([5.0, 0.0, 0.0]);
    let near = &ball | Solid::sphere(0.999_999_999_999);
    assert!(share(&(&near | &cube), &mesh(&cube)).is_some_and(|share| share > 0.2));

    let hollow = &ball - Solid::sphere(0.5) - Solid::sphere(0.500_000_000_000_2);
    assert!(share(&hollow, &mesh(&ball)).is_some_and(|share| share > 0.02));

    let half = Solid::cuboid([2.0, 4.0, 4.0]).translate([1.0, 0.0, 0.0]);
    let near = (&ball | Solid::sphere(0.999_999_999_999_5)) - half;
    assert!(share(&near, &Mesh::default()).is_some_and(|share| share > 0.9));
}

#[test]
fn one_small_ball_of_many_is_missed() {
    let balls = |without: Option<usize>| {
        let each = (0..60).filter(|&i| Some(i) != without).map(|i| {
            let at = [i % 4, i / 4 % 4, i / 16].map(|k| k as f64 - 1.5);
            Solid::sphere(0.05 + 0.001 * i as f64).translate(DVec3::from_array(at))
        });
        Solid::union(each)
    };
    for without in [0, 17, 42] {
        // The surfaces' numbers are those of the whole.
        let whole = balls(None);
        let mut mesh = mesh(&whole);
        let at = [without % 4, without / 4 % 4, without / 16].map(|k| k as f64 - 1.5);
        let at = DVec3::from_array(at);
        let kept: Vec<usize> = (0..mesh.triangles.len())
            .filter(|&index| mesh.corners(index)[0].distance(at) > 0.2)
            .collect();
        mesh.triangle_surfaces = kept.iter().map(|&i| mesh.triangle_surfaces[i]).collect();
        mesh.triangles = kept.iter().map(|&i| mesh.triangles[i]).collect();
        assert!(share(&whole, &mesh).is_some(), "{without}");
    }
}

#[test]
fn spans_are_those_of_the_solid() {
    // 70 plates in a row: more pieces than a word has bits.
    let plates = Solid::union((0..70).map(|i| {
        Solid::cuboid_between([f64::from(i), -1.0, -1.0], [f64::from(i) + 0.5, 1.0, 1.0])
    }));
    let program = Program::lower(&plates).expect("valid");
    let bounds = program.bounds().expect("bounded").expect("not empty");
    let lattice = Lattice {
        places: [vec![0.25], vec![0.2], vec![0.3]],
    };
    let found = spans::along(&program, &lattice, &bounds);
    let along_x: Vec<[f64; 2]> = found
        .iter()
        .filter(|s| s.ray == 0)
        .map(|s| s.ends)
        .collect();
    assert_eq!(along_x.len(), 70);
    for (i, [low, high]) in along_x.into_iter().enumerate() {
        assert!((low - i as f64).abs() < 1e-9 && (high - i as f64 - 0.5).abs() < 1e-9);
    }
    for ray in [1, 2] {
        let across: Vec<[f64; 2]> = found
            .iter()
            .filter(|s| s.ray == ray)
            .map(|s| s.ends)
            .collect();
        assert!(across.len() == 1 && across[0][0] <= -1.0 + 1e-9 && across[0][1] >= 1.0 - 1e-9);
    }
}
