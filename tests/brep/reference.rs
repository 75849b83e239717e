//! Solids whose measures are known.

use std::f64::consts::{PI, TAU};

use csg::brep::Bounded;
use csg::{Program, Solid};
use stereotomy::{csg, scenes};

use super::boundary;
use super::sound::assert_sound;
use crate::sweeps::one_in;

/// The truth is within the bound, and the bound tells more than ten digits.
fn assert_known(found: Bounded, wanted: f64, name: &str) {
    let off = (found.value - wanted).abs();
    assert!(
        off <= found.error,
        "{name}: {found:?} in place of {wanted}, off {off:e}"
    );
    assert!(
        found.error <= 1e-10 * wanted.abs().max(1.0),
        "{name}: {found:?}"
    );
}

#[test]
fn reference_scenes_have_their_volumes_and_handles() {
    let cases = [
        ("S1", scenes::sphere(), scenes::SPHERE_VOLUME, vec![0]),
        ("S2", scenes::drilled(), scenes::DRILLED_VOLUME, vec![5]),
        (
            "S3",
            scenes::tricylinder(),
            scenes::TRICYLINDER_VOLUME,
            vec![0],
        ),
        ("S4-1", scenes::menger(1), scenes::menger_volume(1), vec![5]),
        (
            "S4-2",
            scenes::menger(2),
            scenes::menger_volume(2),
            vec![81],
        ),
        // By slices: the area of the union of discs, along their arcs, between all heights at
        // which the arcs change, to fourteen digits (the constant has nine).
        ("S5-100", scenes::cheese(100), 7.829_200_306_932_09, vec![]),
        (
            "S5-1000",
            scenes::cheese(1000),
            7.824_957_970_611_14,
            vec![],
        ),
        (
            "S6",
            scenes::rotated_box(),
            scenes::ROTATED_BOX_VOLUME,
            vec![0],
        ),
        (
            "S7-1e-2",
            scenes::shell(1e-2),
            scenes::shell_volume(1e-2),
            vec![0, 0],
        ),
        (
            "S7-1e-3",
            scenes::shell(1e-3),
            scenes::shell_volume(1e-3),
            vec![0, 0],
        ),
        (
            "S7-1e-4",
            scenes::shell(1e-4),
            scenes::shell_volume(1e-4),
            vec![0, 0],
        ),
        ("S8", scenes::flange(), scenes::FLANGE_VOLUME, vec![9]),
    ];
    for (name, solid, volume, genus) in cases {
        let brep = boundary(&solid).expect("a boundary");
        let found: Vec<usize> = brep.shells().map(|shell| shell.genus()).collect();
        assert!(found == genus || genus.is_empty(), "{name}: {found:?}");
        assert_known(brep.measure().volume, volume, name);
        let program = Program::lower(&solid).expect("valid");
        assert_eq!(assert_sound(&brep, &program, name), 0.0, "{name}");
    }
}

#[test]
fn primitives_have_their_measures() {
    let ellipse_area = PI * 0.7 * 0.4;
    // (solid, volume, area, the second moment about the x axis through the centroid)
    let (r, h) = (0.8, 1.5);
    let slant = f64::hypot(r, h);
    let cases = [
        (
            "ball",
            Solid::sphere(r),
            4.0 / 3.0 * PI * r.powi(3),
            4.0 * PI * r * r,
        ),
        (
            "cylinder",
            Solid::cylinder(r, 0.0..h),
            PI * r * r * h,
            TAU * r * (r + h),
        ),
        (
            "cone",
            Solid::cone(r, 0.0..h),
            PI * r * r * h / 3.0,
            PI * r * (r + slant),
        ),
        (
            "frustum",
            Solid::frustum(0.8, 0.3, 0.0..h),
            PI * h / 3.0 * (0.64 + 0.24 + 0.09),
            PI * (0.64 + 0.09 + 1.1 * f64::hypot(0.5, h)),
        ),
        ("box", Solid::cuboid([1.0, 2.0, 3.0]), 6.0, 22.0),
    ];
    for (name, solid, volume, area) in &cases {
        for (pose, turned) in [
            ("home", solid.clone()),
            (
                "turned",
                solid.rotate_xyz(0.3, 1.1, -0.7).translate([3.0, -2.0, 1.0]),
            ),
        ] {
            let measure = boundary(&turned).expect("a boundary").measure();
            let name = format!("{name} {pose}");
            assert_known(measure.volume, *volume, &name);
            assert_known(measure.area, *area, &name);
        }
    }
    let ellipsoid = boundary(&Solid::ellipsoid([0.7, 0.4, 1.3])).expect("a boundary");
    assert_known(
        ellipsoid.measure().volume,
        4.0 / 3.0 * ellipse_area * 1.3,
        "ellipsoid",
    );
    let rod = boundary(&Solid::elliptic_cylinder([0.7, 0.4], -1.0..1.5)).expect("a boundary");
    assert_known(
        rod.measure().volume,
        2.5 * ellipse_area,
        "elliptic cylinder",
    );
}

