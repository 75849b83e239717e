//! Scenes: OpenSCAD's evaluated tree text (`.csg`), in and out.
//!
//! The nodes of the core are read and written: `group`, `union`,
//! `difference`, `intersection`, `multmatrix`, `color`, `render`, `cube`,
//! `sphere`, `cylinder`. Read are as well `polyhedron`, `circle`, `square`,
//! `polygon`, `text`, `import` (of meshes, and of drawings in SVG and DXF), `surface` (of numbers, and of
//! PNG pictures),
//! `linear_extrude`, `rotate_extrude`, `offset`, `projection`, `hull`,
//! `minkowski` (of solids) and `resize`; and, for scenes that are written by hand, `translate`, `rotate`,
//! `scale` and `mirror`. Any other node is an error that names it
//! and its place, unless `%` (background) leaves it out of the solid anyway.
//!
//! ```
//! use io::scene::{ReadOptions, read, write};
//!
//! let text = "difference() { cube(size = [2, 2, 2], center = true); sphere(r = 1.2); }";
//! let solid = read(text, &ReadOptions::default())?.solid;
//! let program = csg::Program::lower(&solid)?;
//! assert!(program.contains([0.9, 0.9, 0.9]) && !program.contains([0.0; 3]));
//! assert!(write(&solid)?.starts_with("difference() {"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What the text means
//! - A list of siblings (the roots, the children of `group`, `multmatrix`,
//!   `color`, `render`) is their union. Nothing but empty children is empty.
//! - Circles: `0 < $fn <= 12` means a polygon on purpose. Anything else is a
//!   true circle, a true sphere, a true cone; with [`ReadOptions::faceted`]
//!   it is the polygon or polyhedron that OpenSCAD would make of it.
//! - A primitive with a size that is not positive or not finite has no points,
//!   and so has whatever a map with an infinite or NaN entry or without an
//!   inverse makes of its operand. That is OpenSCAD's rule; the reader says
//!   so in [`Scene::warnings`].
//! - Profiles stay as they are drawn: what is extruded or turned has planes,
//!   cylinders and cones. A circle turned about an axis beside it is cut into 32
//!   chords or more first, a twist and circles that are scaled unevenly into flat faces within
//!   3e-4 of the size if these are not too many, with warnings that say how near they are. Offsets
//!   have the arcs of what they move and of its corners; of ellipses, and where rounding leaves
//!   open what meets, chords are moved, with a warning. [`ReadOptions::within`] says how near all
//!   of these are to be.
//! - `text` is drawn in the font it names, or in Liberation Sans with a warning
//!   if that one is not installed; its curves become chords within a thousandth
//!   of the size (faceted: as many as OpenSCAD takes). A warning names characters that the font
//!   has no glyph for.
//! - `linear_extrude` goes along `v`, as far as that is long, or `height`, as in newer versions of
//!   OpenSCAD.
//! - Sections are exact where they have lines, circles and whole ellipses.
//! - Hulls, Minkowski sums, projections, other sections and `resize` need corners: what is in
//!   them is meshed while reading, circles in hulls and sums as polygons of at least 30
//!   corners, which a warning says, as of what else is curved. A hull of nothing but
//!   spheres (equal, or at most 24) is exact, and so is one of circles and polygons, or of
//!   cylinders, cones and frusta with parallel axes and of what has flat faces, if it has at most
//!   48 planes and cones and is meshed without doubt; and a Minkowski sum of spheres and of what
//!   has flat faces and few corners, or of a flat shape and circles. How many cells and corners
//!   all of them together may cost is bounded; more is an error.
//! - Of profiles and solids in one list those unlike the first are left out,
//!   with a warning; an intersection of both has no points.
//! - The faces of a `polyhedron` must close; if they are inside out they are
//!   turned, with a warning, and if they close only on OpenSCAD's grid of
//!   2^-20, vertices move onto it.
//! - Files that `import` and `surface` name lie beside the scene or below, unless
//!   others are allowed. An imported mesh must bound a solid; if it is inside out it
//!   is turned, with a warning. Objects of one file that touch, overlap or lie in each other are
//!   united.
//! - Lengths are in one unit, the millimetre where nothing else is said ([`ReadOptions::unit`]):
//!   those of imported 3MF and glTF files, which have their own, are converted into it, with a
//!   warning where that changes numbers. Other formats have no unit; their numbers are taken as
//!   they are.
//! - An imported drawing ([`crate::profile`] says what is read) keeps its lines, arcs and circles;
//!   other curves become chords within 1e-4 of its size, with a warning. `layer`, `id`, `dpi`, `center`
//!   mean what they do in OpenSCAD, and so do `origin` and `scale`, in DXF.
//! - What an evaluated tree does not have means what it does in OpenSCAD's language:
//!   `translate([x, y, z])`, `rotate([x, y, z])` (degrees about X, then Y, then Z), `rotate(a, [x, y, z])`
//!   (about an axis), `scale`, `mirror`; radii `r` and diameters `d`, of `cylinder` `d1` and `d2` as well; one
//!   size for all sides of a cube or square; the first arguments without their names (`cube([1, 2, 3])`,
//!   `cylinder(4, 1, 1)`); and one child without braces. But there are no variables, and sizes must be given.
//! - Colours are sRGB, and the outermost wins. `color([-1, -1, -1, a])` is
//!   OpenSCAD's "no colour" and sets none. A face cut by a subtracted
//!   primitive shows that primitive's colour, as in OpenSCAD's preview.

