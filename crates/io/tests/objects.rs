//! Units of mesh files, and what several objects of one are as a solid.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::archive;
use csg::glam::{DVec3, Vec3};
use csg::{BoundaryOptions, LengthUnit, Program, Solid};
use io::scene::{self, SceneError};
use io::{
    Error, MeshFile, SolidOptions, WriteOptions, read_mesh_file, read_mesh_with, read_solid,
    read_solid_with, unit_ratio, write_mesh,
};

const UNITS: [LengthUnit; 6] = [
    LengthUnit::Micrometre,
    LengthUnit::Millimetre,
    LengthUnit::Centimetre,
    LengthUnit::Metre,
    LengthUnit::Inch,
    LengthUnit::Foot,
];

fn volume(solid: &Solid) -> f64 {
    let program = Program::lower(solid).expect("a program");
    let boundary = program.boundary(&BoundaryOptions::new());
    boundary.expect("a boundary").measure().volume.value
}

/// How large a cube is, and where its first corner.
type Place = (f64, [f64; 3]);

/// The corners of a cube and its faces outwards.
const CUBE: [[u32; 4]; 6] = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
];

fn corner(k: u32) -> [f64; 3] {
    [k & 1, k >> 1 & 1, k >> 2].map(f64::from)
}

/// A 3MF model of the unit cube (a mirrored one too, where a scale says so) in these places.
fn cubes(unit: &str, places: &[Place]) -> Vec<u8> {
    let vertices = (0..8).map(corner);
    let vertices: String = vertices
        .map(|[x, y, z]| format!("<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>"))
        .collect();
    let faces = CUBE.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let triangles: String = faces
        .map(|[a, b, c]| format!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>"))
        .collect();
    let items: String = places
        .iter()
        .map(|(s, [x, y, z])| {
            format!("<item objectid=\"1\" transform=\"{s} 0 0 0 {s} 0 0 0 {s} {x} {y} {z}\"/>")
        })
        .collect();
    let model = format!(
        "<model unit=\"{unit}\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\
         <resources><object id=\"1\"><mesh><vertices>{vertices}</vertices>\
         <triangles>{triangles}</triangles></mesh></object></resources>\
         <build>{items}</build></model>"
    );
    archive(model.as_bytes())
}

/// The same as OBJ, an object each.
fn cubes_as_obj(places: &[Place]) -> String {
    let mut text = String::new();
    for (number, (scale, offset)) in places.iter().enumerate() {
        text += &format!("o Cube{number}\n");
        for at in (0..8).map(corner) {
            let [x, y, z] = [0, 1, 2].map(|axis: usize| scale * at[axis] + offset[axis]);
            text += &format!("v {x} {y} {z}\n");
        }
        for face in CUBE {
            let [a, b, c, d] = face.map(|k| k as usize + 1 + 8 * number);
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

/// Files of cubes in one folder.
fn files(folder: &Path, places: &[Place]) -> [PathBuf; 3] {
    let [threemf, obj, glb] = ["a.3mf", "a.obj", "a.glb"].map(|name| folder.join(name));
    fs::write(&threemf, cubes("millimeter", places)).expect("written");
    fs::write(&obj, cubes_as_obj(places)).expect("written");
    fs::write(&glb, cubes_as_glb(places)).expect("written");
    [threemf, obj, glb]
}

/// The same as GLB, in metres and Y up, a node each.
fn cubes_as_glb(places: &[Place]) -> Vec<u8> {
    let positions = (0..8).flat_map(|k| corner(k).map(|x| (x * 1e-3) as f32));
    let mut data: Vec<u8> = positions.flat_map(f32::to_le_bytes).collect();
    let faces = CUBE.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]);
    data.extend(faces.flat_map(u32::to_le_bytes));
    // (With Y up the offset (x, y, z) is (x, z, -y), and so is the cube in its own axes.)
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    let nodes: Vec<String> = places
        .iter()
        .map(|(scale, [x, y, z])| {
            format!(
                "{{\"mesh\": 0, \"scale\": [{scale}, {scale}, {scale}], \
                 \"rotation\": [{}, 0, 0, {quarter}], \
                 \"translation\": [{}, {}, {}]}}",
                -quarter,
                x / 1e3,
                z / 1e3,
                -y / 1e3
            )
        })
        .collect();
    let list: Vec<String> = (0..places.len()).map(|k| k.to_string()).collect();
    let json = format!(
        "{{\"asset\": {{\"version\": \"2.0\"}}, \"scene\": 0, \"scenes\": [{{\"nodes\": [{}]}}], \
         \"nodes\": [{}], \"buffers\": [{{\"byteLength\": 240}}], \"bufferViews\": \
         [{{\"buffer\": 0, \"byteLength\": 96}}, {{\"buffer\": 0, \"byteOffset\": 96, \
         \"byteLength\": 144}}], \"accessors\": [{{\"bufferView\": 0, \"componentType\": 5126, \
         \"count\": 8, \"type\": \"VEC3\", \"min\": [0, 0, 0], \"max\": [0.001, 0.001, 0.001]}}, \
         {{\"bufferView\": 1, \"componentType\": 5125, \"count\": 36, \"type\": \"SCALAR\"}}], \
         \"meshes\": [{{\"primitives\": [{{\"attributes\": {{\"POSITION\": 0}}, \"indices\": 1}}]}}]}}",
        list.join(","),
        nodes.join(",")
    );
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + data.len();
    for number in [2, total, json.len()] {
        file.extend((number as u32).to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(json);
    file.extend((data.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(data);
    file
}

fn read_file(path: &Path) -> MeshFile {
    read_mesh_file(path, &io::ReadOptions::default()).expect("read")
}

#[test]
fn lengths_of_units_are_converted_and_return() {
    for (from, to, ratio) in [
        (LengthUnit::Inch, LengthUnit::Millimetre, 25.4),
        (LengthUnit::Foot, LengthUnit::Inch, 12.0),
        (LengthUnit::Metre, LengthUnit::Micrometre, 1e6),
        (LengthUnit::Millimetre, LengthUnit::Centimetre, 0.1),
    ] {
        assert_eq!(unit_ratio(from, to), ratio);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.3mf");
    fs::write(&path, cubes("inch", &[(1.0, [0.1, 0.7, -3.0])])).expect("written");
    let file = read_file(&path);
    assert!(file.has_unit);
    assert_eq!(file.mesh.unit, LengthUnit::Inch);
    for unit in UNITS {
        let other = file.clone().in_unit(unit);
        assert_eq!(other.mesh.unit, unit);
        let ratio = unit_ratio(LengthUnit::Inch, unit);
        let volume = other.mesh.volume();
        assert!((volume / ratio.powi(3) - 1.0).abs() < 1e-13, "{unit:?}");
        let back = other.in_unit(LengthUnit::Inch).mesh;
        for (found, wanted) in back.positions.iter().zip(&file.mesh.positions) {
            let off = (*found - *wanted).abs().max_element();
            assert!(off <= 2.0 * f64::EPSILON * wanted.abs().max_element());
        }
    }
}

/// What is written with a unit is read with it, with the same numbers, and as a solid is as large
/// as it was; numbers of formats without a unit are taken as they are.
#[test]
fn solids_of_files_are_as_large_as_the_files_say() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = Program::lower(&Solid::cuboid([1.0, 2.0, 3.0])).expect("a program");
    for unit in UNITS {
        let mesh = csg::Mesher::new().unit(unit).mesh(&program);
        let mesh = mesh.expect("a mesh").mesh;
        for name in [
            "a.3mf", "a.glb", "a.gltf", "a.stl", "a.obj", "a.ply", "a.off",
        ] {
            let path = folder.path().join(name);
            write_mesh(&path, &mesh, &WriteOptions::default()).expect("written");
            let file = read_file(&path);
            let is_same = (mesh.positions.iter()).all(|p| file.mesh.positions.contains(p));
            assert!(is_same, "{name} {unit:?}");
            assert_eq!(
                file.mesh.unit == unit,
                file.has_unit || unit == LengthUnit::Millimetre
            );
            let ratio = match file.has_unit {
                true => unit_ratio(unit, LengthUnit::Millimetre),
                false => 1.0,
            };
            let solid = read_solid(&path).expect("a solid");
            let found = volume(&solid) / ratio.powi(3);
            assert!((found / 6.0 - 1.0).abs() < 1e-9, "{name} {unit:?}: {found}");
            let options = SolidOptions::default().unit(unit);
            let (solid, repairs) = read_solid_with(&path, &options).expect("a solid");
            assert!(repairs.is_empty());
            let found = volume(&solid);
            assert!((found / 6.0 - 1.0).abs() < 1e-9, "{name} {unit:?}: {found}");
        }
    }
}

#[test]
fn scenes_convert_what_they_import_and_say_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.3mf");
    fs::write(&path, cubes("inch", &[(1.0, [0.0; 3])])).expect("written");
    let options = scene::ReadOptions::default().folder(folder.path());
    let text = "union() { import(\"a.3mf\"); cube(1); }";
    let scene = scene::read(text, &options).expect("a scene");
    assert!((volume(&scene.solid) - 25.4_f64.powi(3)).abs() < 1e-6);
    let [warning] = &scene.warnings[..] else {
        panic!("{:?}", scene.warnings);
    };
    let said = warning.to_string();
    assert!(said.contains("from in to mm: 25.4 times"), "{said}");
    let scene = scene::read(text, &options.clone().unit(LengthUnit::Inch)).expect("a scene");
    assert!((volume(&scene.solid) - 1.0).abs() < 1e-12);
    assert!(scene.warnings.is_empty());
    // A file without a unit.
    fs::write(
        folder.path().join("a.obj"),
        cubes_as_obj(&[(1.0, [0.0; 3])]),
    )
    .expect("written");
    let options = options.unit(LengthUnit::Foot);
    let scene = scene::read("import(\"a.obj\");", &options).expect("a scene");
    assert!((volume(&scene.solid) - 1.0).abs() < 1e-12);
    assert!(scene.warnings.is_empty());
}

/// Objects that share a face, overlap, lie in each other or meet nowhere, all three at once.
#[test]
fn solids_of_objects_are_their_union() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases: [(&[Place], f64, bool); 6] = [
        (&[(1.0, [0.0; 3]), (1.0, [1.0, 0.0, 0.0])], 2.0, true),
        (&[(1.0, [0.0; 3]), (1.0, [0.5; 3])], 1.875, true),
        (&[(1.0, [1.0; 3]), (4.0, [0.0; 3])], 64.0, true),
        (&[(1.0, [0.0; 3]), (1.0, [3.0, 0.0, 0.0])], 2.0, false),
        // Equal ones.
        (&[(1.0, [0.0; 3]), (1.0, [0.0; 3])], 1.0, true),
        (
            &[
                (1.0, [9.0, 0.0, 0.0]),
                (1.0, [0.0; 3]),
                (1.0, [0.0, 0.25, 1.0]),
                (2.0, [0.5, -0.5, -0.5]),
                (0.5, [1.0, 0.0, 0.0]),
            ],
            // One overlaps the large one by 0.5, and one is in it; the third meets it nowhere
            // but for 0.5 x 0.75 x 0.5.
            1.0 + 1.0 + 1.0 + 8.0 - 0.5 - 0.5 * 1.0 * 0.5,
            true,
        ),
    ];
    for (places, wanted, meeting) in cases {
        for path in files(folder.path(), places) {
            let file = read_file(&path);
            let name = path.display();
            assert_eq!(file.objects.len(), places.len(), "{name}");
            let found = file.meeting_objects();
            assert_eq!(found.is_some(), meeting, "{name}");
            assert!(found.is_none_or(|[one, other]| one != other), "{name}");
            let solid = read_solid(&path).expect("a solid");
            let found = volume(&solid);
            assert!(
                (found / wanted - 1.0).abs() < 1e-6,
                "{name}: {found} {wanted}"
            );
            let (solid, repairs) =
                read_solid_with(&path, &SolidOptions::default().repair(true)).expect("a solid");
            assert!(repairs.is_empty(), "{name}: {repairs}");
            assert!((volume(&solid) / wanted - 1.0).abs() < 1e-6, "{name}");
            // The mesh stays what it was.
            let mesh = read_mesh_with(&path, &io::ReadOptions::default()).expect("a mesh");
            let sum: f64 = places.iter().map(|(scale, _)| scale.powi(3)).sum();
            assert!((mesh.volume() / sum - 1.0).abs() < 1e-6, "{name}");
        }
    }
}

/// Objects that are parts of one boundary, or hollows of another one, are taken together.
#[test]
fn objects_that_bound_a_solid_together_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.obj");
    let faces = cubes_as_obj(&[(1.0, [0.0; 3])]).replace("f ", "o Face\nf ");
    fs::write(&path, faces).expect("written");
    assert_eq!(read_file(&path).objects.len(), 6);
    let found = volume(&read_solid(&path).expect("a solid"));
    assert!((found - 1.0).abs() < 1e-12, "{found}");

    // The inner one turned.
    let cubes = cubes_as_obj(&[(3.0, [0.0; 3]), (1.0, [1.0; 3])]);
    let (outer, inner) = cubes.split_once("o Cube1").expect("two");
    let turned: String = inner
        .lines()
        .map(
            |line| match line.split_whitespace().collect::<Vec<_>>()[..] {
                ["f", a, b, c, d] => format!("f {d} {c} {b} {a}\n"),
                _ => format!("{line}\n"),
            },
        )
        .collect();
    fs::write(&path, format!("{outer}o Cube1{turned}")).expect("written");
    assert!(read_file(&path).meeting_objects().is_none());
    let found = volume(&read_solid(&path).expect("a solid"));
    assert!((found - 26.0).abs() < 1e-12, "{found}");
}

#[test]
fn triangles_that_vanish_are_of_no_object() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.obj");
    let text = cubes_as_obj(&[(1.0, [0.0; 3]), (1.0, [5.0; 3])]);
    let text = text.replace("o Cube1", "f 1 1 2\no Nothing\nf 3 3 3\no Cube1");
    fs::write(&path, text).expect("written");
    assert_eq!(read_file(&path).objects, [0..12, 12..24]);
}

#[test]
fn errors_of_imports_name_the_file_and_all_that_is_wrong() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = cubes_as_obj(&[(1.0, [0.0; 3]), (1.0, [0.5; 3])]);
    // The second one is open: neither it nor both bound a solid.
    let open = text.rsplit_once("f ").expect("faces").0;
    let path = folder.path().join("a.obj");
    fs::write(&path, open).expect("written");
    let Err(Error::InFile { source, .. }) = read_solid(&path) else {
        panic!("an error");
    };
    assert!(matches!(*source, Error::NotASolid(_)));
    let options = scene::ReadOptions::default().folder(folder.path());
    let error = scene::read("\n  import(\"a.obj\");", &options).expect_err("no solid");
    let place = error.place().expect("a place");
    assert_eq!((place.line, place.column), (2, 3));
    assert!(matches!(error, SceneError::NotASolid { .. }), "{error}");
    let said = error.to_string();
    assert!(said.contains("a.obj: the mesh bounds no solid"), "{said}");
    assert!(said.contains("open edge"), "{said}");
    assert!(said.contains("through each other"), "{said}");
}

#[test]
fn meshes_are_turned_with_their_normals() {
    let mut file = MeshFile::default();
    file.mesh = csg::Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]);
    file.mesh.corner_normals = vec![[Vec3::Z; 3]];
    let turned = file.turned().mesh;
    assert_eq!(turned.triangles, [[2, 1, 0]]);
    assert_eq!(turned.corner_normals, [[-Vec3::Z; 3]]);
}
