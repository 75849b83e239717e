//! Adaptive cells: the topology is right at whatever size the cells come to,
//! walls thinner than a cell are two sheets, and every vertex is on the
//! surfaces that its triangles claim.

use csg::{Mesh, Meshed, Mesher, Program, Solid};
use stereotomy::{csg, scenes};

use super::defects::{largest_miss, measure, size};
use super::hard_models;
use super::measures::assert_agrees;
use super::tolerance::sampled_deviation;
use crate::random::Random;
use crate::sweeps::one_in;

fn mesh(solid: &Solid, smallest: f64) -> (Program, Meshed) {
    let program = Program::lower(solid).expect("a valid solid");
    let meshed = Mesher::new().smallest_feature(smallest).mesh(&program);
    (program, meshed.expect("a mesh"))
}

/// Handles, summed over the parts.
pub fn genus(meshed: &Meshed) -> i64 {
    let check = &meshed.report.check;
    let euler = check.vertices as i64 - check.edges as i64 + meshed.mesh.triangles.len() as i64;
    check.components as i64 - euler / 2
}

pub fn turned(solid: &Solid) -> Solid {
    solid.rotate_xyz(0.3, 0.5, 0.7)
}

fn assert_sound(name: &str, program: &Program, meshed: &Meshed) {
    let check = &meshed.report.check;
    assert!(check.is_manifold(), "{name}: {check}");
    if meshed.report.fallbacks.is_empty() && !meshed.mesh.triangles.is_empty() {
        let miss = largest_miss(program, &meshed.mesh) / size(&meshed.mesh);
        assert!(
            miss < 1e-12,
            "{name}: a vertex misses its surface by {miss:e}"
        );
    }
}

#[test]
fn reference_scenes_have_their_topology() {
    let all = [
        ("sphere", scenes::sphere(), 0, 1, None),
        ("drilled", scenes::drilled(), 5, 1, None),
        ("tricylinder", scenes::tricylinder(), 0, 1, None),
        (
            "menger 1",
            scenes::menger(1),
            5,
            1,
            Some(scenes::menger_volume(1)),
        ),
        (
            "menger 2",
            scenes::menger(2),
            81,
            1,
            Some(scenes::menger_volume(2)),
        ),
        ("rotated box", scenes::rotated_box(), 0, 1, Some(1.44)),
        ("shell", scenes::shell(0.1), 0, 2, None),
        ("flange", scenes::flange(), 9, 1, None),
    ];
    for (name, solid, handles, parts, volume) in all {
        for solid in [turned(&solid), solid] {
            let (program, meshed) = mesh(&solid, 1e-3);
            assert_sound(name, &program, &meshed);
            assert_eq!(genus(&meshed), handles, "{name}");
            assert_eq!(meshed.report.check.components, parts, "{name}");
            if let Some(volume) = volume {
                let error = meshed.mesh.volume() / volume - 1.0;
                assert!(error.abs() < 1e-12, "{name}: {error:e}");
            }
        }
    }
}

/// The signed volumes of a mesh's parts, ascending.
fn volumes(mesh: &Mesh) -> Vec<f64> {
    let parts = mesh.components();
    let mut volumes = vec![0.0; parts.count];
    for (triangle, part) in parts.of_triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle);
        volumes[part.expect("a usable triangle") as usize] += a.dot(b.cross(c)) / 6.0;
    }
    volumes.sort_by(f64::total_cmp);
    volumes
}

/// With a small ball aside: solids of planes alone are meshed without cells.
fn beside_a_ball(solid: &Solid) -> Solid {
    solid | Solid::sphere(0.1).translate([0.0, -1.5, 0.0])
}

