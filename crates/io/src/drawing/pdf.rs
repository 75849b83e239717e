//! Portable Document Format.

use std::io::Write;

use glam::DVec2;
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, TextStr};

use super::beziers::cubics;
use super::outline::{Outline, Shape};
use super::{DrawingOptions, Sheet};
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

/// Writes outlines on a page of their own, in true size, what they bound filled: lines, and
/// cubic Bézier curves in place of all others.
///
/// # Errors
/// [`Error::EmptyDrawing`], [`Error::DrawingTolerance`]; failed writing.
pub fn write_pdf(
    outlines: &[Outline],
    options: &DrawingOptions,
    out: &mut impl Write,
) -> Result<(), Error> {
    let sheet = Sheet::new(outlines, options)?;
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
    for outline in outlines {
        let Some(first) = outline.pieces.first() else {
            continue;
        };
        let [x, y] = place(first.from);
        content.move_to(x, y);
        for piece in &outline.pieces {
            if piece.shape == Shape::Line {
                let [x, y] = place(piece.to);
                content.line_to(x, y);
                continue;
            }
            for [p, q, to] in cubics(piece, sheet.tolerance) {
                let [[a, b], [c, d], [x, y]] = [p, q, to].map(place);
                content.cubic_to(a, b, c, d, x, y);
            }
        }
        content.close_path();
    }
    content.fill_even_odd_and_stroke();
    let [catalog, pages, page, contents, info] = [1, 2, 3, 4, 5].map(Ref::new);
    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(pages);
    pdf.pages(pages).kids([page]).count(1);
    let mut written = pdf.page(page);
    let media = Rect::new(0.0, 0.0, size.x as f32, size.y as f32);
    written.parent(pages).media_box(media).contents(contents);
    if user_unit > 1.0 {
        written.pair(Name(b"UserUnit"), user_unit as f32);
    }
    written.resources();
    written.finish();
    pdf.stream(contents, &content.finish());
    pdf.document_info(info).title(TextStr(sheet.title));
    out.write_all(&pdf.finish())?;
    Ok(())
}
