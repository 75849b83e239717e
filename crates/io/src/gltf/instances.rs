//! Bodies that are there several times, written once (`EXT_mesh_gpu_instancing`).

use csg::Mesh;
use glam::{DQuat, DVec3, Vec3};
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer;
use gltf_json::validation::{Checked::Valid, USize64};
use gltf_json::{Accessor, Index, Node, Root};
use serde_json::{Value, json};

use super::write::{empty_accessor, rounded_centre};
use crate::parts::{Group, Part, Parts};
use crate::repeats::{Copy, Repeat, quaternion, repeats};

pub(super) const EXTENSION: &str = "EXT_mesh_gpu_instancing";

/// Vertices are as far as this share of the model's longest side, at most, from where they are:
/// four times what single precision makes of them without instances.
const OF_LONGEST_SIDE: f64 = 1.0 / (1_u64 << 22) as f64;

/// Bodies are written once if that leaves out so many bytes, which is about what a node and a
/// mesh take.
const WORTH: usize = 1024;

/// Where a body is, in numbers as the file has them.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub rotation: [f32; 4],
    pub translation: Vec3,
}

impl Place {
    fn at(translation: DVec3) -> Self {
        Self {
            rotation: [0.0, 0.0, 0.0, 1.0],
            translation: translation.as_vec3(),
        }
    }

    /// Where readers put a place of the body.
    pub fn apply(&self, place: DVec3) -> DVec3 {
        let rotation = DQuat::from_array(self.rotation.map(f64::from)).normalize();
        rotation * place + self.translation.as_dvec3()
    }
}

/// A body that is written once.
pub(super) struct Instances {
    /// The part that all of them belong to.
    pub owner: usize,
    /// What its places are told from, within the model's.
    pub centre: DVec3,
    /// Itself, and its copies.
    pub places: Vec<Place>,
}

/// Takes the bodies that are there several times out of the parts, and appends each, once, as a
/// part of its own.
pub(super) fn take_out(mesh: &Mesh, translation: DVec3, parts: &mut Parts<'_>) -> Vec<Instances> {
    let ordinary = parts.parts.len();
    let mut labels = vec![0; mesh.triangles.len()];
    let mut owners = Vec::new();
    for (part, group) in (parts.parts.iter().enumerate())
        .flat_map(|(part, of)| of.groups.iter().map(move |group| (part, group)))
    {
        for &triangle in &group.triangles {
            labels[triangle as usize] = owners.len() as u32;
        }
        owners.push(part);
    }
    let (low, high) = mesh.bounds().unwrap_or_default();
    let tolerance = OF_LONGEST_SIDE * (high - low).max_element();
    let mut all = Vec::new();
    let mut is_taken = vec![false; mesh.triangles.len()];
    for repeat in repeats(mesh, &labels) {
        let Some((instances, copies)) = placed(mesh, translation, &repeat, tolerance) else {
            continue;
        };
        let bytes = repeat.triangles.len() * (3 * 2 + 12);
        if copies.len() * bytes < WORTH {
            continue;
        }
        let owner = owners[labels[repeat.triangles[0] as usize] as usize];
        let copied = copies.iter().flat_map(|copy| &copy.triangles);
        for &triangle in repeat.triangles.iter().chain(copied) {
            is_taken[triangle as usize] = true;
        }
        let mut body: Vec<Group> = Vec::new();
        for group in &parts.parts[owner].groups {
            let first = group.triangles.first().map(|&t| labels[t as usize]);
            let of_group = |t: &&u32| Some(labels[**t as usize]) == first;
            let triangles: Vec<u32> = repeat.triangles.iter().filter(of_group).copied().collect();
            if !triangles.is_empty() {
                body.push(Group {
                    names: group.names.clone(),
                    color: group.color,
                    triangles,
                });
            }
        }
        parts.parts.push(Part {
            names: parts.parts[owner].names.clone(),
            groups: body,
        });
        all.push(Instances { owner, ..instances });
    }
    for part in &mut parts.parts[..ordinary] {
        for group in &mut part.groups {
            group.triangles.retain(|&t| !is_taken[t as usize]);
        }
        part.groups.retain(|group| !group.triangles.is_empty());
    }
    all
}

