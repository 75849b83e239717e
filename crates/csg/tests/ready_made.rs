//! Ready-made solids: volumes against closed forms, meshes closed, manifold and
//! not through themselves; sections likewise.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use csg::glam::{DAffine3, DVec3, dvec3};
use csg::{Gear, Mesher, Profile, Program, Screw, Solid};

const TOLERANCE: f64 = 2e-3;

fn program(what: &str, solid: &Solid) -> Program {
    Program::lower(solid).unwrap_or_else(|e| panic!("{what}: {e}"))
}

/// Meshes a solid and holds its volume to `volume`, exactly if it is bounded by
/// planes.
fn assert_volume(what: &str, solid: &Solid, volume: f64) {
    let meshed = Mesher::new()
        .tolerance(TOLERANCE)
        .mesh(&program(what, solid));
    let meshed = meshed.unwrap_or_else(|e| panic!("{what}: {e}"));
    let report = &meshed.report;
    assert!(report.check.is_manifold(), "{what}: {}", report.check);
    assert_eq!(report.fallbacks, [], "{what}");
    let found = meshed.mesh.volume();
    let allowed = if report.method == "polyhedral" {
        1e-12 * volume
    } else {
        meshed.mesh.area() * TOLERANCE
    };
    assert!(
        (found - volume).abs() <= allowed,
        "{what}: {found}, not {volume} (within {allowed:e})"
    );
}

/// The volume by points of Roberts' R3 sequence in a box.
fn sampled(what: &str, solid: &Solid, half: DVec3) -> f64 {
    const POINTS: u32 = 200_000;
    let steps = dvec3(
        0.819_172_513_396_164_4,
        0.671_043_606_703_789_2,
        0.549_700_477_901_970_3,
    );
    let program = program(what, solid);
    let inside = (0..POINTS).filter(|&k| {
        let share = (0.5 + f64::from(k) * steps).fract();
        program.contains(half * (2.0 * share - 1.0))
    });
    inside.count() as f64 / f64::from(POINTS) * 8.0 * half.element_product()
}

#[test]
fn bodies() {
    let (r, c) = (0.25_f64, 0.2_f64);
    let inner = dvec3(2.0, 1.5, 1.0) - 2.0 * r;
    let faces = inner.x * inner.y + inner.y * inner.z + inner.z * inner.x;
    let rounded = inner.element_product()
        + 2.0 * r * faces
        + PI * r * r * (inner.x + inner.y + inner.z)
        + 4.0 / 3.0 * PI * r.powi(3);
    let sum = 2.0 + 1.5 + 1.0;
    let chamfered = 3.0 - 2.0 * c * c * (sum - 6.0 * c) - 6.0 * c.powi(3);
    let end = PI * c / 3.0 * (1.0 + (1.0 - c) + (1.0 - c).powi(2));
    for (what, solid, volume) in [
        (
            "capsule",
            Solid::capsule(0.5, -1.0..1.0),
            0.5 * PI + PI / 6.0,
        ),
        ("tube", Solid::tube(1.0, 0.5, 0.0..2.0), 1.5 * PI),
        (
            "rounded",
            Solid::rounded_cuboid([2.0, 1.5, 1.0], r),
            rounded,
        ),
        (
            "chamfered",
            Solid::chamfered_cuboid([2.0, 1.5, 1.0], c),
            chamfered,
        ),
        (
            "chamfered cylinder",
            Solid::chamfered_cylinder(1.0, 0.0..1.0, c),
            2.0 * end + PI * (1.0 - 2.0 * c),
        ),
        ("wedge", Solid::wedge([2.0, 1.0, 3.0]), 3.0),
        (
            "pyramid",
            Solid::pyramid(5, 1.0, 0.0..3.0),
            2.5 * (TAU / 5.0).sin(),
        ),
        (
            "prism",
            Solid::regular_prism(7, 1.0, -1.0..1.0),
            7.0 * (TAU / 7.0).sin(),
        ),
    ] {
        assert_volume(what, &solid, volume);
    }
}

