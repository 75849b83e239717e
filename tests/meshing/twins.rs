//! Surfaces that coincide but for what somebody rounded: too near to each other for a
//! wall between them, and too far apart to be the same by arithmetic alone.

use std::f64::consts::{FRAC_PI_2, PI};

use stereotomy::csg::{Meshed, Mesher, Program, Report, Solid};

const TOLERANCE: f64 = 0.01;

fn mesh(solid: &Solid) -> Meshed {
    let program = Program::lower(solid).expect("a valid solid");
    let meshed = Mesher::new().tolerance(TOLERANCE).mesh(&program);
    meshed.expect("a mesh")
}

/// A mesh with nothing to be reported but what was merged, of about a volume.
fn check(what: &str, solid: &Solid, volume: f64) {
    let Meshed { mesh, report, .. } = mesh(solid);
    assert!(report.check.is_manifold(), "{what}: {}", report.check);
    assert_eq!(report.fallbacks, [], "{what}");
    assert_eq!(report.is_proven(), report.moved.is_none(), "{what}");
    let deviation = report.deviation.expect("a bound");
    assert!(deviation <= TOLERANCE, "{what}: {deviation}");
    assert!(
        report.undecided.is_empty(),
        "{what}: {:?}",
        report.undecided
    );
    let off = (mesh.volume() - volume).abs();
    assert!(
        off < TOLERANCE * mesh.area(),
        "{what}: {} for {volume}",
        mesh.volume()
    );
    assert!(mesh.self_intersections().is_empty(), "{what}");
}

#[test]
fn twins_are_not_lost() {
    let ball = |r: f64| Solid::sphere(r);
    let whole = 4.0 / 3.0 * PI;
    for power in 10..16 {
        let by = 10f64.powi(-power);
        let far = Solid::cube(1.0).translate([5.0, 0.0, 0.0]);
        let twins = ball(1.0) | ball(1.0 - by) | far;
        check(&format!("balls by {by}"), &twins, whole + 1.0);
        let hollow = ball(1.0) - ball(0.5) - ball(0.5 + by);
        check(&format!("hollows by {by}"), &hollow, whole * 0.875);
        let half = (ball(1.0) | ball(1.0 - by))
            - Solid::cuboid([2.0, 4.0, 4.0]).translate([1.0, 0.0, 0.0]);
        check(&format!("halves by {by}"), &half, 0.5 * whole);
        let rod = |r: f64, z: f64| Solid::cylinder(r, z - 1.0..z + 1.0);
        let rods = rod(1.0, 0.0) | rod(1.0 - by, 0.5).translate([by, 0.0, 0.0]);
        check(&format!("rods by {by}"), &rods, 2.5 * PI);
    }
}

#[test]
fn faces_that_nearly_lie_in_each_other_join() {
    for power in 10..16 {
        let by = 10f64.powi(-power);
        let beside = Solid::cube(1.0).rotate_z(by).translate([1.0, 0.25, 0.125]);
        check(
            &format!("turned by {by}"),
            &(Solid::cube(1.0) | beside),
            2.0,
        );
    }
}

#[test]
fn what_is_merged_is_told() {
    let twins = Solid::sphere(1.0) | Solid::sphere(1.0 - 1e-12);
    let merged = mesh(&twins).report.moved.expect("they are merged");
    assert_eq!(merged.merged, 1);
    assert!(
        (merged.distance - 1e-12).abs() < 1e-15,
        "{}",
        merged.distance
    );
    // The same through another chain of maps is the same: nothing is merged.
    let there_and_back = Solid::cylinder(0.5, -1.0..1.0)
        .rotate_x(0.3)
        .translate([0.1, 0.2, 0.3])
        .translate([-0.1, -0.2, -0.3])
        .rotate_x(-0.3);
    let same = Solid::cylinder(0.5, -1.0..1.0) | there_and_back;
    assert_eq!(mesh(&same).report.moved, None);
}

/// Numbers that miss round ones by little, of solids that touch there.
#[test]
fn near_misses_of_contacts_are_meshed() {
    for power in 6..13 {
        let by = 10f64.powi(-power);
        let plate = Solid::cuboid([4.0, 4.0, 0.5]).translate([0.0, 0.0, -0.25]);
        let rod = Solid::cylinder(0.75, -1.25..1.25)
            .rotate_x(FRAC_PI_2 + by)
            .translate([0.0, 0.0, 0.75 - 0.7 * by]);
        let solid = plate | rod;
        let Meshed { mesh, report, .. } = mesh(&solid);
        assert!(report.check.is_manifold(), "{by}: {}", report.check);
        let volume = 8.0 + PI * 0.5625 * 2.5;
        let off = (mesh.volume() - volume).abs();
        assert!(off < TOLERANCE * mesh.area(), "{by}: {}", mesh.volume());
    }
}

/// A screw thread of convex wedges, each the hull of eight points on a helix: the end of
/// one is the begin of the next, and planes of a turn are those of the turn before, both
/// but for rounding.
#[test]
fn wedges_of_a_thread_join() {
    const STEPS: u32 = 36;
    const TURNS: u32 = 14;
    const PITCH: f64 = 0.3;
    let wedge = |step: u32| {
        let corner = |step: u32, radius: f64, z: f64| {
            let turns = f64::from(step) / f64::from(STEPS);
            let (sin, cos) = (2.0 * PI * turns).sin_cos();
            [radius * cos, radius * sin, z + PITCH * turns]
        };
        let section = [(0.9, -0.1), (0.9, 0.1), (1.2, -0.02), (1.2, 0.02)];
        let end = |step: u32| section.map(|(radius, z)| corner(step, radius, z));
        let corners = [step, step + 1].map(end).concat();
        Solid::hull(corners)
    };
    let thread = Solid::union((0..STEPS * TURNS).map(wedge));
    let Meshed { mesh, report, .. } = mesh(&thread);
    check_exact(&report);
    let one = volume_of(&wedge(0));
    let off = mesh.volume() - f64::from(STEPS * TURNS) * one;
    assert!(off.abs() < 1e-12 * mesh.volume(), "{off}");

    // Its core fills it up to a prism: what is left of each wedge is beyond that.
    let around = |step: u32| 2.0 * PI * f64::from(step) / f64::from(STEPS);
    let corners: Vec<[f64; 3]> = (0..STEPS)
        .flat_map(|step| [-1.0, 6.0].map(|z| [around(step).cos(), around(step).sin(), z]))
        .collect();
    let core = Solid::hull(corners);
    let beyond = volume_of(&(wedge(0) - &core));
    let whole = volume_of(&core) + f64::from(STEPS * TURNS) * beyond;
    let screw = thread | core;
    let Meshed { mesh, report, .. } = self::mesh(&screw);
    check_exact(&report);
    let off = mesh.volume() - whole;
    assert!(off.abs() < 1e-12 * whole, "{off}");
}

/// One body without holes, its surfaces where they are but for rounding.
fn check_exact(report: &Report) {
    assert_eq!(report.method, "polyhedral");
    assert!(report.check.is_manifold(), "{}", report.check);
    assert_eq!(
        (report.check.components, report.check.genus()),
        (1, Some(0))
    );
    assert!(
        report.fallbacks.is_empty() && report.undecided.is_empty(),
        "{report:?}"
    );
    let moved = report.moved.map_or(0.0, |moved| moved.distance);
    assert!(moved < 1e-12, "{moved}");
}

fn volume_of(solid: &Solid) -> f64 {
    mesh(solid).mesh.volume()
}
