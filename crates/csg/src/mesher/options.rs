//! What a mesher is asked for.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::control::{Caller, CancelToken};
use crate::error::Error;
use crate::limits::Limits;
use crate::mesh::LengthUnit;
use crate::program::{Bounds, Program};
use crate::tessellate::Goal;

/// The most cells along one axis: indices and patience end there.
pub const MAX_CELLS: u32 = 1 << 16;

/// Turns programs into meshes.
///
/// ```
/// use csg::{Mesher, Program, Solid};
///
/// let solid = Solid::cube(1.5) & Solid::sphere(1.0);
/// let meshed = Mesher::new().cells(32).draft().mesh(&Program::lower(&solid)?)?;
/// assert!(meshed.report.check.is_closed());
/// // A ball without the six caps of height 1/4 that stick out of the cube.
/// assert!((meshed.mesh.volume() - 3.109).abs() < 0.02);
/// # Ok::<(), csg::Error>(())
/// ```
#[derive(Clone, Debug)]
#[must_use]
pub struct Mesher {
    resolution: Option<Resolution>,
    smallest_feature: Option<f64>,
    pub(super) method: Method,
    tolerance: Option<f64>,
    angle: Option<f64>,
    pub(super) bounds: Option<Bounds>,
    pub(super) unit: LengthUnit,
    pub(super) check: bool,
    pub(super) normals: bool,
    pub(super) feature_angle: Option<f64>,
    pub(super) limits: Limits,
    pub(super) caller: Caller,
}

/// How fine the cells are.
#[derive(Clone, Copy, Debug)]
enum Resolution {
    /// So many along the longest side of the bounds.
    Cells(u32),
    /// Of this side length.
    Size(f64),
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Method {
    Exact,
    Draft,
}

impl Default for Mesher {
    fn default() -> Self {
        Self::new()
    }
}

/// The tolerance unless another one is asked for, of the longest side of the bounds.
pub(super) const DEFAULT_TOLERANCE: f64 = 1e-3;

impl Mesher {
    /// To a [`Self::tolerance`] of a thousandth of the longest side of the solid's
    /// bounds, in millimetres; for a solid bounded by planes alone its exact
    /// boundary. That one is made with a tolerance, too, but not where
    /// [`Self::cells`], their size or a box are given. Drafts and solids in a box
    /// that was given have 128 cells along the longest side.
    pub fn new() -> Self {
        Self {
            resolution: None,
            smallest_feature: None,
            method: Method::Exact,
            tolerance: None,
            angle: None,
            bounds: None,
            unit: LengthUnit::default(),
            check: true,
            normals: false,
            feature_angle: None,
            limits: Limits::new(),
            caller: Caller::default(),
        }
    }

    /// As many cells along the longest side of the bounds, 1 to
    /// [`MAX_CELLS`]. Time and memory grow with the square of it.
    ///
    /// Meshes by cells are not tested for running through themselves, which takes some
    /// five times as long as they do: those of solids that touch themselves, as where the
    /// edge of one part runs along a face of another one, may, and
    /// [`Mesh::self_intersections`](crate::Mesh::self_intersections) tells. To a
    /// tolerance they are.
    pub fn cells(mut self, cells: u32) -> Self {
        self.resolution = Some(Resolution::Cells(cells));
        self
    }

    /// Cells of this side length, in model units.
    pub fn cell_size(mut self, size: f64) -> Self {
        self.resolution = Some(Resolution::Size(size));
        self
    }