/// Bodies with parts of tori: chords of the same area, but many cones.
#[test]
fn round_bodies() {
    let torus = sampled("torus", &Solid::torus(1.0, 0.4), dvec3(1.4, 1.4, 0.4));
    let wanted = 2.0 * PI * PI * 0.16;
    assert!((torus / wanted - 1.0).abs() < 5e-3, "{torus}, not {wanted}");
    let rounded = Solid::rounded_cylinder(1.0, -0.5..0.5, 0.3);
    let rounded = sampled("rounded cylinder", &rounded, dvec3(1.0, 1.0, 0.5));
    // Pappus: a square less a quarter disc, at its centre's distance, at either end.
    let (square, disc) = (0.09, 0.09 * PI / 4.0);
    let moment = square * 0.85 - disc * (0.7 + 0.4 / PI);
    let wanted = PI - 2.0 * TAU * moment;
    assert!(
        (rounded / wanted - 1.0).abs() < 5e-3,
        "{rounded}, not {wanted}"
    );
}

#[test]
fn platonic_solids() {
    let root = 5f64.sqrt();
    let dodecahedron = (4.0 / (3f64.sqrt() * (1.0 + root))).powi(3) * (15.0 + 7.0 * root) / 4.0;
    let icosahedron = (TAU / 5.0).sin().powi(-3) * 5.0 * (3.0 + root) / 12.0;
    for (what, solid, volume, faces) in [
        (
            "tetrahedron",
            Solid::tetrahedron(1.0),
            8.0 * 3f64.sqrt() / 27.0,
            4,
        ),
        ("octahedron", Solid::octahedron(1.0), 4.0 / 3.0, 8),
        ("dodecahedron", Solid::dodecahedron(1.0), dodecahedron, 12),
        ("icosahedron", Solid::icosahedron(1.0), icosahedron, 20),
    ] {
        assert_volume(what, &solid, volume);
        assert_eq!(program(what, &solid).surfaces().len(), faces, "{what}");
    }
}

#[test]
fn patterns() {
    let block = Solid::cuboid_between([1.0, 0.0, 0.0], [2.0, 0.5, 0.5]);
    for (what, solid, volume) in [
        ("row", block.linear_pattern(4, [0.0, 1.0, 0.0]), 1.0),
        ("overlapping", block.linear_pattern(3, [0.5, 0.0, 0.0]), 0.5),
        ("grid", block.grid_pattern([2, 3, 2], [2.0, 1.0, 1.0]), 3.0),
        ("around", block.polar_pattern(4), 1.0),
        (
            "path",
            Solid::cube(0.5).path_pattern([[0.0; 3], [3.0, 0.0, 0.0], [3.0, 3.0, 0.0]], 7),
            7.0 * 0.125,
        ),
        ("helix", block.helical_pattern(4, 4.0, 8.0), 1.0),
    ] {
        assert_volume(what, &solid, volume);
    }
    // A corner of the path counts to the piece before it.
    let turned = Solid::cuboid([0.5, 0.1, 0.1]);
    let turned = turned.path_pattern([[0.0; 3], [3.0, 0.0, 0.0], [3.0, 3.0, 0.0]], 3);
    let p = program("path", &turned);
    assert!(p.contains([3.2, 0.0, 0.0]) && p.contains([3.0, 2.8, 0.0]));
    // Ten thousand places, one block.
    let many = block.linear_pattern(100, [0.0, 1.0, 0.0]);
    assert_eq!(
        program("many", &many.linear_pattern(100, [2.0, 0.0, 0.0]))
            .surfaces()
            .len(),
        402
    );
}

