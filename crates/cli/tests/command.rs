//! The `csg` command as a user runs it.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::time::Instant;

use serde_json::Value;

const DRILLED: &str = "difference() {
\tintersection() { cube(size = [1.5, 1.5, 1.5], center = true); sphere(r = 1); }
\tcylinder(h = 4, r1 = 0.5, r2 = 0.5, center = true);
\tmultmatrix([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]) { cylinder(h = 4, r1 = 0.5, r2 = 0.5, center = true); }
\tmultmatrix([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]) { cylinder(h = 4, r1 = 0.5, r2 = 0.5, center = true); }
}
";
/// The exact volume of [`DRILLED`].
const DRILLED_VOLUME: f64 = 0.988_789_557_199_477;

/// A folder of its own with a scene in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        fs::write(folder.file("in.csg"), DRILLED).expect("a file");
        folder
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the command here, words separated by spaces.
    fn run(&self, arguments: &str) -> Output {
        self.run_with_input(arguments, "")
    }

    fn run_with_input(&self, arguments: &str, input: &str) -> Output {
        let mut child = Command::new(env!("CARGO_BIN_EXE_csg"))
            .args(arguments.split_whitespace())
            .current_dir(self.0.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command runs");
        let mut stdin = child.stdin.take().expect("its input");
        // A command that fails early does not read it.
        let _ = stdin.write_all(input.as_bytes());
        drop(stdin);
        child.wait_with_output().expect("the command ends")
    }

    /// Names of all files here but the scene, sorted.
    fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("a folder");
        let mut names: Vec<String> = entries
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .filter(|name| name != "in.csg")
            .collect();
        names.sort();
        names
    }
}

fn succeeded(output: &Output) -> &Output {
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    output
}

/// Asserts the exit code, and returns what was said.
fn failed(output: &Output, code: i32) -> String {
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{message}");
    message
}

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

#[test]
fn step_has_the_exact_surfaces_and_needs_a_solid() {
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
    let said = failed(&folder.run("mesh part.stl -o other.step"), 5);
    assert!(
        said.contains("from the exact boundary of a solid, not from a mesh"),
        "{said}"
    );
    let said = failed(&folder.run("measure part.step"), 3);
    assert!(said.contains("cannot read part.step"), "{said}");
    assert_eq!(folder.files(), ["part.STP", "part.step", "part.stl"]);
}

#[test]
fn streams_carry_the_scene_the_mesh_and_the_json() {
    let folder = Folder::new();
    let output = folder.run_with_input("mesh - -o - --format stl --cells 32", DRILLED);
    let mesh = io::stl::read_stl(&succeeded(&output).stdout).expect("an STL mesh");
    assert!((mesh.volume() / DRILLED_VOLUME - 1.0).abs() < 0.05);

    let output = folder.run_with_input("measure - --json - --cells 32", DRILLED);
    let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
    assert_eq!(json["genus"], 5);

    let output = folder.run("render in.csg -o - --size 40x30 --cells 32");
    assert!(succeeded(&output).stdout.starts_with(b"\x89PNG"));

    let message = failed(&folder.run("mesh in.csg -o - --json -"), 2);
    assert!(message.contains("standard output"), "{message}");
    assert_eq!(folder.files(), [] as [&str; 0]);
}

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
    // Cells prove nothing.
    let output = folder.run("measure in.csg --json - --cells 32");
    let json: Value = serde_json::from_slice(&succeeded(&output).stdout).expect("JSON");
    assert_eq!(json["volume"]["upper"], Value::Null);
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
fn render_frames_the_model() {
    let folder = Folder::new();
    let cameras = ["iso", "top", "-1,2,-1", "3,-4,2:0,0,0", "0,0,-1"];
    for (index, camera) in cameras.iter().enumerate() {
        let command = format!(
            "render in.csg -o {index}.png --size 96x64 --cells 32 --camera {camera} --background ffffff"
        );
        succeeded(&folder.run(&command));
        let file = fs::read(folder.file(&format!("{index}.png"))).expect("a file");
        // Width and height stand in the header.
        assert_eq!(&file[16..24], [0, 0, 0, 96, 0, 0, 0, 64]);
    }
    succeeded(&folder.run("render in.csg -o p.png --orthographic --cells 32 --size 96x64"));
    let [perspective, parallel] =
        ["0.png", "p.png"].map(|name| fs::read(folder.file(name)).expect("a file"));
    assert_ne!(perspective, parallel);
}

