//! Options of commands that draw, and of those that tell of exact boundaries.

use std::path::PathBuf;

use csg::BoundaryOptions;
use io::drawing::{Drawing, DrawingFormat, DrawingOptions, write_drawing, write_drawing_to};
use serde::Serialize;

use super::parse::length;
use crate::failure::{Failure, exit_codes};
use crate::mesher::{LimitOptions, Unit};
use crate::output::{self, is_stream};
use crate::progress::Progress;

/// What all of them take.
#[derive(Debug, clap::Args)]
pub(crate) struct TellOptions {
    /// The unit of lengths
    #[arg(long, value_enum, default_value_t = Unit::Mm)]
    pub unit: Unit,
    /// Write what is told as JSON; `-` writes to standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    #[command(flatten)]
    pub limits: LimitOptions,
}

/// Where to draw, and how.
#[derive(Debug, clap::Args)]
pub(crate) struct SheetOptions {
    /// Where to write the drawing (.svg .dxf .pdf), or `-` for SVG on standard output; may
    /// be given more than once
    #[arg(short, long = "output", value_name = "OUT", required = true)]
    outputs: Vec<PathBuf>,
    /// How far Bézier curves may stray from what they stand for: parabolas and hyperbolas in
    /// SVG, all curves in PDF [default: a millionth of the drawing's longer side]
    #[arg(long, value_name = "DISTANCE", value_parser = length, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    #[command(flatten)]
    pub tell: TellOptions,
}

impl SheetOptions {
    /// Refuses outputs that would come out mixed, or in no known format.
    pub fn check(&self) -> Result<(), Failure> {
        output::check_streams(&self.outputs, self.tell.json.as_deref())?;
        for path in self.files() {
            DrawingFormat::from_path(path)
                .map_err(|error| Failure::new(exit_codes::USAGE, "no such format", error))?;
        }
        let json = self.tell.json.as_deref();
        output::check_folders(self.outputs.iter().map(PathBuf::as_path).chain(json))
    }

    pub fn boundary(&self, progress: &Progress) -> BoundaryOptions {
        BoundaryOptions::new()
            .limits(self.tell.limits.limits())
            .progress(progress.callback())
    }

    fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.outputs.iter().filter(|path| !is_stream(path))
    }

    /// Writes a drawing, and tells what is told of it.
    pub fn write(
        &self,
        drawing: &Drawing,
        account: &(impl Serialize + ToString),
        progress: &Progress,
    ) -> Result<(), Failure> {
        progress.stage("writing");
        let is_empty = drawing.bounds().is_none();
        for path in &self.outputs {
            let mut options = DrawingOptions::default()
                .title(path.file_stem().unwrap_or_default().to_string_lossy())
                .unit(self.tell.unit.length_unit());
            if let Some(tolerance) = self.tolerance {
                options = options.tolerance(tolerance);
            }
            let written = if is_stream(path) {
                let mut bytes = Vec::new();
                write_drawing_to(DrawingFormat::Svg, drawing, &options.title(""), &mut bytes)
                    .map(|()| Some(bytes))
            } else {
                write_drawing(path, drawing, &options).map(|()| None)
            };
            let bytes = written.map_err(|error| {
                let name = path.display().to_string();
                match error {
                    error if is_empty => {
                        Failure::new(exit_codes::MODEL, format!("cannot draw {name}"), error)
                            .hint("`csg measure` tells between which coordinates the solid lies")
                    }
                    error => Failure::output(&name, error),
                }
            })?;
            if let Some(bytes) = bytes {
                output::print(&bytes)?;
            }
        }
        progress.end();
        if let Some(path) = &self.tell.json {
            output::write_json(path, account)?;
        }
        progress.say(account.to_string());
        for path in self.files() {
            progress.say(format_args!("wrote {}", path.display()));
        }
        Ok(())
    }
}

/// Draws numbers of kinds of pieces: those that there are.
pub(super) fn kinds(kinds: &[(usize, &str)]) -> String {
    let kinds = kinds.iter().filter(|(count, _)| *count > 0);
    let kinds: Vec<String> = kinds
        .map(|(count, kind)| format!("{count} {kind}"))
        .collect();
    kinds.join(", ")
}
