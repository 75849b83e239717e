//! `view`: the model in the browser.

use std::any::{Any, TypeId};
use std::collections::BTreeMap;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;

use clap::{Arg, ArgAction, ArgMatches, Args, Command};
use csg::Solid;
use io::scene::SceneError;
use view::{
    Loaded, Parameter, ParameterKind, Problem, Source, Subject, TextPlace, ViewError, ViewOptions,
};

use crate::failure::{Failure, exit_codes};
use crate::input::{Contents, Input, repaired};
use crate::mesher::{MesherOptions, Unit};
use crate::output;

/// Options of `view`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Only print the page's address
    #[arg(long)]
    no_open: bool,
    /// The port on this machine's own address [default: one that is free]
    #[arg(
        long,
        value_name = "PORT",
        default_value_t = 0,
        hide_default_value = true
    )]
    port: u16,
    #[command(flatten)]
    mesher: MesherOptions,
}

impl Options {
    fn serve(&self, source: &mut dyn Source) -> Result<(), Failure> {
        let options = ViewOptions {
            port: self.port,
            open: !self.no_open,
            settings: self.mesher.view_settings(),
        };
        let mut printed = Ok(());
        view::view(source, &options, |address| {
            printed = output::print(format!("{address}\n").as_bytes());
        })
        .map_err(|error| {
            let code = match error {
                ViewError::Port { .. } => exit_codes::USAGE,
                ViewError::Watch { .. } => exit_codes::INPUT,
                _ => exit_codes::OUTPUT,
            };
            Failure::new(code, "the model cannot be shown", error)
        })?;
        printed
    }
}

/// Shows a file.
pub(crate) fn run_file(input: Input, options: &Options) -> Result<(), Failure> {
    let unit = options.mesher.unit;
    options.serve(&mut FileSource {
        input,
        unit,
        read: None,
    })
}

struct FileSource {
    input: Input,
    unit: Unit,
    /// What standard input held: it cannot be read twice.
    read: Option<(Solid, Vec<String>)>,
}

