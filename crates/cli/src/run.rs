//! Parsing the command line and running the command it names.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{ArgAction, Args, Command, CommandFactory, Parser, Subcommand};
use csg::Solid;

use crate::commands::sweep::Variable;
#[cfg(feature = "view")]
use crate::commands::view;
use crate::commands::{
    compare, convert, drawing, info, manual, measure, merge, mesh, render, section, sweep,
};
use crate::failure::{EXIT_CODES_HELP, Failure, exit_codes};
use crate::input::{Input, Reader, Reading, Subject, Wanted, is_openscad};
use crate::progress::Progress;

/// Meshes, pictures and measures of solids made of half-spaces
#[derive(Debug, Parser)]
#[command(name = "csg", version, after_help = EXIT_CODES_HELP)]
struct FileCommandLine {
    /// Say nothing on standard error but warnings and errors
    #[arg(short, long, global = true)]
    quiet: bool,
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
    /// Put the shards of a mesh together, from `mesh --shard`
    Merge(merge::Options),
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
    /// Draw what a plane meets of the input, with true lines, arcs and ellipses
    Section {
        #[command(flatten)]
        input: Input,
        #[command(flatten)]
        options: section::Options,
    },
    /// Draw what is seen of the input, with true lines, arcs and ellipses, hidden lines dashed
    Drawing {
        #[command(flatten)]
        input: Input,
        #[command(flatten)]
        options: drawing::Options,
    },
    /// Write the input in other formats
    Convert(Box<convert::Options>),
    /// Tell what is in a file
    Info(info::Options),
    /// Tell how two solids differ: volumes, the largest distance, a point
    Compare(compare::Options),
    /// Measure, and mesh, a table of variants of a model
    Sweep {
        /// The model of all rows, an OpenSCAD model whose variables are the table's columns
        /// [default: the file that the column `model` names in each row, beside the table]
        #[arg(long, value_name = "IN")]
        model: Option<PathBuf>,
        #[command(flatten)]
        reading: Reading,
        #[command(flatten)]
        options: sweep::Options,
    },
    /// Show the input in the browser, again whenever it is saved
    #[cfg(feature = "view")]
    View {
        #[command(flatten)]
        input: Input,
        #[command(flatten)]
        options: view::Options,
    },
    /// Print what completes the command's arguments in a shell
    Completions(manual::CompletionOptions),
    /// Write manual pages
    Man(manual::ManOptions),
}

#[derive(Debug, Parser)]
#[command(after_help = EXIT_CODES_HELP)]
struct ModelCommandLine<A: Args> {
    /// Say nothing on standard error but warnings and errors
    #[arg(short, long, global = true)]
    quiet: bool,
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
    /// Draw what a plane meets of the model, with true lines, arcs and ellipses
    Section(section::Options),
    /// Draw what is seen of the model, with true lines, arcs and ellipses, hidden lines dashed
    Drawing(drawing::Options),
    /// Measure, and mesh, a table of variants: its columns are the model's arguments
    Sweep(sweep::Options),
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
    let FileCommandLine { quiet, command } = match arguments() {
        Ok(line) => line,
        Err(code) => return code,
    };
    let progress = &Progress::new(quiet);
    let result = match command {
        FileCommand::Mesh { input, options } => {
            let wanted = options.mesher.wanted();
            mesh::run(Box::new(|| input.read(wanted)), &options, progress)
        }
        FileCommand::Merge(options) => merge::run(&options, progress),
        FileCommand::Render { input, options } => render::run(
            Box::new(|| {
                input.read(Wanted {
                    faces_only: options.faces_only(),
                    ..options.mesher.wanted()
                })
            }),
            &options,
            progress,
        ),
        FileCommand::Measure { input, options } => {
            let wanted = options.mesher.wanted();
            measure::run(Box::new(|| input.read(wanted)), &options, progress)
        }
        FileCommand::Section { input, options } => {
            let wanted = Wanted::solid(options.sheet.tell.unit);
            section::run(Box::new(|| input.read(wanted)), &options, progress)
        }
        FileCommand::Drawing { input, options } => {
            let wanted = Wanted::solid(options.sheet.tell.unit);
            drawing::run(Box::new(|| input.read(wanted)), &options, progress)
        }
        FileCommand::Convert(options) => convert::run(&options, progress),
        FileCommand::Info(options) => info::run(&options),
        FileCommand::Compare(options) => match compare::run(&options, progress) {
            Ok(false) => return ExitCode::from(exit_codes::DIFFERENT),
            result => result.map(|_| ()),
        },
        FileCommand::Sweep {
            model,
            reading,
            options,
        } => {
            let variant = |row: &[Variable]| file_variant(model.as_ref(), &reading, &options, row);
            sweep::run(&variant, &options, progress)
        }
        #[cfg(feature = "view")]
        FileCommand::View { input, options } => view::run_file(input, &options),
        FileCommand::Completions(options) => {
            manual::completions(&options, FileCommandLine::command())
        }
        FileCommand::Man(options) => manual::man(&options, FileCommandLine::command()),
    };
    progress.end();
    exit(result)
}

