//! The draft mesh: always closed, near the truth, and nearer with more cells.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicU64, Ordering};

use csg::program::{Cell, Pruner};
use csg::{Bounds, CancelToken, Color, Error, Mesh, Meshed, Mesher, Program, Solid};
use glam::{DVec3, dvec3};
use proptest::prelude::*;

use crate::sweeps::one_in;

fn lower(solid: &Solid) -> Program {
    Program::lower(solid).expect("a valid solid")
}

fn draft(solid: &Solid, cells: u32) -> Meshed {
    Mesher::new()
        .cells(cells)
        .draft()
        .mesh(&lower(solid))
        .expect("a mesh")
}

fn drilled() -> Solid {
    let bore = Solid::infinite_cylinder(0.5);
    (Solid::cube(1.5) & Solid::sphere(1.0))
        - &bore
        - bore.rotate_x(PI / 2.0)
        - bore.rotate_y(PI / 2.0)
}

/// The exact volume of [`drilled`] (integrated to 1e-15).
const DRILLED_VOLUME: f64 = 0.988_789_557_199_477;

/// The mean error over several resolutions around `cells`: the error of one
/// depends on where the lattice happens to fall.
fn mean_error(solid: &Solid, volume: f64, cells: u32) -> f64 {
    let errors =
        (0..5).map(|i| (draft(solid, cells + i * cells / 16).mesh.volume() - volume).abs());
    errors.sum::<f64>() / 5.0
}

#[test]
fn the_error_falls_fourfold_as_cells_double() {
    for (solid, volume) in [
        (Solid::sphere(1.0), 4.0 / 3.0 * PI),
        (drilled(), DRILLED_VOLUME),
    ] {
        let errors = [16, 32, 64].map(|cells| mean_error(&solid, volume, cells));
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((1.6..2.6).contains(&order), "{errors:?} order {order}");
        }
    }
}

#[test]
fn genus_and_provenance() {
    let solid = (Solid::cube(1.5)
        .named("block")
        .colored(Color::from_linear([1.0, 0.0, 0.0]))
        & Solid::sphere(1.0))
        - Solid::infinite_cylinder(0.5).named("bore");
    let Meshed { mesh, report, .. } = draft(&solid, 48);
    assert!(report.check.is_manifold(), "{}", report.check);
    assert_eq!(report.check.genus(), Some(1));
    assert_eq!(draft(&drilled(), 48).report.check.genus(), Some(5));
    assert_eq!(mesh.triangle_surfaces.len(), mesh.triangles.len());
    assert_eq!(mesh.corner_normals.len(), mesh.triangles.len());
    // Away from edges a triangle lies on the surface that it names.
    let mut named = [0.0; 3];
    for index in 0..mesh.triangles.len() {
        let corners = mesh.corners(index);
        let area = 0.5
            * (corners[1] - corners[0])
                .cross(corners[2] - corners[0])
                .length();
        let surface = mesh.surface_of(index).expect("a surface");
        let on =
            |distance: &dyn Fn(DVec3) -> f64| corners.iter().all(|&p| distance(p).abs() < 1e-3);
        let place = match surface.name.as_deref() {
            Some("block") => 0,
            Some("bore") => 1,
            _ => 2,
        };
        assert_eq!(surface.color.is_some(), place == 0);
        named[place] += area;
        if on(&|p| p.length() - 1.0) && !on(&|p| p.abs().max_element() - 0.75) {
            assert_eq!(place, 2, "{corners:?}");
        }
        if on(&|p| p.truncate().length() - 0.5) {
            assert_eq!(place, 1, "{corners:?}");
        }
        // Outward: the normals agree with the triangle.
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        for corner in mesh.corner_normals[index] {
            assert!(corner.as_dvec3().dot(normal) > 0.0);
        }
    }
    // The bore's wall: its ends lie on the faces z = ±3/4.
    assert!((named[1] - 2.0 * PI * 0.5 * 1.5).abs() < 0.1, "{named:?}");
}

#[test]
fn abutting_boxes_have_no_membrane() {
    let part = Solid::cuboid_between([0.0; 3], [1.0, 1.0, 1.0]);
    let solid = Solid::union([
        part.clone(),
        part.translate([1.0, 0.0, 0.0]),
        part.translate([2.0, 0.0, 0.0]),
    ]);
    let meshed = draft(&solid, 40);
    assert!(meshed.report.check.is_manifold());
    assert_eq!(meshed.report.check.components, 1);
    assert_eq!(meshed.report.check.genus(), Some(0));
    // Along its 20 units of sharp edges the draft bevels less than half a
    // cell's square.
    let bevels = 20.0 * 0.5 * meshed.report.cell_size.powi(2);
    assert!((meshed.mesh.volume() - 3.0).abs() < bevels);
    for position in &meshed.mesh.positions {
        let inner = position.x.clamp(0.2, 2.8) == position.x
            && position.y.clamp(0.2, 0.8) == position.y
            && position.z.clamp(0.2, 0.8) == position.z;
        assert!(!inner, "{position}");
    }
}

