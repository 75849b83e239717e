//! `csg mesh`.

use std::fs;
use std::time::Instant;

use serde_json::Value;

use crate::{DRILLED_VOLUME, Folder, failed, succeeded};

#[test]
fn mesh_writes_every_format_and_json() {
    let folder = Folder::new();
    let outputs = ["glb", "gltf", "obj", "stl", "ply", "3mf"].map(|e| format!("-o out.{e}"));
    let command = format!(
        "mesh in.csg {} --cells 48 --json out.json",
        outputs.join(" ")
    );
    let start = Instant::now();
    succeeded(&folder.run(&command));
    let elapsed = start.elapsed().as_secs_f64();
    let expected = [
        "out.3mf", "out.bin", "out.glb", "out.gltf", "out.json", "out.obj", "out.ply", "out.stl",
    ];
    assert_eq!(folder.files(), expected);

    let text = fs::read_to_string(folder.file("out.json")).expect("a file");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let volume = json["volume"]["value"].as_f64().expect("a number");
    assert!((volume / DRILLED_VOLUME - 1.0).abs() < 0.02, "{volume}");
    assert_eq!(json["genus"], 5);
    assert_eq!(json["components"], 1);
    assert_eq!(
        (&json["manifold"], &json["closed"]),
        (&Value::Bool(true), &Value::Bool(true))
    );
    for (axis, low) in json["bounds"]["min"]
        .as_array()
        .expect("a point")
        .iter()
        .enumerate()
    {
        let high = &json["bounds"]["max"][axis];
        assert!((low.as_f64().expect("a number") + 0.75).abs() < 0.02);
        assert!((high.as_f64().expect("a number") - 0.75).abs() < 0.02);
    }
    let mesh = io::read_mesh(folder.file("out.glb")).expect("a mesh");
    assert_eq!(json["triangles"], mesh.triangles.len());
    let seconds = json["seconds"].as_object().expect("stages");
    let total: f64 = seconds
        .iter()
        .filter(|s| s.0 != "total")
        .filter_map(|s| s.1.as_f64())
        .sum();
    assert!((total - seconds["total"].as_f64().expect("a number")).abs() < 1e-9);
    // Stages follow each other: none is counted twice.
    assert!(total < elapsed, "{total} of {elapsed}");
    assert!(json["report"]["cells_visited"].as_u64() > json["report"]["surface_cells"].as_u64());
    // A mesh that was read says in which unit it is: glTF is in metres.
    for extension in ["glb", "gltf", "obj", "stl", "ply"] {
        let mesh = io::read_mesh(folder.file(&format!("out.{extension}"))).expect("a mesh");
        let millimetres = mesh.volume() * (mesh.unit.in_metres() * 1e3).powi(3);
        assert!(
            (millimetres / volume - 1.0).abs() < 1e-5,
            "{extension} {millimetres}"
        );
    }
}

/// Of a mesh the STEP has the solid that it bounds, in its own unit.
#[test]
fn step_of_meshes_is_of_what_they_bound() {
    let folder = Folder::new();
    fs::write(
        folder.file("box.csg"),
        "cube(size = [1, 2, 3], center = false);",
    )
    .expect("a file");
    succeeded(&folder.run("mesh box.csg -o box.3mf --unit in"));
    succeeded(&folder.run("mesh box.3mf -o box.step"));
    succeeded(&folder.run("convert box.3mf again.step"));
    succeeded(&folder.run("mesh box.3mf -o both.step -o both.ply"));
    for name in ["box.step", "again.step", "both.step"] {
        let text = fs::read_to_string(folder.file(name)).expect("a file");
        assert_eq!(text.matches("ADVANCED_FACE(").count(), 6, "{name}");
        assert!(text.contains("CONVERSION_BASED_UNIT('INCH'"), "{name}");
    }
    let faces = |turned: bool| {
        let mut faces = ["0 2 1", "0 1 3", "0 3 2", "1 2 3"].map(str::to_owned);
        if turned {
            faces = faces.map(|face| face.chars().rev().collect());
        }
        format!(
            "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 {}\n",
            faces.join("\n3 ")
        )
    };
    fs::write(folder.file("turned.off"), faces(true)).expect("a file");
    let output = folder.run("mesh turned.off -o turned.step");
    let said = String::from_utf8_lossy(&succeeded(&output).stderr).into_owned();
    assert!(said.contains("inside out: they are turned"), "{said}");
    assert!(said.contains("volume      0.16666"), "{said}");
    let open = faces(false)
        .replace("\n3 1 2 3", "")
        .replace("4 4 0", "4 3 0");
    fs::write(folder.file("open.off"), open).expect("a file");
    let said = failed(&folder.run("mesh open.off -o open.step"), 4);
    assert!(said.contains("--repair mends"), "{said}");
    assert!(!folder.file("open.step").exists());
}

