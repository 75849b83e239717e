//! `csg section`.

use std::fs;

use serde_json::Value;

use crate::{Folder, failed, succeeded};

/// A cone, and a tube lying beside it: cut across they give a circle, a hyperbola, rectangles.
const CONE_AND_TUBE: &str = "
cylinder(h = 10, r1 = 5, r2 = 0, center = false);
multmatrix([[0, 0, 1, 8], [0, 1, 0, 0], [-1, 0, 0, 3], [0, 0, 0, 1]]) {
\tdifference() {
\t\tcylinder(h = 10, r1 = 3, r2 = 3, center = false);
\t\tcylinder(h = 30, r1 = 2, r2 = 2, center = true);
\t}
}
";

#[test]
fn sections_are_exact_and_come_in_every_format() {
    let folder = Folder::new();
    fs::write(folder.file("both.csg"), CONE_AND_TUBE).expect("a file");
    let section = |options: &str| -> Value {
        let output = folder.run(&format!("section both.csg {options} --json -"));
        serde_json::from_slice(&succeeded(&output).stdout).expect("JSON")
    };
    let area = |json: &Value| json["area"]["value"].as_f64().expect("a number");
    let outputs = "-o cut.svg -o cut.dxf -o cut.pdf";
    // Through the axis of the tube: its wall is cut twice, and the cone in a circle.
    let level = section(&format!("--plane z=3 {outputs}"));
    let wanted = 2.0 * 10.0 + std::f64::consts::PI * 3.5_f64.powi(2);
    assert!((area(&level) - wanted).abs() < 1e-10, "{level}");
    assert_eq!((&level["parts"], &level["holes"]), (&3.into(), &0.into()));
    assert_eq!((&level["lines"], &level["arcs"]), (&8.into(), &1.into()));
    let text = |name: &str| fs::read_to_string(folder.file(name)).expect("a file");
    assert_eq!(text("cut.svg").matches('A').count(), 3);
    assert!(text("cut.svg").contains("mm\""));
    assert_eq!(text("cut.dxf").matches("\nLWPOLYLINE\n").count(), 2);
    assert_eq!(text("cut.dxf").matches("\nCIRCLE\n").count(), 1);
    assert!(
        fs::read(folder.file("cut.pdf"))
            .expect("a file")
            .starts_with(b"%PDF")
    );
    // Beside the cone's axis: a hyperbola between two points of the base.
    let beside = section("--plane y=1 -o cut.dxf");
    assert_eq!(beside["conics"], 1);
    assert!(text("cut.dxf").contains("\nSPLINE\n"));
    // Steeper than the axis, and less steep than the cone: an ellipse.
    let tilted = section("--plane 0,0.3,1:0,0,5 -o cut.svg");
    assert!(tilted["ellipses"].as_u64() >= Some(1), "{tilted}");
}

/// From the front x is on the right and z upwards, and from behind x is on the left.
#[test]
fn planes_are_seen_from_the_front_above_and_the_right() {
    let folder = Folder::new();
    let scene = "cube(size = [1, 2, 3], center = false);";
    fs::write(folder.file("box.csg"), scene).expect("a file");
    for (plane, view) in [
        ("z=1", "0 -2 1 2"),
        ("y=1", "0 -3 1 3"),
        ("x=0.5", "0 -3 2 3"),
        ("-y=1", "-1 -3 1 3"),
        ("-x=0.5", "-2 -3 2 3"),
    ] {
        let output = folder.run(&format!("section box.csg --plane {plane} -o - -q"));
        let text = String::from_utf8_lossy(&succeeded(&output).stdout).into_owned();
        assert!(output.stderr.is_empty());
        let (_, after) = text.split_once("viewBox=\"").expect("a view");
        let (found, _) = after.split_once('"').expect("its end");
        let numbers = |text: &str| -> Vec<f64> {
            text.split(' ')
                .map(|n| n.parse().expect("a number"))
                .collect()
        };
        let (found, wanted) = (numbers(found), numbers(view));
        // There is a margin of two hundredths of the longer side.
        let margin = 0.02 * wanted[2].max(wanted[3]);
        for (k, wanted) in wanted.into_iter().enumerate() {
            let wanted = if k < 2 {
                wanted - margin
            } else {
                wanted + 2.0 * margin
            };
            assert!((found[k] - wanted).abs() < 1e-9, "{plane}: {text}");
        }
    }
}

#[test]
fn faces_in_the_plane_are_told_and_nothing_is_an_error() {
    let folder = Folder::new();
    let scene = "cube(size = [2, 2, 2], center = true);\n\
                 multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]) {\n\
                 \tcube(size = [2, 2, 2], center = true);\n}";
    fs::write(folder.file("steps.csg"), scene).expect("a file");
    let said = |options: &str| {
        let output = folder.run(&format!("section steps.csg {options} -o cut.svg"));
        String::from_utf8_lossy(&succeeded(&output).stderr).into_owned()
    };
    assert!(said("--plane z=0.5").contains("parts       1"));
    assert!(!said("--plane z=0.5").contains("warning"));
    // The one ends where the other one begins.
    let level = said("--plane z=1");
    assert!(
        level.contains("warning") && level.contains("face in the plane"),
        "{level}"
    );
    // On the very top there is what lies below.
    assert!(said("--plane z=3").contains("area        4.0000"));
    assert!(said("--plane -z=-1").contains("area        4.0000"));
    let message = failed(&folder.run("section steps.csg --plane z=9 -o no.svg"), 4);
    assert!(message.contains("does not meet the solid"), "{message}");
    assert!(!folder.file("no.svg").exists());
    for wrong in [
        "--plane up -o a.svg",
        "--plane z=0 -o a.dwg",
        "--plane z=0",
        "--plane z=0 -o a.svg --tolerance -1",
        "--plane z=0 -o - --json -",
    ] {
        failed(&folder.run(&format!("section steps.csg {wrong}")), 2);
    }
}
