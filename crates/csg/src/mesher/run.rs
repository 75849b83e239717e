//! One run of a mesher: which way the mesh is made, what is done when it fails
//! or costs too much, and what a finished mesh still gets.

mod prepare;
mod slab;
mod tolerance;
mod uncut;

use crate::clock::Instant;
use crate::elementary;

use glam::DVec3;
use rayon::prelude::*;

use super::fit::{HALVINGS, fit, is_too_much};
use super::options::{Mesher, Method};
use crate::adapt;
use crate::arrangement::{self, Borders, Chords, Evaluated};
use crate::control::Control;
use crate::draft;
use crate::error::Error;
use crate::finish;
use crate::limits::{Demand, Limit, LimitReached};
use crate::mesh::Mesh;
use crate::numeric::tolerance::{HELD, MAPPED, MOVED_AT_EDGES, NEAR};
use crate::program::{Bounds, Program};
use crate::report::Report;
use crate::settling::Settling;
use crate::surface_nets;
use crate::task::Task;
use crate::tessellate::{Goal, Unkept};
use crate::verify;

/// Bytes that the check of a mesh needs for each triangle, while it runs.
const CHECK_BYTES: usize = 100;

/// The stage of tries whose mesh was not kept, and of what lies between stages.
const REST: &str = "rest";

/// Shares of the whole, about as long as they take: where a mesh of the right topology is
/// there, where it keeps its tolerance, and where it no longer runs through itself.
const SHAPED: f64 = 0.1;
const REFINED: f64 = 0.5;
const PARTED: f64 = 0.87;

/// Where a mesh without a tolerance is there, if it is then checked.
const MESHED: f64 = 0.5;

/// Of what is left once the mesh is there: where it has normals, where it is known whether it is
/// closed, and where its distances are.
const SHADED: f64 = 0.3;
const COUNTED: f64 = 0.55;
const CHECKED: f64 = 0.75;

/// A finished mesh and how it came about.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Meshed {
    /// The mesh.
    pub mesh: Mesh,
    /// What was done for it, and what could not be done.
    pub report: Report,
}

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

impl<'a> Run<'a> {
    /// Of work that began at `start`.
    pub fn new(mesher: &'a Mesher, program: &'a Program, start: Instant) -> Result<Self, Error> {
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
        finish::put_on_carriers(self.program, &mut mesh);
        mesh.unit = mesher.unit;
        let start = Instant::now();
        // Each try writes its own report, and only one of them is kept.
        let whole = (start - self.start).as_secs_f64();
        let told: f64 = report.stages.iter().map(|(_, seconds)| seconds).sum();
        report.stages.push((REST, (whole - told).max(0.0)));
        let made = if self.goal.is_some() {
            PARTED
        } else {
            self.shaped()
        };
        let tell = |share: f64| self.control.tell(made + (1.0 - made) * share);
        tell(0.0);
        if mesher.normals {
            let surface = |triangle: usize| finish::surface_of(self.program, &mesh, triangle);
            mesh.corner_normals = finish::corner_normals(&mesh, surface);
            report.end_stage("normals", start);
        }
        tell(SHADED);
        let start = Instant::now();
        if let Some(angle) = mesher.feature_angle {
            mesh.feature_edges = finish::feature_edges(self.program, &mesh, angle);
            report.end_stage("feature edges", start);
        }
        if mesher.check {
            let start = Instant::now();
            let count = || {
                let check = mesh.check();
                tell(COUNTED);
                check
            };
            let largest = || finish::largest_distances(self.program, &mesh);
            let (check, largest) = rayon::join(count, largest);
            report.check = check;
            (
                report.largest_vertex_distance,
                report.largest_centroid_distance,
            ) = largest;
            let start = report.end_stage("check", start);
            tell(CHECKED);
            let is_to_tolerance = self.goal.is_some() && self.smallest.is_some();
            if is_to_tolerance || report.method == "polyhedral" {
                self.hold_against_program(&mesh, &mut report)?;
                report.end_stage("rays", start);
            }
        }
        self.control.tell(1.0);
        Ok(Meshed { mesh, report })
    }

