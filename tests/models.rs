//! The scene files in `models/` are what the writer makes of the reference
//! scenes, and read back as the same solids.

use std::path::Path;

use crate::ROOT;
use stereotomy::csg::glam::dvec3;
use stereotomy::csg::{Program, Solid};
use stereotomy::io::scene::{ReadOptions, read_file, write};
use stereotomy::scenes;

fn models() -> [(&'static str, Solid); 8] {
    [
        ("sphere", scenes::sphere()),
        ("drilled", scenes::drilled()),
        ("tricylinder", scenes::tricylinder()),
        ("menger-2", scenes::menger(2)),
        ("menger-3", scenes::menger(3)),
        ("rotated-box", scenes::rotated_box()),
        ("shell", scenes::shell(0.1)),
        ("flange", scenes::flange()),
    ]
}

/// To write the files anew, run this test with STEREOTOMY_WRITE_MODELS=1.
#[test]
fn model_files_are_up_to_date() {
    let folder = Path::new(ROOT).join("models");
    let rewrite = std::env::var_os("STEREOTOMY_WRITE_MODELS").is_some();
    for (name, solid) in models() {
        let path = folder.join(name).with_extension("csg");
        let text = write(&solid).expect("expressible");
        if rewrite {
            std::fs::write(&path, &text).expect("written");
        }
        let file = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(
            file == text,
            "{} is stale: run this test with STEREOTOMY_WRITE_MODELS=1",
            path.display()
        );
    }
}

#[test]
fn model_files_hold_the_scenes() {
    let folder = Path::new(ROOT).join("models");
    for (name, solid) in models() {
        let path = folder.join(name).with_extension("csg");
        let read = read_file(&path, &ReadOptions::default()).expect("a scene");
        let (scene, file) = (Program::lower(&solid), Program::lower(&read.solid));
        let (scene, file) = (scene.expect("valid"), file.expect("valid"));
        assert_eq!(scene.surfaces().len(), file.surfaces().len(), "{name}");
        // A lattice without a point on any face.
        for i in 0..40_000u32 {
            let [x, y, z] = [0.754_877_67, 0.569_840_29, 0.362_437_47]
                .map(|step: f64| (f64::from(i) * step).fract() * 2.6 - 1.3);
            let point = dvec3(x, y, z);
            assert_eq!(
                scene.contains(point),
                file.contains(point),
                "{name} {point}"
            );
        }
    }
}
