//! The glTF writer.

use csg::elementary;
use std::collections::BTreeMap;
use std::io::Write;
use std::ops::Range;

use csg::{Color, Mesh};
use glam::{DVec3, Vec3};
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Stride, Target};
use gltf_json::material::{AlphaMode, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::{Checked::Valid, USize64};
use gltf_json::{Accessor, Asset, Index, Material, Node, Root, Scene, buffer};
use serde_json::{Value, json, value::to_raw_value};

use super::Z_UP_TO_Y_UP;
use super::instances::{self, InstanceNode, Instances, PlaceViews};
use crate::parts::{DEFAULT_COLOR, Group, Parts, unit_normals};
use crate::tree::tree;
use crate::{Error, MeshFormat, WriteOptions, units};

/// Writes a binary glTF file (GLB).
///
/// Bodies whose faces have names in common become a node with a mesh, within nodes of the names
/// around that (a part of an assembly); its primitives are the faces of one name and one colour,
/// with all names in `extras.names`. Every colour becomes a material; normals
/// are written where the mesh has them (without them, glTF viewers must
/// shade flat). Surface indices and feature edges are not kept.
///
/// # Errors
/// An empty or invalid mesh; one that single precision or the format's 4 GiB
/// cannot hold; failed writing.
pub fn write_glb(mesh: &Mesh, out: &mut impl Write) -> Result<(), Error> {
    write_glb_with(mesh, &WriteOptions::default(), out)
}

/// [`write_glb`] with choices: [`WriteOptions::instances`], and `WriteOptions::compress`, with which
/// it is `write_glb_compressed`.
///
/// # Errors
/// As [`write_glb`].
pub fn write_glb_with(
    mesh: &Mesh,
    options: &WriteOptions,
    out: &mut impl Write,
) -> Result<(), Error> {
    let geometry = Geometry::of(mesh, MeshFormat::Glb, options.instances)?;
    #[cfg(feature = "compress")]
    if options.compress {
        return super::compress::write(geometry, mesh, out);
    }
    write_chunks(geometry.json(mesh, None)?, geometry.byte_length(), out)?;
    geometry.write_data(out)
}

/// Writes the header, the chunk of JSON, and what comes before so many bytes of data.
pub(super) fn write_chunks(
    mut json: Vec<u8>,
    length: usize,
    out: &mut impl Write,
) -> Result<(), Error> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + length;
    let total = u32::try_from(total).map_err(|_| Error::DoesNotFit {
        format: MeshFormat::Glb,
        problem: "it would take more than 4 GiB; write .gltf with .bin, or mesh it coarser"
            .to_owned(),
    })?;
    let mut head = Vec::with_capacity(20);
    head.extend_from_slice(b"glTF");
    for word in [2, total, json.len() as u32] {
        head.extend_from_slice(&u32::to_le_bytes(word));
    }
    head.extend_from_slice(b"JSON");
    out.write_all(&head)?;
    out.write_all(&json)?;
    out.write_all(&(length as u32).to_le_bytes())?;
    Ok(out.write_all(b"BIN\0")?)
}

/// Writes a glTF file in two parts: the JSON, and the data it refers to as
/// `bin_uri` (a relative URI: percent-encode what is not plain).
///
/// # Errors
/// As [`write_glb`], without the limit of 4 GiB.
pub fn write_gltf(
    mesh: &Mesh,
    bin_uri: &str,
    json: &mut impl Write,
    bin: &mut impl Write,
) -> Result<(), Error> {
    write_gltf_with(mesh, &WriteOptions::default(), bin_uri, (json, bin))
}

/// [`write_gltf`] with choices: [`WriteOptions::instances`].
///
/// # Errors
/// As [`write_gltf`].
pub fn write_gltf_with(
    mesh: &Mesh,
    options: &WriteOptions,
    bin_uri: &str,
    (json, bin): (&mut impl Write, &mut impl Write),
) -> Result<(), Error> {
    let geometry = Geometry::of(mesh, MeshFormat::Gltf, options.instances)?;
    json.write_all(&geometry.json(mesh, Some(bin_uri))?)?;
    geometry.write_data(bin)
}