#[test]
fn a_shell_of_several_cells_is_resolved() {
    let solid = Solid::sphere(1.0) - Solid::sphere(0.9);
    let volume = 4.0 / 3.0 * PI * (1.0 - 0.9f64.powi(3));
    let Meshed { mesh, report, .. } = draft(&solid, 64);
    assert!(report.check.is_manifold());
    assert_eq!(
        (report.check.components, report.check.genus()),
        (2, Some(0))
    );
    assert!((mesh.volume() / volume - 1.0).abs() < 0.02);
}

#[test]
fn a_wall_thinner_than_a_cell_stays_closed() {
    let solid = Solid::sphere(1.0) - Solid::sphere(0.98);
    let report = draft(&solid, 32).report;
    assert!(report.check.is_closed() && report.check.is_oriented());
    // One vertex a cell cannot do justice to two sheets, and it says so.
    assert!(report.check.non_manifold_edges > 0);
}

#[test]
fn nothing_and_infinity() {
    let nothing = draft(&(Solid::cube(1.0) - Solid::cube(1.0)), 32);
    assert!(nothing.mesh.positions.is_empty() && nothing.mesh.triangles.is_empty());
    assert_eq!(nothing.report.bounds, None);
    for endless in [
        Solid::infinite_cylinder(1.0),
        !Solid::sphere(1.0),
        Solid::half_space([0.0, 0.0, 1.0], 0.0),
    ] {
        let result = Mesher::new().draft().mesh(&lower(&endless));
        assert!(
            matches!(result, Err(Error::Unbounded { .. })),
            "{endless:?}"
        );
    }
}

#[test]
fn far_away_and_at_any_scale_the_mesh_is_the_same() {
    let near = draft(&drilled(), 32);
    let offset = dvec3(1e6, -2e6, 3e6);
    let far = draft(&drilled().translate(offset), 32);
    let relative = (far.mesh.volume() / near.mesh.volume() - 1.0).abs();
    assert!(relative < 1e-3, "{relative}");
    assert!(far.report.check.is_manifold());
    for scale in [1e-9, 1e9] {
        let scaled = draft(&drilled().scale(scale), 32);
        let volume = scaled.mesh.volume() / scale.powi(3);
        assert!((volume / near.mesh.volume() - 1.0).abs() < 1e-3, "{volume}");
        assert_eq!(scaled.report.check.genus(), Some(5));
    }
}

#[test]
fn faces_on_round_numbers_fall_on_no_sample() {
    // 64 cells of 1/32: every face would lie in a plane of a lattice that
    // started at a corner.
    let steps = Solid::union((0..4).map(|i| {
        let i = f64::from(i);
        Solid::cuboid_between([0.0; 3], [2.0 - 0.5 * i, 2.0, 0.5 + 0.5 * i])
    }));
    let meshed = Mesher::new()
        .cell_size(1.0 / 32.0)
        .draft()
        .mesh(&lower(&steps))
        .expect("a mesh");
    assert!(meshed.report.check.is_manifold(), "{}", meshed.report.check);
    assert!(
        (meshed.mesh.volume() - 5.0).abs() < 0.02,
        "{}",
        meshed.mesh.volume()
    );
}

#[test]
fn options_are_checked() {
    let program = lower(&Solid::sphere(1.0));
    let sphere = Bounds {
        min: DVec3::splat(-1.0),
        max: DVec3::splat(1.0),
    };
    let cut = Bounds {
        min: DVec3::splat(-1.0),
        max: dvec3(1.0, 0.3, 1.0),
    };
    let within = Bounds {
        min: DVec3::splat(-0.1),
        max: DVec3::splat(0.1),
    };
    let endless = Bounds {
        min: DVec3::splat(-1.0),
        max: DVec3::INFINITY,
    };
    let faulty = [
        Mesher::new().cells(0),
        Mesher::new().cells(csg::MAX_CELLS + 1),
        Mesher::new().cell_size(0.0),
        Mesher::new().cell_size(f64::NAN),
        Mesher::new().cell_size(1e-9),
        Mesher::new().bounds(cut),
        Mesher::new().bounds(within),
        Mesher::new().bounds(endless),
    ];
    for mesher in faulty {
        let result = mesher.clone().draft().mesh(&program);
        assert!(matches!(result, Err(Error::InvalidOption(_))), "{mesher:?}");
    }
    let found = Mesher::new()
        .bounds(sphere)
        .cells(32)
        .draft()
        .mesh(&program)
        .expect("a mesh");
    assert!(found.report.check.is_manifold());
}

