//! Points in which faces are touched: by an edge that runs along them, an apex, or
//! another face. They become vertices of both, so that both meet there and stay
//! apart all around, however coarse their triangles.

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::picture::{Picture, Slits};
use super::piece::Side;
use super::scene::Scene;
use crate::program::SurfaceId;

/// A point in which surfaces touch each other.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    pub at: DVec3,
    /// Those that may.
    pub surfaces: SmallVec<[SurfaceId; 3]>,
}

/// Makes vertices of contacts that lie inside of faces.
pub(super) fn add_contacts(
    scene: &Scene<'_>,
    contacts: &[Contact],
    faces: &[Side],
    slits: &Slits,
    triangles: &mut [Vec<[u32; 3]>],
    positions: &mut Vec<DVec3>,
) {
    if contacts.is_empty() {
        return;
    }
    let mut of_surface: FxHashMap<SurfaceId, Vec<&Contact>> = FxHashMap::default();
    for contact in contacts {
        for &surface in &contact.surfaces {
            of_surface.entry(surface).or_default().push(contact);
        }
    }
    for (side, triangles) in faces.iter().zip(triangles) {
        let Some(contacts) = of_surface.get(&side.plane) else {
            continue;
        };
        let surface = scene.surface(side.plane);
        let frame = scene.frame(side.plane);
        let is_inside = |contact: &&&Contact| {
            let patch = frame.map_or(0, |f| f.patch(contact.at, DVec3::ZERO, scene.near));
            let is_corner =
                |&corner: &u32| positions[corner as usize].distance(contact.at) <= scene.weld;
            let off = surface.value(contact.at).abs();
            off <= scene.weld * surface.gradient(contact.at).length()
                && patch == side.patch
                && !triangles.iter().flatten().any(is_corner)
        };
        let inside: SmallVec<[DVec3; 4]> = contacts
            .iter()
            .filter(is_inside)
            .map(|contact| contact.at)
            .collect();
        if !inside.is_empty() {
            let mut picture = Picture::new(scene, side, std::mem::take(triangles), slits);
            for at in inside {
                picture.insert(at, positions);
            }
            *triangles = picture.triangles;
        }
    }
}
