//! One run of a mesher: which way the mesh is made, what is done when it fails
//! or costs too much, and what a finished mesh still gets.

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::fit::{HALVINGS, fit, is_too_much};
use super::{Meshed, Mesher, Method, Task};
use crate::adapt;
use crate::control::Control;
use crate::draft;
use crate::error::Error;
use crate::evaluation;
use crate::finish;
use crate::limits::{Demand, Limit, LimitReached};
use crate::mesh::{Mesh, MeshSurface};
use crate::net;
use crate::program::{Bounds, Program};
use crate::refine::{self, Goal, Outcome, Surfaced, Unkept, Which};
use crate::report::Report;

/// Bytes that the check of a mesh needs for each triangle, while it runs.
const CHECK_BYTES: usize = 100;

/// A mesher with valid options at work.
pub(super) struct Run<'a> {
    mesher: &'a Mesher,
    program: &'a Program,
    /// The size below which cells are not split, if they are adaptive.
    smallest: Option<f64>,
    goal: Option<Goal>,
    start: Instant,
    control: Control,
}

/// A mesh brought to a tolerance.
struct Refined {
    surfaced: Surfaced,
    outcome: Outcome,
}

impl<'a> Run<'a> {
    pub fn new(mesher: &'a Mesher, program: &'a Program) -> Result<Self, Error> {
        let start = Instant::now();
        if let Some(angle) = mesher.feature_angle
            && !(0.0..=std::f64::consts::PI).contains(&angle)
        {
            return Err(Error::InvalidOption(format!(
                "a feature angle of {angle}: give radians from 0 to pi"
            )));
        }
        if let Some(bounds) = mesher.bounds
            && !(bounds.min.is_finite() && bounds.max.is_finite())
        {
            return Err(Error::InvalidOption(
                "the bounds must be finite: give two ordinary corners".into(),
            ));
        }
        Ok(Self {
            mesher,
            program,
            smallest: mesher.smallest_cell()?,
            goal: mesher.goal()?,
            start,
            control: Control::start(&mesher.caller, mesher.limits, Demand::ExactBoundary),
        })
    }

    pub fn mesh(&self) -> Result<Meshed, Error> {
        let mesher = self.mesher;
        let mut report = Report::default();
        let mut mesh = self.shape(&mut report)?;
        mesh.unit = mesher.unit;
        let start = Instant::now();
        if !report.limits_reached.is_empty() {
            let told: f64 = report.stages.iter().map(|(_, seconds)| seconds).sum();
            let tries = (start - self.start).as_secs_f64() - told;
            report.stages.push(("beyond limits", tries.max(0.0)));
        }
        if mesher.normals {
            mesh.corner_normals = finish::corner_normals(self.program, &mesh);
            report.end_stage("normals", start);
        }
        let start = Instant::now();
        if let Some(angle) = mesher.feature_angle {
            mesh.feature_edges = finish::feature_edges(self.program, &mesh, angle);
            report.end_stage("feature edges", start);
        }
        if mesher.check {
            let start = Instant::now();
            report.check = mesh.check();
            (
                report.largest_vertex_distance,
                report.largest_centroid_distance,
            ) = finish::largest_distances(self.program, &mesh);
            report.end_stage("check", start);
        }
        self.control.tell(1.0);
        Ok(Meshed { mesh, report })
    }

