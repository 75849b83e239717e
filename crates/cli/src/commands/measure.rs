//! `measure`: volume, area and centroid of a solid from its exact boundary, or of a mesh.

use std::path::PathBuf;
use std::time::Instant;

use csg::{Error, Program};
use serde::Serialize;

use super::account::Account;
use super::exact::ExactAccount;
use crate::failure::Failure;
use crate::input::{Reader, Subject};
use crate::mesher::{MesherOptions, no_needs, produce};
use crate::nothing::Nothing;
use crate::output::{self, is_stream};
use crate::progress::Progress;

/// Options of `measure`: of a solid the exact boundary is measured, unless one of them asks for
/// a mesh or it has more than 50,000 faces, all of them flat.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    #[command(flatten)]
    pub(crate) mesher: MesherOptions,
    /// Write the measures as JSON; `-` writes to standard output, in place of
    /// the text
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Options {
    fn tell(&self, account: &(impl Serialize + ToString)) -> Result<(), Failure> {
        if let Some(path) = &self.json {
            output::write_json(path, account)?;
            if is_stream(path) {
                return Ok(());
            }
        }
        output::print(account.to_string().as_bytes())
    }
}

/// Whether a solid is measured as a mesh because of its many faces, all of them flat: the mesh is
/// as exact, but for rounding, and takes a tenth of the time.
fn is_large_polyhedron(program: &Program) -> bool {
    const MANY: usize = 50_000;
    program.carriers().len() > MANY && program.is_polyhedral()
}

pub(crate) fn run(
    subject: Reader<'_>,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    let mesher = &options.mesher;
    progress.stage("reading");
    let start = Instant::now();
    let subject = subject()?;
    let read = start.elapsed();
    let program = match &subject {
        Subject::Solid(solid, _) if !mesher.is_of_mesh() => Some((solid, Program::lower(solid)?)),
        _ => None,
    };
    if let Some((solid, program)) = program.filter(|(_, program)| !is_large_polyhedron(program)) {
        progress.stage("boundary");
        let boundary = mesher.boundary(progress);
        match ExactAccount::of((solid, &program), &boundary, subject.unit(mesher.unit)) {
            Ok((account, _)) => {
                progress.end();
                if account.is_empty() {
                    say!("{}", Nothing::of(solid));
                }
                return options.tell(&account);
            }
            // A mesh is better than nothing.
            Err(error @ Error::Undecided(_)) => say!("warning: {error}"),
            Err(error) => return Err(error.into()),
        }
    }
    let mut product = produce(Box::new(|| Ok(subject)), mesher, true, &no_needs, progress)?;
    product.seconds.push(("read", read.as_secs_f64()));
    let account = Account::of(&mut product);
    progress.end();
    options.tell(&account)
}
