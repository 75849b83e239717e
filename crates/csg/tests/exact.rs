//! The exact mesher: manifold whatever the resolution, on the surface to
//! rounding, with the right topology where the cells resolve it.

use csg::{Mesh, Mesher, Program, Solid};
use glam::DVec3;

fn drilled() -> Solid {
    let bore = Solid::infinite_cylinder(0.5);
    let quarter = std::f64::consts::FRAC_PI_2;
    (Solid::cube(1.5) & Solid::sphere(1.0))
        - &bore
        - bore.rotate_x(quarter)
        - bore.rotate_y(quarter)
}

fn mesh(solid: &Solid, cells: u32) -> Mesh {
    let program = Program::lower(solid).expect("a valid solid");
    let meshed = Mesher::new().cells(cells).mesh(&program).expect("bounded");
    assert!(meshed.report.check.is_manifold(), "{cells} cells");
    assert!(
        meshed.report.fallbacks.is_empty(),
        "{:?}",
        meshed.report.fallbacks
    );
    meshed.mesh
}

/// The largest distance of a vertex from a surface that one of its triangles
/// claims, by evaluation.
fn largest_miss(solid: &Solid, mesh: &Mesh) -> f64 {
    let program = Program::lower(solid).expect("a valid solid");
    let mut largest = 0.0f64;
    for (triangle, &entry) in mesh.triangles.iter().zip(&mesh.triangle_surfaces) {
        let id = mesh.surfaces[entry as usize].surface;
        let surface = &program.surfaces()[id as usize];
        for &vertex in triangle {
            let p = mesh.positions[vertex as usize];
            let distance = surface.value(p).abs() / surface.gradient(p).length();
            largest = largest.max(distance);
        }
    }
    largest
}

#[test]
fn a_rotated_box_is_exact() {
    let solid = Solid::cuboid([2.0, 1.2, 0.6]).rotate_xyz(0.7, 0.5, 0.3);
    for cells in [16, 33, 64] {
        let mesh = mesh(&solid, cells);
        assert!((mesh.volume() - 1.44).abs() < 1e-13, "{}", mesh.volume());
        for i in 0..8 {
            let sign = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let corner = DVec3::new(sign(0), 0.6 * sign(1), 0.3 * sign(2));
            let corner = glam::DMat3::from_rotation_z(0.3)
                * glam::DMat3::from_rotation_y(0.5)
                * glam::DMat3::from_rotation_x(0.7)
                * corner;
            let nearest = mesh.positions.iter().map(|p| p.distance(corner));
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-13, "corner {i} off by {nearest:e} at {cells}");
        }
    }
}

#[test]
fn curved_solids_converge_at_second_order_with_vertices_on_their_surfaces() {
    let exact = 0.988_789_557_199_477;
    let mut previous = f64::INFINITY;
    for cells in [32, 64, 128] {
        let mesh = mesh(&drilled(), cells);
        let miss = largest_miss(&drilled(), &mesh);
        assert!(miss < 1e-13, "{miss:e} at {cells}");
        let error = (mesh.volume() - exact).abs();
        assert!(error < previous / 3.0, "{error:e} after {previous:e}");
        previous = error;
        assert_eq!(mesh.check().genus(), Some(5));
    }
}

#[test]
fn any_number_of_threads_gives_the_same_mesh() {
    let program = Program::lower(&drilled()).expect("a valid solid");
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads");
        let meshed = pool.install(|| Mesher::new().cells(100).mesh(&program));
        meshed.expect("bounded").mesh
    };
    let one = with_threads(1);
    assert!(one == with_threads(2));
    assert!(one == with_threads(8));
}

#[test]
fn normals_are_the_surfaces_gradients() {
    let solid = Solid::sphere(2.0) - Solid::sphere(1.0);
    let program = Program::lower(&solid).expect("a valid solid");
    let meshed = Mesher::new().cells(24).normals().mesh(&program);
    let mesh = meshed.expect("bounded").mesh;
    assert_eq!(mesh.corner_normals.len(), mesh.triangles.len());
    for (i, normals) in mesh.corner_normals.iter().enumerate() {
        for (p, n) in mesh.corners(i).into_iter().zip(normals) {
            // Outwards on the outer sphere, into the cavity on the inner.
            let outward = p.normalize() * if p.length() > 1.5 { 1.0 } else { -1.0 };
            assert!(n.as_dvec3().distance(outward) < 1e-6, "{n} at {p}");
        }
    }
}

