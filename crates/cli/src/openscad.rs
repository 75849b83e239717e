//! OpenSCAD models, evaluated by the `openscad` that is installed.

use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::failure::Failure;

/// The evaluated tree of a model, its variables set as in `name=value`. What OpenSCAD
/// has to say goes to standard error.
pub(crate) fn evaluated(path: &Path, define: &[String]) -> Result<Vec<u8>, Failure> {
    let name = path.display().to_string();
    let mut command = Command::new("openscad");
    for definition in define {
        command.arg("-D").arg(definition);
    }
    // (Its name must not be taken for an option.)
    let path = if path.is_absolute() {
        path.to_owned()
    } else {
        Path::new(".").join(path)
    };
    let output = command
        .args(["--export-format", "csg", "-o", "-"])
        .arg(path)
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| {
            let hint = "OpenSCAD models are evaluated by the `openscad` command: install it \
                        (Debian: apt install openscad), or name a .csg scene";
            match error.kind() {
                ErrorKind::NotFound => Failure::input(&name, "`openscad` is not installed"),
                _ => Failure::input(&name, format!("`openscad` does not run: {error}")),
            }
            .hint(hint)
        })?;
    if output.status.success() {
        Ok(output.stdout)
    } else {
        let problem = format!("openscad could not evaluate it ({})", output.status);
        Err(Failure::input(&name, problem))
    }
}