    /// The mesh itself, about the true origin.
    fn shape(&self, report: &mut Report) -> Result<Mesh, Error> {
        // A box without extent holds no solid: at most a point was left of it.
        let has_extent = |bounds: &Bounds| bounds.size().max_element() > 0.0;
        let program = self.program;
        self.control.check()?;
        let mut beyond = None;
        if self.mesher.is_polyhedral(program) {
            let start = Instant::now();
            report.method = "polyhedral";
            let loose = program.loose_bounds()?;
            report.end_stage("bounds", start);
            let Some(loose) = loose.filter(has_extent) else {
                return Ok(Mesh::default());
            };
            let mut attempt = report.clone();
            match self.polyhedral(loose, &mut attempt) {
                Ok(Some(mesh)) => {
                    *report = attempt;
                    return Ok(mesh);
                }
                Ok(None) => {}
                Err(error) => match is_too_much(&error) {
                    Some(reached) if self.mesher.limits.partial => beyond = Some(reached),
                    _ => return Err(error),
                },
            }
        }
        let start = Instant::now();
        report.method = match self.mesher.method {
            Method::Draft => "draft",
            Method::Exact if self.smallest.is_some() => "adaptive",
            Method::Exact => "exact",
        };
        let bounds = match self.mesher.bounds {
            Some(bounds) => Some(bounds),
            None => program.bounds()?,
        };
        report.end_stage("bounds", start);
        let Some(bounds) = bounds.filter(has_extent) else {
            return Ok(Mesh::default());
        };
        report.bounds = Some(bounds);
        let mesh = self.coarse_to_fine(bounds, report)?;
        if let Some(reached) = beyond {
            report.limits_reached.push(LimitReached {
                kept: Some(report.cell_size),
                ..reached
            });
        }
        Ok(mesh)
    }

    /// The exact boundary of planes; none where it could not be closed.
    fn polyhedral(&self, loose: Bounds, report: &mut Report) -> Result<Option<Mesh>, Error> {
        let control = self.control.again(Demand::ExactBoundary);
        let task = Task::new(self.program, loose, 0.0, &control);
        let Some(mut mesh) = evaluation::mesh(&task, &[], 0, report)? else {
            return Ok(None);
        };
        self.check_size(&mesh, &control)?;
        move_by(&mut mesh.positions, task.origin);
        report.bounds = mesh.bounds().map(|(min, max)| Bounds { min, max });
        if self.mesher.check {
            for place in crossings(&mesh) {
                report.add_fallback(Unkept::Crossing.describe(), place);
            }
        }
        Ok(Some(mesh))
    }

    /// The mesh by cells; where time is limited and a partial result welcome,
    /// the finest that is found in time.
    fn coarse_to_fine(&self, bounds: Bounds, report: &mut Report) -> Result<Mesh, Error> {
        const FINER: f64 = 4.0;
        /// Of the solid, where the coarsest begins.
        const COARSEST: f64 = 0.125;
        let limits = &self.mesher.limits;
        let Some(time) = limits.time.filter(|_| limits.partial) else {
            return self.by_cells(bounds, 1.0, report);
        };
        let cell = self.cell_size(&bounds)?;
        let (demand, finest) = match &self.goal {
            Some(goal) => (Demand::Tolerance(goal.tolerance), goal.tolerance),
            None => (Demand::Cells(cell), cell),
        };
        let factor = COARSEST * bounds.size().max_element() / finest.min(cell);
        let mut best: Option<(Mesh, Report, f64)> = None;
        for pass in (0..=factor.log(FINER).ceil().clamp(0.0, 30.0) as i32).rev() {
            let factor = FINER.powi(pass);
            let mut attempt = report.clone();
            match (self.by_cells(bounds, factor, &mut attempt), &mut best) {
                (Ok(mesh), _) if pass > 0 && mesh.triangles.is_empty() => {}
                (Ok(mesh), _) => best = Some((mesh, attempt, factor)),
                (Err(error), Some((_, kept, factor))) if is_too_late(&error) => {
                    kept.limits_reached.push(LimitReached {
                        limit: Limit::Time(time),
                        demand,
                        kept: Some(*factor * finest),
                    });
                    break;
                }
                (Err(error), _) => return Err(error),
            }
        }
        let (mesh, kept, _) = best.unwrap_or_default();
        *report = kept;
        Ok(mesh)
    }

    /// The side of the cells that are asked for, or of the smallest.
    fn cell_size(&self, bounds: &Bounds) -> Result<f64, Error> {
        match self.smallest {
            Some(smallest) => Ok(smallest.min(bounds.size().max_element())),
            None => self.mesher.cell_size_for(bounds),
        }
    }

