//! Meshes brought to a tolerance: is the promise kept, with few triangles?

use std::f64::consts::PI;

use csg::{Meshed, Mesher, Program, Solid};
use glam::DVec3;
use stereotomy::{csg, scenes};

use super::defects::{largest_miss, size};
use super::hard_models;
use crate::sweeps::one_in;

/// Scenes, the cells that see all of their features, and their genus.
fn scenes() -> Vec<(&'static str, Solid, u32, i64)> {
    let bored_cone = Solid::cone(1.0, 0.0..2.0)
        - Solid::infinite_cylinder(0.3)
            .rotate_x(std::f64::consts::FRAC_PI_2)
            .translate([0.0, 0.0, 0.7]);
    let lens = Solid::ellipsoid([1.0, 0.5, 0.2]) - Solid::paraboloid([0.5, 0.8]);
    let waist = Solid::hyperboloid_one_sheet([0.5, 0.7, 0.8]) & Solid::sphere(1.5);
    vec![
        ("sphere", scenes::sphere(), 8, 0),
        ("drilled", scenes::drilled(), 24, 5),
        ("sponge", scenes::menger(2), 30, 81),
        ("box", scenes::rotated_box(), 8, 0),
        ("shell", scenes::shell(0.2), 24, 0),
        ("flange", scenes::flange(), 40, 9),
        ("bored cone", bored_cone, 24, 1),
        ("lens", lens, 40, 0),
        ("waist", waist, 24, 0),
    ]
}

fn lower(solid: &Solid) -> Program {
    Program::lower(solid).expect("a valid solid")
}

fn mesh(program: &Program, cells: u32, tolerance: f64) -> Meshed {
    let mesher = Mesher::new().cells(cells).tolerance(tolerance);
    mesher.mesh(program).expect("a mesh")
}

/// The largest distance, to first order, of any of a lattice of points on the
/// triangles to the triangle's surface.
pub fn sampled_deviation(program: &Program, meshed: &Meshed) -> f64 {
    const STEPS: u32 = 8;
    let mesh = &meshed.mesh;
    let mut largest = 0.0f64;
    for triangle in 0..mesh.triangles.len() {
        let entry = mesh.surface_of(triangle).expect("an entry");
        let surface = &program.surfaces()[entry.surface as usize];
        let [p, q, r] = mesh.corners(triangle);
        for i in 0..=STEPS {
            for j in 0..=STEPS - i {
                let [a, b] = [i, j].map(|k| f64::from(k) / f64::from(STEPS));
                let point = p + a * (q - p) + b * (r - p);
                let gradient = surface.gradient(point).length();
                if gradient > 1e-9 {
                    largest = largest.max(surface.value(point).abs() / gradient);
                }
            }
        }
    }
    largest
}

/// The distance of a point to a triangle (Ericson, *Real-Time Collision
/// Detection*, 5.1.5).
pub fn distance(x: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let on_side = |p: DVec3, q: DVec3| {
        let t = (x - p).dot(q - p) / p.distance_squared(q);
        x.distance(p.lerp(q, t.clamp(0.0, 1.0)))
    };
    let normal = (b - a).cross(c - a);
    let is_over = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|&(p, q)| (q - p).cross(x - p).dot(normal) >= 0.0);
    if is_over {
        (x - a).dot(normal).abs() / normal.length()
    } else {
        on_side(a, b).min(on_side(b, c)).min(on_side(c, a))
    }
}

