//! Solids from files: `read_solid`, and the nodes `import` and `surface`.

use std::fs::{self, File};
use std::path::Path;

use crate::common;
use csg::{Mesh, Mesher, Program, Solid};
use io::scene::{ReadOptions, read, read_file};
use io::{Error, MeshFormat, SolidOptions, WriteOptions, read_solid, read_solid_with, write_mesh};

fn mesh(solid: &Solid) -> Mesh {
    let program = Program::lower(solid).expect("a program");
    let meshed = Mesher::new().mesh(&program).expect("a mesh");
    assert!(meshed.report.check.is_manifold());
    meshed.mesh
}

fn volume(solid: &Solid) -> f64 {
    mesh(solid).volume()
}

/// A block with a step, which is not convex: volume 7.
fn step() -> Mesh {
    let solid = Solid::cuboid_between([0.0; 3], [2.0; 3])
        - Solid::cuboid_between([1.0, 1.0, 1.0], [3.0, 3.0, 3.0]);
    mesh(&solid)
}

/// A box without provenance: volume 6.
fn bare() -> Mesh {
    let Mesh {
        positions,
        triangles,
        ..
    } = common::small_box();
    Mesh::new(positions, triangles)
}

#[test]
fn every_mesh_format_that_is_read_gives_the_solid() {
    let folder = tempfile::tempdir().expect("a folder");
    for format in MeshFormat::ALL {
        let path = folder.path().join(format!("step.{}", format.extension()));
        write_mesh(&path, &step(), &WriteOptions::default()).expect("written");
        match read_solid(&path) {
            Ok(solid) => {
                assert!((volume(&solid) - 7.0).abs() < 1e-12, "{format}");
                // A solid like any other.
                let half = solid & Solid::half_space([0.0, 0.0, 1.0], 1.0);
                assert!((volume(&half) - 4.0).abs() < 1e-12, "{format}");
            }
            Err(error) => assert_eq!(format, MeshFormat::ThreeMf, "{error}"),
        }
    }
}

#[test]
fn what_is_wrong_with_a_mesh_is_said_with_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bad.off");
    let says = |mesh: &Mesh| {
        write_mesh(&path, mesh, &WriteOptions::default()).expect("written");
        let error = read_solid(&path).expect_err("no solid");
        let text = error.to_string();
        assert!(text.contains("bad.off"), "{text}");
        text
    };
    let good = bare();
    let mut open = good.clone();
    open.triangles.pop();
    assert!(
        says(&open).contains("3 x open edge, first at ("),
        "{}",
        says(&open)
    );
    let mut turned = good.clone();
    turned.triangles[0].reverse();
    assert!(says(&turned).contains("opposite orientation, first at ("));
    let mut inside_out = good.clone();
    for triangle in &mut inside_out.triangles {
        triangle.reverse();
    }
    assert!(says(&inside_out).contains("face inwards"));
    let mut twice = good.clone();
    twice.triangles.push(good.triangles[0]);
    assert!(says(&twice).contains("duplicate triangle, first at ("));
    // A second box half in the first.
    let mut crossing = good.clone();
    let count = good.positions.len() as u32;
    let moved = good.positions.iter().map(|p| *p + 0.25);
    crossing.positions.extend(moved);
    let second = good.triangles.iter().map(|t| t.map(|v| v + count));
    crossing.triangles.extend(second);
    assert!(says(&crossing).contains("triangles through each other, first"));
    let flat = Mesh::new(good.positions.clone(), vec![[0, 1, 2], [0, 2, 1]]);
    assert!(says(&flat).contains("2 triangles enclose nothing"));
    assert!(matches!(read_solid("none.stl"), Err(Error::File { .. })));
}

/// A box without one triangle, read for itself and imported by a scene.
#[test]
fn broken_meshes_are_mended_if_asked_and_it_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("open.stl");
    let mut open = bare();
    open.triangles.pop();
    write_mesh(&path, &open, &WriteOptions::default()).expect("written");
    let (solid, repairs) =
        read_solid_with(&path, &SolidOptions::default().repair(true)).expect("a solid");
    assert!((volume(&solid) - 6.0).abs() < 1e-6);
    assert_eq!(repairs.holes, 1, "{repairs}");
    let text = "import(file = \"open.stl\");";
    let options = ReadOptions::default().folder(folder.path());
    let error = read(text, &options).expect_err("no solid");
    assert!(error.to_string().contains("open edge"), "{error}");
    let scene = read(text, &options.repair(true)).expect("a scene");
    assert!((volume(&scene.solid) - 6.0).abs() < 1e-6);
    let warning = scene.warnings[0].to_string();
    assert!(warning.contains("1 x holes closed"), "{warning}");
}

