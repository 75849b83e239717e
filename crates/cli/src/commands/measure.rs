//! `measure`: volume, area, centroid, and whether the mesh is sound.

use std::path::PathBuf;

use super::account::Account;
use crate::failure::Failure;
use crate::input::Subject;
use crate::mesher::{MesherOptions, no_needs, produce};
use crate::output::{self, is_stream};
use crate::progress::Progress;

/// Options of `measure`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    #[command(flatten)]
    mesher: MesherOptions,
    /// Write the measures as JSON; `-` writes to standard output, in place of
    /// the text
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

pub(crate) fn run(
    subject: impl FnOnce() -> Result<Subject, Failure>,
    options: &Options,
) -> Result<(), Failure> {
    let progress = Progress::new();
    let mut product = produce(subject, &options.mesher, true, &no_needs, &progress)?;
    let account = Account::of(&mut product);
    drop(progress);
    if let Some(path) = &options.json {
        output::write_json(path, &account)?;
        if is_stream(path) {
            return Ok(());
        }
    }
    output::print(account.to_string().as_bytes())
}
