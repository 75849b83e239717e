//! From a program to its boundary.

use std::sync::Arc;

use super::build::build;
use super::data::Brep;
use glam::DVec3;

use super::uncut::Joining;
use crate::arrangement::{self, Arrangement};
use crate::control::{Caller, CancelToken, Control};
use crate::error::Error;
use crate::limits::{Demand, Limits};
use crate::program::{Apart, Bounds, Program, Surface};
use crate::report::Report;
use crate::settling::{Prepared, Settling};
use crate::task::Task;
use crate::undecided::Undecided;

/// How a boundary is to be evaluated: see [`Program::boundary`].
#[derive(Clone, Debug, Default)]
#[must_use]
pub struct BoundaryOptions {
    limits: Limits,
    caller: Caller,
    most_moved: Option<f64>,
    cut_at_seams: bool,
}

impl BoundaryOptions {
    /// With no limits but the machine's memory.
    pub fn new() -> Self {
        Self::default()
    }

    /// How much it may cost: blocks of space are counted as cells.
    pub fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// Calls back with the share that is done, from 0 to 1, from any thread.
    pub fn progress(mut self, callback: impl Fn(f64) + Send + Sync + 'static) -> Self {
        self.caller.progress = Some(Arc::new(callback));
        self
    }

    /// A handle with which another thread may stop the work.
    pub fn cancel_token(mut self, token: CancelToken) -> Self {
        self.caller.cancel = token;
        self
    }

    /// How far surfaces may be moved, in model units, where they nearly coincide or touch and
    /// it cannot be told what they do where they are: a hundred-thousandth of the solid's
    /// longest side, unless said otherwise. What was done is told by [`Brep::moved`].
    pub fn most_moved(mut self, distance: f64) -> Self {
        self.most_moved = Some(distance);
        self
    }

    /// Cuts faces along seams, planes through centres and axes, so that each has a chart, as some
    /// formats want: those of cylinders and cones at one line, if they go all around, and whole spheres
    /// at half a great circle ([`crate::brep::Face::meridian`]); they are on both sides of it
    /// then. Others are cut so that each is seen whole from one direction
    /// ([`crate::brep::Face::view`]): an ellipsoid has eight faces, and as many a
    /// sphere that others cut.
    ///
    /// Faces that others touch from within along a curve are not slit there but go on, and the others
    /// meet in an edge: a void that touches its body in curves alone is a shell of its own. Where a loop leads through one point more than once, as parts
    /// that touch there are in it, it has vertices.
    pub fn cut_at_seams(mut self) -> Self {
        self.cut_at_seams = true;
        self
    }
}

/// Of the longest side, how far surfaces may be moved unless said otherwise: a hundredth of the
/// default tolerance of meshes, as these are made.
const MOST_MOVED: f64 = 1e-5;