/// The data of the buffer, and which stretch of it each primitive is.
pub(super) struct Geometry<'a> {
    parts: Parts<'a>,
    /// Added to every position by the nodes.
    pub translation: DVec3,
    pub positions: Vec<Vec3>,
    /// Empty, or as long as `positions`.
    pub normals: Vec<Vec3>,
    pub indices: Vec<u32>,
    /// One for each group.
    pub primitives: Vec<Stretch>,
    /// Of the last parts, where they are.
    pub instances: Vec<Instances>,
}

pub(super) struct Stretch {
    pub vertices: Range<usize>,
    pub indices: Range<usize>,
    /// Where its indices begin among those of their width, counted in indices.
    first: usize,
}

impl Stretch {
    /// Whether its indices take 16 bits (the greatest one is reserved).
    pub fn is_narrow(&self) -> bool {
        self.vertices.len() <= usize::from(u16::MAX)
    }
}

impl<'a> Geometry<'a> {
    /// Gathers the corners part by part; corners at one vertex with the same
    /// normal become one.
    pub fn of(mesh: &'a Mesh, format: MeshFormat, instanced: bool) -> Result<Self, Error> {
        /// No vertex, or the end of a chain.
        const NONE: u32 = u32::MAX;
        let mut parts = Parts::of(mesh, format)?;
        let translation = mesh.bounds().map_or(DVec3::ZERO, rounded_centre);
        let has_normals = !mesh.corner_normals.is_empty();
        let instances = if instanced {
            instances::take_out(mesh, translation, &mut parts)
        } else {
            Vec::new()
        };
        let mut geometry = Self {
            parts,
            instances,
            translation,
            positions: Vec::with_capacity(mesh.positions.len()),
            normals: Vec::new(),
            indices: Vec::with_capacity(mesh.triangles.len() * 3),
            primitives: Vec::new(),
        };
        // Written vertices of one mesh vertex are chained: the first by mesh
        // vertex, the next by written vertex (counted within the part).
        let mut first = vec![NONE; mesh.positions.len()];
        let mut next: Vec<u32> = Vec::new();
        let ordinary = geometry.parts.parts.len() - geometry.instances.len();
        let parts = geometry.parts.parts.iter().enumerate();
        for (number, part) in parts.flat_map(|(n, of)| of.groups.iter().map(move |part| (n, part)))
        {
            let of_instances = number.checked_sub(ordinary);
            let own = of_instances.map_or(DVec3::ZERO, |k| geometry.instances[k].centre);
            let start = geometry.positions.len();
            let first_index = geometry.indices.len();
            next.clear();
            for &triangle in &part.triangles {
                let corners = mesh.triangles[triangle as usize];
                let normals = unit_normals(mesh, triangle as usize).unwrap_or_default();
                for (vertex, normal) in corners.into_iter().zip(normals) {
                    let head = first[vertex as usize];
                    let mut slot = head;
                    while slot != NONE
                        && has_normals
                        && geometry.normals[start + slot as usize] != normal
                    {
                        slot = next[slot as usize];
                    }
                    if slot == NONE {
                        slot = next.len() as u32;
                        next.push(head);
                        first[vertex as usize] = slot;
                        let place = (mesh.positions[vertex as usize] - translation - own).as_vec3();
                        geometry.positions.push(place);
                        if has_normals {
                            geometry.normals.push(normal);
                        }
                    }
                    geometry.indices.push(slot);
                }
            }
            // The greatest index is reserved.
            if next.len() >= NONE as usize
                || !geometry.positions[start..].iter().all(|p| p.is_finite())
            {
                return Err(Error::DoesNotFit {
                    format,
                    problem: "its coordinates or vertex count exceed 32 bits; \
                              scale the model down or mesh it coarser"
                        .to_owned(),
                });
            }
            for &triangle in &part.triangles {
                for vertex in mesh.triangles[triangle as usize] {
                    first[vertex as usize] = NONE;
                }
            }
            let mut stretch = Stretch {
                vertices: start..geometry.positions.len(),
                indices: first_index..geometry.indices.len(),
                first: 0,
            };
            stretch.first = geometry.indices_of_width(stretch.is_narrow());
            geometry.primitives.push(stretch);
        }
        Ok(geometry)
    }

