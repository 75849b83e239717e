//! The glTF reader: the triangles of the default scene, in the model's own
//! axes and unit. Animations, skins, textures and cameras are passed over.

use std::ops::Range;

use csg::{Color, LengthUnit, Mesh};
use glam::{DMat3, DMat4, DQuat, DVec3, DVec4, Vec3};
use rayon::prelude::*;

use super::Z_UP_TO_Y_UP;
use super::accessors::{Indices, LIST, Loaded, Vectors, triangle_count};
use super::document::{Document, Node, PlaceAttributes, Primitive};
use crate::assemble::{Assembled, Assembler};
use crate::contents::Contents;
use crate::weld::{self, split, weld};
use crate::{Error, MeshFormat, units};

/// Reads a binary glTF file (GLB) that holds all of its data.
///
/// The mesh is in the unit that this crate's writer noted, else in
/// millimetres, and Z is up. Vertices at exactly the same place become one,
/// and triangles that thereby vanish are left out. The names that it noted, else nodes' names,
/// and materials' base colours become the surfaces' names and colours.
///
/// # Errors
/// A damaged file, one without triangles, data in other files, required extensions that change the
/// geometry (compression), sparse accessors.
pub fn read_glb(data: &[u8]) -> Result<Mesh, Error> {
    read_glb_with(data, false).map(|read| read.mesh)
}

/// [`read_glb`]; with `apart`, vertices that have normals are not welded. Each mesh in each of its
/// places is an object.
pub(crate) fn read_glb_with(data: &[u8], apart: bool) -> Result<Assembled, Error> {
    let word = |at: usize| -> Result<usize, Error> {
        let bytes = data.get(at..at + 4).and_then(|b| b.try_into().ok());
        let bytes = bytes.ok_or_else(|| malformed(format!("byte {at}"), CUT_OFF))?;
        Ok(u32::from_le_bytes(bytes) as usize)
    };
    if data.get(..4) != Some(b"glTF") {
        return Err(malformed(
            "byte 0",
            "this is no GLB file: it must begin with \"glTF\"",
        ));
    }
    if word(4)? != 2 {
        return Err(malformed(
            "byte 4",
            "only version 2 of glTF can be read; convert the file",
        ));
    }
    let mut json = None;
    let mut bin = None;
    let mut at = 12;
    while at + 8 <= data.len().min(word(8)?) {
        let content = data
            .get(at + 8..at + 8 + word(at)?)
            .ok_or_else(|| malformed(format!("chunk at byte {at}"), CUT_OFF))?;
        match &data[at + 4..at + 8] {
            b"JSON" if json.is_none() => json = Some(content),
            b"BIN\0" if bin.is_none() => bin = Some(content),
            // Other chunks are extensions, to be passed over.
            _ => {}
        }
        at += 8 + content.len();
    }
    let json = json.ok_or_else(|| malformed("byte 12", "there is no JSON chunk"))?;
    read(json, apart, &mut |index, uri| match uri {
        None if index == 0 => bin.map(Contents::Borrowed).ok_or_else(|| {
            malformed(
                "buffer 0",
                "the file has no binary chunk; it may be cut off",
            )
        }),
        None => Err(malformed(
            format!("buffer {index}"),
            "it has neither URI nor chunk",
        )),
        Some(uri) => data_uri(uri, index)?.map(Contents::Read).ok_or_else(|| {
            let problem = format!("its data is in {uri:?}; give the path, or embed the data");
            malformed(format!("buffer {index}"), problem)
        }),
    })
}

/// Reads a glTF file from its JSON; `load` fetches what a relative URI
/// (percent-decoded) names. For the rest, see [`read_glb`].
///
/// # Errors
/// As [`read_glb`], and whatever `load` returns.
pub fn read_gltf(
    json: &[u8],
    mut load: impl FnMut(&str) -> Result<Vec<u8>, Error>,
) -> Result<Mesh, Error> {
    read_gltf_with(json, false, |name| load(name).map(Contents::Read)).map(|read| read.mesh)
}

/// [`read_gltf`]; with `apart`, vertices that have normals are not welded.
pub(crate) fn read_gltf_with(
    json: &[u8],
    apart: bool,
    mut load: impl FnMut(&str) -> Result<Contents<'static>, Error>,
) -> Result<Assembled, Error> {
    read(json, apart, &mut |index, uri| {
        let uri = uri.ok_or_else(|| malformed(format!("buffer {index}"), "it has no URI"))?;
        match data_uri(uri, index)? {
            Some(data) => Ok(Contents::Read(data)),
            None => load(&percent_decoded(uri)),
        }
    })
}

