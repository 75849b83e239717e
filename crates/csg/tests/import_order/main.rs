//! Imports between the files of this crate run one way: from no file do they lead back to it,
//! and between rooms, which are the folders and files right under `src`, only upwards in the
//! list below.

mod reader;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs;
use std::path::Path;

use self::reader::{Import, imports};

/// The rooms, each with what it holds: every one may import from those before it.
const ROOMS: [(&str, &str); 32] = [
    (
        "elementary",
        "sines and powers that are the same everywhere",
    ),
    ("clock", "what time it is, where there is a clock"),
    ("limits", "how much may be spent"),
    ("machine", "how much memory there is"),
    ("pages", "memory that grows without a copy"),
    ("undecided", "why something could not be told, and where"),
    ("color", "colours"),
    (
        "error",
        "what can be wrong with a model, and how to mend it",
    ),
    ("control", "progress, cancelling, and what is spent"),
    ("numeric", "numbers alone"),
    ("surface", "planes and quadrics, and points common to some"),
    (
        "mesh",
        "triangles, and what can be said of them without a solid",
    ),
    ("solid", "the tree that a user builds"),
    ("shapes", "ready-made solids"),
    ("program", "the tree lowered: surfaces and a formula"),
    ("report", "what was done for a mesh"),
    ("task", "what the ways of meshing are handed"),
    ("arrangement", "the exact boundary"),
    (
        "settling",
        "surfaces moved so that a boundary can be evaluated",
    ),
    ("brep", "the exact boundary as faces, edges and vertices"),
    (
        "tessellate",
        "a mesh of the right topology brought to a tolerance",
    ),
    ("surface_nets", "meshes by a lattice"),
    ("adapt", "meshes by adaptive cells"),
    ("draft", "meshes in draft quality"),
    ("finish", "normals and feature edges"),
    ("merger", "a mesh put together from slabs"),
    ("verify", "a mesh held against its program"),
    ("mesher", "the entry: options in, mesh and report out"),
    ("query", "what a ray meets, and what is nearest"),
    ("section", "what a plane meets of a solid"),
    (
        "corners",
        "what is made of the corners of solids: hulls, sums, projections",
    ),
    ("theory", "pages on the mathematics, without code"),
];

/// The face of the crate, which hands on names of all rooms.
const FACE: &str = "lib.rs";

#[test]
fn imports_of_files_never_lead_back() {
    let imports = imports(&sources());
    if let Some(circle) = shortest_circle(&imports) {
        panic!("files import each other in a circle:\n{}", chain(&circle));
    }
}

#[test]
fn rooms_import_only_from_rooms_before_them() {
    let imports = imports(&sources());
    let wrong = against_order(&imports, &ROOMS.map(|(room, _)| room));
    assert!(
        wrong.is_empty(),
        "against the order of rooms:\n{}",
        chain(&wrong)
    );
}

#[test]
fn the_order_names_every_room() {
    let sources = sources();
    let files = sources.iter().map(|(file, _)| file.as_str());
    // `random` is compiled for tests alone.
    let built: BTreeSet<&str> = files
        .filter(|&file| file != FACE)
        .map(room)
        .filter(|&room| room != "random")
        .collect();
    assert_eq!(built, ROOMS.iter().map(|&(room, _)| room).collect());
}

/// What is known of this crate is read from it.
#[test]
fn imports_of_this_crate_are_seen() {
    let imports = imports(&sources());
    let is_seen = |from: &str, to: &str, name: &str| {
        let wanted = Import {
            from: from.to_owned(),
            to: to.to_owned(),
            name: name.to_owned(),
        };
        imports.contains(&wanted)
    };
    assert!(is_seen("mesher.rs", "mesher/run.rs", "Run"));
    // Through the faces of two rooms.
    assert!(is_seen("verify/rays.rs", "surface/bounds.rs", "Bounds"));
    // By a path in the code, through the name of a module.
    assert!(is_seen("mesher/run.rs", "draft.rs", "mesh"));
}

/// Every way to name a thing is an import, and closes a circle.
#[test]
fn made_up_circles_are_found() {
    let ways = [
        "use crate::a::Thing;",
        "use super::super::a::Thing as Other;",
        "use crate::{a::{self, Thing}, c};",
        "use crate::a;\nfn f() -> a::Thing {}",
        "fn f() { g(crate::a::Thing) }",
        "fn f() { assert!(matches!(g(), [crate::a::Thing::One, ..])) }",
        "// Handed on by the face of the crate.\nuse crate::Thing;",
        "// Handed on twice.\nuse crate::c::Renamed;",
        "mod inner { fn f() -> super::super::super::a::Thing {} }",
        "use crate::a::*;",
        "pub use crate::a::Thing;\nfn f() -> Thing {}",
    ];
    for way in ways {
        let made_up = [
            ("lib.rs", "mod a;\nmod b;\nmod c;\npub use a::Thing;"),
            (
                "a.rs",
                "use crate::b::inside::Used;\npub enum Thing { One }",
            ),
            ("b/mod.rs", "mod inside;"),
            ("b/inside.rs", &format!("{way}\npub struct Used;")),
            ("c.rs", "pub use crate::Thing as Renamed;"),
        ];
        let circle = shortest_circle(&imports(&owned(&made_up)));
        let circle = circle.unwrap_or_else(|| panic!("no circle by: {way}"));
        let files: Vec<&str> = circle.iter().map(|import| import.from.as_str()).collect();
        assert_eq!(files, ["a.rs", "b/inside.rs"], "{way}");
        let text = chain(&circle);
        assert!(
            text.starts_with("a.rs takes Used from b/inside.rs\nb/inside.rs takes "),
            "{text}"
        );
    }
}