/// Every option for looks changes the picture, each in its own way.
#[test]
fn render_has_an_option_for_every_look() {
    let folder = Folder::new();
    let mut pictures = Vec::new();
    for looks in [
        "",
        "--plain",
        "--plain --shading flat",
        "--plain --shading gouraud",
        "--plain --anti-aliasing none",
        "--plain --anti-aliasing msaa8",
        "--plain --anti-aliasing supersample2",
        "--plain --anti-aliasing supersample4",
        "--plain --edges",
        "--plain --edges --line-width 3",
        "--plain --hidden-edges",
        "--plain --wireframe",
        "--plain --points",
        "--plain --section -y=0",
        "--plain --section -y=0 --section 0,0,1:0,0,0.4",
        "--plain --ambient-occlusion",
        "--plain --shadow",
        "--plain --material 0.5,0.5,0.8,4",
        "--plain --light 1,0,0:ff8800",
        "--plain --point-light 2,-2,3",
        "--plain --ambient 800000",
        "--plain --environment 4466ff:553311",
        "--plain --checker 0.3",
        "--plain --camera -1,1,-1 --up 1,0,0",
        "--plain --near 3.5",
        "--plain --far 3.5",
        "--hidden-surface zbuffer",
        "--hidden-surface wireframe",
        "--show depth --depth-bits 12",
        "--plain --axes",
        "--plain --show depth",
        "--plain --show normals",
        "--plain --show surfaces",
        "--plain --show occlusion",
        "--plain --projection ortho",
        "--plain --projection cavalier",
        "--plain --projection cabinet",
        "--plain --fov 60",
        "--plain --background ff0000",
        "--plain --sheet",
        "--plain --sheet first",
        "--plain --dimension bbox",
        "--plain --scale-bar",
        "--plain --color-by surface",
        "--plain --color-by draft",
        "--plain --color-by curvature",
        "--plain --color-by thickness",
        "--plain --color-by deviation",
        "--plain --checker 0.3 --checker-by surface",
        "--plain --vpn 1,-1,1",
        "--plain --vpn 1,-1,1 --vrp 0,0,0.5 --vup 1,0,0",
        "--plain --vpn 1,-1,1 --window -1,1,-0.75,0.75",
        "--plain --vpn 1,-1,1 --prp 0.5,0,2",
        "--plain --vpn 0,-1,0 --projection ortho --prp 2,1,4",
        "--plain --vpn 1,-1,1 --clip-planes 0.2,-2",
        "--plain --section -y=0 --cap-color ff0000",
        "--turntable 3",
    ] {
        let command = format!("render in.csg -o out.png --size 120x90 --cells 16 {looks}");
        succeeded(&folder.run(&command));
        let file = fs::read(folder.file("out.png")).expect("a file");
        assert_eq!(&file[16..24], [0, 0, 0, 120, 0, 0, 0, 90], "{looks}");
        assert!(!pictures.contains(&file), "{looks}");
        pictures.push(file);
    }
    // Two ways that are right show the same.
    let by_the_book = ["zbuffer", "scanline"].map(|way| {
        let command = format!("render in.csg -o out.png --cells 16 --hidden-surface {way}");
        succeeded(&folder.run(&command));
        fs::read(folder.file("out.png")).expect("a file")
    });
    assert_eq!(by_the_book[0], by_the_book[1]);
    // The look that needs no options is made of three that have one each.
    let all = "--plain --edges --ambient-occlusion --shadow";
    succeeded(&folder.run(&format!(
        "render in.csg -o out.png --size 120x90 --cells 16 {all}"
    )));
    assert_eq!(
        fs::read(folder.file("out.png")).expect("a file"),
        pictures[0]
    );
    let output = folder.run("render in.csg -o out.png --cells 16 --stats");
    assert!(String::from_utf8_lossy(&succeeded(&output).stderr).contains("pixels shaded"));
    succeeded(&folder.run("render in.csg -o out.gif --cells 16 --turntable 2 --size 64x48"));
    assert_eq!(
        &fs::read(folder.file("out.gif")).expect("a file")[..6],
        b"GIF89a"
    );
    failed(
        &folder.run("render in.csg -o out.png --dimension no:such"),
        4,
    );
    succeeded(&folder.run("mesh in.csg -o in.glb --cells 16"));
    let told = folder.run("render in.glb -o out.png --color-by deviation");
    assert!(failed(&told, 4).contains("solid"));
    let wide = "render in.csg -o out.png --vpn 0,-1,0 --window -2,2,-1,1 --size 90x90";
    assert!(failed(&folder.run(wide), 4).contains("stretched"));
    let message = failed(&folder.run("render in.csg -o out.png --section up"), 2);
    assert!(message.contains("y=0"), "{message}");
}

