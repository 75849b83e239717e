//! From where a model is best seen, if nobody says.

use std::collections::HashMap;

use csg::Mesh;
use glam::{DVec2, DVec3};

use crate::section::SectionPlane;

/// Directions towards the viewer, before they are turned: isometric, the usual
/// one first, those from below last.
const OCTANTS: [DVec3; 8] = [
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(-1.0, -1.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.0),
    DVec3::new(1.0, -1.0, -1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(-1.0, -1.0, -1.0),
    DVec3::new(-1.0, 1.0, -1.0),
];

/// By how many degrees a view is turned about the upward axis, and tilted,
/// until no face hides the rest.
const TURNS: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [-15.0, -5.0],
    [15.0, -5.0],
    [-15.0, 10.0],
    [15.0, 10.0],
    [-30.0, -10.0],
    [30.0, -10.0],
    [-40.0, 15.0],
    [40.0, 15.0],
];

/// The share of what is seen that faces of one direction may take.
const MOST: f64 = 0.9;

/// The unit direction to look along (Z up) that shows most of a mesh: the
/// isometric view, from the side on which section planes that cut it show
/// their caps, and turned where nearly all that is seen would be faces of one
/// direction. O(triangles).
#[must_use]
pub fn clear_view(mesh: &Mesh, sections: &[SectionPlane]) -> DVec3 {
    let shown = |towards: DVec3| {
        let caps = sections.iter();
        caps.filter(|plane| plane.normal.dot(towards) > 0.0).count()
    };
    let most = OCTANTS.map(shown).into_iter().max();
    let octant = OCTANTS.into_iter().find(|&o| Some(shown(o)) == most);
    let octant = octant.unwrap_or(OCTANTS[0]).normalize();
    let faces = areas_by_direction(mesh);
    let mut best = (f64::INFINITY, octant);
    for [turn, tilt] in TURNS {
        let towards = turned(octant, turn.to_radians(), tilt.to_radians());
        if shown(towards) < shown(octant) {
            continue;
        }
        let seen = faces.iter().map(|area| area.dot(towards).max(0.0));
        let (all, largest) = seen.fold((0.0, 0.0f64), |(all, most), a| (all + a, most.max(a)));
        let share = if all > 0.0 { largest / all } else { 0.0 };
        if share < MOST {
            return -towards;
        }
        if share < best.0 {
            best = (share, towards);
        }
    }
    -best.1
}

/// A direction turned about Z and raised.
fn turned(direction: DVec3, turn: f64, tilt: f64) -> DVec3 {
    let flat = direction.truncate();
    let height = direction.z.atan2(flat.length()) + tilt * direction.z.signum();
    let around = DVec2::from_angle(turn).rotate(flat).normalize_or_zero();
    (around * height.cos()).extend(height.sin())
}

/// The vector areas of all faces of nearly one direction together.
fn areas_by_direction(mesh: &Mesh) -> Vec<DVec3> {
    /// Steps of a unit vector's coordinates that count as one direction.
    const STEPS: f64 = 16.0;
    let mut areas: HashMap<[i8; 3], DVec3> = HashMap::new();
    for triangle in &mesh.triangles {
        let at = |v: u32| mesh.positions.get(v as usize).copied();
        let [Some(a), Some(b), Some(c)] = triangle.map(at) else {
            continue;
        };
        let area = (b - a).cross(c - a);
        if let Some(normal) = area.try_normalize() {
            let key = (normal * STEPS).round().to_array().map(|v| v as i8);
            *areas.entry(key).or_default() += area;
        }
    }
    // (The sum's order does not depend on the hash, and a maximum has none.)
    let mut areas: Vec<_> = areas.into_iter().collect();
    areas.sort_unstable_by_key(|(key, _)| *key);
    areas.into_iter().map(|(_, area)| area).collect()
}