    /// How many indices of the primitives take 16 bits, or 32.
    fn indices_of_width(&self, narrow: bool) -> usize {
        let same = self.primitives.iter().filter(|s| s.is_narrow() == narrow);
        same.map(|stretch| stretch.indices.len()).sum()
    }

    /// A multiple of 4, as the chunks of a binary file are.
    fn byte_length(&self) -> usize {
        let indices = 4 * self.indices_of_width(false) + 2 * self.indices_of_width(true);
        let (translations, rotations) = instances::counts(&self.instances);
        (12 * (self.positions.len() + self.normals.len()) + indices).next_multiple_of(4)
            + 12 * translations
            + 16 * rotations
    }

    /// Positions, normals, indices of 32 bits, those of 16, where instances are: little-endian,
    /// without gaps but after the indices.
    fn write_data(&self, out: &mut impl Write) -> Result<(), Error> {
        let mut bytes = Vec::with_capacity(self.byte_length());
        for place in self.positions.iter().chain(&self.normals) {
            for coordinate in place.to_array() {
                bytes.extend_from_slice(&coordinate.to_le_bytes());
            }
        }
        for narrow in [false, true] {
            let same = self.primitives.iter().filter(|s| s.is_narrow() == narrow);
            for index in same.flat_map(|stretch| &self.indices[stretch.indices.clone()]) {
                let index = index.to_le_bytes();
                bytes.extend_from_slice(&index[..if narrow { 2 } else { 4 }]);
            }
        }
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let translations = instances::translations(&self.instances).map(|place| place.translation);
        let rotations = instances::rotations(&self.instances).flat_map(|place| place.rotation);
        for number in translations.flat_map(|t| t.to_array()).chain(rotations) {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        Ok(out.write_all(&bytes)?)
    }

    fn json(&self, mesh: &Mesh, bin_uri: Option<&str>) -> Result<Vec<u8>, Error> {
        let document = self.document(mesh, bin_uri)?;
        Ok(serde_json::to_vec(&document).map_err(std::io::Error::from)?)
    }

    pub(super) fn document(&self, mesh: &Mesh, bin_uri: Option<&str>) -> Result<Value, Error> {
        let metres = mesh.unit.in_metres();
        let mut root = Root {
            asset: Asset {
                generator: Some(concat!("stereotomy ", env!("CARGO_PKG_VERSION")).to_owned()),
                extras: to_raw_value(&json!({
                    "unit": units::name(mesh.unit),
                    "unitInMetres": metres,
                    "modelUpAxis": "Z",
                }))
                .ok(),
                ..Asset::default()
            },
            ..Root::default()
        };
        let views = self.push_buffer(&mut root, bin_uri);
        for index in 0..self.parts.colors.len() {
            let name = self.parts.color_name(index);
            root.push(material(name, self.parts.colors[index]));
        }
        let (nodes, instanced) = self.push_nodes(&mut root, &views);
        let turned = root.push(Node {
            name: Some("model".to_owned()),
            children: Some(nodes.clone()),
            ..Node::default()
        });
        root.scene = Some(root.push(Scene {
            extensions: None,
            extras: None,
            name: None,
            nodes: vec![turned],
        }));
        // glTF's numbers are decimal, gltf-json's are single precision: the
        // transforms go in as doubles, so that nothing is lost on the way.
        let mut json = serde_json::to_value(&root).map_err(std::io::Error::from)?;
        if self.translation != DVec3::ZERO {
            for node in nodes {
                json["nodes"][node.value()]["translation"] = json!(self.translation.to_array());
            }
        }
        for node in &instanced {
            node.tell(&mut json);
        }
        if !instanced.is_empty() {
            json["extensionsUsed"] = json!([instances::EXTENSION]);
            json["extensionsRequired"] = json!([instances::EXTENSION]);
        }
        let [x, y, z] = Z_UP_TO_Y_UP.map(|column| column.map(|entry| entry * metres));
        json["nodes"][turned.value()]["matrix"] = json!([
            x[0], x[1], x[2], 0.0, y[0], y[1], y[2], 0.0, z[0], z[1], z[2], 0.0, 0.0, 0.0, 0.0, 1.0
        ]);
        Ok(json)
    }

    /// A node for each part and for each name around parts. Returns those that are in no other,
    /// and those of instances.
    fn push_nodes(&self, root: &mut Root, views: &Views) -> (Vec<Index<Node>>, Vec<InstanceNode>) {
        let mut stretches = self.primitives.iter();
        let meshes: Vec<_> = (self.parts.parts.iter())
            .map(|part| {
                let groups = part.groups.iter().zip(stretches.by_ref());
                let primitives: Vec<_> = groups
                    .map(|(group, stretch)| self.primitive(root, views, (group, stretch)))
                    .collect();
                // (Of some all bodies are instances.)
                (!primitives.is_empty()).then(|| {
                    root.push(gltf_json::Mesh {
                        name: part.names.last().map(|&name| name.to_owned()),
                        primitives,
                        extensions: None,
                        extras: None,
                        weights: None,
                    })
                })
            })
            .collect();
        let (meshes, repeated) = meshes.split_at(meshes.len() - self.instances.len());
        let repeated: Vec<_> = repeated.iter().copied().flatten().collect();
        let instanced = instances::push_nodes(root, views.places, &self.instances, &repeated);
        let of_part = |part: Option<usize>| {
            let all = self.instances.iter().zip(&instanced);
            all.filter(move |(instances, _)| Some(instances.owner) == part)
                .map(|(_, node)| node.node)
        };
        let parts = &self.parts.parts[..meshes.len()];
        let tree = tree(parts.iter().map(|part| &part.names[..]));
        let mut nodes = vec![Index::new(0); tree.len()];
        // What is within others comes after them there, and before them here.
        for (index, branch) in tree.iter().enumerate().skip(1).rev() {
            let inner = branch.inner.iter().map(|&inner| nodes[inner]);
            let inner = inner.chain(of_part(branch.part)).collect();
            nodes[index] = root.push(Node {
                name: Some(branch.name.to_owned()),
                mesh: branch.part.and_then(|part| meshes[part]),
                children: Some(inner).filter(|inner: &Vec<_>| !inner.is_empty()),
                ..Node::default()
            });
        }
        let without_name = tree[0].part.and_then(|part| meshes[part]).map(|mesh| {
            root.push(Node {
                mesh: Some(mesh),
                ..Node::default()
            })
        });
        let inner = tree[0].inner.iter().map(|&inner| nodes[inner]);
        let outermost = without_name
            .into_iter()
            .chain(of_part(tree[0].part))
            .chain(inner);
        (outermost.collect(), instanced)
    }

    /// Faces of one name and one colour; its extras have all names around them.
    fn primitive(
        &self,
        root: &mut Root,
        views: &Views,
        (group, stretch): (&Group<'_>, &Stretch),
    ) -> Primitive {
        let (view, size, component_type) = if stretch.is_narrow() {
            (views.narrow_indices, 2, ComponentType::U16)
        } else {
            (views.wide_indices, 4, ComponentType::U32)
        };
        let has_names = !group.names.is_empty();
        Primitive {
            attributes: self.push_accessors(root, views, stretch),
            extensions: None,
            extras: has_names
                .then(|| to_raw_value(&json!({ "names": group.names })).ok())
                .flatten(),
            indices: Some(root.push(Accessor {
                buffer_view: view,
                byte_offset: Some(USize64::from(stretch.first * size)),
                count: USize64::from(stretch.indices.len()),
                component_type: Valid(GenericComponentType(component_type)),
                type_: Valid(Type::Scalar),
                ..empty_accessor()
            })),
            material: Some(Index::new(group.color as u32)),
            mode: Valid(Mode::Triangles),
            targets: None,
        }
    }

    fn push_buffer(&self, root: &mut Root, uri: Option<&str>) -> Views {
        let buffer = root.push(gltf_json::Buffer {
            byte_length: USize64::from(self.byte_length()),
            name: None,
            uri: uri.map(str::to_owned),
            extensions: None,
            extras: None,
        });
        let [wide, narrow] = [false, true].map(|narrow| self.indices_of_width(narrow));
        let (translations, rotations) = instances::counts(&self.instances);
        let mut offset: usize = 0;
        let mut view = |count: usize, size: usize, target: Option<Target>| {
            if target.is_none() {
                offset = offset.next_multiple_of(4);
            }
            let view = root.push(buffer::View {
                buffer,
                byte_length: USize64::from(count * size),
                byte_offset: Some(USize64::from(offset)),
                // Several accessors share a view, which must then say this.
                byte_stride: (target == Some(Target::ArrayBuffer)).then_some(Stride(size)),
                name: None,
                target: target.map(Valid),
                extensions: None,
                extras: None,
            });
            offset += count * size;
            view
        };
        Views {
            positions: view(self.positions.len(), 12, Some(Target::ArrayBuffer)),
            normals: (!self.normals.is_empty())
                .then(|| view(self.normals.len(), 12, Some(Target::ArrayBuffer))),
            wide_indices: (wide > 0).then(|| view(wide, 4, Some(Target::ElementArrayBuffer))),
            narrow_indices: (narrow > 0).then(|| view(narrow, 2, Some(Target::ElementArrayBuffer))),
            places: PlaceViews {
                translations: (translations > 0).then(|| view(translations, 12, None)),
                rotations: (rotations > 0).then(|| view(rotations, 16, None)),
            },
        }
    }

    fn push_accessors(
        &self,
        root: &mut Root,
        views: &Views,
        stretch: &Stretch,
    ) -> BTreeMap<gltf_json::validation::Checked<Semantic>, Index<Accessor>> {
        let vector = || Accessor {
            byte_offset: Some(USize64::from(stretch.vertices.start * 12)),
            count: USize64::from(stretch.vertices.len()),
            component_type: Valid(GenericComponentType(ComponentType::F32)),
            type_: Valid(Type::Vec3),
            ..empty_accessor()
        };
        let places = &self.positions[stretch.vertices.clone()];
        let low = places.iter().fold(Vec3::INFINITY, |low, &p| low.min(p));
        let high = places
            .iter()
            .fold(Vec3::NEG_INFINITY, |high, &p| high.max(p));
        let mut attributes = BTreeMap::new();
        let positions = root.push(Accessor {
            buffer_view: Some(views.positions),
            min: Some(json!(low.to_array())),
            max: Some(json!(high.to_array())),
            ..vector()
        });
        attributes.insert(Valid(Semantic::Positions), positions);
        if views.normals.is_some() {
            let normals = root.push(Accessor {
                buffer_view: views.normals,
                ..vector()
            });
            attributes.insert(Valid(Semantic::Normals), normals);
        }
        attributes
    }
}

struct Views {
    positions: Index<buffer::View>,
    normals: Option<Index<buffer::View>>,
    wide_indices: Option<Index<buffer::View>>,
    narrow_indices: Option<Index<buffer::View>>,
    places: PlaceViews,
}

pub(super) fn empty_accessor() -> Accessor {
    Accessor {
        buffer_view: None,
        byte_offset: None,
        count: USize64(0),
        component_type: Valid(GenericComponentType(ComponentType::F32)),
        extensions: None,
        extras: None,
        type_: Valid(Type::Scalar),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}

/// A matt material of the colour; glTF's factors are linear, as ours are.
fn material(name: String, color: Option<Color>) -> Material {
    let Color {
        rgb: [r, g, b],
        alpha,
    } = color.unwrap_or(DEFAULT_COLOR);
    Material {
        name: Some(name),
        alpha_mode: Valid(if alpha < 1.0 {
            AlphaMode::Blend
        } else {
            AlphaMode::Opaque
        }),
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor([r, g, b, alpha]),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(0.5),
            ..PbrMetallicRoughness::default()
        },
        ..Material::default()
    }
}

/// The centre of the bounds, rounded to a multiple of a power of two about as
/// large as the model.
pub(super) fn rounded_centre((low, high): (DVec3, DVec3)) -> DVec3 {
    let half = (high / 2.0 - low / 2.0).max_element();
    let step = elementary::exp2(elementary::log2(half).floor());
    let translation = (low.midpoint(high) / step).round() * step;
    // (A single point has no size, a giant no step.)
    if translation.is_finite() {
        // Sums with +0 turn -0 into 0, which reads better.
        translation + 0.0
    } else {
        DVec3::ZERO
    }
}