    /// The mesh by cells and to a tolerance that are larger than what was asked
    /// for by a factor, or by more if only that fits the limits.
    fn by_cells(&self, bounds: Bounds, factor: f64, report: &mut Report) -> Result<Mesh, Error> {
        let longest = bounds.size().max_element();
        let asked = (factor * self.cell_size(&bounds)?).min(longest);
        let most = if self.mesher.limits.partial {
            longest
        } else {
            asked
        };
        // Adaptive cells only come in powers of two.
        let halvings = if self.smallest.is_some() { 0 } else { HALVINGS };
        let before = report.clone();
        let (made, reached) = fit(asked, most, halvings, |cell| {
            let mut attempt = before.clone();
            attempt.cell_size = cell;
            let mesh = self.by_cells_of(cell, bounds, factor, &mut attempt)?;
            Ok((mesh, attempt))
        })?;
        let (mesh, attempt) = made;
        // Cells so large that they see nothing are no result.
        if let Some(reached) = reached.filter(|_| mesh.triangles.is_empty()) {
            return Err(Error::LimitReached(LimitReached {
                kept: None,
                ..reached
            }));
        }
        *report = attempt;
        report.limits_reached.extend(reached);
        Ok(mesh)
    }

    fn by_cells_of(
        &self,
        cell: f64,
        bounds: Bounds,
        factor: f64,
        report: &mut Report,
    ) -> Result<Mesh, Error> {
        let control = self.control.again(Demand::Cells(cell));
        let task = Task::new(self.program, bounds, cell, &control);
        let evaluated = self.evaluated(&task, factor, report)?;
        let (mut mesh, attempt) = match evaluated {
            Some(evaluated) if is_final(&evaluated.1) => evaluated,
            other => {
                let mut attempt = report.clone();
                let by_cells = self.by_cells_alone(&task, factor, &mut attempt);
                match (other, by_cells) {
                    // Of two that are not perfect the better one.
                    (Some(first), Ok(_)) if first.1.complaints() <= attempt.complaints() => first,
                    (Some(first), Err(error)) if is_too_much(&error).is_some() => first,
                    (_, by_cells) => (by_cells?, attempt),
                }
            }
        };
        *report = attempt;
        self.check_size(&mesh, &control)?;
        if matches!(self.mesher.method, Method::Exact) {
            move_by(&mut mesh.positions, task.origin);
        }
        Ok(mesh)
    }

    fn by_cells_alone(
        &self,
        task: &Task<'_>,
        factor: f64,
        report: &mut Report,
    ) -> Result<Mesh, Error> {
        let mut mesh = match self.mesher.method {
            Method::Draft => draft::mesh(task, report)?,
            Method::Exact if self.smallest.is_some() => adapt::mesh(task, report)?,
            Method::Exact => net::mesh(task, report)?,
        };
        if let Some(goal) = &self.goal {
            self.refine(&mut mesh, task, &goal.loosened(factor), report)?;
        }
        Ok(mesh)
    }

    /// The mesh to a tolerance without cells, from the curves in which surfaces
    /// meet, and its report; none where they are not known.
    fn evaluated(
        &self,
        task: &Task<'_>,
        factor: f64,
        report: &Report,
    ) -> Result<Option<(Mesh, Report)>, Error> {
        let Some(goal) = &self.goal else {
            return Ok(None);
        };
        let is_tried = evaluation::is_polyhedral(self.program);
        if self.smallest.is_none() || self.mesher.bounds.is_some() || is_tried {
            return Ok(None);
        }
        let control = self.control.again(Demand::ExactBoundary);
        let task = task.with(&control);
        let most_blocks = if self.mesher.check {
            evaluation::MANY_BLOCKS
        } else {
            evaluation::FEW_BLOCKS
        };
        let goal = Goal {
            even_curves: true,
            ..goal.loosened(factor)
        };
        let mut best: Option<(Mesh, Report)> = None;
        for turns in [
            &evaluation::LONG_CHORDS[..],
            &evaluation::SHORT_CHORDS,
            &evaluation::SHORTEST_CHORDS,
        ] {
            let mut report = report.clone();
            report.method = "boundary";
            let attempt =
                evaluation::mesh(&task, turns, most_blocks, &mut report).and_then(|mesh| {
                    let Some(mut mesh) = mesh else {
                        return Ok(None);
                    };
                    self.refine(&mut mesh, &task, &goal, &mut report)?;
                    Ok(Some(mesh))
                });
            let mesh = match attempt {
                Ok(Some(mesh)) => mesh,
                Ok(None) => break,
                // Cells may be larger.
                Err(error) if is_too_much(&error).is_some() => break,
                Err(error) => return Err(error),
            };
            let is_final = is_final(&report);
            let complaints = report.complaints();
            if best
                .as_ref()
                .is_none_or(|best| complaints < best.1.complaints())
            {
                best = Some((mesh, report));
            }
            if is_final {
                break;
            }
        }
        Ok(best)
    }

