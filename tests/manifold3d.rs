//! The same solids by manifold3d, an independent program: volumes agree, and
//! it accepts every mesh that our own check calls manifold.

mod script;
mod solids;

#[path = "../crates/csg/tests/regions/meshes.rs"]
mod meshes;

use std::path::Path;

use self::script::Script;
use self::solids::Random;
use crate::environment::python;
use crate::sweeps::one_in;
use stereotomy::csg::glam::{DQuat, DVec3};
use stereotomy::csg::{Meshed, Mesher, Program, Solid};
use stereotomy::scenes;

/// Segments of manifold3d's circles.
const SEGMENTS: u32 = 96;

fn start() -> Script {
    let required = include_str!("manifold3d/requirements.txt");
    Script::start(&python("manifold3d", required))
}

/// Meshes a solid at three resolutions: the finest mesh, and the spread of
/// the volumes, which estimates its error. An error that falls with the cells
/// leaves the coarser ones that much farther off.
fn mesh(solid: &Solid) -> (Meshed, f64) {
    let program = Program::lower(solid).expect("a valid solid");
    let mesh = |cells| Mesher::new().cells(cells).mesh(&program).expect("a mesh");
    let (coarse, middle, fine) = (mesh(24), mesh(34), mesh(60));
    let volumes = [&coarse, &middle, &fine].map(|meshed| meshed.mesh.volume());
    let spread = volumes
        .iter()
        .fold(0.0f64, |m, v| m.max((v - volumes[2]).abs()));
    (fine, spread)
}

/// Compares one solid; returns whether its mesh was manifold.
fn compare(script: &mut Script, folder: &Path, name: &str, solid: &Solid) -> bool {
    let (their_volume, tessellation) = script.volume(solid, SEGMENTS);
    let (Meshed { mesh, report, .. }, spread) = mesh(solid);
    let volume = mesh.volume();
    let tolerance = tessellation + spread + 1e-9;
    assert!(
        (volume - their_volume).abs() <= tolerance,
        "{name}: {volume}, by manifold3d {their_volume} ± {tessellation}, spread {spread}: {solid:?}"
    );
    assert!(report.check.is_closed(), "{name}: {}", report.check);
    if !report.check.is_manifold() || mesh.triangles.is_empty() {
        return false;
    }
    let (status, found) = script.status(&mesh, folder);
    assert_eq!(status, "NoError", "{name}: {solid:?}");
    // It reads the mesh as we do, but for the degenerate triangles that it
    // collapses.
    assert!(
        (found - their_volume).abs() <= tolerance,
        "{name}: {found}, of our mesh {volume}, by manifold3d {their_volume}: {solid:?}"
    );
    true
}

#[test]
fn random_trees_agree() {
    let mut script = start();
    let folder = tempfile::tempdir().expect("a folder");
    let mut manifold = 0;
    let mut not_empty = 0;
    let step = one_in(5);
    for seed in (0..120).step_by(step) {
        let solid = Random::new(seed).solid(2 + seed % 8);
        let name = format!("tree {seed}");
        manifold += usize::from(compare(&mut script, folder.path(), &name, &solid));
        not_empty += usize::from(
            Program::lower(&solid)
                .expect("valid")
                .bounds()
                .expect("bounded")
                .is_some(),
        );
    }
    // Otherwise little was compared.
    assert!(
        not_empty * step >= 100 && manifold * step >= 75,
        "{not_empty} solids, {manifold} manifold"
    );
}

#[test]
fn reference_scenes_agree() {
    let mut script = start();
    let folder = tempfile::tempdir().expect("a folder");
    for (name, solid) in [
        ("sphere", scenes::sphere()),
        ("drilled", scenes::drilled()),
        ("tricylinder", scenes::tricylinder()),
        ("menger 2", scenes::menger(2)),
        ("cheese 100", scenes::cheese(100)),
        ("rotated box", scenes::rotated_box()),
        ("shell", scenes::shell(0.1)),
        ("flange", scenes::flange()),
    ] {
        assert!(
            compare(&mut script, folder.path(), name, &solid),
            "{name} is not manifold"
        );
    }
}

/// Meshes of thousands of triangles, as files bring them, with each other and with boxes:
/// both programs cut them exactly.
#[test]
fn imported_meshes_agree() {
    let mut script = start();
    let folder = tempfile::tempdir().expect("a folder");
    let bumps = |phase: f64| {
        move |d: DVec3| 1.0 + 0.1 * (5.0 * d.x + phase).sin() * (4.0 * d.y - phase).cos()
    };
    let files = [
        meshes::ball(4, 1.0),
        meshes::star(4, bumps(0.3)),
        meshes::star(3, bumps(1.7)),
        meshes::rounded_cube(16, DQuat::from_rotation_x(0.4)),
    ];
    let solids = files.map(|mesh| Solid::from_mesh(&mesh).expect("a solid"));
    let cube = Solid::cuboid_between([0.1, 0.2, 0.3], [2.0, 2.0, 2.0]);
    let pairs = (0..4).flat_map(|a| (a + 1..4).map(move |b| (a, b)));
    let pairs = pairs.map(|(a, b)| (&solids[a], solids[b].translate([0.2, 0.1, 0.05])));
    let cut = solids.iter().map(|solid| (solid, cube.clone()));
    let combined = pairs.chain(cut).flat_map(|(a, b)| [a | &b, a & &b, a - &b]);
    for (number, solid) in combined.enumerate().step_by(one_in(4)) {
        let (theirs, _) = script.volume(&solid, SEGMENTS);
        let program = Program::lower(&solid).expect("a valid solid");
        let Meshed { mesh, report, .. } = Mesher::new().mesh(&program).expect("a mesh");
        assert_eq!(report.fallbacks, [], "{number}");
        assert!(report.check.is_manifold(), "{number}: {}", report.check);
        let off = mesh.volume() - theirs;
        assert!(off.abs() <= 1e-9, "{number}: {off}");
        let (status, found) = script.status(&mesh, folder.path());
        assert_eq!(status, "NoError", "{number}");
        assert!((found - theirs).abs() <= 1e-9, "{number}");
    }
}
