//! Where lines run inside a mesh, and how far points are from it.

use csg::Mesh;
use glam::{DMat3, DVec2, DVec3};
use stereotomy::csg;

use super::{Line, SIDE};

/// Where a line crosses a mesh's triangles: at which parameter, and +1 where it goes in.
pub fn crossings(mesh: &Mesh, line: &Line) -> Vec<(f64, i32)> {
    let turn = across(line);
    let at = turn * line.origin;
    let turned = turned(mesh, turn);
    let triangles = turned.iter();
    triangles
        .filter_map(|&corners| cross(corners, at))
        .collect()
}

/// The corners of all triangles, turned.
fn turned(mesh: &Mesh, turn: DMat3) -> Vec<[DVec3; 3]> {
    let positions: Vec<DVec3> = mesh.positions.iter().map(|&p| turn * p).collect();
    let triangles = mesh.triangles.iter();
    let corners = triangles.map(|corners| corners.map(|corner| positions[corner as usize]));
    corners.collect()
}

/// The same for each of a grid of parallel lines.
pub fn bundle(mesh: &Mesh, lines: &[Line]) -> Vec<Vec<(f64, i32)>> {
    let turn = across(&lines[0]);
    let at: Vec<DVec3> = lines.iter().map(|line| turn * line.origin).collect();
    let mut found = vec![Vec::new(); lines.len()];
    // Lines one after another are a row: each triangle asks the rows that it reaches.
    let rows: Vec<(DVec2, DVec2)> = at
        .chunks(SIDE)
        .map(|row| {
            let row = row.iter().map(|p| p.truncate());
            let low = row.clone().reduce(DVec2::min).unwrap_or_default();
            (low, row.reduce(DVec2::max).unwrap_or_default())
        })
        .collect();
    for corners in turned(mesh, turn) {
        let low = corners.into_iter().reduce(DVec3::min).unwrap_or_default();
        let high = corners.into_iter().reduce(DVec3::max).unwrap_or_default();
        for (row, (least, greatest)) in rows.iter().enumerate() {
            if low.truncate().cmpgt(*greatest).any() || high.truncate().cmplt(*least).any() {
                continue;
            }
            for n in row * SIDE..(row + 1) * SIDE {
                found[n].extend(cross(corners, at[n]));
            }
        }
    }
    found
}

/// A turn that brings a line's direction to z.
fn across(line: &Line) -> DMat3 {
    let w = line.direction;
    let (u, v) = w.any_orthonormal_pair();
    DMat3::from_cols(u, v, w).transpose()
}

/// Where the vertical through a point crosses a triangle.
fn cross(corners: [DVec3; 3], at: DVec3) -> Option<(f64, i32)> {
    let [a, b, c] = corners.map(|p| (p - at).truncate());
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    if low.cmpgt(DVec2::ZERO).any() || high.cmplt(DVec2::ZERO).any() {
        return None;
    }
    let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let is_inside = weights.iter().all(|&w| w > 0.0) || weights.iter().all(|&w| w < 0.0);
    let sum: f64 = weights.iter().sum();
    if !is_inside || sum == 0.0 {
        return None;
    }
    let heights = corners.map(|p| p.z - at.z);
    let height = (0..3).map(|k| weights[k] / sum * heights[k]).sum();
    Some((height, if sum > 0.0 { -1 } else { 1 }))
}

/// The parts of a line within a mesh, and how many times; none where its crossings do not
/// add up, as where it runs through an edge.
pub fn winding(mut crossings: Vec<(f64, i32)>) -> Option<Vec<([f64; 2], i32)>> {
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut times = 0;
    let mut found = Vec::new();
    for pair in crossings.windows(2) {
        times += pair[0].1;
        if times != 0 {
            found.push(([pair[0].0, pair[1].0], times));
        }
    }
    times += crossings.last().map_or(0, |last| last.1);
    (times == 0).then_some(found)
}

/// How far a point is from a mesh, and the normal of the nearest triangle; infinitely from
/// an empty one.
pub fn nearest(mesh: &Mesh, place: DVec3) -> (f64, DVec3) {
    let mut found = (f64::INFINITY, DVec3::Z);
    for [a, b, c] in (0..mesh.triangles.len()).map(|index| mesh.corners(index)) {
        let in_box = place.clamp(a.min(b).min(c), a.max(b).max(c));
        if in_box.distance_squared(place) > found.0 * found.0 {
            continue;
        }
        let distance = from_triangle([a, b, c], place);
        if distance < found.0 {
            found = (distance, (b - a).cross(c - a).normalize_or(DVec3::Z));
        }
    }
    found
}

/// By the regions of a triangle's corners, edges and face (Ericson, *Real-Time Collision
/// Detection*, 2005, 5.1.5), edge by edge.
fn from_triangle(corners: [DVec3; 3], place: DVec3) -> f64 {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let edges = [0, 1, 2].map(|k| (corners[k], corners[(k + 1) % 3]));
    let is_above =
        |(from, to): &(DVec3, DVec3)| normal.cross(*to - *from).dot(place - *from) >= 0.0;
    if normal.length_squared() > 0.0 && edges.iter().all(is_above) {
        return ((place - corners[0]).dot(normal) / normal.length()).abs();
    }
    let from_edge = |(from, to): (DVec3, DVec3)| {
        let along = to - from;
        let length = along.length_squared();
        let share = if length > 0.0 {
            (place - from).dot(along) / length
        } else {
            0.0
        };
        (from + along * share.clamp(0.0, 1.0)).distance(place)
    };
    edges
        .map(from_edge)
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}
