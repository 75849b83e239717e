//! The boundaries of all models that once broke a mesher.

use std::fs;
use std::path::{Path, PathBuf};

use csg::{Mesher, Program};
use rayon::prelude::*;
use stereotomy::io::scene::{ReadOptions, read_file};
use stereotomy::{csg, io};

use crate::ROOT;

use super::boundary;
use super::sound::assert_sound;

/// They have the volumes of meshes that are proven, to a hundredth of a percent of the box or as
/// far as surfaces were moved.
#[test]
fn hard_models_have_boundaries() {
    let folder = Path::new(ROOT).join("models/hard");
    let files = fs::read_dir(folder).expect("the folder");
    let files: Vec<PathBuf> = files.map(|file| file.expect("a file").path()).collect();
    let found: Vec<String> = files.par_iter().filter_map(fault).collect();
    assert!(files.len() > 60, "{}", files.len());
    assert!(found.is_empty(), "{found:#?}");
}

fn fault(file: &PathBuf) -> Option<String> {
    let name = file.display().to_string();
    let scene: io::scene::Scene = read_file(file, &ReadOptions::default()).expect("a scene");
    let brep = match boundary(&scene.solid) {
        Ok(brep) => brep,
        Err(error) => return Some(format!("{name}: {error}")),
    };
    let program = Program::lower(&scene.solid).expect("valid");
    if brep.moved().is_none() {
        assert_sound(&brep, &program, &name);
    }
    let measure = brep.measure();
    let size = brep.bounds().map_or(0.0, |bounds| bounds.size().length());
    let meshed = Mesher::new()
        .tolerance(1e-2 * size)
        .mesh(&program)
        .expect("a mesh");
    let deviation = meshed
        .report
        .deviation
        .filter(|d| d.is_finite())
        .unwrap_or(1e-2 * size);
    let most = 2.0 * deviation * measure.area.upper() + measure.volume.error;
    let off = (meshed.mesh.volume() - measure.volume.value).abs();
    let is_right = off <= most && measure.volume.error <= 1e-4 * size.powi(3);
    (!is_right).then(|| format!("{name}: {:?} off {off} of {most}", measure.volume))
}
