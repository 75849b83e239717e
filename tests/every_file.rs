//! That no file of tests is forgotten, where all of them are modules of one program.

use std::fs;
use std::path::Path;

/// Panics unless all Rust files in `tests` of a crate, or in its folder if it has nothing else, and
/// all folders there with a `main.rs`, are named by the `main.rs` of that folder or are programs of
/// their own in the crate's manifest.
pub fn is_a_module(crate_folder: &str, main: &str) {
    let folder = Path::new(crate_folder);
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
    let tests = if folder.join("tests").exists() {
        "tests/"
    } else {
        ""
    };
    let entries = fs::read_dir(folder.join(tests)).expect("a folder of tests");
    let mut count = 0;
    for entry in entries {
        let path = entry.expect("an entry").path();
        let is_file = path.extension().is_some_and(|extension| extension == "rs");
        if !is_file && !path.join("main.rs").exists() {
            continue;
        }
        let name = path.file_stem().expect("a name").to_string_lossy();
        let is_named = main.lines().any(|line| line == format!("mod {name};"))
            || main.contains(&format!("#[path = \"{name}.rs\"]\n"))
            || manifest.contains(&format!("path = \"{tests}{name}.rs\""));
        assert!(is_named, "{} is in no program", path.display());
        count += 1;
    }
    assert!(count > 1);
}