/// Steinmetz: two crossing cylinders, 16 r³ / 3 and 16 r²; and unequal ones by an integral.
#[test]
fn crossing_cylinders_have_their_measures() {
    let rod = |radius: f64| Solid::cylinder(radius, -3.0..3.0);
    let cross = rod(1.0) & rod(1.0).rotate_x(0.5 * PI);
    let measure = boundary(&cross).expect("a boundary").measure();
    assert_known(measure.volume, 16.0 / 3.0, "equal");
    assert_known(measure.area, 16.0, "equal");
    // Of radii 1 and b: 8 ∫ √(1 - x²) √(b² - x²) dx from 0 to b, x = b sin u, by the
    // trapezoidal rule, which converges geometrically for a periodic function.
    for b in [0.3, 0.7, 0.95] {
        let cross = rod(1.0) & rod(b).rotate_x(0.5 * PI);
        let steps = 2000;
        let terms = (0..steps).map(|k| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(steps)).sin_cos();
            (1.0 - (b * sin).powi(2)).sqrt() * (b * cos).powi(2)
        });
        let volume = 8.0 * 0.25 * TAU * terms.sum::<f64>() / f64::from(steps);
        let found = boundary(&cross).expect("a boundary").measure();
        assert_known(found.volume, volume, &format!("{b}"));
    }
}

/// Of radii 5 and a little more, at right angles: 4 ∫ √(a² - x²) √(b² - x²) dx, x = a sin u, whose
/// two curves nearly meet in two points, where they turn within √(2 (b - a) / a).
#[test]
fn crossing_cylinders_of_nearly_one_radius_have_their_measures_however_they_are_turned() {
    const RADIUS: f64 = 5.0;
    const MOST: u32 = 40;
    let step = one_in(7);
    for power in 2..=8 {
        let other = RADIUS + 10f64.powi(-power);
        // The trapezoidal rule in s, u = π/2 tanh s: steps far below those in which it turns.
        let steps = 4000;
        let terms = (-steps..=steps).map(|k| {
            let s = 12.0 * f64::from(k) / f64::from(steps);
            let du = 0.5 * PI / s.cosh().powi(2);
            // cos u, with all its digits where that is nearly 0.
            let left = PI / (1.0 + (2.0 * s.abs()).exp());
            let cos = left.sin();
            du * cos * cos * height(RADIUS * cos, RADIUS, other)
        });
        let volume = 4.0 * RADIUS * RADIUS * terms.sum::<f64>() * 12.0 / f64::from(steps);
        for k in (0..MOST).step_by(step) {
            let angle = |n: u32| (f64::from(3 * k + n) * 0.7346).rem_euclid(TAU);
            let rod = |radius: f64| Solid::cylinder(radius, -12.0..12.0);
            let cross = rod(RADIUS) & rod(other).rotate_x(0.5 * PI);
            let turned = cross
                .rotate_x(angle(1))
                .rotate_y(angle(2))
                .rotate_z(angle(3));
            let brep = boundary(&turned).expect("a boundary");
            let name = format!("1e-{power}, turned {k}");
            assert_eq!((brep.moved(), brep.edges().len()), (None, 2), "{name}");
            let found = brep.measure().volume;
            let off = (found.value - volume).abs();
            assert!(
                off <= found.error + 1e-11 * volume,
                "{name}: {found:?} for {volume}"
            );
            assert!(found.error <= 1e-7, "{name}: {found:?}");
        }
    }
}

/// √(b² - a² sin² u), by a cos u: exact where a and b are nearly the same.
fn height(cosine: f64, a: f64, b: f64) -> f64 {
    (cosine * cosine + (b - a) * (b + a)).sqrt()
}

/// What is left of a solid less itself, moved by so little that no double tells: surfaces are made
/// one, and what was between them is within the bound.
#[test]
fn what_is_lost_between_surfaces_is_within_the_bound() {
    let parts = [
        Solid::sphere(5.0),
        Solid::cylinder(5.0, -4.0..4.0),
        Solid::cube(10.0),
    ];
    for (k, solid) in parts.into_iter().enumerate() {
        for power in 9..=13 {
            let by = 10f64.powi(-power);
            let rest = solid.clone() - solid.translate([-by, 0.0, 0.0]);
            let brep = boundary(&rest).expect("a boundary");
            let found = brep.measure().volume;
            // The area that is seen along the way, times that.
            let volume = [25.0 * PI, 80.0, 100.0][k] * by;
            let off = (found.value - volume).abs();
            assert!(off <= found.error, "{k} {by}: {found:?} for {volume}");
        }
    }
}

