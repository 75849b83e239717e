//! Limits of memory hold for what is really allocated.
#![allow(missing_docs, reason = "a test")]

use csg::{Limits, Mesher, Program, Solid};
use peak_alloc::PeakAlloc;
use stereotomy::{csg, scenes};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// One test, for peaks are those of the whole process.
#[test]
fn the_estimate_is_within_a_factor_of_two() {
    let ways: [(&str, Solid, Mesher); 8] = [
        ("uniform", scenes::drilled(), Mesher::new().cells(100)),
        (
            "uniform planes",
            scenes::menger(3),
            Mesher::new().cells(100),
        ),
        (
            "uniform to a tolerance",
            scenes::sphere(),
            Mesher::new().cells(50).tolerance(1e-4),
        ),
        (
            "adaptive",
            scenes::cheese(40),
            Mesher::new().smallest_feature(4e-3),
        ),
        (
            "to a tolerance",
            scenes::sphere(),
            Mesher::new().tolerance(1e-4),
        ),
        (
            "curves to a tolerance",
            scenes::flange(),
            Mesher::new().tolerance(1e-6),
        ),
        ("planes", scenes::menger(3), Mesher::new()),
        ("draft", scenes::drilled(), Mesher::new().cells(100).draft()),
    ];
    for (name, solid, mesher) in ways {
        let program = Program::lower(&solid).expect("a valid solid");
        let mesh = |mesher: &Mesher| mesher.mesh(&program).map(|meshed| meshed.mesh);
        for mesher in [mesher.clone().check(false), mesher.normals()] {
            // Scratch memory stays from run to run.
            mesh(&mesher).expect("a mesh");
            let before = ALLOCATOR.current_usage();
            ALLOCATOR.reset_peak_usage();
            mesh(&mesher).expect("a mesh");
            let peak = (ALLOCATOR.peak_usage() - before) as u64;
            let limited = |most| mesh(&mesher.clone().limits(Limits::new().memory(most)));
            assert!(limited(2 * peak).is_ok(), "{name}: {peak}");
            let reached = limited(peak / 2);
            let is_reached = matches!(reached, Err(csg::Error::LimitReached(_)));
            assert!(is_reached, "{name}: {peak}");
        }
    }
}