/// The model of a row: the one of all rows, or that which its column `model` names.
fn file_variant(
    model: Option<&PathBuf>,
    reading: &Reading,
    options: &sweep::Options,
    row: &[Variable],
) -> Result<Subject, Failure> {
    const MODEL: &str = "model";
    let own = row.iter().find(|(name, _)| name == MODEL);
    let path = match (model, own) {
        (Some(model), _) => model.clone(),
        (None, Some((_, name))) => options.folder().join(name),
        (None, None) => {
            let cause = "the table has no column `model`: give a --model for all rows";
            return Err(Failure::new(exit_codes::USAGE, "no model", cause));
        }
    };
    // What stands beside the name of a file of its own may be a note.
    let has_variables = model.is_some() || is_openscad(&path);
    let define = row
        .iter()
        .filter(|(name, value)| has_variables && name != MODEL && !value.is_empty());
    let define: Vec<String> = define.map(openscad_variable).collect();
    reading.read(&path, &define, options.wanted())
}

/// A variable as OpenSCAD's `-D` has it: text in quotes, unless it has them.
fn openscad_variable((name, value): &Variable) -> String {
    let is_value = value.parse::<f64>().is_ok()
        || matches!(value.as_str(), "true" | "false" | "undef")
        || value.starts_with(['[', '"']);
    if is_value {
        format!("{name}={value}")
    } else {
        let value = value.replace('\\', "\\\\").replace('"', "\\\"");
        format!("{name}=\"{value}\"")
    }
}

/// Runs `mesh`, `render`, `measure`, `section`, `sweep` or `view`, as the arguments of the
/// process say, on a model written in Rust. Returns the exit code ([`crate::exit_codes`])
/// after having said what went wrong, if anything did.
#[must_use]
pub fn run(model: impl Fn() -> Solid + Sync) -> ExitCode {
    run_with(|_: NoArguments| model())
}

/// [`run`] for a model with arguments of its own, which come before the
/// subcommand, or are the columns of the table that `sweep` is given. `view` shows them as
/// sliders, boxes and lists, and makes the model again when one is moved.
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
pub fn run_with<A: Args>(model: impl Fn(A) -> Solid + Sync) -> ExitCode {
    let ModelCommandLine {
        quiet,
        model: dimensions,
        command,
    } = match arguments::<ModelCommandLine<A>>() {
        Ok(line) => line,
        Err(code) => return code,
    };
    let progress = &Progress::new(quiet);
    let subject: Reader<'_> = Box::new(|| Ok(Subject::Solid(model(dimensions), None)));
    let result = match command {
        ModelCommand::Mesh(options) => mesh::run(subject, &options, progress),
        ModelCommand::Render(options) => render::run(subject, &options, progress),
        ModelCommand::Measure(options) => measure::run(subject, &options, progress),
        ModelCommand::Section(options) => section::run(subject, &options, progress),
        ModelCommand::Drawing(options) => drawing::run(subject, &options, progress),
        ModelCommand::Sweep(options) => {
            let variant = |row: &[Variable]| Ok(Subject::Solid(model(variant_of(row)?), None));
            sweep::run(&variant, &options, progress)
        }
        #[cfg(feature = "view")]
        ModelCommand::View(options) => {
            let given = ModelCommandLine::<A>::command().get_matches();
            view::run_model(&model, &given, &options)
        }
    };
    progress.end();
    exit(result)
}

/// A model's arguments from a row of variables: each is the argument of its name.
fn variant_of<A: Args>(row: &[Variable]) -> Result<A, Failure> {
    let usage = |cause: String| Failure::new(exit_codes::USAGE, "no such variant", cause);
    let command = A::augment_args(Command::new("row").no_binary_name(true));
    let plain = |name: &str| name.replace('_', "-");
    let mut line: Vec<OsString> = Vec::new();
    for (name, value) in row.iter().filter(|(_, value)| !value.is_empty()) {
        let found = command.get_arguments().find(|argument| {
            plain(argument.get_id().as_str()) == plain(name)
                || argument.get_long().is_some_and(|long| long == plain(name))
        });
        let argument = found.ok_or_else(|| {
            let known = command
                .get_arguments()
                .filter_map(|argument| argument.get_long());
            let known: Vec<&str> = known.collect();
            usage(format!(
                "the model has no argument `{name}`: it has {}",
                known.join(", ")
            ))
        })?;
        let long = argument.get_long().map(|long| format!("--{long}"));
        match (long, argument.get_action()) {
            (Some(long), ArgAction::SetTrue) => match value.as_str() {
                "true" | "1" | "yes" => line.push(long.into()),
                "false" | "0" | "no" => {}
                _ => return Err(usage(format!("`{name}` is true or false, not {value}"))),
            },
            (Some(long), _) => line.push(format!("{long}={value}").into()),
            (None, _) => line.push(value.into()),
        }
    }
    let matches = command.try_get_matches_from(line);
    let made = matches.and_then(|matches| A::from_arg_matches(&matches));
    made.map_err(|error| {
        let said = error.to_string();
        usage(
            said.lines()
                .next()
                .unwrap_or_default()
                .trim_start_matches("error: ")
                .to_owned(),
        )
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
            _ if said.use_stderr() => return ExitCode::from(exit_codes::USAGE),
            Ok(()) => Ok(()),
            Err(error) => Err(Failure::output("standard output", error)),
        })
    })
}

fn exit(result: Result<(), Failure>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            say!("{failure}");
            ExitCode::from(failure.code)
        }
    }
}