    /// Whether a finished mesh is within the limits, with what it still gets.
    fn check_size(&self, mesh: &Mesh, control: &Control) -> Result<(), Error> {
        let normals = if self.mesher.normals { 36 } else { 0 };
        let check = if self.mesher.check { CHECK_BYTES } else { 0 };
        let bytes = size_of_val(&*mesh.positions)
            + mesh.triangles.len() * (size_of::<[u32; 4]>() + normals + check);
        control.check_triangles(mesh.triangles.len())?;
        control.again(Demand::ExactBoundary).check_memory(bytes)
    }

    /// Brings a mesh in the task's frame to the tolerance, or to a larger one if
    /// only that fits the limits.
    fn refine(
        &self,
        mesh: &mut Mesh,
        task: &Task<'_>,
        goal: &Goal,
        report: &mut Report,
    ) -> Result<(), Error> {
        let start = Instant::now();
        merge_alike(mesh, task.program);
        let coarse = Surfaced {
            positions: std::mem::take(&mut mesh.positions),
            triangles: std::mem::take(&mut mesh.triangles),
            groups: std::mem::take(&mut mesh.triangle_surfaces),
            surface_of_group: mesh.surfaces.iter().map(|s| s.surface).collect(),
        };
        let asked = goal.tolerance;
        let most = if self.mesher.limits.partial {
            task.size.length().max(asked)
        } else {
            asked
        };
        let (refined, reached) = fit(asked, most, HALVINGS, |tolerance| {
            self.refine_to(&coarse, task, goal.loosened(tolerance / asked))
        })?;
        let Surfaced {
            positions,
            triangles,
            groups,
            ..
        } = refined.surfaced;
        mesh.positions = positions;
        mesh.triangles = triangles;
        mesh.triangle_surfaces = groups;
        let outcome = refined.outcome;
        report.deviation = Some(outcome.deviation);
        report.farthest = Some(outcome.farthest + task.origin);
        for (reason, place) in outcome.unkept {
            report.add_fallback(reason.describe(), place + task.origin);
        }
        report.limits_reached.extend(reached);
        report.end_stage("refine", start);
        Ok(())
    }

    /// A mesh to a tolerance, and to so much less on surfaces where that is not
    /// proven, or, if it is to be checked, where the mesh would run through itself,
    /// that it is and does not.
    fn refine_to(
        &self,
        coarse: &Surfaced,
        task: &Task<'_>,
        mut goal: Goal,
    ) -> Result<Refined, Error> {
        const MOST_TRIES: u32 = 8;
        /// Of a mesh that is not checked.
        const FEW_TRIES: u32 = 3;
        /// In a row, that were no better.
        const MOST_IN_VAIN: u32 = 3;
        const FINER: f64 = 0.4;
        /// So many times as many triangles are not worth it.
        const MOST_GROWTH: usize = 20;
        let control = self.control.again(Demand::Tolerance(goal.tolerance));
        let attempt = |goal: &Goal| -> Result<(Refined, Vec<u32>), Error> {
            let mut surfaced = coarse.clone();
            let mut outcome = refine::to_tolerance(&mut surfaced, &task.surfaces, goal, &control)?;
            if self.mesher.check {
                self.part_crossing(&mut surfaced, &mut outcome, task, goal)?;
            }
            let mut narrow = std::mem::take(&mut outcome.tighter);
            narrow.sort_unstable();
            narrow.dedup();
            Ok((Refined { surfaced, outcome }, narrow))
        };
        let (mut best, mut narrow) = attempt(&goal)?;
        let most_triangles = MOST_GROWTH * best.surfaced.triangles.len();
        let mut in_vain = 0;
        // At first it may be enough that no vertex of the surfaces is removed.
        let (tries, most_in_vain, at_first) = if self.mesher.check {
            (MOST_TRIES, MOST_IN_VAIN, 1.0)
        } else {
            (FEW_TRIES, 1, FINER)
        };
        for _ in 1..tries {
            if narrow.is_empty() || in_vain == most_in_vain {
                break;
            }
            for &surface in &narrow {
                let tight = goal.tight.entry(surface);
                tight
                    .and_modify(|share| *share *= FINER)
                    .or_insert(at_first);
            }
            let refined = match attempt(&goal) {
                // Better one that runs through itself than none.
                Err(error) if is_too_much(&error).is_some() => break,
                result => result?,
            };
            narrow = refined.1;
            in_vain += 1;
            let is_too_large = refined.0.surfaced.triangles.len() > most_triangles;
            if refined.0.outcome.unkept.len() < best.outcome.unkept.len() {
                best = refined.0;
                in_vain = 0;
            }
            if is_too_large {
                break;
            }
        }
        Ok(best)
    }

