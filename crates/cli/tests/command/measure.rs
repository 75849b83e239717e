//! `csg measure`.

use std::f64::consts::PI;
use std::fs;

use serde_json::Value;

use crate::{DRILLED_VOLUME, Folder, failed, succeeded};

#[test]
fn measure_reads_meshes_too() {
    let folder = Folder::new();
    succeeded(&folder.run("mesh in.csg -o part.ply --cells 32"));
    let of_scene = folder.run("measure in.csg --cells 32 --json -");
    let of_mesh = folder.run("measure part.ply --json -");
    let [scene, mesh] = [of_scene, of_mesh]
        .map(|output| serde_json::from_slice::<Value>(&succeeded(&output).stdout).expect("JSON"));
    for key in ["triangles", "vertices", "genus", "manifold"] {
        assert_eq!(scene[key], mesh[key], "{key}");
    }
    let text = folder.run("measure part.ply");
    let text = String::from_utf8_lossy(&succeeded(&text).stdout).into_owned();
    assert!(
        text.contains("volume") && text.contains("genus       5"),
        "{text}"
    );
}

/// Without options that ask for a mesh, a solid's measures are those of its exact boundary, told
/// to the last digit that is known.
#[test]
fn measures_of_solids_are_exact_and_say_how_far() {
    let folder = Folder::new();
    let output = folder.run("measure in.csg --json - --unit cm");
    let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
    let bound = |name: &str| json["volume"][name].as_f64().expect("a number");
    assert!(bound("lower") <= DRILLED_VOLUME && DRILLED_VOLUME <= bound("upper"));
    assert!(bound("upper") - bound("lower") < 1e-11, "{json}");
    assert_eq!(json["genus"], 5);
    assert_eq!((&json["faces"], &json["edges"]), (&13.into(), &24.into()));
    let text = folder.run("measure in.csg --unit cm");
    let text = String::from_utf8_lossy(&succeeded(&text).stdout).into_owned();
    assert!(
        text.contains("volume      0.98878955719") && text.contains("cm³"),
        "{text}"
    );
    assert!(!text.contains("triangles"), "{text}");

    // Of a mesh within its proven deviation.
    let output = folder.run("measure in.csg --json - --tolerance 0.001");
    let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
    let bound = |name: &str| json["volume"][name].as_f64().expect("a number");
    assert!(bound("lower") <= DRILLED_VOLUME && DRILLED_VOLUME <= bound("upper"));
    assert!(bound("upper") - bound("lower") < 0.1, "{json}");
    // What is exact but for rounding is told to be no more than that: the sum of this one is off.
    let concave = "linear_extrude(height = 5) polygon(points = [[0, 0], [2, 4], [8, 4], [10, 0], [10, 10], [0, 10]]);";
    fs::write(folder.file("concave.csg"), concave).expect("a scene");
    let output = folder.run("measure concave.csg --json - --tolerance 0.001");
    let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
    let bound = |name: &str| json["volume"][name].as_f64().expect("a number");
    assert!(bound("lower") <= 340.0 && 340.0 <= bound("upper"), "{json}");
    assert!(bound("upper") - bound("lower") < 340e-12, "{json}");
    // Cells prove nothing.
    let output = folder.run("measure in.csg --json - --cells 32");
    let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
    assert_eq!(json["volume"]["upper"], Value::Null);
}

/// OpenSCAD's sphere of 400 corners around, in 200 rings: 80,000 flat faces, measured as a mesh.
#[test]
fn large_polyhedra_are_measured_quickly_and_exactly() {
    let folder = Folder::new();
    fs::write(folder.file("ball.csg"), "sphere(r = 1, $fn = 400);").expect("a scene");
    let output = folder.run("measure ball.csg --faceted --json -");
    let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
    let ring = |k: u32| {
        let (radius, z) = (PI * (f64::from(k) + 0.5) / 200.0).sin_cos();
        (
            200.0 * (std::f64::consts::TAU / 400.0).sin() * radius * radius,
            z,
        )
    };
    let between = |k: u32| {
        let ((area, z), (next, below)) = (ring(k), ring(k + 1));
        (z - below) / 3.0 * (area + next + (area * next).sqrt())
    };
    let volume: f64 = (0..199).map(between).sum();
    let bound = |name: &str| json["volume"][name].as_f64().expect("a number");
    assert!(
        bound("lower") <= volume && volume <= bound("upper"),
        "{volume} {json}"
    );
    assert!(bound("upper") - bound("lower") < 1e-9, "{json}");
    assert!(
        json["triangles"].as_u64().is_some_and(|n| n > 100_000),
        "{json}"
    );
}

