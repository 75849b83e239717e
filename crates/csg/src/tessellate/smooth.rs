//! Evens out triangles before they are tessellated, so that as few small ones
//! as possible do.

use super::flips::Waiting;
use super::half_edges::{HalfEdges, Kind, next};
use super::region::Way;
use super::shape::faces_out_in_the_middle;

/// Moves the vertices inside the faces that are to be tessellated amid their
/// neighbours, and flips edges accordingly.
pub(super) fn smooth(mesh: &mut HalfEdges<'_>, waiting: &mut Waiting) {
    /// Tunes counts only.
    const SWEEPS: usize = 3;
    let is_wanted = |vertex: &u32| {
        mesh.kinds[*vertex as usize] == Kind::Face
            && mesh.region(mesh.leaving[*vertex as usize]).way == Way::AtOnce
    };
    let vertices: Vec<u32> = (0..mesh.positions.len() as u32).filter(is_wanted).collect();
    for _ in 0..SWEEPS {
        for &vertex in &vertices {
            centre(mesh, vertex);
        }
        for &vertex in &vertices {
            for spoke in mesh.around(vertex) {
                waiting.push(spoke);
                waiting.push(next(spoke));
            }
        }
        waiting.flip_all(mesh, |_| {});
    }
}

/// Moves a vertex amid its neighbours, unless that folds a triangle.
fn centre(mesh: &mut HalfEdges<'_>, vertex: u32) {
    let leaving = mesh.leaving[vertex as usize];
    let (surface, region) = (mesh.surface(leaving), mesh.region(leaving));
    let (mut sum, mut count) = (glam::DVec3::ZERO, 0.0);
    for spoke in mesh.around(vertex) {
        sum += mesh.at(mesh.target(spoke));
        count += 1.0;
    }
    let Some(place) = region.project(surface, sum / count) else {
        return;
    };
    let fits = mesh.around(vertex).all(|spoke| {
        let rim = next(spoke);
        let corners = [place, mesh.at(mesh.origin(rim)), mesh.at(mesh.target(rim))];
        faces_out_in_the_middle(surface, mesh.region(spoke), corners)
    });
    if fits {
        mesh.positions[vertex as usize] = place;
    }
}
