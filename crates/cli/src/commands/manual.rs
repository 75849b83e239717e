//! `completions` and `man`: what shells and readers of manuals want to know of the command.

use std::path::PathBuf;

use clap::Command;
use clap_complete::Shell;

use crate::failure::Failure;
use crate::output::{self, is_stream};

/// Options of `completions`.
#[derive(Debug, clap::Args)]
pub(crate) struct CompletionOptions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Options of `man`.
#[derive(Debug, clap::Args)]
pub(crate) struct ManOptions {
    /// The folder to write a page to for the command and each of its subcommands; without
    /// one, or with `-`, the command's own page goes to standard output
    #[arg(value_name = "FOLDER")]
    folder: Option<PathBuf>,
}

/// Prints what completes the command's arguments in a shell.
pub(crate) fn completions(
    options: &CompletionOptions,
    mut command: Command,
) -> Result<(), Failure> {
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut command, name, &mut script);
    output::print(&script)
}

/// Writes manual pages.
pub(crate) fn man(options: &ManOptions, command: Command) -> Result<(), Failure> {
    match options.folder.as_deref().filter(|path| !is_stream(path)) {
        Some(folder) => clap_mangen::generate_to(command, folder)
            .map_err(|error| Failure::output(&folder.display().to_string(), error)),
        None => {
            let mut page = Vec::new();
            clap_mangen::Man::new(command)
                .render(&mut page)
                .map_err(|error| Failure::output("standard output", error))?;
            output::print(&page)
        }
    }
}