pub(super) const CUT_OFF: &str = "the data ends too early; the file may have been cut off";

pub(super) fn malformed(place: impl Into<String>, problem: impl Into<String>) -> Error {
    Error::Malformed {
        format: MeshFormat::Gltf,
        place: place.into(),
        problem: problem.into(),
    }
}

/// Gives a buffer's bytes by its index and URI.
type LoadBuffer<'a, 'data> = dyn FnMut(usize, Option<&str>) -> Result<Contents<'data>, Error> + 'a;

fn read<'data>(
    json: &[u8],
    apart: bool,
    load: &mut LoadBuffer<'_, 'data>,
) -> Result<Assembled, Error> {
    #[cfg_attr(not(feature = "compress"), expect(unused_mut))]
    let mut document: Document = serde_json::from_slice(json)
        .map_err(|error| malformed("JSON", format!("it is not a glTF document: {error}")))?;
    if !document.asset.version.starts_with("2.") {
        let problem = format!(
            "version {:?} cannot be read, only 2.x",
            document.asset.version
        );
        return Err(malformed("asset.version", problem));
    }
    // Extensions about looks do not touch the geometry; the others are understood.
    let harmless = [
        "KHR_materials_",
        "KHR_texture_",
        "KHR_lights_",
        "KHR_mesh_quantization",
        "EXT_mesh_gpu_instancing",
    ];
    let is_coded = |name: &String| cfg!(feature = "compress") && name == "EXT_meshopt_compression";
    let known =
        |name: &String| harmless.iter().any(|prefix| name.starts_with(prefix)) || is_coded(name);
    if let Some(name) = document
        .extensions_required
        .iter()
        .find(|name| !known(name))
    {
        let problem = format!("{name} is not known here; export the file without it");
        return Err(malformed("extensionsRequired", problem));
    }
    #[cfg_attr(not(feature = "compress"), expect(unused_mut))]
    let mut buffers = document
        .buffers
        .iter()
        .enumerate()
        .map(|(index, buffer)| match buffer.is_fallback() {
            true => Ok(Contents::Read(Vec::new())),
            false => load(index, buffer.uri.as_deref()),
        })
        .collect::<Result<Vec<_>, _>>()?;
    #[cfg(feature = "compress")]
    super::compress::decode(&mut document, &mut buffers)?;
    let unit = document.asset.extras["unit"]
        .as_str()
        .and_then(units::named)
        .unwrap_or_default();
    let read = Loaded { document, buffers }.scene(unit, apart)?;
    if read.mesh.triangles.is_empty() {
        let problem =
            "there is no triangle with three corners in it; points and lines are passed over";
        return Err(malformed("scene", problem));
    }
    Ok(read)
}

/// A file may have many instances of many triangles in few bytes.
const MOST_TRIANGLES: usize = 1 << 28;

/// Triangles to be read: a primitive where a node places it.
struct Item<'a> {
    node: &'a Node,
    primitive: &'a Primitive,
    /// Whether it is the first of the node's mesh in its place.
    begins: bool,
    /// Where it stands in the file.
    place: String,
    transform: DMat4,
    positions: Vectors<'a>,
    normals: Option<Vectors<'a>>,
    indices: Indices<'a>,
}

impl Item<'_> {
    /// The names that the writer noted, the outermost first, else the node's.
    fn names(&self) -> Vec<&str> {
        match self.primitive.extras["names"].as_array() {
            Some(names) => names.iter().filter_map(|name| name.as_str()).collect(),
            None => self.node.name.as_deref().into_iter().collect(),
        }
    }

    fn mode(&self) -> u32 {
        self.primitive.mode.unwrap_or(LIST)
    }

    fn triangles(&self) -> usize {
        triangle_count(self.mode(), self.indices.count())
    }

    fn is_mirrored(&self) -> bool {
        DMat3::from_mat4(self.transform).determinant() < 0.0
    }

    /// The normals in the model's axes.
    fn turned_normals(&self) -> Vec<Vec3> {
        let Some(normals) = &self.normals else {
            return Vec::new();
        };
        // Normals go with the cofactors, which need no inverse; their sign
        // under mirroring is undone.
        let linear = DMat3::from_mat4(self.transform);
        let cofactors = DMat3::from_cols(
            linear.y_axis.cross(linear.z_axis),
            linear.z_axis.cross(linear.x_axis),
            linear.x_axis.cross(linear.y_axis),
        );
        let sign = if self.is_mirrored() { -1.0 } else { 1.0 };
        let turn = |i| {
            (cofactors * normals.get(i) * sign)
                .normalize_or_zero()
                .as_vec3()
        };
        (0..normals.count()).into_par_iter().map(turn).collect()
    }
}

