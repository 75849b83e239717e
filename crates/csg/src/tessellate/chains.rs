//! The curves of a mesh from end to end, and where along them vertices should
//! be.

use glam::DVec3;

use super::conics::OnConic;
use super::course::Course;
use super::curves::{Stretches, is_straight};
use super::deviation;
use super::goal::Goal;
use super::half_edges::{HalfEdges, Kind, next};
use super::shape::faces_out_everywhere;
use crate::program::Surface;

/// A chain of edges along one curve, cut into chords that stray alike.
pub(super) struct Division {
    /// The points between the chain's ends.
    pub points: Vec<DVec3>,
    /// Which of the points each of the chain's edges ends in, counted from 1;
    /// the last one in none of them, one past all.
    pub ends: Vec<u32>,
    /// The largest distance of a chord, a bound; and where.
    pub deviation: f64,
    pub farthest: DVec3,
}

/// Every curve in which two surfaces meet of which one is curved, from corner to
/// corner or all around, as half-edges in a row.
pub(super) fn chains(mesh: &HalfEdges<'_>) -> Vec<Vec<u32>> {
    let mut is_done = vec![false; mesh.end_of_halves() as usize];
    let mut chains = Vec::new();
    let is_start = |half: u32| mesh.kinds[mesh.origin(half) as usize] != Kind::Curve;
    let curved: Vec<u32> = mesh.halves().filter(|&h| is_curved(mesh, h)).collect();
    // Those with ends first; what is left then goes around.
    for with_ends in [true, false] {
        for &half in &curved {
            if is_done[half as usize] || (with_ends && !is_start(half)) {
                continue;
            }
            let mut chain = Vec::new();
            let mut here = Some(half);
            while let Some(half) = here.filter(|&half| !is_done[half as usize]) {
                is_done[half as usize] = true;
                is_done[mesh.twin(half) as usize] = true;
                chain.push(half);
                here = onward(mesh, half);
            }
            chains.push(chain);
        }
    }
    chains
}

fn is_curved(mesh: &HalfEdges<'_>, half: u32) -> bool {
    if !mesh.is_on_curve(half) || mesh.is_contact(half) {
        return false;
    }
    !mesh.curve_surfaces(half).iter().all(|s| s.is_plane())
}

/// The next edge along the same curve.
fn onward(mesh: &HalfEdges<'_>, half: u32) -> Option<u32> {
    let vertex = mesh.target(half);
    if mesh.kinds[vertex as usize] != Kind::Curve {
        return None;
    }
    let back = mesh.twin(half);
    mesh.around(vertex)
        .find(|&spoke| spoke != back && mesh.is_feature(spoke))
}

/// Finds the points for a chain: as few as the tolerance asks for, but no
/// fewer chords than the chain has edges. `None` where the curve could not be
/// followed.
pub(super) fn divide(
    mesh: &HalfEdges<'_>,
    chain: &[u32],
    goal: &Goal,
    precision: f64,
) -> Option<Division> {
    const LEAST_LEFT: f64 = 0.25;
    let surfaces = mesh.curve_surfaces(chain[0]);
    let starts = chain.iter().map(|&half| mesh.at(mesh.origin(half)));
    let end = mesh.at(mesh.target(chain[chain.len() - 1]));
    let vertices: Vec<DVec3> = starts.chain([end]).collect();
    let on = |half| goal.tolerance_on(mesh.surface_id(half));
    let tolerance = on(chain[0]).min(on(mesh.twin(chain[0])));
    // What ends are off their surfaces already is not left to chords, unless that
    // is most of it.
    let off = surfaces.map(|s| [vertices[0], end].map(|p| deviation::first_order(s, p)));
    let left = tolerance - off.iter().flatten().copied().fold(0.0, f64::max);
    let goal = &Goal {
        tolerance: if left > LEAST_LEFT * tolerance {
            left
        } else {
            tolerance
        },
        ..goal.clone()
    };
    // Not to be followed where the surfaces touch along it, nor to be cut up.
    let is_line = |w: &[DVec3]| is_straight(surfaces, w[0], w[1], precision);
    if vertices.windows(2).all(is_line) {
        let inner = &vertices[1..chain.len()];
        let ends = [vertices[0], end];
        let (deviation, farthest) = farthest(surfaces, ends, inner, chain.len());
        return Some(Division {
            points: inner.to_vec(),
            ends: (1..=chain.len() as u32).collect(),
            deviation,
            farthest,
        });
    }
    let sides = [chain[0], mesh.twin(chain[0])];
    let rounds = sides.map(|side| mesh.region(side).round.as_ref());
    if let Some(course) = OnConic::new(surfaces, &vertices, rounds, goal, precision) {
        return divide_course(&course, &vertices, goal);
    }
    let course = Stretches::new(surfaces, &vertices, rounds, goal, precision)?;
    divide_course(&course, &vertices, goal)
}

