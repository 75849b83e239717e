//! What the Khronos glTF validator says about the files written here. The
//! test installs the validator itself (once, under the target folder); it
//! needs Node.js with npm, and fails without.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{colored_box, in_unit, small_box, sphere};
use csg::{LengthUnit, Merger, Mesh, Mesher, Program, Solid};
use glam::{DVec3, dvec3};
use io::shard::write_merged;
use io::{WriteOptions, write_mesh};

/// The folder with the validator's `node_modules`.
fn installed_validator() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("gltf-validator-2.0.0-dev.3.10-and-gltf-transform-4.5.1");
    fs::create_dir_all(&folder).expect("a folder for the validator");
    // Tests run in parallel: one installs, the others wait.
    let lock = File::create(folder.join("lock")).expect("a lock file");
    lock.lock().expect("the lock");
    let done = folder.join("installed");
    if !done.exists() {
        let package = include_str!("validator/package.json");
        fs::write(folder.join("package.json"), package).expect("package.json");
        let npm = if cfg!(windows) { "npm.cmd" } else { "npm" };
        let output = Command::new(npm)
            .args(["install", "--no-audit", "--no-fund", "--ignore-scripts"])
            .current_dir(&folder)
            .output()
            .unwrap_or_else(|error| {
                panic!("this test needs npm: install Node.js 18 or later ({error})")
            });
        assert!(
            output.status.success(),
            "npm could not install gltf-validator 2.0.0-dev.3.10 (is the registry reachable?):\n{}",
            String::from_utf8_lossy(&output.stderr)
        );
        fs::write(done, "").expect("a marker");
    }
    folder
}

/// The validator's verdict on each file.
fn validate(files: &[PathBuf]) -> Vec<serde_json::Value> {
    ask("validate.cjs", files)
}

/// What a script says of each file.
fn ask(script: &str, files: &[PathBuf]) -> Vec<serde_json::Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/validator");
    let script = folder.join(script);
    let output = Command::new("node")
        .env("NODE_PATH", installed_validator().join("node_modules"))
        .arg(script)
        .args(files)
        .output()
        .unwrap_or_else(|error| panic!("this test needs node: install Node.js ({error})"));
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let lines = String::from_utf8(output.stdout).expect("UTF-8");
    let reports: Vec<_> = lines
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(reports.len(), files.len());
    reports
}

