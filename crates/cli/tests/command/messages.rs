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
