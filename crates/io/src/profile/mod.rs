//! Flat shapes from drawings: SVG and DXF files as a [`Profile`].
//!
//! Lines stay lines and arcs arcs: circles, round corners, `A` commands with equal radii, bulges,
//! `ARC`s. Quadratic Bézier curves stay parabolas. Whole ellipses are such, too, where they cross no
//! other contour of their element, or of the drawing in DXF: also circles under maps that scale unevenly, and arcs that close an ellipse. Other
//! curves (cubic ones, arcs of an ellipse beside other sides, which a [`Profile`] does not hold, and
//! splines but quadratic ones without weights) become chords within [`ProfileOptions::tolerance`], which
//! a warning says. What is read, and how, follows OpenSCAD's `import` where that is no loss, so that a
//! scene means the same:
//!
//! # SVG
//! - Read are `path`, `rect`, `circle`, `ellipse`, `polygon`, `polyline`, `g`, `a`, `switch`, `use`,
//!   `symbol` and inner `svg`, with `transform`s. Text, pictures, clips and masks are not, which
//!   a warning says, and nothing is taken from other files or style sheets.
//! - An element is what its contours enclose by the even-odd rule, whatever its `fill` and
//!   `fill-rule`, and the shape is the union of all elements. That is OpenSCAD's rule
//!   (its `import_svg.cc`); where the rule that the file gives would fill more, a warning says so.
//! - Strokes are passed over: a `line` has no area. A contour that is not closed is closed by
//!   a straight side, as fillings are by the standard, with a warning; OpenSCAD draws
//!   its stroke instead. If it has `fill="none"` it is left out.
//! - An `A` command whose radius is half the distance of its ends, but for what the decimals of the
//!   path do not tell (2 units of the last, and 1e-5 of itself), is half a circle or ellipse; and so are two
//!   that make a whole one (1e-2), as circles are often written.
//! - What has `display: none`, or `visibility: hidden`, is left out. An element that is selected by
//!   its `id`, or a layer of Inkscape's, is there even if what it is in is not displayed.
//! - The result is in millimetres, with y up and the lower left corner of the page at the origin.
//!   `mm`, `cm`, `in`, `pt` (1/72 in), `pc` and `px` (1/96 in) of the page's width and height are
//!   what they say; a number without a unit is one of [`ProfileOptions::dpi`] to the inch, and
//!   so is one of the view box where the page has no size. Without a view box a unit of the file
//!   is a millimetre, as in OpenSCAD, where the standard has 1/96 in; a warning says so.
//!
//! # DXF
//! - Read are `LINE`, `ARC`, `CIRCLE`, `LWPOLYLINE`, `POLYLINE`, `ELLIPSE`, `SPLINE` by control
//!   points, and `INSERT` of blocks. Others are named in a warning, and so is what does not
//!   lie in the plane of the drawing. Heights are passed over.
//! - The unit is the drawing's, whichever it is.
//! - The shape is what all closed contours enclose by the even-odd rule. Lines and arcs whose ends
//!   are nearer than 1e-5 of the drawing's longer side make contours; where they do not
//!   meet to 1e-9 of it a warning says how far the ends were apart. One that stays open is
//!   closed by a straight side, as OpenSCAD does, with a warning that says how wide and where it is
//!   open. What is drawn twice counts once, with a warning.
//! - A layer is that of the entity; of a block's contents, that of the `INSERT`, as in OpenSCAD.
//!   Layers that are switched off are read.
//!
//! OpenSCAD passes over bulges, splines and the base points of blocks, which are read here.
//!
//! # Libraries
//! `roxmltree` gives the tree that `use` looks up, with places for errors, and bounds entities;
//! `svgtypes` keeps arcs, which `usvg` makes curves of. DXF is read by a loop over group codes here: the
//! crate `dxf` depends on pictures, calendars and another XML reader, and has no lines for errors.

mod curves;
mod dxf;
mod ellipses;
mod svg;
mod warnings;

