//! `csg mesh --shard` and `csg merge`.

use std::fs;

use serde_json::Value;

use crate::{Folder, failed, succeeded};

/// Shards of `in.csg`: `1.shard`, `2.shard` and so on.
fn shards(folder: &Folder, options: &str, parts: usize) -> Vec<String> {
    let shard = |part| {
        let name = format!("{part}.shard");
        let options = format!("{options} --shard {part}/{parts} -o {name}");
        succeeded(&folder.run(&format!("mesh in.csg {options}")));
        name
    };
    (1..=parts).map(shard).collect()
}

#[test]
fn shards_put_together_are_the_whole_to_the_byte() {
    let folder = Folder::new();
    let read = |name: &str| fs::read(folder.file(name)).expect("a file");
    succeeded(
        &folder.run("mesh in.csg --cells 40 --unit cm -o whole.ply -o whole.stl -o whole.obj"),
    );
    for parts in [1, 2, 5] {
        let names = shards(&folder, "--cells 40 --unit cm", parts);
        // In any order.
        let names = names.into_iter().rev().collect::<Vec<_>>().join(" ");
        let merge =
            format!("merge {names} -o merged.ply -o merged.stl -o merged.obj --json merged.json");
        let output = folder.run(&merge);
        succeeded(&output);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(told.contains(&format!("of {parts} shards")), "{told}");
        let json: Value = serde_json::from_slice(&read("merged.json")).expect("JSON");
        assert_eq!(
            (&json["shards"], &json["unit"]),
            (&parts.into(), &"cm".into())
        );
        assert_eq!(
            json["files"],
            serde_json::json!(["merged.ply", "merged.stl", "merged.obj"])
        );
        let count = format!("{} triangles", json["triangles"]);
        assert!(told.contains(&count), "{told} {json}");
        for format in ["ply", "stl", "obj"] {
            let (whole, merged) = (format!("whole.{format}"), format!("merged.{format}"));
            assert!(read(&whole) == read(&merged), "{format} of {parts}");
        }
    }
}

#[test]
fn what_is_no_shard_and_no_whole_is_told() {
    let folder = Folder::new();
    shards(&folder, "--cells 12", 2);
    succeeded(&folder.run("mesh in.csg --cells 13 --shard 2/2 -o other.shard"));
    let bytes = fs::read(folder.file("2.shard")).expect("a file");
    fs::write(folder.file("short.shard"), &bytes[..bytes.len() - 5]).expect("a file");
    for (arguments, code, said) in [
        ("merge 1.shard -o a.ply", 3, "1.shard: it is one of 2 slabs"),
        ("merge 1.shard 1.shard 2.shard -o a.ply", 3, "as is 1.shard"),
        (
            "merge 1.shard other.shard -o a.ply",
            3,
            "other.shard: it is of another mesh",
        ),
        (
            "merge 1.shard short.shard -o a.ply",
            3,
            "short.shard: it was cut off",
        ),
        ("merge 1.shard in.csg -o a.ply", 3, "in.csg: it is no shard"),
        ("merge 1.shard none.shard -o a.ply", 3, "none.shard: "),
        ("merge 1.shard 2.shard -o a.dwg", 2, "a.dwg"),
        ("merge 1.shard 2.shard -o -", 2, "name one"),
        (
            "mesh in.csg --cells 12 --shard 1/2 -o a.ply",
            2,
            "part-1.shard",
        ),
        ("mesh in.csg --cells 12 --shard 3/2 -o a.shard", 2, "1/4"),
        ("mesh in.csg --shard 1/2 -o a.shard", 2, "without cells"),
        (
            "mesh in.csg --shard 1/2 --tolerance 0.1 --cells 12 -o a.shard",
            2,
            "tolerance",
        ),
        (
            "mesh in.csg --shard 1/2 --draft --cells 12 -o a.shard",
            2,
            "draft",
        ),
    ] {
        let told = failed(&folder.run(arguments), code);
        assert!(told.contains(said), "{arguments}: {told}");
        assert!(!folder.file("a.ply").exists() && !folder.file("a.shard").exists());
    }
}