#[test]
fn the_khronos_validator_finds_nothing() {
    let mut bare = small_box();
    bare.corner_normals.clear();
    bare.surfaces.clear();
    bare.triangle_surfaces.clear();
    // Normals that the writer must repair: zero, NaN, not of unit length.
    let mut broken_normals = small_box();
    broken_normals.corner_normals[0][0] = glam::Vec3::ZERO;
    broken_normals.corner_normals[1][1] = glam::Vec3::NAN;
    broken_normals.corner_normals[2] = [glam::vec3(0.0, 0.0, 7.0); 3];
    let mut odd_color = small_box();
    odd_color.surfaces[1].color = Some(csg::Color::from_linear([2.0, -1.0, f32::NAN]));
    // A part of more than 65535 vertices (32 bits an index) beside small ones.
    let mut wide = sphere(DVec3::ZERO, 10.0, 200);
    wide.surfaces = small_box().surfaces;
    wide.triangle_surfaces = vec![0; wide.triangles.len()];
    wide.triangle_surfaces[..3].copy_from_slice(&[1, 1, 1]);
    let far = dvec3(1e6, -3e8, 1e12);
    let thin = colored_box(DVec3::ZERO, dvec3(1.0, 1.0, 1e-9));
    let meshes: Vec<(&str, Mesh, u64)> = vec![
        ("box", small_box(), 3),
        ("bare", bare, 1),
        ("broken normals", broken_normals, 3),
        ("odd-color", odd_color, 4),
        ("sphere", sphere(DVec3::ZERO, 10.0, 40), 1),
        ("far", sphere(far, 1.0, 12), 1),
        ("tiny", sphere(DVec3::ZERO, 1e-6, 12), 1),
        ("huge", sphere(DVec3::ZERO, 1e6, 12), 1),
        ("thin", thin, 3),
        ("wide", wide, 2),
        ("inch", in_unit(small_box(), LengthUnit::Inch), 3),
        (
            "micrometre",
            in_unit(small_box(), LengthUnit::Micrometre),
            3,
        ),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let mut files = Vec::new();
    for (name, mesh, _) in &meshes {
        for extension in ["glb", "gltf"] {
            let file = folder.path().join(format!("{name}.{extension}"));
            write_mesh(&file, mesh, &WriteOptions::default()).expect("written");
            files.push(file);
        }
    }
    let reports = validate(&files);
    for (pair, (name, mesh, materials)) in reports.chunks(2).zip(&meshes) {
        for report in pair {
            assert_eq!(report["numErrors"], 0, "{name}: {report:#}");
            assert_eq!(report["numWarnings"], 0, "{name}: {report:#}");
            assert_eq!(report["totalTriangleCount"], mesh.triangles.len(), "{name}");
            assert_eq!(report["materialCount"], *materials, "{name}");
        }
    }
}

#[test]
fn chunks_of_a_merged_mesh_pass() {
    let red = csg::Color::from_srgb([0.8, 0.1, 0.1]);
    let solid = Solid::sphere(1.0) - Solid::cube(1.0).translate([0.5; 3]).colored(red);
    let program = Program::lower(&solid).expect("a valid solid");
    let mesher = Mesher::new().cells(480);
    let slabs = (0..3).map(|part| mesher.slab(&program, part, 3));
    let slabs = slabs.collect::<Result<_, _>>().expect("slabs");
    let merger = Merger::new(slabs).expect("slabs of one mesh");
    assert!(merger.triangle_count() > io::gltf::CHUNK);
    let folder = tempfile::tempdir().expect("a folder");
    let files = write_merged(folder.path().join("ball.glb"), &merger).expect("written");
    let report = &validate(&files)[0];
    assert_eq!(report["numErrors"], 0, "{report:#}");
    assert_eq!(report["numWarnings"], 0, "{report:#}");
    assert_eq!(report["totalTriangleCount"], merger.triangle_count());
    assert_eq!(report["materialCount"], 2);
    let read = io::gltf::read_glb(&fs::read(&files[0]).expect("a file")).expect("GLB");
    let whole = mesher.mesh(&program).expect("a mesh").mesh;
    assert!((read.volume() - whole.volume()).abs() < 1e-5);
}

#[test]
fn the_validator_does_find_faults() {
    // Guards the test above: a file with a wrong bound must not pass.
    let mut bytes = Vec::new();
    io::gltf::write_glb(&small_box(), &mut bytes).expect("written");
    let text = b"\"count\":";
    let at = bytes
        .windows(text.len())
        .position(|w| w == text)
        .expect("a count");
    bytes[at + text.len()] = b'9';
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("wrong.glb");
    fs::write(&file, bytes).expect("written");
    assert_ne!(validate(&[file])[0]["numErrors"], 0);
}

/// Compressed files: without a fault to the validator (which does not decode them), and decoded by
/// gltf-transform and by our reader to the same solid.
#[cfg(feature = "compress")]
#[test]
fn compressed_files_are_read_by_gltf_transform() {
    let mut options = WriteOptions::default();
    options.compress = true;
    let mut wide = sphere(DVec3::ZERO, 10.0, 200);
    wide.surfaces = small_box().surfaces;
    wide.triangle_surfaces = vec![0; wide.triangles.len()];
    wide.triangle_surfaces[..3].copy_from_slice(&[1, 1, 1]);
    let mut bare = sphere(DVec3::ZERO, 1e-3, 30);
    bare.corner_normals.clear();
    let meshes = [
        ("box", small_box()),
        ("bare", bare),
        ("wide", wide),
        ("far", sphere(dvec3(1e5, -3e5, 1e6), 1.0, 40)),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let mut files = Vec::new();
    for (name, mesh) in &meshes {
        let file = folder.path().join(format!("{name}.glb"));
        write_mesh(&file, mesh, &options).expect("written");
        let plain = folder.path().join("plain.glb");
        write_mesh(&plain, mesh, &WriteOptions::default()).expect("written");
        let size = |file: &Path| fs::metadata(file).expect("a file").len();
        println!("{name}: {} bytes, compressed {}", size(&plain), size(&file));
        assert!(*name == "box" || 2 * size(&file) < size(&plain));
        files.push(file);
    }
    let verdicts = validate(&files);
    let decoded = ask("decode.cjs", &files);
    for (((name, mesh), file), (verdict, decoded)) in
        meshes.iter().zip(&files).zip(verdicts.iter().zip(&decoded))
    {
        assert_eq!(verdict["numErrors"], 0, "{name}: {verdict:#}");
        assert_eq!(verdict["numWarnings"], 0, "{name}: {verdict:#}");
        let extensions = ["EXT_meshopt_compression", "KHR_mesh_quantization"];
        assert_eq!(
            decoded["extensions"],
            serde_json::json!(extensions),
            "{name}"
        );
        assert_eq!(decoded["triangles"], mesh.triangles.len(), "{name}");
        assert!(
            decoded["worst"].as_f64().expect("a number") < 0.01,
            "{name}"
        );
        let cubed = mesh.unit.in_metres().powi(3);
        // A 65,535th of the side at every point moves the volume by a few of these.
        let near = |volume: f64| (volume / mesh.volume() - 1.0).abs() < 1e-4;
        let volume = decoded["volume"].as_f64().expect("a number") / cubed;
        // (Other programs place vertices in single precision.)
        assert!(*name == "far" || near(volume), "{name}: {volume}");
        let back = io::read_mesh(file).expect("read");
        assert!(near(back.volume()), "{name}: {}", back.volume());
        assert_eq!(back.triangles.len(), mesh.triangles.len(), "{name}");
        assert!(back.check().is_manifold(), "{name}");
        let (low, high) = mesh.bounds().expect("bounds");
        let (back_low, back_high) = back.bounds().expect("bounds");
        let step = (high - low).max_element() / 65_535.0;
        assert!((low - back_low).abs().max_element() <= step, "{name}");
        assert!((high - back_high).abs().max_element() <= step, "{name}");
    }
}

/// Bodies that are there several times, written once: without a fault to the validator, and to
/// gltf-transform the same solid.
#[test]
fn instances_are_read_by_gltf_transform() {
    let mut meshes = Vec::new();
    for (name, is_turned) in [("moved", false), ("turned", true)] {
        for with_normals in [true, false] {
            let mut mesh = small_box();
            mesh.positions.clear();
            mesh.triangles.clear();
            let body = small_box();
            for k in 0..30_u32 {
                let first = mesh.positions.len() as u32;
                let angle = if is_turned { 0.2 * f64::from(k) } else { 0.0 };
                let turn = csg::elementary::rotation(dvec3(0.6, 0.0, 0.8), angle);
                let at = dvec3(5.0 * f64::from(k), 1.0 / 3.0, 2.0);
                let places = body.positions.iter().map(|&p| turn * p + at);
                mesh.positions.extend(places);
                let corners = body.triangles.iter().map(|t| t.map(|v| first + v));
                mesh.triangles.extend(corners);
            }
            mesh.triangle_surfaces = body.triangle_surfaces.repeat(30);
            mesh.corner_normals.clear();
            if with_normals {
                for k in 0..30_u32 {
                    let angle = if is_turned { 0.2 * f64::from(k) } else { 0.0 };
                    let turn = csg::elementary::rotation(dvec3(0.6, 0.0, 0.8), angle);
                    let turned = |n: glam::Vec3| (turn * n.as_dvec3()).as_vec3();
                    let normals = body.corner_normals.iter().map(|n| n.map(turned));
                    mesh.corner_normals.extend(normals);
                }
            }
            meshes.push((name, mesh));
        }
    }
    let compressions: &[bool] = if cfg!(feature = "compress") {
        &[false, true]
    } else {
        &[false]
    };
    let folder = tempfile::tempdir().expect("a folder");
    let mut cases = Vec::new();
    for (number, (name, mesh)) in meshes.iter().enumerate() {
        for &compress in compressions {
            let mut options = WriteOptions::default();
            options.instances = true;
            #[cfg(feature = "compress")]
            {
                options.compress = compress;
            }
            let mut extensions = vec!["glb"];
            extensions.extend((!compress).then_some("gltf"));
            for extension in extensions {
                let name = format!("{name}-{number}-{compress}.{extension}");
                let file = folder.path().join(&name);
                write_mesh(&file, mesh, &options).expect("written");
                cases.push((name, mesh, compress, file));
            }
        }
    }
    let files: Vec<PathBuf> = cases.iter().map(|case| case.3.clone()).collect();
    let verdicts = validate(&files);
    let decoded = ask("decode.cjs", &files);
    for (((name, mesh, compress, file), verdict), decoded) in
        cases.iter().zip(&verdicts).zip(&decoded)
    {
        assert_eq!(verdict["numErrors"], 0, "{name}: {verdict:#}");
        assert_eq!(verdict["numWarnings"], 0, "{name}: {verdict:#}");
        assert_eq!(verdict["totalTriangleCount"], 12, "{name}");
        let extensions = decoded["extensions"].as_array().expect("extensions");
        assert!(
            extensions.contains(&"EXT_mesh_gpu_instancing".into()),
            "{name}"
        );
        assert_eq!(decoded["triangles"], mesh.triangles.len(), "{name}");
        let cubed = mesh.unit.in_metres().powi(3);
        let near = |volume: f64| (volume / mesh.volume() - 1.0).abs() < 1e-4;
        let volume = decoded["volume"].as_f64().expect("a number") / cubed;
        assert!(near(volume), "{name}: {volume}");
        let back = io::read_mesh(file).expect("read");
        assert_eq!(back.triangles.len(), mesh.triangles.len(), "{name}");
        assert!(near(back.volume()), "{name}: {}", back.volume());
        assert!(back.check().is_manifold(), "{name}");
        let (low, high) = mesh.bounds().expect("bounds");
        let (back_low, back_high) = back.bounds().expect("bounds");
        let step = (high - low).max_element() / if *compress { 65_535.0 } else { 4e6 };
        assert!((low - back_low).abs().max_element() <= step, "{name}");
        assert!((high - back_high).abs().max_element() <= step, "{name}");
    }
}

/// Code that is damaged, cut off, or says that it is far longer than it is.
#[cfg(feature = "compress")]
#[test]
fn damaged_code_is_refused_or_decoded_to_something() {
    let mut bytes = Vec::new();
    io::gltf::write_glb_compressed(&sphere(DVec3::ZERO, 1.0, 8), &mut bytes).expect("written");
    let json = bytes.windows(4).position(|w| w == b"BIN\0").expect("data") + 4;
    for at in json..bytes.len() {
        for byte in [0, 0x55, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] = byte;
            if let Ok(mesh) = io::gltf::read_glb(&damaged) {
                assert_eq!(mesh.check().out_of_range_triangles, 0);
            }
        }
    }
    let count = b"\"count\":";
    let found = bytes.windows(count.len()).position(|w| w == count);
    let at = found.expect("a count") + count.len();
    for digit in b'0'..=b'9' {
        let mut damaged = bytes.clone();
        damaged[at] = digit;
        let _ = io::gltf::read_glb(&damaged);
    }
}
