//! 3MF files: written and read, and those that others write.

use crate::common::{MODEL, archive, small_box};
use csg::glam::{DVec3, dvec3};
use csg::{LengthUnit, Mesh};
use io::threemf::{read_3mf, write_3mf};

/// Triangles as corners, each with its colour.
fn triangles(mesh: &Mesh) -> Vec<([DVec3; 3], Option<[u8; 4]>)> {
    let color = |index: usize| {
        let color = mesh.surface_of(index)?.color?;
        let [r, g, b] = color.to_srgb();
        Some([r, g, b, color.alpha].map(|x| (255.0 * x).round() as u8))
    };
    let all = 0..mesh.triangles.len();
    all.map(|index| (mesh.corners(index), color(index)))
        .collect()
}

#[test]
fn what_is_written_is_read_to_the_bit() {
    let mut mesh = small_box();
    mesh.positions
        .iter_mut()
        .for_each(|p| *p = *p * std::f64::consts::PI + dvec3(1e-9, 1e9, 0.1));
    for unit in [
        LengthUnit::Micrometre,
        LengthUnit::Millimetre,
        LengthUnit::Inch,
    ] {
        mesh.unit = unit;
        let mut file = Vec::new();
        write_3mf(&mesh, &mut file).expect("written");
        let read = read_3mf(&file).expect("read");
        assert_eq!(
            (read.unit, read.positions.len()),
            (unit, mesh.positions.len())
        );
        for ((found, color), (wanted, own)) in triangles(&read).into_iter().zip(triangles(&mesh)) {
            assert_eq!(found, wanted);
            // Those without get the default.
            assert!(own.is_none() || color == own, "{color:?} {own:?}");
        }
    }
}

#[test]
fn components_names_and_colors_are_read() {
    let mesh = read_3mf(&archive(MODEL.as_bytes())).expect("read");
    assert_eq!(
        (mesh.unit, mesh.triangles.len()),
        (LengthUnit::Centimetre, 8)
    );
    assert!(mesh.check().is_manifold());
    // The one, and the other twice as large, turned over where it is mirrored.
    assert!((mesh.volume() - 0.5).abs() < 1e-12, "{}", mesh.volume());
    let (low, high) = mesh.bounds().expect("bounds");
    assert_eq!(
        (low, high),
        (dvec3(3.0, 20.0, 30.0), dvec3(11.0, 21.0, 31.0))
    );
    let names = mesh
        .surfaces
        .iter()
        .filter_map(|surface| surface.name.as_deref());
    assert!(names.clone().count() > 0 && names.into_iter().all(|name| name == "Tetra & eder"));
    let colors: Vec<_> = triangles(&mesh)
        .into_iter()
        .map(|(_, color)| color)
        .collect();
    let (orange, blue) = (Some([255, 128, 0, 255]), Some([0, 64, 255, 128]));
    assert_eq!(colors, [[orange, orange, blue, orange]; 2].concat());
}

#[test]
fn faults_have_their_place() {
    for (from, to, words) in [
        ("v3=\"3\"", "v3=\"4\"", "vertex 4"),
        ("v3=\"3\"", "v3=\"-1\"", "a number `v3`"),
        ("x=\"1\"", "x=\"1e999\"", "not finite"),
        ("objectid=\"1\"", "objectid=\"2\"", "no object 2 before it"),
        (
            "<item objectid=\"2\"",
            "<item objectid=\"7\"",
            "no object 7",
        ),
        ("centimeter", "furlong", "furlong"),
        ("-2 0 0 0", "-2 0 0", "twelve"),
        ("</model>", "", "cut off"),
        ("</object>", "</objekt>", "byte"),
    ] {
        assert!(MODEL.contains(from));
        let faulty = archive(MODEL.replacen(from, to, 1).as_bytes());
        let error = read_3mf(&faulty).expect_err(to).to_string();
        assert!(
            error.contains(words) && error.contains("3dmodel.model"),
            "{to}: {error}"
        );
    }
    let nothing = MODEL.replace("<item objectid=\"2\"", "<other");
    let error = read_3mf(&archive(nothing.as_bytes()))
        .expect_err("nothing")
        .to_string();
    assert!(error.contains("no triangle"), "{error}");
}

/// Files that would fill the memory are refused: spaces that unpack to a gigabyte, and objects
/// of objects of objects.
#[test]
fn bombs_are_refused() {
    let spaces = vec![b' '; 64 << 20];
    let error = read_3mf(&archive(&spaces)).expect_err("a bomb").to_string();
    assert!(error.contains("far more than a mesh"), "{error}");
    let mut objects = String::new();
    for id in 3..60 {
        let before = id - 1;
        let part = format!("<component objectid=\"{before}\"/>");
        objects += &format!("<object id=\"{id}\"><components>{part}{part}</components></object>");
    }
    let bomb = MODEL
        .replace("</resources>", &format!("{objects}</resources>"))
        .replace("<item objectid=\"2\"", "<item objectid=\"59\"");
    let error = read_3mf(&archive(bomb.as_bytes()))
        .expect_err("a bomb")
        .to_string();
    assert!(error.contains("too many triangles"), "{error}");
}
