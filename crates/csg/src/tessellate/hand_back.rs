//! From the mesh at work to the finished one.

use super::fine::{Fine, INNER, ON_SIDE};
use super::half_edges::{HalfEdges, NONE, first_of};
use super::region::Way;
use super::surfaced::Surfaced;
use crate::program::SurfaceId;

/// The mesh without what is gone, and with what was tessellated.
pub(super) fn hand_back(mesh: &HalfEdges<'_>, fine: &Fine, surfaced: &mut Surfaced) {
    surfaced.triangles.clear();
    surfaced.groups.clear();
    let mut places = vec![NONE; mesh.positions.len()];
    let mut places_on_sides = vec![NONE; fine.points.len()];
    let mut positions = Vec::with_capacity(mesh.positions.len() + fine.points.len());
    for subdivision in &fine.subdivisions {
        let first_inner = positions.len() as u32;
        positions.extend_from_slice(&subdivision.inner);
        let mut place = |vertex: u32| {
            let (place, position) = if vertex >= ON_SIDE {
                let point = (vertex - ON_SIDE) as usize;
                (&mut places_on_sides[point], fine.points[point])
            } else if vertex >= INNER {
                return vertex - INNER + first_inner;
            } else {
                (&mut places[vertex as usize], mesh.at(vertex))
            };
            if *place == NONE {
                *place = positions.len() as u32;
                positions.push(position);
            }
            *place
        };
        let group = mesh.region(first_of(subdivision.large)).group;
        let triangles = subdivision
            .triangles
            .iter()
            .map(|&[a, b, c]| [place(a), place(b), place(c)]);
        surfaced.triangles.extend(triangles);
        surfaced.groups.resize(surfaced.triangles.len(), group);
    }
    let mut place = |vertex: u32| {
        let place = &mut places[vertex as usize];
        if *place == NONE {
            *place = positions.len() as u32;
            positions.push(mesh.at(vertex));
        }
        *place
    };
    for triangle in 0..mesh.triangle_count() {
        if mesh.is_gone(triangle) || mesh.region(first_of(triangle)).way == Way::Done {
            continue;
        }
        let [a, b, c] = mesh.triangle(triangle);
        surfaced.triangles.push([place(a), place(b), place(c)]);
        surfaced.groups.push(mesh.region(first_of(triangle)).group);
    }
    surfaced.positions = positions;
    let renumbered = |(ends, &other): (&[u32; 2], &SurfaceId)| {
        let mut ends = ends.map(|end| places[end as usize]);
        ends.sort_unstable();
        (!ends.contains(&NONE)).then_some((ends, other))
    };
    surfaced.borders = mesh.borders.iter().filter_map(renumbered).collect();
}