    /// Looks for places where a mesh of the whole solid is not its boundary.
    fn hold_against_program(&self, mesh: &Mesh, report: &mut Report) -> Result<(), Error> {
        let bounds = match report.method {
            "polyhedral" => self.program.loose_bounds()?,
            _ => report.bounds,
        };
        let Some(bounds) = bounds else {
            return Ok(());
        };
        let size = bounds.size().max_element();
        let tolerance = self.goal.as_ref().map_or(0.0, |goal| goal.tolerance);
        let deviation = report.deviation.filter(|d| d.is_finite()).unwrap_or(0.0);
        let unseen = 2.0 * report.moved.map_or(0.0, |moved| moved.distance) + NEAR * size;
        let tolerance = tolerance.max(deviation).max(unseen).max(HELD * size);
        let held = verify::Tolerances { tolerance, unseen };
        let found = verify::differences(self.program, mesh, &bounds, held);
        for place in found.places {
            report.add_fallback(verify::DIFFERENCE, place);
        }
        report.difference = found.share;
        Ok(())
    }

    /// The mesh itself, about the true origin.
    fn shape(&self, report: &mut Report) -> Result<Mesh, Error> {
        // A box without extent holds no solid: at most a point was left of it.
        let has_extent = |bounds: &Bounds| bounds.size().max_element() > 0.0;
        let program = self.program;
        self.control.check()?;
        if let Some(mesh) = self.with_uncut(report)? {
            return Ok(mesh);
        }
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
        self.check_tolerance(&bounds)?;
        let mesh = self.coarse_to_fine(bounds, report)?;
        if let Some(reached) = beyond {
            report.limits_reached.push(LimitReached {
                kept: Some(report.cell_size),
                ..reached
            });
        }
        Ok(mesh)
    }

    /// An error for a tolerance that no coordinates can keep.
    fn check_tolerance(&self, bounds: &Bounds) -> Result<(), Error> {
        let Some(goal) = &self.goal else {
            return Ok(());
        };
        let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
        let least = MAPPED * farthest;
        if goal.tolerance < least && !self.program.is_polyhedral() {
            return Err(Error::InvalidOption(format!(
                "a tolerance of {:e}: coordinates of up to {farthest} are rounded by more; \
                 give at least {least:.1e}, or move the solid to the origin",
                goal.tolerance
            )));
        }
        Ok(())
    }