impl Loaded<'_> {
    fn scene(&self, unit: LengthUnit, apart: bool) -> Result<Assembled, Error> {
        let document = &self.document;
        let scene = document.scene.unwrap_or(0);
        let roots = match document.scenes.get(scene) {
            Some(scene) => scene.nodes.clone(),
            None if document.scenes.is_empty() && document.scene.is_none() => {
                self.nodes_without_parent()
            }
            None => return Err(malformed("scene", format!("there is no scene {scene}"))),
        };
        let mut items: Vec<Item> = Vec::new();
        let mut triangles = 0_usize;
        let mut visited = vec![false; document.nodes.len()];
        let mut stack: Vec<(usize, Option<DMat4>)> =
            roots.into_iter().rev().map(|root| (root, None)).collect();
        while let Some((index, parent)) = stack.pop() {
            let place = || format!("node {index}");
            let node = document.nodes.get(index);
            let node = node.ok_or_else(|| malformed(place(), "there is no such node"))?;
            if std::mem::replace(&mut visited[index], true) {
                return Err(malformed(
                    place(),
                    "it is reached twice; nodes must form a tree",
                ));
            }
            let transform = match parent {
                Some(parent) => parent * node.transform(),
                None => to_model(node.transform(), unit),
            };
            if !transform.is_finite() {
                return Err(malformed(place(), "its transform is not finite"));
            }
            stack.extend(
                node.children
                    .iter()
                    .rev()
                    .map(|&child| (child, Some(transform))),
            );
            if let Some(mesh) = node.mesh {
                let entry = document.meshes.get(mesh);
                let entry = entry.ok_or_else(|| malformed(place(), "there is no such mesh"))?;
                let instances = match &node.extensions.instancing {
                    Some(of) => self.instances(&of.attributes, &place())?,
                    None => vec![DMat4::IDENTITY],
                };
                for instance in instances {
                    let transform = transform * instance;
                    let first = items.len();
                    if !transform.is_finite() {
                        return Err(malformed(place(), "an instance's transform is not finite"));
                    }
                    for (number, primitive) in entry.primitives.iter().enumerate() {
                        let place = format!("mesh {mesh}, primitive {number}");
                        // Points, lines and what has no place are passed over.
                        let position = primitive.attributes.position;
                        let has_faces = primitive.mode.unwrap_or(LIST) >= LIST;
                        if let Some(position) = position.filter(|_| has_faces) {
                            let item = self.item(node, primitive, position, place, transform)?;
                            triangles = triangles.saturating_add(item.triangles());
                            items.push(item);
                        }
                    }
                    if let Some(item) = items.get_mut(first) {
                        item.begins = true;
                    }
                    let is_repeated = node.extensions.instancing.is_some();
                    if is_repeated && items.len().max(triangles) > MOST_TRIANGLES {
                        let problem = "it has far more triangles, instance by instance, than a \
                                       mesh can hold here";
                        return Err(malformed(place(), problem));
                    }
                }
            }
        }
        self.assemble(&items, unit, apart)
    }

    /// Where a node's mesh is, within the node.
    fn instances(&self, of: &PlaceAttributes, place: &str) -> Result<Vec<DMat4>, Error> {
        let vectors = |accessor: Option<usize>| {
            let vectors = accessor.map(|accessor| self.vectors(accessor, place));
            vectors.transpose()
        };
        let (translations, scales) = (vectors(of.translation)?, vectors(of.scale)?);
        let rotations = of.rotation.map(|rotation| self.quadruples(rotation, place));
        let rotations = rotations.transpose()?;
        let counts = [
            translations.as_ref().map(Vectors::count),
            rotations.as_ref().map(Vec::len),
            scales.as_ref().map(Vectors::count),
        ];
        let mut counts = counts.into_iter().flatten();
        let count = counts.next().unwrap_or(0);
        if counts.any(|other| other != count) {
            let problem = "its instances have not as many translations, rotations and scales";
            return Err(malformed(place, problem));
        }
        let at = |index: usize| {
            let rotation = rotations.as_ref().map(|rotations| rotations[index]);
            let rotation = rotation.map_or(Some(DQuat::IDENTITY), |q| {
                q.try_normalize().map(DQuat::from_vec4)
            });
            let rotation = rotation.ok_or_else(|| malformed(place, "a rotation is none"))?;
            Ok(DMat4::from_scale_rotation_translation(
                scales
                    .as_ref()
                    .map_or(DVec3::ONE, |scales| scales.get(index)),
                rotation,
                (translations.as_ref()).map_or(DVec3::ZERO, |all| all.get(index)),
            ))
        };
        (0..count).map(at).collect()
    }

    /// Looks up what a primitive consists of.
    fn item<'a>(
        &'a self,
        node: &'a Node,
        primitive: &'a Primitive,
        position: usize,
        place: String,
        transform: DMat4,
    ) -> Result<Item<'a>, Error> {
        let positions = self.vectors(position, &place)?;
        let normals = match primitive.attributes.normal {
            Some(normal) => Some(self.vectors(normal, &place)?).filter(|n| n.count() != 0),
            None => None,
        };
        if normals
            .as_ref()
            .is_some_and(|n| n.count() != positions.count())
        {
            return Err(malformed(place, "it has not as many normals as positions"));
        }
        let indices = match primitive.indices {
            Some(indices) => self.indices(indices, &place)?,
            None => Indices::Counted(positions.count()),
        };
        Ok(Item {
            node,
            primitive,
            begins: false,
            place,
            transform,
            positions,
            normals,
            indices,
        })
    }

    /// Finds the vertices of all items, then puts their triangles together.
    fn assemble(&self, items: &[Item], unit: LengthUnit, apart: bool) -> Result<Assembled, Error> {
        let blocks = blocks(items, |item| item.positions.count(), weld::BLOCK);
        let lengths: Vec<usize> = blocks.iter().map(|(_, range)| range.len()).collect();
        let count: usize = lengths.iter().sum();
        let place = |item: &Item, index: usize| {
            let place = item.transform.transform_point3(item.positions.get(index));
            let finite = place.is_finite().then_some(place);
            finite.ok_or_else(|| malformed(&*item.place, "a position is not finite"))
        };
        let too_many = || malformed("meshes", "too many vertices");
        if u32::try_from(count).is_err() {
            return Err(too_many());
        }
        let with_normals = items
            .iter()
            .all(|i| i.normals.is_some() || i.triangles() == 0);
        let (positions, numbers);
        if apart && with_normals {
            numbers = (0..count as u32).collect();
            let mut places: Vec<DVec3> = bytemuck::zeroed_vec(count);
            split(&mut places, lengths.iter().copied())
                .into_par_iter()
                .zip(&blocks)
                .map(|(places, (item, range))| {
                    let mut to = places.iter_mut().zip(range.clone());
                    to.try_for_each(|(to, index)| place(&items[*item], index).map(|p| *to = p))
                })
                // (Not straight into a `Result`, which would keep any error.)
                .collect::<Vec<_>>()
                .into_iter()
                .collect::<Result<(), Error>>()?;
            positions = places;
        } else {
            let mut found = vec![0; count];
            let places = weld(&mut found, &lengths, |block, places| {
                let (item, range) = &blocks[block];
                for index in range.clone() {
                    places.push(place(&items[*item], index)?);
                }
                Ok::<_, Error>(())
            })?;
            positions = places.ok_or_else(too_many)?;
            numbers = found;
        }
        let mut assembler = Assembler::new(unit);
        assembler.add_vertices(positions);
        let mut objects = Vec::new();
        let mut before = 0;
        for item in items {
            if item.begins {
                objects.push(before);
            }
            before += item.triangles();
        }
        assembler.begin_objects(objects);
        self.triangles(items, with_normals, &numbers, &mut assembler)?;
        Ok(assembler.finish())
    }

    /// Adds the triangles of all items; `numbers` has the vertices of one
    /// after the other.
    fn triangles(
        &self,
        items: &[Item],
        with_normals: bool,
        numbers: &[u32],
        assembler: &mut Assembler,
    ) -> Result<(), Error> {
        let mut rest = numbers;
        let vertices: Vec<(&[u32], Vec<Vec3>)> = items
            .iter()
            .map(|item| {
                let own;
                (own, rest) = rest.split_at(item.positions.count());
                let turned = if with_normals {
                    item.turned_normals()
                } else {
                    Vec::new()
                };
                (own, turned)
            })
            .collect();
        let blocks = blocks(items, Item::triangles, weld::BLOCK / 3);
        let lengths: Vec<usize> = blocks.iter().map(|(_, range)| range.len()).collect();
        let part = |block: usize| {
            let item = &items[blocks[block].0];
            (item.names(), self.color(item.primitive.material))
        };
        assembler.all_triangles(&lengths, with_normals, part, |block, triangles, normals| {
            let (item, range) = &blocks[block];
            let (vertices, turned) = &vertices[*item];
            let item = &items[*item];
            let (mode, mirrored) = (item.mode(), item.is_mirrored());
            for (k, (index, to)) in range.clone().zip(triangles).enumerate() {
                let [a, b, c] = item.indices.corners(mode, index);
                let corners = if mirrored { [a, c, b] } else { [a, b, c] };
                let count = vertices.len();
                if let Some(beyond) = corners.iter().find(|&&i| i as usize >= count) {
                    let problem = format!("index {beyond} is beyond its {count} positions");
                    return Err(malformed(&*item.place, problem));
                }
                *to = corners.map(|i| vertices[i as usize]);
                if let Some(normals) = normals.get_mut(k) {
                    *normals = corners.map(|i| turned[i as usize]);
                }
            }
            Ok(())
        })
    }

    fn nodes_without_parent(&self) -> Vec<usize> {
        let nodes = &self.document.nodes;
        let mut is_child = vec![false; nodes.len()];
        for &child in nodes.iter().flat_map(|node| &node.children) {
            if let Some(entry) = is_child.get_mut(child) {
                *entry = true;
            }
        }
        (0..nodes.len()).filter(|&index| !is_child[index]).collect()
    }

    fn color(&self, material: Option<usize>) -> Option<Color> {
        let material = self.document.materials.get(material?)?;
        if material.name.as_deref() == Some(crate::parts::DEFAULT_MATERIAL) {
            return None;
        }
        let [r, g, b, alpha] = material.pbr_metallic_roughness.base_color_factor?;
        Some(Color::from_linear([r, g, b]).with_alpha(alpha))
    }
}