#[test]
fn feature_edges_are_the_edges_of_the_solid() {
    let meshed = |solid: &Solid| {
        let program = Program::lower(solid).expect("a valid solid");
        let meshed = Mesher::new().cells(20).feature_edges(0.1).mesh(&program);
        meshed.expect("bounded").mesh
    };
    let length = |mesh: &Mesh, line: &[u32]| -> f64 {
        let at = |v: u32| mesh.positions[v as usize];
        line.windows(2).map(|w| at(w[0]).distance(at(w[1]))).sum()
    };
    // A cube has twelve, each of its side's length.
    let cube = meshed(&Solid::cube(2.0).rotate_xyz(0.3, 0.5, 0.7));
    assert_eq!(cube.feature_edges.len(), 12);
    for line in &cube.feature_edges {
        assert!((length(&cube, line) - 2.0).abs() < 1e-12);
    }
    // A cylinder has two closed ones.
    let cylinder = meshed(&Solid::cylinder(1.0, 0.0..1.0));
    assert_eq!(cylinder.feature_edges.len(), 2);
    for line in &cylinder.feature_edges {
        assert_eq!(line.first(), line.last());
        let circle = length(&cylinder, line);
        assert!(circle < std::f64::consts::TAU && circle > 6.2, "{circle}");
    }
    // A sphere cut by another through its middle, smooth elsewhere.
    let ball = meshed(&Solid::sphere(1.0));
    assert!(ball.feature_edges.is_empty());
}

#[test]
fn the_tip_of_a_cone_is_a_vertex() {
    let cone = Solid::cone(1.0, 0.0..2.0);
    let tip = DVec3::new(0.0, 0.0, 2.0);
    let turned = cone.rotate_xyz(0.3, 0.5, 0.7);
    let turned_tip = glam::DMat3::from_rotation_z(0.7)
        * glam::DMat3::from_rotation_y(0.5)
        * glam::DMat3::from_rotation_x(0.3)
        * tip;
    for (solid, tip) in [(cone, tip), (turned, turned_tip)] {
        for cells in [16, 23, 33, 64] {
            let mesh = mesh(&solid, cells);
            let distances = mesh.positions.iter().map(|p| p.distance(tip));
            let nearest = distances.fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-12, "off by {nearest:e} at {cells}");
        }
    }
}

#[test]
fn what_is_too_thin_for_the_cells_is_reported() {
    for thin in [
        Solid::cuboid([1.0, 1.0, 1e-3]),
        Solid::sphere(1.0) - Solid::sphere(0.9999),
    ] {
        let program = Program::lower(&thin).expect("a valid solid");
        let meshed = Mesher::new().cells(16).mesh(&program).expect("bounded");
        assert!(meshed.report.check.is_manifold());
        assert!(!meshed.report.fallbacks.is_empty());
    }
}

/// Ry(heading) Rx(pitch) Rz(roll): corners of a box are where the matrices of the
/// axes put them.
#[test]
fn rotate_euler_is_ry_rx_rz() {
    let (h, p, r) = (0.5f64, -0.4f64, 1.1f64);
    let at_once = mesh(&Solid::cuboid([2.0, 1.2, 0.6]).rotate_euler(h, p, r), 8);
    let turn = |[a, b]: [f64; 2], angle: f64| {
        let (sin, cos) = angle.sin_cos();
        [a * cos - b * sin, a * sin + b * cos]
    };
    for corner in 0..8 {
        let sign = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
        let [x, y] = turn([sign(0), 0.6 * sign(1)], r);
        let [y, z] = turn([y, 0.3 * sign(2)], p);
        let [z, x] = turn([z, x], h);
        let near = at_once.positions.iter();
        let nearest = near
            .map(|q| (q.x - x).abs() + (q.y - y).abs() + (q.z - z).abs())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-9, "{corner}: {nearest}");
    }
}