#[test]
fn the_promise_is_kept() {
    for (name, solid, cells, genus) in scenes() {
        let program = lower(&solid);
        for tolerance in [1e-2, 1e-3] {
            let meshed = mesh(&program, cells, tolerance);
            let (mesh, report) = (&meshed.mesh, &meshed.report);
            let label = format!("{name} to {tolerance}: {:?}", report.fallbacks);
            assert!(report.check.is_manifold(), "{label}");
            assert_eq!(report.check.genus(), Some(genus), "{label}");
            assert!(report.fallbacks.is_empty(), "{label}");
            assert_eq!(mesh.self_intersections(), [[0; 2]; 0], "{label}");
            let on_surface = 1e-11 * size(mesh);
            assert!(largest_miss(&program, mesh) <= on_surface, "{label}");
            let bound = report.deviation.expect("a bound");
            assert!(bound <= tolerance, "{label}: {bound}");
            let sampled = sampled_deviation(&program, &meshed);
            assert!(
                sampled <= 1.02 * bound + on_surface,
                "{label}: {sampled}, {bound}"
            );
        }
    }
}

/// Points of the boundary, from a mesh ten times as fine, are as near to the
/// mesh as promised.
#[test]
fn the_boundary_is_near_the_mesh() {
    const TOLERANCE: f64 = 1e-2;
    for (name, solid, cells, _) in scenes() {
        let program = lower(&solid);
        let coarse = mesh(&program, cells, TOLERANCE).mesh;
        let fine = mesh(&program, cells, 0.1 * TOLERANCE).mesh;
        let every = fine.positions.len().div_ceil(400);
        for &point in fine.positions.iter().step_by(every) {
            let nearest = (0..coarse.triangles.len())
                .map(|triangle| distance(point, coarse.corners(triangle)))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest <= TOLERANCE, "{name}: {nearest} at {point}");
        }
    }
}

#[test]
fn volumes_converge() {
    let scenes = [
        (scenes::sphere(), scenes::SPHERE_VOLUME, 8),
        (scenes::drilled(), scenes::DRILLED_VOLUME, 24),
        (scenes::flange(), scenes::FLANGE_VOLUME, 40),
    ];
    for (solid, volume, cells) in scenes {
        let program = lower(&solid);
        for tolerance in [1e-2, 1e-3, 1e-4] {
            let mesh = mesh(&program, cells, tolerance).mesh;
            let off = (mesh.volume() - volume).abs();
            assert!(off <= mesh.area() * tolerance, "{tolerance}: {off}");
        }
    }
}

/// Against what manifold3d makes of the same scenes with circles of n corners,
/// r (1 - cos(π / n)) from the truth.
#[test]
fn triangles_are_few() {
    let count = |solid: &Solid, cells, tolerance| {
        mesh(&lower(solid), cells, tolerance).mesh.triangles.len()
    };
    assert_eq!(count(&scenes::rotated_box(), 8, 1e-3), 12);
    assert_eq!(count(&scenes::menger(2), 30, 1e-3), 1296);
    let deviation = |n: f64| 1.0 - (PI / n).cos();
    assert!(count(&scenes::flange(), 40, deviation(64.0)) <= 2_900 * 6 / 5);
    assert!(count(&scenes::flange(), 40, deviation(256.0)) <= 11_000 * 6 / 5);
    // A cylinder is two polygons and a strip.
    let cylinder = Solid::cylinder(1.0, 0.0..3.0);
    let n = f64::from(count(&cylinder, 12, deviation(100.0)) as u32 + 4) / 4.0;
    assert!(n <= 1.2 * 100.0, "{n} corners");
}

#[test]
fn corners_stay_exact() {
    let block = scenes::rotated_box();
    let mesh = mesh(&lower(&block), 8, 0.1).mesh;
    assert!((mesh.volume() - scenes::ROTATED_BOX_VOLUME).abs() < 1e-14);
    assert_eq!(mesh.positions.len(), 8);
}

#[test]
fn an_angle_makes_more_triangles() {
    let program = lower(&Solid::cylinder(1.0, 0.0..1.0));
    let angle = 10f64.to_radians();
    let mesher = Mesher::new().cells(12).tolerance(1.0).angle(angle);
    let meshed = mesher.mesh(&program).expect("a mesh");
    // Thirty-six corners at least on both circles.
    assert!(meshed.mesh.positions.len() >= 72);
    assert!(meshed.mesh.positions.len() <= 100);
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let program = lower(&scenes::drilled());
    let meshed = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool")
            .install(|| mesh(&program, 24, 1e-3).mesh)
    };
    assert_eq!(meshed(1), meshed(3));
}

