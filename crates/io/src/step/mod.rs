//! STEP (ISO 10303): solids with exact surfaces, for other CAD systems. Written only.
//!
//! Planes, spheres, cylinders and cones, lines and conics are what they are; elliptic cylinders are
//! extruded, and paraboloids and hyperboloids of revolution, and ellipsoids of revolution that are
//! whole, turned conics. Other ellipsoids, paraboloids and hyperboloids, and elliptic cones, are
//! rational B-splines, which have the same points. Curves of degree four, in which two of them meet,
//! are B-splines that stray from both by no more than [`StepOptions::tolerance`].
//!
//! Edges that are no lines have their images on the surfaces beside them, as curves of the surfaces'
//! parameters, which stray by no more than that either: other programs take areas and volumes within
//! them, and without them lay some through a few points. They are left out where a reader finds them
//! without error, as of circles around an axis, and on surfaces of revolution.
//!
//! Faces are those of a boundary that was cut at seams
//! ([`csg::BoundaryOptions::cut_at_seams`]): those of cylinders and cones at one line, whole
//! spheres at one meridian, others so that none closes on itself, and none has a pole inside. A
//! whole ellipsoid of revolution is put together again here, and cut at one meridian; so are
//! paraboloids and hyperboloids of two sheets, of revolution, around a pole, if no edge is nearer to
//! their axis than 1 mm. Of a sphere what lies between circles around one axis, or beyond one, is a face
//! without a seam.
//!
//! Where a shell touches itself its vertices at one place are one in the file.

mod cap;
mod chart;
mod curves;
mod image;
mod patches;
mod product;
mod scaled;
mod spheroid;
mod surfaces;
mod telling;
mod text;
mod topology;
mod zone;

use std::ffi::OsStr;
use std::io::Write;
use std::path::Path;

use csg::brep::Face;
use csg::{Brep, LengthUnit};
use glam::DVec3;
use rustc_hash::FxHashMap;

use self::curves::Stray;
use self::product::{Product, Products, Styles};
use self::text::{Entities, Id};
use self::topology::Topology;
use crate::parts::Names;
use crate::tree::tree;
use crate::{AtomicFile, Error};

/// Which part of the standard a file follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum StepSchema {
    /// AP242, managed model based 3D engineering.
    #[default]
    Ap242,
    /// AP214, automotive design, for older programs.
    Ap214,
}

/// Choices in writing.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepOptions {
    /// The product's name.
    pub name: String,
    /// The unit of the model's lengths.
    pub unit: LengthUnit,
    /// The schema.
    pub schema: StepSchema,
    /// How far B-splines may stray from curves of degree four, and images of edges from the edges,
    /// in the model's unit:
    /// 1e-9 of the diagonal of a box around the solid unless given, and up to 1e-7 from curves that are
    /// not known as well, along which surfaces nearly touch.
    pub tolerance: Option<f64>,
}

impl Default for StepOptions {
    fn default() -> Self {
        Self {
            name: "part".to_owned(),
            unit: LengthUnit::default(),
            schema: StepSchema::default(),
            tolerance: None,
        }
    }
}

impl StepOptions {
    /// The same options with another name of the product.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// The same options with another unit.
    #[must_use]
    pub fn unit(mut self, unit: LengthUnit) -> Self {
        self.unit = unit;
        self
    }

    /// The same options with another schema.
    #[must_use]
    pub fn schema(mut self, schema: StepSchema) -> Self {
        self.schema = schema;
        self
    }

    /// The same options with another tolerance.
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }
}

/// How far B-splines and images stray from curves unless said otherwise, of the solid's size.
const TOLERANCE: f64 = 1e-9;

/// To what files say they are exact, of the solid's size.
const ACCURACY: f64 = 1e-7;

