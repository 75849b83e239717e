//! Shards: what is put together of them, and that no damage goes unnoticed.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use csg::{CancelToken, Color, Merger, Mesher, Program, Slab, SlabSource, Solid};
use io::shard::{Reading, ShardFile, write_merged, write_merged_by, write_shard_file};
use io::{Error, MeshFormat, WriteOptions, gltf, write_mesh};

fn folder(shards: u32, cells: u32) -> (tempfile::TempDir, Vec<PathBuf>, csg::Mesh) {
    let folder = tempfile::tempdir().expect("a folder");
    let ball = Solid::sphere(1.1).colored(Color::from_srgb([1.0, 0.2, 0.0]));
    let solid = (Solid::cube(2.0).named("block") - ball) | Solid::cylinder(0.2, -1.0..1.3);
    let program = Program::lower(&solid.translate([5.0, 0.0, 0.0])).expect("a valid solid");
    let mesher = Mesher::new().cells(cells).normals();
    let write = |part| {
        let path = folder.path().join(format!("part-{part}.shard"));
        let slab = mesher.slab(&program, part, shards).expect("a slab");
        write_shard_file(&path, &slab).expect("written");
        path
    };
    let paths = (0..shards).map(write).collect();
    let mesh = mesher.mesh(&program).expect("a mesh").mesh;
    (folder, paths, mesh)
}

fn merger(paths: &[PathBuf]) -> Result<Merger<ShardFile>, Error> {
    let shards = paths.iter().map(ShardFile::open);
    Ok(Merger::new(shards.collect::<Result<_, _>>()?)?)
}

#[test]
fn shards_give_the_files_of_the_whole() {
    for shards in [1, 3, 40] {
        let (folder, paths, mesh) = folder(shards, 50);
        let merger = merger(&paths).expect("shards of one mesh");
        for format in MeshFormat::ALL {
            let whole = folder
                .path()
                .join("whole")
                .with_extension(format.extension());
            // (Files name those beside them.)
            write_mesh(&whole, &mesh, &WriteOptions::default()).expect("written");
            let expected = fs::read(&whole).expect("a file");
            fs::remove_file(&whole).expect("removed");
            write_merged(&whole, &merger).expect("merged");
            let merged = fs::read(&whole).expect("a file");
            assert!(merged == expected, "{format} of {shards}");
        }
    }
}

#[test]
fn chunks_are_the_same_for_any_number_of_shards() {
    let glb = |shards: u32, chunks: usize| {
        let (folder, paths, mesh) = folder(shards, 50);
        let merger = merger(&paths).expect("shards of one mesh");
        let path = folder.path().join("a.glb");
        let chunk = mesh.triangles.len() / 5 + 1;
        let names = write_merged_by(&path, &merger, (chunk, chunks)).expect("written");
        let files = names.iter().map(|name| fs::read(name).expect("a file"));
        let files: Vec<Vec<u8>> = files.collect();
        // Nothing is left that was on the way.
        let all = fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(all, paths.len() + names.len());
        (files, mesh)
    };
    for (chunks, files) in [(64, 1), (2, 3), (5, 1)] {
        let (whole, mesh) = glb(1, chunks);
        assert_eq!(whole.len(), files);
        for shards in [3, 40] {
            assert!(glb(shards, chunks).0 == whole, "{shards} shards");
        }
        // The triangles of the whole, in single precision.
        let read = whole.iter().map(|file| gltf::read_glb(file).expect("GLB"));
        let read: Vec<csg::Mesh> = read.collect();
        let count: usize = read.iter().map(|mesh| mesh.triangles.len()).sum();
        assert_eq!(count, mesh.triangles.len());
        // (About one point, as the files' meshes are not closed.)
        let cones = |mesh: &csg::Mesh| -> f64 {
            let corners = (0..mesh.triangles.len()).map(|t| mesh.corners(t));
            corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
        };
        let volume: f64 = read.iter().map(cones).sum();
        assert!((volume - cones(&mesh)).abs() < 1e-5, "{volume}");
        let colors = read.iter().flat_map(|mesh| &mesh.surfaces);
        assert!(colors.clone().any(|surface| surface.color.is_some()));
    }
}