    /// The exact boundary of planes; none where it could not be closed.
    fn polyhedral(&self, loose: Bounds, report: &mut Report) -> Result<Option<Mesh>, Error> {
        let control = self.control.again(Demand::ExactBoundary);
        for settling in Settling::ALL {
            let mut attempt = report.clone();
            let places: Vec<DVec3> = report.undecided.iter().map(|u| u.place).collect();
            let Some(settled) = self.settle(&loose, settling, &places, &mut attempt)? else {
                continue;
            };
            let task = Task::new(settled.program(self.program), loose, 0.0, &control);
            let mut mesh = match arrangement::mesh(&task, (&Chords::LONG, 0.0), &mut attempt)? {
                Ok(evaluated) if settling.has_lost(evaluated.mesh.triangles.is_empty()) => continue,
                Ok(Evaluated { mesh, .. }) => mesh,
                Err(undecided) => {
                    report.undecided.push(undecided);
                    continue;
                }
            };
            let (moved, _) = settled.moved_boundary(&mesh, &task.surfaces, attempt.moved);
            attempt.deviation = attempt.deviation.map(|deviation| deviation + moved);
            self.check_size(&mesh, &control)?;
            move_by(&mut mesh.positions, task.origin);
            attempt.bounds = mesh.bounds().map(|(min, max)| Bounds { min, max });
            if self.mesher.check {
                for place in crossings(&mesh) {
                    attempt.add_fallback(Unkept::Crossing.describe(), place);
                }
            }
            *report = attempt;
            return Ok(Some(mesh));
        }
        Ok(None)
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
        for pass in (0..=(elementary::ln(factor) / elementary::ln(FINER))
            .ceil()
            .clamp(0.0, 30.0) as i32)
            .rev()
        {
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
        let control = self.shaping(Demand::Cells(cell));
        let task = Task::new(self.program, bounds, cell, &control);
        let evaluated = self.evaluated(&task, factor, report)?;
        // A boundary with something to be reported is better than cells, which report more.
        let (mut mesh, attempt) = match evaluated {
            Some(evaluated) => evaluated,
            None => {
                let mut attempt = report.clone();
                (self.by_cells_alone(&task, factor, &mut attempt)?, attempt)
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
            Method::Exact => surface_nets::mesh(task, report)?,
        };
        if let Some(goal) = &self.goal {
            let goal = goal.loosened(factor);
            self.refine(&mut mesh, Borders::default(), task, &goal, report)?;
        }
        Ok(mesh)
    }

    /// For a mesh of the right topology, which is all there is to do without a tolerance.
    fn shaping(&self, demand: Demand) -> Control {
        self.control.again(demand).part(0.0, self.shaped())
    }

    /// The share of the whole where that is done.
    fn shaped(&self) -> f64 {
        match &self.goal {
            Some(_) => SHAPED,
            None if self.mesher.check => MESHED,
            None => 1.0,
        }
    }

    /// The mesh to a tolerance without cells, from the curves in which surfaces
    /// meet, and its report; none where they are not known.
    fn evaluated(
        &self,
        task: &Task<'_>,
        factor: f64,
        report: &mut Report,
    ) -> Result<Option<(Mesh, Report)>, Error> {
        let Some(goal) = &self.goal else {
            return Ok(None);
        };
        let is_tried = self.program.is_polyhedral();
        if self.smallest.is_none() || self.mesher.bounds.is_some() || is_tried {
            return Ok(None);
        }
        let control = self.shaping(Demand::ExactBoundary);
        let bounds = task.bounds();
        let goal = Goal {
            even_curves: true,
            ..goal.loosened(factor)
        };
        let mut best: Option<(Mesh, Report)> = None;
        // Shorter chords tell no more.
        let mut untold: Vec<Settling> = Vec::new();
        for (settling, chords) in Settling::with_chords() {
            if untold.contains(&settling) {
                continue;
            }
            let mut attempt = report.clone();
            let undecided = report.undecided.iter().map(|undecided| undecided.place);
            let fallbacks = best.iter().flat_map(|(_, report)| &report.fallbacks);
            let complaints = fallbacks.flat_map(|fallback| fallback.places.iter().copied());
            let places: Vec<DVec3> = undecided.chain(complaints).collect();
            let settled = self.settle(&bounds, settling, &places, &mut attempt)?;
            let Some(settled) = settled else {
                untold.push(settling);
                continue;
            };
            let task = match settled.moved() {
                Some(moved) => Task::new(&moved.program, bounds, task.cell, &control),
                None => task.with(&control),
            };
            // Together with the moves it is what was asked for.
            let asked = &goal;
            let goal = asked.less(settled.distance());
            attempt.method = "boundary";
            let chords = (chords, goal.tolerance);
            let made = arrangement::mesh(&task, chords, &mut attempt).and_then(|evaluated| {
                let Evaluated { mut mesh, borders } = match evaluated {
                    Ok(evaluated) if settling.has_lost(evaluated.mesh.triangles.is_empty()) => {
                        return Ok(None);
                    }
                    Ok(evaluated) => evaluated,
                    Err(undecided) => {
                        report.undecided.push(undecided);
                        return Ok(None);
                    }
                };
                let (moved, place) = settled.moved_boundary(&mesh, &task.surfaces, attempt.moved);
                let most = MOVED_AT_EDGES * asked.tolerance;
                let goal = asked.less(moved.min(most));
                self.refine(&mut mesh, borders, &task, &goal, &mut attempt)?;
                attempt.deviation = attempt.deviation.map(|deviation| deviation + moved);
                if moved > most {
                    attempt.add_fallback(Unkept::Far.describe(), place + task.origin);
                }
                Ok(Some(mesh))
            });
            let mesh = match made {
                Ok(Some(mesh)) => mesh,
                Ok(None) => {
                    untold.push(settling);
                    continue;
                }
                // Cells may be larger.
                Err(error) if is_too_much(&error).is_some() => return Ok(best),
                Err(error) => return Err(error),
            };
            let is_final = is_final(&attempt);
            let complaints = attempt.complaints();
            if best
                .as_ref()
                .is_none_or(|best| complaints < best.1.complaints())
            {
                best = Some((mesh, attempt));
            }
            if is_final {
                return Ok(best);
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
}

/// Whether a mesh to a tolerance is not to be tried in another way: nothing is to
/// be reported, or what was asked for does not fit a limit.
fn is_final(report: &Report) -> bool {
    report.complaints() == 0 || !report.limits_reached.is_empty()
}

fn is_too_late(error: &Error) -> bool {
    matches!(error, Error::LimitReached(reached) if matches!(reached.limit, Limit::Time(_)))
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
