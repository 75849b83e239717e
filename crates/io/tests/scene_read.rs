//! Reading scenes: what the nodes mean, what is refused and where, and that
//! no text whatever makes the reader fail in another way.

use csg::{Color, Node, Primitive, Program, Solid};
use glam::DVec3;
use io::scene::{ReadOptions, Scene, SceneError, read, read_bytes, read_file};
use proptest::prelude::*;

fn scene(text: &str, faceted: bool) -> Scene {
    read(text, &ReadOptions::default().faceted(faceted)).unwrap_or_else(|e| panic!("{text}: {e}"))
}

fn program(text: &str) -> Program {
    Program::lower(&scene(text, false).solid).expect("a valid solid")
}

fn is_empty(text: &str) -> bool {
    let solid = scene(text, false).solid;
    matches!(solid.node(), Node::Primitive(Primitive::Empty))
}

#[test]
fn operations_and_maps() {
    let p = program(
        "difference() { group() { cube(size = [4, 4, 4], center = true); }
         multmatrix([[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
         { sphere($fn = 0, $fa = 12, $fs = 2, r = 1); } }
         multmatrix([[2, 0, 0, 20], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 2]])
         { cube(size = [1, 1, 1], center = false); }",
    );
    for (point, inside) in [
        ([0.0, 0.0, 0.0], true),
        ([1.5, 0.0, 0.0], false),
        ([2.5, 0.0, 0.0], false),
        ([1.5, 1.5, 1.5], true),
        // The whole matrix is divided by its last entry.
        ([10.5, 0.5, 0.5], true),
        ([11.5, 0.5, 0.5], false),
    ] {
        assert_eq!(p.contains(point), inside, "{point:?}");
    }
    let p = program(
        "render(convexity = 2) { intersection() { cylinder(h = 2, r1 = 2, r2 = 0, center = true);
         union() { sphere(r = 1); } } }",
    );
    assert!(p.contains([0.9, 0.0, -0.1]) && !p.contains([0.9, 0.0, 0.3]));
    assert!(!p.contains([1.2, 0.0, -0.9]));
}

#[test]
fn rows_act_on_columns() {
    let p = program(
        "multmatrix([[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]])
         { cube(size = [1, 2, 3], center = false); }",
    );
    // (x, y, z) goes to (10 - y, 20 + x, 30 + z).
    assert!(p.contains([8.1, 20.9, 32.9]) && !p.contains([9.5, 21.1, 30.5]));
}

#[test]
fn background_is_left_out_and_highlight_kept() {
    let cut = "difference() {\n%\tcube(size = [9, 9, 9], center = true);\n#\tcube(size = [4, 4, 4], center = true);\n\tsphere(r = 1);\n}\n";
    let p = program(cut);
    assert!(p.contains([1.9; 3]) && !p.contains([2.1; 3]) && !p.contains([0.0; 3]));
    let kept = "intersection() {\n%\tsphere(r = 1);\n\tcube(size = [4, 4, 4], center = true);\n}";
    assert!(program(kept).contains([1.9; 3]));
    // What is left out need not be readable, at any depth.
    let out = "%hull() { text(text = \"a\\\"b\", size = undef); group() { polygon(points = [[1, 2], [3, 4]], paths = undef); } }\nsphere(r = 1);";
    assert!(program(out).contains([0.0; 3]));
    let after = read("%group() { roof(); }\nroof();", &ReadOptions::default());
    assert!(matches!(after, Err(SceneError::Unsupported { place, .. }) if place.line == 2));
    assert!(is_empty("%sphere(r = 1);"));
}

#[test]
fn empty_operands() {
    let no_size = "cube(size = [0, 0, 0], center = false);";
    for empty in [
        String::new(),
        " // nothing\n".into(),
        "group();".into(),
        "group() {\n}".into(),
        "union() { group(); union(); }".into(),
        "difference();".into(),
        "difference() { group(); sphere(r = 1); }".into(),
        format!("difference() {{ {no_size} sphere(r = 1); }}"),
        "intersection();".into(),
        "intersection() { sphere(r = 1); group(); }".into(),
        format!("color([1, 0, 0, 1]) {{ {no_size} }}"),
        "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);".into(),
    ] {
        assert!(is_empty(&empty), "{empty}");
    }
    let p = program(&format!(
        "difference() {{ sphere(r = 1); {no_size} }} intersection() {{ sphere(r = 2); }}"
    ));
    assert!(p.contains([1.5, 0.0, 0.0]));
}

