//! Drawing exchange format, as text, of the year 2000 (AC1015): the first that has ellipses and
//! splines, and which nearly every program reads.

use csg::elementary;
use std::f64::consts::{PI, TAU};
use std::fmt::{Display, Write as _};
use std::io::Write;

use csg::LengthUnit;
use glam::DVec2;

use super::dimension::HEIGHT;
use super::outline::{Outline, Piece, Shape};
use super::{Dimension, Drawing, DrawingOptions, Sheet};
use crate::Error;

/// Writes outlines: of lines and circular arcs as one closed polyline with bulges, whole circles
/// and ellipses as such, and others piece by piece, parabolas and hyperbolas as rational splines
/// of degree two. Lines of views are on the layers `VISIBLE` and `HIDDEN`, which is dashed, and
/// sizes, as lines and text, on `DIMENSIONS`.
///
/// # Errors
/// [`Error::EmptyDrawing`], [`Error::DrawingTolerance`]; failed writing.
pub fn write_dxf(
    drawing: &Drawing,
    options: &DrawingOptions,
    out: &mut impl Write,
) -> Result<(), Error> {
    let sheet = Sheet::new(drawing, options)?;
    let mut file = Tags::default();
    let units = units(sheet.unit);
    file.section("HEADER", |file| {
        file.tag(9, "$ACADVER").tag(1, "AC1015");
        file.tag(9, "$HANDSEED").tag(5, "FFFF");
        file.tag(9, "$INSUNITS").tag(70, units);
        file.tag(9, "$MEASUREMENT").tag(70, u8::from(units > 2));
        file.tag(9, "$EXTMIN").point(10, sheet.low);
        file.tag(9, "$EXTMAX").point(10, sheet.high);
    });
    file.section("TABLES", |file| tables(file, DASH * sheet.side));
    file.section("BLOCKS", |file| {
        for (k, block) in [MODEL, PAPER].into_iter().enumerate() {
            let owner = block.handle;
            for (kind, class) in [("BLOCK", "AcDbBlockBegin"), ("ENDBLK", "AcDbBlockEnd")] {
                file.tag(0, kind)
                    .handle(0x20 + 2 * k as u32 + u32::from(kind == "ENDBLK"));
                file.tag(330, format_args!("{owner:X}"));
                file.tag(100, "AcDbEntity").tag(8, "0").tag(100, class);
                if kind == "BLOCK" {
                    file.tag(2, block.name).tag(70, 0).point(10, DVec2::ZERO);
                    file.tag(3, block.name).tag(1, "");
                }
            }
        }
    });
    file.section("ENTITIES", |file| {
        let mut entities = Entities {
            file,
            next: 0x100,
            layer: "0",
        };
        for outline in &drawing.outlines {
            entities.outline(outline);
        }
        for (layer, pieces) in [(VISIBLE, &drawing.visible), (HIDDEN, &drawing.hidden)] {
            entities.layer = layer;
            pieces.iter().for_each(|piece| entities.piece(piece));
        }
        entities.layer = DIMENSIONS;
        for size in &drawing.dimensions {
            entities.dimension(size, &sheet);
        }
    });
    file.section("OBJECTS", |file| {
        file.tag(0, "DICTIONARY").handle(ROOT).tag(330, "0");
        file.tag(100, "AcDbDictionary").tag(281, 1);
        file.tag(3, "ACAD_GROUP")
            .tag(350, format_args!("{GROUPS:X}"));
        file.tag(0, "DICTIONARY")
            .handle(GROUPS)
            .tag(330, format_args!("{ROOT:X}"));
        file.tag(100, "AcDbDictionary").tag(281, 1);
    });
    file.tag(0, "EOF");
    // (A title has no place in the format but a comment.)
    let title = sheet.title.replace(['\r', '\n'], " ");
    write!(out, "999\n{title}\n{}", file.text)?;
    Ok(())
}

/// The number that the format has for a unit.
fn units(unit: LengthUnit) -> u8 {
    match unit {
        LengthUnit::Inch => 1,
        LengthUnit::Foot => 2,
        LengthUnit::Millimetre => 4,
        LengthUnit::Centimetre => 5,
        LengthUnit::Metre => 6,
        LengthUnit::Micrometre => 13,
    }
}

/// Layers, and the line type of the second.
const VISIBLE: &str = "VISIBLE";
const HIDDEN: &str = "HIDDEN";
const DIMENSIONS: &str = "DIMENSIONS";

/// Of the longer side, a dash; the gap after it is a half as long.
const DASH: f64 = 0.012;

/// Handles: numbers of what others name.
const ROOT: u32 = 0xC;
const GROUPS: u32 = 0xD;