/// Writes a boundary that was cut at seams: one solid for each body, with the
/// voids in it. Faces are named and coloured as the primitives that they come from; a body
/// whose faces have one name around them or one colour has it, too. Where bodies differ in their
/// names, each name is a product, put together from those within it ([`csg::Solid::named`]);
/// else there is one product.
///
/// ```
/// use csg::{BoundaryOptions, Program, Solid};
/// use io::step::{StepOptions, write_step};
///
/// let solid = Solid::cube(2.0) - Solid::cylinder(0.5, -2.0..2.0);
/// let options = BoundaryOptions::new().cut_at_seams();
/// let brep = Program::lower(&solid)?.boundary(&options)?;
/// let mut file = Vec::new();
/// write_step(&brep, &StepOptions::default().name("block"), &mut file)?;
/// let text = String::from_utf8(file)?;
/// assert_eq!(text.matches("CYLINDRICAL_SURFACE").count(), 1);
/// assert_eq!(text.matches("MANIFOLD_SOLID_BREP").count(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Error::EmptySolid`]; [`Error::NotInStep`] for a boundary that was not cut at seams, a
/// tolerance that is not above 0 or cannot be kept; failed writing.
pub fn write_step(brep: &Brep, options: &StepOptions, out: &mut impl Write) -> Result<(), Error> {
    if brep.is_empty() {
        return Err(Error::EmptySolid);
    }
    if !brep.is_cut_at_seams() {
        return Err(Error::NotInStep {
            problem: "its faces close on themselves: evaluate it with \
                      BoundaryOptions::cut_at_seams"
                .to_owned(),
        });
    }
    let size = size(brep);
    let tolerance = options.tolerance.unwrap_or(TOLERANCE * size);
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(Error::NotInStep {
            problem: format!("the tolerance is {tolerance}: give one above 0"),
        });
    }
    let mut entities = Entities::default();
    let to = &mut entities;
    let accuracy = tolerance.max(ACCURACY * size);
    let context = product::context(to, options.unit, accuracy);
    let stray = Stray {
        usual: tolerance,
        most: options.tolerance.unwrap_or(accuracy),
    };
    let (mut topology, mut styles) = (Topology::new(options.unit), Styles::new());
    let mut parts: Vec<(Names<'_>, Vec<Id>)> = Vec::new();
    let mut numbers: FxHashMap<Names<'_>, usize> = FxHashMap::default();
    for shells in brep.bodies() {
        let faces = || shells.iter().flat_map(csg::brep::Shell::faces);
        let names = common_names(faces());
        let name = names.last().copied().unwrap_or(&options.name);
        let body = topology.body(to, (name, &shells), stray)?;
        let faces: Vec<_> = faces()
            .map(|face| (topology.faces[&face.id().index()], face))
            .collect();
        styles.paint(to, body, &faces);
        let part = *numbers.entry(names).or_insert_with_key(|names| {
            parts.push((names.clone(), Vec::new()));
            parts.len() - 1
        });
        parts[part].1.push(body);
    }
    write_products(to, (options, context), &parts);
    styles.finish(to, context);
    write!(
        out,
        "ISO-10303-21;\n{}DATA;\n{}ENDSEC;\nEND-ISO-10303-21;\n",
        product::header(options),
        entities.into_text()
    )?;
    Ok(())
}

/// The names that all faces have around them, the outermost first.
fn common_names<'a>(mut faces: impl Iterator<Item = Face<'a>>) -> Names<'a> {
    let names = |face: Face<'a>| {
        let origin = face.origin();
        origin.parts.iter().chain(&origin.name).map(AsRef::as_ref)
    };
    let mut common: Names<'a> = faces
        .next()
        .map_or(Vec::new(), |face| names(face).collect());
    for face in faces {
        let pairs = common.iter().copied().zip(names(face));
        let count = pairs.take_while(|(a, b)| a == b).count();
        common.truncate(count);
    }
    common
}

/// One product of all bodies, or, where they are of several parts, one for each part, and for
/// each name around parts one that is put together from these.
fn write_products(
    to: &mut Entities,
    (options, context): (&StepOptions, Id),
    parts: &[(Names<'_>, Vec<Id>)],
) {
    let products = Products::new(to, options.schema, context);
    if let [(_, bodies)] = parts {
        products.of_bodies(to, &options.name, bodies);
        return;
    }
    let tree = tree(parts.iter().map(|(names, _)| &names[..]));
    let mut done: Vec<Option<Product>> = vec![None; tree.len()];
    // What is within others comes after them there, and before them here.
    for (index, branch) in tree.iter().enumerate().rev() {
        let name = if index == 0 {
            &options.name
        } else {
            branch.name
        };
        let own = branch
            .part
            .map(|part| products.of_bodies(to, name, &parts[part].1));
        let mut inner: Vec<Product> = own.into_iter().collect();
        inner.extend(branch.inner.iter().filter_map(|&inner| done[inner]));
        done[index] = own
            .filter(|_| branch.inner.is_empty())
            .or_else(|| Some(products.of_products(to, name, &inner)));
    }
}

/// Writes a file of a boundary that was cut at seams, replaced whole or not at all
/// ([`AtomicFile`]): see [`write_step`].
///
/// # Errors
/// As [`write_step`], with the file's name; what the operating system refuses.
pub fn write_step_file(
    path: impl AsRef<Path>,
    brep: &Brep,
    options: &StepOptions,
) -> Result<(), Error> {
    let path = path.as_ref();
    let write = || {
        let mut file = AtomicFile::create(path)?;
        write_step(brep, options, &mut file)?;
        file.commit()
    };
    write().map_err(|error| error.in_file(path))
}

/// Whether a file's name says that it is a STEP file: `.step` or `.stp`.
#[must_use]
pub fn is_step(path: impl AsRef<Path>) -> bool {
    let extension = path.as_ref().extension().and_then(OsStr::to_str);
    let is = |known: &str| extension.is_some_and(|found| found.eq_ignore_ascii_case(known));
    is("step") || is("stp")
}

/// The diagonal of a box around points of all edges.
fn size(brep: &Brep) -> f64 {
    let points = brep.edges().flat_map(|edge| {
        let [from, to] = edge.range();
        [from, 0.5 * (from + to), to].map(|t| edge.at(t))
    });
    let (low, high) = points.fold(
        (DVec3::INFINITY, DVec3::NEG_INFINITY),
        |(low, high), point| (low.min(point), high.max(point)),
    );
    low.distance(high)
}
