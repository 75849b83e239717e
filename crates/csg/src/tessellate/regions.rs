//! The faces of a mesh: connected triangles on one surface.

use super::deviation::Shrinkage;
use super::half_edges::{HalfEdges, NONE, halves_of, triangle_of};
use super::region::{Bend, Region, Way};
use super::surfaced::Surfaced;
use crate::surface::round::Round;

/// The connected faces of a mesh, which its half-edges are told.
pub(super) fn regions(mesh: &mut HalfEdges<'_>, surfaced: &Surfaced) -> Vec<Region> {
    let Surfaced {
        groups,
        surface_of_group,
        reach,
        ..
    } = surfaced;
    let mut regions = Vec::new();
    let mut pending = Vec::new();
    for seed in 0..groups.len() as u32 {
        if mesh.region_index(seed) != NONE {
            continue;
        }
        let group = groups[seed as usize];
        let id = surface_of_group[group as usize];
        let surface = &mesh.surfaces[id];
        let index = regions.len() as u32;
        let bend = Bend::of(surface);
        let round = Round::of(surface, *reach);
        // Folded triangles are outvoted by area.
        let mut facing = 0.0;
        mesh.set_region(seed, index);
        pending.push(seed);
        while let Some(triangle) = pending.pop() {
            let corners = mesh.triangle(triangle).map(|v| mesh.at(v));
            facing += match &round {
                Some(round) => round.facing(corners),
                None => {
                    let [p, q, r] = corners;
                    let gradient = match bend {
                        Bend::Flat => surface.linear,
                        _ => surface.gradient((p + q + r) / 3.0).normalize_or_zero(),
                    };
                    (q - p).cross(r - p).dot(gradient)
                }
            };
            for half in halves_of(triangle) {
                let other = triangle_of(mesh.twin(half));
                let is_new = mesh.region_index(other) == NONE;
                if is_new && groups[other as usize] == group {
                    mesh.set_region(other, index);
                    pending.push(other);
                }
            }
        }
        regions.push(Region {
            surface: id,
            group,
            bend,
            outward: if facing < 0.0 { -1.0 } else { 1.0 },
            shrinkage: Shrinkage::of(surface),
            round,
            way: Way::OneByOne,
        });
    }
    regions
}
