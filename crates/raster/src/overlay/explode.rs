//! Exploded views: parts moved apart.

use csg::Mesh;
use glam::DVec3;

use crate::color_map::connected_parts;

/// Moves the connected parts of a mesh away from its middle: each by `factor`
/// times the way from there to its own middle. O(n).
#[must_use]
pub fn exploded(mesh: &Mesh, factor: f64) -> Mesh {
    let parts = connected_parts(mesh);
    let count = parts.iter().max().map_or(0, |&last| last as usize + 1);
    let mut boxes = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY); count];
    let mut part_of = vec![None; mesh.positions.len()];
    for (triangle, &part) in mesh.triangles.iter().zip(&parts) {
        for &v in triangle {
            if let Some(p) = mesh.positions.get(v as usize).filter(|p| p.is_finite()) {
                let (low, high) = &mut boxes[part as usize];
                (*low, *high) = (low.min(*p), high.max(*p));
                part_of[v as usize] = Some(part as usize);
            }
        }
    }
    let middle = |(low, high): (DVec3, DVec3)| low + (high - low) / 2.0;
    let all = boxes
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |all, own| {
            (all.0.min(own.0), all.1.max(own.1))
        });
    let mut moved = mesh.clone();
    for (p, part) in moved.positions.iter_mut().zip(part_of) {
        if let Some(part) = part {
            *p += (middle(boxes[part]) - middle(all)) * factor;
        }
    }
    moved
}