#[test]
fn progress_rises_to_one_and_cancel_stops() {
    let program = lower(&drilled());
    let calls = std::sync::Arc::new((AtomicU64::new(0), AtomicU64::new(0)));
    let seen = calls.clone();
    let meshed = Mesher::new().cells(64).draft().progress(move |share| {
        assert!((0.0..=1.0).contains(&share));
        seen.0.fetch_add(1, Ordering::Relaxed);
        seen.1.fetch_max(share.to_bits(), Ordering::Relaxed);
    });
    assert!(meshed.mesh(&program).is_ok());
    assert!(calls.0.load(Ordering::Relaxed) > 10);
    assert_eq!(f64::from_bits(calls.1.load(Ordering::Relaxed)), 1.0);

    let token = CancelToken::new();
    let stop = token.clone();
    let mesher = Mesher::new()
        .cells(64)
        .draft()
        .cancel_token(token)
        .progress(move |share| {
            assert!(share < 1.0);
            stop.cancel();
        });
    assert_eq!(mesher.mesh(&program), Err(Error::Cancelled));
}

#[test]
fn any_number_of_threads_gives_the_same_mesh() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        pool.install(|| draft(&drilled(), 40).mesh)
    };
    let one = with(1);
    assert_eq!(one, with(3));
    assert_eq!(one, with(8));
}

/// Bounded random trees with coincident faces.
fn any_tree() -> impl Strategy<Value = Solid> {
    let leaf = prop_oneof![
        Just(Solid::cube(1.0)),
        Just(Solid::sphere(0.6)),
        Just(Solid::cylinder(0.4, -0.5..0.5)),
        Just(Solid::cone(0.5, -0.5..0.5)),
    ];
    leaf.prop_recursive(4, 24, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 1..4).prop_map(Solid::union),
            prop::collection::vec(inner.clone(), 1..3).prop_map(Solid::intersection),
            prop::collection::vec(inner.clone(), 1..4).prop_map(Solid::difference),
            (inner.clone(), -2i32..3, -2i32..3).prop_map(|(s, x, y)| {
                s.translate([0.25 * f64::from(x), 0.25 * f64::from(y), 0.0])
            }),
            (inner.clone(), 0i32..4).prop_map(|(s, k)| s.rotate_x(f64::from(k) * PI / 4.0)),
            inner.prop_map(|s| &s - s.scale(0.5)),
        ]
    })
}

/// How often the mesh winds around a point: the sum of the triangles' solid
/// angles over 4 pi (van Oosterom and Strackee 1983).
fn winding_number(mesh: &Mesh, point: DVec3) -> f64 {
    let solid_angle = |index: usize| {
        let [a, b, c] = mesh.corners(index).map(|corner| corner - point);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(denominator)
    };
    (0..mesh.triangles.len()).map(solid_angle).sum::<f64>() / (4.0 * PI)
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(150 / one_in(5) as u32)
    })]

    #[test]
    fn random_trees_are_closed_and_true_to_the_program(
        tree in any_tree(),
        points in prop::collection::vec(prop::array::uniform3(0.0..1.0f64), 24),
    ) {
        let program = lower(&tree);
        let Meshed { mesh, report, .. } =
            Mesher::new().cells(28).draft().mesh(&program).expect("a mesh");
        let check = &report.check;
        prop_assert!(check.is_closed() && check.is_oriented(), "{}", check);
        prop_assert_eq!(check.degenerate_triangles + check.duplicate_triangles, 0);
        prop_assert_eq!(check.unreferenced_vertices, 0);
        let Some(bounds) = report.bounds else {
            prop_assert!(mesh.triangles.is_empty());
            return Ok(());
        };
        // A triangle stays within the cells around its lattice edge, so a
        // point is on the right side of the mesh wherever the program does not
        // vary within a cell of it.
        let root = program.root_cell();
        let half = DVec3::splat(1.001 * report.cell_size);
        let (mut pruner, mut cell) = (Pruner::default(), Cell::default());
        for point in points {
            let point = bounds.min + DVec3::from(point) * bounds.size();
            root.prune_into(program.surfaces(), point, half, &mut pruner, &mut cell);
            if let Some(inside) = cell.constant() {
                let expected = if inside { 1.0 } else { 0.0 };
                let winding = winding_number(&mesh, point);
                prop_assert!((winding - expected).abs() < 1e-6, "{winding} at {point}");
            }
        }
    }
}
