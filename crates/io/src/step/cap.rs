//! Faces of paraboloids and of hyperboloids of two sheets, of revolution, with the pole inside: put
//! together again of the quarters in which they come, and cut at one meridian.

use csg::SurfaceShape;
use csg::brep::{Coedge, CoedgeId, Edge, Face, Shell};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::surfaces::is_round;

/// Faces that are one in the file.
pub(super) struct Cap<'a> {
    /// The quarters, and what others cut off from them.
    pub faces: Vec<Face<'a>>,
    /// Around the one that they become: with the pole first.
    pub loops: Vec<Vec<Coedge<'a>>>,
    /// The direction across the axis in which it is cut.
    pub meridian: DVec3,
}

/// The faces of a shell that have a pole inside together, and no other edge nearer to the axis than
/// `least`.
///
/// Open CASCADE 8.0, which mends what it reads with a tolerance of 1 mm, takes loops of less across for
/// degenerate: quarters it reads however small.
pub(super) fn caps<'a>(shell: &Shell<'a>, least: f64) -> Vec<Cap<'a>> {
    let mut groups: FxHashMap<(usize, bool), Vec<Face<'a>>> = FxHashMap::default();
    for face in shell.faces() {
        let key = (face.surface_index(), face.is_along_gradient());
        groups.entry(key).or_default().push(face);
    }
    let mut groups: Vec<_> = groups
        .into_iter()
        .filter(|(_, faces)| faces.len() >= 4)
        .collect();
    groups.sort_by_key(|(key, _)| *key);
    groups
        .iter()
        .flat_map(|(_, faces)| caps_of(faces, least))
        .collect()
}

/// Of faces on one side of a surface the cap around each of its poles.
fn caps_of<'a>(faces: &[Face<'a>], least: f64) -> Vec<Cap<'a>> {
    let (poles, axis) = match faces[0].surface().shape() {
        SurfaceShape::EllipticParaboloid { placement, bends } if is_round(bends) => {
            (vec![placement.origin], placement.axes[2])
        }
        SurfaceShape::HyperboloidTwoSheets {
            placement,
            radii: [a, b, c],
        } if is_round([a, b]) => {
            let axis = placement.axes[2];
            let poles = [c, -c].map(|height| placement.origin + height * axis);
            (poles.to_vec(), axis)
        }
        _ => return Vec::new(),
    };
    let caps = poles
        .into_iter()
        .map(|pole| cap(faces, (pole, axis), least));
    caps.flatten().collect()
}

/// The cap around a pole.
fn cap<'a>(faces: &[Face<'a>], (pole, axis): (DVec3, DVec3), least: f64) -> Option<Cap<'a>> {
    let middle = |edge: &Edge<'_>| {
        let [from, to] = edge.range();
        edge.at(0.5 * (from + to)) - pole
    };
    let across = |edge: &Edge<'_>| middle(edge).reject_from(axis).normalize_or_zero();
    // The seams that end at the pole, each with its direction.
    let mut seams: Vec<(Edge<'a>, DVec3)> = Vec::new();
    for edge in faces.iter().flat_map(Face::edges) {
        let is_new = seams.iter().all(|(known, _)| known.id() != edge.id());
        let size = middle(&edge).length();
        let mut ends = edge.vertices().into_iter().flatten();
        let begins = ends.any(|end| end.point().distance(pole) <= AT * size);
        if is_new && begins && is_seam(&edge) {
            seams.push((edge, across(&edge)));
        }
    }
    let [(first, _), _, _, _] = seams[..] else {
        return None;
    };
    let reached = over_seams(first.faces()[0]);
    let edges = || reached.iter().flat_map(Face::edges);
    let is_near = |edge: &Edge<'_>| {
        let [from, to] = edge.range();
        let places = (0..=8).map(|k| edge.at(from + 0.125 * f64::from(k) * (to - from)) - pole);
        let mut off_axis = places.map(|place| place.reject_from(axis).length());
        !is_seam(edge) && off_axis.any(|distance| distance < least)
    };
    if edges().any(|edge| is_near(&edge)) {
        return None;
    }
    // Cut where nothing crosses the meridian: an edge there is on both sides of it.
    let is_along =
        |edge: &Edge<'_>, meridian: DVec3| is_seam(edge) && across(edge).dot(meridian) > 0.5;
    let pieces = |meridian| edges().filter(|edge| is_along(edge, meridian)).count() / 2;
    let (first, meridian) = seams
        .into_iter()
        .find(|&(_, meridian)| pieces(meridian) == 1)?;
    let is_cut = |edge: &Edge<'_>| !is_seam(edge) || is_along(edge, meridian);
    let mut loops = loops(&reached, is_cut);
    let has_pole =
        |around: &Vec<Coedge<'_>>| around.iter().any(|side| side.edge().id() == first.id());
    let outer = loops.iter().position(has_pole)?;
    loops.swap(0, outer);
    Some(Cap {
        faces: reached,
        loops,
        meridian,
    })
}

/// An edge ends at a pole that is nearer than this share of its length.
const AT: f64 = 1e-9;

/// Whether an edge lies within what is one face but for seams.
pub(super) fn is_seam(edge: &Edge<'_>) -> bool {
    let [one, other] = edge.faces();
    one.surface_index() == other.surface_index()
        && one.is_along_gradient() == other.is_along_gradient()
        && one.origin() == other.origin()
}

/// All faces that are reached from one over seams, that first.
pub(super) fn over_seams(face: Face<'_>) -> Vec<Face<'_>> {
    let mut reached = vec![face];
    let mut is_reached: FxHashSet<usize> = [face.id().index()].into_iter().collect();
    let mut next = 0;
    while let Some(face) = reached.get(next).copied() {
        next += 1;
        for edge in face.edges().filter(is_seam) {
            for other in edge.faces() {
                if is_reached.insert(other.id().index()) {
                    reached.push(other);
                }
            }
        }
    }
    reached
}

/// What is left of the loops around faces where they are cut at some of their edges only.
pub(super) fn loops<'a>(
    faces: &[Face<'a>],
    is_cut: impl Fn(&Edge<'_>) -> bool,
) -> Vec<Vec<Coedge<'a>>> {
    let mut sides = Vec::new();
    let mut following: FxHashMap<CoedgeId, Coedge<'a>> = FxHashMap::default();
    for around in faces.iter().flat_map(Face::loops) {
        let all: Vec<Coedge<'a>> = around.coedges().collect();
        for (index, side) in all.iter().enumerate() {
            following.insert(side.id(), all[(index + 1) % all.len()]);
            sides.push(*side);
        }
    }
    let next = |side: Coedge<'a>| {
        let mut next = following[&side.id()];
        // Over an edge that is none there: on with what follows its other side.
        while !is_cut(&next.edge()) {
            next = following[&next.twin().id()];
        }
        next
    };
    let mut is_seen: FxHashSet<CoedgeId> = FxHashSet::default();
    let mut loops = Vec::new();
    for start in sides.into_iter().filter(|side| is_cut(&side.edge())) {
        let mut around = Vec::new();
        let mut side = start;
        while is_seen.insert(side.id()) {
            around.push(side);
            side = next(side);
        }
        if !around.is_empty() {
            loops.push(around);
        }
    }
    loops
}
