//! Drawings of sections and views: true lines, arcs and ellipses, as SVG, DXF and PDF.
//!
//! What a plane meets of a solid ([`Section`]), and what is seen of it along a direction
//! ([`View`]), is taken from its exact boundary, not from a mesh: planes give
//! lines, and quadrics conics; curves of degree four, which views alone have, are Bézier curves
//! of degree three. Lines, circles and ellipses are what they are in SVG and DXF;
//! parabolas and hyperbolas are rational splines in DXF, which have the same points, and
//! Bézier curves in SVG. PDF knows no curves but Bézier's. Where these stand for another curve
//! they stray from it by no more than [`DrawingOptions::tolerance`].

mod beziers;
mod crossings;
mod dimension;
mod dxf;
mod outline;
mod pdf;
mod section;
mod seen;
mod svg;
mod view;

use csg::elementary;
use std::ffi::OsStr;
use std::io::Write;
use std::path::Path;

use csg::{BoundaryOptions, LengthUnit, Profile};
use glam::DVec2;

use crate::{AtomicFile, Error};

pub use self::dimension::Dimension;
pub use self::dxf::write_dxf;
pub use self::outline::{Outline, Piece, Shape};
pub use self::pdf::write_pdf;
pub use self::section::{Section, SectionFrame};
pub use self::svg::write_svg;
pub use self::view::View;

/// What is drawn. DXF has a layer for each of these.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Drawing {
    /// What they bound is filled.
    pub outlines: Vec<Outline>,
    /// Lines in full.
    pub visible: Vec<Piece>,
    /// Dashed lines.
    pub hidden: Vec<Piece>,
    /// Sizes, in thin lines, with numbers in the model's unit.
    pub dimensions: Vec<Dimension>,
}

impl Drawing {
    /// A box around all but sizes; none if there is nothing.
    #[must_use]
    pub fn bounds(&self) -> Option<[DVec2; 2]> {
        let outlines = self.outlines.iter().map(Outline::bounds);
        let pieces = self.visible.iter().chain(&self.hidden).map(Piece::bounds);
        join(outlines.chain(pieces))
    }
}

/// The box around some.
fn join(boxes: impl Iterator<Item = [DVec2; 2]>) -> Option<[DVec2; 2]> {
    boxes.reduce(|one, other| [one[0].min(other[0]), one[1].max(other[1])])
}

/// The formats of drawings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DrawingFormat {
    /// Scalable Vector Graphics.
    Svg,
    /// Drawing exchange format, as text, of the year 2000 (AC1015).
    Dxf,
    /// Portable Document Format, in true size.
    Pdf,
}

impl DrawingFormat {
    /// The format of a file by its name's extension.
    ///
    /// # Errors
    /// [`Error::UnknownDrawing`], which lists the known ones.
    pub fn from_path(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let extension = path.extension().and_then(OsStr::to_str);
        let extension = extension.unwrap_or_default().to_ascii_lowercase();
        match extension.as_str() {
            "svg" => Ok(Self::Svg),
            "dxf" => Ok(Self::Dxf),
            "pdf" => Ok(Self::Pdf),
            _ => Err(Error::UnknownDrawing {
                path: path.to_owned(),
            }),
        }
    }
}

/// Choices in writing.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DrawingOptions {
    /// The drawing's title.
    pub title: String,
    /// The unit of the model's lengths.
    pub unit: LengthUnit,
    /// How far Bézier curves may stray from what they stand for, in the model's unit: a
    /// millionth of the drawing's longer side unless given.
    pub tolerance: Option<f64>,
}

impl DrawingOptions {
    /// The same options with another title.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The same options with another unit.
    #[must_use]
    pub fn unit(mut self, unit: LengthUnit) -> Self {
        self.unit = unit;
        self
    }

    /// The same options with another tolerance.
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }
}

/// How far Bézier curves stray unless said otherwise, of the longer side.
const TOLERANCE: f64 = 1e-6;

/// What a drawing's writers need to know of it.
struct Sheet<'a> {
    title: &'a str,
    unit: LengthUnit,
    tolerance: f64,
    /// The longer side of what is drawn, without sizes.
    side: f64,
    low: DVec2,
    high: DVec2,
}

