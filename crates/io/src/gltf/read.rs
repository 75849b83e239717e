//! The glTF reader: the triangles of the default scene, in the model's own
//! axes and unit. Animations, skins, textures and cameras are passed over.

use std::borrow::Cow;
use std::ops::Range;

use csg::{Color, LengthUnit, Mesh};
use glam::{DMat3, DMat4, DQuat, DVec3, DVec4, Vec3};
use rayon::prelude::*;
use serde::Deserialize;

use super::Z_UP_TO_Y_UP;
use crate::assemble::Assembler;
use crate::weld::{self, weld};
use crate::{Error, MeshFormat, units};

/// Reads a binary glTF file (GLB) that holds all of its data.
///
/// The mesh is in the unit that this crate's writer noted, else in
/// millimetres, and Z is up. Vertices at exactly the same place become one,
/// and triangles that thereby vanish are left out. Nodes' names and
/// materials' base colours become the surfaces' names and colours.
///
/// # Errors
/// A damaged file, data in other files, required extensions that change the
/// geometry (compression), sparse accessors.
pub fn read_glb(data: &[u8]) -> Result<Mesh, Error> {
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
    read(json, &mut |index, uri| match uri {
        None if index == 0 => bin.map(Cow::Borrowed).ok_or_else(|| {
            malformed(
                "buffer 0",
                "the file has no binary chunk; it may be cut off",
            )
        }),
        None => Err(malformed(
            format!("buffer {index}"),
            "it has neither URI nor chunk",
        )),
        Some(uri) => data_uri(uri, index)?.map(Cow::Owned).ok_or_else(|| {
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
    read(json, &mut |index, uri| {
        let uri = uri.ok_or_else(|| malformed(format!("buffer {index}"), "it has no URI"))?;
        match data_uri(uri, index)? {
            Some(data) => Ok(Cow::Owned(data)),
            None => load(&percent_decoded(uri)).map(Cow::Owned),
        }
    })
}

const CUT_OFF: &str = "the data ends too early; the file may have been cut off";

fn malformed(place: impl Into<String>, problem: impl Into<String>) -> Error {
    Error::Malformed {
        format: MeshFormat::Gltf,
        place: place.into(),
        problem: problem.into(),
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Document {
    asset: Asset,
    scene: Option<usize>,
    #[serde(default)]
    scenes: Vec<Scene>,
    #[serde(default)]
    nodes: Vec<Node>,
    #[serde(default)]
    meshes: Vec<MeshEntry>,
    #[serde(default)]
    materials: Vec<MaterialEntry>,
    #[serde(default)]
    accessors: Vec<Accessor>,
    #[serde(default)]
    buffer_views: Vec<BufferView>,
    #[serde(default)]
    buffers: Vec<Buffer>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
    #[serde(default)]
    extras: serde_json::Value,
}

#[derive(Deserialize)]
struct Scene {
    #[serde(default)]
    nodes: Vec<usize>,
}

#[derive(Deserialize)]
struct Node {
    name: Option<String>,
    mesh: Option<usize>,
    #[serde(default)]
    children: Vec<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Deserialize)]
struct MeshEntry {
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: Attributes,
    indices: Option<usize>,
    material: Option<usize>,
    mode: Option<u32>,
}

#[derive(Deserialize)]
struct Attributes {
    #[serde(rename = "POSITION")]
    position: Option<usize>,
    #[serde(rename = "NORMAL")]
    normal: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct MaterialEntry {
    name: Option<String>,
    #[serde(default)]
    pbr_metallic_roughness: Pbr,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Pbr {
    base_color_factor: Option<[f32; 4]>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    count: usize,
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    normalized: bool,
    sparse: Option<serde_json::Value>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
struct Buffer {
    uri: Option<String>,
}

impl Node {
    fn transform(&self) -> DMat4 {
        if let Some(matrix) = &self.matrix {
            return DMat4::from_cols_array(matrix);
        }
        DMat4::from_scale_rotation_translation(
            self.scale.map_or(DVec3::ONE, DVec3::from_array),
            self.rotation.map_or(DQuat::IDENTITY, DQuat::from_array),
            self.translation.map_or(DVec3::ZERO, DVec3::from_array),
        )
    }
}

/// Gives a buffer's bytes by its index and URI.
type LoadBuffer<'a, 'data> = dyn FnMut(usize, Option<&str>) -> Result<Cow<'data, [u8]>, Error> + 'a;

fn read<'data>(json: &[u8], load: &mut LoadBuffer<'_, 'data>) -> Result<Mesh, Error> {
    let document: Document = serde_json::from_slice(json)
        .map_err(|error| malformed("JSON", format!("it is not a glTF document: {error}")))?;
    if !document.asset.version.starts_with("2.") {
        let problem = format!(
            "version {:?} cannot be read, only 2.x",
            document.asset.version
        );
        return Err(malformed("asset.version", problem));
    }
    // Extensions about looks do not touch the geometry.
    let harmless = [
        "KHR_materials_",
        "KHR_texture_",
        "KHR_lights_",
        "KHR_mesh_quantization",
    ];
    let known = |name: &String| harmless.iter().any(|prefix| name.starts_with(prefix));
    if let Some(name) = document
        .extensions_required
        .iter()
        .find(|name| !known(name))
    {
        let problem = format!("{name} is not known here; export the file without it");
        return Err(malformed("extensionsRequired", problem));
    }
    let buffers = document
        .buffers
        .iter()
        .enumerate()
        .map(|(index, buffer)| load(index, buffer.uri.as_deref()))
        .collect::<Result<Vec<_>, _>>()?;
    let unit = document.asset.extras["unit"]
        .as_str()
        .and_then(units::named)
        .unwrap_or_default();
    let reader = Reader { document, buffers };
    reader.scene(unit)
}

struct Reader<'data> {
    document: Document,
    buffers: Vec<Cow<'data, [u8]>>,
}

/// Triangles to be read: a primitive where a node places it.
struct Item<'a> {
    node: &'a Node,
    primitive: &'a Primitive,
    /// Where it stands in the file.
    place: String,
    transform: DMat4,
    positions: Vectors<'a>,
    normals: Option<Vectors<'a>>,
    indices: Indices<'a>,
}

impl Item<'_> {
    fn mode(&self) -> u32 {
        self.primitive.mode.unwrap_or(LIST)
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

impl Reader<'_> {
    fn scene(&self, unit: LengthUnit) -> Result<Mesh, Error> {
        let document = &self.document;
        let scene = document.scene.unwrap_or(0);
        let roots = match document.scenes.get(scene) {
            Some(scene) => scene.nodes.clone(),
            None if document.scenes.is_empty() && document.scene.is_none() => {
                self.nodes_without_parent()
            }
            None => return Err(malformed("scene", format!("there is no scene {scene}"))),
        };
        let mut items = Vec::new();
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
                for (number, primitive) in entry.primitives.iter().enumerate() {
                    let place = format!("mesh {mesh}, primitive {number}");
                    // Points, lines and what has no place are passed over.
                    let position = primitive.attributes.position;
                    let triangles = primitive.mode.unwrap_or(LIST) >= LIST;
                    if let Some(position) = position.filter(|_| triangles) {
                        items.push(self.item(node, primitive, position, place, transform)?);
                    }
                }
            }
        }
        self.assemble(&items, unit)
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
            place,
            transform,
            positions,
            normals,
            indices,
        })
    }

    /// Welds the vertices of all items, then puts their triangles together.
    fn assemble(&self, items: &[Item], unit: LengthUnit) -> Result<Mesh, Error> {
        let blocks = blocks(items, |item| item.positions.count(), weld::BLOCK);
        let lengths: Vec<usize> = blocks.iter().map(|(_, range)| range.len()).collect();
        let mut numbers = vec![0; lengths.iter().sum()];
        let positions = weld(&mut numbers, &lengths, |block, places| {
            let (item, range) = &blocks[block];
            let item = &items[*item];
            for index in range.clone() {
                let place = item.transform.transform_point3(item.positions.get(index));
                if !place.is_finite() {
                    return Err(malformed(&*item.place, "a position is not finite"));
                }
                places.push(place);
            }
            Ok(())
        })?;
        let positions = positions.ok_or_else(|| malformed("meshes", "too many vertices"))?;
        let mut assembler = Assembler::new(unit);
        assembler.add_vertices(positions);
        self.triangles(items, &numbers, &mut assembler)?;
        Ok(assembler.finish())
    }

    /// Adds the triangles of all items; `numbers` has the vertices of one
    /// after the other.
    fn triangles(
        &self,
        items: &[Item],
        numbers: &[u32],
        assembler: &mut Assembler,
    ) -> Result<(), Error> {
        let count = |item: &Item| triangle_count(item.mode(), item.indices.count());
        let with_normals = items.iter().all(|i| i.normals.is_some() || count(i) == 0);
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
        let blocks = blocks(items, count, weld::BLOCK / 3);
        let lengths: Vec<usize> = blocks.iter().map(|(_, range)| range.len()).collect();
        let part = |block: usize| {
            let item = &items[blocks[block].0];
            (
                item.node.name.as_deref(),
                self.color(item.primitive.material),
            )
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

    fn vectors(&self, accessor: usize, place: &str) -> Result<Vectors<'_>, Error> {
        let elements = self.elements(accessor, "VEC3", 3, place)?;
        Ok(Vectors {
            component: component_reader(elements.entry, place)?,
            elements,
        })
    }

    fn indices(&self, accessor: usize, place: &str) -> Result<Indices<'_>, Error> {
        let elements = self.elements(accessor, "SCALAR", 1, place)?;
        match elements.entry.component_type {
            5121 | 5123 | 5125 => Ok(Indices::Listed(elements)),
            _ => Err(malformed(place, "its indices are no unsigned integers")),
        }
    }

    /// The bytes of each element of an accessor, all of them in range.
    fn elements(
        &self,
        accessor: usize,
        kind: &str,
        components: usize,
        place: &str,
    ) -> Result<Elements<'_>, Error> {
        let wrong = |problem: &str| malformed(format!("{place}, accessor {accessor}"), problem);
        let entry = self.document.accessors.get(accessor);
        let entry = entry.ok_or_else(|| wrong("there is no such accessor"))?;
        if entry.sparse.is_some() {
            return Err(wrong(
                "sparse accessors cannot be read; export without them",
            ));
        }
        if entry.kind != kind {
            return Err(wrong(&format!(
                "its type is {:?} instead of {kind}",
                entry.kind
            )));
        }
        let view = entry
            .buffer_view
            .and_then(|view| self.document.buffer_views.get(view));
        let view = view.ok_or_else(|| wrong("there is no such buffer view"))?;
        let size = component_size(entry.component_type) * components;
        if size == 0 {
            return Err(wrong("its component type is unknown"));
        }
        let stride = view.byte_stride.unwrap_or(size);
        if stride < size {
            return Err(wrong(
                "its elements overlap: the view's stride is too small",
            ));
        }
        let bytes = (|| {
            let view_end = view.byte_offset.checked_add(view.byte_length)?;
            let data = self
                .buffers
                .get(view.buffer)?
                .get(view.byte_offset..view_end)?;
            let data = data.get(entry.byte_offset..)?;
            match entry.count.checked_sub(1) {
                None => Some(&data[..0]),
                Some(before) => data.get(..stride.checked_mul(before)?.checked_add(size)?),
            }
        })();
        let bytes = bytes.ok_or_else(|| wrong(CUT_OFF))?;
        Ok(Elements {
            entry,
            bytes,
            stride,
            size,
        })
    }
}