/// Cells in a row may each see both planes of a wedge whose ridge lies outside
/// of them all: where there is nothing to report, the ridge is where it should
/// be and nowhere else.
#[test]
fn wedges_are_exact_or_reported_whatever_the_cells() {
    let mut exact = 0;
    let mut reported = Vec::new();
    for degrees in [30f64, 10.0, 3.0, 1.0] {
        let height = degrees.to_radians().tan();
        let wedge = Solid::prism([[0.0, 0.0], [1.0, 0.0], [1.0, height]], 0.0..0.7);
        let volume = 0.35 * height;
        for wedge in [turned(&wedge), wedge] {
            let solid = beside_a_ball(&wedge);
            let program = Program::lower(&solid).expect("a valid solid");
            for size in [0.1f64, 0.03, 1e-2, 3e-3, 1e-3] {
                let cells = Mesher::new().cell_size(size.max(0.01));
                for mesher in [Mesher::new().smallest_feature(size), cells] {
                    let meshed = mesher.mesh(&program).expect("a mesh");
                    let name = format!("{degrees} degrees, {} of {size}", meshed.report.method);
                    assert_sound(&name, &program, &meshed);
                    if let Some(first) = meshed.report.fallbacks.first() {
                        reported.push(format!("{name}: {first}"));
                        continue;
                    }
                    exact += 1;
                    let volumes = volumes(&meshed.mesh);
                    let off = volumes.iter().map(|v| (v / volume - 1.0).abs());
                    let off = off.fold(f64::INFINITY, f64::min);
                    assert!(volumes.len() == 2 && off < 1e-11, "{name}: {volumes:?}");
                    assert_eq!(genus(&meshed), 0, "{name}");
                    let defects = measure(&program, &meshed.mesh);
                    assert_eq!(defects.folded, 0, "{name}: {:?}", defects.places);
                    assert_eq!(meshed.mesh.self_intersections().len(), 0, "{name}");
                }
            }
        }
    }
    // Most have something to report next to the ridge.
    assert!(exact >= 16, "{exact}\n{}", reported.join("\n"));
}

#[test]
fn walls_thinner_than_any_cell_are_two_sheets() {
    for thickness in [1e-2, 1e-4, 1e-6] {
        let solid = Solid::sphere(1.0) - Solid::sphere(1.0 - thickness);
        let (program, meshed) = mesh(&solid, 0.01);
        assert_sound("shell", &program, &meshed);
        assert_eq!(meshed.report.check.components, 2, "{thickness}");
        // Both are the same mesh but for their radii.
        let [inner, outer] = volumes(&meshed.mesh)[..] else {
            panic!("two parts");
        };
        let ratio = (-inner / outer).cbrt();
        assert!(
            (ratio - (1.0 - thickness)).abs() < 0.02 * thickness,
            "{thickness}: {ratio}"
        );

        let solid = turned(&(Solid::cube(1.0) - Solid::cube(1.0 - 2.0 * thickness)));
        let (program, meshed) = mesh(&beside_a_ball(&solid), 0.01);
        assert_sound("box", &program, &meshed);
        assert_eq!(
            meshed.report.check.components, 3,
            "{thickness}: {:?}",
            meshed.report.fallbacks
        );
        let [inner, _, outer] = volumes(&meshed.mesh)[..] else {
            panic!("three parts");
        };
        let volume = 1.0 - (1.0 - 2.0 * thickness).powi(3);
        assert!((outer + inner - volume).abs() < 1e-14, "{thickness}");
    }
}

#[test]
fn wires_slots_and_pin_holes_are_found() {
    let wire = Solid::cylinder(0.5e-3, -0.7..0.7).rotate_xyz(0.3, 0.4, 0.0);
    let (program, meshed) = mesh(&(Solid::cube(1.0) | wire), 1e-4);
    assert_sound("wire", &program, &meshed);
    assert_eq!(meshed.report.check.components, 1);
    let (low, high) = meshed.mesh.bounds().expect("a box");
    assert!(
        (high - low).max_element() > 1.2,
        "the wire's ends stick out"
    );

    let slot = Solid::cuboid([1e-4, 3.0, 3.0]).translate([0.123, 0.0, 0.0]);
    let (program, meshed) = mesh(&beside_a_ball(&(Solid::cube(1.0) - slot)), 1e-3);
    assert_sound("slot", &program, &meshed);
    let [_, left, right] = volumes(&meshed.mesh)[..] else {
        panic!("three parts");
    };
    assert!((left + right - (1.0 - 1e-4)).abs() < 1e-14);

    let mut random = Random::new(1);
    let holes = 60;
    let pins = (0..holes).map(|i| {
        let jitter = 0.1 * random.unit();
        let place = [f64::from(i % 10), f64::from(i / 10), 0.0].map(|k| 0.09 * (k + jitter) - 0.42);
        Solid::cylinder(0.5e-3, -1.0..1.0).translate(place)
    });
    let plate = Solid::cuboid([1.0, 1.0, 0.01]) - Solid::union(pins.collect::<Vec<_>>());
    let (program, meshed) = mesh(&plate, 1e-4);
    assert_sound("plate", &program, &meshed);
    assert_eq!(genus(&meshed), i64::from(holes));
}