    /// The largest distance between the mesh and the solid's boundary, both
    /// ways, in model units: the mesh is brought to it with just enough
    /// triangles, whatever the cells, which then only have to be fine enough
    /// to see every feature. [`Report::deviation`] says what was reached. With
    /// [`Self::check`] triangles that run through each other, where faces are
    /// nearer to each other than the tolerance, or that face into the solid, are
    /// cut up until none do, and else reported.
    ///
    /// Borders between colours or names on one surface are curves like any other: as
    /// near to where a second surface cuts it. Where cells have to do (`"adaptive"` or
    /// `"exact"` in [`Report::method`]) they are only as near as the cells are small.
    ///
    /// Not for drafts.
    ///
    /// [`Report::deviation`]: crate::Report::deviation
    /// [`Report::method`]: crate::Report::method
    pub fn tolerance(mut self, distance: f64) -> Self {
        self.tolerance = Some(distance);
        self
    }

    /// With a tolerance, its own or the default: the largest angle in radians, too, that a
    /// surface may turn along an edge of the mesh.
    pub fn angle(mut self, angle: f64) -> Self {
        self.angle = Some(angle);
        self
    }

    /// The draft quality: surface nets with one vertex a cell. Sharp edges
    /// are bevelled by up to a cell, the volume is off by a second-order
    /// term, and where two sheets pass through one cell the mesh has
    /// non-manifold edges, which the report counts. It is always closed.
    pub fn draft(mut self) -> Self {
        self.method = Method::Draft;
        self
    }

    /// Looks for features down to this size, in model units, with adaptive
    /// cells: as large as the solid is simple in them, and none smaller than
    /// this. With a [`Self::tolerance`] and without [`Self::cells`] that is how
    /// meshes are made; the smallest feature is then the tolerance, unless said
    /// otherwise.
    ///
    /// The mesh has the solid's topology, two sheets nearer to each other than
    /// a cell included, with few triangles: flat faces, straight edges and
    /// corners are exact, and without a tolerance curved faces come in chords
    /// as coarse as a sixth of a circle. What could not be resolved is
    /// reported. Costs some microseconds a cell.
    pub fn smallest_feature(mut self, size: f64) -> Self {
        self.smallest_feature = Some(size);
        self
    }

    /// A box known to contain the solid, in place of the one found from the
    /// program. A solid that reaches out of it is an error; parts that lie
    /// wholly outside are not seen.
    pub fn bounds(mut self, bounds: Bounds) -> Self {
        self.bounds = Some(bounds);
        self
    }

    /// The unit of the model's lengths, handed on to the mesh.
    pub fn unit(mut self, unit: LengthUnit) -> Self {
        self.unit = unit;
        self
    }

    /// Fills [`Mesh::corner_normals`] with exact normals: the gradient of each
    /// triangle's surface at its corners. 36 bytes a triangle.
    ///
    /// [`Mesh::corner_normals`]: crate::Mesh::corner_normals
    pub fn normals(mut self) -> Self {
        self.normals = true;
        self
    }

    /// Fills [`Mesh::feature_edges`] with the edges between different surfaces
    /// that meet at more than `angle` radians, as polylines.
    ///
    /// [`Mesh::feature_edges`]: crate::Mesh::feature_edges
    pub fn feature_edges(mut self, angle: f64) -> Self {
        self.feature_angle = Some(angle);
        self
    }

    /// Whether to check and measure the finished mesh (on by default), which
    /// takes about as long again as meshing; off, [`Report::check`] and the
    /// report's distances stay empty. A mesh to a tolerance, or one of planes, is
    /// held against the solid along some dozen to some hundred rays, too, which
    /// takes about 3% of the time: what differs by more than the tolerance is among
    /// [`Report::fallbacks`].
    ///
    /// [`Report::check`]: crate::Report::check
    /// [`Report::fallbacks`]: crate::Report::fallbacks
    pub fn check(mut self, check: bool) -> Self {
        self.check = check;
        self
    }

    /// Called with the share of the work that is done, 0 to 1, about once a
    /// percent, from whatever thread did it; two calls from different threads
    /// may overtake each other.
    pub fn progress(mut self, callback: impl Fn(f64) + Send + Sync + 'static) -> Self {
        self.caller.progress = Some(Arc::new(callback));
        self
    }

