//! `mesh`: write mesh files, and STEP.

use std::path::PathBuf;

use csg::{Program, Solid};
use serde::Serialize;

use super::account::Account;
use super::exact::ExactAccount;
use crate::failure::Failure;
use crate::input::Subject;
use crate::mesher::{MesherOptions, no_needs, produce};
use crate::nothing::Nothing;
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
    progress: &Progress,
) -> Result<(), Failure> {
    output::check(&options.outputs, options.json.as_deref())?;
    progress.stage("reading");
    let subject = subject()?;
    if let Subject::Solid(solid) = &subject
        && options.outputs.iter().all(io::step::is_step)
        && !options.mesher.is_of_mesh()
    {
        return write_exact(&Program::lower(solid)?, solid, options, progress);
    }
    let mut product = produce(|| Ok(subject), &options.mesher, true, &no_needs, progress)?;
    progress.stage("writing");
    product.stage("write", |product| {
        let mut outputs = options.outputs.iter();
        outputs.try_for_each(|path| match &product.program {
            Some(program) if io::step::is_step(path) => {
                let boundary = options.mesher.boundary(progress).cut_at_seams();
                output::write_step(path, &program.boundary(&boundary)?, product.mesh.unit)
            }
            _ => output::write_mesh(path, &product.mesh, options.format),
        })
    })?;
    progress.end();
    tell(&Account::of(&mut product), options, progress)
}

/// STEP files alone: no mesh is needed for them.
fn write_exact(
    program: &Program,
    solid: &Solid,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    progress.stage("boundary");
    let unit = options.mesher.unit;
    let boundary = options.mesher.boundary(progress).cut_at_seams();
    let (account, brep) = ExactAccount::of(program, &boundary, unit)?;
    if account.is_empty() {
        eprintln!("{}", Nothing::of(solid));
    }
    progress.stage("writing");
    for path in &options.outputs {
        output::write_step(path, &brep, unit.length_unit())?;
    }
    progress.end();
    tell(&account, options, progress)
}

/// Says what was written.
fn tell(
    account: &(impl Serialize + ToString),
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    if let Some(path) = &options.json {
        output::write_json(path, account)?;
    }
    progress.say(account.to_string().trim_end());
    for path in options.outputs.iter().filter(|path| !is_stream(path)) {
        progress.say(format_args!("wrote {}", path.display()));
    }
    Ok(())
}
