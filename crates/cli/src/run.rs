//! Parsing the command line and running the command it names.

use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use csg::Solid;

use crate::commands::{measure, mesh, render};
use crate::failure::{EXIT_CODES_HELP, Failure};
use crate::input::{Input, Subject};

/// Meshes, pictures and measures of solids made of half-spaces
#[derive(Debug, Parser)]
#[command(name = "csg", version, after_help = EXIT_CODES_HELP)]
struct FileCommandLine {
    #[command(subcommand)]
    command: FileCommand,
}

#[derive(Debug, Subcommand)]
enum FileCommand {
    /// Write meshes of the input
    Mesh {
        #[command(flatten)]
        input: Input,
        #[command(flatten)]
        options: mesh::Options,
    },
    /// Draw a picture of the input
    Render {
        #[command(flatten)]
        input: Input,
        #[command(flatten)]
        options: Box<render::Options>,
    },
    /// Measure the input
    Measure {
        #[command(flatten)]
        input: Input,
        #[command(flatten)]
        options: measure::Options,
    },
}

#[derive(Debug, Parser)]
#[command(after_help = EXIT_CODES_HELP)]
struct ModelCommandLine<A: Args> {
    #[command(flatten)]
    model: A,
    #[command(subcommand)]
    command: ModelCommand,
}

#[derive(Debug, Subcommand)]
enum ModelCommand {
    /// Write meshes of the model
    Mesh(mesh::Options),
    /// Draw a picture of the model
    Render(Box<render::Options>),
    /// Measure the model
    Measure(measure::Options),
}

/// A model without arguments of its own.
#[derive(Debug, Args)]
struct NoArguments {}

/// The `csg` command: its arguments are those of the process.
#[must_use]
pub fn main() -> ExitCode {
    let result = match FileCommandLine::parse().command {
        FileCommand::Mesh { input, options } => mesh::run(|| input.read(false), &options),
        FileCommand::Render { input, options } => {
            render::run(|| input.read(options.faces_only()), &options)
        }
        FileCommand::Measure { input, options } => measure::run(|| input.read(false), &options),
    };
    exit(result)
}

/// Runs `mesh`, `render` or `measure`, as the arguments of the process say, on
/// a model written in Rust. Returns the exit code ([`crate::exit_codes`])
/// after having said what went wrong, if anything did.
#[must_use]
pub fn run(model: impl FnOnce() -> Solid) -> ExitCode {
    run_with(|_: NoArguments| model())
}

/// [`run`] for a model with arguments of its own, which come before the
/// subcommand.
///
/// ```no_run
/// use cli::clap;
/// use csg::Solid;
///
/// #[derive(clap::Args)]
/// struct Dimensions {
///     /// Radius of the bore
///     #[arg(long, default_value_t = 0.5)]
///     bore: f64,
/// }
///
/// fn main() -> std::process::ExitCode {
///     cli::run_with(|dimensions: Dimensions| {
///         Solid::cube(2.0) - Solid::infinite_cylinder(dimensions.bore)
///     })
/// }
/// ```
#[must_use]
pub fn run_with<A: Args>(model: impl FnOnce(A) -> Solid) -> ExitCode {
    let ModelCommandLine {
        model: arguments,
        command,
    } = ModelCommandLine::<A>::parse();
    let subject = || Ok(Subject::Solid(model(arguments)));
    exit(match command {
        ModelCommand::Mesh(options) => mesh::run(subject, &options),
        ModelCommand::Render(options) => render::run(subject, &options),
        ModelCommand::Measure(options) => measure::run(subject, &options),
    })
}

fn exit(result: Result<(), Failure>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            ExitCode::from(failure.code)
        }
    }
}
