//! Sides of triangles, and where they are cut.

use glam::DVec3;

use super::curves::on_curve;
use super::half_edges::{HalfEdges, Kind};
use super::shape::faces_out_everywhere;

/// A side of a triangle, and where it is to be cut.
#[derive(Clone, Copy)]
pub(super) struct Side {
    /// In ascending order.
    pub ends: [u32; 2],
    pub target: DVec3,
    /// Of the vertex there.
    pub kind: Kind,
}

/// Each side once, and where the solid touches itself all edges at the same place, to
/// be cut at the same point.
pub(super) fn together(mesh: &HalfEdges<'_>, mut sides: Vec<Side>) -> Vec<Side> {
    for index in 0..sides.len() {
        let side = sides[index];
        let kind = Kind::Corner;
        let alike = mesh.contacts.alike(side.ends).iter();
        sides.extend(alike.map(|&ends| Side { ends, kind, ..side }));
    }
    sides.sort_unstable_by_key(|side| side.ends);
    sides.dedup_by_key(|side| side.ends);
    sides
}

/// Where an edge would be cut next to a point of it.
pub(super) fn cut_of(mesh: &HalfEdges<'_>, half: u32, near: DVec3, precision: f64) -> Option<Side> {
    let ends = mesh.ends(half);
    let curve = if mesh.is_contact(half) {
        mesh.contact_curve(mesh.contacts.alike(ends))?
    } else {
        mesh.curve(half)
    };
    let surfaces = curve.map(|id| &mesh.surfaces[id]);
    let (target, kind) = if std::ptr::eq(surfaces[0], surfaces[1]) {
        let kind = if mesh.is_feature(half) {
            Kind::Corner
        } else {
            Kind::Face
        };
        (mesh.region(half).project(surfaces[0], near)?, kind)
    } else {
        let [p, q] = ends.map(|v| mesh.at(v));
        let reach = 0.5 * p.distance(q);
        (on_curve(surfaces, near, reach, precision)?, Kind::Curve)
    };
    Some(Side { ends, target, kind })
}

/// Where an edge would be cut next to its middle, and how far that is from there.
pub(super) fn halved(mesh: &HalfEdges<'_>, half: u32, precision: f64) -> Option<(f64, Side)> {
    let middle = mesh
        .at(mesh.origin(half))
        .midpoint(mesh.at(mesh.target(half)));
    let side = cut_of(mesh, half, middle, precision)?;
    Some((side.target.distance(middle), side))
}

/// Whether the four triangles that a split leaves face the right way.
pub(super) fn splits_well(mesh: &HalfEdges<'_>, half: u32, target: DVec3) -> bool {
    let side_is_good = |half: u32| {
        let (surface, region) = (mesh.surface(half), mesh.region(half));
        let u = mesh.at(mesh.origin(half));
        let w = mesh.at(mesh.target(half));
        let c = mesh.at(mesh.apex(half));
        faces_out_everywhere(surface, region, [u, target, c])
            && faces_out_everywhere(surface, region, [target, w, c])
    };
    side_is_good(half) && side_is_good(mesh.twin(half))
}