#[test]
fn centroids_and_moments_are_those_of_the_formulas() {
    let (r, h) = (0.8, 1.5);
    let volume = PI * r * r * h / 3.0;
    let place = glam::DVec3::new(10.0, -20.0, 30.0);
    let cone = Solid::cone(r, 0.0..h).translate(place);
    let measure = boundary(&cone).expect("a boundary").measure();
    let [x, y, z] = measure.centroid.expect("something");
    assert_known(x, place.x, "x");
    assert_known(y, place.y, "y");
    assert_known(z, place.z + 0.25 * h, "z");
    let along = 3.0 / 80.0 * volume * h * h;
    let across = 3.0 / 20.0 * volume * r * r;
    let wanted = glam::DMat3::from_diagonal(glam::DVec3::new(across, across, along));
    let off = (measure.second_moments - wanted).to_cols_array();
    let off = off.into_iter().map(f64::abs).fold(0.0, f64::max);
    assert!(off <= measure.second_moments_error, "{off:e} {measure:?}");
    assert!(measure.second_moments_error < 1e-10, "{measure:?}");
    let inertia = measure.inertia();
    assert!((inertia.z_axis.z - 2.0 * across).abs() < 1e-12);
    assert!((inertia.x_axis.x - across - along).abs() < 1e-12);
}

/// Outermost points on faces, edges, vertices and an apex.
#[test]
fn boxes_are_those_of_the_formulas() {
    let assert_box = |solid: &Solid, low: [f64; 3], high: [f64; 3], name: &str| {
        let bounds = boundary(solid)
            .expect("a boundary")
            .bounds()
            .expect("a box");
        let off = (bounds.min - glam::DVec3::from(low)).abs();
        let off = off.max((bounds.max - glam::DVec3::from(high)).abs());
        assert!(off.max_element() < 1e-13, "{name}: {bounds:?}");
    };
    let ball = Solid::sphere(1.0);
    assert_box(&ball, [-1.0; 3], [1.0; 3], "ball");
    let upper = &ball & Solid::half_space([0.0, 0.0, -1.0], -0.6);
    assert_box(&upper, [-0.8, -0.8, 0.6], [0.8, 0.8, 1.0], "cap");
    let lower = &ball & Solid::half_space([0.0, 0.0, 1.0], 0.6);
    assert_box(
        &lower,
        [-1.0, -1.0, -1.0],
        [1.0, 1.0, 0.6],
        "ball without its cap",
    );
    let cone = Solid::cone(1.0, 0.0..2.0);
    assert_box(&cone, [-1.0, -1.0, 0.0], [1.0, 1.0, 2.0], "cone");
    let moved = cone.translate([10.0, 20.0, -30.0]);
    assert_box(&moved, [9.0, 19.0, -30.0], [11.0, 21.0, -28.0], "moved");
    // A turned ellipsoid: the roots of the diagonal of R diag(a²) Rᵀ.
    let turned = Solid::ellipsoid([1.0, 2.0, 3.0]).rotate_xyz(0.3, 0.4, 0.5);
    let turn = glam::DMat3::from_rotation_z(0.5)
        * glam::DMat3::from_rotation_y(0.4)
        * glam::DMat3::from_rotation_x(0.3);
    let squares =
        turn * glam::DMat3::from_diagonal(glam::DVec3::new(1.0, 4.0, 9.0)) * turn.transpose();
    let half = [0, 1, 2].map(|k| squares.col(k)[k].sqrt());
    assert_box(&turned, half.map(|h| -h), half, "ellipsoid");
    // A rod that lies askew, whose ends are discs: their seams are anywhere.
    for k in 0..40 {
        let (r, h, angle) = (0.7, 2.0, 0.1 * f64::from(k) + 0.03);
        let rod = Solid::cylinder(r, -h..h).rotate_x(angle);
        let [y, z] = [
            h * angle.sin().abs() + r * angle.cos().abs(),
            h * angle.cos().abs() + r * angle.sin().abs(),
        ];
        assert_box(&rod, [-r, -y, -z], [r, y, z], "askew");
    }
    assert_box(
        &scenes::flange(),
        [-1.0, -1.0, 0.0],
        [1.0, 1.0, 0.7],
        "flange",
    );
    // Of faces: the cap's disc, and what is round of it.
    let brep = boundary(&upper).expect("a boundary");
    let boxes: Vec<_> = brep.faces().filter_map(|face| face.bounds()).collect();
    let top = |bounds: &csg::Bounds| bounds.max.z;
    let (disc, round) = match top(&boxes[0]) < top(&boxes[1]) {
        true => (boxes[0], boxes[1]),
        false => (boxes[1], boxes[0]),
    };
    for (found, wanted) in [
        (disc.min, [-0.8, -0.8, 0.6]),
        (disc.max, [0.8, 0.8, 0.6]),
        (round.min, [-0.8, -0.8, 0.6]),
        (round.max, [0.8, 0.8, 1.0]),
    ] {
        let off = (found - glam::DVec3::from(wanted)).abs().max_element();
        assert!(off < 1e-13, "{found} for {wanted:?}");
    }
}

#[test]
fn nothing_has_no_boundary_and_no_measures() {
    let apart = Solid::sphere(1.0) & Solid::sphere(1.0).translate([3.0, 0.0, 0.0]);
    for solid in [Solid::empty(), apart] {
        let brep = boundary(&solid).expect("an empty boundary");
        assert!(brep.is_empty());
        let measure = brep.measure();
        assert_eq!((measure.volume.value, measure.area.value), (0.0, 0.0));
        assert_eq!(measure.centroid, None);
    }
}
