//! Profiles, extrusions, hulls and polyhedra in scenes: volumes against closed
//! forms, smooth and faceted, and what is said where something is amiss.

use std::f64::consts::PI;

use csg::{BoundaryOptions, Mesher, Program};
use io::scene::{ReadOptions, Scene, SceneError, read};

fn scene(text: &str, faceted: bool) -> Scene {
    read(text, &ReadOptions::default().faceted(faceted)).unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// The volume, and by how much it may be off: the area times the tolerance.
fn smooth_volume(text: &str, tolerance: f64) -> (f64, f64) {
    let program = Program::lower(&scene(text, false).solid).expect("a program");
    let meshed = Mesher::new().tolerance(tolerance).mesh(&program);
    let meshed = meshed.unwrap_or_else(|e| panic!("{text}: {e}"));
    assert_eq!(meshed.report.fallbacks, [], "{text}");
    assert!(meshed.report.check.is_manifold(), "{text}");
    (meshed.mesh.volume(), meshed.mesh.area() * tolerance)
}

fn volume(text: &str, faceted: bool) -> f64 {
    let solid = scene(text, faceted).solid;
    let program = Program::lower(&solid).unwrap_or_else(|e| panic!("{text}: {e}"));
    let mesher = Mesher::new();
    let mesher = if faceted {
        mesher
    } else {
        mesher.tolerance(1e-2)
    };
    let meshed = mesher
        .mesh(&program)
        .unwrap_or_else(|e| panic!("{text}: {e}"));
    assert_eq!(meshed.report.fallbacks, [], "{text}");
    assert!(meshed.report.check.is_manifold(), "{text}");
    meshed.mesh.volume()
}

/// Oblique prisms and cylinders stand where their axis does, twisted ones as well.
#[test]
fn extrusions_along_a_vector_lean() {
    let bounds = |text: &str| {
        let program = Program::lower(&scene(text, false).solid).expect("a program");
        let brep = program
            .boundary(&BoundaryOptions::new())
            .expect("a boundary");
        let bounds = brep.bounds().expect("bounds");
        let volume = brep.measure().volume.value;
        (
            [bounds.min, bounds.max].map(|point| point.to_array()),
            volume,
        )
    };
    let near = |found: [[f64; 3]; 2], wanted: [[f64; 3]; 2], text: &str| {
        let mut pairs = found.iter().flatten().zip(wanted.iter().flatten());
        assert!(
            pairs.all(|(a, b)| (a - b).abs() < 1e-9),
            "{text}: {found:?}"
        );
    };
    let square = "square(size = [1, 2], center = false);";
    let text = format!("linear_extrude(height = 10, v = [3, 0, 4]) {{ {square} }}");
    let (found, volume) = bounds(&text);
    near(found, [[0.0; 3], [7.0, 2.0, 8.0]], &text);
    assert!((volume - 16.0).abs() < 1e-9);
    let text = format!("linear_extrude(v = [2, 3, 10], center = true) {{ {square} }}");
    near(
        bounds(&text).0,
        [[-1.0, -1.5, -5.0], [2.0, 3.5, 5.0]],
        &text,
    );
    let text = "linear_extrude(v = [1, 0, 2]) { circle(r = 3); }";
    let (found, volume) = bounds(text);
    near(found, [[-3.0, -3.0, 0.0], [4.0, 3.0, 2.0]], text);
    assert!((volume - 18.0 * PI).abs() < 1e-9);
    // Half way up a quarter turn is an eighth, and the axis half as far.
    let text =
        "linear_extrude(v = [8, 0, 2], twist = 90) { square(size = [4, 1], center = true); }";
    let twisted = scene(text, false);
    let program = Program::lower(&twisted.solid).expect("a program");
    let [on, beside] = [1.0, -1.0].map(|sign| {
        let along = 1.9 * std::f64::consts::FRAC_1_SQRT_2;
        program.contains([4.0 + along, -sign * along, 1.0])
    });
    assert!(on && !beside);

    for (v, problem) in [
        ("[1, 2]", "`v` must be [x, y, z]"),
        ("3", "`v` must be [x, y, z]"),
    ] {
        let text = format!("linear_extrude(height = 1, v = {v}) {{ {square} }}");
        let error = read(&text, &ReadOptions::default()).expect_err("a mistake");
        assert!(error.to_string().contains(problem), "{error}");
    }
    // Not upwards.
    let down = scene(
        &format!("linear_extrude(v = [1, 0, -1]) {{ {square} }}"),
        false,
    );
    assert!(
        down.warnings[0].to_string().contains("the height"),
        "{:?}",
        down.warnings
    );
    let error = read(
        "resize([1, 2, 3], auto = \"x\") cube(1);",
        &ReadOptions::default(),
    );
    assert!(
        error
            .expect_err("a mistake")
            .to_string()
            .contains("one flag")
    );
}

fn assert_volume(text: &str, wanted: f64) {
    let found = volume(text, true);
    assert!(
        (found / wanted - 1.0).abs() < 1e-11,
        "{text}: {found}, not {wanted}"
    );
}

const SQUARE: &str = "square(size = [2, 1], center = true);";

/// Reads a scene without a warning, and holds the volume within its exact boundary to `wanted`.
fn assert_exact(text: &str, wanted: f64) {
    let scene = scene(text, false);
    assert!(scene.warnings.is_empty(), "{text}: {:?}", scene.warnings);
    let program = Program::lower(&scene.solid).expect("a program");
    let boundary = program.boundary(&BoundaryOptions::new()).expect(text);
    let volume = boundary.measure().volume;
    let off = (volume.value - wanted).abs();
    assert!(
        off <= volume.error + 1e-11 * wanted,
        "{text}: {volume:?}, {wanted}"
    );
}

#[test]
fn polygons_are_the_same_in_both_readings() {
    let polygon = "polygon(points = [[0, 0], [4, 0], [4, 4], [0, 4], [1, 1], [3, 1], [3, 3], [1, 3]], paths = [[0, 1, 2, 3], [4, 5, 6, 7]], convexity = 1);";
    for (text, wanted) in [
        (format!("linear_extrude(height = 2, center = true, convexity = 1, scale = [1, 1], $fn = 0, $fa = 12, $fs = 2) {{ {polygon} }}"), 24.0),
        (format!("linear_extrude(height = 3, scale = [0, 0]) {{ {SQUARE} }}"), 2.0),
        (format!("linear_extrude(height = 3, scale = 0.5) {{ {SQUARE} }}"), 3.5),
        (format!("linear_extrude(height = 3) {{ difference() {{ {SQUARE} circle($fn = 4, r = 0.5); }} }}"), 4.5),
        (format!("linear_extrude(height = 3) {{ multmatrix([[-2, 0, 0, 5], [0, 1, 0, 0], [0, 0, 0, 9], [0, 0, 0, 1]]) {{ {SQUARE} }} }}"), 12.0),
        (format!("linear_extrude(height = 1) {{ offset(delta = 0.5) {{ {SQUARE} }} }}"), 6.0),
        (format!("linear_extrude(height = 1) {{ offset(r = -0.25) {{ {SQUARE} }} }}"), 0.75),
        ("linear_extrude(height = 1) { hull() { circle($fn = 4, r = 1); multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { circle($fn = 4, r = 1); } } }".to_owned(), 8.0),
        ("linear_extrude(height = 1) { projection(cut = false) { cube(size = [1, 2, 3], center = true); multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 9], [0, 0, 0, 1]]) { cube(size = [2, 1, 3], center = true); } } }".to_owned(), 3.0),
        ("linear_extrude(height = 1) { projection(cut = true) { union() { multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -1], [0, 0, 0, 1]]) { cube(size = [2, 1, 1]); } cube(size = [1, 2, 1]); } } }".to_owned(), 3.0),
        ("linear_extrude(height = 1) { projection(cut = true) { difference() { cube(size = [3, 3, 3], center = true); cube(size = [1, 1, 5], center = true); } } }".to_owned(), 8.0),
        ("linear_extrude(height = 1) { resize(newsize = [5, 0, 0], auto = [0, 1, 0]) { square(size = [2, 1]); } }".to_owned(), 12.5),
        ("rotate_extrude(angle = 360, $fn = 4) { multmatrix([[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { square(size = [1, 2]); } }".to_owned(), 20.0),
        ("rotate_extrude(angle = 90, $fn = 4) { multmatrix([[1, 0, 0, -3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { square(size = [1, 2]); } }".to_owned(), 5.0),
        ("hull() { cube(size = [1, 1, 1]); multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cube(size = [1, 1, 1]); } }".to_owned(), 4.0),
        ("minkowski() { cube(size = [1, 2, 3]); cube(size = [1, 1, 1], center = true); }".to_owned(), 24.0),
        ("minkowski() { difference() { cube(size = [4, 4, 4]); cube(size = [2, 2, 9]); } cube(size = [1, 1, 1]); }".to_owned(), 105.0),
        ("resize(newsize = [0, 0, 9], auto = [true, false, false]) { cube(size = [1, 2, 3]); }".to_owned(), 54.0),
        ("resize(newsize = [20, 0, 0], auto = true) { cube(size = 3); }".to_owned(), 8000.0),
        ("resize([6, 0, 0], auto = false) { cube(size = [1, 2, 3]); }".to_owned(), 36.0),
        // Area times the height along z, wherever it leans to.
        (format!("linear_extrude(height = 10, v = [3, 0, 4]) {{ {SQUARE} }}"), 16.0),
        (format!("linear_extrude(v = [1, -2, 3], center = true) {{ {SQUARE} }}"), 6.0),
        (format!("linear_extrude(height = 5, v = [0, 0, 0.1]) {{ {SQUARE} }}"), 10.0),
        (format!("linear_extrude(v = [9, 0, 3], scale = 0.5) {{ {SQUARE} }}"), 3.5),
        ("polyhedron(points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], convexity = 1);".to_owned(), 1.0 / 6.0),
        // Listed the other way round.
        ("polyhedron(points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], faces = [[2, 1, 0], [1, 3, 0], [3, 2, 0], [2, 3, 1]], convexity = 1);".to_owned(), 1.0 / 6.0),
    ] {
        assert_volume(&text, wanted);
        let smooth = volume(&text, false);
        assert!((smooth / wanted - 1.0).abs() < 1e-11, "{text}: {smooth}");
    }
}

/// A cone between two spheres (the closed form is in the mesher's own tests), and nothing to be told.
#[test]
fn hulls_of_unequal_spheres_are_smooth() {
    let text = "hull() { sphere(r = 3, $fa = 12, $fs = 2); multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2.5], [0, 0, 0, 1]]) { sphere(r = 1, $fa = 12, $fs = 2); } }";
    let (found, off) = smooth_volume(text, 1e-3);
    assert!((found - 114.458_692_345_788).abs() <= off, "{found}");
    assert!(scene(text, false).warnings.is_empty());
}

/// Cylinders, cones and frusta with parallel axes, and flat faces: against closed forms, and nothing
/// to be told.
#[test]
fn hulls_of_cylinders_and_flat_faces_are_smooth() {
    let at = |x: f64, y: f64, z: f64, what: &str| {
        format!(
            "multmatrix([[1, 0, 0, {x}], [0, 1, 0, {y}], [0, 0, 1, {z}], [0, 0, 0, 1]]) {{ {what} }}"
        )
    };
    let cylinder = |height: f64, low: f64, high: f64| {
        format!("cylinder($fn = 0, $fa = 12, $fs = 2, h = {height}, r1 = {low}, r2 = {high});")
    };
    let turned = |what: &str| {
        format!(
            "multmatrix([[0.866025, -0.5, 0, 0], [0.5, 0.866025, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {{ {what} }}"
        )
    };
    let high = at(4.0, 0.0, 0.0, &cylinder(5.0, 1.0, 1.0));
    let half = at(0.0, -1.0, 0.0, "cube(size = [4, 2, 2]);");
    for (what, wanted) in [
        (
            cylinder(1.0, 1.0, 2.0) + &at(0.0, 0.0, 1.0, &cylinder(1.0, 2.0, 1.0)),
            14.0 / 3.0 * PI,
        ),
        // A trapezoid of area 14 and height 5, widened by half a circle at each side.
        (cylinder(2.0, 1.0, 1.0) + &high, 28.0 + 5.0 * PI),
        (turned(&(cylinder(2.0, 1.0, 1.0) + &high)), 28.0 + 5.0 * PI),
        (cylinder(2.0, 1.0, 1.0) + &half, 16.0 + PI),
        (
            format!("group() {{ color([1, 0, 0, 1]) {{ {half} }} }}") + &cylinder(2.0, 1.0, 1.0),
            16.0 + PI,
        ),
        // Extruded circles lean where they are scaled beside the axis.
        (
            "linear_extrude(height = 1, scale = 2) { circle(r = 1); } ".to_owned()
                + &at(
                    0.0,
                    0.0,
                    1.0,
                    "linear_extrude(height = 1, scale = 0.5) { circle(r = 2); }",
                ),
            14.0 / 3.0 * PI,
        ),
        (
            at(
                1.0,
                0.0,
                0.0,
                "linear_extrude(height = 3, scale = 2) { multmatrix([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { circle(r = 1); } }",
            ) + &at(2.0, 0.0, 0.5, "cube(size = [0.5, 0.5, 0.5]);"),
            7.0 * PI,
        ),
        // All that is round is within.
        (
            "cube(size = [2, 2, 1], center = true);".to_owned()
                + &at(0.0, 0.0, 0.5, &cylinder(3.0, 1.0, 0.0)),
            8.0,
        ),
    ] {
        let text = format!("hull() {{ {what} }}");
        let (found, off) = smooth_volume(&text, 1e-3);
        assert!((found - wanted).abs() <= off, "{text}: {found}, {wanted}");
        assert!(scene(&text, false).warnings.is_empty(), "{text}");
    }
    let lying = "multmatrix([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])";
    let across = format!("hull() {{ {high} {lying} {{ {high} }} }}");
    assert!(!scene(&across, false).warnings.is_empty(), "{across}");
}

/// Rounded by balls what has flat faces is as Steiner says; circles that became polygons are told.
#[test]
fn minkowski_sums_with_balls_are_round() {
    let ball = |radius: f64| 4.0 / 3.0 * PI * radius.powi(3);
    let sphere = "sphere($fn = 0, $fa = 12, $fs = 2, r = 2);";
    let rounded = 480.0 + 2.0 * 376.0 + PI * 24.0 * 4.0 + ball(2.0);
    for (text, wanted) in [
        (
            format!("minkowski() {{ cube(size = [10, 8, 6]); {sphere} }}"),
            rounded,
        ),
        (
            format!("minkowski() {{ {sphere} group() {{ cube(size = [10, 8, 6]); }} }}"),
            rounded,
        ),
        (
            format!("minkowski() {{ {sphere} sphere($fn = 100, r = 3); }}"),
            ball(5.0),
        ),
        (
            format!(
                "minkowski() {{ cube(size = [10, 8, 6]); {sphere} sphere(r = 1, $fa = 12, $fs = 2); }}"
            ),
            480.0 + 3.0 * 376.0 + PI * 24.0 * 9.0 + ball(3.0),
        ),
    ] {
        assert_exact(&text, wanted);
    }
    for text in [
        "minkowski() { sphere(r = 1); cylinder(r1 = 2, r2 = 2, h = 1); }",
        "hull() { cube(size = [9, 9, 1]); sphere(r = 5); }",
        "linear_extrude(height = 1) { minkowski() { square(size = [9, 9]); polygon(points = [[0, 0], [1, 0], [0, 1]]); circle(r = 5); } }",
    ] {
        let warnings: Vec<String> = scene(text, false)
            .warnings
            .iter()
            .map(ToString::to_string)
            .collect();
        let is_told = |warning: &String| warning.contains("polygons of 30 corners");
        assert!(warnings.iter().any(is_told), "{text}: {warnings:?}");
        let warnings = scene(text, true).warnings;
        assert!(warnings.is_empty(), "{text}: {warnings:?}");
    }
}

/// Offsets, sums with circles and sections keep lines and arcs, also of combinations.
#[test]
fn flat_shapes_stay_exact() {
    let plate = "difference() { square(size = [40, 40], center = true); circle(r = 10); }";
    let mitred = format!("offset(delta = 1, chamfer = false) {{ {plate} }}");
    let post = "cylinder(r1 = 5, r2 = 5, h = 10);";
    let tilted = "multmatrix([[1, 0, 0, 0], [0, 0.8, -0.6, 0], [0, 0.6, 0.8, 0], [0, 0, 0, 1]]) { cylinder(r1 = 5, r2 = 5, h = 60, center = true); }";
    let section = |of: &str| format!("projection(cut = true) {{ {of} }}");
    for (flat, wanted) in [
        (format!("offset(r = -1) {{ {plate} }}"), 1444.0 - 121.0 * PI),
        (
            format!("offset(r = 1) {{ {plate} }}"),
            1760.0 + PI - 81.0 * PI,
        ),
        (
            format!("offset(r = 12) {{ {plate} }}"),
            1600.0 + 4.0 * 480.0 + 144.0 * PI,
        ),
        // Gone and back: only the corners are round.
        (
            format!("offset(r = 3) {{ offset(r = -3) {{ {plate} }} }}"),
            1600.0 - 100.0 * PI - 9.0 * (4.0 - PI),
        ),
        (format!("hull() {{ {plate} }}"), 1600.0),
        (mitred, 42.0 * 42.0 - 81.0 * PI),
        (
            format!("minkowski() {{ {plate} circle(r = 1); circle(r = 2); }}"),
            1600.0 + 480.0 + 9.0 * PI - 49.0 * PI,
        ),
        (section(post), 25.0 * PI),
        (
            section(&format!(
                "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -3], [0, 0, 0, 1]]) {{ difference() {{ {post} cube(size = [2, 2, 30], center = true); }} }}"
            )),
            25.0 * PI - 4.0,
        ),
        (section(tilted), 25.0 * PI / 0.8),
    ] {
        let text = format!("linear_extrude(height = 1) {{ {flat} }}");
        assert_exact(&text, wanted);
    }
    for (text, told) in [
        (
            "linear_extrude(height = 1, scale = [0.5, 1]) { circle(r = 10); }",
            "flat faces within 3.0e-3 of it",
        ),
        (
            "linear_extrude(height = 5, twist = 90, slices = 4) { square(size = [3, 2], center = true); }",
            "flat faces within 5.4e-4 of it",
        ),
        (
            "linear_extrude(height = 1) { hull() { difference() { circle(r = 2); square(size = [9, 9]); } } }",
            "chords",
        ),
    ] {
        let warnings = scene(text, false).warnings;
        assert!(warnings[0].to_string().contains(told), "{warnings:?}");
    }
}

#[test]
fn circles_are_round_or_not() {
    let facets = |n: f64| 0.5 * n * (2.0 * PI / n).sin();
    for (text, faceted, smooth) in [
        (
            "linear_extrude(height = 2) { circle($fn = 30, r = 1); }",
            2.0 * facets(30.0),
            2.0 * PI,
        ),
        (
            "linear_extrude(height = 2, scale = 0) { circle($fn = 30, r = 1); }",
            2.0 / 3.0 * facets(30.0),
            2.0 / 3.0 * PI,
        ),
        (
            "linear_extrude(height = 2) { hull() { circle($fn = 30, r = 1); multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { circle($fn = 30, r = 1); } } }",
            2.0 * (facets(30.0) + 6.0 * (PI / 30.0).cos()),
            2.0 * (PI + 6.0),
        ),
        (
            "multmatrix([[0.6, 0, -0.8, 5], [0, 1, 0, 0], [0.8, 0, 0.6, 7], [0, 0, 0, 1]]) { hull() { cylinder($fn = 30, h = 2, r1 = 1, r2 = 1); multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cylinder($fn = 30, h = 2, r1 = 1, r2 = 1); } } }",
            2.0 * (facets(30.0) + 6.0 * (PI / 30.0).cos()),
            2.0 * (PI + 6.0),
        ),
        (
            "rotate_extrude(angle = 360, $fn = 20) { square(size = [1, 2]); }",
            2.0 * facets(20.0),
            2.0 * PI,
        ),
        (
            "rotate_extrude(angle = 90, $fn = 20) { square(size = [1, 2]); }",
            0.5 * facets(20.0),
            0.5 * PI,
        ),
    ] {
        assert_volume(text, faceted);
        let (found, off) = smooth_volume(text, 1e-4);
        assert!(
            (found - smooth).abs() <= off,
            "{text}: {found}, not {smooth}"
        );
    }
    // A ring by Pappus, its section as large as the circle; a rounded box.
    let ring = "rotate_extrude(angle = 360, $fn = 0) { multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { circle($fn = 0, r = 1); } }";
    let ring = Program::lower(&scene(ring, false).solid).expect("a program");
    let count = 100_000;
    // Points spread evenly: Roberts' R3 sequence.
    let at = |k: u32, step: f64| 2.0 * (0.5 + f64::from(k) * step).fract() - 1.0;
    let within = (0..count).filter(|&k| {
        let (x, y, z) = (
            at(k, 0.819_172_513_396_164_4),
            at(k, 0.671_043_606_703_789_2),
            at(k, 0.549_700_477_901_970_3),
        );
        ring.contains([4.0 * x, 4.0 * y, z])
    });
    let found = 128.0 * within.count() as f64 / f64::from(count);
    assert!((found - 6.0 * PI * PI).abs() < 0.2, "{found}");
    let balls: String = (0..8)
        .map(|k| {
            let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(|c| 2 * c);
            format!("multmatrix([[1, 0, 0, {x}], [0, 1, 0, {y}], [0, 0, 1, {z}], [0, 0, 0, 1]]) {{ sphere(r = 1); }}")
        })
        .collect();
    let (found, off) = smooth_volume(&format!("hull() {{ {balls} }}"), 1e-2);
    let wanted = 8.0 + 24.0 + 6.0 * PI + 4.0 / 3.0 * PI;
    assert!((found - wanted).abs() <= off, "{found}, not {wanted}");
}

/// What is made of chords or flat faces in place of what was asked for, and nothing else: how near these
/// are is said.
#[test]
fn what_is_only_nearly_so_is_said() {
    let off = "multmatrix([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])";
    let ring = format!("rotate_extrude(angle = 360) {{ {off} {{ circle(r = 1); }} }}");
    let square = format!("rotate_extrude(angle = 360) {{ {off} {{ square(size = [1, 1]); }} }}");
    let unequal = format!("hull() {{ sphere(r = 1); {off} {{ sphere(r = 2); }} }}");
    let long = "multmatrix([[2, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])";
    let unlike = format!("hull() {{ sphere(r = 1); {long} {{ sphere(r = 1); }} }}");
    let equal = format!("hull() {{ sphere(r = 1); {off} {{ sphere(r = 1); }} }}");
    for (text, faceted, within) in [
        (&ring, false, Some("within 6e-4")),
        (&ring, true, None),
        (&square, false, None),
        (&unequal, false, None),
        (&unlike, false, Some("within")),
        (&equal, false, None),
    ] {
        let said = scene(text, faceted).warnings;
        let said: Vec<String> = said.iter().map(ToString::to_string).collect();
        assert_eq!(
            said.len(),
            usize::from(within.is_some()),
            "{text}: {said:?}"
        );
        let is_told = |within| said.iter().all(|warning| warning.contains(within));
        assert!(within.is_none_or(is_told), "{text}: {said:?}");
    }
}

#[test]
fn warnings_and_errors_say_where() {
    for text in [
        SQUARE,
        "group() { linear_extrude(height = 0) { circle(r = 1); } }",
        "group() { linear_extrude(height = 1) { sphere(r = 1); } }",
        "group() { rotate_extrude(angle = 360) { square(size = [2, 2], center = true); } }",
        "group() { polygon(points = [[0, 0], [1, 0]], paths = undef, convexity = 1); }",
        "intersection() { cube(size = [1, 1, 1]); circle(r = 1); }",
    ] {
        let scene = scene(&format!("\n{text}"), false);
        assert!(!scene.warnings.is_empty(), "{text}");
        assert_eq!(scene.warnings[0].place.line, 2, "{text}");
        let program = Program::lower(&scene.solid).expect("a program");
        assert!(program.surfaces().is_empty(), "{text}");
    }
    for text in [
        "polyhedron(points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3]], convexity = 1);",
        "polyhedron(points = [[0, 0, 0]], faces = [[0, 1, 2]], convexity = 1);",
        "polyhedron(points = undef, faces = [[0, 1, 2]], convexity = 1);",
        "polygon(points = [[0, 0], [1, 0], [0, 1]], paths = [[0, 1, 7]], convexity = 1);",
        "linear_extrude(height = 1, twist = nan) { circle(r = 1); }",
        "offset(r = inf) { circle(r = 1); }",
        "resize(newsize = [1]) { circle(r = 1); }",
    ] {
        match read(&format!("\n\t{text}"), &ReadOptions::default()) {
            Err(SceneError::Argument { place, .. }) => {
                assert_eq!((place.line, place.column), (2, 2), "{text}");
            }
            other => panic!("{text}: {other:?}"),
        }
    }
}

#[test]
fn profiles_on_both_sides_of_the_axis_are_told_with_their_extent() {
    for (flat, extent) in [
        ("circle(r = 5);", "from -5.00 to 5.00"),
        ("translate([1, 0]) circle(r = 1234);", "from -1233 to 1235"),
    ] {
        let text = format!("rotate_extrude(angle = 180) {{ {flat} }}");
        let said = scene(&text, false).warnings[0].to_string();
        assert!(said.contains(extent), "{said}");
    }
}

/// What stands for curved surfaces that there are none for is as near as asked, also under maps, and
/// the solid knows how near.
#[test]
fn what_stands_for_others_is_as_near_as_asked() {
    let off = "multmatrix([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])";
    let thrice = "multmatrix([[0, -3, 0, 5], [3, 0, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1]])";
    let ring = format!("rotate_extrude(angle = 360) {{ {off} {{ circle(r = 1); }} }}");
    let twist = "linear_extrude(height = 4, twist = 90) { square(size = [2, 1]); }";
    let ball = "linear_extrude(height = 4) { projection() { multmatrix([[1, 0, 0, 5], [0, 1, 0.3, 0], [0, 0.2, 1, 0], [0, 0, 0, 1]]) { sphere(r = 1); } } }";
    let hull = "hull() { sphere(r = 1); multmatrix([[2, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { sphere(r = 1); } }";
    for text in [&ring, twist, ball, hull] {
        let larger = format!("{thrice} {{ {text} }}");
        for (text, times) in [(text, 1.0), (&larger, 3.0)] {
            let strays = |within: Option<f64>| {
                let options = ReadOptions::default();
                let options = match within {
                    Some(within) => options.within(within),
                    None => options,
                };
                let read = read(text, &options).unwrap_or_else(|e| panic!("{e}: {text}"));
                assert!(read.warnings.len() == 1, "{:?}: {text}", read.warnings);
                read.solid.strays().unwrap_or_else(|| panic!("{text}"))
            };
            let default = strays(None);
            assert!(
                (1e-4..3e-3).contains(&(default / times)),
                "{default}: {text}"
            );
            // (Circles in hulls are polygons of 360 corners at most.)
            for within in [0.02, 0.002] {
                let found = strays(Some(within));
                assert!(
                    found <= within * 1.000_001 && found > 0.1 * within,
                    "{found}, not {within}: {text}"
                );
            }
        }
    }
    let exact = "minkowski() { cube(size = [1, 2, 3]); sphere(r = 1); }";
    assert_eq!(scene(exact, false).solid.strays(), None);
}

/// Sums of boxes and cylinders along one axis, and solids of a new size, are exact.
#[test]
fn sums_along_an_axis_and_new_sizes_are_exact() {
    let turned = "multmatrix([[1, 0, 0, 3], [0, 0, -1, 1], [0, 1, 0, 2], [0, 0, 0, 1]])";
    let box_and_rod = |turn: &str| {
        format!("minkowski() {{ cube(size = [10, 10, 8]); {turn} {{ cylinder(r = 1, h = 2); }} }}")
    };
    let squashed = "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0.5, 0], [0, 0, 0, 1]])";
    let two = "minkowski() { group() { cube(size = [4, 4, 1]); cube(size = [1, 8, 1]); } cylinder(r = 0.5, h = 1); }";
    for (text, volume) in [
        (box_and_rod("group()"), (140.0 + PI) * 10.0),
        (box_and_rod(turned), (80.0 + 36.0 + PI) * 12.0),
        // An L of two boxes, rounded but for its inner corner.
        (
            two.to_owned(),
            2.0 * (20.0 + 0.5 * 24.0 - 0.25 + 5.0 * PI / 16.0),
        ),
        (
            "resize(newsize = [10, 20, 30]) { sphere(r = 1); }".to_owned(),
            1000.0 * PI,
        ),
        (
            "linear_extrude(height = 2) { resize([8, 4]) { circle(r = 1); } }".to_owned(),
            16.0 * PI,
        ),
        (
            format!("resize(newsize = [0, 0, 3]) {{ {squashed} {{ cylinder(r = 2, h = 5); }} }}"),
            12.0 * PI,
        ),
    ] {
        let read = scene(&text, false);
        assert!(read.warnings.is_empty(), "{:?}: {text}", read.warnings);
        let program = Program::lower(&read.solid).expect("a program");
        let brep = program
            .boundary(&BoundaryOptions::default())
            .expect("a boundary");
        let found = brep.measure().volume.value;
        assert!(
            (found / volume - 1.0).abs() < 1e-9,
            "{text}: {found}, not {volume}"
        );
    }
}

/// Where a solid of revolution begins, as newer versions of OpenSCAD write it.
#[test]
fn revolutions_begin_where_they_say() {
    let from = |start: &str, side: f64| {
        format!(
            "rotate_extrude(angle = 90, {start}$fn = 0) {{ multmatrix([[1, 0, 0, {side}], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {{ square(size = [1, 1]); }} }}"
        )
    };
    for (start, side, degrees) in [
        ("", 2.0, 45.0),
        ("start = 0, ", 2.0, 45.0),
        ("start = 30, ", 2.0, 75.0),
        ("start = -90, ", 2.0, -45.0),
        ("start = 30, ", -3.0, 255.0),
    ] {
        let solid = scene(&from(start, side), false).solid;
        let program = Program::lower(&solid).expect("a program");
        for turn in 0..24 {
            let angle = f64::from(15 * turn) + 7.0;
            let (sine, cosine) = angle.to_radians().sin_cos();
            let off = (angle - degrees + 180.0).rem_euclid(360.0) - 180.0;
            let is_within = program.contains([2.5 * cosine, 2.5 * sine, 0.5]);
            assert_eq!(is_within, off.abs() < 45.0, "{start}{side}: {angle}");
        }
    }
}
