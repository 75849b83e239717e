//! The one entry from a program to a mesh: options in, mesh and report out.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::adapt;
use crate::control::{CancelToken, Control};
use crate::draft;
use crate::error::Error;
use crate::finish;
use crate::mesh::{LengthUnit, Mesh, MeshSurface};
use crate::net;
use crate::polyhedral;
use crate::program::{Bounds, Program, Surface};
use crate::refine::{self, Goal, Surfaced, Unkept};
use crate::report::Report;

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
    method: Method,
    tolerance: Option<f64>,
    angle: Option<f64>,
    bounds: Option<Bounds>,
    unit: LengthUnit,
    check: bool,
    normals: bool,
    feature_angle: Option<f64>,
    control: Control,
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
enum Method {
    Exact,
    Draft,
}

/// A finished mesh and how it came about.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Meshed {
    /// The mesh.
    pub mesh: Mesh,
    /// What was done for it, and what could not be done.
    pub report: Report,
}

/// What there is to mesh. All geometry is relative to `origin`, the middle
/// of the solid's bounds, so that a model far away loses no digits.
pub(crate) struct Task<'a> {
    pub(crate) program: &'a Program,
    /// The program's surfaces about `origin`.
    pub(crate) surfaces: Vec<Surface>,
    pub(crate) origin: DVec3,
    /// The lengths of the sides of the bounds.
    pub(crate) size: DVec3,
    /// Side of a cell.
    pub(crate) cell: f64,
    pub(crate) control: &'a Control,
}

impl Task<'_> {
    /// The entry of triangles on a surface of a primitive.
    pub(crate) fn mesh_surface(&self, surface: u32, primitive: u32) -> MeshSurface {
        let origin = &self.program.origins()[primitive as usize];
        MeshSurface {
            surface,
            primitive,
            name: origin.name.as_ref().map(Arc::clone),
            color: origin.color,
        }
    }
}

impl Default for Mesher {
    fn default() -> Self {
        Self::new()
    }
}