#[test]
fn step_has_the_exact_surfaces() {
    let folder = Folder::new();
    succeeded(&folder.run("mesh in.csg -o part.step -o part.STP -o part.stl --unit in"));
    assert_eq!(folder.files(), ["part.STP", "part.step", "part.stl"]);
    let text = fs::read_to_string(folder.file("part.step")).expect("a file");
    assert_eq!(
        text,
        fs::read_to_string(folder.file("part.STP")).expect("a file")
    );
    assert_eq!(text.lines().next(), Some("ISO-10303-21;"));
    assert_eq!(text.matches("MANIFOLD_SOLID_BREP('part'").count(), 1);
    assert!(text.contains("SPHERICAL_SURFACE") && text.contains("CONVERSION_BASED_UNIT('INCH'"));
    // No mesh is made for it alone.
    let output = folder.run("mesh in.csg -o part.STP");
    let said = String::from_utf8_lossy(&succeeded(&output).stderr).into_owned();
    assert!(
        said.contains("exact boundary") && !said.contains("triangles"),
        "{said}"
    );
    let said = failed(&folder.run("measure part.step"), 3);
    assert!(said.contains("cannot read part.step"), "{said}");
    assert_eq!(folder.files(), ["part.STP", "part.step", "part.stl"]);
}

#[test]
fn limits_end_the_work_or_make_what_fits() {
    let folder = Folder::new();
    for (limit, words) in [
        ("--limit-cells 5000 --cells 100", "5000 cells"),
        ("--limit-triangles 700 --tolerance 1e-4", "700 triangles"),
        ("--limit-memory 200K --tolerance 1e-4", "0.2 MB"),
        ("--limit-time 0 --tolerance 1e-4", "0ns"),
    ] {
        let message = failed(&folder.run(&format!("mesh in.csg -o out.stl {limit}")), 6);
        assert!(message.contains(words), "{message}");
        assert!(message.contains("--partial"), "{message}");
        assert!(!folder.file("out.stl").exists(), "{limit}");
    }
    for (limit, most) in [
        ("--limit-cells 5000 --cells 100", 5000),
        ("--limit-triangles 700 --tolerance 1e-4", 700),
        ("--limit-memory 200K --tolerance 1e-4", 2000),
        ("--limit-time 3 --tolerance 1e-9", u64::MAX),
    ] {
        let command = format!("mesh in.csg -o out.stl --json - --partial {limit}");
        let output = folder.run(&command);
        let said = String::from_utf8_lossy(&succeeded(&output).stderr).into_owned();
        assert!(said.contains("would take more than the limit"), "{said}");
        let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(json["manifold"], true);
        assert!(json["triangles"].as_u64() <= Some(most), "{limit}");
        let reached = json["report"]["limits_reached"].as_array().expect("a list");
        assert!(!reached.is_empty(), "{limit}");
        fs::remove_file(folder.file("out.stl")).expect("a file");
    }
    for wrong in ["--limit-cells -1", "--limit-memory much", "--limit-time -1"] {
        failed(&folder.run(&format!("mesh in.csg -o out.stl {wrong}")), 2);
    }
}

#[test]
fn the_size_of_cells_says_as_much_as_their_number() {
    let folder = Folder::new();
    let cell_size = |option: &str| {
        let output = folder.run(&format!("measure in.csg --json - {option}"));
        let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
        json["report"]["cell_size"].as_f64().expect("a number")
    };
    assert_eq!(cell_size("--cell-size 0.0625"), 0.0625);
    // The solid is 1.5 long.
    assert!((cell_size("--cells 24") - 0.0625).abs() < 1e-6);
    failed(&folder.run("mesh in.csg -o out.stl --cell-size 0"), 2);
    failed(
        &folder.run("mesh in.csg -o out.stl --cell-size 1 --cells 8"),
        2,
    );
}

