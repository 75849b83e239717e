//! Help, and what is said when something is wrong.

use std::fs;
use std::process::Command;

use crate::{Folder, failed, succeeded};

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
        (
            "mesh in.csg -o out.glb --cells 0",
            2,
            "whole number from 1 to 65536",
        ),
        (
            "mesh in.csg -o out.glb --cells 1.5",
            2,
            "whole number from 1 to 65536",
        ),
        (
            "mesh in.csg -o out.glb --limit-cells x",
            2,
            "whole number from 0",
        ),
        ("mesh in.csg -o out.shard --shard 1/2", 2, "--cell-size"),
        (
            "render in.csg -o out.png --turntable 0",
            2,
            "whole number from 1 to 1000",
        ),
        (
            "render in.csg -o out.png --camera 1,2,3,4",
            2,
            "3,-3,2,0,0,0",
        ),
        ("render in.csg -o out.jpg", 2, ".png"),
        ("render in.csg -o out.png --near -1", 2, "from the eye"),
        ("render in.csg -o out.png --far inf", 2, "from the eye"),
        (
            "render in.csg -o out.png --near 5 --far 2",
            4,
            "give 0 < near < far",
        ),
        (
            "render in.csg -o out.png --colorscheme Cornfield",
            2,
            "give --background",
        ),
        ("render in.csg -o out.png --size 0x4", 2, "1024x768"),
        ("render in.csg -o out.png --camera above", 2, "front"),
        ("mesh missing.csg -o out.glb", 3, "missing.csg"),
        ("mesh part.step -o out.glb", 3, "STEP is written, not read"),
        ("info part.step", 3, "STEP is written, not read"),
        ("info .", 3, "it is a folder"),
        ("mesh syntax.csg -o out.glb", 3, "syntax.csg:1:"),
        ("mesh roof.csg -o out.glb", 3, "roof.csg:2:"),
        ("measure mesh.stl", 3, "mesh.stl"),
        (
            "mesh in.csg -o no/such/folder/out.glb --cells 16",
            5,
            "no/such/folder",
        ),
        ("mesh nothing.csg -o out.glb", 4, "empty"),
        ("mesh nothing.csg -o out.step", 4, "empty"),
        ("render nothing.csg -o out.png", 4, "empty"),
        ("section nothing.csg --plane z=0 -o out.svg", 4, "empty"),
        ("drawing nothing.csg --view top -o out.svg", 4, "empty"),
    ] {
        let message = failed(&folder.run(command), code);
        assert!(message.contains(words), "{command}: {message}");
        assert!(!message.contains("panicked"), "{message}");
        assert!(!message.contains("unfinished"), "{message}");
    }
    let left: Vec<String> = folder
        .files()
        .into_iter()
        .filter(|f| f.starts_with("out"))
        .collect();
    assert_eq!(left, [] as [&str; 0]);
}

/// What people are told names no function of the libraries.
#[test]
fn messages_name_options() {
    let folder = Folder::new();
    let write = |name: &str, text: &str| fs::write(folder.file(name), text).expect("a file");
    fs::create_dir(folder.file("in")).expect("a folder");
    write("in/import.csg", "import(file = \"../hosts.stl\");");
    let limit = failed(
        &folder.run("mesh in.csg -o out.glb --limit-triangles 10"),
        6,
    );
    assert!(
        limit.contains("--partial") && !limit.contains("::"),
        "{limit}"
    );
    let outside = failed(&folder.run("measure in/import.csg"), 3);
    assert!(outside.contains("--any-folder allows"), "{outside}");
    assert!(!outside.contains("any_folder"), "{outside}");
}

/// Every command says why, and where the operands lie; and then nothing that is vaguer.
#[test]
fn empty_models_say_why() {
    let folder = Folder::new();
    let text = "intersection() { sphere(r = 1); multmatrix([[1, 0, 0, 9], [0, 1, 0, 0], \
                [0, 0, 1, 0], [0, 0, 0, 1]]) { sphere(r = 1); } }";
    fs::write(folder.file("apart.csg"), text).expect("a file");
    for command in [
        "mesh apart.csg -o out.glb",
        "mesh apart.csg -o out.step",
        "render apart.csg -o out.png",
        "section apart.csg --plane z=0 -o out.svg",
        "drawing apart.csg -o out.svg",
    ] {
        let said = failed(&folder.run(command), 4);
        assert!(said.contains("are 7 apart along x"), "{command}: {said}");
        assert!(said.contains("operand 2 lies between 8 -1 -1"), "{said}");
        for vague in ["csg measure", "does not meet", "smaller than", "?"] {
            assert!(!said.contains(vague), "{command}: {said}");
        }
    }
    // The plane is beside it.
    let said = failed(&folder.run("section in.csg --plane z=5 -o out.svg"), 4);
    assert!(said.contains("does not meet the solid"), "{said}");
}

#[test]
fn a_missing_openscad_is_told() {
    let folder = Folder::new();
    fs::write(folder.file("part.scad"), "cube(1);").expect("a file");
    let output = Command::new(env!("CARGO_BIN_EXE_csg"))
        .args(["measure", "part.scad"])
        .current_dir(folder.file(""))
        .env("PATH", "")
        .output()
        .expect("the command runs");
    let message = failed(&output, 3);
    assert!(message.contains("`openscad` is not installed"), "{message}");
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

/// As `csg … 2>&1 | head -1` leaves it.
#[test]
fn what_nobody_reads_on_standard_error_ends_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("a.csg");
    fs::write(&scene, "cube(size = [1, 1, 1]); sphere(r = 1, $fn = 8);").expect("written");
    let name = |file: &str| folder.path().join(file).display().to_string();
    let (scene, missing) = (scene.display().to_string(), name("missing.csg"));
    let cases: [(&[&str], i32); 8] = [
        (&["mesh", &scene, "-o", &name("a.stl")], 0),
        (&["convert", &scene, &name("a.ply")], 0),
        (
            &["section", &scene, "--plane", "z=0", "-o", &name("a.svg")],
            0,
        ),
        (&["measure", &scene, "--json", &name("a.json")], 0),
        (&["render", &scene, "--stats", "-o", &name("a.png")], 0),
        (&["info", &scene], 0),
        (&["compare", &scene, &missing], 3),
        (&["mesh", &scene, "--misspelt"], 2),
    ];
    for (arguments, code) in cases {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let output = Command::new(env!("CARGO_BIN_EXE_csg"))
            .args(arguments)
            .stderr(writer)
            .output()
            .expect("the command runs");
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    }
    for file in ["a.stl", "a.ply", "a.svg", "a.json", "a.png"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}