use std::ffi::OsStr;
use std::path::Path;

use csg::{FillRule, Profile};
use glam::{DAffine2, DVec2};

use self::curves::{Cutting, Loop, Outline, loop_bounds, loop_path};
use self::ellipses::by_ellipses;
use self::warnings::Warnings;
use crate::contents::Contents;
use crate::drawing::DrawingFormat;
use crate::scene::Fineness;
use crate::{Error, step};

/// Of the drawing's longer side, how far chords stray unless said otherwise.
const TOLERANCE: f64 = 1e-4;
/// The most bytes of a file.
const MOST_BYTES: u64 = 1 << 26;
/// The most sides of all contours, and elements or entities, those of copies included.
const MOST_SIDES: usize = 1 << 20;

/// Choices in reading a drawing.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ProfileOptions {
    /// Only what is on this layer: one of Inkscape's by its label in SVG.
    pub layer: Option<String>,
    /// SVG: only the element of this `id`; with a layer, if it is on that.
    pub id: Option<String>,
    /// SVG: how many units without a name an inch has: 72.
    pub dpi: f64,
    /// DXF: this point of the drawing becomes the origin, before it is scaled.
    pub origin: DVec2,
    /// DXF: the drawing is scaled by this.
    pub scale: f64,
    /// Whether the middle of the shape's bounds becomes the origin.
    pub center: bool,
    /// How far chords may stray from curves that are neither arcs nor parabolas, in the result's unit:
    /// 1e-4 of the
    /// longer side of what is drawn unless given.
    pub tolerance: Option<f64>,
    /// All arcs and curves as OpenSCAD's chords.
    pub(crate) fineness: Option<Fineness>,
}

impl Default for ProfileOptions {
    fn default() -> Self {
        Self {
            layer: None,
            id: None,
            dpi: 72.0,
            origin: DVec2::ZERO,
            scale: 1.0,
            center: false,
            tolerance: None,
            fineness: None,
        }
    }
}

impl ProfileOptions {
    /// The same options with only one layer.
    #[must_use]
    pub fn layer(mut self, layer: impl Into<String>) -> Self {
        self.layer = Some(layer.into());
        self
    }

    /// The same options with only one element.
    #[must_use]
    pub fn id(mut self, id: impl Into<String>) -> Self {
        self.id = Some(id.into());
        self
    }

    /// The same options with another number of units to the inch.
    #[must_use]
    pub fn dpi(mut self, dpi: f64) -> Self {
        self.dpi = dpi;
        self
    }

    /// The same options with another origin.
    #[must_use]
    pub fn origin(mut self, origin: impl Into<DVec2>) -> Self {
        self.origin = origin.into();
        self
    }

    /// The same options with another scale.
    #[must_use]
    pub fn scale(mut self, scale: f64) -> Self {
        self.scale = scale;
        self
    }

    /// The same options with the shape centred, or not.
    #[must_use]
    pub fn center(mut self, center: bool) -> Self {
        self.center = center;
        self
    }

    /// The same options with another tolerance.
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }
}

/// What a drawing is read as.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ReadProfile {
    /// [`Profile::empty`] if nothing in the drawing has an area.
    pub profile: Profile,
    /// What was left out, taken for something else or mended, each with where it is first.
    pub warnings: Vec<String>,
    /// How far chords stray from curves that are neither arcs of circles nor parabolas, if there are
    /// such.
    pub strays: Option<f64>,
    /// How many sides it has.
    pub(crate) sides: usize,
}

/// Reads a flat shape from an SVG or DXF file ([the module](self) says how); its warnings are
/// passed over, which [`read_profile_with`] gives.
///
/// ```no_run
/// let profile = io::read_profile("plate.dxf")?;
/// let solid = csg::Solid::extrude(&profile, 0.0..3.0);
/// # Ok::<(), io::Error>(())
/// ```
///
/// # Errors
/// As [`read_profile_with`].
pub fn read_profile(path: impl AsRef<Path>) -> Result<Profile, Error> {
    Ok(read_profile_with(path, &ProfileOptions::default())?.profile)
}

