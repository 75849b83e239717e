//! `csg compare`, `csg convert` and `csg info`.

use std::fs;

use serde_json::Value;

use crate::{DRILLED_VOLUME, Folder, failed, succeeded};

fn compared(folder: &Folder, arguments: &str, code: i32) -> Value {
    let output = folder.run(&format!("compare {arguments} --json -"));
    failed(&output, code);
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// Balls of one middle differ by a shell as thick as their radii differ.
#[test]
fn differences_are_within_their_bounds() {
    let folder = Folder::new();
    fs::write(folder.file("one.csg"), "sphere(r = 1);").expect("a file");
    fs::write(folder.file("less.csg"), "sphere(r = 0.9);").expect("a file");
    let json = compared(&folder, "one.csg less.csg", 1);
    let bounds =
        |value: &Value| ["lower", "upper"].map(|end| value[end].as_f64().expect("a number"));
    let shell = 4.0 / 3.0 * std::f64::consts::PI * (1.0 - 0.9_f64.powi(3));
    for (name, wanted) in [("difference", shell), ("in_one", shell), ("in_other", 0.0)] {
        let [lower, upper] = bounds(&json["volumes"][name]);
        assert!(
            lower <= wanted && wanted <= upper && upper - lower < 1e-10,
            "{name}: {json}"
        );
    }
    let [lower, upper] = bounds(&json["distance"]);
    assert!(
        lower <= 0.1 && 0.1 <= upper && upper - lower < 1e-3,
        "{json}"
    );
    assert_eq!(json["witness"]["inside"], "one");
    let point = json["witness"]["point"].as_array().expect("a point");
    let square: f64 = point
        .iter()
        .map(|x| x.as_f64().expect("a number").powi(2))
        .sum();
    assert!((0.9..=1.0).contains(&square.sqrt()), "{json}");
    // As near as that they are equal.
    assert_eq!(
        compared(&folder, "one.csg less.csg --within 0.11", 0)["equal"],
        true
    );
    assert_eq!(
        compared(&folder, "one.csg less.csg --within 0.09", 1)["equal"],
        false
    );
    // Just so far apart: meshes do not tell.
    let json = compared(&folder, "one.csg less.csg --within 0.1", 1);
    let [lower, upper] = bounds(&json["distance"]);
    assert!(json["equal"].is_null(), "{json}");
    assert!(
        lower <= 0.1 && 0.1 < upper && upper - lower < 2e-3,
        "{json}"
    );
    let text = folder.run("compare one.csg less.csg");
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(
        text.contains("is in A alone") && text.ends_with("different\n"),
        "{text}"
    );
}

/// Plates that differ by a bore's radius, and what is moved: the distance is known, and told to a
/// tenth of it.
#[test]
fn distances_are_told_as_they_are() {
    let folder = Folder::new();
    let bored = |radius: f64| {
        format!(
            "difference() {{ cylinder(h = 4, r1 = 20, r2 = 20, center = true); \
             cylinder(h = 9, r1 = {radius}, r2 = {radius}, center = true); }}"
        )
    };
    let moved = |what: &str, by: f64| {
        format!(
            "multmatrix([[1, 0, 0, {by}], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {{ {what} }}"
        )
    };
    let (ball, cube) = ("sphere(r = 3);", "cube(size = [3, 2, 1], center = true);");
    for (one, other, distance) in [
        (bored(8.0), bored(8.01), 0.01),
        (bored(8.0), bored(8.5), 0.5),
        (ball.into(), moved(ball, 0.5), 0.5),
        (cube.into(), moved(cube, 0.1), 0.1),
    ] {
        fs::write(folder.file("one.csg"), &one).expect("a file");
        fs::write(folder.file("other.csg"), &other).expect("a file");
        let json = compared(&folder, "one.csg other.csg", 1);
        let [lower, upper] =
            ["lower", "upper"].map(|end| json["distance"][end].as_f64().expect("a number"));
        assert!(
            lower <= distance + 1e-15 && distance <= upper && upper - lower <= 0.1 * distance,
            "{distance}: {json}"
        );
    }
    // A plate and its own mesh, whose long triangles lie across those of another one.
    fs::write(folder.file("one.csg"), bored(8.0)).expect("a file");
    succeeded(&folder.run("mesh one.csg -o one.stl --tolerance 0.01 -q"));
    compared(&folder, "one.csg one.stl --within 0.015", 0);
}

#[test]
fn equal_solids_are_equal_however_they_are_written() {
    let folder = Folder::new();
    let other = "intersection() {
\tdifference() {
\t\tsphere(r = 1);
\t\tunion() {
\t\t\tmultmatrix([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]) { cylinder(h = 9, r1 = 0.5, r2 = 0.5, center = true); }
\t\t\tmultmatrix([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]) { cylinder(h = 9, r1 = 0.5, r2 = 0.5, center = true); }
\t\t\tcylinder(h = 9, r1 = 0.5, r2 = 0.5, center = true);
\t\t}
\t}
\tcube(size = [1.5, 1.5, 1.5], center = true);
}";
    fs::write(folder.file("other.csg"), other).expect("a file");
    let json = compared(&folder, "in.csg other.csg", 0);
    assert_eq!(json["equal"], true);
    assert_eq!(json["volumes"]["difference"]["upper"], 0.0);
    assert_eq!(json["distance"]["upper"], 0.0);
    assert_eq!(json["witness"], Value::Null);
}