/// The elements of an accessor, all of them in range.
struct Elements<'a> {
    entry: &'a Accessor,
    bytes: &'a [u8],
    stride: usize,
    /// Bytes of an element.
    size: usize,
}

impl Elements<'_> {
    fn count(&self) -> usize {
        self.entry.count
    }

    #[inline]
    fn get(&self, index: usize) -> &[u8] {
        &self.bytes[index * self.stride..][..self.size]
    }
}

/// An accessor of three coordinates an element.
struct Vectors<'a> {
    elements: Elements<'a>,
    component: fn(&[u8]) -> f64,
}

impl Vectors<'_> {
    fn count(&self) -> usize {
        self.elements.count()
    }

    #[inline]
    fn get(&self, index: usize) -> DVec3 {
        let bytes = self.elements.get(index);
        if let ([x, y, z], []) = bytes.as_chunks::<4>()
            && self.elements.entry.component_type == FLOAT
        {
            return DVec3::from_array([x, y, z].map(|c| f64::from(f32::from_le_bytes(*c))));
        }
        let size = self.elements.size / 3;
        DVec3::from_array([0, 1, 2].map(|i| (self.component)(&bytes[i * size..])))
    }
}

/// The indices of a primitive.
enum Indices<'a> {
    Listed(Elements<'a>),
    /// 0, 1, 2, ...
    Counted(usize),
}

