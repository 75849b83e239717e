//! The OBJ writer against tobj, and the reader against the writer.

use std::io::BufReader;

use crate::common;
use crate::common::{faces, small_box, sphere, srgb_bytes};
use csg::Mesh;
use glam::{DVec3, dvec3};
use io::obj::{read_obj, write_mtl, write_obj};
use proptest::prelude::*;

fn written(mesh: &Mesh) -> (Vec<u8>, Vec<u8>) {
    let (mut obj, mut mtl) = (Vec::new(), Vec::new());
    write_obj(mesh, Some("a b.mtl"), &mut obj).expect("written");
    write_mtl(mesh, &mut mtl).expect("written");
    (obj, mtl)
}

#[test]
fn tobj_sees_the_same_solid() {
    let mesh = small_box();
    let (obj, mtl) = written(&mesh);
    let (models, materials) = tobj::load_obj_buf(
        &mut BufReader::new(&obj[..]),
        &tobj::LoadOptions::default(),
        |path| {
            assert_eq!(path.to_str(), Some("a b.mtl"));
            tobj::load_mtl_buf(&mut BufReader::new(&mtl[..]))
        },
    )
    .expect("valid OBJ");
    let materials = materials.expect("valid MTL");
    let mut volume = 0.0;
    let mut names = Vec::new();
    for model in &models {
        let data = &model.mesh;
        let at = |i: u32| DVec3::from_slice(&data.positions[i as usize * 3..]);
        for (corners, normals) in data.indices.chunks(3).zip(data.normal_indices.chunks(3)) {
            let [a, b, c] = [0, 1, 2].map(|i| at(corners[i]));
            volume += a.dot(b.cross(c)) / 6.0;
            let face = (b - a).cross(c - a).normalize();
            for &normal in normals {
                let normal = DVec3::from_slice(&data.normals[normal as usize * 3..]);
                assert!((normal - face).length() < 1e-6);
            }
        }
        let material = &materials[data.material_id.expect("a material")];
        let kd = material
            .diffuse
            .expect("a colour")
            .map(|x| (x * 255.0).round());
        names.push((model.name.clone(), kd, material.dissolve));
    }
    assert_eq!(volume, 6.0);
    let grey = materials[0]
        .diffuse
        .expect("grey")
        .map(|x| (x * 255.0).round());
    let orange = [255.0, 128.0, 0.0];
    let hub = || "hub".to_owned();
    assert_eq!(
        names,
        [
            ("unnamed_object".to_owned(), grey, Some(1.0)),
            ("unnamed_object".to_owned(), orange, Some(1.0)),
            (hub(), orange, Some(1.0)),
            (hub(), grey, Some(1.0)),
            ("Nabe_2_<&\">".to_owned(), [0.0, 64.0, 255.0], Some(0.5)),
        ]
    );
}

#[test]
fn a_mesh_returns_as_it_was() {
    let mesh = sphere(dvec3(1e6 / 3.0, -7.1, 1e-9), 1.0 / 3.0, 12);
    let mut obj = Vec::new();
    write_obj(&mesh, None, &mut obj).expect("written");
    assert_eq!(
        read_obj(&obj, |_| None).expect("read"),
        Mesh {
            unit: mesh.unit,
            ..mesh
        }
    );

    let mesh = small_box();
    let (obj, mtl) = written(&mesh);
    let back = read_obj(&obj, |name| {
        assert_eq!(name, "a b.mtl");
        Some(mtl.clone())
    })
    .expect("read");
    assert_eq!(back.positions, mesh.positions);
    let places = |mesh: &Mesh| faces(mesh).into_iter().map(|f| f.0).collect::<Vec<_>>();
    assert_eq!(places(&back), places(&mesh));
    for (index, triangle) in back.triangles.iter().enumerate() {
        let original = mesh
            .triangles
            .iter()
            .position(|t| t == triangle)
            .expect("kept");
        assert_eq!(back.corner_normals[index], mesh.corner_normals[original]);
        let (new, old) = (
            back.surface_of(index).unwrap(),
            mesh.surface_of(original).unwrap(),
        );
        let name = old.name.as_deref().map(|name| name.replace(' ', "_"));
        assert_eq!(new.name.as_deref(), name.as_deref());
        assert_eq!(new.color.map(srgb_bytes), old.color.map(srgb_bytes));
    }
}

#[test]
fn coincident_vertices_stay_apart() {
    // Two boxes that share an edge, as separate vertices, in two groups.
    let mut mesh = small_box();
    let other = common::colored_box(dvec3(1.0, 2.0, 0.0), dvec3(2.0, 3.0, 3.0));
    mesh.positions.extend(&other.positions);
    mesh.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + 8)));
    mesh.triangle_surfaces.extend(&other.triangle_surfaces);
    mesh.corner_normals.extend(&other.corner_normals);
    assert!(mesh.check().is_manifold());
    let (obj, _) = written(&mesh);
    let back = read_obj(&obj, |_| None).expect("read");
    assert_eq!(back.positions.len(), 16);
    assert!(back.check().is_manifold());
}