/// [`read_profile`] with other options, and with warnings. The file must be a regular one of at
/// most 64 MiB, and must not be written to meanwhile; no other is read. Time is that of
/// the text and n log n of the sides.
///
/// # Errors
/// [`Error::UnknownProfile`]; [`Error::MalformedDrawing`] with the line and element of what is
/// damaged or too much; what the operating system refuses.
pub fn read_profile_with(
    path: impl AsRef<Path>,
    options: &ProfileOptions,
) -> Result<ReadProfile, Error> {
    let path = path.as_ref();
    let read = || {
        let format = format_of(path)?;
        let refused = Error::file("read", path);
        match std::fs::metadata(path) {
            Ok(about) if about.is_file() && about.len() > MOST_BYTES => {
                return Err(too_large(format, about.len()));
            }
            _ => {}
        }
        let data = Contents::of(path).map_err(refused)?;
        match format {
            DrawingFormat::Dxf => read_dxf(&data, options),
            _ => read_svg(&data, options),
        }
    };
    read().map_err(|error: Error| error.in_file(path))
}

/// Whether a file's extension is of a drawing that can be read.
pub(crate) fn is_flat(path: &Path) -> bool {
    format_of(path).is_ok()
}

fn format_of(path: &Path) -> Result<DrawingFormat, Error> {
    let extension = path.extension().and_then(OsStr::to_str);
    match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("svg") => Ok(DrawingFormat::Svg),
        Some("dxf") => Ok(DrawingFormat::Dxf),
        _ if step::is_step(path) => Err(Error::StepOfMesh {
            path: path.to_owned(),
        }),
        _ => Err(Error::UnknownProfile {
            path: path.to_owned(),
        }),
    }
}

fn too_large(format: DrawingFormat, bytes: u64) -> Error {
    let most = MOST_BYTES >> 20;
    malformed(
        format,
        "the file".to_owned(),
        format!("its {bytes} bytes are more than {most} MiB: leave out what is not needed"),
    )
}

fn malformed(format: DrawingFormat, place: String, problem: impl Into<String>) -> Error {
    Error::MalformedDrawing {
        format,
        place,
        problem: problem.into(),
    }
}

/// Reads an SVG document in UTF-8.
///
/// # Errors
/// [`Error::MalformedDrawing`].
pub fn read_svg(data: &[u8], options: &ProfileOptions) -> Result<ReadProfile, Error> {
    check(DrawingFormat::Svg, data, options)?;
    let mut warnings = Warnings::default();
    let steps = svg::steps(data, options, &mut warnings)?;
    finished(DrawingFormat::Svg, &steps, options, warnings)
}

/// Reads a DXF document as text, of any version.
///
/// # Errors
/// [`Error::MalformedDrawing`].
pub fn read_dxf(data: &[u8], options: &ProfileOptions) -> Result<ReadProfile, Error> {
    check(DrawingFormat::Dxf, data, options)?;
    let mut warnings = Warnings::default();
    let steps = dxf::steps(data, options, &mut warnings)?;
    finished(DrawingFormat::Dxf, &steps, options, warnings)
}

fn check(format: DrawingFormat, data: &[u8], options: &ProfileOptions) -> Result<(), Error> {
    if data.len() as u64 > MOST_BYTES {
        return Err(too_large(format, data.len() as u64));
    }
    let is_size = |value: f64| value > 0.0 && value.is_finite();
    for (name, value) in [("dpi", options.dpi), ("scale", options.scale)] {
        if !is_size(value) {
            let problem = format!("the {name} is {value}: give one above 0");
            return Err(malformed(format, "the options".to_owned(), problem));
        }
    }
    match options.tolerance {
        Some(tolerance) if !is_size(tolerance) => Err(Error::DrawingTolerance { tolerance }),
        _ => Ok(()),
    }
}