#[test]
fn sizes_that_make_nothing_are_empty_with_a_warning() {
    for text in [
        "cube(size = [1, -1, 1], center = false);",
        "cube(size = [inf, 1, 1], center = false);",
        "cube(size = [nan, 1, 1], center = true);",
        "cube(size = [1e999, 1, 1], center = true);",
        "sphere(r = 0);",
        "sphere(r = -nan);",
        "cylinder(h = 0, r1 = 1, r2 = 1, center = false);",
        "cylinder(h = 1, r1 = 0, r2 = 0, center = false);",
        "cylinder(h = 1, r1 = 1, r2 = -1, center = false);",
        "cylinder(h = 1, r1 = nan, r2 = 1, center = false);",
        "cylinder(h = inf, r1 = 1, r2 = 1, center = false);",
        "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]) { sphere(r = 1); }",
        "multmatrix([[1, 2, 0, 0], [2, 4, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { sphere(r = 1); }",
        "multmatrix([[1, 0, 0, inf], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { sphere(r = 1); }",
        "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0]]) { sphere(r = 1); }",
    ] {
        for faceted in [false, true] {
            let scene = scene(&format!("group();\n  {text}"), faceted);
            assert_eq!(scene.warnings.len(), 1, "{text}");
            let place = &scene.warnings[0].place;
            assert_eq!((place.line, place.column), (2, 3), "{text}");
            let node = scene.solid.node();
            assert!(matches!(node, Node::Primitive(Primitive::Empty)), "{text}");
        }
    }
}

#[test]
fn circles_and_polygons() {
    let kind = |text: &str, faceted| match scene(text, faceted).solid.node() {
        Node::Primitive(primitive) => primitive.kind(),
        other => other.kind(),
    };
    for (fragments, smooth) in [("0", true), ("6", false), ("12", false), ("12.5", true)] {
        let sphere = format!("sphere($fn = {fragments}, $fa = 12, $fs = 2, r = 5);");
        let cylinder = |top| {
            format!(
                "cylinder($fn = {fragments}, $fa = 12, $fs = 2, h = 1, r1 = 5, r2 = {top}, center = true);"
            )
        };
        for (text, round, flat) in [
            (sphere, "sphere", "convex_polyhedron"),
            (cylinder(5), "cylinder", "prism"),
            (cylinder(0), "cone", "convex_polyhedron"),
        ] {
            assert_eq!(kind(&text, true), flat, "{text}");
            assert_eq!(kind(&text, false), if smooth { round } else { flat });
        }
    }
    // The first corner of a triangle lies on +x.
    let p = program("cylinder($fn = 0.1, h = 1, r1 = 1, r2 = 1, center = false);");
    assert!(p.contains([0.99, 0.0, 0.5]) && !p.contains([-0.51, 0.0, 0.5]));
}

/// The colours that faces can have, with the primitive's kind.
fn colors(text: &str) -> Vec<(&'static str, Option<Color>)> {
    let program = program(text);
    let origins = program.origins().iter();
    origins.map(|origin| (origin.kind, origin.color)).collect()
}

