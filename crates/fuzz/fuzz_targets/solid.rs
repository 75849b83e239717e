#![no_main]
//! Solids that scenes describe, meshed and measured.

use std::time::Duration;

use csg::{BoundaryOptions, Limits, Mesher, Program};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Ok(scene) = io::scene::read_bytes(data, &io::scene::ReadOptions::default()) else {
        return;
    };
    let Ok(program) = Program::lower(&scene.solid) else {
        return;
    };
    let limits = Limits::new().triangles(100_000).time(Duration::from_secs(5));
    if let Ok(made) = Mesher::new().tolerance(0.05).limits(limits).mesh(&program) {
        assert!(made.mesh.check().is_manifold());
    }
    if data.len() < 1000
        && let Ok(brep) = program.boundary(&BoundaryOptions::new())
    {
        let _ = brep.measure();
    }
});
