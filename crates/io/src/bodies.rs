//! Which connected parts of a mesh are the walls of voids, and in which others these are.

use csg::Mesh;
use csg::elementary;
use csg::mesh::Components;
use glam::DVec3;
use rayon::prelude::*;

/// A connected part of a mesh.
struct Body {
    /// Six times its volume: below 0 for the wall of a void.
    volume: f64,
    low: DVec3,
    high: DVec3,
    /// A point of it.
    point: DVec3,
}

/// For each component the one that it bounds a body with: itself, or of a void the smallest
/// that is around it. Only where `differ` are two of them told apart by their triangles.
pub(crate) fn owners(
    mesh: &Mesh,
    components: &Components,
    differ: impl Fn(usize, usize) -> bool,
) -> Vec<usize> {
    let mut bodies: Vec<Option<Body>> = (0..components.count).map(|_| None).collect();
    for (index, component) in components.of_triangles.iter().enumerate() {
        let Some(component) = component else { continue };
        let [a, b, c] = mesh.corners(index);
        let body = bodies[*component as usize].get_or_insert(Body {
            volume: 0.0,
            low: a,
            high: a,
            point: a,
        });
        // About a point of its own, so that little is lost far from the origin.
        let [u, v, w] = [a, b, c].map(|corner| corner - body.point);
        body.volume += u.dot(v.cross(w));
        body.low = body.low.min(a).min(b).min(c);
        body.high = body.high.max(a).max(b).max(c);
    }
    let mut owners: Vec<usize> = (0..components.count).collect();
    for (index, body) in bodies.iter().enumerate() {
        let Some(body) = body.as_ref().filter(|body| body.volume < 0.0) else {
            continue;
        };
        let is_around = |other: &Body| {
            other.volume > 0.0
                && other.low.cmple(body.low).all()
                && other.high.cmpge(body.high).all()
        };
        let around = bodies.iter().enumerate().filter_map(|(around, other)| {
            let other = other.as_ref().filter(|other| is_around(other))?;
            Some((around, other.volume))
        });
        let mut around: Vec<(usize, f64)> = around.collect();
        around.sort_by(|a, b| a.1.total_cmp(&b.1));
        let Some(&(smallest, _)) = around.first() else {
            continue;
        };
        owners[index] = smallest;
        if around.iter().any(|&(other, _)| differ(other, smallest)) {
            let mut around = around.into_iter().map(|(other, _)| other);
            if let Some(owner) =
                around.find(|&other| winding(mesh, components, other, body.point) > 0.5)
            {
                owners[index] = owner;
            }
        }
    }
    owners
}

/// How often a component winds around a point, by the solid angles of its triangles
/// (A. van Oosterom and J. Strackee, *The Solid Angle of a Plane Triangle*, 1983).
fn winding(mesh: &Mesh, components: &Components, component: usize, point: DVec3) -> f64 {
    let angles = components
        .of_triangles
        .par_iter()
        .enumerate()
        .map(|(index, of)| {
            if of.map(|of| of as usize) != Some(component) {
                return 0.0;
            }
            let [a, b, c] = mesh
                .corners(index)
                .map(|corner| (corner - point).normalize_or_zero());
            let below = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
            2.0 * elementary::atan2(a.dot(b.cross(c)), below)
        });
    angles.sum::<f64>() / (4.0 * std::f64::consts::PI)
}