#[test]
fn the_outer_color_wins() {
    let red = Color::from_srgb([1.0, 0.0, 0.0]);
    let blue = Color::from_srgb([0.0, 0.0, 1.0]).with_alpha(0.5);
    assert_eq!(
        colors("color([1, 0, 0, 1]) { color([0, 0, 1, 0.5]) { sphere(r = 1); } }"),
        [("sphere", Some(red))]
    );
    // No colour at all lets the inner one through.
    assert_eq!(
        colors(
            "color([-1, -1, -1, 1]) { color([0, 0, 1, 0.5]) { sphere(r = 1); } sphere(r = 2); }"
        ),
        [("sphere", Some(blue)), ("sphere", None)]
    );
    // Siblings do not colour each other; a cut shows the cutter's colour.
    assert_eq!(
        colors(
            "difference() { color([1, 0, 0]) { cube(size = [1, 1, 1], center = true); } sphere(r = 0.6); }"
        ),
        [("cuboid", Some(red)), ("sphere", None)]
    );
    // By name, in digits, and with an opacity beside.
    for (text, alpha) in [
        ("\"blue\", 0.5", 0.5),
        ("\"Blue\"", 1.0),
        ("c = \"#00f\", alpha = 0.5", 0.5),
        ("\"#0000ff80\", alpha = 0.25", 0.25),
        ("[0, 0, 1], 0.25", 0.25),
        ("[0, 0, 1, 0.1], 0.25", 0.25),
    ] {
        let found = colors(&format!("color({text}) {{ sphere(r = 1); }}"));
        assert_eq!(found, [("sphere", Some(blue.with_alpha(alpha)))], "{text}");
    }
    let grey = colors("color([0.5, 0.5, 0.5, 1]) { sphere(r = 1); }");
    let linear = grey[0].1.map_or(0.0, |color| color.rgb[0]);
    assert!((linear - 0.214_041).abs() < 1e-5, "decoded from sRGB");
}

#[test]
fn errors_say_where_and_what() {
    for (text, line, column, says) in [
        ("fill() { sphere(r = 1); }", 1, 1, "`fill`"),
        ("group() {\n\troof(convexity = 0);\n}", 2, 2, "cylinder"),
        ("spehre(r = 1);", 1, 1, "(`sphere` is meant?)"),
        ("Cube(size = [1, 1, 1]);", 1, 1, "(`cube` is meant?)"),
        ("translat([1, 0, 0]) { }", 1, 1, "(`translate` is meant?)"),
        ("\ntranslate(1) { }", 2, 1, "[x, y, z]"),
        ("translate() { }", 1, 1, "[x, y, z]"),
        (
            "translate([1, 2, 3], [1, 2, 3]) { }",
            1,
            1,
            "without a name",
        ),
        ("scale([1]) sphere(1);", 1, 1, "one for all axes"),
        ("rotate(45, [0, 0, 0]) sphere(1);", 1, 1, "no direction"),
        ("rotate(b = 45) sphere(1);", 1, 1, "`b`"),
        ("mirror(\"x\") sphere(1);", 1, 1, "[x, y, z]"),
        ("translate([1, 0, 0])", 1, 21, "`;`, `{` or a child"),
        ("translate([1, 0, 0]) }", 1, 22, "`;`, `{` or a child"),
        ("translate([1, 0, 0]) %", 1, 23, "a node"),
        ("sphere(1) sphere(2);", 1, 1, "no children"),
        ("sphere(1, r = 2);", 1, 1, "twice"),
        ("sphere(r = 1, d = 2);", 1, 1, "both"),
        ("sphere(1, 2);", 1, 1, "without a name"),
        ("cylinder(4, 1);", 1, 1, "`r2`"),
        ("torus(r = 1);", 1, 1, "`torus` cannot be read: supported"),
        ("group() {", 1, 1, "never closed"),
        ("group(); }", 1, 10, "no `{` is open"),
        ("group()", 1, 8, "the end of the text, not `;`"),
        ("cube(size = [1, 1], center = true);", 1, 1, "[x, y, z]"),
        ("cube(size = [1, 1, true]);", 1, 1, "[x, y, z]"),
        ("cube(size = [1, 1, 1], center = 1);", 1, 1, "true or false"),
        ("\ncube(size = [1, 1, 1], centre = true);", 2, 1, "`centre`"),
        ("sphere(q = 1);", 1, 1, "`q`"),
        ("sphere(r = 1, r = 2);", 1, 1, "twice"),
        ("color([1, 0, 0], 0.5, alpha = 1) { }", 1, 1, "twice"),
        ("sphere(r = undef);", 1, 1, "number `r`"),
        ("sphere(r = 1 2);", 1, 14, "the number 2, not `,` or `)`"),
        ("sphere(r = 1..2);", 1, 12, "not a number"),
        ("cylinder(h = 1, r1 = 1);", 1, 1, "`r2`"),
        ("sphere(r = 1) { group(); }", 1, 1, "no children"),
        (
            "color(\"reddish\") { sphere(r = 1); }",
            1,
            1,
            "a name, or #rrggbb",
        ),
        (
            "color(\"red\", \"half\") { sphere(r = 1); }",
            1,
            1,
            "number `alpha`",
        ),
        ("color([nan, 0, 0, 1]) { sphere(r = 1); }", 1, 1, "from 0"),
        ("multmatrix([[1, 0], [0, 1]]) { }", 1, 1, "four rows"),
        (
            "multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 1, 0, 1]]) { }",
            1,
            1,
            "projective",
        ),
        ("sphere(r = [[[[[[[[[1]]]]]]]]]);", 1, 20, "deep"),
        ("!sphere(r = 1);", 1, 1, "export"),
        ("union { }", 1, 7, "`(` after `union`"),
        ("/* é */ @", 1, 9, "'@'"),
    ] {
        let error = read(text, &ReadOptions::default()).expect_err(text);
        let place = error.place().expect("a place");
        assert_eq!((place.line, place.column), (line, column), "{error}");
        assert!(error.to_string().contains(says), "{error}");
    }
}