#[test]
fn hard_models_are_manifold_in_every_pose() {
    let models = hard_models::all();
    let cases = models.flat_map(|(name, solid)| [(name, turned(&solid)), (name, solid)]);
    for (name, solid) in cases.step_by(one_in(3)) {
        let (program, meshed) = mesh(&solid, 4e-3);
        assert_sound(name, &program, &meshed);
    }
}

#[test]
fn random_solids_are_manifold() {
    for seed in (0..120).step_by(one_in(5)) {
        let solid = Random::new(seed).solid();
        let (program, meshed) = mesh(&solid, 0.02);
        assert_sound(&format!("seed {seed}"), &program, &meshed);
    }
}

/// The mesh and the program agree on what is inside; refinement of cells leaves
/// their topology as it is; and where nothing is reported the deviation is
/// within its bound and the mesh does not run through itself.
#[test]
fn random_solids_keep_a_tolerance_or_say_so() {
    const TOLERANCE: f64 = 0.01;
    let step = one_in(3);
    let mut proven = 0;
    for seed in (0..40).step_by(step) {
        let (program, coarse) = mesh(&Random::new(seed).solid(), TOLERANCE);
        let meshed = Mesher::new().tolerance(TOLERANCE).mesh(&program);
        let meshed = meshed.expect("a mesh");
        let label = format!("seed {seed}: {:?}", meshed.report.fallbacks);
        assert!(meshed.report.check.is_manifold(), "{label}");
        if meshed.report.method == "adaptive" {
            assert_eq!(genus(&meshed), genus(&coarse), "{label}");
            let parts = |meshed: &Meshed| meshed.report.check.components;
            assert_eq!(parts(&meshed), parts(&coarse), "{label}");
        }
        if meshed.report.fallbacks.is_empty() {
            let random = &mut Random::new(seed);
            assert_agrees(&program, &meshed.mesh, TOLERANCE, random, &label);
            proven += 1;
            let bound = meshed.report.deviation.unwrap_or(0.0);
            let sampled = sampled_deviation(&program, &meshed);
            assert!(bound <= TOLERANCE, "{label}: {bound}");
            assert!(
                sampled <= 1.05 * bound + 1e-10,
                "{label}: {sampled}, {bound}"
            );
            assert_eq!(meshed.mesh.self_intersections().len(), 0, "{label}");
        }
    }
    assert!(proven * step >= 15, "{proven} solids");
}

#[test]
fn a_tolerance_is_kept_with_few_triangles() {
    // Name, solid, tolerance, the most triangles, exact volume, area.
    let all = [
        ("rotated box", scenes::rotated_box(), 1e-3, 12, 1.44),
        (
            "menger 2",
            scenes::menger(2),
            1e-3,
            1296,
            scenes::menger_volume(2),
        ),
        (
            "thin box",
            turned(&(Solid::cube(1.0) - Solid::cube(1.0 - 2e-6))),
            1e-3,
            24,
            5.999988e-6,
        ),
        (
            "drilled",
            scenes::drilled(),
            1e-3,
            6000,
            scenes::DRILLED_VOLUME,
        ),
        (
            "sphere",
            scenes::sphere(),
            1e-4,
            75_000,
            scenes::SPHERE_VOLUME,
        ),
        // Its curves cross in six points, where its surfaces touch.
        (
            "tricylinder",
            scenes::tricylinder(),
            1e-3,
            500,
            scenes::TRICYLINDER_VOLUME,
        ),
        (
            "tricylinder",
            scenes::tricylinder(),
            1e-5,
            4_500,
            scenes::TRICYLINDER_VOLUME,
        ),
    ];
    for (name, solid, tolerance, most, volume) in all {
        let program = Program::lower(&solid).expect("a valid solid");
        let mesher = Mesher::new().tolerance(tolerance);
        let meshed = mesher.mesh(&program).expect("a mesh");
        assert_sound(name, &program, &meshed);
        assert_eq!(meshed.report.fallbacks, [], "{name}");
        let deviation = meshed.report.deviation.expect("a bound");
        assert!(deviation <= tolerance, "{name}: {deviation:e}");
        let mesh = &meshed.mesh;
        assert!(
            mesh.triangles.len() <= most,
            "{name}: {}",
            mesh.triangles.len()
        );
        assert_eq!(mesh.self_intersections().len(), 0, "{name}");
        let error = (mesh.volume() - volume).abs();
        assert!(
            error <= 1e-14 + deviation * mesh.area(),
            "{name}: {error:e}"
        );
    }
}