/// Meshes are compared with what they were made of, and no farther from it than they say.
#[test]
fn what_is_converted_is_near_to_what_it_was() {
    let folder = Folder::new();
    succeeded(&folder.run("convert in.csg out.stl again.csg part.step --tolerance 0.01"));
    succeeded(&folder.run("convert out.stl out.obj"));
    assert_eq!(
        folder.files(),
        ["again.csg", "out.obj", "out.stl", "part.step"]
    );
    assert_eq!(compared(&folder, "in.csg again.csg", 0)["equal"], true);
    // (Binary STL is of single precision.)
    assert_eq!(compared(&folder, "out.stl out.obj", 0)["equal"], true);
    let json = compared(&folder, "in.csg out.obj --within 0.0101", 0);
    assert!(json["distance"]["upper"].as_f64() > Some(0.003), "{json}");
    let one = json["volumes"]["one"]["value"].as_f64().expect("a number");
    assert!((one - DRILLED_VOLUME).abs() < 1e-11);
    succeeded(&folder.run("convert out.stl out.csg"));
    let same = compared(&folder, "out.csg out.stl --within 1e-9", 0);
    assert_eq!(same["equal"], true);
    failed(&folder.run("convert in.csg out.dwg"), 2);
}

#[test]
fn what_is_empty_is_told() {
    let folder = Folder::new();
    let text = "difference() { sphere(r = 1); sphere(r = 2); }";
    fs::write(folder.file("nothing.csg"), text).expect("a file");
    let message = failed(&folder.run("compare in.csg nothing.csg"), 1);
    assert!(
        message.contains("warning: nothing.csg: nothing is left") && message.contains("operand 1"),
        "{message}"
    );
    fs::write(folder.file("blank.csg"), "").expect("a file");
    let text = folder.run("info blank.csg");
    let text = String::from_utf8_lossy(&succeeded(&text).stdout).into_owned();
    assert!(text.contains("surfaces    none"), "{text}");
}

#[test]
fn info_tells_what_is_there() {
    let folder = Folder::new();
    let info = |name: &str| -> Value {
        let output = folder.run(&format!("info {name} --json -"));
        serde_json::from_slice(&succeeded(&output).stdout).expect("JSON")
    };
    let solid = info("in.csg");
    assert_eq!(solid["kind"], "solid");
    assert_eq!(solid["primitives"], 5);
    assert_eq!(
        (&solid["surfaces"]["cylinder"], &solid["surfaces"]["sphere"]),
        (&3.into(), &1.into())
    );
    succeeded(&folder.run("mesh in.csg -o part.glb --tolerance 0.01 -q"));
    let mesh = info("part.glb");
    assert_eq!(
        (&mesh["kind"], &mesh["normals"]),
        (&"mesh".into(), &true.into())
    );
    let text = folder.run("info part.glb");
    let text = String::from_utf8_lossy(&succeeded(&text).stdout).into_owned();
    let triangles = format!("triangles   {}", mesh["triangles"]);
    assert!(text.contains(&triangles), "{text}");
}

/// Both are brought to one unit, and objects that overlap are one solid.
#[test]
fn units_and_objects_are_compared_as_what_they_are() {
    let folder = Folder::new();
    for (name, text) in [
        ("inch.csg", "cube(1);"),
        ("mm.csg", "cube(25.4);"),
        ("union.csg", "cube(1); translate([0.5, 0, 0]) cube(1);"),
    ] {
        fs::write(folder.file(name), text).expect("a file");
    }
    succeeded(&folder.run("mesh inch.csg --unit in -o inch.3mf -o inch.glb -o bare.stl -q"));
    succeeded(&folder.run("mesh mm.csg -o mm.3mf -q"));
    let same = compared(&folder, "inch.3mf mm.csg --within 1e-6", 0);
    assert_eq!(same["unit"], "mm");
    compared(&folder, "inch.3mf mm.3mf --within 1e-6", 0);
    compared(&folder, "inch.glb mm.3mf --within 1e-6 --repair", 0);
    let different = compared(&folder, "inch.csg inch.3mf", 1);
    let volume = different["volumes"]["other"]["value"].as_f64();
    assert!((volume.expect("a number") - 25.4_f64.powi(3)).abs() < 1e-6);
    // Numbers without a unit, and of a scene, are of the unit that is asked for.
    let same = compared(&folder, "inch.csg inch.3mf --unit in", 0);
    assert_eq!(same["unit"], "in");
    compared(&folder, "bare.stl inch.3mf --unit in", 0);
    compared(&folder, "mm.3mf inch.3mf --unit in --within 1e-9", 0);
    let output = folder.run("compare inch.3mf mm.csg");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains("inch.3mf are converted from in to mm (--unit)"),
        "{said}"
    );

    succeeded(&folder.run("mesh inch.csg -o bare.obj -q"));
    let cube = fs::read_to_string(folder.file("bare.obj")).expect("a mesh");
    let vertices = |line: &str| -> Option<[f64; 3]> {
        let numbers = line.strip_prefix("v ")?.split(' ');
        let numbers: Vec<f64> = numbers.map(|n| n.parse().expect("a number")).collect();
        numbers.try_into().ok()
    };
    let mut two = format!("o One\n{cube}o Two\n");
    for line in cube.lines() {
        match vertices(line) {
            Some([x, y, z]) => two += &format!("v {} {y} {z}\n", x + 0.5),
            None if line.starts_with("f ") => {
                let corners = line.split(' ').skip(1).map(|corner| {
                    let number: usize =
                        corner.split('/').next().unwrap_or("").parse().expect("one");
                    (number + 8).to_string()
                });
                two += &format!("f {}\n", corners.collect::<Vec<_>>().join(" "));
            }
            None => {}
        }
    }
    fs::write(folder.file("two.obj"), two).expect("written");
    let same = compared(&folder, "two.obj union.csg", 0);
    assert_eq!(same["equal"], true);
    let other = compared(&folder, "two.obj inch.csg", 1);
    let lower = other["distance"]["lower"].as_f64().expect("a number");
    assert!((lower - 0.5).abs() < 0.01, "{other}");
}
