//! `section`: draw what a plane meets of a solid, with true lines, arcs and ellipses.

use std::fmt;
use std::path::PathBuf;

use csg::BoundaryOptions;
use io::drawing::{
    DrawingFormat, DrawingOptions, Outline, Section, SectionFrame, Shape, write_drawing,
    write_drawing_to,
};
use serde::Serialize;

use super::figure::Figure;
use super::parse::{WrittenPlane, length, plane};
use crate::failure::{Failure, exit_codes};
use crate::input::Subject;
use crate::mesher::{LimitOptions, Unit};
use crate::output::{self, is_stream};
use crate::progress::Progress;

/// Options of `section`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The plane: x, y or z with a position, like z=0, or NX,NY,NZ:PX,PY,PZ. Planes across
    /// z are seen from above, across y from the front, across x from the right, and others,
    /// and those with a sign, like -y=0, from where their normal points
    #[arg(long, value_name = "PLANE", allow_hyphen_values = true, value_parser = plane)]
    plane: WrittenPlane,
    /// Where to write the drawing (.svg .dxf .pdf), or `-` for SVG on standard output; may
    /// be given more than once
    #[arg(short, long = "output", value_name = "OUT", required = true)]
    outputs: Vec<PathBuf>,
    /// How far Bézier curves may stray from what they stand for: parabolas and hyperbolas in
    /// SVG, all curves in PDF [default: a millionth of the drawing's longer side]
    #[arg(long, value_name = "DISTANCE", value_parser = length, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// The unit of the model's lengths
    #[arg(long, value_enum, default_value_t = Unit::Mm)]
    unit: Unit,
    /// Write area, length and counts as JSON; `-` writes to standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    limits: LimitOptions,
}

impl Options {
    /// The plane as it is looked at.
    fn frame(&self) -> Option<SectionFrame> {
        let WrittenPlane {
            normal,
            point,
            is_by_axis,
        } = self.plane;
        // The front is where y is least.
        let is_across_y = is_by_axis && normal.y != 0.0;
        SectionFrame::facing(point, if is_across_y { -normal } else { normal })
    }
}

pub(crate) fn run(
    subject: impl FnOnce() -> Result<Subject, Failure>,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    output::check_streams(&options.outputs, options.json.as_deref())?;
    for path in options.outputs.iter().filter(|path| !is_stream(path)) {
        DrawingFormat::from_path(path)
            .map_err(|error| Failure::new(exit_codes::USAGE, "no such format", error))?;
    }
    let frame = options.frame().ok_or_else(|| {
        let cause = "its numbers are too large: give a plane nearer to the origin";
        Failure::new(exit_codes::USAGE, "no such plane", cause)
    })?;
    progress.stage("reading");
    let solid = subject()?.solid()?;
    progress.stage("section");
    let boundary = BoundaryOptions::new()
        .limits(options.limits.limits())
        .progress(progress.callback());
    let section = Section::of(&solid, &frame, &boundary)?;
    if section.is_at_face {
        eprintln!(
            "warning: the solid has a face in the plane: drawn is what lies just behind it, \
             which is not what lies just before it"
        );
    }
    for path in &options.outputs {
        let mut drawing = DrawingOptions::default()
            .title(path.file_stem().unwrap_or_default().to_string_lossy())
            .unit(options.unit.length_unit());
        if let Some(tolerance) = options.tolerance {
            drawing = drawing.tolerance(tolerance);
        }
        let written = if is_stream(path) {
            let mut bytes = Vec::new();
            let format = DrawingFormat::Svg;
            write_drawing_to(format, &section.outlines, &drawing.title(""), &mut bytes)
                .map(|()| Some(bytes))
        } else {
            write_drawing(path, &section.outlines, &drawing).map(|()| None)
        };
        let bytes = written.map_err(|error| {
            let name = path.display().to_string();
            match error {
                error if section.outlines.is_empty() => {
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
    let account = Account::of(&section, options.unit);
    if let Some(path) = &options.json {
        output::write_json(path, &account)?;
    }
    progress.say(&account);
    for path in options.outputs.iter().filter(|path| !is_stream(path)) {
        progress.say(format_args!("wrote {}", path.display()));
    }
    Ok(())
}

/// What is said of a section.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Account {
    area: Figure,
    /// Of all outlines.
    length: Figure,
    /// Connected parts.
    parts: usize,
    /// Outlines around holes.
    holes: usize,
    lines: usize,
    /// Circles and their arcs.
    arcs: usize,
    /// Ellipses and their arcs.
    ellipses: usize,
    /// Pieces of parabolas and hyperbolas.
    conics: usize,
    unit: &'static str,
}

impl Account {
    fn of(section: &Section, unit: Unit) -> Self {
        let pieces = section
            .outlines
            .iter()
            .flat_map(|outline: &Outline| &outline.pieces);
        let count =
            |is: fn(&Shape) -> bool| pieces.clone().filter(|piece| is(&piece.shape)).count();
        Self {
            area: section.area.into(),
            length: section.length.into(),
            parts: section.parts,
            holes: section.outlines.len() - section.parts,
            lines: count(|shape| matches!(shape, Shape::Line)),
            arcs: count(|shape| {
                matches!(
                    shape,
                    Shape::Ellipse {
                        is_circle: true,
                        ..
                    }
                )
            }),
            ellipses: count(|shape| {
                matches!(
                    shape,
                    Shape::Ellipse {
                        is_circle: false,
                        ..
                    }
                )
            }),
            conics: count(|shape| matches!(shape, Shape::Conic { .. })),
            unit: unit.symbol(),
        }
    }
}

impl fmt::Display for Account {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.unit;
        writeln!(f, "area        {} {unit}²", self.area)?;
        writeln!(f, "outlines    {} {unit}", self.length)?;
        writeln!(f, "parts       {}", self.parts)?;
        writeln!(f, "holes       {}", self.holes)?;
        let kinds = [
            (self.lines, "lines"),
            (self.arcs, "circles and arcs"),
            (self.ellipses, "ellipses"),
            (self.conics, "parabolas and hyperbolas"),
        ];
        let kinds = kinds.iter().filter(|(count, _)| *count > 0);
        let kinds: Vec<String> = kinds
            .map(|(count, kind)| format!("{count} {kind}"))
            .collect();
        write!(f, "pieces      {}", kinds.join(", "))
    }
}
