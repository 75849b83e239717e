//! Files are replaced whole or left alone.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::common::small_box;
use csg::Mesh;
use glam::DVec3;
use io::{AtomicFile, Error, MeshFormat, WriteOptions, read_mesh, write_mesh};

/// The names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

fn write(path: &Path, mesh: &Mesh) -> Result<(), Error> {
    write_mesh(path, mesh, &WriteOptions::default())
}

#[test]
fn every_format_is_written_and_read_by_its_extension() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = small_box();
    for format in MeshFormat::ALL {
        assert_eq!(
            MeshFormat::from_extension(&format.extension().to_uppercase()),
            Some(format)
        );
        let path = folder.path().join(format!("a part.{}", format.extension()));
        write(&path, &mesh).expect("written");
        let back = read_mesh(&path).expect("read");
        assert_eq!((back.volume(), back.area()), (6.0, 22.0), "{format}");
        assert!(back.check().is_manifold(), "{format}");
    }
    assert_eq!(
        names(folder.path()),
        [
            "3mf", "bin", "glb", "gltf", "mtl", "obj", "off", "ply", "stl"
        ]
        .map(|e| format!("a part.{e}"))
    );
}

#[test]
fn an_error_leaves_the_old_files_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let good = small_box();
    let vast = Mesh::new(
        vec![DVec3::ZERO, DVec3::X * 1e300, DVec3::Y],
        vec![[0, 1, 2]],
    );
    let mut broken = small_box();
    broken.triangles[0][0] = 77;
    for format in MeshFormat::ALL {
        write(
            &folder.path().join(format!("m.{}", format.extension())),
            &good,
        )
        .expect("written");
    }
    let before: Vec<_> = names(folder.path());
    let contents = |names: &[String]| -> Vec<Vec<u8>> {
        names
            .iter()
            .map(|n| fs::read(folder.path().join(n)).expect("a file"))
            .collect()
    };
    let old = contents(&before);
    for format in MeshFormat::ALL {
        let path = folder.path().join(format!("m.{}", format.extension()));
        for bad in [&broken, &Mesh::default()] {
            let error = write(&path, bad).expect_err("refused").to_string();
            assert!(error.contains(&*path.to_string_lossy()), "{error}");
        }
        if matches!(format, MeshFormat::Glb | MeshFormat::Gltf | MeshFormat::Stl) {
            write(&path, &vast).expect_err("refused");
        }
    }
    assert_eq!(names(folder.path()), before);
    assert_eq!(contents(&before), old);
}

#[test]
fn an_unfinished_file_vanishes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("data.txt");
    fs::write(&path, "old").expect("written");
    let mut file = AtomicFile::create(&path).expect("created");
    file.write_all(b"new and unfinished").expect("written");
    assert_eq!(fs::read_to_string(&path).expect("read"), "old");
    drop(file);
    assert_eq!(names(folder.path()), ["data.txt"]);
    let mut file = AtomicFile::create(&path).expect("created");
    file.write_all(b"new").expect("written");
    file.commit().expect("committed");
    assert_eq!(fs::read_to_string(&path).expect("read"), "new");
    assert_eq!(names(folder.path()), ["data.txt"]);
}

#[test]
fn a_pair_is_replaced_together_or_not_at_all() {
    let folder = tempfile::tempdir().expect("a folder");
    let [first, second, third] = ["1", "2", "3"].map(|name| folder.path().join(name));
    fs::write(&first, "old first").expect("written");
    let start = || {
        [&first, &second, &third].map(|path| {
            let mut file = AtomicFile::create(path).expect("created");
            file.write_all(b"new").expect("written");
            file
        })
    };
    let files = start();
    // Something that no file can replace appears at the last place.
    fs::create_dir(&third).expect("a folder");
    fs::write(third.join("inside"), "").expect("written");
    let error = AtomicFile::commit_all(files).expect_err("refused");
    assert!(error.to_string().contains("cannot replace"), "{error}");
    assert_eq!(fs::read_to_string(&first).expect("read"), "old first");
    assert_eq!(names(folder.path()), ["1", "3"]);
    fs::remove_dir_all(&third).expect("removed");
    AtomicFile::commit_all(start()).expect("committed");
    assert_eq!(names(folder.path()), ["1", "2", "3"]);
    assert_eq!(fs::read_to_string(&first).expect("read"), "new");
}