#[test]
fn faceted_gives_polygons() {
    let folder = Folder::new();
    let scene = "cylinder($fn = 24, $fa = 12, $fs = 2, h = 1, r1 = 1, r2 = 1, center = false);";
    fs::write(folder.file("round.csg"), scene).expect("a file");
    let volume = |command: &str| {
        let output = folder.run(command);
        let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
        json["volume"]["value"].as_f64().expect("a number")
    };
    let round = volume("measure round.csg --json - --cells 128");
    let faceted = volume("measure round.csg --faceted --json - --cells 128");
    let tau = std::f64::consts::TAU;
    // Polygon and circle differ by 1.1%, more than the mesh from either.
    assert!((round - tau / 2.0).abs() < 0.004 * round, "{round}");
    assert!(
        (faceted - 12.0 * (tau / 24.0).sin()).abs() < 0.004 * round,
        "{faceted}"
    );
}

#[test]
fn a_model_of_which_nothing_is_left_is_warned_about() {
    let folder = Folder::new();
    let scene = "difference() { sphere(r = 1); cube(size = [3, 3, 3], center = true); }";
    let output = folder.run_with_input("measure -", scene);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("nothing is left of the model's 2 primitives"),
        "{said}"
    );
    assert!(said.contains("takes all of the first operand"), "{said}");
    assert!(
        said.contains("operand 2 lies between -1.5 -1.5 -1.5 and 1.5 1.5 1.5"),
        "{said}"
    );
    // A corner in the origin is told as that, and not as what rounding makes of it.
    let scene = "difference() { cube(size = [1, 1, 1]); cube(size = [3, 3, 3], center = true); }";
    let output = folder.run_with_input("measure -", scene);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("operand 1 lies between 0 0 0 and 1 1 1"),
        "{said}"
    );
    let scene = "intersection() { sphere(r = 1); multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], \
                 [0, 0, 1, 0], [0, 0, 0, 1]]) { sphere(r = 1); } }";
    let output = folder.run_with_input("mesh - -o empty.step", scene);
    let said = failed(&output, 4);
    assert!(
        said.contains("operands 1 and 2 are 1 apart along x"),
        "{said}"
    );
    let output = folder.run_with_input("measure -", "group();");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains("nothing is left"), "{said}");
}

/// Two cubes of side 1 as OBJ, an object each, the second one moved so.
fn two_cubes(offset: [f64; 3]) -> String {
    let mut text = String::new();
    for (number, offset) in [[0.0; 3], offset].into_iter().enumerate() {
        text += &format!("o Part{number}\n");
        for k in 0..8_u32 {
            let corner = [k & 1, k >> 1 & 1, k >> 2].map(f64::from);
            let [x, y, z] = [0, 1, 2].map(|axis: usize| corner[axis] + offset[axis]);
            text += &format!("v {x} {y} {z}\n");
        }
        for face in [
            "1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6",
        ] {
            let corners = face.split(' ').map(|corner| {
                let corner: usize = corner.parse().expect("a number");
                (8 * number + corner).to_string()
            });
            text += &format!("f {}\n", corners.collect::<Vec<_>>().join(" "));
        }
    }
    text
}

/// A file with a unit is measured in it, whatever is asked of scenes, and scenes convert what
/// they import.
#[test]
fn files_are_measured_in_their_own_unit() {
    let folder = Folder::new();
    fs::write(folder.file("cube.csg"), "cube(1);").expect("a file");
    fs::write(folder.file("import.csg"), "import(\"cube.3mf\");").expect("a file");
    succeeded(&folder.run("mesh cube.csg --unit in -o cube.3mf -o cube.stl -q"));
    let measured = |arguments: &str, volume: f64, unit: &str| {
        let output = folder.run(&format!("measure {arguments} --json -"));
        let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
        let found = json["volume"]["value"].as_f64().expect("a number");
        assert!((found / volume - 1.0).abs() < 1e-12, "{arguments}: {json}");
        assert_eq!(json["unit"], unit, "{arguments}");
        let text = folder.run(&format!("measure {arguments}"));
        let text = String::from_utf8_lossy(&succeeded(&text).stdout).into_owned();
        assert!(text.contains(&format!("{unit}³")), "{text}");
    };
    measured("cube.3mf", 1.0, "in");
    measured("cube.3mf --unit cm", 1.0, "in");
    measured("cube.3mf --repair", 1.0, "in");
    measured("cube.stl", 1.0, "mm");
    measured("cube.stl --unit ft", 1.0, "ft");
    measured("cube.stl --repair --unit ft", 1.0, "ft");
    measured("import.csg", 25.4_f64.powi(3), "mm");
    measured("import.csg --unit in", 1.0, "in");
    let output = folder.run("measure import.csg");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains("converted from in to mm: 25.4 times"),
        "{said}"
    );
    // Meshes of solids and of meshes say it, too; scenes have no unit.
    succeeded(&folder.run("convert cube.3mf cube.glb scene.csg"));
    measured("cube.glb", 1.0, "in");
    measured("scene.csg", 25.4_f64.powi(3), "mm");
    let section = folder.run("section --plane z=1 cube.3mf -o a.svg --unit cm --json -");
    let json: Value = serde_json::from_slice(&succeeded(&section).stdout).expect("JSON");
    let area = json["area"]["value"].as_f64().expect("a number");
    assert!((area - 2.54 * 2.54).abs() < 1e-12, "{json}");
}

