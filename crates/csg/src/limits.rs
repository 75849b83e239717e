//! How much a mesh may cost, and what is said when one would cost more.

use std::fmt;
use std::time::Duration;

/// How much a mesh may cost: as much as the machine has memory for, unless said
/// otherwise. For [`crate::Mesher::limits`].
///
/// Where a limit is reached meshing ends with [`crate::Error::LimitReached`],
/// or, if [`Self::partial`] results are welcome, with the best mesh that was
/// found within all limits: a closed one like any other, of larger cells or to
/// a larger tolerance, as [`crate::Report::limits_reached`] says.
///
/// Cells, triangles and memory are counted, not measured: the result is the
/// same for any number of threads and on every machine with memory enough. With a limit
/// of time it naturally is not.
///
/// ```
/// use csg::{Error, Limits, Mesher, Program, Solid};
///
/// let ball = Program::lower(&Solid::sphere(1.0))?;
/// let limits = Limits::new().triangles(1000);
/// let mesher = Mesher::new().tolerance(1e-5);
/// let result = mesher.clone().limits(limits).mesh(&ball);
/// assert!(matches!(result, Err(Error::LimitReached(_))));
///
/// let meshed = mesher.limits(limits.partial()).mesh(&ball)?;
/// assert!(meshed.report.check.is_manifold());
/// assert!((500..=1000).contains(&meshed.mesh.triangles.len()));
/// // In place of 1e-5.
/// let reached = &meshed.report.limits_reached[0];
/// assert!(meshed.report.deviation <= reached.kept);
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[must_use]
pub struct Limits {
    pub(crate) cells: Option<u64>,
    pub(crate) triangles: Option<u64>,
    pub(crate) memory: Option<u64>,
    pub(crate) time: Option<Duration>,
    pub(crate) partial: bool,
}

impl Limits {
    /// No limits but that of the machine's memory.
    pub fn new() -> Self {
        Self::default()
    }

    /// The most cells that may be looked at, as
    /// [`crate::Report::cells_visited`] counts them: those that are split, too,
    /// where they are adaptive, and blocks of space for solids bounded by
    /// planes. Uniform cells are counted by bricks of some thousands.
    pub fn cells(mut self, most: u64) -> Self {
        self.cells = Some(most);
        self
    }

    /// The most triangles of the finished mesh.
    pub fn triangles(mut self, most: u64) -> Self {
        self.triangles = Some(most);
        self
    }

    /// The most bytes that may be held at a time for cells and triangles, mesh
    /// and checks included, the program not: an estimate from their counts,
    /// for large meshes within a factor of two of what an allocator would say. Half of
    /// what the machine has, or the process's control group, unless said otherwise; where
    /// that cannot be told (it is on Linux alone) there is no limit.
    pub fn memory(mut self, bytes: u64) -> Self {
        self.memory = Some(bytes);
        self
    }

    /// How long meshing may take, from the call on. It ends some milliseconds
    /// later, as the clock is looked at now and then; normals and checks of a
    /// finished mesh are not cut short.
    ///
    /// For [`Self::partial`] results meshes are made from coarse to fine, each
    /// four times as fine as the one before, until the time is over, which
    /// costs up to half as much again. Of a solid bounded by planes alone there
    /// is only its exact boundary, or none.
    pub fn time(mut self, most: Duration) -> Self {
        self.time = Some(most);
        self
    }

    /// What fits the limits, in place of an error: cells or the tolerance, and
    /// with the latter the angle, are made larger until it does. An error is
    /// left for what cannot be had at any size, and for a limit of time that is
    /// over before the coarsest mesh is made.
    pub fn partial(mut self) -> Self {
        self.partial = true;
        self
    }
}

/// One of the [`Limits`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// So many cells.
    Cells(u64),
    /// So many triangles.
    Triangles(u64),
    /// So many bytes.
    Memory(u64),
    /// So long.
    Time(Duration),
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cells(most) => write!(f, "{most} cells"),
            Self::Triangles(most) => write!(f, "{most} triangles"),
            Self::Memory(bytes) => write!(f, "{} MB", *bytes as f64 / 1e6),
            Self::Time(most) => write!(f, "{most:?}"),
        }
    }
}

/// What took more than a limit allows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Demand {
    /// Cells of this side length, or down to it, in model units.
    Cells(f64),
    /// This tolerance, in model units.
    Tolerance(f64),
    /// The exact boundary of a solid bounded by planes.
    ExactBoundary,
}

impl fmt::Display for Demand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cells(size) => write!(f, "cells of {}", told(*size)),
            Self::Tolerance(distance) => write!(f, "a tolerance of {}", told(*distance)),
            Self::ExactBoundary => f.write_str("the exact boundary of planes"),
        }
    }
}

/// A number as it is told: four digits say what was halved or was a share of a length.
fn told(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// A limit that was reached, and by what.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LimitReached {
    /// Which.
    pub limit: Limit,
    /// What was asked for.
    pub demand: Demand,
    /// The size of cells, or the tolerance, that was kept instead, in model
    /// units; `None` without a [`Limits::partial`] result.
    pub kept: Option<f64>,
}

impl fmt::Display for LimitReached {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            limit,
            demand,
            kept,
        } = self;
        write!(f, "{demand} would take more than the limit of {limit}")?;
        match (kept.map(told), demand) {
            (Some(kept), Demand::Tolerance(_)) => write!(f, ": {kept} was kept"),
            (Some(kept), _) => write!(f, ": made with cells of {kept}"),
            (None, _) => Ok(()),
        }
    }
}
