//! `csg drawing`.

use std::fs;

use serde_json::Value;

use crate::{Folder, failed, succeeded};

/// A block with a bore upright and one across.
const BLOCK: &str = "difference() {
\tcube(size = [40, 30, 20], center = true);
\tcylinder(h = 50, r1 = 5, r2 = 5, center = true);
\tmultmatrix([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]) { cylinder(h = 60, r1 = 3, r2 = 3, center = true); }
}
";

#[test]
fn hidden_lines_are_dashed_and_sizes_told() {
    let folder = Folder::new();
    fs::write(folder.file("block.csg"), BLOCK).expect("a file");
    let drawing = |options: &str| -> Value {
        let output = folder.run(&format!("drawing block.csg {options} --json -"));
        serde_json::from_slice(&succeeded(&output).stdout).expect("JSON")
    };
    let count = |json: &Value, of: &str, kind: &str| json[of][kind].as_u64().expect("a number");
    let outputs = "-o part.svg -o part.dxf -o part.pdf";
    // From above: a block with a circle in it, and the other bore's walls, up to the circle and
    // beyond.
    let top = drawing(&format!("--view top --dimensions {outputs}"));
    assert_eq!(count(&top, "visible", "lines"), 4, "{top}");
    assert_eq!(count(&top, "visible", "arcs"), 1, "{top}");
    assert!(count(&top, "hidden", "lines") >= 4, "{top}");
    assert_eq!(top["dimensions"], serde_json::json!([40.0, 30.0, 10.0]));
    let text = |name: &str| fs::read_to_string(folder.file(name)).expect("a file");
    let (svg, dxf) = (text("part.svg"), text("part.dxf"));
    for part in ["stroke-dasharray", ">40 mm<", ">30 mm<", ">⌀10 mm<"] {
        assert!(svg.contains(part), "no {part} in {svg}");
    }
    for part in [
        "\nCIRCLE\n",
        "\nHIDDEN\n",
        "\nVISIBLE\n",
        "\n40 mm\n",
        "\n%%c10 mm\n",
    ] {
        assert!(dxf.contains(part), "no {part:?}");
    }
    let pdf = fs::read(folder.file("part.pdf")).expect("a file");
    assert!(pdf.starts_with(b"%PDF") && pdf.windows(9).any(|bytes| bytes == b"Helvetica"));
    // The saddle curves of the bores are not seen from the front: from aslant they are, as
    // splines.
    let aslant = drawing("--view -1,1,-1 --unit in -o part.dxf");
    assert!(count(&aslant, "hidden", "splines") > 0, "{aslant}");
    assert!(count(&aslant, "visible", "ellipses") > 0, "{aslant}");
    let visible = drawing("--view iso --no-hidden -o part.svg");
    assert_eq!(
        visible["hidden"],
        drawing("--view top --no-hidden -o part.svg")["hidden"]
    );
    assert_eq!(count(&visible, "hidden", "lines"), 0);
}

#[test]
fn what_cannot_be_drawn_is_told() {
    let folder = Folder::new();
    for (wrong, code) in [
        ("--view above -o a.svg", 2),
        ("--view 0,0,0 -o a.svg", 2),
        ("--view top -o a.png", 2),
        ("--view top", 2),
    ] {
        failed(&folder.run(&format!("drawing in.csg {wrong}")), code);
    }
    fs::write(folder.file("nothing.csg"), "union();").expect("a file");
    let said = failed(&folder.run("drawing nothing.csg -o a.svg"), 4);
    assert!(said.contains("empty"), "{said}");
    assert_eq!(
        folder
            .files()
            .iter()
            .filter(|name| name.contains(".svg"))
            .count(),
        0
    );
}

#[test]
fn step_schemas_and_compression_are_choices_of_every_command() {
    let folder = Folder::new();
    let text = |name: &str| fs::read_to_string(folder.file(name)).expect("a file");
    succeeded(&folder.run("mesh in.csg -o old.step --step-schema ap214"));
    succeeded(&folder.run("convert in.csg same.step --step-schema ap214"));
    succeeded(&folder.run("convert in.csg new.step"));
    fs::write(folder.file("table.csv"), "model\nin.csg\n").expect("a file");
    succeeded(&folder.run("sweep table.csv -o all.csv --write row-{row}.step --step-schema ap214"));
    for (name, schema) in [
        ("old.step", "AUTOMOTIVE_DESIGN"),
        ("same.step", "AUTOMOTIVE_DESIGN"),
        ("row-1.step", "AUTOMOTIVE_DESIGN"),
        ("new.step", "AP242"),
    ] {
        assert!(text(name).contains(schema), "{name}");
    }
    if cfg!(feature = "compress") {
        succeeded(&folder.run("mesh in.csg -o plain.glb"));
        succeeded(&folder.run("mesh in.csg -o small.glb --compress"));
        let size = |name: &str| fs::metadata(folder.file(name)).expect("a file").len();
        assert!(2 * size("small.glb") < size("plain.glb"));
        let output = folder.run("info small.glb");
        let said = String::from_utf8_lossy(&succeeded(&output).stdout).into_owned();
        assert!(said.contains("triangles"), "{said}");
        let same = folder.run("compare small.glb plain.glb --within 0.0001");
        succeeded(&same);
    }
}