/// What a scene has in place of a torus strays from it: measures say so, and a tolerance holds for both.
#[test]
fn what_stands_for_a_torus_is_told() {
    let folder = Folder::new();
    let ring = "rotate_extrude() { translate([5, 0]) { circle(r = 2); } }";
    fs::write(folder.file("ring.csg"), ring).expect("a file");
    let told = |arguments: &str| -> [f64; 4] {
        let output = folder.run(&format!("measure ring.csg {arguments} --json -"));
        let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
        let bounds = &json["bounds"]["max"][0];
        let deviation = &json["report"]["deviation"];
        let number = |value: &Value| value.as_f64();
        let strays = number(&json["strays"]).expect("how far it strays");
        let measured = number(&json["volume"]["value"]).expect("a volume");
        let widest = number(bounds).expect("a box");
        [strays, number(deviation).unwrap_or(0.0), measured, widest]
    };
    let volume = 2.0 * PI * 5.0 * PI * 4.0;
    let area = 4.0 * PI * PI * 10.0;
    for (arguments, tolerance) in [
        ("", 1e-3),
        ("--tolerance 0.02", 0.02),
        ("--tolerance 0.2", 0.2),
    ] {
        let [strays, deviation, measured, widest] = told(arguments);
        assert!(
            0.05 * tolerance < strays && strays + deviation <= 1.001 * tolerance,
            "{arguments}: {strays} {deviation}"
        );
        assert!(
            (measured - volume).abs() <= tolerance * area,
            "{arguments}: {measured}, not {volume}"
        );
        assert!(
            (widest - 7.0).abs() <= 1.001 * tolerance,
            "{arguments}: {widest}"
        );
    }
    let output = folder.run("measure ring.csg");
    let text = &succeeded(&output).stdout;
    assert!(String::from_utf8_lossy(text).contains("\nstrays      by at most "));
}

#[test]
fn objects_that_meet_are_told_and_united_if_asked() {
    let folder = Folder::new();
    let import = "import(\"two.obj\");";
    fs::write(folder.file("import.csg"), import).expect("a file");
    for (offset, union) in [([1.0, 0.0, 0.0], 2.0), ([0.5; 3], 1.875)] {
        fs::write(folder.file("two.obj"), two_cubes(offset)).expect("a file");
        let volume = |arguments: &str| {
            let output = folder.run(&format!("measure {arguments} --json -"));
            let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            (json["volume"]["value"].as_f64().expect("a number"), said)
        };
        let (sum, said) = volume("two.obj");
        assert!((sum - 2.0).abs() < 1e-12);
        assert!(
            said.contains("objects 1 and 2 of 2") && said.contains("--repair"),
            "{said}"
        );
        for arguments in ["two.obj --repair", "import.csg"] {
            let (found, said) = volume(arguments);
            assert!((found - union).abs() < 1e-12, "{arguments}: {found}");
            assert_eq!(said, "", "{arguments}");
        }
    }
    // Apart.
    fs::write(folder.file("two.obj"), two_cubes([3.0; 3])).expect("a file");
    let output = folder.run("measure two.obj");
    assert_eq!(String::from_utf8_lossy(&succeeded(&output).stderr), "");
    // What bounds no solid says how it is mended, in a scene as by itself.
    let text = two_cubes([0.5; 3]);
    let open = text.rsplit_once("f ").expect("faces").0;
    fs::write(folder.file("two.obj"), open).expect("a file");
    let message = failed(&folder.run("measure import.csg"), 3);
    assert!(message.contains("import.csg:1:1: import"), "{message}");
    assert!(
        message.contains("hint: --repair mends what it can"),
        "{message}"
    );
    succeeded(&folder.run("measure import.csg --repair"));
}
