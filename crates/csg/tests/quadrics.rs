//! Quadrics by their coefficients: those whose centres, apexes or vertices are far from what is kept
//! of them, and cylinders over parabolas and hyperbolas.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use crate::measured::measured;
use crate::random::Random;
use crate::sweeps::one_in;
use csg::glam::{DMat3, DQuat, DVec3, EulerRot, dvec3};
use csg::{BoundaryOptions, Mesher, Program, Solid};

/// The coefficients of Σ squares + Σ linear + constant, turned and moved.
fn turned(squares: DVec3, linear: DVec3, constant: f64, (turn, by): (DMat3, DVec3)) -> [f64; 10] {
    let form = turn * DMat3::from_diagonal(squares) * turn.transpose();
    let (along, moved) = (turn * linear, form * by);
    let rest = along - 2.0 * moved;
    [
        form.x_axis.x,
        form.y_axis.y,
        form.z_axis.z,
        2.0 * form.x_axis.y,
        2.0 * form.y_axis.z,
        2.0 * form.z_axis.x,
        rest.x,
        rest.y,
        rest.z,
        constant - along.dot(by) + by.dot(moved),
    ]
}

#[track_caller]
fn assert_volume(what: &str, solid: &Solid, truth: f64) {
    let found = measured(what, solid);
    let off = (found.value - truth).abs();
    assert!(
        off <= found.error.max(1e-12 * truth),
        "{what}: {found:?} for {truth}"
    );
}

fn poses() -> [(DMat3, DVec3); 2] {
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, 0.5, 0.7);
    [
        (DMat3::IDENTITY, DVec3::ZERO),
        (DMat3::from_quat(turn), dvec3(1.0, 2.0, 3.0)),
    ]
}

fn placed(solid: &Solid, (turn, by): (DMat3, DVec3)) -> Solid {
    solid.rotate_by(DQuat::from_mat3(&turn)).translate(by)
}

#[test]
fn digits_are_kept_however_far_the_centre_is() {
    let block = Solid::cuboid([20.0, 20.0, 10.0]).translate([0.0, 0.0, 5.0]);
    for exponent in 3..25 {
        let s = 0.3 * 10.0_f64.powf(-0.4 * f64::from(exponent));
        let square = s * s;
        let flat = dvec3(1.0, 1.0, 0.0);
        let (x, z) = (DVec3::X, DVec3::Z);
        // Between z = 0 and 10, and 10 from the axis.
        let round = |slope: f64, bend: f64| PI * (10.0 + 50.0 * slope + bend * 1000.0 / 3.0);
        let sheets = {
            let root = s.sqrt();
            let half = 5.0 * (1.0 + 100.0 * s).sqrt() + 0.5 * (10.0 * root).asinh() / root;
            40.0 * half
        };
        let cases = [
            (
                "a cone",
                flat - square * z,
                -2.0 * s * z,
                -1.0,
                round(2.0 * s, square),
            ),
            ("a paraboloid", flat, -s * z, -1.0, round(s, 0.0)),
            (
                "one sheet",
                flat - square * z,
                DVec3::ZERO,
                -1.0,
                round(0.0, square),
            ),
            (
                "one sheet, far",
                flat - square * z,
                -s * z,
                -1.0,
                round(s, square),
            ),
            (
                "a spheroid",
                flat + square * z,
                -square * z,
                -1.0,
                round(square, -square),
            ),
            (
                "a spheroid, far",
                flat + square * z,
                -s * z,
                -1.0,
                round(s, -square),
            ),
            (
                "a flat bowl",
                0.1 * s * flat,
                z,
                -5.0,
                2000.0 - 8000.0 / 3.0 * s,
            ),
            ("a trough", 0.1 * s * x, z, -5.0, 2000.0 - 4000.0 / 3.0 * s),
            ("a saddle", 0.1 * s * (x - DVec3::Y), z, -5.0, 2000.0),
            ("two sheets", DVec3::Y - s * x, DVec3::ZERO, -1.0, sheets),
            ("two planes", DVec3::Y, DVec3::ZERO, -1.0, 400.0),
        ];
        for (what, squares, linear, constant, truth) in cases {
            for pose in poses() {
                let quadric = Solid::quadric(turned(squares, linear, constant, pose));
                let what = format!("{what} of {s:e}");
                assert_volume(&what, &(quadric & placed(&block, pose)), truth);
            }
        }
    }
}

