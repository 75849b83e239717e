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
//! Vertices never leave their surfaces. One thread does all but the
//! tessellation, in a fixed order.

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
mod outcome;
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

pub(crate) use self::goal::Goal;
use self::grow::Grower;
use self::half_edges::HalfEdges;
use self::hand_back::hand_back;
pub(crate) use self::outcome::{Outcome, Unkept};
pub(crate) use self::separate::{Parting, folded, separate};
pub(crate) use self::surfaced::Surfaced;
use self::surfaced::{BYTES_PER_TRIANGLE, precision};
use crate::control::Control;
use crate::error::Error;
use crate::program::Surface;

/// Brings a mesh to the tolerance with as few triangles as it knows how.
///
/// `surfaces` are in the frame of the positions. The mesh must be closed,
/// oriented and manifold, its vertices on the surfaces of their triangles to
/// rounding. Some hundred nanoseconds a triangle, of the mesh given or that
/// returned.
pub(crate) fn to_tolerance(
    surfaced: &mut Surfaced,
    surfaces: &[Surface],
    goal: &Goal,
    control: &Control,
) -> Result<Outcome, Error> {
    let precision = precision(&surfaced.positions);
    let Some(mut mesh) = HalfEdges::new(surfaced, surfaces) else {
        let place = surfaced.positions.first().copied().unwrap_or_default();
        return Ok(Outcome {
            deviation: f64::INFINITY,
            farthest: place,
            unkept: vec![(Unkept::NotManifold, place)],
            tighter: Vec::new(),
        });
    };
    control.check_memory(BYTES_PER_TRIANGLE * surfaced.triangles.len())?;
    mesh.fix_contacts();
    coarsen::coarsen(&mut mesh, goal);
    control.check()?;
    let mut grower = Grower::new(&mut mesh, goal, precision);
    grower.cut_contacts();
    grower.run(control)?;
    let (outcome, fine) = (grower.outcome, grower.fine);
    hand_back(&mesh, &fine, surfaced);
    control.check_triangles(surfaced.triangles.len())?;
    Ok(outcome)
}