#[test]
fn other_programs_files_are_read() {
    let text = b"# cube corner\r\nmtllib none.mtl\r\no thing\r\nv 0 0 0\r\nv 1 0 0 0.5 0.5 0.5\r\n\
        v 1 1 0\r\nv 0 1 0\r\nvt 0 0\r\nvn 0 0 2\r\ns off\r\nf 1/1/1 2/1/1 \\\r\n 3/1/1 4/1/1\r\n\
        l 1 2\r\nf -4/-1 -3/-1 -1/-1\r\n";
    let mesh = read_obj(text, |_| None).expect("read");
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 3]]);
    assert_eq!(mesh.surfaces[0].name.as_deref(), Some("thing"));
    assert!(mesh.corner_normals.is_empty(), "one face has no normals");
    for (text, words) in [
        ("v 1 2", "line 1: v needs three"),
        ("v 1-2 3\n", "line 1: v needs three"),
        ("v 1.5.5 2\n", "line 1: v needs three"),
        ("v 1 2 1e400\n", "line 1: v needs three"),
        (
            "v 0 0 0\nf 1 1 2",
            "line 2: \"2\" names none of the 1 vertices",
        ),
        ("v 0 0 0\nf 1 1", "line 2: a face needs"),
        ("v 0 0 0\n\nf 1 0 1", "line 3: \"0\""),
        ("v 0 0 nan", "line 1"),
        ("v 0 0 0\nf 1//1 1//1 1//1", "none of the 0 normals"),
    ] {
        let error = read_obj(text.as_bytes(), |_| None)
            .expect_err(text)
            .to_string();
        assert!(error.contains(words), "{text:?}: {error}");
    }
}

proptest! {
    /// Every double comes back with the same bits.
    #[test]
    fn numbers_are_exact(bits in prop::collection::vec(any::<[u64; 3]>(), 3..20)) {
        let positions: Vec<DVec3> = bits
            .iter()
            .map(|b| DVec3::from_array(b.map(f64::from_bits)))
            .filter(|p| p.is_finite())
            .chain([DVec3::splat(-0.0), dvec3(1e15, -1e16, 5e-324), DVec3::ONE])
            .collect();
        let mesh = Mesh::new(positions, vec![[0, 1, 2]]);
        let mut obj = Vec::new();
        write_obj(&mesh, None, &mut obj).expect("written");
        let back = read_obj(&obj, |_| None).expect("read");
        for (a, b) in back.positions.iter().zip(&mesh.positions) {
            prop_assert_eq!(a.to_array().map(f64::to_bits), b.to_array().map(f64::to_bits));
        }
    }
}

/// A file of some megabytes: fans of three triangles, of two names in turn,
/// each with indices from 1 or counted backwards.
fn large_file(backwards: bool) -> String {
    let mut text = String::new();
    for fan in 0..60_000 {
        let name = ["odd", "even"][usize::from(fan % 1000 < 500)];
        if fan % 500 == 0 {
            text += &format!("g {name}\n");
        }
        for corner in 0..5 {
            text += &format!("v {fan}.5 {corner}.25 -{}\n", fan % 7);
        }
        text += "vn 0 0 1\n";
        let at = |corner: i64| {
            if backwards {
                corner - 5
            } else {
                5 * fan + corner + 1
            }
        };
        let normal = if backwards { -1 } else { fan + 1 };
        text += "f";
        for corner in 0..5 {
            text += &format!(" {}//{normal}", at(corner));
            // (A line that goes on in the next one.)
            if corner == 2 {
                text += " \\\n";
            }
        }
        text += "\n";
    }
    text
}

#[test]
fn large_files_are_read_piece_by_piece() {
    let read = |text: &str| read_obj(text.as_bytes(), |_| None);
    let mesh = read(&large_file(false)).expect("valid");
    assert_eq!(mesh.positions.len(), 300_000);
    assert_eq!(mesh.triangles.len(), 180_000);
    assert_eq!(mesh.corner_normals.len(), 180_000);
    for fan in (0..60_000).step_by(77) {
        let place = dvec3(fan as f64 + 0.5, 3.25, -((fan % 7) as f64));
        assert_eq!(mesh.positions[5 * fan + 3], place);
        let base = 5 * fan as u32;
        assert_eq!(mesh.triangles[3 * fan + 2], [base, base + 3, base + 4]);
        let surface = mesh.triangle_surfaces[3 * fan] as usize;
        let name = ["odd", "even"][usize::from(fan % 1000 < 500)];
        assert_eq!(mesh.surfaces[surface].name.as_deref(), Some(name));
    }
    assert!(read(&large_file(true)).expect("valid") == mesh);
    // Lines that are read word by word say the same.
    let unusual = large_file(false).replace("v ", "v\t+").replace("f ", "f  ");
    assert!(read(&unusual).expect("valid") == mesh);
    // Wrong in the last line: a vertex that does not come, and one that comes
    // too late.
    for end in ["f 1 2 300001\n", "f 1 2 300001\nv 1 2 3\n"] {
        let text = large_file(false) + end;
        let line = large_file(false).lines().count() + 1;
        let error = read(&text).expect_err("no such vertex").to_string();
        let expected = format!("line {line}: \"300001\" names none of the 300000 vertices");
        assert!(error.starts_with(&expected), "{error}");
    }
}