fn divide_course(course: &impl Course, vertices: &[DVec3], goal: &Goal) -> Option<Division> {
    const MOST_TRIES: usize = 5;
    let edges = vertices.len() as u32 - 1;
    let mut chords = ((course.chords() - 1e-3).ceil() as u32).max(edges);
    let mut tries = 1;
    let (points, deviation, farthest) = loop {
        let points = course.points(chords)?;
        let (first, last) = (vertices[0], vertices[edges as usize]);
        let measured = if course.is_even() { 1 } else { chords };
        let (deviation, farthest) =
            farthest(course.surfaces(), [first, last], &points, measured as usize);
        let excess = deviation / goal.tolerance;
        // Curvature is the whole story only where it hardly changes.
        if excess <= 1.0 || excess == f64::INFINITY || tries == MOST_TRIES {
            break (points, deviation, farthest);
        }
        chords = (f64::from(chords) * excess.min(2.0).sqrt()) as u32 + 1;
        tries += 1;
    };
    // Every vertex goes to the nearest point.
    let mut ends = Vec::with_capacity(edges as usize);
    let mut before = 0;
    for (k, share) in (1..edges).zip(course.shares().into_iter().skip(1)) {
        let nearest = (share * f64::from(chords)).round() as u32;
        before = nearest.clamp(before + 1, chords - (edges - k));
        ends.push(before);
    }
    ends.push(chords);
    Some(Division {
        points,
        ends,
        deviation,
        farthest,
    })
}

/// The largest distance of one of the first so many chords, and its middle.
pub(super) fn farthest(
    surfaces: [&Surface; 2],
    [first, last]: [DVec3; 2],
    points: &[DVec3],
    chords: usize,
) -> (f64, DVec3) {
    let mut before = first;
    let mut farthest = (0.0, first);
    for &point in points.iter().chain([&last]).take(chords) {
        let bound = deviation::of_chord(surfaces, before, point);
        if bound > farthest.0 {
            farthest = (bound, before.midpoint(point));
        }
        before = point;
    }
    farthest
}

/// Moves the vertices of a chain to their points, unless that folds a triangle.
pub(super) fn move_vertices(mesh: &mut HalfEdges<'_>, chain: &[u32], division: &Division) -> bool {
    let vertices: Vec<u32> = chain[1..].iter().map(|&half| mesh.origin(half)).collect();
    let before: Vec<DVec3> = vertices.iter().map(|&v| mesh.at(v)).collect();
    for (&vertex, &end) in vertices.iter().zip(&division.ends) {
        mesh.positions[vertex as usize] = division.points[end as usize - 1];
    }
    let fits = vertices.iter().all(|&vertex| {
        mesh.around(vertex).all(|spoke| {
            let rim = next(spoke);
            let corners = [
                mesh.at(vertex),
                mesh.at(mesh.origin(rim)),
                mesh.at(mesh.target(rim)),
            ];
            faces_out_everywhere(mesh.surface(spoke), mesh.region(spoke), corners)
        })
    });
    if !fits {
        for (&vertex, before) in vertices.iter().zip(before) {
            mesh.positions[vertex as usize] = before;
        }
    }
    fits
}