#[test]
fn bodies_that_are_the_same_are_written_once() {
    let folder = Folder::new();
    let ball = |k: u32| {
        let x = 3 * k;
        format!(
            "multmatrix([[1,0,0,{x}],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) {{ \
             sphere($fn = 0, $fa = 12, $fs = 2, r = 1); }}\n"
        )
    };
    let balls: String = (0..20).map(ball).collect();
    fs::write(folder.file("balls.csg"), balls).expect("a file");
    succeeded(&folder.run("mesh balls.csg -o plain.glb"));
    succeeded(&folder.run("mesh balls.csg -o once.glb -o once.gltf --instances"));
    let size = |name: &str| fs::metadata(folder.file(name)).expect("a file").len();
    assert!(8 * size("once.glb") < size("plain.glb"));
    assert!(8 * size("once.bin") < size("plain.glb"));
    let stream = folder.run("mesh balls.csg -o - --instances");
    assert_eq!(succeeded(&stream).stdout.len() as u64, size("once.glb"));
    for name in ["once.glb", "once.gltf", "plain.glb"] {
        let output = folder.run(&format!("info {name}"));
        let said = String::from_utf8_lossy(&succeeded(&output).stdout).into_owned();
        assert!(said.contains("6400"), "{said}");
    }
}

/// Twelve bored plates around an axis, of which the mesher makes different triangles.
#[test]
fn bodies_that_are_the_same_and_turned_are_written_once() {
    let folder = Folder::new();
    let plate = |k: u32| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 12.0).sin_cos();
        let (x, y) = (40.0 * cos, 40.0 * sin);
        format!(
            "multmatrix([[{cos},{},0,{x}],[{sin},{cos},0,{y}],[0,0,1,0],[0,0,0,1]]) {{ difference() {{ \
             cube(size = [8, 6, 2], center = true); \
             cylinder($fn = 0, $fa = 12, $fs = 2, h = 9, r1 = 1.5, r2 = 1.5, center = true); }} }}\n",
            -sin
        )
    };
    let plates: String = (0..12).map(plate).collect();
    fs::write(folder.file("plates.csg"), plates).expect("a file");
    succeeded(&folder.run("mesh plates.csg -o plain.glb"));
    succeeded(&folder.run("mesh plates.csg -o once.glb --instances --json told.json"));
    let size = |name: &str| fs::metadata(folder.file(name)).expect("a file").len();
    assert!(4 * size("once.glb") < size("plain.glb"));
    succeeded(&folder.run("compare once.glb plain.glb --within 0.1"));
    let told = fs::read_to_string(folder.file("told.json")).expect("a file");
    let told: Value = serde_json::from_str(&told).expect("JSON");
    // What is told is told of what was written.
    let output = folder.run("info once.glb");
    let said = String::from_utf8_lossy(&succeeded(&output).stdout).into_owned();
    assert!(said.contains(&told["triangles"].to_string()), "{said}");
    assert_eq!(
        (&told["components"], &told["closed"]),
        (&12.into(), &true.into())
    );
}

#[test]
fn vertices_of_ply_have_colours_on_request() {
    let folder = Folder::new();
    let scene = "difference() { color([1, 0, 0, 1]) { cube(size = [2, 2, 2]); }\n\
                 color([0, 0, 1, 1]) { cube(size = [1, 1, 1]); } }\n";
    fs::write(folder.file("two.csg"), scene).expect("a file");
    succeeded(&folder.run("mesh two.csg -o plain.ply"));
    succeeded(&folder.run("mesh two.csg -o split.ply --vertex-colors"));
    let stream = folder.run("mesh two.csg -o - --format ply --vertex-colors");
    let split = fs::read(folder.file("split.ply")).expect("a file");
    assert_eq!(succeeded(&stream).stdout, split);
    let read = |name: &str| io::read_mesh(folder.file(name)).expect("read");
    assert_eq!(read("split.ply"), read("plain.ply"));
    assert_ne!(split, fs::read(folder.file("plain.ply")).expect("a file"));
}

/// Without anybody to tell them, no measures are made; the file is the same.
#[test]
fn quiet_step_files_are_the_same() {
    let folder = Folder::new();
    let text = |name: &str| fs::read_to_string(folder.file(name)).expect("a file");
    for name in ["loud", "quiet", "json"] {
        fs::create_dir(folder.file(name)).expect("a folder");
    }
    let loud = folder.run("mesh in.csg -o loud/part.step");
    assert!(String::from_utf8_lossy(&succeeded(&loud).stderr).contains("volume"));
    let quiet = folder.run("mesh in.csg -o quiet/part.step --quiet");
    assert!(succeeded(&quiet).stderr.is_empty());
    let json = folder.run("mesh in.csg -o json/part.step --quiet --json -");
    assert!(String::from_utf8_lossy(&succeeded(&json).stdout).contains("\"volume\""));
    assert_eq!(text("loud/part.step"), text("quiet/part.step"));
    assert_eq!(text("loud/part.step"), text("json/part.step"));
}