impl Source for FileSource {
    fn name(&self) -> String {
        if self.input.is_stream() {
            return "model".to_owned();
        }
        let name = self.input.path().file_stem().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    fn file(&self) -> Option<&Path> {
        (!self.input.is_stream()).then_some(self.input.path())
    }

    fn load(&mut self, _: &BTreeMap<String, String>) -> Result<Loaded, Problem> {
        let loaded = |(solid, warnings)| Loaded {
            subject: Subject::Solid(solid),
            warnings,
        };
        if let Some(read) = &self.read {
            return Ok(loaded(read.clone()));
        }
        let contents = self.input.contents(self.unit);
        match contents.map_err(|failure| Problem::new(failure.reason()))? {
            Contents::Mesh(file) => Ok(Loaded {
                subject: Subject::Mesh(file.or_in(self.unit.length_unit()).mesh),
                warnings: Vec::new(),
            }),
            Contents::Repaired(solid, _, repairs) => {
                let warnings = repaired(self.input.path(), &repairs);
                Ok(loaded((solid, warnings.into_iter().collect())))
            }
            Contents::Scene(Ok(scene)) => {
                let warnings = scene.warnings.iter().map(ToString::to_string).collect();
                let read = (scene.solid, warnings);
                self.read = self.input.is_stream().then(|| read.clone());
                Ok(loaded(read))
            }
            Contents::Scene(Err(error)) => Err(self.problem(&error)),
        }
    }
}

impl FileSource {
    /// What is wrong with a scene, with the lines around it.
    fn problem(&self, error: &SceneError) -> Problem {
        let place = error.place().filter(|place| place.file.is_some());
        let text = place.and_then(|_| std::fs::read_to_string(self.input.path()).ok());
        Problem {
            message: error.to_string(),
            place: place
                .zip(text)
                .map(|(place, text)| TextPlace::of(&text, place.line, place.column)),
        }
    }
}

/// Shows a model with arguments of its own; they begin as the command line has them.
pub(crate) fn run_model<A: Args>(
    model: impl Fn(A) -> Solid,
    given: &ArgMatches,
    options: &Options,
) -> Result<(), Failure> {
    let command = Command::new("model")
        .no_binary_name(true)
        .disable_help_flag(true);
    let make = |matches: &ArgMatches| A::from_arg_matches(matches).map(&model);
    run_command(&make, A::augment_args(command), given, options)
}

/// Shows what is made of a command's arguments.
fn run_command(
    make: Make<'_>,
    command: Command,
    given: &ArgMatches,
    options: &Options,
) -> Result<(), Failure> {
    let raw = |argument: &Arg| {
        let values = given.get_raw(argument.get_id().as_str());
        values
            .into_iter()
            .flatten()
            .map(|value| value.to_string_lossy().into_owned())
    };
    let (mut parameters, mut fixed) = (Vec::new(), Vec::new());
    for argument in command.get_arguments() {
        match kind(argument) {
            Some(kind) => {
                let help = argument.get_help().map(ToString::to_string);
                let default = raw(argument).next().unwrap_or_default();
                parameters.push(Parameter {
                    name: argument.get_id().to_string(),
                    help: help.unwrap_or_default(),
                    default,
                    kind,
                });
            }
            None => fixed.extend(raw(argument).map(|value| (argument.get_id().to_string(), value))),
        }
    }
    options.serve(&mut ModelSource {
        make,
        command,
        parameters,
        fixed,
    })
}

/// What values an argument takes; `None` for one that is given more than once.
fn kind(argument: &Arg) -> Option<ParameterKind> {
    match argument.get_action() {
        ArgAction::SetTrue => return Some(ParameterKind::Flag),
        ArgAction::Set if argument.get_num_args().is_none_or(|n| n.max_values() <= 1) => {}
        _ => return None,
    }
    let choices = argument.get_possible_values();
    if !choices.is_empty() {
        let names = choices.iter().map(|choice| choice.get_name().to_owned());
        let choices = names.collect();
        return Some(ParameterKind::Choice { choices });
    }
    let value = argument.get_value_parser().type_id();
    let is = |types: &[TypeId]| types.iter().any(|of| value == *of);
    let whole = [
        TypeId::of::<u8>(),
        TypeId::of::<u16>(),
        TypeId::of::<u32>(),
        TypeId::of::<u64>(),
        TypeId::of::<usize>(),
        TypeId::of::<i8>(),
        TypeId::of::<i16>(),
        TypeId::of::<i32>(),
        TypeId::of::<i64>(),
        TypeId::of::<isize>(),
    ];
    Some(match () {
        () if is(&[TypeId::of::<f64>(), TypeId::of::<f32>()]) => ParameterKind::Number,
        () if is(&whole) => ParameterKind::Integer,
        () => ParameterKind::Text,
    })
}

type Make<'a> = &'a dyn Fn(&ArgMatches) -> Result<Solid, clap::Error>;

struct ModelSource<'a> {
    make: Make<'a>,
    /// The model's own arguments.
    command: Command,
    parameters: Vec<Parameter>,
    /// Values of arguments that are not among the parameters.
    fixed: Vec<(String, String)>,
}

impl ModelSource<'_> {
    /// A command line for these values.
    fn line(&self, values: &BTreeMap<String, String>) -> Vec<String> {
        let of_parameters = self.parameters.iter().map(|parameter| {
            let value = values.get(&parameter.name).unwrap_or(&parameter.default);
            (&parameter.name, value)
        });
        let fixed = self.fixed.iter().map(|(name, value)| (name, value));
        let (mut options, mut positions) = (Vec::new(), Vec::new());
        for (name, value) in of_parameters.chain(fixed) {
            let mut arguments = self.command.get_arguments();
            let Some(argument) = arguments.find(|argument| argument.get_id() == name.as_str())
            else {
                continue;
            };
            let flag = match (argument.get_long(), argument.get_short()) {
                (Some(long), _) => format!("--{long}"),
                (None, Some(short)) => format!("-{short}"),
                (None, None) if value.is_empty() => continue,
                (None, None) => {
                    positions.push((argument.get_index(), value.clone()));
                    continue;
                }
            };
            match argument.get_action() {
                ArgAction::SetTrue if value == "true" => options.push(flag),
                ArgAction::SetTrue => {}
                _ if value.is_empty() => {}
                _ => options.push(format!("{flag}={value}")),
            }
        }
        // (Values that begin with a dash are no options here.)
        options.push("--".to_owned());
        positions.sort();
        options.extend(positions.into_iter().map(|(_, value)| value));
        options
    }
}