    /// Cuts up the triangles of a mesh that run through each other until none do, or
    /// that does not help, and notes where they still do.
    fn part_crossing(
        &self,
        surfaced: &mut Surfaced,
        outcome: &mut Outcome,
        task: &Task<'_>,
        goal: &Goal,
    ) -> Result<(), Error> {
        const MOST_ROUNDS: u32 = 14;
        let mut pairs = crossing_pairs(surfaced, task.origin);
        if pairs.is_empty() {
            return Ok(());
        }
        // Where the mesh is folded there are more and more.
        let too_many = 4 * pairs.len() + 16;
        let before = (surfaced.clone(), outcome.clone(), pairs);
        let mut least = before.clone();
        for which in [Which::Worst, Which::Chords] {
            (*surfaced, *outcome, pairs) = before.clone();
            for _ in 0..MOST_ROUNDS {
                self.control.check()?;
                if !refine::part(surfaced, &task.surfaces, goal, &pairs, which, outcome) {
                    break;
                }
                pairs = crossing_pairs(surfaced, task.origin);
                if pairs.len() < least.2.len() {
                    least = (surfaced.clone(), outcome.clone(), pairs.clone());
                }
                if pairs.is_empty() || pairs.len() > too_many {
                    break;
                }
            }
            if least.2.is_empty() {
                break;
            }
        }
        (*surfaced, *outcome, pairs) = least;
        for pair in pairs {
            let corner = surfaced.triangles[pair[0] as usize][0];
            let place = surfaced.positions[corner as usize];
            outcome.unkept.push((Unkept::Crossing, place));
            let group = |triangle: u32| surfaced.groups[triangle as usize] as usize;
            let surfaces = pair.map(|triangle| surfaced.surface_of_group[group(triangle)]);
            outcome.tighter.extend(surfaces);
        }
        Ok(())
    }
}

/// Whether a mesh to a tolerance is not to be tried in another way: nothing is to
/// be reported, or what was asked for does not fit a limit.
fn is_final(report: &Report) -> bool {
    report.complaints() == 0 || !report.limits_reached.is_empty()
}

fn is_too_late(error: &Error) -> bool {
    matches!(error, Error::LimitReached(reached) if matches!(reached.limit, Limit::Time(_)))
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

/// The pairs of triangles that run through each other once a mesh's points are
/// moved: rounding decides where faces meet in a plane.
fn crossing_pairs(surfaced: &Surfaced, by: DVec3) -> Vec<[u32; 2]> {
    let mesh = Mesh {
        positions: surfaced.positions.iter().map(|&p| p + by).collect(),
        triangles: surfaced.triangles.clone(),
        ..Mesh::default()
    };
    mesh.self_intersections()
}

/// Moves all points.
fn move_by(positions: &mut [DVec3], by: DVec3) {
    if by != DVec3::ZERO {
        positions
            .par_chunks_mut(4096)
            .for_each(|chunk| chunk.iter_mut().for_each(|p| *p += by));
    }
}