impl Mesher {
    /// 128 cells along the longest side of the solid's bounds, in millimetres;
    /// for a solid bounded by planes alone none at all, but its exact boundary.
    /// That one is made with a [`Self::tolerance`], too, but not where
    /// [`Self::cells`], their size or a box are given.
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
            control: Control::default(),
        }
    }

    /// As many cells along the longest side of the bounds, 1 to
    /// [`MAX_CELLS`]. Time and memory grow with the square of it.
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
    /// [`Self::check`] a mesh that runs through itself, where faces are nearer
    /// to each other than the tolerance, is made anew with half of it. Not for
    /// drafts.
    pub fn tolerance(mut self, distance: f64) -> Self {
        self.tolerance = Some(distance);
        self
    }

    /// With a tolerance: the largest angle in radians, too, that a surface may
    /// turn along an edge of the mesh.
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
    pub fn normals(mut self) -> Self {
        self.normals = true;
        self
    }

    /// Fills [`Mesh::feature_edges`] with the edges between different surfaces
    /// that meet at more than `angle` radians, as polylines.
    pub fn feature_edges(mut self, angle: f64) -> Self {
        self.feature_angle = Some(angle);
        self
    }

    /// Whether to check and measure the finished mesh (on by default), which
    /// takes about as long again as meshing; off, [`Report::check`] and the
    /// report's distances stay empty.
    pub fn check(mut self, check: bool) -> Self {
        self.check = check;
        self
    }

    /// Called with the share of the work that is done, 0 to 1, about once a
    /// percent, from whatever thread did it; two calls from different threads
    /// may overtake each other.
    pub fn progress(mut self, callback: impl Fn(f64) + Send + Sync + 'static) -> Self {
        self.control.progress = Some(Arc::new(callback));
        self
    }

    /// A handle with which another thread may stop the work.
    pub fn cancel_token(mut self, token: CancelToken) -> Self {
        self.control.cancel = token;
        self
    }

    /// Meshes a program. The empty solid gives an empty mesh.
    ///
    /// The result is the same for any number of threads.
    ///
    /// # Errors
    /// [`Error::Unbounded`] for a solid that reaches infinitely far,
    /// [`Error::InvalidOption`] for a resolution, a tolerance, an angle or a box
    /// out of range,
    /// [`Error::TooLarge`] if the vertices outnumber an index,
    /// [`Error::Cancelled`] when asked to stop.
    pub fn mesh(&self, program: &Program) -> Result<Meshed, Error> {
        let smallest = self.smallest_cell()?;
        let by_cells = match self.method {
            Method::Draft => "draft",
            Method::Exact if smallest.is_some() => "adaptive",
            Method::Exact => "exact",
        };
        let is_polyhedral = self.is_polyhedral(program);
        let mut report = Report {
            method: if is_polyhedral {
                "polyhedral"
            } else {
                by_cells
            },
            ..Report::default()
        };
        let start = Instant::now();
        self.control.check()?;
        let mut bounds = match self.bounds {
            Some(bounds) if bounds.min.is_finite() && bounds.max.is_finite() => Some(bounds),
            Some(_) => {
                return Err(Error::InvalidOption(
                    "the bounds must be finite: give two ordinary corners".into(),
                ));
            }
            None if is_polyhedral => program.loose_bounds()?,
            None => program.bounds()?,
        };
        let goal = self.goal()?;
        report.end_stage("bounds", start);
        // A box without extent holds no solid: at most a point was left of it.
        let has_extent = |bounds: &Bounds| bounds.size().max_element() > 0.0;
        let mut mesh = None;
        if let Some(loose) = bounds.filter(|b| is_polyhedral && has_extent(b)) {
            mesh = self.polyhedral(program, loose, &mut report)?;
            if mesh.is_none() {
                bounds = program.bounds()?;
            }
        }
        let bounds = bounds.filter(has_extent);
        let mut mesh = match (mesh, bounds) {
            (Some(exact), _) => exact,
            (None, None) => Mesh::default(),
            (None, Some(bounds)) => {
                report.method = by_cells;
                report.bounds = Some(bounds);
                self.mesh_by_cells(program, bounds, goal, &mut report)?
            }
        };
        mesh.unit = self.unit;
        self.control.check()?;
        let start = Instant::now();
        if self.normals {
            mesh.corner_normals = finish::corner_normals(program, &mesh);
            report.end_stage("normals", start);
        }
        let start = Instant::now();
        if let Some(angle) = self.feature_angle {
            if !(0.0..=std::f64::consts::PI).contains(&angle) {
                return Err(Error::InvalidOption(format!(
                    "a feature angle of {angle}: give radians from 0 to pi"
                )));
            }
            mesh.feature_edges = finish::feature_edges(program, &mesh, angle);
            report.end_stage("feature edges", start);
        }
        if self.check {
            let start = Instant::now();
            report.check = mesh.check();
            (
                report.largest_vertex_distance,
                report.largest_centroid_distance,
            ) = finish::largest_distances(program, &mesh);
            report.end_stage("check", start);
        }
        if let Some(progress) = &self.control.progress {
            progress(1.0);
        }
        Ok(Meshed { mesh, report })
    }

    fn task<'a>(&'a self, program: &'a Program, bounds: Bounds, cell: f64) -> Task<'a> {
        let origin = bounds.center();
        Task {
            program,
            surfaces: program.surfaces_about(origin),
            origin,
            size: bounds.size(),
            cell,
            control: &self.control,
        }
    }

    /// The exact boundary of planes; none where it could not be closed.
    fn polyhedral(
        &self,
        program: &Program,
        loose: Bounds,
        report: &mut Report,
    ) -> Result<Option<Mesh>, Error> {
        let task = self.task(program, loose, 0.0);
        let Some(mut mesh) = polyhedral::mesh(&task, report)? else {
            return Ok(None);
        };
        move_by(&mut mesh.positions, task.origin);
        report.bounds = mesh.bounds().map(|(min, max)| Bounds { min, max });
        if self.check {
            for place in crossings(&mesh) {
                report.add_fallback(Unkept::Crossing.describe(), place);
            }
        }
        Ok(Some(mesh))
    }

    fn mesh_by_cells(
        &self,
        program: &Program,
        bounds: Bounds,
        goal: Option<Goal>,
        report: &mut Report,
    ) -> Result<Mesh, Error> {
        let smallest = self.smallest_cell()?;
        report.cell_size = match smallest {
            Some(smallest) => smallest.min(bounds.size().max_element()),
            None => self.cell_size_for(&bounds)?,
        };
        let task = self.task(program, bounds, report.cell_size);
        let mut mesh = match self.method {
            Method::Draft => draft::mesh(&task, report)?,
            Method::Exact if smallest.is_some() => adapt::mesh(&task, report)?,
            Method::Exact => net::mesh(&task, report)?,
        };
        if let Some(goal) = goal {
            self.refine(&mut mesh, &task, &goal, report)?;
        }
        if matches!(self.method, Method::Exact) {
            move_by(&mut mesh.positions, task.origin);
        }
        Ok(mesh)
    }

    fn goal(&self) -> Result<Option<Goal>, Error> {
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
            tolerance,
            angle: self.angle,
        }))
    }

    /// Brings a mesh in the task's frame to the tolerance, and, if it is to be
    /// checked, to so much less that it does not run through itself.
    fn refine(
        &self,
        mesh: &mut Mesh,
        task: &Task<'_>,
        goal: &Goal,
        report: &mut Report,
    ) -> Result<(), Error> {
        const MOST_TRIES: u32 = 4;
        let start = Instant::now();
        merge_alike(mesh, task.program);
        let mut surfaced = Surfaced {
            positions: std::mem::take(&mut mesh.positions),
            triangles: std::mem::take(&mut mesh.triangles),
            groups: std::mem::take(&mut mesh.triangle_surfaces),
            surface_of_group: mesh.surfaces.iter().map(|s| s.surface).collect(),
        };
        let coarse = surfaced.clone();
        let mut goal = *goal;
        let mut outcome;
        let mut tries = 0;
        loop {
            outcome = refine::to_tolerance(&mut surfaced, &task.surfaces, &goal, &self.control)?;
            mesh.positions = std::mem::take(&mut surfaced.positions);
            mesh.triangles = std::mem::take(&mut surfaced.triangles);
            let crossings = if self.check {
                crossings(mesh)
            } else {
                Vec::new()
            };
            tries += 1;
            if crossings.is_empty() || tries == MOST_TRIES {
                for place in crossings {
                    outcome.unkept.push((Unkept::Crossing, place));
                }
                break;
            }
            // Faces that run close by each other need smaller triangles.
            goal.tolerance *= 0.5;
            surfaced = coarse.clone();
        }
        mesh.triangle_surfaces = surfaced.groups;
        report.deviation = Some(outcome.deviation);
        report.farthest = Some(outcome.farthest + task.origin);
        for (reason, place) in outcome.unkept {
            report.add_fallback(reason.describe(), place + task.origin);
        }
        report.end_stage("refine", start);
        Ok(())
    }

    /// Whether the exact boundary of planes is to be meshed, without cells. It
    /// is that of the whole solid, not of what lies in a box that was given.
    fn is_polyhedral(&self, program: &Program) -> bool {
        matches!(self.method, Method::Exact)
            && self.resolution.is_none()
            && self.bounds.is_none()
            && polyhedral::is_polyhedral(program)
    }

    /// The size below which cells are not split, if they are adaptive.
    fn smallest_cell(&self) -> Result<Option<f64>, Error> {
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

    fn cell_size_for(&self, bounds: &Bounds) -> Result<f64, Error> {
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

/// Makes one entry of those of a mesh's surfaces that only differ in which of
/// several primitives of the same kind, name and colour they come from: borders
/// between them on one surface would keep vertices that nobody needs.
fn merge_alike(mesh: &mut Mesh, program: &Program) {
    let origin = |entry: &MeshSurface| &program.origins()[entry.primitive as usize];
    let mut kept: Vec<MeshSurface> = Vec::new();
    let mut of_surface: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    let mut merged = Vec::with_capacity(mesh.surfaces.len());
    for entry in &mesh.surfaces {
        let known = of_surface.entry(entry.surface).or_default();
        let alike = known
            .iter()
            .find(|&&k| origin(&kept[k as usize]) == origin(entry));
        merged.push(alike.copied().unwrap_or_else(|| {
            kept.push(entry.clone());
            known.push(kept.len() as u32 - 1);
            kept.len() as u32 - 1
        }));
    }
    for index in &mut mesh.triangle_surfaces {
        *index = merged[*index as usize];
    }
    mesh.surfaces = kept;
}

/// Places where a mesh runs through itself.
fn crossings(mesh: &Mesh) -> Vec<DVec3> {
    let pairs = mesh.self_intersections().into_iter();
    pairs
        .map(|[triangle, _]| mesh.corners(triangle as usize)[0])
        .collect()
}

/// Moves all points.
fn move_by(positions: &mut [DVec3], by: DVec3) {
    if by != DVec3::ZERO {
        positions
            .par_chunks_mut(4096)
            .for_each(|chunk| chunk.iter_mut().for_each(|p| *p += by));
    }
}