/// A part of the shape, in the coordinates of the result but for its centre.
enum Figure {
    /// What contours enclose by the even-odd rule; what the file says of it, for warnings.
    Contours(Vec<Outline>, FillRule),
    /// The image of the disc of radius 1, without what others make up.
    Disc(DAffine2, Vec<Step>),
}

/// A figure that is added to those before it, or taken from them.
struct Step {
    figure: Figure,
    is_hole: bool,
}

impl Step {
    fn added(figure: Figure) -> Self {
        Self {
            figure,
            is_hole: false,
        }
    }
}

impl Figure {
    /// Adds points whose hull holds it.
    fn reach(&self, bounds: &mut Bounds) {
        match self {
            Self::Contours(outlines, _) => {
                let points = outlines.iter().flat_map(Outline::hull);
                points.for_each(|point| bounds.add(point));
            }
            // (What is taken from it is within.)
            Self::Disc(map, _) => {
                disc_bounds(map)
                    .into_iter()
                    .for_each(|point| bounds.add(point));
            }
        }
    }
}

fn whole() -> String {
    "the drawing".to_owned()
}

/// What steps come to.
fn finished(
    format: DrawingFormat,
    steps: &[Step],
    options: &ProfileOptions,
    mut warnings: Warnings,
) -> Result<ReadProfile, Error> {
    const LARGEST: f64 = 1e100;
    let mut size = Bounds::default();
    steps.iter().for_each(|step| step.figure.reach(&mut size));
    let [low, high] = size.0.unwrap_or_default();
    let side = (high - low).max_element();
    // (Not a number is too large, too.)
    if !(side < LARGEST && low.abs().max(high.abs()).max_element() < LARGEST) {
        let problem = "its coordinates are too large";
        return Err(malformed(format, whole(), problem));
    }
    let mut making = Making {
        format,
        side,
        cutting: Cutting {
            tolerance: options.tolerance.unwrap_or(TOLERANCE * side),
            fineness: options.fineness,
            of_svg: format == DrawingFormat::Svg,
            sides: 0,
            has_cut: false,
        },
        bounds: Bounds::default(),
        warnings: &mut warnings,
    };
    let mut profile = making.made(steps)?;
    let Making {
        cutting, bounds, ..
    } = making;
    let strays = (cutting.has_cut && cutting.fineness.is_none()).then_some(cutting.tolerance);
    if let Some(within) = strays {
        let problem = format!(
            "curves that are neither arcs of circles nor parabolas are taken for chords within {within:.1e}"
        );
        warnings.add(whole, problem);
    }
    if let Some([low, high]) = bounds.0.filter(|_| options.center) {
        profile = profile.translate(-low.midpoint(high));
    }
    if let Some(fault) = profile.fault() {
        return Err(malformed(format, whole(), fault.to_string()));
    }
    Ok(ReadProfile {
        profile,
        warnings: warnings.told(),
        strays,
        sides: cutting.sides,
    })
}

/// What is needed to make a profile of steps.
struct Making<'a> {
    format: DrawingFormat,
    /// The longer one of the drawing.
    side: f64,
    cutting: Cutting,
    /// Of what is made.
    bounds: Bounds,
    warnings: &'a mut Warnings,
}