#[test]
fn holes_threads_and_grips() {
    let counterbore = PI * (0.25 * 3.0 + (1.0 - 0.25) * 1.0);
    let countersink = PI * (0.25 * 3.0 + 0.5 / 3.0 * (1.0 + 0.5 + 0.25) - 0.25 * 0.5);
    for (what, solid, volume) in [
        (
            "counterbore",
            Solid::counterbore(0.5, 3.0, 1.0, 1.0),
            counterbore,
        ),
        (
            "countersink",
            Solid::countersink(0.5, 3.0, 1.0),
            countersink,
        ),
        ("nut trap", Solid::nut_trap(2.0, 3.0), 6.0 * 3f64.sqrt()),
        ("slot", Solid::slot(2.0, 0.5, 1.0), 2.0 + 0.25 * PI),
    ] {
        assert_volume(what, &solid, volume);
    }
    let knurled = Profile::knurled(2.0, 30);
    let corners = &knurled.contours(1.0).expect("a polygon")[0];
    let [a, b, c] = [0, 1, 2].map(|k| corners[k]);
    // Right angles at the roots (the tips of tips are sharper).
    let at = if b.length() < a.length() {
        (a - b).dot(c - b)
    } else {
        (b - a).dot(corners[59] - a)
    };
    assert!(at.abs() < 1e-12);
    let root = 2.0 * ((PI / 30.0).cos() - (PI / 30.0).sin());
    let area = 30.0 * 2.0 * root * (PI / 30.0).sin();
    assert!((knurled.area(1.0).expect("an area") / area - 1.0).abs() < 1e-12);
}

#[test]
fn threads_come_near_the_area_of_iso_68() {
    assert_eq!(Screw::metric(7.5), None);
    let m8 = Screw::metric(8.0).expect("M8");
    assert_eq!(m8.pitch, 1.25);
    // The minor diameter of ISO 724.
    assert!((8.0 - 2.0 * m8.depth() - 6.647).abs() < 5e-4);
    let (crest, root) = (4.0, 4.0 - m8.depth());
    let slope = (crest * crest + crest * root + root * root) / 3.0;
    let area = PI * (crest * crest / 8.0 + root * root / 4.0 + 0.625 * slope);
    let off = [12, 24].map(|steps| {
        let rod = Solid::threaded_rod(Screw { steps, ..m8 }, 0.5 * 1.25);
        let meshed = Mesher::new().mesh(&program("rod", &rod)).expect("a mesh");
        assert!(meshed.report.check.is_manifold(), "{steps}");
        (meshed.mesh.volume() / (0.5 * 1.25 * area) - 1.0).abs()
    });
    // Chords cut off less by the square of their number.
    assert!(off[0] < 0.05 && off[1] < 0.4 * off[0], "{off:?}");
}