#[test]
fn failures_have_a_cause_a_hint_and_a_code() {
    let folder = Folder::new();
    let write = |name: &str, text: &str| fs::write(folder.file(name), text).expect("a file");
    write("syntax.csg", "cube(size = [1, 1, 1], center = true)");
    write("roof.csg", "group() {\n\troof();\n}");
    write(
        "nothing.csg",
        "difference() { sphere(r = 1); sphere(r = 2); }",
    );
    write("mesh.stl", "this is no mesh");
    write("part.step", "");
    for (command, code, words) in [
        ("", 2, "Usage"),
        ("mesh in.csg", 2, "--output"),
        ("mesh in.csg -o out.dwg", 2, ".glb"),
        ("mesh in.csg -o out.glb --cells 0", 2, "--cells"),
        ("render in.csg -o out.jpg", 2, ".png"),
        ("render in.csg -o out.png --size 0x4", 2, "1024x768"),
        ("render in.csg -o out.png --camera above", 2, "front"),
        ("mesh missing.csg -o out.glb", 3, "missing.csg"),
        ("mesh part.step -o out.glb", 3, "hint:"),
        ("mesh syntax.csg -o out.glb", 3, "syntax.csg:1:"),
        ("mesh roof.csg -o out.glb", 3, "roof.csg:2:"),
        ("measure mesh.stl", 3, "mesh.stl"),
        (
            "mesh in.csg -o no/such/folder/out.glb --cells 16",
            5,
            "no/such/folder",
        ),
        ("mesh nothing.csg -o out.glb", 5, "empty"),
        ("render nothing.csg -o out.png", 4, "empty"),
    ] {
        let message = failed(&folder.run(command), code);
        assert!(message.contains(words), "{command}: {message}");
        assert!(!message.contains("panicked"), "{message}");
    }
    let left: Vec<String> = folder
        .files()
        .into_iter()
        .filter(|f| f.starts_with("out"))
        .collect();
    assert_eq!(left, [] as [&str; 0]);
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
fn help_documents_the_exit_codes() {
    let folder = Folder::new();
    let output = folder.run("--help");
    let text = String::from_utf8_lossy(&succeeded(&output).stdout).into_owned();
    for code in [0, 2, 3, 4, 5, 6] {
        assert!(text.contains(&format!("\n  {code}  ")), "{text}");
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
        assert!(off <= tolerance * number(&json["area"]), "{off}");
        assert_eq!(json["genus"], 5);
    }
    let text = folder.run("measure in.csg --tolerance 0.01");
    let text = String::from_utf8_lossy(&succeeded(&text).stdout).into_owned();
    assert!(text.contains("deviation   at most 0.00"), "{text}");

    let drum = "cylinder(h = 1, r1 = 1, r2 = 1, center = true);";
    fs::write(folder.file("drum.csg"), drum).expect("a file");
    let vertices = |options: &str| {
        let json = measure(&format!("drum.csg --tolerance 1 {options}"));
        json["vertices"].as_u64().expect("a count")
    };
    // 36 corners of both circles turn by ten degrees each.
    assert!((72..=100).contains(&vertices("--angle 10")));
    assert!(vertices("") < 36);
    failed(&folder.run("measure drum.csg --angle 10"), 2);

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
        let output = folder.run(&format!("measure in.csg {wrong}"));
        assert!(!output.status.success(), "{wrong}");
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
fn a_model_of_which_nothing_is_left_is_warned_about() {
    let folder = Folder::new();
    let scene = "difference() { sphere(r = 1); cube(size = [3, 3, 3], center = true); }";
    let output = folder.run_with_input("measure -", scene);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("nothing is left of the model's 2 primitives"),
        "{said}"
    );
    let output = folder.run_with_input("measure -", "group();");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains("nothing is left"), "{said}");
}

#[test]
fn scenes_import_from_beside_them_and_openscad_models_are_evaluated() {
    let folder = Folder::new();
    assert!(
        folder
            .run("mesh in.csg -o part.stl --tolerance 0.1")
            .status
            .success()
    );
    fs::write(folder.file("import.csg"), "import(file = \"part.stl\");").expect("a file");
    let output = folder.run("measure import.csg --json -");
    let measures: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let volume = measures["volume"]["value"].as_f64().expect("a volume");
    assert!((volume - DRILLED_VOLUME).abs() < 0.1, "{volume}");

    fs::write(
        folder.file("part.scad"),
        "side = 2; cube([side, 3, 4]); // a block",
    )
    .expect("a file");
    let output = folder.run("measure part.scad -D side=5 --json -");
    if Command::new("openscad")
        .arg("--version")
        .stderr(Stdio::null())
        .status()
        .is_err()
    {
        let line = "openscad is not installed: that models are evaluated is not tested\n";
        let _ = std::io::stderr().write_all(line.as_bytes());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(3) && said.contains("apt install openscad"));
        return;
    }
    let measures: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let volume = measures["volume"]["value"].as_f64().expect("a volume");
    assert!((volume - 60.0).abs() < 1e-9, "{volume}");
    fs::write(folder.file("bad.scad"), "cube(").expect("a file");
    let output = folder.run("measure bad.scad");
    assert_eq!(output.status.code(), Some(3));
}

