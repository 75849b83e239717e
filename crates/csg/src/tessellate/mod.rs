//! From a mesh whose topology is right to one with just enough triangles: no
//! point of it is farther than the tolerance from the boundary, nor the
//! reverse.
//!
//! 1. [`coarsen`] takes out what vertices can be spared.
//! 2. [`curves`] finds for every curve between two faces the points that it
//!    needs, and [`grow`] puts them in, coarse to fine, and those that the
//!    faces need; [`flips`] keeps triangles in shape.
//! 3. Faces that bend both ways are only cut into large triangles that way
//!    ([`patches`]), which [`fill`] then fills with small ones in one step.
//! 4. [`deviation`] bounds how far the result strays.
//!
//! Where triangles of the result run through each other, [`mod@separate`] cuts them up.
//!
//! Vertices never leave their surfaces. [`mod@parts`] of the mesh that are not connected are
//! refined at once; within one of them, one thread does all but the filling, in a fixed
//! order. Walls thinner than the tolerance are cut up alike on both sides ([`mirror`]).

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
mod round;
mod separate;
mod shape;
mod side;
mod smooth;
mod surfaced;

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

pub(crate) use self::goal::Goal;
use self::grow::Grower;
use self::half_edges::HalfEdges;
use self::hand_back::hand_back;
pub(crate) use self::outcome::{Outcome, Unkept};
pub(crate) use self::parts::{Refined, join, join_refined, parts};
pub(crate) use self::separate::{Parting, folded, separate};
use self::surfaced::{BYTES_PER_FINISHED, BYTES_PER_TRIANGLE};
pub(crate) use self::surfaced::{Surfaced, precision};
use crate::control::Control;
use crate::error::Error;
use crate::program::Surface;

/// Brings the parts of a mesh to the tolerance with as few triangles as it knows how, each for
/// itself.
///
/// `surfaces` are in the frame of the positions. Parts must be closed,
/// oriented and manifold, its vertices on the surfaces of their triangles to
/// rounding. Some hundred nanoseconds a triangle, of the mesh given or that
/// returned, on one thread for each part.
pub(crate) fn to_tolerance(
    parts: &[Surfaced],
    surfaces: &[Surface],
    goal: &Goal,
    control: &Control,
) -> Result<Vec<Refined>, Error> {
    let triangles = AtomicUsize::new(0);
    let refine = |part: &Surfaced| {
        let refined = refine(part, surfaces, goal, control)?;
        let count = refined.surfaced.triangles.len();
        let all = count + triangles.fetch_add(count, Ordering::Relaxed);
        control.check_triangles(all)?;
        control.check_memory(BYTES_PER_FINISHED * all)?;
        Ok(refined)
    };
    if let [part] = parts {
        return Ok(vec![refine(part)?]);
    }
    let originals = mirror::originals(parts, surfaces, goal);
    let some = |wanted: &(dyn Fn(usize) -> Result<Option<Refined>, Error> + Sync)| {
        // All of them, whichever fails first.
        let made: Vec<Result<Option<Refined>, Error>> =
            (0..parts.len()).into_par_iter().map(wanted).collect();
        made.into_iter()
            .collect::<Result<Vec<Option<Refined>>, Error>>()
    };
    let mut refined = some(&|part| match originals[part] {
        mirror::NONE => refine(&parts[part]).map(Some),
        _ => Ok(None),
    })?;
    let images = some(&|part| {
        let original = originals[part];
        if original == mirror::NONE {
            return Ok(None);
        }
        let original = refined[original as usize].as_ref();
        let image = original.and_then(|of| mirror::image(&parts[part], of, surfaces, goal));
        image.map_or_else(|| refine(&parts[part]), Ok).map(Some)
    })?;
    for (refined, image) in refined.iter_mut().zip(images) {
        if image.is_some() {
            *refined = image;
        }
    }
    Ok(refined.into_iter().flatten().collect())
}

/// Brings a mesh to the tolerance on one thread.
fn refine(
    surfaced: &Surfaced,
    surfaces: &[Surface],
    goal: &Goal,
    control: &Control,
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
    coarsen::coarsen(&mut mesh, goal);
    control.check()?;
    let mut grower = Grower::new(&mut mesh, goal, surfaced.precision);
    grower.cut_contacts();
    grower.run(control)?;
    let (outcome, fine) = (grower.outcome, grower.fine);
    let mut refined = surfaced.empty();
    hand_back(&mesh, &fine, &mut refined);
    control.check_triangles(refined.triangles.len())?;
    Ok(Refined {
        surfaced: refined,
        outcome,
    })
}