    /// A handle with which another thread may stop the work.
    pub fn cancel_token(mut self, token: CancelToken) -> Self {
        self.caller.cancel = token;
        self
    }

    /// How much a mesh may cost; as much as there is memory for, unless said otherwise.
    pub fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// The tolerance where nothing says how fine the mesh should be.
    pub(super) fn default_tolerance(&self, program: &Program) -> Result<Option<f64>, Error> {
        let is_sized = self.resolution.is_some()
            || self.smallest_feature.is_some()
            || self.tolerance.is_some()
            || self.bounds.is_some();
        if is_sized || matches!(self.method, Method::Draft) || program.is_polyhedral() {
            return Ok(None);
        }
        let size = program
            .bounds()?
            .map_or(0.0, |bounds| bounds.size().max_element());
        // A box without extent holds no solid.
        Ok(Some(DEFAULT_TOLERANCE * size).filter(|&tolerance| tolerance > 0.0))
    }

    pub(super) fn goal(&self) -> Result<Option<Goal>, Error> {
        let Some(tolerance) = self.tolerance else {
            return Ok(None);
        };
        if matches!(self.method, Method::Draft) {
            return Err(Error::InvalidOption(
                "a tolerance for a draft: it keeps none".into(),
            ));
        }
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(Error::InvalidOption(format!(
                "a tolerance of {tolerance}: give a positive distance"
            )));
        }
        if let Some(angle) = self.angle
            && !(angle > 0.0 && angle <= std::f64::consts::PI)
        {
            return Err(Error::InvalidOption(format!(
                "an angle of {angle}: give radians from 0 to pi"
            )));
        }
        Ok(Some(Goal {
            tight: FxHashMap::default(),
            tolerance,
            promised: tolerance,
            even_curves: false,
            keeps_vertices: false,
            angle: self.angle,
        }))
    }

    /// Whether the exact boundary of planes is to be meshed, without cells. It
    /// is that of the whole solid, not of what lies in a box that was given.
    pub(super) fn is_polyhedral(&self, program: &Program) -> bool {
        self.is_by_boundary() && program.is_polyhedral()
    }

    /// Whether cells are only the second way.
    pub(super) fn is_by_boundary(&self) -> bool {
        matches!(self.method, Method::Exact) && self.resolution.is_none() && self.bounds.is_none()
    }

    /// The size below which cells are not split, if they are adaptive.
    pub(super) fn smallest_cell(&self) -> Result<Option<f64>, Error> {
        if let Some(size) = self.smallest_feature
            && !(size > 0.0 && size.is_finite())
        {
            return Err(Error::InvalidOption(format!(
                "a smallest feature of {size}: give a positive length"
            )));
        }
        let is_adaptive = matches!(self.method, Method::Exact) && self.resolution.is_none();
        let wanted = self.smallest_feature.or(self.tolerance);
        Ok(wanted.filter(|_| is_adaptive))
    }

    /// Whether the number or the size of uniform cells is given.
    pub(super) fn is_by_cells(&self) -> bool {
        self.resolution.is_some()
    }

    pub(super) fn cell_size_for(&self, bounds: &Bounds) -> Result<f64, Error> {
        let longest = bounds.size().max_element();
        let range = format!("1 to {MAX_CELLS} cells along the longest side");
        match self.resolution.unwrap_or(Resolution::Cells(128)) {
            Resolution::Cells(cells) if (1..=MAX_CELLS).contains(&cells) => {
                Ok(longest / f64::from(cells))
            }
            Resolution::Cells(cells) => Err(Error::InvalidOption(format!(
                "{cells} cells: ask for {range}"
            ))),
            Resolution::Size(size) if size > 0.0 && longest / size <= f64::from(MAX_CELLS) => {
                // Cells much larger than the solid would lose digits.
                Ok(size.min(longest))
            }
            Resolution::Size(size) => Err(Error::InvalidOption(format!(
                "a cell size of {size} for a solid {longest} long: ask for {range}"
            ))),
        }
    }
}