impl Source for ModelSource<'_> {
    fn name(&self) -> String {
        let program = std::env::args_os().next().unwrap_or_default();
        let name = Path::new(&program).file_stem().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    fn parameters(&self) -> Vec<Parameter> {
        self.parameters.clone()
    }

    fn load(&mut self, values: &BTreeMap<String, String>) -> Result<Loaded, Problem> {
        let said = |error: clap::Error| {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            Problem::new(first.strip_prefix("error: ").unwrap_or(first))
        };
        let matches = self.command.clone().try_get_matches_from(self.line(values));
        let matches = matches.map_err(said)?;
        // A model that panics is shown as a mistake, and may be right with other values.
        let made = panic::catch_unwind(AssertUnwindSafe(|| (self.make)(&matches)));
        let solid = made.map_err(|payload| Problem::new(told(&*payload)))?;
        Ok(Loaded {
            subject: Subject::Solid(solid.map_err(said)?),
            warnings: Vec::new(),
        })
    }
}

/// What a panic said.
fn told(payload: &(dyn Any + Send)) -> String {
    let text = payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    format!("the model panicked: {}", text.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(clap::Args)]
    struct Arguments {
        /// How many
        #[arg(default_value_t = 3)]
        count: u32,
        #[arg(long, default_value_t = -0.5, allow_negative_numbers = true)]
        shift: f64,
        #[arg(short)]
        solid: bool,
        #[arg(long, value_parser = ["round", "square"], default_value = "round")]
        shape: String,
        #[arg(long)]
        label: Option<String>,
        #[arg(long)]
        hole: Vec<f64>,
    }

    #[test]
    fn arguments_become_parameters_and_back() {
        let command = Arguments::augment_args(Command::new("model").no_binary_name(true));
        let parsed = |line: Vec<String>| {
            let matches = command.clone().try_get_matches_from(line).expect("valid");
            <Arguments as clap::FromArgMatches>::from_arg_matches(&matches).expect("valid")
        };
        let parameters = command.get_arguments().filter_map(|argument| {
            Some(Parameter {
                name: argument.get_id().to_string(),
                help: String::new(),
                default: argument
                    .get_default_values()
                    .first()
                    .map_or(String::new(), |value| value.to_string_lossy().into_owned()),
                kind: kind(argument)?,
            })
        });
        let source = ModelSource {
            make: &|_| unreachable!("nothing is made here"),
            parameters: parameters.collect(),
            fixed: [1.5, -2.0]
                .map(|hole| ("hole".to_owned(), hole.to_string()))
                .into(),
            command: command.clone(),
        };
        let kinds: Vec<_> = source
            .parameters
            .iter()
            .map(|p| (&*p.name, &p.kind))
            .collect();
        let choices = ["round", "square"].map(str::to_owned).into();
        assert_eq!(
            kinds,
            [
                ("count", &ParameterKind::Integer),
                ("shift", &ParameterKind::Number),
                ("solid", &ParameterKind::Flag),
                ("shape", &ParameterKind::Choice { choices }),
                ("label", &ParameterKind::Text),
            ]
        );
        let usual = parsed(source.line(&BTreeMap::new()));
        assert_eq!((usual.count, usual.shift, usual.solid), (3, -0.5, false));
        assert_eq!((&*usual.shape, usual.label), ("round", None));
        assert_eq!(usual.hole, [1.5, -2.0]);
        let values = [
            ("count", "7"),
            ("shift", "-3"),
            ("solid", "true"),
            ("label", "-a b"),
        ];
        let values = values.map(|(name, value)| (name.to_owned(), value.to_owned()));
        let other = parsed(source.line(&values.into()));
        assert_eq!((other.count, other.shift, other.solid), (7, -3.0, true));
        assert_eq!(other.label.as_deref(), Some("-a b"));
    }
}
