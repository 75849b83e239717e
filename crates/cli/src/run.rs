//! Parsing the command line and running the command it names.

use std::process::ExitCode;

#[cfg(feature = "view")]
use clap::CommandFactory;
use clap::{Args, Parser, Subcommand};
use csg::Solid;

#[cfg(feature = "view")]
use crate::commands::view;
use crate::commands::{measure, mesh, render};
use crate::failure::{EXIT_CODES_HELP, Failure, exit_codes};
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
    /// Show the input in the browser, again whenever it is saved
    #[cfg(feature = "view")]
    View {
        #[command(flatten)]
        input: Input,
        #[command(flatten)]
        options: view::Options,
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
    /// Show the model in the browser, its arguments as sliders
    #[cfg(feature = "view")]
    View(view::Options),
}

/// A model without arguments of its own.
#[derive(Debug, Args)]
struct NoArguments {}

/// The `csg` command: its arguments are those of the process.
#[must_use]
pub fn main() -> ExitCode {
    let command = match arguments::<FileCommandLine>() {
        Ok(line) => line.command,
        Err(code) => return code,
    };
    let result = match command {
        FileCommand::Mesh { input, options } => mesh::run(|| input.read(false), &options),
        FileCommand::Render { input, options } => {
            render::run(|| input.read(options.faces_only()), &options)
        }
        FileCommand::Measure { input, options } => measure::run(|| input.read(false), &options),
        #[cfg(feature = "view")]
        FileCommand::View { input, options } => view::run_file(input, &options),
    };
    exit(result)
}

/// Runs `mesh`, `render`, `measure` or `view`, as the arguments of the process say, on
/// a model written in Rust. Returns the exit code ([`crate::exit_codes`])
/// after having said what went wrong, if anything did.
#[must_use]
pub fn run(model: impl Fn() -> Solid) -> ExitCode {
    run_with(|_: NoArguments| model())
}

/// [`run`] for a model with arguments of its own, which come before the
/// subcommand. `view` shows them as sliders, boxes and lists, and makes the model again when
/// one is moved.
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
pub fn run_with<A: Args>(model: impl Fn(A) -> Solid) -> ExitCode {
    let ModelCommandLine {
        model: dimensions,
        command,
    } = match arguments::<ModelCommandLine<A>>() {
        Ok(line) => line,
        Err(code) => return code,
    };
    let subject = || Ok(Subject::Solid(model(dimensions)));
    exit(match command {
        ModelCommand::Mesh(options) => mesh::run(subject, &options),
        ModelCommand::Render(options) => render::run(subject, &options),
        ModelCommand::Measure(options) => measure::run(subject, &options),
        #[cfg(feature = "view")]
        ModelCommand::View(options) => {
            let given = ModelCommandLine::<A>::command().get_matches();
            view::run_model(model, &given, &options)
        }
    })
}

/// The arguments of the process; or the exit code, after help, the version or
/// what is wrong with them has been printed. (clap's own `parse` takes no notice
/// of help that cannot be written.)
fn arguments<P: Parser>() -> Result<P, ExitCode> {
    P::try_parse().map_err(|said| {
        let printed = said
            .print()
            .and_then(|()| std::io::Write::flush(&mut std::io::stdout()));
        exit(match printed {
            Ok(()) if said.exit_code() == 0 => Ok(()),
            Ok(()) => return ExitCode::from(exit_codes::USAGE),
            Err(error) => Err(Failure::output("standard output", error)),
        })
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
