//! What goes in and comes out, and what is left when that fails.

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::{DRILLED, DRILLED_VOLUME, Folder, failed, succeeded};

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
        assert!(!message.contains("unfinished"), "{message}");
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

#[test]
fn materials_in_other_folders_are_missed() {
    let folder = Folder::new();
    fs::create_dir(folder.file("in")).expect("a folder");
    fs::write(folder.file("a.mtl"), "newmtl red\nKd 1 0 0\n").expect("a file");
    let text = "mtllib ../a.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(folder.file("in/a.obj"), text).expect("a file");
    let said = |command: &str| {
        let output = folder.run(command);
        String::from_utf8_lossy(&succeeded(&output).stderr).into_owned()
    };
    let warning = said("info in/a.obj");
    assert!(
        warning.contains("in/a.obj: its materials are left out") && warning.contains("a.mtl"),
        "{warning}"
    );
    assert_eq!(said("info in/a.obj --any-folder"), "");
}

/// A tetrahedron without one side.
#[test]
fn broken_meshes_are_mended_if_asked() {
    let folder = Folder::new();
    let text = "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n";
    fs::write(folder.file("open.off"), text).expect("a file");
    let output = folder.run("mesh open.off --repair -o closed.stl");
    let said = String::from_utf8_lossy(&succeeded(&output).stderr).into_owned();
    assert!(
        said.contains("open.off was repaired: 1 x holes closed"),
        "{said}"
    );
    succeeded(&folder.run("measure closed.stl"));
}
