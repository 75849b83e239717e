//! `mesh`: write mesh files, and STEP.

use std::path::PathBuf;

use super::account::Account;
use crate::failure::Failure;
use crate::input::Subject;
use crate::mesher::{MesherOptions, no_needs, produce};
use crate::output::{self, StreamFormat, is_stream};
use crate::progress::Progress;

/// Options of `mesh`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Where to write: a mesh (.glb .gltf .obj .stl .ply .off .3mf), or the solid with
    /// its exact surfaces, for CAD systems (.step .stp), by extension; or `-` for a mesh
    /// on standard output; may be given more than once
    #[arg(short, long = "output", value_name = "OUT", required = true)]
    outputs: Vec<PathBuf>,
    /// The format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: StreamFormat,
    #[command(flatten)]
    mesher: MesherOptions,
    /// Write measures, checks, times and the mesher's report as JSON; `-`
    /// writes to standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

pub(crate) fn run(
    subject: impl FnOnce() -> Result<Subject, Failure>,
    options: &Options,
) -> Result<(), Failure> {
    output::check(&options.outputs, options.json.as_deref())?;
    let progress = Progress::new();
    let mut product = produce(subject, &options.mesher, true, &no_needs, &progress)?;
    progress.stage("writing");
    product.stage("write", |product| {
        let mut outputs = options.outputs.iter();
        outputs.try_for_each(|path| match &product.program {
            Some(program) if io::step::is_step(path) => {
                output::write_step(path, program, product.mesh.unit)
            }
            _ => output::write_mesh(path, &product.mesh, options.format),
        })
    })?;
    drop(progress);
    let account = Account::of(&mut product);
    if let Some(path) = &options.json {
        output::write_json(path, &account)?;
    }
    // Standard output may be carrying data.
    eprint!("{account}");
    for path in options.outputs.iter().filter(|path| !is_stream(path)) {
        eprintln!("wrote {}", path.display());
    }
    Ok(())
}