impl Making<'_> {
    fn made(&mut self, steps: &[Step]) -> Result<Profile, Error> {
        let mut profile = Profile::empty();
        let mut added = Vec::new();
        for step in steps {
            let figure = self.figure(&step.figure)?;
            if step.is_hole {
                profile = Profile::union([profile].into_iter().chain(added.drain(..))) - figure;
            } else {
                added.push(figure);
            }
        }
        Ok(match (profile == Profile::empty(), added.len()) {
            (true, 1) => added.remove(0),
            (true, _) => Profile::union(added),
            (false, 0) => profile,
            (false, _) => Profile::union([profile].into_iter().chain(added)),
        })
    }

    fn figure(&mut self, figure: &Figure) -> Result<Profile, Error> {
        match figure {
            Figure::Contours(outlines, rule) => self.contours(outlines, *rule),
            Figure::Disc(map, without) => {
                let corners = disc_bounds(map).into_iter();
                corners.for_each(|point| self.bounds.add(point));
                let disc = match self.cutting.disc(map) {
                    Some(corners) => Profile::paths([loop_path(&corners)], FillRule::EvenOdd),
                    None => Profile::circle(1.0).affine(*map),
                };
                Ok(if without.is_empty() {
                    disc
                } else {
                    disc - self.made(without)?
                })
            }
        }
    }

    fn contours(&mut self, outlines: &[Outline], rule: FillRule) -> Result<Profile, Error> {
        // (OpenSCAD has other numbers for arcs of paths than for discs.)
        if !self.cutting.of_svg || self.cutting.fineness.is_none() {
            let steps = by_ellipses(outlines.to_vec(), 0);
            if steps.len() > 1 {
                let mut cutting = Cutting::within(self.cutting.tolerance);
                let loops = self.loops(outlines, &mut cutting)?;
                let profile = self.made(&steps)?;
                self.check_rule(&loops, rule);
                return Ok(profile);
            }
        }
        let mut cutting = self.cutting;
        let loops = self.loops(outlines, &mut cutting)?;
        self.cutting = cutting;
        let points = loops.iter().flat_map(loop_bounds);
        points.for_each(|point| self.bounds.add(point));
        if loops.is_empty() {
            return Ok(Profile::empty());
        }
        self.check_rule(&loops, rule);
        Ok(Profile::paths(
            loops.iter().map(loop_path),
            FillRule::EvenOdd,
        ))
    }

    /// Outlines as lines, arcs and parabolas, and chords for other curves.
    fn loops(&self, outlines: &[Outline], cutting: &mut Cutting) -> Result<Vec<Loop>, Error> {
        let mut loops: Vec<Loop> = Vec::with_capacity(outlines.len());
        for outline in outlines {
            let Some(made) = cutting.contour(outline) else {
                let problem = format!("it has more than {MOST_SIDES} sides: raise the tolerance");
                return Err(malformed(self.format, whole(), problem));
            };
            loops.extend(made);
        }
        Ok(loops)
    }

    /// Warns where the file's rule fills more than the one by which all is read.
    fn check_rule(&mut self, loops: &[Loop], rule: FillRule) {
        /// Of an area, what is not told apart.
        const SAME: f64 = 1e-6;
        if rule == FillRule::EvenOdd {
            return;
        }
        let tolerance = 1e-2 * self.side;
        let area = |rule| Profile::paths(loops.iter().map(loop_path), rule).area(tolerance);
        if let [Ok(filled), Ok(told)] = [area(FillRule::EvenOdd), area(rule)]
            && (filled - told).abs() > SAME * told
        {
            let problem = "its contours overlap where the file's fill-rule, nonzero, fills them: \
                           they are read by the even-odd rule, as OpenSCAD does";
            self.warnings.add(whole, problem.to_owned());
        }
    }
}

/// Opposite corners of the box around the image of the disc of radius 1.
fn disc_bounds(map: &DAffine2) -> [DVec2; 2] {
    let [x, y] = [map.matrix2.x_axis, map.matrix2.y_axis];
    let reach = (x * x + y * y).map(f64::sqrt);
    [map.translation - reach, map.translation + reach]
}

/// The least and the greatest coordinates of some points.
#[derive(Default)]
struct Bounds(Option<[DVec2; 2]>);

impl Bounds {
    fn add(&mut self, point: DVec2) {
        let [low, high] = self.0.unwrap_or([point; 2]);
        // (Not a number stays one.)
        let low = DVec2::select(point.cmpge(low), low, point);
        let high = DVec2::select(point.cmple(high), high, point);
        self.0 = Some([low, high]);
    }
}
