//! What makes and tests the page, installed by npm once, under the target folder.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A copy of the page's sources, with the packages that make and test it.
pub fn installed() -> PathBuf {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../view/web");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view");
    fs::create_dir_all(&folder).expect("a folder under target/");
    let lock = File::create(folder.join("lock")).expect("a lock file");
    lock.lock().expect("the lock");
    for name in ["package.json", "package-lock.json", "build.js"] {
        fs::copy(sources.join(name), folder.join(name)).expect("a file that can be copied");
    }
    for name in ["src", "tests"] {
        let copy = folder.join(name);
        if copy.exists() {
            fs::remove_dir_all(&copy).expect("a folder that can be removed");
        }
        fs::create_dir(&copy).expect("a folder");
        for file in fs::read_dir(sources.join(name)).expect("a folder of sources") {
            let file = file.expect("a file");
            fs::copy(file.path(), copy.join(file.file_name())).expect("a copy");
        }
    }
    let wanted = fs::read(folder.join("package-lock.json")).expect("a lock file");
    let stamp = folder.join("installed");
    if fs::read(&stamp).is_ok_and(|found| found == wanted) {
        return folder;
    }
    let npm = if cfg!(windows) { "npm.cmd" } else { "npm" };
    run(Command::new(npm)
        .args([
            "ci",
            "--no-audit",
            "--no-fund",
            "--ignore-scripts",
            "--loglevel=error",
        ])
        .current_dir(&folder));
    fs::write(stamp, wanted).expect("a stamp");
    folder
}

/// Runs a command that must not fail.
pub fn run(command: &mut Command) {
    let status = command.status().unwrap_or_else(|error| {
        panic!("{command:?} does not run ({error}): it needs Node.js 20 with npm")
    });
    assert!(status.success(), "{command:?} failed: see its words above");
}