#[test]
fn off_files_of_others_are_read() {
    // Polygons, one of them not convex, comments, counts on the first line, colours.
    let text = "OFF 12 8 0 # an L\n0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n\n0 0 1\n2 0 1\n2 1 1\n1 1 1\n1 2 1\n0 2 1\n6 5 4 3 2 1 0\n6 6 7 8 9 10 11 255 0 0\n4 0 1 7 6\n4 1 2 8 7\n4 2 3 9 8\n4 3 4 10 9\n4 4 5 11 10\n4 5 0 6 11\n";
    let mesh = io::off::read_off(text.as_bytes()).expect("a mesh");
    assert!((mesh.volume() - 3.0).abs() < 1e-15 && mesh.check().is_manifold());
    for (text, place) in [
        ("OBJ\n", "line 1: this is no OFF file"),
        ("OFF\n3 x 0", "line 2: it needs the numbers"),
        ("OFF\n1 0 0\n1 2", "line 3: a vertex needs three numbers"),
        (
            "OFF\n1 0 0\n1 2 nan",
            "line 3: its coordinates are not finite",
        ),
        ("OFF\n1 1 0\n1 2 3\n3 0 0 1", "line 4: it names vertex 1"),
        (
            "OFF\n1 1 0\n1 2 3\n3 0 0",
            "line 4: the face has fewer corners",
        ),
        ("OFF\n2 1 0\n1 2 3\n", "a vertex is missing"),
        ("OFF\n4000000000 1 0\n", "a vertex is missing"),
    ] {
        let error = io::off::read_off(text.as_bytes())
            .expect_err(text)
            .to_string();
        assert!(error.contains(place), "{error}");
    }
}

#[test]
fn imports_lie_beside_the_scene_unless_others_are_allowed() {
    let folder = tempfile::tempdir().expect("a folder");
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).expect("a folder");
    let write = |path: &Path| {
        write_mesh(path, &step(), &WriteOptions::default()).expect("written");
    };
    write(&folder.path().join("step.stl"));
    write(&inner.join("step.stl"));
    let scene = |text: &str| {
        let path = folder.path().join("inner/scene.csg");
        fs::write(&path, text).expect("written");
        path
    };
    let cut = "difference() { import(file = \"step.stl\", layer = \"\", origin = [0, 0], scale = 1, convexity = 1, $fn = 0, $fa = 12, $fs = 2, timestamp = 7); cube(size = [2, 2, 1]); }";
    let solid = read_file(scene(cut), &ReadOptions::default())
        .expect("a scene")
        .solid;
    assert!((volume(&solid) - 3.0).abs() < 1e-12);
    // Without a file, without leave.
    let error = read(cut, &ReadOptions::default()).expect_err("no folder");
    assert!(
        error.to_string().contains("not read from a file"),
        "{error}"
    );
    let outside = scene("import(file = \"../step.stl\");");
    // (Whether it is there is not told.)
    for hidden in ["../none.stl", "../none/none.stl", "../step.stl"] {
        let outside = scene(&format!("import(file = \"{hidden}\");"));
        let error = read_file(&outside, &ReadOptions::default()).expect_err("outside");
        let text = error.to_string();
        assert!(
            text.contains("scene.csg:1:1") && text.contains("not in the scene's folder"),
            "{text}"
        );
        assert!(matches!(error, io::scene::SceneError::OtherFolder { .. }));
    }
    let anywhere = ReadOptions::default().any_folder(true);
    assert!(read_file(&outside, &anywhere).is_ok());
    for (node, problem) in [
        ("import(file = \"none.stl\");", "none.stl"),
        ("import(file = undef);", "the name of a `file`"),
        (
            "import(file = \"scene.csg\");",
            "no mesh format has this extension",
        ),
    ] {
        let error = read_file(scene(node), &ReadOptions::default()).expect_err(node);
        let text = error.to_string();
        assert!(
            text.contains(problem) && text.contains("scene.csg:1:1"),
            "{text}"
        );
    }
}

#[test]
fn imports_that_are_inside_out_are_turned_with_a_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut mesh = bare();
    for triangle in &mut mesh.triangles {
        triangle.reverse();
    }
    let path = folder.path().join("turned.off");
    write_mesh(&path, &mesh, &WriteOptions::default()).expect("written");
    let options = ReadOptions::default().folder(folder.path());
    let scene = read("import(file = \"turned.off\");", &options).expect("a scene");
    assert!((volume(&scene.solid) - 6.0).abs() < 1e-12);
    assert!(scene.warnings[0].problem.contains("inside out"));
}

