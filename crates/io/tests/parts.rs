//! Parts of assemblies: bodies by the names around them, in every format that has a place for them.

use std::io::{Cursor, Read};

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

/// The text of an entry of an archive, if there is one.
fn entry(file: &[u8], name: &str) -> Option<String> {
    let mut archive = zip::ZipArchive::new(Cursor::new(file)).expect("an archive");
    let mut entry = archive.by_name(name).ok()?;
    let mut text = String::new();
    entry.read_to_string(&mut text).expect("text");
    Some(text)
}

#[test]
fn slicers_are_told_of_parts_in_several_colors() {
    const FOR_PRUSA: &str = "Metadata/Slic3r_PE_model.config";
    let mut file = Vec::new();
    write_3mf(&mesh(&pump()), &mut file).expect("written");
    let [model, told] = ["3D/3dmodel.model", FOR_PRUSA].map(|name| {
        let text = entry(&file, name);
        text.unwrap_or_else(|| panic!("no {name}"))
    });
    let model = roxmltree::Document::parse(&model).expect("a model");
    let told = roxmltree::Document::parse(&told).expect("what is told");
    let mut extruders = Vec::new();
    for object in told
        .descendants()
        .filter(|node| node.has_tag_name("object"))
    {
        let value = |of: &str, key: &str| {
            let is_it = |node: &roxmltree::Node<'_, '_>| {
                node.attribute("type") == Some(of) && node.attribute("key") == Some(key)
            };
            object.descendants().find(is_it)?.attribute("value")
        };
        let own = model.descendants().find(|node| {
            node.tag_name().name() == "object" && node.attribute("id") == object.attribute("id")
        });
        let own = own.expect("of the model");
        let name = own.attribute("name");
        assert_eq!(
            (value("object", "name"), value("volume", "name")),
            (name, name)
        );
        let volume = object.children().find(|node| node.has_tag_name("volume"));
        let volume = volume.expect("a volume");
        let named = |node: &roxmltree::Node<'_, '_>| node.tag_name().name() == "triangle";
        let last = own.descendants().filter(named).count() - 1;
        assert_eq!(volume.attribute("firstid"), Some("0"));
        assert_eq!(volume.attribute("lastid"), Some(&*last.to_string()));
        extruders.push((name, value("object", "extruder")));
    }
    extruders.sort_unstable();
    let one = Some("1");
    assert_eq!(
        extruders,
        [
            (None, one),
            (Some("ball"), Some("2")),
            (Some("housing"), one),
            (Some("shaft & key"), one),
        ]
    );
    // One colour is for one extruder.
    let mut file = Vec::new();
    write_3mf(&mesh(&Solid::cube(1.0).named("alone")), &mut file).expect("written");
    assert_eq!(entry(&file, FOR_PRUSA), None);
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
