//! What the pages of theory link to is there: files of this crate, and in them what is named.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn pages_of_theory_name_what_is_there() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let entries = fs::read_dir(source.join("theory")).expect("pages");
    let mut pages: Vec<PathBuf> = entries.map(|entry| entry.expect("a page").path()).collect();
    pages.push(source.join("theory.rs"));
    assert!(pages.len() > 5);
    for page in pages {
        let text = fs::read_to_string(&page).expect("a page");
        let page = page.display();
        let mut named = BTreeSet::new();
        for (name, file) in links(&text) {
            let code = fs::read_to_string(source.join(file));
            let code = code.unwrap_or_else(|_| panic!("{page}: there is no {file}"));
            let is_there = name == file || code.lines().any(|line| defines(line, name));
            assert!(is_there, "{page}: no {name} in {file}");
            named.insert(format!("{file}: {file}.html"));
        }
        let targets = text.lines().filter_map(|line| line.strip_prefix("//! ["));
        // (A line may begin with a link.)
        let targets = targets.filter(|line| !line.starts_with('`'));
        let targets = targets.filter_map(|line| line.split_once("]: "));
        let told = targets.map(|(file, address)| {
            let of_source = address.trim_start_matches("../").strip_prefix("src/csg/");
            format!("{file}: {}", of_source.unwrap_or(address))
        });
        assert_eq!(named, told.collect(), "{page}");
    }
}

/// Names that are links to files, each with the file.
fn links(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.split("[`").skip(1).filter_map(|part| {
        let (name, rest) = part.split_once("`]")?;
        let (file, _) = rest.strip_prefix('[')?.split_once(']')?;
        Some((name, file))
    })
}

/// Whether a line begins a function, a type, a constant, or what a type has by that name.
fn defines(line: &str, name: &str) -> bool {
    let name = name.rsplit("::").next().unwrap_or(name);
    let words = line.split(|c: char| !c.is_alphanumeric() && c != '_');
    let mut words = words.filter(|word| !word.is_empty());
    let is_variant = name.starts_with(char::is_uppercase);
    let kinds = ["fn", "struct", "enum", "const"];
    let first = words.find(|word| !["pub", "super", "crate"].contains(word));
    first.is_some_and(|word| {
        is_variant && word == name || kinds.contains(&word) && words.next() == Some(name)
    })
}