/// What is written by hand is what OpenSCAD makes of it: each pair is one solid.
#[test]
fn scenes_written_by_hand() {
    let cube = "cube(size = [1, 2, 3], center = false);";
    let matrix = |rows: &str| format!("multmatrix([{rows}, [0, 0, 0, 1]]) {{ {cube} }}");
    for (text, means) in [
        ("cube([1, 2, 3]);", cube.to_owned()),
        (
            "cube(2, true);",
            "cube(size = [2, 2, 2], center = true);".to_owned(),
        ),
        ("sphere(2);", "sphere(r = 2);".to_owned()),
        ("sphere(d = 4);", "sphere(r = 2);".to_owned()),
        (
            "cylinder(h = 4, r = 1);",
            "cylinder(h = 4, r1 = 1, r2 = 1);".to_owned(),
        ),
        (
            "cylinder(4, d1 = 2, d2 = 1);",
            "cylinder(h = 4, r1 = 1, r2 = 0.5);".to_owned(),
        ),
        (
            "cylinder(4, d = 4, r2 = 1);",
            "cylinder(h = 4, r1 = 2, r2 = 1);".to_owned(),
        ),
        (
            "linear_extrude(3) circle(d = 2);",
            "linear_extrude(height = 3) { circle(r = 1); }".to_owned(),
        ),
        (
            "linear_extrude(3) square(2);",
            "linear_extrude(height = 3) { square(size = [2, 2]); }".to_owned(),
        ),
        (
            "translate([5, 6]) cube([1, 2, 3]);",
            matrix("[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 0]"),
        ),
        // About X first: y goes to z, then z to x.
        (
            "rotate([90, 90, 0]) cube([1, 2, 3]);",
            matrix("[0, 1, 0, 0], [0, 0, -1, 0], [-1, 0, 0, 0]"),
        ),
        (
            "rotate(-90) cube([1, 2, 3]);",
            matrix("[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0]"),
        ),
        (
            "rotate(a = 120, v = [1, 1, 1]) cube([1, 2, 3]);",
            matrix("[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0]"),
        ),
        (
            "scale([2, 3]) scale(2) cube([1, 2, 3]);",
            matrix("[4, 0, 0, 0], [0, 6, 0, 0], [0, 0, 2, 0]"),
        ),
        (
            "mirror([1, 1, 0]) cube([1, 2, 3]);",
            matrix("[0, -1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0]"),
        ),
        ("mirror([0, 0, 0]) cube([1, 2, 3]);", cube.to_owned()),
        (
            "difference() { union() cube([1, 2, 3]); translate([9, 9, 9]) sphere(1); } %sphere(9);",
            format!(
                "difference() {{ {cube} multmatrix([[1, 0, 0, 9], [0, 1, 0, 9], [0, 0, 1, 9], \
                 [0, 0, 0, 1]]) {{ sphere(r = 1); }} }}"
            ),
        ),
    ] {
        let [one, other] = [text, &*means].map(|text| {
            let program = program(text);
            let bounds = program.bounds().expect("bounds").expect("a solid");
            (program, bounds)
        });
        let off = (one.1.min - other.1.min)
            .abs()
            .max((one.1.max - other.1.max).abs());
        assert!(off.max_element() < 1e-14, "{text}: {off}");
        for k in 0..500_u32 {
            let share = |n: u32| f64::from(k.wrapping_mul(n) % 499) / 499.0;
            let share = DVec3::new(share(1), share(73), share(211));
            let point = one.1.min + (one.1.max - one.1.min) * share + 1e-7;
            let point = point.to_array();
            assert_eq!(one.0.contains(point), other.0.contains(point), "{text}");
        }
    }
    // Right angles are exact.
    let solid = scene("rotate([0, 0, 270]) cube([1, 2, 3]);", false).solid;
    let Node::Transform(Ok(map), _) = solid.node() else {
        panic!("{solid:?}");
    };
    let turned = glam::DMat3::from_cols(-DVec3::Y, DVec3::X, DVec3::Z);
    assert_eq!(map.matrix3, turned);
    assert!(is_empty("translate([1, 0, 0]);"));
    assert!(is_empty("group() %translate(1) group() roof(1);"));
}

