//! Files that nobody vouches for: what they may make the reader open, and what
//! is no mesh.

use std::fs;
use std::path::Path;

use crate::common::small_box;
use io::{ReadOptions, WriteOptions, read_mesh, read_mesh_with, write_mesh};

/// Writes `folder/box.gltf`, whose data is in the file `data`.
fn document(folder: &Path, data: &str) -> std::path::PathBuf {
    let path = folder.join("box.gltf");
    write_mesh(&path, &small_box(), &WriteOptions::default()).expect("written");
    let text = fs::read_to_string(&path).expect("text");
    fs::write(&path, text.replace("box.bin", data)).expect("written");
    path
}

fn message(path: &Path) -> String {
    read_mesh(path).expect_err("refused").to_string()
}

#[test]
fn data_lies_beside_the_document_or_below() {
    let outer = tempfile::tempdir().expect("a folder");
    let inner = outer.path().join("in");
    fs::create_dir_all(inner.join("below")).expect("folders");
    let mesh = read_mesh(document(&inner, "box.bin")).expect("beside");
    let bin = inner.join("box.bin");
    fs::copy(&bin, inner.join("below/data.bin")).expect("copied");
    fs::copy(&bin, outer.path().join("above.bin")).expect("copied");
    for inside in [
        "below/data.bin",
        "./box.bin",
        "below/../box.bin",
        "../in/box.bin",
    ] {
        let read = read_mesh(document(&inner, inside)).expect(inside);
        assert_eq!(read, mesh, "{inside}");
    }
    let absolute = outer.path().join("above.bin");
    for outside in [
        "../above.bin",
        "%2e%2e/above.bin",
        &*absolute.to_string_lossy(),
    ] {
        let path = document(&inner, outside);
        let error = message(&path);
        assert!(error.contains("above.bin is not in the folder"), "{error}");
        assert!(error.contains("box.gltf"), "{error}");
        let anywhere = ReadOptions::default().any_folder(true);
        assert_eq!(read_mesh_with(&path, &anywhere).expect(outside), mesh);
    }
    // Whether it is there is nobody's business.
    for hidden in ["../none.bin", "../none/none.bin", "/none/none.bin"] {
        let error = message(&document(&inner, hidden));
        assert!(error.contains("none.bin is not in the folder"), "{error}");
    }
    let error = message(&document(&inner, "none.bin"));
    assert!(error.contains("none.bin: "), "{error}");
}

#[cfg(unix)]
#[test]
fn links_are_followed_before_the_folder_is_judged() {
    let outer = tempfile::tempdir().expect("a folder");
    let inner = outer.path().join("in");
    fs::create_dir(&inner).expect("a folder");
    let path = document(&inner, "link.bin");
    fs::rename(inner.join("box.bin"), outer.path().join("above.bin")).expect("moved");
    std::os::unix::fs::symlink("../above.bin", inner.join("link.bin")).expect("a link");
    let error = message(&path);
    assert!(error.contains("above.bin is not in the folder"), "{error}");
}

/// Each would be read for ever, or waited for.
#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let pipe = std::process::Command::new("mkfifo")
        .arg(path("pipe.bin"))
        .status();
    assert!(pipe.expect("mkfifo runs").success());
    fs::create_dir(path("folder.bin")).expect("a folder");
    std::os::unix::fs::symlink("/dev/zero", path("zero.bin")).expect("a link");
    for (name, words) in [
        ("pipe.bin", "a pipe"),
        ("folder.bin", "it is a folder"),
        ("zero.bin", "it is a device"),
    ] {
        let anywhere = ReadOptions::default().any_folder(true);
        let error = read_mesh_with(document(folder.path(), name), &anywhere);
        let error = error.expect_err(name).to_string();
        assert!(error.contains(words) && error.contains(name), "{error}");
        // The mesh itself, and the materials of one, which are left out.
        let mesh = path(name).with_extension("stl");
        std::os::unix::fs::symlink(path(name), &mesh).expect("a link");
        assert!(message(&mesh).contains(words), "{}", message(&mesh));
        let text = format!("mtllib {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        fs::write(path("a.obj"), text).expect("written");
        assert_eq!(read_mesh(path("a.obj")).expect(name).triangles.len(), 1);
    }
    let scene = path("zero.csg");
    std::os::unix::fs::symlink("/dev/zero", &scene).expect("a link");
    let error = io::scene::read_file(&scene, &io::scene::ReadOptions::default());
    let error = error.expect_err("refused").to_string();
    assert!(error.contains("it is a device"), "{error}");
}

#[test]
fn what_is_no_mesh_is_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let zeros = |length: usize| vec![0u8; length];
    let mut flat = zeros(84 + 50);
    flat[80] = 1;
    let garbage: Vec<u8> = (0..4000u32)
        .map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8)
        .collect();
    let mut cases: Vec<(&str, Vec<u8>)> = vec![
        ("obj", garbage.clone()),
        ("obj", b"Dear reader,\nthis is a letter.\n".to_vec()),
        ("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_vec()),
        ("stl", zeros(84)),
        ("stl", zeros(1000)),
        ("stl", flat),
        ("stl", b"solid\nendsolid\n".to_vec()),
        ("off", b"OFF\n0 0 0\n".to_vec()),
        ("gltf", b"{\"asset\": {\"version\": \"2.0\"}}".to_vec()),
        (
            "ply",
            b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n".to_vec(),
        ),
    ];
    for extension in ["glb", "gltf", "obj", "stl", "ply", "off"] {
        cases.push((extension, Vec::new()));
        cases.push((extension, garbage.clone()));
        cases.push((extension, zeros(100_000)));
    }
    for (extension, data) in cases {
        let path = folder.path().join("no-mesh").with_extension(extension);
        fs::write(&path, &data).expect("written");
        let error = message(&path);
        let start: Vec<_> = data.iter().take(20).collect();
        // The file, the place in it, and the problem.
        assert!(error.matches(": ").count() >= 2, "{start:?}: {error}");
        assert!(error.contains("no-mesh"), "{error}");
    }
}

/// A stream that takes so many bytes.
struct FullAfter(usize);

impl std::io::Write for FullAfter {
    fn write(&mut self, data: &[u8]) -> std::io::Result<usize> {
        if self.0 == 0 {
            return Err(std::io::ErrorKind::StorageFull.into());
        }
        let taken = data.len().min(self.0);
        self.0 -= taken;
        Ok(taken)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn an_archive_that_cannot_be_finished_is_an_error() {
    let mut whole = Vec::new();
    io::threemf::write_3mf(&small_box(), &mut whole).expect("written");
    for room in 0..whole.len() {
        let error = io::threemf::write_3mf(&small_box(), &mut FullAfter(room));
        let error = error.expect_err("no room").to_string();
        assert!(error.contains("no storage space"), "{room}: {error}");
    }
    io::threemf::write_3mf(&small_box(), &mut FullAfter(whole.len())).expect("room");
}
