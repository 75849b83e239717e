//! Scalable Vector Graphics.

use csg::elementary;
use std::fmt::Write as _;
use std::io::Write;

use csg::LengthUnit;
use glam::DVec2;

use super::beziers::parabolas;
use super::dimension::HEIGHT;
use super::outline::{Outline, Piece, Shape};
use super::{Dimension, Drawing, DrawingOptions, Sheet, decimal};
use crate::Error;

/// Of the longer side, the margin around the drawing and the width of its lines.
const MARGIN: f64 = 0.02;
const LINE: f64 = 0.002;

/// Of half a turn: longer arcs are written as three, as their centre is told better by parts.
const FLATTEST: f64 = 1.5;

/// Writes outlines as one path, what they bound filled, and lines as another one, dashed ones
/// as a third: circles and ellipses as arcs, parabolas and hyperbolas as quadratic Bézier curves.
/// Sizes are lines and text. Width and height are those of the model; y, which
/// points down in the format, is turned over.
///
/// # Errors
/// [`Error::EmptyDrawing`], [`Error::DrawingTolerance`]; failed writing.
pub fn write_svg(
    drawing: &Drawing,
    options: &DrawingOptions,
    out: &mut impl Write,
) -> Result<(), Error> {
    let sheet = Sheet::new(drawing, options)?;
    let longer = (sheet.high - sheet.low).max_element();
    let margin = DVec2::splat(MARGIN * longer);
    let (low, high) = (sheet.low - margin, sheet.high + margin);
    let size = high - low;
    let decimals = sheet.decimals();
    let number = |x: f64| decimal(x, decimals);
    let (unit, scale) = unit(sheet.unit);
    let [width, height] = (scale * size).to_array().map(number);
    let view = [low.x, -high.y, size.x, size.y].map(number).join(" ");
    let line = LINE * longer;
    let pen = Pen {
        sheet: &sheet,
        decimals,
    };
    let outlines = drawing.outlines.iter();
    let paths: String = outlines.map(|outline| pen.outline(outline)).collect();
    let mut layers = String::new();
    if !paths.is_empty() {
        let line = number(line);
        layers += &format!(
            "<path fill=\"#dbe4ee\" fill-rule=\"evenodd\" stroke=\"#1a1a1a\" \
             stroke-width=\"{line}\" stroke-linejoin=\"round\" d=\"{paths}\"/>\n"
        );
    }
    let dashes = [4.0, 3.0].map(|length| number(length * line)).join(" ");
    let dashes = format!(" stroke-dasharray=\"{dashes}\"");
    for (name, pieces, dashes, width) in [
        ("hidden", &drawing.hidden, dashes.as_str(), 0.6 * line),
        ("visible", &drawing.visible, "", 1.4 * line),
    ] {
        if !pieces.is_empty() {
            let (paths, width) = (pen.pieces(pieces), number(width));
            layers += &format!(
                "<path id=\"{name}\" fill=\"none\" stroke=\"#1a1a1a\" stroke-width=\"{width}\"\
                 {dashes} stroke-linecap=\"round\" d=\"{paths}\"/>\n"
            );
        }
    }
    if !drawing.dimensions.is_empty() {
        let sizes = drawing.dimensions.iter();
        let sizes: String = sizes.map(|size| pen.dimension(size)).collect();
        let (width, height) = (number(0.5 * line), number(HEIGHT * sheet.side));
        layers += &format!(
            "<g id=\"dimensions\" stroke=\"#2a5caa\" fill=\"none\" stroke-width=\"{width}\" \
             font-family=\"sans-serif\" font-size=\"{height}\" text-anchor=\"middle\">\n\
             {sizes}</g>\n"
        );
    }
    let title = escaped(sheet.title);
    write!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}{unit}\" \
         height=\"{height}{unit}\" viewBox=\"{view}\">\n\
         <title>{title}</title>\n\
         {layers}</svg>\n"
    )?;
    Ok(())
}