/// Three files around, and the way in to them is none of it.
#[test]
fn long_circles_are_named_whole() {
    let made_up = [
        ("lib.rs", "mod a;\nmod b;\nmod c;\nmod d;"),
        ("a.rs", "use crate::b::B;"),
        ("b.rs", "use crate::c::C;"),
        ("c.rs", "use crate::d::D;"),
        ("d.rs", "use crate::b::B;"),
    ];
    let circle = shortest_circle(&imports(&owned(&made_up))).expect("a circle");
    let expected = "b.rs takes C from c.rs\nc.rs takes D from d.rs\nd.rs takes B from b.rs";
    assert_eq!(chain(&circle), expected);
}

#[test]
fn what_is_no_import_closes_no_circle() {
    let ways = [
        "// use crate::a::Thing;",
        "/// [`crate::a::Thing`]\nfn f() { g(\"crate::a::Thing\") }",
        "#[cfg(test)]\nmod tests { use crate::a::Thing; }",
        "#[cfg(test)]\nuse crate::a::Thing;",
        "#[cfg(test)]\nfn f() -> crate::a::Thing {}",
        "pub use crate::a::Thing;",
        "pub(in crate::a) struct Thing;",
        "use a::Thing;",
        "use std::a::Thing;",
        "fn f() -> Thing {}",
    ];
    for way in ways {
        let made_up = [
            ("lib.rs", "mod a;\nmod b;\n#[cfg(test)]\nmod checks;"),
            ("a.rs", "use crate::b::Used;"),
            ("b.rs", &format!("{way}\npub struct Used;")),
            ("checks.rs", "use crate::a::Thing;\npub struct Checked;"),
        ];
        let imports = imports(&owned(&made_up));
        assert_eq!(imports.len(), 1, "{way}: {}", chain(&imports));
    }
}

#[test]
fn made_up_imports_against_the_order_are_found() {
    let made_up = [
        ("lib.rs", "mod first;\nmod second;"),
        ("first/mod.rs", "mod low;"),
        (
            "first/low.rs",
            "use crate::second::high::High;\npub struct Low;",
        ),
        (
            "second/mod.rs",
            "pub mod high;\nuse crate::first::low::Low;",
        ),
        ("second/high.rs", "pub struct High;"),
    ];
    let imports = imports(&owned(&made_up));
    let wrong = against_order(&imports, &["first", "second"]);
    assert_eq!(chain(&wrong), "first/low.rs takes High from second/high.rs");
    let wrong = against_order(&imports, &["second", "first"]);
    assert_eq!(chain(&wrong), "second/mod.rs takes Low from first/low.rs");
}

fn owned(sources: &[(&str, &str)]) -> Vec<(String, String)> {
    let owned = sources.iter();
    owned
        .map(|&(file, text)| (file.to_owned(), text.to_owned()))
        .collect()
}

/// The files under `src`, by their paths there, and their texts.
fn sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![root.clone()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("an entry of a folder").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(&root).expect("a file under the root");
                let name = name.to_str().expect("a name in UTF-8").replace('\\', "/");
                found.push((name, fs::read_to_string(&path).expect("a text")));
            }
        }
    }
    found
}

/// The folder or file right under `src`.
fn room(file: &str) -> &str {
    let first = file.split('/').next().unwrap_or(file);
    first.strip_suffix(".rs").unwrap_or(first)
}

/// The imports from a room of later ones.
fn against_order(imports: &[Import], rooms: &[&str]) -> Vec<Import> {
    let place = |file: &str| rooms.iter().position(|&name| name == room(file));
    let is_wrong =
        |import: &&Import| import.from != FACE && place(&import.from) < place(&import.to);
    imports.iter().filter(is_wrong).cloned().collect()
}

/// The fewest imports that lead from a file back to it, from the first such file on.
fn shortest_circle(imports: &[Import]) -> Option<Vec<Import>> {
    let mut from: BTreeMap<&str, Vec<&Import>> = BTreeMap::new();
    for import in imports {
        from.entry(&import.from).or_default().push(import);
    }
    let circles = from
        .keys()
        .filter_map(|&start| circle_through(start, &from));
    circles.min_by_key(Vec::len)
}

fn circle_through(start: &str, from: &BTreeMap<&str, Vec<&Import>>) -> Option<Vec<Import>> {
    // By which import each file was reached first.
    let mut reached: BTreeMap<&str, &Import> = BTreeMap::new();
    let mut pending = VecDeque::from([start]);
    while let Some(file) = pending.pop_front() {
        for import in from.get(file).into_iter().flatten() {
            if !reached.contains_key(import.to.as_str()) {
                reached.insert(&import.to, import);
                pending.push_back(&import.to);
            }
        }
    }
    let mut circle: Vec<Import> = vec![(*reached.get(start)?).clone()];
    while circle[circle.len() - 1].from != start {
        let last = &circle[circle.len() - 1];
        circle.push(reached[last.from.as_str()].clone());
    }
    circle.reverse();
    Some(circle)
}

/// Imports for people to read.
fn chain(imports: &[Import]) -> String {
    let lines = imports
        .iter()
        .map(|Import { from, to, name }| format!("{from} takes {name} from {to}"));
    lines.collect::<Vec<_>>().join("\n")
}
