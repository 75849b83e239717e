//! The glTF reader: the triangles of the default scene, in the model's own
//! axes and unit. Animations, skins, textures and cameras are passed over.

use csg::{Color, LengthUnit, Mesh};
use glam::{DMat3, DMat4, DQuat, DVec3, DVec4, Vec3};
use serde::Deserialize;

use super::Z_UP_TO_Y_UP;
use crate::assemble::Assembler;
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
    let mut bin = bin.map(<[u8]>::to_vec);
    read(json, &mut |index, uri| match uri {
        None if index == 0 => bin.take().ok_or_else(|| {
            malformed(
                "buffer 0",
                "the file has no binary chunk; it may be cut off",
            )
        }),
        None => Err(malformed(
            format!("buffer {index}"),
            "it has neither URI nor chunk",
        )),
        Some(uri) => data_uri(uri, index)?.ok_or_else(|| {
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
            Some(data) => Ok(data),
            None => load(&percent_decoded(uri)),
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
type LoadBuffer<'a> = dyn FnMut(usize, Option<&str>) -> Result<Vec<u8>, Error> + 'a;

fn read(json: &[u8], load: &mut LoadBuffer<'_>) -> Result<Mesh, Error> {
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

struct Reader {
    document: Document,
    buffers: Vec<Vec<u8>>,
}

impl Reader {
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
        let mut assembler = Assembler::new(unit);
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
                    self.primitive(primitive, &place, transform, node, &mut assembler)?;
                }
            }
        }
        Ok(assembler.finish())
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

    fn primitive(
        &self,
        primitive: &Primitive,
        place: &str,
        transform: DMat4,
        node: &Node,
        assembler: &mut Assembler,
    ) -> Result<(), Error> {
        let mode = primitive.mode.unwrap_or(4);
        let Some(position) = primitive.attributes.position.filter(|_| mode >= 4) else {
            // Points, lines, and what has no place to be drawn at.
            return Ok(());
        };
        let positions = self.vectors(position, place)?;
        let normals = match primitive.attributes.normal {
            Some(normal) => self.vectors(normal, place)?,
            None => Vec::new(),
        };
        if !normals.is_empty() && normals.len() != positions.len() {
            return Err(malformed(place, "it has not as many normals as positions"));
        }
        let indices: Vec<u32> = match primitive.indices {
            Some(indices) => self.indices(indices, place)?,
            None => (0..positions.len() as u32).collect(),
        };
        if let Some(index) = indices.iter().find(|&&i| i as usize >= positions.len()) {
            let problem = format!("index {index} is beyond its {} positions", positions.len());
            return Err(malformed(place, problem));
        }
        let linear = DMat3::from_mat4(transform);
        let mirrored = linear.determinant() < 0.0;
        // Normals go with the cofactors, which need no inverse; their sign
        // under mirroring is undone.
        let cofactors = DMat3::from_cols(
            linear.y_axis.cross(linear.z_axis),
            linear.z_axis.cross(linear.x_axis),
            linear.x_axis.cross(linear.y_axis),
        );
        let sign = if mirrored { -1.0 } else { 1.0 };
        assembler.reserve(positions.len(), indices.len() / 3);
        let vertices = positions
            .iter()
            .map(|&p| assembler.weld(transform.transform_point3(p)))
            .collect::<Option<Vec<u32>>>()
            .ok_or_else(|| malformed(place, "a position is not finite, or there are too many"))?;
        let turned: Vec<Vec3> = normals
            .iter()
            .map(|&n| (cofactors * n * sign).normalize_or_zero().as_vec3())
            .collect();
        assembler.begin_part(node.name.as_deref(), self.color(primitive.material));
        for [a, b, c] in triangles(mode, &indices) {
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            let corners = corners.map(|index| index as usize);
            let normals = (!turned.is_empty()).then(|| corners.map(|corner| turned[corner]));
            assembler.triangle(corners.map(|corner| vertices[corner]), normals);
        }
        Ok(())
    }

    fn color(&self, material: Option<usize>) -> Option<Color> {
        let material = self.document.materials.get(material?)?;
        if material.name.as_deref() == Some(crate::parts::DEFAULT_MATERIAL) {
            return None;
        }
        let [r, g, b, alpha] = material.pbr_metallic_roughness.base_color_factor?;
        Some(Color::from_linear([r, g, b]).with_alpha(alpha))
    }

    fn vectors(&self, accessor: usize, place: &str) -> Result<Vec<DVec3>, Error> {
        let (entry, elements) = self.elements(accessor, "VEC3", 3, place)?;
        let component = component_reader(entry, place)?;
        let size = component_size(entry.component_type);
        Ok(elements
            .map(|bytes| DVec3::from_array([0, 1, 2].map(|i| component(&bytes[i * size..]))))
            .collect())
    }

    fn indices(&self, accessor: usize, place: &str) -> Result<Vec<u32>, Error> {
        let (entry, elements) = self.elements(accessor, "SCALAR", 1, place)?;
        Ok(match entry.component_type {
            5121 => elements.map(|b| u32::from(b[0])).collect(),
            5123 => elements
                .map(|b| u32::from(u16::from_le_bytes([b[0], b[1]])))
                .collect(),
            5125 => elements
                .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
                .collect(),
            _ => return Err(malformed(place, "its indices are no unsigned integers")),
        })
    }

    /// The bytes of each element of an accessor, all of them in range.
    fn elements(
        &self,
        accessor: usize,
        kind: &str,
        components: usize,
        place: &str,
    ) -> Result<(&Accessor, impl Iterator<Item = &[u8]>), Error> {
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
        Ok((entry, bytes.chunks(stride).map(move |chunk| &chunk[..size])))
    }
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

/// Bytes of a component type, 0 for an unknown one.
fn component_size(component_type: u32) -> usize {
    match component_type {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        5125 | 5126 => 4,
        _ => 0,
    }
}

/// Reads a component of an accessor of floats (or of the integers that
/// KHR_mesh_quantization allows in their place).
fn component_reader(entry: &Accessor, place: &str) -> Result<fn(&[u8]) -> f64, Error> {
    Ok(match (entry.component_type, entry.normalized) {
        (5126, _) => |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
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

/// The triangles of a list, a strip (5) or a fan (6).
fn triangles(mode: u32, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        5 => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| {
                if i % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[1], w[0], w[2]]
                }
            })
            .collect(),
        6 => indices
            .windows(2)
            .skip(1)
            .map(|w| [indices[0], w[0], w[1]])
            .collect(),
        _ => indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
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