/// The places of a body and its copies, of those that come to where they should.
fn placed<'a>(
    mesh: &Mesh,
    translation: DVec3,
    repeat: &'a Repeat,
    tolerance: f64,
) -> Option<(Instances, Vec<&'a Copy>)> {
    let at = |vertex: u32| mesh.positions[vertex as usize] - translation;
    let first = &repeat.copies.first()?.vertices;
    let places = || first.iter().map(|&(vertex, _)| at(vertex));
    let bounds = places().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    let centre = rounded_centre(bounds);
    let written = |vertex: u32| (at(vertex) - centre).as_vec3().as_dvec3();
    let fits = |place: &Place, pairs: &[(u32, u32)]| {
        let near =
            |&(from, to): &(u32, u32)| place.apply(written(from)).distance(at(to)) <= tolerance;
        pairs.iter().all(near)
    };
    let own = Place::at(centre);
    let same: Vec<(u32, u32)> = first.iter().map(|&(vertex, _)| (vertex, vertex)).collect();
    if !fits(&own, &same) {
        return None;
    }
    let mut found = vec![own];
    let mut kept = Vec::new();
    for copy in &repeat.copies {
        let mut place = Place {
            rotation: quaternion(&copy.rotation).map(|component| component as f32),
            translation: Vec3::ZERO,
        };
        // What is left is made up for by the translation.
        let left = |&(from, to): &(u32, u32)| at(to) - place.apply(written(from));
        let sum: DVec3 = copy.vertices.iter().map(left).sum();
        place.translation = (sum / copy.vertices.len() as f64).as_vec3();
        if fits(&place, &copy.vertices) {
            found.push(place);
            kept.push(copy);
        }
    }
    let instances = Instances {
        owner: 0,
        centre,
        places: found,
    };
    Some((instances, kept)).filter(|(_, kept)| !kept.is_empty())
}

/// Whether any of these is turned.
fn are_turned(instances: &Instances) -> bool {
    let turned = |place: &Place| place.rotation != Place::at(DVec3::ZERO).rotation;
    instances.places.iter().any(turned)
}

/// How many translations there are, and how many rotations.
pub(super) fn counts(all: &[Instances]) -> (usize, usize) {
    let count = |instances: &Instances| instances.places.len();
    let turned = all.iter().filter(|instances| are_turned(instances));
    (all.iter().map(count).sum(), turned.map(count).sum())
}

/// All translations, one instance after the other.
pub(super) fn translations(all: &[Instances]) -> impl Iterator<Item = &Place> {
    all.iter().flat_map(|instances| &instances.places)
}

/// All rotations of those that have any.
pub(super) fn rotations(all: &[Instances]) -> impl Iterator<Item = &Place> {
    let turned = all.iter().filter(|instances| are_turned(instances));
    turned.flat_map(|instances| &instances.places)
}

/// Views of translations and rotations.
#[derive(Clone, Copy)]
pub(super) struct PlaceViews {
    pub translations: Option<Index<buffer::View>>,
    pub rotations: Option<Index<buffer::View>>,
}

/// A node of a mesh that is there several times, and the accessors of its places.
pub(super) struct InstanceNode {
    pub node: Index<Node>,
    translation: Index<Accessor>,
    rotation: Option<Index<Accessor>>,
}

impl InstanceNode {
    /// Says in the document what `gltf-json` has no type for.
    pub fn tell(&self, document: &mut Value) {
        let mut attributes = json!({ "TRANSLATION": self.translation.value() });
        if let Some(rotation) = self.rotation {
            attributes["ROTATION"] = json!(rotation.value());
        }
        document["nodes"][self.node.value()]["extensions"] =
            json!({ EXTENSION: { "attributes": attributes } });
    }
}

/// A node for each of the bodies that are there several times, with these meshes.
pub(super) fn push_nodes(
    root: &mut Root,
    views: PlaceViews,
    all: &[Instances],
    meshes: &[Index<gltf_json::Mesh>],
) -> Vec<InstanceNode> {
    let (mut translated, mut rotated) = (0, 0);
    let nodes = all.iter().zip(meshes).map(|(instances, &mesh)| {
        let count = instances.places.len();
        let mut push = |view, kind, offset: &mut usize, size| {
            let accessor = Accessor {
                buffer_view: view,
                byte_offset: Some(USize64::from(*offset * size)),
                count: USize64::from(count),
                component_type: Valid(GenericComponentType(ComponentType::F32)),
                type_: Valid(kind),
                ..empty_accessor()
            };
            *offset += count;
            root.push(accessor)
        };
        let translation = push(views.translations, Type::Vec3, &mut translated, 12);
        let rotation =
            are_turned(instances).then(|| push(views.rotations, Type::Vec4, &mut rotated, 16));
        let node = root.push(Node {
            mesh: Some(mesh),
            ..Node::default()
        });
        InstanceNode {
            node,
            translation,
            rotation,
        }
    });
    nodes.collect()
}
