//! Portable Document Format.

use std::io::Write;

use glam::DVec2;
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str, TextStr};

use super::beziers::cubics;
use super::dimension::HEIGHT;
use super::outline::{Piece, Shape};
use super::{Drawing, DrawingOptions, Sheet};
use crate::Error;

/// Points, the format's unit, in a metre.
const POINTS: f64 = 72.0 / 0.0254;
/// Around the drawing, in points: 5 mm.
const MARGIN: f64 = 0.005 * POINTS;
/// Width of lines, in points: 0.35 mm.
const LINE: f64 = 0.35e-3 * POINTS;
/// But no wider than this share of a small drawing.
const THIN: f64 = 0.005;
/// No page is longer, in units that are points unless the page says otherwise.
const LONGEST: f64 = 14_400.0;

/// Writes a drawing on a page of its own, in true size, what outlines bound filled: lines, and
/// cubic Bézier curves in place of all others.
///
/// # Errors
/// [`Error::EmptyDrawing`], [`Error::DrawingTolerance`]; failed writing.
pub fn write_pdf(
    drawing: &Drawing,
    options: &DrawingOptions,
    out: &mut impl Write,
) -> Result<(), Error> {
    let sheet = Sheet::new(drawing, options)?;
    let scale = sheet.unit.in_metres() * POINTS;
    let size = scale * (sheet.high - sheet.low) + DVec2::splat(2.0 * MARGIN);
    let user_unit = (size.max_element() / LONGEST).max(1.0).ceil();
    let size = size / user_unit;
    let place = |point: DVec2| -> [f32; 2] {
        let place = (scale * (point - sheet.low) + DVec2::splat(MARGIN)) / user_unit;
        place.as_vec2().to_array()
    };
    let mut content = Content::new();
    content.set_fill_rgb(0.86, 0.894, 0.933);
    content.set_stroke_rgb(0.1, 0.1, 0.1);
    let line = LINE.min(THIN * size.max_element() * user_unit);
    content.set_line_width((line / user_unit) as f32);
    let draw = |content: &mut Content, piece: &Piece| {
        if piece.shape == Shape::Line {
            let [x, y] = place(piece.to);
            content.line_to(x, y);
            return;
        }
        for [p, q, to] in cubics(piece, sheet.tolerance) {
            let [[a, b], [c, d], [x, y]] = [p, q, to].map(place);
            content.cubic_to(a, b, c, d, x, y);
        }
    };
    for outline in &drawing.outlines {
        let Some(first) = outline.pieces.first() else {
            continue;
        };
        let [x, y] = place(first.from);
        content.move_to(x, y);
        for piece in &outline.pieces {
            draw(&mut content, piece);
        }
        content.close_path();
    }
    if !drawing.outlines.is_empty() {
        content.fill_even_odd_and_stroke();
    }
    let line = (line / user_unit) as f32;
    for (pieces, width, dashes) in [
        (&drawing.hidden, 0.6, &[4.0, 3.0][..]),
        (&drawing.visible, 1.4, &[][..]),
    ] {
        if pieces.is_empty() {
            continue;
        }
        content.set_line_width(width * line);
        content.set_dash_pattern(dashes.iter().map(|dash| dash * line), 0.0);
        let mut at = None;
        for piece in pieces {
            if at != Some(piece.from) {
                let [x, y] = place(piece.from);
                content.move_to(x, y);
            }
            draw(&mut content, piece);
            at = Some(piece.to);
        }
        content.stroke();
    }
    if !drawing.dimensions.is_empty() {
        content.set_stroke_rgb(0.165, 0.36, 0.667);
        content.set_fill_rgb(0.165, 0.36, 0.667);
        content.set_line_width(0.5 * line);
    }
    let height = (HEIGHT * sheet.side * scale / user_unit) as f32;
    for size in &drawing.dimensions {
        for stroke in size.strokes(sheet.side) {
            let [[a, b], [x, y]] = stroke.map(place);
            content.move_to(a, b).line_to(x, y);
        }
        content.stroke();
        // In the encoding of the font, which has no sign for diameters but a letter.
        let text: Vec<u8> = size
            .text(sheet.unit)
            .chars()
            .map(|c| match c {
                '⌀' => 0xd8,
                'µ' => 0xb5,
                c => c as u8,
            })
            .collect();
        let (at, along) = size.place(sheet.side);
        let along = along.as_vec2();
        let half = 0.5 * width(&text) * height;
        let [x, y] = place(at);
        let [x, y] = [x - half * along.x, y - half * along.y];
        content.begin_text().set_font(Name(FONT), height);
        content.set_text_matrix([along.x, along.y, -along.y, along.x, x, y]);
        content.show(Str(&text)).end_text();
    }
    let [catalog, pages, page, contents, info, font] = [1, 2, 3, 4, 5, 6].map(Ref::new);
    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(pages);
    pdf.pages(pages).kids([page]).count(1);
    let mut written = pdf.page(page);
    let media = Rect::new(0.0, 0.0, size.x as f32, size.y as f32);
    written.parent(pages).media_box(media).contents(contents);
    if user_unit > 1.0 {
        written.pair(Name(b"UserUnit"), user_unit as f32);
    }
    let mut resources = written.resources();
    if !drawing.dimensions.is_empty() {
        resources.fonts().pair(Name(FONT), font);
    }
    resources.finish();
    written.finish();
    if !drawing.dimensions.is_empty() {
        let mut font = pdf.type1_font(font);
        font.base_font(Name(b"Helvetica"));
        font.encoding_predefined(Name(b"WinAnsiEncoding"));
    }
    pdf.stream(contents, &content.finish());
    pdf.document_info(info).title(TextStr(sheet.title));
    out.write_all(&pdf.finish())?;
    Ok(())
}

/// The name of the one font, which all readers have.
const FONT: &[u8] = b"F";

/// How wide text is in Helvetica, at height 1.
fn width(text: &[u8]) -> f32 {
    let widths = text.iter().map(|c| match c {
        b'0'..=b'9' | b'u' | b'n' | 0xb5 => 0.556,
        b'.' | b' ' | b't' | b'f' => 0.278,
        b'm' => 0.833,
        b'i' => 0.222,
        b'-' => 0.333,
        0xd8 => 0.778,
        _ => 0.5,
    });
    widths.sum()
}