/// Pieces of at most `most` elements of each item, of which `count` says how
/// many there are: the item's number and a range of its elements.
fn blocks<'a>(
    items: &[Item<'a>],
    count: impl Fn(&Item<'a>) -> usize,
    most: usize,
) -> Vec<(usize, Range<usize>)> {
    let mut blocks = Vec::new();
    for (number, item) in items.iter().enumerate() {
        let count = count(item);
        let starts = (0..count).step_by(most);
        blocks.extend(starts.map(|start| (number, start..count.min(start + most))));
    }
    blocks
}

/// A root's transform, followed by the change from metres with Y up to the
/// unit with Z up. (Divided, entry by entry: what the writer multiplied with
/// the unit then returns exactly.)
fn to_model(root: DMat4, unit: LengthUnit) -> DMat4 {
    let from_y_up = DMat3::from_cols_array_2d(&Z_UP_TO_Y_UP).transpose();
    let column =
        |column: DVec4| (from_y_up * column.truncate() / unit.in_metres()).extend(column.w);
    DMat4::from_cols(
        column(root.x_axis),
        column(root.y_axis),
        column(root.z_axis),
        column(root.w_axis),
    )
}

/// The bytes of a `data:` URI; `None` if it is another kind of URI.
fn data_uri(uri: &str, index: usize) -> Result<Option<Vec<u8>>, Error> {
    use base64::Engine;
    let Some(rest) = uri.strip_prefix("data:") else {
        return Ok(None);
    };
    rest.split_once(";base64,")
        .and_then(|(_, text)| base64::engine::general_purpose::STANDARD.decode(text).ok())
        .map(Some)
        .ok_or_else(|| {
            malformed(
                format!("buffer {index}"),
                "its data URI is not valid base64",
            )
        })
}

/// A URI's path with `%20` and the like resolved.
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let code = (*first == b'%')
            .then(|| tail.get(..2).and_then(|d| std::str::from_utf8(d).ok()))
            .flatten()
            .and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match code {
            Some(code) => {
                bytes.push(code);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
