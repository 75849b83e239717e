//! Curved faces whose triangles would fold in space.
//!
//! Cut up as it is seen from its patch's direction, a face has triangles that
//! do not overlap there, but a long one may face away from its surface. Such
//! faces get the Delaunay triangulation of the picture (Lawson, *Software for C1
//! Surface Interpolation*, 1977), and then vertices in the middle of the longest
//! sides of what is left. A vertex that is lifted to the surface along the
//! direction of view stays where it is in the picture, so that triangles never
//! overlap there, and all face outwards once they are small.

use glam::DVec3;

use super::picture::{NONE, Picture, Slits};
use super::piece::Side;
use super::scene::Scene;
use crate::program::Surface;
use crate::surface::round::{Round, facing_cosine, facing_range};

/// Whether a triangle faces out clearly in its middle, and nowhere against its surface:
/// asked as tessellation does, of an elongated quadric where it is round.
pub(super) fn faces_out(
    surface: &Surface,
    round: Option<&Round>,
    along_normal: bool,
    corners: [DVec3; 3],
) -> bool {
    /// Of the angle between the normals: 60°.
    const LEAST_COSINE: f64 = 0.5;
    let outward = if along_normal { 1.0 } else { -1.0 };
    let range = facing_range(surface, round, corners);
    outward * facing_cosine(surface, round, corners) >= LEAST_COSINE
        && range.iter().all(|along| outward * along >= 0.0)
}

/// Cuts a curved face up anew if one of its triangles does not face outwards
/// clearly, with more vertices where it takes them. Chords at the rim of triangles
/// that still do not are added to `coarse`, by their ends: vertices next to them
/// are seen on the other side of the chord than of its curve.
pub(super) fn unfold(
    scene: &Scene<'_>,
    side: &Side,
    triangles: &mut Vec<[u32; 3]>,
    positions: &mut Vec<DVec3>,
    slits: &Slits,
    coarse: &mut Vec<[u32; 2]>,
) {
    const MOST_ROUNDS: usize = 8;
    let Some(frame) = scene.frame(side.plane) else {
        return;
    };
    let surface = scene.surface(side.plane);
    let round = frame.round.as_ref();
    let is_good = |corners: &[u32; 3], positions: &[DVec3]| {
        let corners = corners.map(|c| positions[c as usize]);
        faces_out(surface, round, side.along_normal, corners)
    };
    if triangles.iter().all(|corners| is_good(corners, positions)) {
        return;
    }
    let mut picture = Picture::new(scene, side, std::mem::take(triangles), slits);
    picture.make_delaunay(positions);
    for _ in 0..MOST_ROUNDS {
        let before = positions.len();
        for triangle in 0..picture.triangles.len() as u32 {
            let corners = picture.triangles[triangle as usize];
            // One that is turned over as it is seen, by rounding, is so in all its parts.
            if is_good(&corners, positions) || !picture.is_seen(triangle, positions) {
                continue;
            }
            let length = |half: &u32| {
                let [from, to] = picture.ends(*half);
                let along = positions[to as usize] - positions[from as usize];
                let along = round.map_or(along, |round| round.direction(along));
                along.length_squared()
            };
            let halves = 3 * triangle..3 * triangle + 3;
            let longest = halves.max_by(|a, b| length(a).total_cmp(&length(b)));
            // While the longest side is a chord at the rim, others need not be shorter.
            let is_inner = |half: &u32| picture.twins[*half as usize] != NONE;
            let Some(half) = longest.filter(is_inner) else {
                continue;
            };
            // In its middle, as it is seen.
            let [from, to] = picture.ends(half);
            let middle = positions[from as usize].midpoint(positions[to as usize]);
            let lifted = frame.lift(surface, side.patch, middle);
            let off = surface.value(lifted).abs();
            if off <= scene.weld * surface.gradient(lifted).length() {
                positions.push(lifted);
                picture.split_edge(half, positions.len() as u32 - 1, positions);
            }
        }
        if positions.len() == before {
            break;
        }
    }
    for triangle in 0..picture.triangles.len() as u32 {
        if !is_good(&picture.triangles[triangle as usize], positions) {
            let rim = 3 * triangle..3 * triangle + 3;
            let rim = rim.filter(|&half| picture.twins[half as usize] == NONE);
            coarse.extend(rim.map(|half| picture.ends(half)));
        }
    }
    *triangles = picture.triangles;
}
