//! The Python package as its users have it: built by maturin, installed by pip, tested by
//! pytest. What maturin packs is what these tests were compiled with; with STEREOTOMY_WHEEL=alone
//! it compiles the package by itself.
//!
//! They take longest and mostly wait: so the first test of all only begins them, on a thread of
//! their own beside the other tests, and the last one waits for them.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::thread::{JoinHandle, spawn};

use crate::{ROOT, environment};

/// What [`begin`] began.
static BEGUN: Mutex<Option<JoinHandle<()>>> = Mutex::new(None);

/// Begins the package's tests, unless they were begun.
pub fn begin() {
    let mut begun = BEGUN.lock().expect("no other test fails at it");
    begun.get_or_insert_with(|| spawn(the_package_passes_its_tests));
}

/// Waits for them, whichever test was called first.
pub fn end() {
    begin();
    let begun = BEGUN.lock().expect("no other test fails at it").take();
    let passed = begun.expect("they were begun").join();
    passed.expect("the package passes its tests: see the words above");
}

fn run(command: &mut Command) {
    let status = command
        .status()
        .unwrap_or_else(|error| panic!("{command:?} does not run: {error}"));
    assert!(
        status.success(),
        "{command:?} failed ({status}): see its words above"
    );
}

fn the_package_passes_its_tests() {
    let requirements = include_str!("../crates/python/tests/requirements.txt");
    let python = environment::python("python", requirements);
    let root = Path::new(ROOT);
    let package = root.join("crates/python");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python");
    let wheels = folder.join("wheels");
    // None of an older version may be left.
    if wheels.exists() {
        fs::remove_dir_all(&wheels).expect("a folder that can be removed");
    }
    // By the profile that the other tests have: a release takes minutes.
    let mut maturin = Command::new(&python);
    maturin.args(["-m", "maturin", "build", "--quiet", "--profile", "dev"]);
    let is_alone = std::env::var_os("STEREOTOMY_WHEEL").is_some_and(|text| text == "alone");
    if !is_alone {
        maturin
            .env("CARGO", root.join("tests/python/cargo"))
            .env("STEREOTOMY_CARGO", env!("CARGO"))
            .env("STEREOTOMY_ROOT", root);
    }
    run(maturin
        .arg("--interpreter")
        .arg(&python)
        .arg("--manifest-path")
        .arg(package.join("Cargo.toml"))
        .arg("--out")
        .arg(&wheels));
    let wheel = fs::read_dir(&wheels)
        .expect("a folder of wheels")
        .next()
        .expect("a wheel")
        .expect("its name")
        .path();
    run(environment::pip_install(&python)
        .args(["--no-deps", "--force-reinstall"])
        .arg(wheel));
    run(Command::new(&python)
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
        .arg(package.join("tests"))
        .current_dir(&package)
        // Nothing is left in the source tree.
        .env_remove("PYTHONDONTWRITEBYTECODE")
        .env("PYTHONPYCACHEPREFIX", folder.join("compiled"))
        .env("MYPY_CACHE_DIR", folder.join("mypy")));
}