/// The unit's name in the format, and how many of it a unit of the model is.
fn unit(unit: LengthUnit) -> (&'static str, f64) {
    match unit {
        LengthUnit::Centimetre => ("cm", 1.0),
        LengthUnit::Inch => ("in", 1.0),
        LengthUnit::Foot => ("in", 12.0),
        other => ("mm", other.in_metres() * 1e3),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

struct Pen<'a> {
    sheet: &'a Sheet<'a>,
    decimals: usize,
}

impl Pen<'_> {
    /// A point with y turned over.
    fn point(&self, point: DVec2) -> String {
        let [x, y] = [point.x, -point.y].map(|x| decimal(x, self.decimals));
        format!("{x} {y}")
    }

    fn outline(&self, outline: &Outline) -> String {
        let mut path = String::new();
        let Some(first) = outline.pieces.first() else {
            return path;
        };
        path += &format!("M{}", self.point(first.from));
        for piece in &outline.pieces {
            self.piece(piece, &mut path);
        }
        path += "Z";
        path
    }

    /// Pieces that need not follow each other.
    fn pieces(&self, pieces: &[Piece]) -> String {
        let mut path = String::new();
        let mut at = None;
        for piece in pieces {
            if at != Some(piece.from) {
                path += &format!("M{}", self.point(piece.from));
            }
            self.piece(piece, &mut path);
            at = Some(piece.to);
        }
        path
    }

    fn dimension(&self, size: &Dimension) -> String {
        let strokes = size.strokes(self.sheet.side).into_iter();
        let strokes = strokes.map(|[from, to]| format!("M{}L{}", self.point(from), self.point(to)));
        let (at, along) = size.place(self.sheet.side);
        let [x, y] = [at.x, -at.y].map(|x| decimal(x, self.decimals));
        let turn = match decimal(-elementary::atan2(along.y, along.x).to_degrees(), 6).as_str() {
            "0" => String::new(),
            turn => format!(" transform=\"rotate({turn} {x} {y})\""),
        };
        format!(
            "<path d=\"{}\"/>\n\
             <text x=\"{x}\" y=\"{y}\"{turn} fill=\"#2a5caa\" stroke=\"none\">{}</text>\n",
            strokes.collect::<String>(),
            size.text(self.sheet.unit)
        )
    }

    fn piece(&self, piece: &Piece, path: &mut String) {
        // (Writing to a string cannot fail.)
        let _ = match piece.shape {
            Shape::Line => write!(path, "L{}", self.point(piece.to)),
            Shape::Ellipse {
                long,
                short,
                is_circle,
                ..
            } => {
                let radii = [long, short].map(|axis| decimal(axis.length(), self.decimals));
                // (Seen from the other side angles change their signs.)
                let lean = match is_circle {
                    true => "0".to_owned(),
                    false => decimal(elementary::atan2(-long.y, long.x).to_degrees(), 12),
                };
                let turn = piece.shape.turn();
                let sweep = u8::from(turn < 0.0);
                let arc = |to: DVec2, is_large: bool| {
                    let large = u8::from(is_large);
                    let to = self.point(to);
                    format!("A{} {} {lean} {large} {sweep} {to}", radii[0], radii[1])
                };
                // An arc between two places that are one would be none, and the centre of half an
                // ellipse depends on the last digits of its ends by their square root.
                if turn.abs() > FLATTEST * std::f64::consts::PI {
                    let ends = [piece.at(1.0 / 3.0), piece.at(2.0 / 3.0), piece.to];
                    let thirds = ends.map(|to| arc(to, false));
                    write!(path, "{}", thirds.concat())
                } else {
                    write!(path, "{}", arc(piece.to, turn.abs() > std::f64::consts::PI))
                }
            }
            Shape::Cubic { controls } => {
                let [a, b] = controls.map(|control| self.point(control));
                write!(path, "C{a} {b} {}", self.point(piece.to))
            }
            Shape::Conic { .. } => {
                let parabolas = parabolas(piece, self.sheet.tolerance).into_iter();
                let curves = parabolas
                    .map(|[control, to]| format!("Q{} {}", self.point(control), self.point(to)));
                write!(path, "{}", curves.collect::<String>())
            }
        };
    }
}
