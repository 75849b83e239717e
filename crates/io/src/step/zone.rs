//! Faces of spheres between circles around one axis, as turned parts have: put together again of the
//! eighths in which they come.
//!
//! The circles are parallels of the file's surface then, which readers find without error. There is no
//! seam: it would need vertices where the circles have none. A face around a closed surface that has
//! none is read as such by other programs.

use csg::SurfaceShape;
use csg::brep::{Coedge, CurveShape, Edge, Face, Shell};
use glam::DVec3;
use rustc_hash::FxHashSet;

use super::cap::{is_seam, loops, over_seams};

/// Faces that are one in the file.
pub(super) struct Zone<'a> {
    pub faces: Vec<Face<'a>>,
    /// One circle, around a cap, or two.
    pub loops: Vec<Vec<Coedge<'a>>>,
    /// The direction of the axis, of unit length.
    pub axis: DVec3,
}

/// Of unit normals of circles, by how much they may differ: the circles' parallels are then as exact
/// as other curves.
const PARALLEL: f64 = 1e-9;

/// The zones and caps of spheres in a shell. None with a circle of a radius below `least`, which Open
/// CASCADE may take for degenerate.
pub(super) fn zones<'a>(shell: &Shell<'a>, least: f64) -> Vec<Zone<'a>> {
    let mut is_known: FxHashSet<usize> = FxHashSet::default();
    let mut zones = Vec::new();
    for face in shell.faces() {
        let is_sphere = matches!(face.surface().shape(), SurfaceShape::Sphere { .. });
        if !is_sphere || face.meridian().is_some() || is_known.contains(&face.id().index()) {
            continue;
        }
        let faces = over_seams(face);
        is_known.extend(faces.iter().map(|face| face.id().index()));
        zones.extend(zone(faces, least));
    }
    zones
}

fn zone(faces: Vec<Face<'_>>, least: f64) -> Option<Zone<'_>> {
    let mut axis: Option<DVec3> = None;
    for edge in faces.iter().flat_map(Face::edges) {
        if is_seam(&edge) {
            continue;
        }
        let normal = normal(&edge, least)?;
        let axis = *axis.get_or_insert(normal);
        if axis.cross(normal).length() > PARALLEL {
            return None;
        }
    }
    Some(Zone {
        loops: loops(&faces, |edge| !is_seam(edge)),
        faces,
        axis: axis?,
    })
}

/// The unit normal of the plane of an edge that is a circle of some radius at least.
fn normal(edge: &Edge<'_>, least: f64) -> Option<DVec3> {
    let curve = edge.curve();
    let CurveShape::Ellipse { .. } = curve else {
        return None;
    };
    let axes = curve.half_axes().filter(|axes| axes.is_circle)?;
    let is_large = axes.short.length() >= least;
    is_large.then(|| axes.long.cross(axes.short).normalize_or_zero())
}