#[test]
fn primitives_with_far_apexes_and_centres_are_exact() {
    let half = Solid::cuboid([20.0, 20.0, 10.0]).translate([10.0, 0.0, 5.0]);
    let behind = Solid::half_space(-DVec3::Z, 0.0);
    for exponent in 3..25 {
        let s = 0.3 * 10.0_f64.powf(-0.4 * f64::from(exponent));
        let (top, radius) = (1.0 + 10.0 * s, 1.0 / s);
        let frustum = Solid::frustum(1.0, top, 0.0..10.0) & &half;
        let cap = Solid::sphere(radius).translate([0.0, 0.0, 1.0 - radius]) & &behind;
        for pose in poses() {
            let what = format!("of {s:e}");
            let truth = 0.5 * PI * 10.0 / 3.0 * (1.0 + top + top * top);
            assert_volume(&format!("a frustum {what}"), &placed(&frustum, pose), truth);
            let truth = PI * (radius - 1.0 / 3.0);
            assert_volume(&format!("a cap {what}"), &placed(&cap, pose), truth);
        }
    }
}

/// What is cut off of them and what is left make up the whole, and so do their meshes.
#[test]
fn cylinders_over_parabolas_and_hyperbolas_are_cut_exactly() {
    let mut random = Random(5);
    let block = Solid::cuboid([4.0; 3]);
    for case in (0..120).step_by(one_in(7)) {
        let mut number = |low: f64, high: f64| low + (high - low) * random.unit();
        let (a, b) = (number(0.3, 2.0), number(0.3, 2.0));
        let quadric = |xx: f64, zz: f64, z: f64, constant: f64| {
            Solid::quadric([xx, 0.0, zz, 0.0, 0.0, 0.0, 0.0, 0.0, z, constant])
        };
        let one = match case % 4 {
            0 => quadric(a, 0.0, 1.0, -1.0),
            1 => quadric(a, -b, 0.0, -0.5),
            2 => quadric(a, -b, 0.0, 0.5),
            _ => quadric(-a, 0.0, 0.0, 0.3),
        };
        let other = match case / 4 % 4 {
            0 => Solid::sphere(1.5),
            1 => Solid::cylinder(0.8, -3.0..3.0),
            2 => Solid::ellipsoid([1.8, 1.2, 0.9]) - Solid::sphere(0.7),
            _ => Solid::cuboid([1.8; 3]),
        };
        let mut pose = |solid: Solid| {
            let turned = solid.rotate_xyz(number(0.0, 6.0), number(0.0, 6.0), number(0.0, 6.0));
            turned.translate([number(-1.0, 1.0), number(-1.0, 1.0), number(-1.0, 1.0)])
        };
        let (one, other) = (pose(one) & &block, pose(other));
        let what = format!("case {case}");
        let rest = &one - &other;
        let [whole, off, left] = [&one, &(&one & &other), &rest].map(|s| measured(&what, s));
        let within = (whole.error + off.error + left.error).max(1e-11);
        let difference = (whole.value - off.value - left.value).abs();
        assert!(difference <= within, "{what}: {difference} beyond {within}");
        let program = Program::lower(&rest).expect("valid");
        let meshed = Mesher::new().tolerance(0.02).mesh(&program);
        let meshed = meshed.unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_eq!(meshed.report.undecided, [], "{what}");
        assert!(meshed.report.check.is_manifold(), "{what}");
        let difference = (meshed.mesh.volume() - left.value).abs();
        assert!(difference <= 0.02 * meshed.mesh.area(), "{what}");
    }
}