#[test]
fn surfaces_are_the_relief_that_openscad_makes() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(
        folder.path().join("relief.dat"),
        "# heights\n1 2 3\n\n4 5 9\n",
    )
    .expect("written");
    let options = ReadOptions::default().folder(folder.path());
    for (center, x) in [(false, 0.0), (true, -1.0)] {
        let text = format!("surface(file = \"relief.dat\", center = {center}, invert = false);");
        let solid = read(&text, &options).expect("a scene").solid;
        // Over each square the mean of its corners, above 0.
        assert!((volume(&solid) - 7.75).abs() < 1e-12);
        let (min, max) = mesh(&solid).bounds().expect("not empty");
        let half = if center { -0.5 } else { 0.0 };
        assert!(min.distance([x, half, 0.0].into()) < 1e-12, "{min}");
        assert!(
            max.distance([x + 2.0, half + 1.0, 9.0].into()) < 1e-12,
            "{max}"
        );
    }
    for (data, problem) in [
        (&b"\xff\xfe1"[..], "neither a PNG picture nor a text"),
        (b"\x89PNG\r\n\x1a\nnothing", "the picture cannot be read"),
    ] {
        fs::write(folder.path().join("bad.png"), data).expect("written");
        let error = read("surface(file = \"bad.png\");", &options).expect_err(problem);
        assert!(error.to_string().contains(problem), "{error}");
    }
    fs::write(folder.path().join("bad.dat"), "1 2\n3 x\n").expect("written");
    let error = read("surface(file = \"bad.dat\");", &options).expect_err("no number");
    assert!(error.to_string().contains("line 2: \"x\""), "{error}");
}

fn picture(path: &Path, [columns, rows]: [u32; 2], color: png::ColorType, bytes: &[u8]) {
    let mut encoder = png::Encoder::new(File::create(path).expect("a file"), columns, rows);
    encoder.set_color(color);
    let mut writer = encoder.write_header().expect("a head");
    writer.write_image_data(bytes).expect("written");
}

/// White is 100 high and black 0, the lowest row comes first, and opacity is no matter.
#[test]
fn surfaces_of_pictures_are_as_high_as_they_are_light() {
    let folder = tempfile::tempdir().expect("a folder");
    let options = ReadOptions::default().folder(folder.path());
    let path = folder.path().join("relief.PNG");
    let corner_heights = |text: &str| {
        let mesh = mesh(&read(text, &options).expect("a scene").solid);
        let (min, _) = mesh.bounds().expect("not empty");
        let at = |x: f64, y: f64| {
            let above = mesh.positions.iter().filter(|p| (p.x, p.y) == (x, y));
            above.map(|p| p.z).fold(f64::NEG_INFINITY, f64::max)
        };
        [
            at(0.0, 0.0),
            at(1.0, 0.0),
            at(0.0, 1.0),
            at(1.0, 1.0),
            min.z,
        ]
    };
    let near = |found: [f64; 5], truth: [f64; 5]| {
        let off = found.iter().zip(truth).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-11, "{found:?}, not {truth:?}");
    };
    let plain = "surface(file = \"relief.PNG\");";
    let inverted = "surface(file = \"relief.PNG\", invert = true);";
    picture(
        &path,
        [2, 2],
        png::ColorType::Grayscale,
        &[51, 102, 255, 204],
    );
    near(corner_heights(plain), [100.0, 80.0, 20.0, 40.0, 19.0]);
    let one = 100.0 / 255.0;
    let negative = [-100.0, -80.0, -20.0, -40.0, -101.0].map(|height| height + one);
    near(corner_heights(inverted), negative);
    // Red, green, blue, and white that is not seen.
    let bytes = [
        255, 0, 0, 255, 0, 255, 0, 9, 0, 0, 255, 255, 255, 255, 255, 0,
    ];
    picture(&path, [2, 2], png::ColorType::Rgba, &bytes);
    near(corner_heights(plain), [7.22, 100.0, 21.26, 71.52, 6.22]);
    // As large as no solid can be, of few bytes.
    picture(
        &path,
        [4000, 4000],
        png::ColorType::Grayscale,
        &vec![7; 16_000_000],
    );
    let error = read(plain, &options).expect_err("too large");
    let problem = "relief.PNG: 4000 x 4000 pixels are too many for a solid";
    assert!(error.to_string().contains(problem), "{error}");
}
