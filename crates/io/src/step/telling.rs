//! Voids that touch the shell around them.

use csg::brep::{Edge, Loop, Shell};
use glam::DVec3;

/// As a share of the size, how near a point is to a surface that it is on.
const ON_SURFACE: f64 = 1e-6;

/// An edge with a vertex that is off the outer shell: an end of it, or one in its middle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Telling {
    /// The edge's number.
    pub edge: usize,
    /// Whether it is to have a vertex in the middle.
    pub is_parted: bool,
}

/// Of a void with vertices on the outer shell the edge that goes farthest from it; none if there
/// are no such vertices.
///
/// Open CASCADE's reader asks the first vertices of a shell on which side of the others it is,
/// and takes one of which three are on another one for a solid of its own
/// (`ShapeFix_Solid.cxx`): the first one that it comes to must tell.
pub(super) fn edge(void: &Shell<'_>, outer: &Shell<'_>) -> Option<Telling> {
    let surfaces: Vec<_> = outer.faces().map(|face| face.surface()).collect();
    let away = |point: DVec3| {
        let distances = surfaces.iter().map(|surface| {
            let slope = surface.gradient(point).length();
            surface.value(point).abs() / slope.max(f64::MIN_POSITIVE)
        });
        distances.fold(f64::INFINITY, f64::min)
    };
    let faces: Vec<_> = void.faces().collect();
    // (The outer loop is the first one.)
    let loops: Vec<_> = faces
        .iter()
        .filter_map(|face| face.loops().next())
        .collect();
    let edges: Vec<Edge<'_>> = loops
        .iter()
        .flat_map(Loop::coedges)
        .map(|side| side.edge())
        .collect();
    let ends = |edge: &Edge<'_>| {
        let ends = edge.vertices()?;
        let points = ends.map(|end| end.point());
        Some((points, points.map(away)))
    };
    let known = edges.iter().filter_map(ends);
    let size = known.clone().flat_map(|(points, _)| points);
    let size = size.map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let near = ON_SURFACE * size;
    if !known
        .clone()
        .any(|(_, away)| away.iter().any(|&far| far <= near))
    {
        return None;
    }
    let told = edges.iter().map(|edge| {
        let [from, until] = edge.range();
        let middle = away(edge.at(0.5 * (from + until)));
        let ends = ends(edge).map_or(0.0, |(_, [one, other])| one.min(other));
        let is_parted = ends <= near;
        let telling = Telling {
            edge: edge.id().index(),
            is_parted,
        };
        (telling, if is_parted { middle } else { ends })
    });
    let order = |(telling, far): &(Telling, f64)| (!telling.is_parted, *far);
    let best = told.max_by(|a, b| {
        order(a)
            .partial_cmp(&order(b))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    best.filter(|&(_, far)| far > near)
        .map(|(telling, _)| telling)
}