/// A shell that runs the command with files limited to so many blocks of 512
/// bytes, as a full disk would.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_old_file_and_says_so() {
    let folder = Folder::new();
    for extension in ["stl", "obj", "glb", "gltf", "ply", "off", "3mf"] {
        let name = format!("old.{extension}");
        fs::write(folder.file(&name), "precious").expect("a file");
        let script = format!(
            "trap '' XFSZ; ulimit -f 2; exec {} mesh in.csg --cells 24 -o {name}",
            env!("CARGO_BIN_EXE_csg")
        );
        let output = Command::new("sh")
            .args(["-c", &script])
            .current_dir(folder.0.path())
            .output()
            .expect("a shell");
        let message = failed(&output, 5);
        assert!(message.contains(&name), "{message}");
        assert!(message.contains("File too large"), "{message}");
        // Nothing but the message, above all of the libraries.
        assert!(message.starts_with("error: cannot write"), "{message}");
        let lines = message.lines().filter(|line| !line.starts_with("  "));
        assert_eq!(lines.count(), 1, "{message}");
        let old = fs::read_to_string(folder.file(&name)).expect("the old file");
        assert_eq!(old, "precious", "{name}");
        fs::remove_file(folder.file(&name)).expect("removed");
        assert_eq!(folder.files(), [] as [&str; 0]);
    }
}

/// The second file of a pair is a pipe that nobody reads: there the command
/// waits, in the middle of writing, until it is killed.
#[cfg(unix)]
#[test]
fn a_killed_command_leaves_the_old_file() {
    let folder = Folder::new();
    fs::write(folder.file("old.gltf"), "precious").expect("a file");
    let pipe = Command::new("mkfifo").arg(folder.file("old.bin")).status();
    assert!(pipe.expect("mkfifo runs").success());
    let mut child = Command::new(env!("CARGO_BIN_EXE_csg"))
        .args(["mesh", "in.csg", "--cells", "24", "-o", "old.gltf"])
        .current_dir(folder.0.path())
        .spawn()
        .expect("the command runs");
    let unfinished = || folder.files().iter().any(|f| f.starts_with(".unfinished"));
    while !unfinished() {
        let ended = child.try_wait().expect("its state");
        assert_eq!(ended, None, "it does not wait for the pipe");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    child.kill().expect("killed");
    assert!(!child.wait().expect("its end").success());
    let old = fs::read_to_string(folder.file("old.gltf")).expect("the old file");
    assert_eq!(old, "precious");
}

#[cfg(target_os = "linux")]
#[test]
fn help_that_cannot_be_written_is_an_error() {
    for arguments in [&["--help"][..], &["mesh", "--help"], &["--version"]] {
        let full = fs::File::options().write(true).open("/dev/full");
        let output = Command::new(env!("CARGO_BIN_EXE_csg"))
            .args(arguments)
            .stdout(full.expect("a full device"))
            .output()
            .expect("the command runs");
        let message = failed(&output, 5);
        assert!(message.contains("standard output"), "{message}");
        assert!(message.contains("No space left"), "{message}");
    }
}

#[test]
fn what_is_no_mesh_and_data_elsewhere_are_errors() {
    let folder = Folder::new();
    fs::write(folder.file("letter.obj"), "Dear reader,\n").expect("a file");
    fs::write(folder.file("zeros.stl"), [0; 1000]).expect("a file");
    for name in ["letter.obj", "zeros.stl"] {
        let message = failed(&folder.run(&format!("measure {name}")), 3);
        assert!(message.contains("there is no triangle"), "{message}");
    }
    fs::create_dir(folder.file("in")).expect("a folder");
    succeeded(&folder.run("mesh in.csg --cells 24 -o in/part.gltf"));
    succeeded(&folder.run("measure in/part.gltf"));
    fs::rename(folder.file("in/part.bin"), folder.file("part.bin")).expect("moved");
    let text = fs::read_to_string(folder.file("in/part.gltf")).expect("text");
    fs::write(
        folder.file("in/part.gltf"),
        text.replace("part.bin", "../part.bin"),
    )
    .expect("written");
    let message = failed(&folder.run("measure in/part.gltf"), 3);
    assert!(message.contains("not in the folder"), "{message}");
    assert!(message.contains("--any-folder"), "{message}");
    succeeded(&folder.run("measure in/part.gltf --any-folder"));
}
