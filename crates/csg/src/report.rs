//! What a mesher did, and what it could not do.

use crate::clock::Instant;
use std::fmt;

use glam::DVec3;

use crate::limits::LimitReached;
use crate::mesh::MeshCheck;
use crate::program::Bounds;
use crate::undecided::Undecided;

/// How many places of each [`Fallback`] a report keeps.
pub const PLACES_PER_FALLBACK: usize = 8;

/// The account of one run of a [`crate::Mesher`].
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// The method's name: `"draft"`, `"exact"` on a uniform grid,
    /// `"adaptive"`, `"polyhedral"` for the exact boundary of planes, or
    /// `"boundary"` for one from the curves in which surfaces meet, refined to
    /// the tolerance.
    pub method: &'static str,
    /// The box that was meshed; `None` if the solid is proven empty.
    pub bounds: Option<Bounds>,
    /// Side of a cell, in model units; 0 if the solid is proven empty.
    pub cell_size: f64,
    /// Cells that were sampled.
    pub cells_visited: u64,
    /// Cells in boxes that pruning proved to be all inside or all outside.
    pub cells_pruned: u64,
    /// Cells that the surface passes through.
    pub surface_cells: u64,
    /// The largest distance, in model units and to first order, of a vertex
    /// from the surface that a triangle at it is assigned to.
    pub largest_vertex_distance: f64,
    /// The same for the centroids of triangles: the chord error.
    pub largest_centroid_distance: f64,
    /// With a tolerance asked for: the largest distance, in model units,
    /// between the mesh and the solid's boundary, both ways; a bound, not a
    /// sample. It holds where the mesh has the boundary's topology; where surfaces were
    /// [moved](Self::moved), between the mesh and the boundary of the solid so moved, and to
    /// first order counts how far edges were moved with them.
    pub deviation: Option<f64>,
    /// Where that is.
    pub farthest: Option<DVec3>,
    /// With limits and partial results: what was made larger to stay within
    /// them.
    pub limits_reached: Vec<LimitReached>,
    /// Where the exact boundary could not be told, once for each try, so that another way
    /// had to do: other chords, surfaces that are moved, or cells.
    pub undecided: Vec<Undecided>,
    /// What was done to surfaces that nearly coincide or touch, if anything was.
    pub moved: Option<Moved>,
    /// What had to be settled for somewhere, each kind once.
    pub fallbacks: Vec<Fallback>,
    /// Where the finished mesh, held against the solid along some rays, is not its
    /// boundary: what share of the rays' length in either is in one alone, about that of
    /// the volume. 0 as long as no place is found, which is a fallback, too.
    pub difference: f64,
    /// Closed, oriented, manifold? Checked on the finished mesh.
    pub check: MeshCheck,
    /// Seconds of each stage, in the order in which they ran, one after
    /// another; together the time that the mesh took. The stage "rest" is that
    /// of tries whose mesh was not kept, wherever they were, and of what lies
    /// between stages.
    pub stages: Vec<(&'static str, f64)>,
}

impl Report {
    /// Counts a place where something had to be settled for.
    pub(crate) fn add_fallback(&mut self, kind: &'static str, place: DVec3) {
        self.add_fallbacks(kind, 1, &[place]);
    }

    /// Counts places, of which the first few are told.
    pub(crate) fn add_fallbacks(&mut self, kind: &'static str, count: usize, places: &[DVec3]) {
        if count == 0 {
            return;
        }
        let known = self.fallbacks.iter().position(|f| f.kind == kind);
        let index = known.unwrap_or_else(|| {
            self.fallbacks.push(Fallback {
                kind,
                count: 0,
                places: Vec::new(),
            });
            self.fallbacks.len() - 1
        });
        let fallback = &mut self.fallbacks[index];
        fallback.count += count;
        let room = PLACES_PER_FALLBACK - fallback.places.len();
        fallback.places.extend(places.iter().take(room));
    }

    /// Whether [`Self::deviation`] holds without any condition: the mesh was made from
    /// the exact boundary, of surfaces none of which was moved, and nothing had to be
    /// settled for.
    #[must_use]
    pub fn is_proven(&self) -> bool {
        matches!(self.method, "polyhedral" | "boundary")
            && self.moved.is_none()
            && self.complaints() == 0
            && self.deviation.is_some_and(f64::is_finite)
    }

    /// How many places something had to be settled for in.
    pub(crate) fn complaints(&self) -> usize {
        self.fallbacks.iter().map(|fallback| fallback.count).sum()
    }

    /// Ends one of several turns of a stage, which began at `since`, and
    /// returns the time now.
    pub(crate) fn add_to_stage(&mut self, name: &'static str, since: Instant) -> Instant {
        let now = Instant::now();
        let seconds = (now - since).as_secs_f64();
        match self.stages.iter_mut().find(|stage| stage.0 == name) {
            Some(stage) => stage.1 += seconds,
            None => self.stages.push((name, seconds)),
        }
        now
    }

    /// Ends a stage that began at `since`, and returns the time now.
    pub(crate) fn end_stage(&mut self, name: &'static str, since: Instant) -> Instant {
        let now = Instant::now();
        self.stages.push((name, (now - since).as_secs_f64()));
        now
    }
}

/// Surfaces that are not where the program has them: too near to each other for a wall
/// or a gap between them, so that one is in the place of several, or moved because it
/// could not be told what they do where they are.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Moved {
    /// How many surfaces were replaced by another one.
    pub merged: usize,
    /// Bound on how far any surface was moved, within the solid's bounds, in model
    /// units. It is part of [`Report::deviation`], but walls, gaps and contacts of such
    /// a size may be lost or new: nothing is told of how far they are from the mesh. Moves
    /// that are no more than what rounding does to coordinates are not told.
    pub distance: f64,
    /// A point of the surface that was moved farthest: its centre, or a point of its
    /// axis or plane.
    pub place: DVec3,
}

/// One kind of thing that had to be settled for, and where.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Fallback {
    /// What it is.
    pub kind: &'static str,
    /// How often it happened.
    pub count: usize,
    /// The first few places, in model units.
    pub places: Vec<DVec3>,
}

impl fmt::Display for Fallback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {}", self.count, self.kind)?;
        if let Some(place) = self.places.first() {
            write!(f, " (first at {place})")?;
        }
        Ok(())
    }
}