#[test]
fn errors_name_the_file_and_the_way_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let unknown = folder.path().join("part.step");
    let error = write(&unknown, &small_box())
        .expect_err("unknown")
        .to_string();
    assert!(
        error.contains("part.step") && error.contains(".glb, .gltf, .obj"),
        "{error}"
    );
    let nowhere = folder.path().join("no/such/folder/part.glb");
    let error = write(&nowhere, &small_box())
        .expect_err("no folder")
        .to_string();
    assert!(error.contains("no/such/folder"), "{error}");
    let missing = folder.path().join("missing.stl");
    let error = read_mesh(&missing).expect_err("missing").to_string();
    assert!(
        error.contains("cannot read") && error.contains("missing.stl"),
        "{error}"
    );
    let broken = folder.path().join("broken.obj");
    fs::write(&broken, "v 1 2\n").expect("written");
    let error = read_mesh(&broken).expect_err("broken").to_string();
    assert!(
        error.ends_with("broken.obj: line 1: v needs three finite numbers"),
        "{error}"
    );
    assert!(names(folder.path()).len() == 1);
}

#[cfg(unix)]
#[test]
fn links_permissions_and_devices_are_respected() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().expect("a folder");
    let real = folder.path().join("real");
    let link = folder.path().join("link");
    let put = |path: &Path| {
        let mut file = AtomicFile::create(path)?;
        file.write_all(b"data")?;
        file.commit()
    };
    put(&real).expect("written");
    let mode = |path: &Path| fs::metadata(path).expect("a file").permissions().mode() & 0o777;
    let plain = folder.path().join("plain");
    fs::write(&plain, "").expect("written");
    assert_eq!(mode(&real), mode(&plain), "as any new file");
    fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).expect("set");
    symlink(&real, &link).expect("a link");
    put(&link).expect("written");
    assert!(fs::symlink_metadata(&link).expect("a link").is_symlink());
    assert_eq!(mode(&real), 0o640);
    assert_eq!(names(folder.path()), ["link", "plain", "real"]);
    put(Path::new("/dev/null")).expect("written");
    // A device that is always full.
    #[cfg(target_os = "linux")]
    {
        let error = put(Path::new("/dev/full")).expect_err("full");
        assert!(matches!(error, Error::Write(_)), "{error}");
    }
}

#[test]
fn a_file_that_does_not_wait_for_the_disk_is_whole_as_well() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("picture");
    fs::write(&path, "old").expect("written");
    let mut file = AtomicFile::create(&path).expect("created").without_flush();
    file.write_all(b"new").expect("written");
    assert_eq!(fs::read(&path).expect("read"), b"old");
    file.commit().expect("replaced");
    assert_eq!(fs::read(&path).expect("read"), b"new");
    assert_eq!(names(folder.path()), ["picture"]);
}

#[test]
fn meshes_to_be_drawn_look_the_same_and_need_not_be_connected() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("box.glb");
    let mut mesh = small_box();
    let corners =
        |mesh: &Mesh| -> Vec<_> { (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect() };
    for (with_normals, vertices) in [(true, 24), (false, 8)] {
        if !with_normals {
            mesh.corner_normals.clear();
        }
        write(&path, &mesh).expect("written");
        let (welded, apart) = (
            read_mesh(&path).expect("read"),
            io::read_mesh_with(&path, &io::ReadOptions::default().to_draw(true)).expect("read"),
        );
        assert_eq!(welded.positions.len(), 8);
        assert_eq!(apart.positions.len(), vertices);
        assert_eq!(corners(&apart), corners(&welded));
        assert_eq!(apart.corner_normals, welded.corner_normals);
        assert_eq!(apart.triangle_surfaces, welded.triangle_surfaces);
    }
}