mod arguments;
mod build;
mod error;
mod facets;
mod flat;
mod imports;
mod lettering;
mod lex;
mod operations;
mod parse;
mod pieces;
mod placing;
mod polyhedra;
mod primitives;
mod relief;
mod shapes;
mod values;
mod write;

use std::path::{Path, PathBuf};

use csg::{LengthUnit, Solid};

use crate::contents::Contents;

pub(crate) use facets::Fineness;

pub use error::{Place, SceneError, Warning};
pub use write::{WriteError, write};

/// How to read a scene.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Read every circle, sphere and cone as the polygon or polyhedron that
    /// OpenSCAD makes of it under `$fn`, `$fa` and `$fs`.
    pub faceted: bool,
    /// Files of fonts that `text` may name beside those installed.
    pub fonts: Vec<PathBuf>,
    /// Where the files lie that `import` and `surface` name: that of the scene,
    /// where nothing else is said. Without one (a scene that is not read from a
    /// file) such nodes are errors.
    pub folder: Option<PathBuf>,
    /// Whether they may name files in any folder, and not only in that one and
    /// below.
    pub any_folder: bool,
    /// Whether imported meshes that bound no solid are mended, with a warning that says
    /// what was changed ([`Solid::repaired`]).
    pub repair: bool,
    /// The unit of the scene's lengths, into which those of imported 3MF and glTF files are
    /// converted; others have none and are taken as they are.
    pub unit: LengthUnit,
    /// How far chords and flat faces may stray that stand for what there are no surfaces for, in
    /// the scene's unit: shares of sizes, told by warnings, where nothing else is said. How
    /// far they do tells [`Solid::strays`].
    pub within: Option<f64>,
}

impl ReadOptions {
    /// The same options with circles as OpenSCAD's polygons, or not.
    #[must_use]
    pub fn faceted(mut self, faceted: bool) -> Self {
        self.faceted = faceted;
        self
    }

    /// The same options with one more file of fonts.
    #[must_use]
    pub fn font(mut self, file: impl Into<PathBuf>) -> Self {
        self.fonts.push(file.into());
        self
    }

    /// The same options with the folder of imported files.
    #[must_use]
    pub fn folder(mut self, folder: impl Into<PathBuf>) -> Self {
        self.folder = Some(folder.into());
        self
    }

    /// The same options with files of any folder allowed, or not.
    #[must_use]
    pub fn any_folder(mut self, any_folder: bool) -> Self {
        self.any_folder = any_folder;
        self
    }

    /// The same options with imported meshes mended, or not.
    #[must_use]
    pub fn repair(mut self, repair: bool) -> Self {
        self.repair = repair;
        self
    }

    /// The same options with chords and flat faces within a distance, in the scene's unit, of what
    /// they stand for.
    #[must_use]
    pub fn within(mut self, distance: f64) -> Self {
        self.within = Some(distance);
        self
    }

    /// The same options with another unit of the scene's lengths.
    #[must_use]
    pub fn unit(mut self, unit: LengthUnit) -> Self {
        self.unit = unit;
        self
    }
}

/// What a scene text says.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scene {
    /// The union of the roots; [`Solid::empty`] where there is nothing.
    pub solid: Solid,
    /// Nodes that have no points because of their arguments.
    pub warnings: Vec<Warning>,
}

/// Reads a scene. Time and memory are linear in the text (in faceted mode:
/// and in the number of facets), and no depth of nesting overflows the stack.
///
/// # Errors
/// [`SceneError`] says in which line and column the text is not a scene, or
/// which of its nodes or arguments cannot be read.
pub fn read(text: &str, options: &ReadOptions) -> Result<Scene, SceneError> {
    build::build(&parse::parse(text)?, options)
}

/// Reads a scene file in UTF-8; errors name the file.
///
/// # Errors
/// As [`read`]; [`SceneError::Io`] if the file cannot be read, and
/// [`SceneError::NotUtf8`] if it is not text.
pub fn read_file(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    let bytes = Contents::of(path).map_err(|source| SceneError::Io {
        path: path.to_owned(),
        source,
    })?;
    let mut options = options.clone();
    if options.folder.is_none() {
        options.folder = path.parent().map(Path::to_owned);
    }
    let mut scene = read_bytes(&bytes, &options).map_err(|error| error.in_file(path))?;
    for warning in &mut scene.warnings {
        warning.place.file = Some(path.to_owned());
    }
    Ok(scene)
}

/// Reads a scene from bytes that should be UTF-8, as from a pipe.
///
/// # Errors
/// As [`read`]; [`SceneError::NotUtf8`] if the bytes are not text.
pub fn read_bytes(bytes: &[u8], options: &ReadOptions) -> Result<Scene, SceneError> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let (valid, _) = bytes.split_at(error.valid_up_to());
        let valid = String::from_utf8_lossy(valid);
        SceneError::NotUtf8 {
            place: Place::of(&valid, valid.len()),
        }
    })?;
    // Some editors begin a text with a byte order mark.
    read(text.strip_prefix('\u{feff}').unwrap_or(text), options)
}