/// A cone whose apex is as far as that from another surface: volumes change with the distance as
/// evenly near nothing as farther off.
#[test]
fn apexes_beside_surfaces_are_as_far_off_as_they_are() {
    let cone = Solid::cone(0.25, -1.75..0.0).rotate_y(FRAC_PI_2);
    // All touch the plane z = 0 at the origin from above.
    let others: [(&str, Solid); 5] = [
        (
            "cylinder along",
            Solid::cylinder(1.25, -0.25..0.25).rotate_y(FRAC_PI_2),
        ),
        (
            "cylinder across",
            Solid::cylinder(1.25, -1.0..1.0).rotate_x(FRAC_PI_2),
        ),
        ("ball", Solid::sphere(1.25)),
        ("ellipsoid", Solid::ellipsoid([0.8, 0.6, 1.25])),
        (
            "cone",
            Solid::cone(2.0, -2.75..1.25)
                .rotate_x(FRAC_PI_2 + 0.5f64.atan())
                .rotate_z(0.4),
        ),
    ];
    // Of that cone the side is at the distance that its axis has from there.
    let below = [1.25, 1.25, 1.25, 1.25, 1.25 / 5f64.sqrt() * 2.0];
    for ((what, other), below) in others.iter().zip(below) {
        for pose in poses() {
            let volume = |off: f64, is_swapped: bool| {
                let other = other.translate([0.0, 0.0, below + off]);
                let [a, b] = [&cone, &other].map(|s| placed(s, pose));
                let solid = if is_swapped { b & a } else { a & b };
                let found = measured(what, &solid);
                assert!(found.error < 1e-10, "{what} {off:e}: {found:?}");
                found.value
            };
            let on = volume(0.0, false);
            let slope = (volume(1e-4, false) - volume(-1e-4, false)) / 2e-4;
            for power in 5..9 {
                for off in [10f64.powi(-power), -(10f64.powi(-power))] {
                    for is_swapped in [false, true] {
                        let found = volume(off, is_swapped);
                        let wanted = on + off * slope;
                        let most = 3e-3 * off.abs() + 1e-12;
                        let is_near = (found - wanted).abs() < most;
                        assert!(is_near, "{what} {off:e}: {found}, not {wanted} ({on})");
                    }
                }
            }
        }
    }
}

/// Cones the sum of whose half angles is the angle between their axes, as of countersinks at right angles,
/// touch each other at infinity, wherever they are.
#[test]
fn cones_that_touch_at_infinity_add_up() {
    let mut random = Random(5);
    for case in (0..240).step_by(one_in(5)) {
        let mut number = |low: f64, high: f64| low + (high - low) * random.unit();
        let half = [FRAC_PI_4, FRAC_PI_4, number(0.3, 1.0)][case % 3];
        let height = number(0.8, 1.5);
        let a = Solid::cone(half.tan() * height, -height..0.0);
        let other = FRAC_PI_2 - half;
        let radius = other.tan() * height;
        let b = Solid::cone(radius, -height..0.0).rotate_x(FRAC_PI_2);
        // On a grid in every other case.
        let step = [0.0, 0.25][case % 2];
        let b = b.translate([(); 3].map(|()| match number(-0.5, 0.5) {
            off if step > 0.0 => (off / step).round() * step,
            off => off,
        }));
        let [of_a, of_b] = [half, other].map(|angle| {
            let radius = angle.tan() * height;
            PI / 3.0 * radius * radius * height
        });
        let sixth = (DMat3::from_rotation_z(PI / 3.0), DVec3::ZERO);
        for pose in poses().into_iter().chain([sixth]) {
            let [a, b] = [&a, &b].map(|solid| placed(solid, pose));
            let [both, common] = [&a | &b, &a & &b].map(|solid| {
                let program = Program::lower(&solid).expect("valid");
                let boundary = program.boundary(&BoundaryOptions::new());
                let boundary = boundary.unwrap_or_else(|e| panic!("{case}: {e}"));
                assert_eq!(boundary.moved(), None, "{case}");
                boundary.measure().volume
            });
            let off = (both.value + common.value - of_a - of_b).abs();
            let error = both.error + common.error;
            assert!(error < 1e-12 * (of_a + of_b), "{case}: {both:?} {common:?}");
            assert!(off <= error, "{case}: {off:e} of {error:e}");
            let program = Program::lower(&(a - b)).expect("valid");
            let meshed = Mesher::new()
                .tolerance(0.01)
                .mesh(&program)
                .expect("a mesh");
            let report = &meshed.report;
            assert!(report.is_proven() && report.moved.is_none(), "{case}");
            assert_eq!(meshed.mesh.self_intersections().len(), 0, "{case}");
        }
    }
}