#[test]
fn a_tolerance_an_angle_and_a_smallest_feature_are_kept() {
    let folder = Folder::new();
    let measure = |options: &str| -> Value {
        let output = folder.run(&format!("measure {options} --json -"));
        serde_json::from_slice(&succeeded(&output).stdout).expect("JSON")
    };
    let number = |value: &Value| value.as_f64().expect("a number");
    let none: &[Value] = &[];
    for tolerance in [1e-2, 1e-4] {
        let json = measure(&format!("in.csg --tolerance {tolerance}"));
        let deviation = number(&json["report"]["deviation"]);
        // As few triangles as that takes: most of it is made use of.
        assert!(
            (0.3 * tolerance..=tolerance).contains(&deviation),
            "{deviation}"
        );
        assert_eq!(
            json["report"]["fallbacks"].as_array().expect("a list"),
            none
        );
        let off = (number(&json["volume"]["value"]) - DRILLED_VOLUME).abs();
        assert!(off <= tolerance * number(&json["area"]["value"]), "{off}");
        assert_eq!(json["genus"], 5);
    }
    let text = folder.run("measure in.csg --tolerance 0.01");
    let text = String::from_utf8_lossy(&succeeded(&text).stdout).into_owned();
    assert!(text.contains("deviation   at most 0.00"), "{text}");
    // The mesh's volume, and within how much of that the solid's is.
    let line = text.lines().find_map(|line| line.strip_prefix("volume"));
    let told = line.and_then(|told| told.trim().split_once(" mm³ (the solid's within "));
    let (volume, error) = told.expect("both");
    let [volume, error] = [volume, error.trim_end_matches(')')].map(str::parse::<f64>);
    let (volume, error) = (volume.expect("a number"), error.expect("a number"));
    let off = (volume - DRILLED_VOLUME).abs();
    assert!(1e-6 < off && off <= error && error < 0.5, "{text}");

    let drum = "cylinder(h = 1, r1 = 1, r2 = 1, center = true);";
    fs::write(folder.file("drum.csg"), drum).expect("a file");
    let vertices = |options: &str| {
        let json = measure(&format!("drum.csg --tolerance 1 {options}"));
        json["vertices"].as_u64().expect("a count")
    };
    // 36 corners of both circles turn by ten degrees each.
    assert!((72..=100).contains(&vertices("--angle 10")));
    assert!(vertices("") < 36);
    // Without a tolerance it goes with the default, and not with cells, which keep none.
    let alone = measure("drum.csg --angle 5");
    assert!(
        (144..=200).contains(&alone["vertices"].as_u64().expect("a count")),
        "{alone}"
    );
    for wrong in ["--cells 9", "--draft"] {
        failed(
            &folder.run(&format!("measure drum.csg --angle 10 {wrong}")),
            2,
        );
    }

    // Cells down to a millionth would be far more than these.
    let shell = "difference() { sphere(r = 1); sphere(r = 0.999); }";
    fs::write(folder.file("shell.csg"), shell).expect("a file");
    let json = measure("shell.csg --smallest-feature 0.01");
    assert_eq!(json["report"]["method"], "adaptive");
    assert_eq!(json["components"], 2);
    assert_eq!(json["report"]["cell_size"], 0.01);
    failed(
        &folder.run("measure in.csg --smallest-feature 1 --cells 8"),
        2,
    );
    for wrong in ["--tolerance 0", "--tolerance -1", "--smallest-feature 0"] {
        let message = failed(&folder.run(&format!("measure in.csg {wrong}")), 2);
        assert!(message.contains("give a length above 0"), "{message}");
    }
}