#[test]
fn options_out_of_range_are_errors() {
    let program = lower(&Solid::sphere(1.0));
    for mesher in [
        Mesher::new().tolerance(0.0),
        Mesher::new().tolerance(f64::NAN),
        Mesher::new().tolerance(0.1).angle(-1.0),
        Mesher::new().tolerance(0.1).draft(),
        // Less than coordinates are rounded by.
        Mesher::new().tolerance(1e-18),
    ] {
        assert!(matches!(
            mesher.mesh(&program),
            Err(csg::Error::InvalidOption(_))
        ));
    }
}

/// Holes that are small beside the tolerance, of which thousands cut each other.
#[test]
fn ten_thousand_holes_need_no_option() {
    const HOLES: u32 = 10_000;
    let program = lower(&scenes::cheese(HOLES));
    let Meshed { mesh, report, .. } = Mesher::new().mesh(&program).expect("a mesh");
    assert!(report.check.is_manifold(), "{}", report.check);
    assert_eq!(report.fallbacks, []);
    let bound = report.deviation.expect("a bound");
    assert!(bound <= 2e-3, "{bound}");
    let volume = scenes::cheese_volume(HOLES).expect("a known one");
    assert!((mesh.volume() - volume).abs() <= bound * mesh.area());
}

/// Without any option: whole, sound, and with nothing to report.
#[test]
fn defaults_give_a_good_mesh_of_any_model() {
    let shell = |thickness| Solid::sphere(1.0) - Solid::sphere(1.0 - thickness);
    let wire = Solid::cylinder(0.5e-3, -0.7..0.7).rotate_xyz(0.3, 0.4, 0.0);
    let mut models = vec![
        ("shell of 1e-2", shell(1e-2)),
        ("shell of 1e-4", shell(1e-4)),
        ("wire", Solid::cube(1.0) | wire),
        ("cheese", scenes::cheese(60)),
    ];
    models.extend(scenes().into_iter().map(|(name, solid, ..)| (name, solid)));
    models.extend(hard_models::all());
    for (name, solid) in models.into_iter().step_by(one_in(3)) {
        let program = lower(&solid);
        let meshed = Mesher::new().mesh(&program).expect("a mesh");
        let Meshed { mesh, report, .. } = &meshed;
        assert!(report.check.is_manifold(), "{name}: {}", report.check);
        assert_eq!(report.fallbacks, [], "{name}");
        assert_eq!(mesh.self_intersections(), [[0; 2]; 0], "{name}");
        let bounds = program.bounds().expect("bounded").expect("not empty");
        let tolerance = 1e-3 * bounds.size().max_element();
        let bound = report.deviation.expect("a bound");
        assert!(bound <= tolerance, "{name}: {bound}");
        let off = report.largest_vertex_distance;
        assert!(off <= 1e-12 * bounds.size().length(), "{name}: {off}");
        let explicit = Mesher::new().tolerance(tolerance);
        let explicit = explicit.mesh(&program);
        assert!(*mesh == explicit.expect("a mesh").mesh, "{name}");
    }
    // The wall of the finest shell is there.
    let program = lower(&shell(1e-4));
    let mesh = Mesher::new().mesh(&program).expect("a mesh").mesh;
    let volume = scenes::shell_volume(1e-4);
    assert!((mesh.volume() / volume - 1.0).abs() < 0.5);
    let nothing = lower(&(Solid::sphere(1.0) - Solid::sphere(2.0)));
    let empty = Mesher::new().mesh(&nothing).expect("an empty mesh").mesh;
    assert_eq!(empty.triangles.len(), 0);
}