impl<'a> Sheet<'a> {
    fn new(drawing: &Drawing, options: &'a DrawingOptions) -> Result<Self, Error> {
        let bounds = drawing.bounds().ok_or(Error::EmptyDrawing)?;
        let side = (bounds[1] - bounds[0]).max_element();
        let sizes = drawing.dimensions.iter().map(|size| size.bounds(side));
        let [low, high] = join(sizes.chain([bounds])).unwrap_or(bounds);
        let tolerance = options.tolerance.unwrap_or(TOLERANCE * side);
        if tolerance > 0.0 && tolerance.is_finite() {
            Ok(Self {
                title: &options.title,
                unit: options.unit,
                tolerance,
                side,
                low,
                high,
            })
        } else {
            Err(Error::DrawingTolerance { tolerance })
        }
    }

    /// So many decimals tell coordinates to a thousandth of a millionth of the longer side.
    fn decimals(&self) -> usize {
        let side = (self.high - self.low).max_element();
        (9.0 - elementary::log10(side).floor()).clamp(0.0, 15.0) as usize
    }
}

/// A number with so many decimals at most, and none that say nothing.
fn decimal(number: f64, decimals: usize) -> String {
    let text = format!("{number:.decimals$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    match text {
        "-0" | "" => "0".to_owned(),
        text => text.to_owned(),
    }
}

/// Writes a drawing to a file whose extension names the format (`.svg`, `.dxf`, `.pdf`),
/// replaced whole or not at all ([`AtomicFile`]).
///
/// # Errors
/// [`Error::UnknownDrawing`], [`Error::EmptyDrawing`], [`Error::DrawingTolerance`]; what the
/// operating system refuses.
pub fn write_drawing(
    path: impl AsRef<Path>,
    drawing: &Drawing,
    options: &DrawingOptions,
) -> Result<(), Error> {
    let path = path.as_ref();
    let format = DrawingFormat::from_path(path)?;
    let write = || {
        let mut file = AtomicFile::create(path)?;
        write_drawing_to(format, drawing, options, &mut file)?;
        file.commit()
    };
    write().map_err(|error| error.in_file(path))
}

/// Writes a flat shape to a file as [`write_drawing`] does, filled: lines, arcs and circles stay such,
/// and so do ellipses; [`crate::read_profile`] reads SVG and DXF back as the same shape, in SVG
/// counted from the page's corner. The section
/// that is drawn ([`Section::of_profile`]) tells its area, and if its outlines had to be polygons.
///
/// ```no_run
/// use csg::Profile;
/// use io::drawing::write_profile;
///
/// let plate = Profile::rounded_rectangle([60.0, 40.0], 5.0) - Profile::circle(3.0);
/// let drawn = write_profile("plate.dxf", &plate, &Default::default())?;
/// assert_eq!(drawn.strays, None);
/// # Ok::<(), io::Error>(())
/// ```
///
/// # Errors
/// As [`write_drawing`]; [`Error::Undrawable`] for what is wrong with the profile.
pub fn write_profile(
    path: impl AsRef<Path>,
    profile: &Profile,
    options: &DrawingOptions,
) -> Result<Section, Error> {
    let path = path.as_ref();
    DrawingFormat::from_path(path)?;
    let section = Section::of_profile(profile, &BoundaryOptions::new());
    let section = section.map_err(|error| Error::Undrawable(error).in_file(path))?;
    write_drawing(path, &section.drawing(), options)?;
    Ok(section)
}

/// Writes a drawing in one of the formats.
///
/// # Errors
/// As [`write_drawing`].
pub fn write_drawing_to(
    format: DrawingFormat,
    drawing: &Drawing,
    options: &DrawingOptions,
    out: &mut impl Write,
) -> Result<(), Error> {
    match format {
        DrawingFormat::Svg => write_svg(drawing, options, out),
        DrawingFormat::Dxf => write_dxf(drawing, options, out),
        DrawingFormat::Pdf => write_pdf(drawing, options, out),
    }
}