#[test]
fn surfaces_that_were_made_one_are_told() {
    let folder = Folder::new();
    let twins = "union() { sphere(r = 1); sphere(r = 0.999999999999); }";
    fs::write(folder.file("twins.csg"), twins).expect("a file");
    fs::write(folder.file("ball.csg"), "sphere(r = 1);").expect("a file");
    let measure = |name: &str| -> Value {
        let output = folder.run(&format!("measure {name} --tolerance 0.01 --json -"));
        serde_json::from_slice(&succeeded(&output).stdout).expect("JSON")
    };
    let report = &measure("twins.csg")["report"];
    assert_eq!(report["moved"]["merged"], 1);
    assert_eq!(report["proven"], false);
    assert_eq!(report["undecided"], Value::Array(vec![]));
    let report = &measure("ball.csg")["report"];
    assert_eq!(report["moved"], Value::Null);
    assert_eq!(report["proven"], true);
    let output = folder.run("measure twins.csg --tolerance 0.01");
    let text = String::from_utf8_lossy(&succeeded(&output).stdout).into_owned();
    assert!(text.contains("(1 made one with others)"), "{text}");
}

#[test]
fn what_binary_stl_rounds_away_is_told() {
    let folder = Folder::new();
    let tube = |place: &str| {
        format!(
            "multmatrix([[1, 0, 0, {place}], [0, 0.8, -0.6, {place}], [0, 0.6, 0.8, 0], \
             [0, 0, 0, 1]]) {{ difference() {{ cylinder(h = 5, r1 = 3, r2 = 3); \
             cylinder(h = 12, r1 = 2.999, r2 = 2.999, center = true); }} }}"
        )
    };
    let said = |place: &str, output: &str| {
        fs::write(folder.file("tube.csg"), tube(place)).expect("a file");
        let output = folder.run(&format!("mesh tube.csg --tolerance 0.01 -o {output}"));
        String::from_utf8_lossy(&succeeded(&output).stderr).into_owned()
    };
    assert!(!said("0", "tube.stl").contains("warning"));
    assert!(!said("200000", "tube.ply").contains("warning"));
    let warning = said("200000", "tube.stl");
    assert!(
        warning.contains("binary STL rounds these coordinates to steps of up to 1.6e-2"),
        "{warning}"
    );
}

/// A thousandth of the distance between two balls is two fifths of their radius.
#[test]
fn small_balls_far_apart_stay_round_without_an_option() {
    let folder = Folder::new();
    let scene = "sphere(r = 0.05); multmatrix([[1, 0, 0, 20], [0, 1, 0, 0], [0, 0, 1, 0], \
                 [0, 0, 0, 1]]) { sphere(r = 0.05); }";
    fs::write(folder.file("balls.csg"), scene).expect("a file");
    let share = |options: &str| {
        let output = folder.run(&format!("mesh balls.csg {options} -o balls.stl --json -"));
        let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
        let volume = json["volume"]["value"].as_f64().expect("a number");
        volume / (8.0 / 3.0 * std::f64::consts::PI * 0.05f64.powi(3))
    };
    assert!((0.93..1.0).contains(&share("")), "{}", share(""));
    assert!(share("--tolerance 0.02") < 0.8);
    assert!(share("--angle 5") > 0.99);
}

/// Nothing is written, not even what could be, and it is said before the model is read.
#[test]
fn folders_that_are_not_there_are_told_first() {
    let folder = Folder::new();
    fs::write(folder.file("bad.csg"), "roof();").expect("a file");
    fs::write(folder.file("taken"), "").expect("a file");
    for (arguments, words) in [
        ("mesh bad.csg -o y.stl -o nodir/z.stl", "nodir/z.stl"),
        ("mesh bad.csg -o y.stl --json nodir/z.json", "nodir/z.json"),
        (
            "mesh bad.csg --cells 8 --shard 1/2 -o nodir/z.shard",
            "nodir/z.shard",
        ),
        ("mesh bad.csg -o y.step -o taken/z.stl", "taken is a file"),
        ("convert bad.csg y.stl nodir/z.csg", "nodir/z.csg"),
        (
            "section --plane z=0 bad.csg -o y.svg -o nodir/z.svg",
            "nodir/z.svg",
        ),
        ("render bad.csg -o nodir/z.png", "nodir/z.png"),
    ] {
        let message = failed(&folder.run(arguments), 5);
        assert!(message.contains(words), "{arguments}: {message}");
        assert!(message.contains("nothing was written"), "{message}");
        assert_eq!(folder.files(), ["bad.csg", "taken"], "{arguments}");
    }
}
