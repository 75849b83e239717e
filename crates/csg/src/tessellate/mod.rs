//! From a mesh whose topology is right to one with just enough triangles: no
//! point of it is farther than the tolerance from the boundary, nor the
//! reverse.
//!
//! 1. [`coarsen`] takes out what vertices can be spared.
//! 2. [`curves`] finds for every curve between two faces the points that it
//!    needs, and [`mod@alongside`] lets those that run side by side have theirs in the same
//!    places; [`grow`] puts them in, coarse to fine, and those that the faces need; [`flips`]
//!    keeps triangles in shape.
//! 3. Faces that bend both ways are only cut into large triangles that way
//!    ([`patches`]), which [`fill`] then fills with small ones in one step.
//! 4. [`deviation`] bounds how far the result strays.
//!
//! Where triangles of the result run through each other, [`mod@separate`] cuts them up.
//!
//! Vertices never leave their surfaces. [`mod@parts`] of the mesh that are not connected are
//! refined at once; within one of them, one thread does all but the filling, in a fixed
//! order. Spheres that are whole are [`geodesic`] polyhedra; walls thinner than the tolerance
//! are cut up alike on both sides ([`mirror`]).

mod alongside;
mod beside;
mod chains;
mod coarsen;
mod conics;
mod contacts;
mod course;
mod curves;
pub(crate) mod deviation;
mod fill;
mod fine;
mod flips;
mod geodesic;
mod goal;
mod grow;
mod half_edges;
mod hand_back;
mod judge;
mod mirror;
mod outcome;
mod parts;
mod patch;
mod patches;
mod piece;
mod project;
mod region;
mod regions;
mod separate;
mod shape;
mod side;
mod smooth;
mod surfaced;
mod whole;

use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

pub(crate) use self::goal::Goal;
use self::grow::{BEGUN, Grower};
use self::half_edges::HalfEdges;
use self::hand_back::hand_back;
pub(crate) use self::mirror::mirrored;
pub(crate) use self::outcome::{Outcome, Unkept};
pub(crate) use self::parts::{Refined, join, join_refined, parts};
pub(crate) use self::separate::{Parting, Separation, folded};
use self::surfaced::{BYTES_PER_FINISHED, BYTES_PER_TRIANGLE};
pub(crate) use self::surfaced::{Surfaced, precision};
use self::whole::Whole;
use crate::control::Control;
use crate::error::Error;
use crate::program::Surface;

/// Brings the parts of a mesh to the tolerance with as few triangles as it knows how, each for
/// itself.
///
/// `surfaces` are in the frame of the positions. Parts must be closed,
/// oriented and manifold, their vertices on the surfaces of their triangles to
/// rounding. Some hundred nanoseconds a triangle, of the mesh given or that
/// returned, on one thread for each part.
pub(crate) fn to_tolerance(
    parts: &[Surfaced],
    surfaces: &[Surface],
    goal: &Goal,
    control: &Control,
) -> Result<Vec<Refined>, Error> {
    let triangles = AtomicUsize::new(0);
    // Told of the steps of every part.
    let all: usize = parts.iter().map(|part| part.triangles.len()).sum();
    let stage = control.stage(STEPS * all as u64, 0.0, 1.0);
    let wholes = parts.iter().map(|part| Whole::of(part, surfaces));
    let wholes: Vec<Option<Whole<'_>>> = wholes.collect();
    let refine = |part: usize| {
        let sphere = match &wholes[part] {
            Some(whole) => geodesic::sphere(&parts[part], whole, goal, control)?,
            None => None,
        };
        let step = parts[part].triangles.len() as u64;
        let told = Cell::new(0);
        let tell = |share: f64| {
            let now = told.get().max((STEPS as f64 * share) as u64);
            stage.add(step * (now - told.replace(now)));
        };
        let refined = match sphere {
            Some(sphere) => sphere,
            None => refine(&parts[part], surfaces, goal, control, &tell)?,
        };
        tell(1.0);
        let count = refined.surfaced.triangles.len();
        let all = count + triangles.fetch_add(count, Ordering::Relaxed);
        control.check_triangles(all)?;
        control.check_memory(BYTES_PER_FINISHED * all)?;
        Ok(refined)
    };
    // All of them, whichever fails first.
    let some = |wanted: &(dyn Fn(usize) -> Result<Option<Refined>, Error> + Sync)| {
        let made: Vec<Result<Option<Refined>, Error>> = match parts.len() {
            1 => vec![wanted(0)],
            count => (0..count).into_par_iter().map(wanted).collect(),
        };
        made.into_iter()
            .collect::<Result<Vec<Option<Refined>>, Error>>()
    };
    let originals = mirror::originals(&wholes, goal);
    let mut refined = some(&|part| match originals[part] {
        mirror::NONE => refine(part).map(Some),
        _ => Ok(None),
    })?;
    let images = some(&|part| {
        let Some(original) = refined.get(originals[part] as usize) else {
            return Ok(None);
        };
        let pair = [part, originals[part] as usize].map(|part| wholes[part].as_ref());
        let image = match (pair, original) {
            ([Some(whole), Some(other)], Some(original)) => {
                let is_turned = whole.is_void != other.is_void;
                let image = mirror::image(&parts[part], whole, original, is_turned, goal);
                let steps = STEPS * parts[part].triangles.len() as u64;
                image.inspect(|_| stage.add(steps))
            }
            _ => None,
        };
        image.map_or_else(|| refine(part), Ok).map(Some)
    })?;
    for (refined, image) in refined.iter_mut().zip(images) {
        if image.is_some() {
            *refined = image;
        }
    }
    Ok(refined.into_iter().flatten().collect())
}

/// Of a part that is refined.
const STEPS: u64 = 100;

/// Brings a mesh to the tolerance on one thread. Tells what share of it is done.
fn refine(
    surfaced: &Surfaced,
    surfaces: &[Surface],
    goal: &Goal,
    control: &Control,
    tell: &impl Fn(f64),
) -> Result<Refined, Error> {
    let Some(mut mesh) = HalfEdges::new(surfaced, surfaces) else {
        let place = surfaced.positions.first().copied().unwrap_or_default();
        let outcome = Outcome {
            deviation: f64::INFINITY,
            farthest: place,
            unkept: vec![(Unkept::NotManifold, place)],
            tighter: Vec::new(),
        };
        return Ok(Refined {
            surfaced: surfaced.clone(),
            outcome,
        });
    };
    control.check_memory(BYTES_PER_TRIANGLE * surfaced.triangles.len())?;
    mesh.fix_contacts();
    if !goal.keeps_vertices {
        coarsen::coarsen(&mut mesh, goal);
    }
    control.check()?;
    let mut grower = Grower::new(&mut mesh, goal, surfaced.precision);
    grower.cut_contacts();
    tell(BEGUN);
    grower.run(control, tell)?;
    let (outcome, fine) = (grower.outcome, grower.fine);
    let mut refined = surfaced.empty();
    hand_back(&mesh, &fine, &mut refined);
    control.check_triangles(refined.triangles.len())?;
    Ok(Refined {
        surfaced: refined,
        outcome,
    })
}
