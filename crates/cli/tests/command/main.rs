//! The `csg` command as a user runs it: a file for each subcommand.
#![allow(missing_docs, reason = "a test")]

mod compare;
mod drawing;
mod files;
mod measure;
mod merge;
mod mesh;
mod messages;
mod progress;
mod render;
mod section;
mod sweep;

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

const DRILLED: &str = "difference() {
\tintersection() { cube(size = [1.5, 1.5, 1.5], center = true); sphere(r = 1); }
\tcylinder(h = 4, r1 = 0.5, r2 = 0.5, center = true);
\tmultmatrix([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]) { cylinder(h = 4, r1 = 0.5, r2 = 0.5, center = true); }
\tmultmatrix([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]) { cylinder(h = 4, r1 = 0.5, r2 = 0.5, center = true); }
}
";
/// The exact volume of [`DRILLED`].
const DRILLED_VOLUME: f64 = 0.988_789_557_199_477;

/// A folder of its own with a scene in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        fs::write(folder.file("in.csg"), DRILLED).expect("a file");
        folder
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the command here, words separated by spaces.
    fn run(&self, arguments: &str) -> Output {
        self.run_with_input(arguments, "")
    }

    fn run_with_input(&self, arguments: &str, input: &str) -> Output {
        let mut child = Command::new(env!("CARGO_BIN_EXE_csg"))
            .args(arguments.split_whitespace())
            .current_dir(self.0.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command runs");
        let mut stdin = child.stdin.take().expect("its input");
        // A command that fails early does not read it.
        let _ = stdin.write_all(input.as_bytes());
        drop(stdin);
        child.wait_with_output().expect("the command ends")
    }

    /// Names of all files here but the scene, sorted.
    fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("a folder");
        let mut names: Vec<String> = entries
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .filter(|name| name != "in.csg")
            .collect();
        names.sort();
        names
    }
}

fn succeeded(output: &Output) -> &Output {
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    output
}

/// Asserts the exit code, and returns what was said.
fn failed(output: &Output, code: i32) -> String {
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{message}");
    message
}
