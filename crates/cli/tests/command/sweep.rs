//! `csg sweep`, `csg completions` and `csg man`.

use std::fs;

use crate::{DRILLED_VOLUME, Folder, failed, succeeded};

/// Files of their own, a row each.
const TABLE: &str =
    "model,note\nin.csg,\"as it is, drilled\"\nball.csg,round\nbox.csg,\nbad.csg,\n";

fn folder() -> Folder {
    let folder = Folder::new();
    for (name, text) in [
        ("ball.csg", "sphere(r = 2);"),
        ("box.csg", "cube(size = [1, 2, 3], center = false);"),
        ("bad.csg", "roof();"),
        ("table.csv", TABLE),
    ] {
        fs::write(folder.file(name), text).expect("a file");
    }
    folder
}

#[test]
fn rows_are_measured_and_the_same_in_any_number_of_parts() {
    let folder = folder();
    let rows = |name: &str| -> Vec<String> {
        let text = fs::read_to_string(folder.file(name)).expect("a table");
        text.lines().map(str::to_owned).collect()
    };
    let whole = "sweep table.csv -o all.csv --write {row}.stl --write {row}.step";
    let message = failed(&folder.run(whole), 4);
    assert!(message.contains("1 of 4 variants failed"), "{message}");
    let all = rows("all.csv");
    assert_eq!(all.len(), 5);
    assert!(all[0].starts_with("row,model,note,volume,volume_error,area,"));
    let volume = |row: &str| -> f64 {
        row.split(',')
            .nth(3)
            .expect("a field")
            .parse()
            .expect("a number")
    };
    assert!(
        all[1].starts_with("1,in.csg,\"as it is, drilled\",0.98878955719"),
        "{}",
        all[1]
    );
    assert!((volume(&all[2]) - 32.0 / 3.0 * std::f64::consts::PI).abs() < 1e-9);
    assert!((volume(&all[3]) - 6.0).abs() < 1e-12);
    assert!(
        all[4].contains("roof") && all[4].contains(",,,,"),
        "{}",
        all[4]
    );
    for file in ["1.stl", "2.step", "3.stl"] {
        assert!(folder.file(file).exists(), "{file}");
    }
    let mesh = io::read_mesh(folder.file("1.stl")).expect("a mesh");
    assert!((mesh.volume() - DRILLED_VOLUME).abs() < 0.05);
    assert!(!folder.file("4.stl").exists());

    for parts in [2, 3, 7] {
        let mut joined = vec![all[0].clone()];
        for part in 1..=parts {
            let options =
                format!("--write {{row}}.stl --write {{row}}.step --shard {part}/{parts}");
            folder.run(&format!("sweep table.csv -o part.csv {options}"));
            let part = rows("part.csv");
            assert_eq!(part[0], all[0]);
            joined.extend_from_slice(&part[1..]);
        }
        assert_eq!(joined, all, "{parts} parts");
    }
}

#[test]
fn wrong_tables_and_names_are_told() {
    let folder = folder();
    fs::write(folder.file("taken.csv"), "volume\n1\n").expect("a file");
    fs::write(folder.file("twice.csv"), "model\nin.csg\nbox.csg\nin.csg\n").expect("a file");
    fs::write(folder.file("ragged.csv"), "model,a\nin.csg\n").expect("a file");
    let output = failed(&folder.run("sweep table.csv -o nowhere/out.csv"), 5);
    assert!(output.contains("nowhere/out.csv"), "{output}");
    for (arguments, code, words) in [
        ("sweep no.csv -o out.csv", 3, "no.csv"),
        ("sweep taken.csv -o out.csv", 3, "`volume`"),
        ("sweep ragged.csv -o out.csv", 3, "ragged.csv"),
        ("sweep table.csv -o out.csv --write part.stl", 2, "{row}"),
        (
            "sweep table.csv -o out.csv --write {bore}.stl",
            2,
            "model, note",
        ),
        ("sweep table.csv -o out.csv --write {row}.dwg", 2, ".glb"),
        (
            "sweep twice.csv -o out.csv --write {model}.stl",
            2,
            "rows 1 and 3 would have one file",
        ),
        ("sweep table.csv -o out.csv --shard 3/2", 2, "1/4"),
    ] {
        let message = failed(&folder.run(arguments), code);
        assert!(message.contains(words), "{arguments}: {message}");
        assert!(!folder.file("out.csv").exists());
    }
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let folder = Folder::new();
    let commands = [
        "mesh", "render", "measure", "section", "convert", "info", "compare", "sweep",
    ];
    for shell in ["bash", "zsh", "fish"] {
        let output = folder.run(&format!("completions {shell}"));
        let script = String::from_utf8_lossy(&succeeded(&output).stdout).into_owned();
        for command in commands {
            assert!(script.contains(command), "{shell}: {command}");
        }
    }
    fs::create_dir(folder.file("man")).expect("a folder");
    succeeded(&folder.run("man man"));
    for command in commands {
        let page = fs::read_to_string(folder.file(&format!("man/csg-{command}.1")));
        assert!(page.expect("a page").contains(".SH OPTIONS"), "{command}");
    }
}