#[test]
fn too_many_facets_are_refused() {
    let text = "sphere($fn = 1e9, $fa = 12, $fs = 2, r = 5);";
    let faceted = ReadOptions::default().faceted(true);
    let error = read(text, &faceted).expect_err("10¹⁸ facets");
    assert!(error.to_string().contains("facets"), "{error}");
    assert!(read(text, &ReadOptions::default()).is_ok());
    let endless = "cylinder($fn = 0, $fa = 0, $fs = 0, h = 1, r1 = 1, r2 = 1);";
    assert!(read(endless, &faceted).is_err());
}

#[test]
fn files_and_bytes() {
    let folder = std::env::temp_dir().join(format!("stereotomy-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("bad.csg");
    std::fs::write(&path, b"group();\n  \xff").expect("a file");
    let error = read_file(&path, &ReadOptions::default()).expect_err("not UTF-8");
    assert!(error.to_string().contains("bad.csg:2:3"), "{error}");
    std::fs::write(&path, "\u{feff}sphere(r = 0);").expect("a file");
    let scene = read_file(&path, &ReadOptions::default()).expect("an empty scene");
    assert!(scene.warnings[0].to_string().contains("bad.csg:1:1"));
    std::fs::remove_dir_all(&folder).expect("removed");
    let missing = read_file(&path, &ReadOptions::default()).expect_err("no file");
    assert!(missing.to_string().contains("bad.csg"), "{missing}");
    assert!(read_bytes(&[0x80], &ReadOptions::default()).is_err());
}

#[test]
fn a_million_levels_deep() {
    // A stack that a recursion over a million levels breaks.
    let on_a_small_stack = std::thread::Builder::new().stack_size(128 * 1024);
    let test = || {
        let levels = 1_000_000;
        for (head, keeps_depth) in [
            ("group() {", false),
            ("%group() {", false),
            ("difference() { cube(size = [1,1,1]);", true),
            (
                "multmatrix([[1,0,0,0],[0,1,0,0],[0,0,1,1e-9],[0,0,0,1]]) {",
                true,
            ),
        ] {
            let mut text = head.repeat(levels);
            text.push_str("sphere(r = 1);");
            text.push_str(&"}".repeat(levels));
            let solid: Solid = scene(&text, false).solid;
            assert_eq!(!solid.node().operands().is_empty(), keeps_depth, "{head}");
        }
        let lone = "translate([0, 0, 1e-9]) ".repeat(levels) + "sphere(1);";
        let solid: Solid = scene(&lone, false).solid;
        assert!(!solid.node().operands().is_empty());
        let open = read(&"group(){".repeat(levels), &ReadOptions::default());
        assert!(matches!(open, Err(SceneError::Syntax { .. })));
        let brackets = "[".repeat(levels);
        assert!(read(&format!("sphere(r = {brackets}"), &ReadOptions::default()).is_err());
    };
    let thread = on_a_small_stack.spawn(test).expect("a thread");
    thread.join().expect("no overflow");
}

/// Scene texts with numbers good and bad.
fn tree_text() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        any::<f64>().prop_map(|n| format!("{n:?}")),
        (-20..20i32).prop_map(|n| n.to_string()),
        Just("1e-07".to_owned()),
        Just("nan".to_owned()),
    ];
    let three = (number.clone(), number.clone(), number.clone());
    let leaf = prop_oneof![
        number
            .clone()
            .prop_map(|r| format!("sphere($fn = 0, $fa = 12, $fs = 2, r = {r});\n")),
        three
            .clone()
            .prop_map(|(x, y, z)| format!("cube(size = [{x}, {y}, {z}], center = false);\n")),
        three.prop_map(|(h, r1, r2)| format!(
            "cylinder($fn = 7, $fa = 12, $fs = 2, h = {h}, r1 = {r1}, r2 = {r2}, center = true);\n"
        )),
        Just("%text(text = \"a\", size = undef);\n".to_owned()),
        Just("group();\n".to_owned()),
    ];
    leaf.prop_recursive(4, 40, 4, move |inner| {
        let children = prop::collection::vec(inner, 0..4).prop_map(|list| list.concat());
        let head = prop_oneof![
            Just("group()".to_owned()),
            Just("difference()".to_owned()),
            Just("%intersection()".to_owned()),
            Just("#render(convexity = 1)".to_owned()),
            (-1.0..2.0).prop_map(|c: f64| format!("color([{c}, 0, 0.5, 1])")),
            (number.clone(), number.clone()).prop_map(|(a, b)| format!(
                "multmatrix([[{a}, 0, 0, 1], [0, 1, {b}, 0], [0, 0, 1, 0], [0, 0, 0, 1]])"
            )),
        ];
        (head, children).prop_map(|(head, children)| format!("{head} {{\n{children}}}\n"))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whole trees are read, and what they say lowers or is refused by name;
    /// only facets may be too many.
    #[test]
    fn whole_trees_read(text in tree_text()) {
        for faceted in [false, true] {
            match read(&text, &ReadOptions::default().faceted(faceted)) {
                Ok(scene) => { let _ = Program::lower(&scene.solid); }
                Err(error) => prop_assert!(
                    faceted && error.to_string().contains("facets"),
                    "{}: {}", text, error
                ),
            }
        }
    }

    /// Damaged trees give a scene or an error with a place in the text.
    #[test]
    fn damaged_trees_never_panic(
        text in tree_text(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..4u8, any::<u8>()), 1..6),
    ) {
        let marks = b"(){}[],;=%#\"*!/-.e1";
        let mut bytes = text.into_bytes();
        for (at, edit, byte) in edits {
            if bytes.is_empty() {
                break;
            }
            let at = at.index(bytes.len());
            match edit {
                0 => bytes[at] = byte,
                1 => { bytes.remove(at); }
                2 => bytes.insert(at, marks[usize::from(byte) % marks.len()]),
                _ => bytes.truncate(at),
            }
        }
        for faceted in [false, true] {
            match read_bytes(&bytes, &ReadOptions::default().faceted(faceted)) {
                Ok(scene) => { let _ = Program::lower(&scene.solid); }
                Err(error) => {
                    let place = error.place().expect("bytes have places");
                    let lines = bytes.iter().filter(|&&b| b == b'\n').count() + 1;
                    prop_assert!(place.line <= lines && place.column <= bytes.len() + 1);
                }
            }
        }
    }
}
