//! `section`: draw what a plane meets of a solid, with true lines, arcs and ellipses.

use std::fmt;

use io::drawing::{Outline, Section, SectionFrame, Shape};
use serde::Serialize;

use super::figure::{Figure, at_most, short};
use super::parse::{WrittenPlane, plane};
use super::sheet::{SheetOptions, kinds};
use crate::failure::{Failure, exit_codes};
use crate::input::Reader;
use crate::mesher::Unit;
use crate::nothing::refuse_empty;
use crate::progress::Progress;

/// Options of `section`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The plane: x, y or z with a position, like z=0, or NX,NY,NZ:PX,PY,PZ. Planes across
    /// z are seen from above, across y from the front, across x from the right, and others,
    /// and those with a sign, like -y=0, from where their normal points
    #[arg(long, value_name = "PLANE", allow_hyphen_values = true, value_parser = plane)]
    plane: WrittenPlane,
    #[command(flatten)]
    pub(crate) sheet: SheetOptions,
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
    subject: Reader<'_>,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    options.sheet.check()?;
    let frame = options.frame().ok_or_else(|| {
        let cause = "its numbers are too large: give a plane nearer to the origin";
        Failure::new(exit_codes::USAGE, "no such plane", cause)
    })?;
    progress.stage("reading");
    let solid = subject()?.solid(options.sheet.tell.unit)?;
    progress.stage("section");
    let boundary = options.sheet.boundary(progress);
    let section = Section::of(&solid, &frame, &boundary)?;
    if section.outlines.is_empty() {
        refuse_empty(&solid, &boundary)?;
    }
    if section.is_at_face {
        say!(
            "warning: the solid has a face in the plane: drawn is what lies just behind it, \
             which is not what lies just before it"
        );
    }
    let unit = options.sheet.tell.unit.symbol();
    if let Some(strays) = section.strays {
        let off = match strays.is_finite() {
            true => format!("that stray by up to {} {unit}", short(strays, 2)),
            false => "of a mesh, and how far they are off is not known".to_owned(),
        };
        say!(
            "warning: it could not be told how surfaces meet in the plane: drawn are polygons {off}"
        );
    }
    if let Some(moved) = section.moved {
        let distance = at_most(moved.distance, 2);
        say!(
            "warning: surfaces that nearly touch in the plane were moved by up to \
             {distance} {unit}"
        );
    }
    let account = Account::of(&section, options.sheet.tell.unit);
    options.sheet.write(&section.drawing(), &account, progress)
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
        let told = [
            (self.lines, "lines"),
            (self.arcs, "circles and arcs"),
            (self.ellipses, "ellipses"),
            (self.conics, "parabolas and hyperbolas"),
        ];
        write!(f, "pieces      {}", kinds(&told))
    }
}
