//! Parts of assemblies: bodies by the names around them, in every format that has a place for them.

use csg::{Color, Mesh, Mesher, Program, Solid};
use gltf::Node;
use io::gltf::{read_glb, write_glb};
use io::obj::{read_obj, write_obj};
use io::threemf::{read_3mf, write_3mf};

/// A pump: a housing with a hollow, and a bore that has a name of its own; a shaft of two bodies;
/// a base without a name. A loose ball lies in the hollow.
fn pump() -> Solid {
    let hollow = Solid::cube(2.0).named("hollow");
    let bore = Solid::cuboid([0.2, 0.2, 1.5])
        .translate([0.0, 0.0, 1.75])
        .named("bore");
    let housing = (Solid::cube(4.0) - hollow - bore).named("housing");
    let end = |x: f64| Solid::cube(1.0).translate([x, 0.0, 0.0]);
    let shaft = (end(4.0) | end(6.0)).named("shaft & key");
    let brass = Color::from_srgb([1.0, 0.5, 0.0]);
    let ball = Solid::cube(0.5).named("ball").colored(brass);
    let base = Solid::cuboid([9.0, 9.0, 1.0]).translate([0.0, 0.0, -4.0]);
    (housing | shaft | ball).named("pump") | base
}

fn mesh(solid: &Solid) -> Mesh {
    let program = Program::lower(solid).expect("valid");
    Mesher::new()
        .tolerance(0.01)
        .mesh(&program)
        .expect("meshed")
        .mesh
}

/// The volume of all triangles around which these names are.
fn volume(mesh: &Mesh, names: &[&str]) -> f64 {
    let is_within = |index: usize| {
        mesh.surface_of(index).is_some_and(|surface| {
            let all = surface.parts.iter().chain(&surface.name);
            all.map(AsRef::as_ref)
                .collect::<Vec<&str>>()
                .starts_with(names)
        })
    };
    let sixth = |index: usize| {
        let [a, b, c] = mesh.corners(index);
        a.dot(b.cross(c)) / 6.0
    };
    (0..mesh.triangles.len())
        .filter(|&index| is_within(index))
        .map(sixth)
        .sum()
}

fn near(found: f64, wanted: f64) {
    assert!(
        (found - wanted).abs() < 1e-5 * wanted,
        "{found} instead of {wanted}"
    );
}

/// A cube without the hollow and the bore.
const HOUSING: f64 = 64.0 - 8.0 - 0.04;

#[test]
fn nodes_of_gltf_are_parts() {
    let made = mesh(&pump());
    let mut bytes = Vec::new();
    write_glb(&made, &mut bytes).expect("written");
    let file = gltf::Gltf::from_slice(&bytes).expect("valid");
    let scene = file.default_scene().expect("a scene");
    let model = scene.nodes().next().expect("a node");
    assert_eq!(model.name(), Some("model"));
    let inner = |node: &Node| {
        let mut names: Vec<_> = node
            .children()
            .map(|node| {
                (
                    node.name().unwrap_or_default().to_owned(),
                    node.mesh().is_some(),
                )
            })
            .collect();
        names.sort();
        names
    };
    assert_eq!(
        inner(&model),
        [(String::new(), true), ("pump".to_owned(), false)]
    );
    let pump = model.children().find(|node| node.name() == Some("pump"));
    let parts = ["ball", "housing", "shaft & key"].map(|name| (name.to_owned(), true));
    assert_eq!(inner(&pump.expect("the pump")), parts);
    let back = read_glb(&bytes).expect("read");
    near(volume(&back, &["pump", "shaft & key"]), 2.0);
    near(volume(&back, &["pump", "ball"]), 0.125);
    assert!(volume(&back, &["pump", "housing", "bore"]) != 0.0);
    assert!(back.check().is_manifold());
}

#[test]
fn objects_of_3mf_are_parts_with_their_voids() {
    let made = mesh(&pump());
    let mut bytes = Vec::new();
    write_3mf(&made, &mut bytes).expect("written");
    let back = read_3mf(&bytes).expect("read");
    near(back.volume(), made.volume());
    near(volume(&back, &["pump", "shaft & key"]), 2.0);
    near(volume(&back, &["pump", "ball"]), 0.125);
    near(volume(&back, &["pump", "housing"]), HOUSING);
}

#[test]
fn objects_of_obj_are_parts() {
    let made = mesh(&pump());
    let mut bytes = Vec::new();
    write_obj(&made, None, &mut bytes).expect("written");
    let text = String::from_utf8(bytes.clone()).expect("text");
    let mut lines: Vec<&str> = text
        .lines()
        .filter(|line| line.starts_with("o ") || line.starts_with("g "))
        .collect();
    lines.sort_unstable();
    assert_eq!(
        lines,
        [
            "g bore",
            "g hollow",
            "o pump/ball",
            "o pump/housing",
            "o pump/shaft_&_key"
        ]
    );
    let back = read_obj(&bytes, |_| None).expect("read");
    near(volume(&back, &["pump/shaft_&_key"]), 2.0);
    near(volume(&back, &["pump/housing"]), HOUSING);
}