#[test]
fn reading_is_followed_and_stopped() {
    let (folder, paths, _) = folder(3, 20);
    let token = CancelToken::new();
    let most = Arc::new(AtomicU64::new(0));
    let seen = Arc::clone(&most);
    let reading = Reading::new()
        .cancel_token(token.clone())
        .progress(move |bytes| seen.store(bytes, Ordering::Relaxed));
    let shards = paths.iter().map(ShardFile::open);
    let shards = shards.map(|shard| shard.expect("a shard").followed(&reading));
    let shards: Vec<ShardFile> = shards.collect();
    let length: u64 = shards.iter().map(ShardFile::length).sum();
    let merger = Merger::new(shards).expect("shards of one mesh");
    let before = reading.bytes();
    for format in ["ply", "stl"] {
        let path = folder.path().join("a").with_extension(format);
        let before = reading.bytes();
        write_merged(path, &merger).expect("written");
        assert_eq!(reading.bytes(), most.load(Ordering::Relaxed));
        let share = (reading.bytes() - before) as f64 / length as f64;
        assert!((0.8..=1.2).contains(&share), "{format}: {share}");
    }
    assert!(before < length);
    token.cancel();
    let stopped = write_merged(folder.path().join("b.ply"), &merger).expect_err("cancelled");
    assert!(
        matches!(stopped, Error::Slab(csg::Error::Cancelled)),
        "{stopped}"
    );
    assert!(!folder.path().join("b.ply").exists());
}

#[test]
fn a_slab_is_what_was_written() {
    let program = Program::lower(&Solid::sphere(1.0)).expect("a sphere");
    let slab = Mesher::new()
        .cells(20)
        .slab(&program, 1, 3)
        .expect("a slab");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.shard");
    write_shard_file(&path, &slab).expect("written");
    let file = ShardFile::open(&path).expect("a shard");
    let read = Slab {
        head: file.head().clone(),
        body: file.body().expect("its body").into_owned(),
        positions: file.positions().expect("vertices").into_owned(),
        triangles: file.triangles().expect("triangles").into_owned(),
    };
    assert!(read == slab && !slab.triangles.is_empty());
}

#[test]
fn every_damage_is_told_with_the_files_name() {
    let (_folder, paths, _) = folder(3, 12);
    let sound = fs::read(&paths[1]).expect("a file");
    let problem = |bytes: &[u8]| {
        fs::write(&paths[1], bytes).expect("written");
        let out = paths[1].with_extension("ply");
        let made = merger(&paths).and_then(|merger| write_merged(&out, &merger));
        assert!(made.is_ok() || !out.exists(), "half a file");
        let problem = made
            .err()
            .map_or_else(String::new, |error| error.to_string());
        let name = paths[1].display().to_string();
        assert!(
            problem.is_empty() || problem.starts_with(&name),
            "{problem}"
        );
        problem
    };
    for end in (0..sound.len()).step_by(7) {
        assert!(problem(&sound[..end]).contains("it "), "cut off at {end}");
    }
    for at in 0..sound.len() {
        let mut changed = sound.clone();
        changed[at] ^= 0x10;
        assert!(!problem(&changed).is_empty(), "changed at {at}");
    }
    let longer = [&*sound, b"\n"].concat();
    assert!(problem(&longer).contains("changed"));
    assert!(problem(b"ply\n").contains("no shard"));
    let mut newer = sound.clone();
    newer[8] = 2;
    assert!(problem(&newer).contains("version 2"));
    assert_eq!(problem(&sound), "");
}

#[test]
fn shards_of_two_meshes_are_not_mixed() {
    let (_one, mut paths, _) = folder(3, 12);
    let (_other, others, _) = folder(3, 13);
    paths[2].clone_from(&others[2]);
    let problem = merger(&paths).expect_err("two meshes").to_string();
    let told = format!(
        "{}: it is of another mesh than {}",
        paths[2].display(),
        paths[0].display()
    );
    assert!(problem.starts_with(&told), "{problem}");
    paths[2] = PathBuf::from("missing.shard");
    let problem = merger(&paths).expect_err("a missing file").to_string();
    assert!(problem.starts_with("missing.shard: "), "{problem}");
}
