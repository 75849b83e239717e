//! Python in a virtual environment of its own.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The Python of an environment of that name with exactly the required packages,
/// made under `target/` if it is not there yet. Several processes may ask at once.
pub fn python(name: &str, requirements: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).expect("a folder under target/");
    let lock = File::create(folder.join("lock")).expect("a lock file");
    lock.lock().expect("the lock");
    let environment = folder.join("venv");
    let stamp = environment.join("requirements.txt");
    let python = environment.join("bin/python");
    // Written last, so that an environment with the stamp is whole.
    if fs::read_to_string(&stamp).is_ok_and(|found| found == requirements) {
        return python;
    }
    let mut make = Command::new("python3");
    make.args(["-m", "venv", "--clear"]);
    if requirements.is_empty() {
        run(make.arg(&environment));
    } else {
        // (To put pip there takes longer than most installations.)
        run(make.arg("--without-pip").arg(&environment));
        let required = folder.join("requirements.txt");
        fs::write(&required, requirements).expect("a file");
        run(pip_install(&python).arg("-r").arg(&required));
    }
    fs::write(&stamp, requirements).expect("a file");
    python
}

/// The beginning of a command that installs what follows for a Python that `python` gave: with
/// the pip of an environment that has nothing else.
pub fn pip_install(into: &Path) -> Command {
    let mut command = Command::new(python("pip", ""));
    command.args(["-m", "pip", "--python"]).arg(into);
    command.args(["install", "--quiet", "--disable-pip-version-check"]);
    // Most modules are never loaded; to compile all takes longer than to unpack them.
    command.arg("--no-compile");
    command
}

fn run(command: &mut Command) {
    let output = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?} does not run ({error}): install Python 3"));
    assert!(
        output.status.success(),
        "{command:?} failed; it needs Python's venv module (Debian: python3-venv) and a package index:\n{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
}