/// A table's record of a block.
struct Block {
    name: &'static str,
    handle: u32,
}

const MODEL: Block = Block {
    name: "*Model_Space",
    handle: 0x1A,
};
const PAPER: Block = Block {
    name: "*Paper_Space",
    handle: 0x1B,
};

/// The tables that programs want to find, with no more in them than they must have.
fn tables(file: &mut Tags, dash: f64) {
    let records: [(&str, &str, &[&str]); 9] = [
        ("VPORT", "", &[]),
        (
            "LTYPE",
            "AcDbLinetypeTableRecord",
            &["ByBlock", "ByLayer", "Continuous", HIDDEN],
        ),
        (
            "LAYER",
            "AcDbLayerTableRecord",
            &["0", VISIBLE, HIDDEN, DIMENSIONS],
        ),
        ("STYLE", "AcDbTextStyleTableRecord", &["Standard"]),
        ("VIEW", "", &[]),
        ("UCS", "", &[]),
        ("APPID", "AcDbRegAppTableRecord", &["ACAD"]),
        ("DIMSTYLE", "", &[]),
        (
            "BLOCK_RECORD",
            "AcDbBlockTableRecord",
            &[MODEL.name, PAPER.name],
        ),
    ];
    let mut next = 0x10;
    for (table, (name, class, entries)) in (1..).zip(records) {
        file.tag(0, "TABLE")
            .tag(2, name)
            .handle(table)
            .tag(330, "0");
        file.tag(100, "AcDbSymbolTable").tag(70, entries.len());
        if name == "DIMSTYLE" {
            file.tag(100, "AcDbDimStyleTable");
        }
        for &entry in entries {
            file.tag(0, name)
                .handle(next)
                .tag(330, format_args!("{table:X}"));
            file.tag(100, "AcDbSymbolTableRecord")
                .tag(100, class)
                .tag(2, entry);
            next += 1;
            match name {
                "LTYPE" if entry == HIDDEN => {
                    file.tag(70, 0)
                        .tag(3, "__ __ __")
                        .tag(72, 65)
                        .tag(73, 2)
                        .number(40, 1.5 * dash);
                    file.number(49, dash).tag(74, 0);
                    file.number(49, -0.5 * dash).tag(74, 0);
                }
                "LTYPE" => {
                    file.tag(70, 0)
                        .tag(3, "")
                        .tag(72, 65)
                        .tag(73, 0)
                        .tag(40, "0.0");
                }
                "LAYER" => {
                    let color = if entry == DIMENSIONS { 5 } else { 7 };
                    let kind = if entry == HIDDEN {
                        HIDDEN
                    } else {
                        "Continuous"
                    };
                    file.tag(70, 0).tag(62, color).tag(6, kind);
                }
                "STYLE" => {
                    file.tag(70, 0).tag(40, "0.0").tag(41, "1.0").tag(50, "0.0");
                    file.tag(71, 0).tag(42, "2.5").tag(3, "txt").tag(4, "");
                }
                "APPID" => {
                    file.tag(70, 0);
                }
                _ => {}
            }
            // Records of blocks have the handles that these say.
            next = if name == "APPID" { MODEL.handle } else { next };
        }
        file.tag(0, "ENDTAB");
    }
}

/// The file's lines: a number that says what follows, and that.
#[derive(Default)]
struct Tags {
    text: String,
}

impl Tags {
    fn tag(&mut self, code: u16, value: impl Display) -> &mut Self {
        // (Writing to a string cannot fail.)
        let _ = writeln!(self.text, "{code}\n{value}");
        self
    }

    fn handle(&mut self, handle: u32) -> &mut Self {
        self.tag(5, format_args!("{handle:X}"))
    }

    /// A number that reads back to the same bits, with a point.
    fn number(&mut self, code: u16, number: f64) -> &mut Self {
        self.tag(code, format_args!("{number:?}"))
    }

    /// A point of z = 0.
    fn point(&mut self, code: u16, point: DVec2) -> &mut Self {
        self.number(code, point.x)
            .number(code + 10, point.y)
            .number(code + 20, 0.0)
    }

    fn section(&mut self, name: &str, write: impl FnOnce(&mut Self)) {
        self.tag(0, "SECTION").tag(2, name);
        write(self);
        self.tag(0, "ENDSEC");
    }
}

struct Entities<'a> {
    file: &'a mut Tags,
    next: u32,
    layer: &'static str,
}

