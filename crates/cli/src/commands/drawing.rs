//! `drawing`: draw what is seen of a solid, hidden lines dashed, with sizes.

use std::fmt;

use csg::glam::DVec3;
use io::drawing::{Piece, SectionFrame, Shape, View};
use raster::StandardView;
use serde::Serialize;

use super::figure::short;
use super::parse::point;
use super::sheet::{SheetOptions, kinds};
use crate::failure::Failure;
use crate::input::Reader;
use crate::nothing::refuse_empty;
use crate::progress::Progress;

/// Options of `drawing`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// From where it is looked at: front, back, left, right, top, bottom, iso, or a direction
    /// along which, X,Y,Z
    #[arg(long, value_name = "VIEW", allow_hyphen_values = true, value_parser = frame,
          default_value = "front")]
    view: SectionFrame,
    /// Leave out what is hidden
    #[arg(long)]
    no_hidden: bool,
    /// Write width and height beside it, and the diameters of circles that are seen as such
    #[arg(long)]
    dimensions: bool,
    #[command(flatten)]
    pub(crate) sheet: SheetOptions,
}

/// How it is looked at: as pictures are.
fn frame(text: &str) -> Result<SectionFrame, String> {
    let frame = match StandardView::from_name(text) {
        Some(view) => {
            let (direction, up) = view.direction_and_up();
            let x = direction.cross(up).normalize();
            Some(SectionFrame {
                origin: DVec3::ZERO,
                x,
                y: x.cross(direction),
            })
        }
        None => point(text).and_then(|along| SectionFrame::facing(DVec3::ZERO, -along)),
    };
    frame.ok_or_else(|| {
        let names = StandardView::ALL.map(StandardView::name).join(", ");
        format!("give one of {names}, or a direction like -1,1,-1")
    })
}

pub(crate) fn run(
    subject: Reader<'_>,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    options.sheet.check()?;
    progress.stage("reading");
    let solid = subject()?.solid(options.sheet.tell.unit)?;
    progress.stage("drawing");
    let boundary = options.sheet.boundary(progress);
    let mut view = View::of(&solid, &options.view, &boundary)?;
    if options.no_hidden {
        view.hidden.clear();
    }
    let drawing = view.drawing(options.dimensions);
    let account = Account {
        visible: Count::of(&view.visible),
        hidden: Count::of(&view.hidden),
        dimensions: drawing.dimensions.iter().map(|size| size.value).collect(),
        unit: options.sheet.tell.unit.symbol(),
    };
    if drawing.bounds().is_none() {
        refuse_empty(&solid, &boundary)?;
    }
    options.sheet.write(&drawing, &account, progress)
}

/// What is said of a view.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Account {
    visible: Count,
    /// Dashed.
    hidden: Count,
    /// Width and height, and diameters, if they were asked for.
    dimensions: Vec<f64>,
    unit: &'static str,
}

/// Pieces of each kind.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Count {
    lines: usize,
    /// Circles and their arcs.
    arcs: usize,
    /// Ellipses and their arcs.
    ellipses: usize,
    /// Pieces of parabolas and hyperbolas.
    conics: usize,
    /// Pieces of other curves.
    splines: usize,
}

impl Count {
    fn of(pieces: &[Piece]) -> Self {
        let mut count = Self {
            lines: 0,
            arcs: 0,
            ellipses: 0,
            conics: 0,
            splines: 0,
        };
        for piece in pieces {
            *match piece.shape {
                Shape::Line => &mut count.lines,
                Shape::Ellipse {
                    is_circle: true, ..
                } => &mut count.arcs,
                Shape::Ellipse { .. } => &mut count.ellipses,
                Shape::Conic { .. } => &mut count.conics,
                _ => &mut count.splines,
            } += 1;
        }
        count
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told = kinds(&[
            (self.lines, "lines"),
            (self.arcs, "circles and arcs"),
            (self.ellipses, "ellipses"),
            (self.conics, "parabolas and hyperbolas"),
            (self.splines, "splines"),
        ]);
        f.write_str(if told.is_empty() { "nothing" } else { &told })
    }
}

impl fmt::Display for Account {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "visible     {}", self.visible)?;
        write!(f, "hidden      {}", self.hidden)?;
        if let [width, height, ..] = self.dimensions[..] {
            let size = format!("{} × {}", short(width, 9), short(height, 9));
            write!(f, "\nsize        {size} {}", self.unit)?;
        }
        Ok(())
    }
}
