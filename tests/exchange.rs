//! Mesh files as trimesh and lib3mf, independent programs, read them: parts, whole and closed,
//! under their names and in their colours.

use std::path::Path;
use std::process::Command;

use crate::environment::python;
use serde_json::{Value, json};
use stereotomy::csg::{Color, Mesh, Mesher, Program, Solid};
use stereotomy::io::{WriteOptions, write_mesh};

/// What they find in a file of a mesh.
fn read(mesh: &Mesh, name: &str) -> Value {
    let python = python("exchange", include_str!("exchange/requirements.txt"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    write_mesh(&path, mesh, &WriteOptions::default()).expect("written");
    let output = Command::new(python)
        .args([
            Path::new("-c"),
            Path::new(include_str!("exchange/read.py")),
            &path,
        ])
        .output()
        .expect("Python runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// A pump of a hollow housing with a painted bore, and a shaft of two bodies; a base without a
/// name.
fn pump() -> Mesh {
    let brass = Color::from_srgb([1.0, 128.0 / 255.0, 0.0]);
    let steel = Color::from_srgb([64.0 / 255.0, 64.0 / 255.0, 1.0]);
    let hollow = Solid::cube(2.0).named("hollow");
    let bore = Solid::cuboid([0.2, 0.2, 1.5])
        .translate([0.0, 0.0, -1.75])
        .named("bore");
    let housing = (Solid::cube(4.0) - hollow - bore.colored(brass)).named("housing");
    let end = |x: f64| Solid::cube(1.0).translate([x, 0.0, 0.0]);
    let shaft = (end(4.0) | end(6.0)).named("shaft <&> key").colored(steel);
    let base = Solid::cuboid([9.0, 9.0, 1.0]).translate([0.0, 0.0, -4.0]);
    let solid = (housing | shaft).named("pump") | base;
    let program = Program::lower(&solid).expect("valid");
    let made = Mesher::new().tolerance(0.01).mesh(&program);
    made.expect("meshed").mesh
}

/// Whether the volumes of closed parts by these names add up to this.
fn check(found: &Value, name: &str, volume: f64) {
    let parts = found.as_array().expect("parts");
    let is_named = |part: &&Value| {
        let names = part["names"].as_array().expect("names");
        // Programs number what has the same name.
        let is = |found: &Value| found.as_str().is_some_and(|found| found.starts_with(name));
        names.iter().any(is)
    };
    let named: Vec<&Value> = parts.iter().filter(is_named).collect();
    assert!(!named.is_empty(), "no {name} in {found:#}");
    let volumes = named.iter().filter_map(|part| part["volume"].as_f64());
    let sum: f64 = volumes.sum();
    assert!((sum - volume).abs() < 1e-5 * volume, "{name}: {sum}");
}

const HOUSING: f64 = 64.0 - 8.0 - 0.04;

#[test]
fn parts_of_gltf_are_read_by_trimesh() {
    let found = read(&pump(), "pump.glb");
    let found = &found["trimesh"];
    // In metres.
    check(found, "housing", HOUSING * 1e-9);
    check(found, "shaft <&> key", 2e-9);
    check(found, "pump", (HOUSING + 2.0) * 1e-9);
    let colors: Vec<&Value> = found
        .as_array()
        .expect("parts")
        .iter()
        .map(|part| &part["color"])
        .collect();
    // Of faces, in bytes; trimesh does not turn glTF's linear numbers into sRGB.
    let linear = |color: [f32; 3]| {
        let [r, g, b] = Color::from_srgb(color)
            .rgb
            .map(|x| (255.0 * x).round() as u8);
        json!([r, g, b, 255])
    };
    for wanted in [[1.0, 128.0 / 255.0, 0.0], [64.0 / 255.0, 64.0 / 255.0, 1.0]] {
        assert!(
            colors.contains(&&linear(wanted)),
            "{wanted:?} in {colors:?}"
        );
    }
}

#[test]
fn parts_of_3mf_are_read_by_trimesh_and_lib3mf() {
    let all = read(&pump(), "pump.3mf");
    let found = &all["trimesh"];
    check(found, "housing", HOUSING);
    check(found, "shaft <&> key", 2.0);
    for part in found.as_array().expect("parts") {
        assert_eq!(part["closed"], true, "{part}");
    }
    let found = &all["lib3mf"];
    assert_eq!(found["warnings"], json!([]));
    let items = found["items"].as_array().expect("items");
    let names: Vec<&Value> = items.iter().map(|item| &item["name"]).collect();
    assert_eq!(names, ["", "pump"]);
    let parts = items[1]["parts"].as_array().expect("components");
    let brass = json!([255, 128, 0, 255]);
    let steel = json!([64, 64, 255, 255]);
    let [housing, shaft] = &parts[..] else {
        panic!("two parts in {found:#}");
    };
    assert_eq!(
        (&housing["name"], &housing["closed"]),
        (&json!("housing"), &json!(true))
    );
    assert_eq!(
        (&shaft["name"], &shaft["closed"]),
        (&json!("shaft <&> key"), &json!(true))
    );
    let colors = |part: &Value| part["colors"].as_array().expect("colours").clone();
    assert!(colors(housing).contains(&brass) && colors(housing).len() == 2);
    assert_eq!(colors(shaft), [steel]);
}

#[test]
fn parts_of_obj_are_read_by_trimesh() {
    let all = read(&pump(), "pump.obj");
    let found = all["trimesh"].as_array().expect("parts");
    let volumes = found.iter().filter_map(|part| part["volume"].as_f64());
    let sum: f64 = volumes.sum();
    assert!(
        (sum - 81.0 - HOUSING - 2.0).abs() < 1e-9,
        "{sum} in {all:#}"
    );
}
