//! What comes out: mesh and STEP files, pictures and JSON, `-` being standard output.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use csg::{Brep, LengthUnit, Mesh};
use io::step::{StepOptions, StepSchema};
use io::{AtomicFile, MeshFormat, WriteOptions};

use crate::failure::{Failure, exit_codes};

const STANDARD_OUTPUT: &str = "standard output";

/// Formats that fit into one stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum StreamFormat {
    /// glTF 2.0, binary
    #[default]
    Glb,
    /// Wavefront OBJ without materials
    Obj,
    /// Stereolithography, binary
    Stl,
    /// Stanford polygons, binary
    Ply,
}

/// How STEP files are written.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct StepArguments {
    /// Which part of the standard .step files follow: AP242, or AP214 for older programs
    #[arg(long, value_enum, default_value_t)]
    step_schema: Schema,
}

/// Parts of the standard for STEP.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Schema {
    #[default]
    Ap242,
    Ap214,
}

/// Whether a file argument means standard output.
pub(crate) fn is_stream(path: &Path) -> bool {
    path.as_os_str() == OsStr::new("-")
}

/// Refuses outputs that would come out mixed, or in no known format, before
/// any work is done for them.
pub(crate) fn check(meshes: &[PathBuf], json: Option<&Path>) -> Result<(), Failure> {
    check_streams(meshes, json)?;
    meshes.iter().try_for_each(|path| check_format(path))?;
    check_folders(meshes.iter().map(PathBuf::as_path).chain(json))
}

/// Refuses an output that is neither a mesh nor STEP.
pub(crate) fn check_format(path: &Path) -> Result<(), Failure> {
    if is_stream(path) || io::step::is_step(path) {
        return Ok(());
    }
    let format = MeshFormat::from_path(path);
    format
        .map_err(|error| Failure::new(exit_codes::USAGE, "no such mesh format", error))
        .map(|_| ())
}

/// Refuses outputs that would come out mixed.
pub(crate) fn check_streams(outputs: &[PathBuf], json: Option<&Path>) -> Result<(), Failure> {
    let streams = outputs.iter().filter(|path| is_stream(path)).count()
        + usize::from(json.is_some_and(is_stream));
    if streams > 1 {
        let context = "two outputs on standard output";
        let cause = "they would come out mixed: send all but one to files";
        return Err(Failure::new(exit_codes::USAGE, context, cause));
    }
    Ok(())
}

/// Refuses outputs in folders that are not there, before any work is done, and any file written.
pub(crate) fn check_folders<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), Failure> {
    const HINT: &str = "nothing was written: make the folder, or name a file in another one";
    for path in outputs.into_iter().filter(|path| !is_stream(path)) {
        let Some(folder) = path.parent().filter(|folder| *folder != Path::new("")) else {
            continue;
        };
        let name = path.display().to_string();
        let about = std::fs::metadata(folder);
        let about = about.map_err(|error| Failure::output(&name, error).hint(HINT))?;
        if !about.is_dir() {
            let cause = format!("{} is a file, not a folder", folder.display());
            return Err(Failure::output(&name, cause).hint(HINT));
        }
    }
    Ok(())
}

/// Whether a file that is to be written is one that is there: by the same name, or another one
/// that leads to it.
pub(crate) fn is_same_file(output: &Path, input: &Path) -> bool {
    let found = [output, input].map(|path| path.canonicalize().ok());
    !is_stream(output) && found[0].is_some() && found[0] == found[1]
}

/// Writes the mesh to a file by its extension, or to standard output.
pub(crate) fn write_mesh(
    path: &Path,
    mesh: &Mesh,
    stream: StreamFormat,
    options: &WriteOptions,
) -> Result<(), Failure> {
    if !is_stream(path) {
        return io::write_mesh(path, mesh, options)
            .map_err(|error| Failure::output(&path.display().to_string(), error));
    }
    let mut bytes = Vec::new();
    match stream {
        StreamFormat::Glb => io::gltf::write_glb_with(mesh, options, &mut bytes),
        StreamFormat::Obj => io::obj::write_obj(mesh, None, &mut bytes),
        StreamFormat::Stl => io::stl::write_stl(mesh, &mut bytes),
        StreamFormat::Ply => io::ply::write_ply_with(mesh, options, &mut bytes),
    }
    .map_err(|error| Failure::output(STANDARD_OUTPUT, error))?;
    print(&bytes)
}

/// Writes an exact boundary that was cut at seams to a STEP file; the product's name is the file's.
pub(crate) fn write_step(
    path: &Path,
    brep: &Brep,
    unit: LengthUnit,
    arguments: StepArguments,
) -> Result<(), Failure> {
    let schema = match arguments.step_schema {
        Schema::Ap242 => StepSchema::Ap242,
        Schema::Ap214 => StepSchema::Ap214,
    };
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let options = StepOptions::default().name(name).unit(unit).schema(schema);
    io::step::write_step_file(path, brep, &options)
        .map_err(|error| Failure::output(&path.display().to_string(), error))
}

/// Writes bytes to a file, whole or not at all, or to standard output.
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_file(path, bytes, |file| file)
}

/// [`write_bytes`] for a picture, which is not worth waiting for the disk.
pub(crate) fn write_picture(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_file(path, bytes, AtomicFile::without_flush)
}

fn write_file(
    path: &Path,
    bytes: &[u8],
    kind: impl FnOnce(AtomicFile) -> AtomicFile,
) -> Result<(), Failure> {
    if is_stream(path) {
        return print(bytes);
    }
    let name = path.display().to_string();
    let file = AtomicFile::create(path).map_err(|error| Failure::output(&name, error))?;
    let mut file = kind(file);
    file.write_all(bytes)
        .map_err(|error| Failure::output(&name, error))?;
    file.commit().map_err(|error| Failure::output(&name, error))
}

/// Writes a value as JSON.
pub(crate) fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_vec_pretty(value)
        .map_err(|error| Failure::output(&path.display().to_string(), error))?;
    text.push(b'\n');
    write_bytes(path, &text)
}

/// Writes to standard output; a reader that has gone away is an error, not a
/// panic.
pub(crate) fn print(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    out.write_all(bytes)
        .and_then(|()| out.flush())
        .map_err(|error| Failure::output(STANDARD_OUTPUT, error))
}