impl Indices<'_> {
    fn count(&self) -> usize {
        match self {
            Self::Listed(elements) => elements.count(),
            Self::Counted(count) => *count,
        }
    }

    #[inline]
    fn get(&self, index: usize) -> u32 {
        match self {
            Self::Listed(elements) => match *elements.get(index) {
                [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
                [a, b] => u32::from(u16::from_le_bytes([a, b])),
                [a] => u32::from(a),
                _ => u32::MAX,
            },
            Self::Counted(_) => index as u32,
        }
    }

    /// The corners of a triangle of a list, a strip or a fan.
    #[inline]
    fn corners(&self, mode: u32, triangle: usize) -> [u32; 3] {
        if let Self::Listed(Elements {
            bytes, stride: 4, ..
        }) = self
            && mode == LIST
            && let Some((&[a, b, c], _)) = bytes
                .get(12 * triangle..)
                .and_then(|rest| rest.as_chunks::<4>().0.split_first_chunk::<3>())
            && matches!(self, Self::Listed(elements) if elements.size == 4)
        {
            return [a, b, c].map(u32::from_le_bytes);
        }
        corners_of(mode, triangle).map(|index| self.get(index))
    }
}

/// Pieces of at most `most` elements of each item, of which `count` says how
/// many there are: the item's number and a range of its elements.
fn blocks(
    items: &[Item],
    count: impl Fn(&Item) -> usize,
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

/// The component type of single precision.
const FLOAT: u32 = 5126;

/// Bytes of a component type, 0 for an unknown one.
fn component_size(component_type: u32) -> usize {
    match component_type {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        5125 | FLOAT => 4,
        _ => 0,
    }
}

/// Reads a component of an accessor of floats (or of the integers that
/// KHR_mesh_quantization allows in their place).
fn component_reader(entry: &Accessor, place: &str) -> Result<fn(&[u8]) -> f64, Error> {
    Ok(match (entry.component_type, entry.normalized) {
        (FLOAT, _) => |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        (5120, false) => |b| f64::from(i8::from_le_bytes([b[0]])),
        (5121, false) => |b| f64::from(b[0]),
        (5122, false) => |b| f64::from(i16::from_le_bytes([b[0], b[1]])),
        (5123, false) => |b| f64::from(u16::from_le_bytes([b[0], b[1]])),
        (5120, true) => |b| (f64::from(i8::from_le_bytes([b[0]])) / 127.0).max(-1.0),
        (5121, true) => |b| f64::from(b[0]) / 255.0,
        (5122, true) => |b| (f64::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0).max(-1.0),
        (5123, true) => |b| f64::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0,
        _ => {
            return Err(malformed(
                place,
                "its coordinates have an unknown component type",
            ));
        }
    })
}

/// The mode of a list of triangles; the modes below are points and lines.
const LIST: u32 = 4;

/// How many triangles so many indices make in a list, a strip (5) or a fan (6).
const fn triangle_count(mode: u32, indices: usize) -> usize {
    match mode {
        5 | 6 => indices.saturating_sub(2),
        _ => indices / 3,
    }
}

/// Which of the indices are the corners of a triangle.
const fn corners_of(mode: u32, triangle: usize) -> [usize; 3] {
    let t = triangle;
    match mode {
        5 if t.is_multiple_of(2) => [t, t + 1, t + 2],
        5 => [t + 1, t, t + 2],
        6 => [0, t + 1, t + 2],
        _ => [3 * t, 3 * t + 1, 3 * t + 2],
    }
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