impl Program {
    /// The exact boundary: faces on the surfaces themselves, edges on their curves.
    ///
    /// The result is the same for any number of threads. An empty solid has an empty one.
    /// Takes about as long as a coarse mesh.
    ///
    /// # Errors
    /// [`Error::Unbounded`] for a solid that reaches infinitely far,
    /// [`Error::InvalidOption`] for a distance that is negative or not finite,
    /// [`Error::Undecided`] where surfaces meet in a way that could not be told,
    /// [`Error::LimitReached`] if it would cost more than allowed,
    /// [`Error::Cancelled`] when asked to stop.
    pub fn boundary(&self, options: &BoundaryOptions) -> Result<Brep, Error> {
        if let Some(distance) = options.most_moved
            && !(distance >= 0.0 && distance.is_finite())
        {
            return Err(Error::InvalidOption(format!(
                "surfaces may be moved by {distance}: give a distance of 0 or more"
            )));
        }
        let control = Control::start(&options.caller, options.limits, Demand::ExactBoundary);
        control.check()?;
        let bounds = if self.is_polyhedral() {
            self.loose_bounds()?
        } else {
            self.bounds()?
        };
        // A box without extent holds no solid: at most a point was left of it.
        let bounds = bounds.filter(|bounds| bounds.size().max_element() > 0.0);
        let Some(bounds) = bounds else {
            return Ok(Brep::empty());
        };
        let unseen = MOST_MOVED * bounds.size().max_element();
        let most_moved = options.most_moved.unwrap_or(unseen);
        if let Some(brep) = with_uncut(self, bounds, options, &control)? {
            control.tell(1.0);
            return Ok(brep);
        }
        let mut undecided: Vec<Undecided> = Vec::new();
        for settling in Settling::ALL {
            let places: Vec<DVec3> = undecided.iter().map(|undecided| undecided.place).collect();
            let prepared = Prepared::new(self, &bounds, settling, most_moved, &places)?;
            let Some(prepared) = prepared else {
                continue;
            };
            let control = control.again(Demand::ExactBoundary);
            match evaluated(prepared.program(self), bounds, options, &control)? {
                Ok(brep) if settling.has_lost(brep.faces.is_empty()) => {}
                Ok(mut brep) => {
                    brep.moved = prepared.told(&bounds);
                    brep.between = prepared.volume_between(&bounds);
                    control.tell(1.0);
                    return Ok(brep);
                }
                Err(found) => undecided.push(found),
            }
        }
        // What is wrong with the solid as it is.
        match undecided.first() {
            Some(&undecided) => Err(Error::Undecided(undecided)),
            None => Ok(Brep::empty()),
        }
    }
}

/// The boundary of a solid with many uncut faces; none if there are few, or if the rest is
/// undecided or does not fit them.
fn with_uncut(
    program: &Program,
    bounds: Bounds,
    options: &BoundaryOptions,
    control: &Control,
) -> Result<Option<Brep>, Error> {
    let Some(Apart { uncut, rest }) = program.apart() else {
        return Ok(None);
    };
    let control = control.again(Demand::ExactBoundary);
    let task = Task::new(rest, bounds, 0.0, &control);
    let carriers = program.carriers().iter();
    let carriers = carriers.map(|surface| surface.relative_to(task.origin));
    let surfaces: Vec<Surface> = carriers.chain(task.surfaces.iter().copied()).collect();
    let origins = program.origins();
    let rest = if task.surfaces.is_empty() {
        Arrangement {
            rounding: arrangement::rounding(task.origin, task.size.max_element()),
            ..Arrangement::default()
        }
    } else {
        match arrangement::arrangement(&task, &mut Report::default())? {
            Ok(arrangement) => arrangement,
            Err(_) => return Ok(None),
        }
    };
    let joining = Joining {
        uncut,
        surfaces: &surfaces,
        origins,
        origin: task.origin,
    };
    let Some(whole) = joining.with(rest) else {
        return Ok(None);
    };
    let brep = Brep {
        origin: task.origin,
        surfaces,
        origins: origins.to_vec(),
        ..Brep::empty()
    };
    Ok(built(brep, whole, bounds, options).ok())
}

fn evaluated(
    program: &Program,
    bounds: Bounds,
    options: &BoundaryOptions,
    control: &Control,
) -> Result<Result<Brep, Undecided>, Error> {
    let task = Task::new(program, bounds, 0.0, control);
    let mut report = Report::default();
    let arrangement = match arrangement::arrangement(&task, &mut report)? {
        Ok(arrangement) => arrangement,
        Err(undecided) => return Ok(Err(undecided)),
    };
    let brep = Brep {
        origin: task.origin,
        surfaces: task.surfaces,
        origins: program.origins().to_vec(),
        ..Brep::empty()
    };
    Ok(built(brep, arrangement, bounds, options))
}

/// The boundary of an arrangement on given surfaces.
fn built(
    on: Brep,
    arrangement: Arrangement,
    bounds: Bounds,
    options: &BoundaryOptions,
) -> Result<Brep, Undecided> {
    let brep = Brep {
        rounding: arrangement.rounding,
        size: bounds.size().length(),
        is_cut_at_seams: options.cut_at_seams,
        ..on
    };
    let origin = brep.origin;
    build(brep, arrangement, options.cut_at_seams).map_err(|undecided| Undecided {
        place: undecided.place + origin,
        ..undecided
    })
}