impl Entities<'_> {
    fn outline(&mut self, outline: &Outline) {
        let pieces = &outline.pieces;
        let is_round = |piece: &Piece| match piece.shape {
            Shape::Line => true,
            Shape::Ellipse { is_circle, .. } => is_circle && !piece.is_whole(),
            Shape::Conic { .. } | Shape::Cubic { .. } => false,
        };
        if pieces.iter().all(is_round) {
            self.polyline(pieces);
        } else {
            pieces.iter().for_each(|piece| self.piece(piece));
        }
    }

    fn entity(&mut self, name: &str, class: &str) -> &mut Tags {
        self.file.tag(0, name).handle(self.next);
        self.next += 1;
        self.file.tag(330, format_args!("{:X}", MODEL.handle));
        self.file
            .tag(100, "AcDbEntity")
            .tag(8, self.layer)
            .tag(100, class)
    }

    /// Closed, of lines and arcs: a bulge is the tangent of a quarter of an arc's angle.
    fn polyline(&mut self, pieces: &[Piece]) {
        let mut corners = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let turn = piece.shape.turn();
            // Beyond a half of a circle the tangent grows without end.
            if turn.abs() > PI {
                corners.push((piece.from, elementary::tan(turn / 8.0)));
                corners.push((piece.at(0.5), elementary::tan(turn / 8.0)));
            } else {
                corners.push((piece.from, elementary::tan(turn / 4.0)));
            }
        }
        let file = self.entity("LWPOLYLINE", "AcDbPolyline");
        file.tag(90, corners.len()).tag(70, 1);
        for (point, bulge) in corners {
            file.number(10, point.x).number(20, point.y);
            if bulge != 0.0 {
                file.number(42, bulge);
            }
        }
    }

    fn dimension(&mut self, size: &Dimension, sheet: &Sheet<'_>) {
        for [from, to] in size.strokes(sheet.side) {
            let file = self.entity("LINE", "AcDbLine");
            file.point(10, from).point(11, to);
        }
        let (at, along) = size.place(sheet.side);
        // (Signs that are not ASCII have names of their own.)
        let text = size.text(sheet.unit).replace('⌀', "%%c");
        let text = text.replace('µ', "\\U+00B5");
        let file = self.entity("TEXT", "AcDbText");
        file.point(10, at)
            .number(40, HEIGHT * sheet.side)
            .tag(1, text);
        file.number(50, elementary::atan2(along.y, along.x).to_degrees());
        // In the middle, on the base line.
        file.tag(72, 1).point(11, at).tag(100, "AcDbText");
    }

    fn piece(&mut self, piece: &Piece) {
        match piece.shape {
            Shape::Line => {
                let file = self.entity("LINE", "AcDbLine");
                file.point(10, piece.from).point(11, piece.to);
            }
            Shape::Ellipse {
                center,
                long,
                short,
                range,
                is_circle,
            } => {
                // Counter-clockwise, which is the only way there is.
                let side = long.perp_dot(short).signum();
                let mut range = range.map(|t| side * t);
                if range[1] < range[0] {
                    range.reverse();
                }
                let is_whole = piece.is_whole();
                if !is_circle {
                    let file = self.entity("ELLIPSE", "AcDbEllipse");
                    file.point(10, center).point(11, long);
                    let from = if is_whole {
                        0.0
                    } else {
                        range[0].rem_euclid(TAU)
                    };
                    let to = from + if is_whole { TAU } else { range[1] - range[0] };
                    file.number(40, short.length() / long.length());
                    file.number(41, from).number(42, to);
                    return;
                }
                let file = self.entity(if is_whole { "CIRCLE" } else { "ARC" }, "AcDbCircle");
                file.point(10, center)
                    .number(40, 0.5 * (long.length() + short.length()));
                if !is_whole {
                    let lean = elementary::atan2(long.y, long.x);
                    let [from, to] = range.map(|t| (lean + t).to_degrees().rem_euclid(360.0));
                    file.tag(100, "AcDbArc").number(50, from).number(51, to);
                }
            }
            Shape::Cubic { controls: [a, b] } => {
                let file = self.entity("SPLINE", "AcDbSpline");
                file.tag(70, 8).tag(71, 3).tag(72, 8).tag(73, 4).tag(74, 0);
                for knot in [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0] {
                    file.number(40, knot);
                }
                for point in [piece.from, a, b, piece.to] {
                    file.point(10, point);
                }
            }
            Shape::Conic { control, weight } => {
                let file = self.entity("SPLINE", "AcDbSpline");
                // In a plane, rational.
                file.tag(70, 8 + 4)
                    .tag(71, 2)
                    .tag(72, 6)
                    .tag(73, 3)
                    .tag(74, 0);
                for knot in [0.0, 0.0, 0.0, 1.0, 1.0, 1.0] {
                    file.number(40, knot);
                }
                for weight in [1.0, weight, 1.0] {
                    file.number(41, weight);
                }
                for point in [piece.from, control, piece.to] {
                    file.point(10, point);
                }
            }
        }
    }
}