#[test]
fn gears_have_the_area_of_their_involutes() {
    for teeth in [8, 24, 60] {
        let gear = Gear {
            chords: 100,
            ..Gear::new(2.0, teeth)
        };
        let [root, base, tip] = gear.radii();
        assert_eq!((root, tip), (teeth as f64 - 2.5, teeth as f64 + 2.0));
        let parameter = |radius: f64| ((radius / base).powi(2) - 1.0).max(0.0).sqrt();
        let angle = |t: f64| t - t.atan();
        let half = PI / 2.0 / teeth as f64 + angle(20f64.to_radians().tan());
        let (first, last) = (parameter(root), parameter(tip));
        // ½ ∫ r² dθ over an involute, where dθ = t² / (1 + t²) dt; chords at tip and root.
        let flank = base * base * (last.powi(3) - first.powi(3)) / 6.0;
        let triangle = |radius: f64, angle: f64| 0.5 * radius * radius * angle.sin();
        let gap = TAU / teeth as f64 - 2.0 * (half - angle(first));
        let tooth = 2.0 * flank + triangle(tip, 2.0 * (half - angle(last))) + triangle(root, gap);
        let found = gear.profile().area(1.0).expect("an area");
        let wanted = teeth as f64 * tooth;
        assert!(
            (found / wanted - 1.0).abs() < 1e-5,
            "{teeth}: {found}, not {wanted}"
        );
        // On the pitch circle a tooth is as wide as a gap.
        let pitch = gear.pitch_radius();
        let width = 2.0 * (half - angle(parameter(pitch)));
        assert!((width - PI / teeth as f64).abs() < 1e-12);
    }
    for (gear, says) in [
        (Gear::new(0.0, 20), "the module is 0"),
        (Gear::new(1.0, 3), "the number of teeth is 3"),
        (
            Gear {
                pressure_degrees: 0.35,
                ..Gear::new(1.0, 20)
            },
            "from 10 to 30",
        ),
    ] {
        let error = gear.profile().area(1.0).expect_err(says).to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn mistakes_are_named_after_the_function() {
    let nan = f64::NAN;
    for (solid, says) in [
        (Solid::sphere(nan), "at sphere"),
        (Solid::infinite_cylinder(-1.0), "at infinite_cylinder"),
        (Solid::cone(nan, 0.0..1.0), "at cone"),
        (
            Solid::torus(1.0, 2.0),
            "the minor radius is 2: it must be less than 1 (at torus)",
        ),
        (Solid::capsule(nan, 0.0..1.0), "at capsule"),
        (Solid::tube(1.0, 1.0, 0.0..1.0), "at tube"),
        (Solid::rounded_cuboid([1.0; 3], 0.5), "at rounded_cuboid"),
        (
            Solid::chamfered_cuboid([1.0, 1.0, 0.0], 0.1),
            "at chamfered_cuboid",
        ),
        (Solid::wedge([1.0, nan, 1.0]), "at wedge"),
        (Solid::icosahedron(-1.0), "at icosahedron"),
        (Solid::cube(1.0).polar_pattern(0), "at polar_pattern"),
        (
            Solid::cube(1.0).path_pattern([[0.0; 3]], 3),
            "at path_pattern",
        ),
        (Solid::countersink(1.0, 0.5, 2.0), "at countersink"),
        (Solid::nut_trap(0.0, 1.0), "at nut_trap"),
        (Solid::sphere(1.0).rotate_z(90.0), "rotate_z_degrees(90.0)"),
    ] {
        let error = Program::lower(&solid)
            .err()
            .unwrap_or_else(|| panic!("{says}"))
            .to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn sections() {
    let cube = Solid::cube(2.0);
    let area = |solid: &Solid, frame: DAffine3| {
        let section = solid.section(frame, 1e-3).expect("a section");
        section.area(1e-3).expect("an area")
    };
    let at = |z: f64| DAffine3::from_translation(dvec3(0.0, 0.0, z));
    let drilled = &cube - Solid::cuboid([1.0, 1.0, 5.0]);
    let stairs = &cube - Solid::cuboid_between([0.0, -2.0, 0.0], [2.0, 2.0, 2.0]);
    let turn = DAffine3::from_quat(glam::DQuat::from_rotation_arc(
        DVec3::Z,
        DVec3::ONE.normalize(),
    ));
    for (what, solid, frame, wanted) in [
        ("middle", &cube, at(0.0), 4.0),
        ("base and top", &cube, at(-1.0), 4.0),
        ("top", &cube, at(1.0), 4.0),
        ("beside", &cube, at(1.5), 0.0),
        ("drilled", &drilled, at(0.3), 3.0),
        // A plane in which a step lies: the tread is of it.
        ("stairs", &stairs, at(0.0), 4.0),
        ("higher", &stairs, at(0.5), 2.0),
        // A regular hexagon with sides of √2.
        ("hexagon", &cube, turn, 3.0 * 3f64.sqrt()),
    ] {
        let found = area(solid, frame);
        assert!(
            (found - wanted).abs() < 1e-9,
            "{what}: {found}, not {wanted}"
        );
    }
    // What is drawn in the plane can be extruded again.
    let back = Solid::extrude(
        &drilled.section(at(0.0), 1e-3).expect("a section"),
        0.0..1.0,
    );
    assert_volume("extruded section", &back, 3.0);
    let ball = area(&Solid::sphere(1.0), at(FRAC_1_SQRT_2));
    assert!((ball - 0.5 * PI).abs() < TAU * 1e-3, "{ball}");
    assert!(Solid::space().section(at(0.0), 1e-3).is_err());
    assert!(cube.section(DAffine3::ZERO, 1e-3).is_err());
}
