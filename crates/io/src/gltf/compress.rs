//! Compression: positions of 16 bits, normals of 8 (`KHR_mesh_quantization`), and both and indices
//! coded (`EXT_meshopt_compression`).

use std::io::Write;

use csg::Mesh;
use glam::{DVec3, Vec3, Vec4};
use serde_json::{Value, json};

use super::document::Document;
use super::instances;
use super::read::{CUT_OFF, malformed};
use super::write::{Geometry, write_chunks};
use crate::contents::Contents;
use crate::{Error, MeshFormat};

const EXTENSION: &str = "EXT_meshopt_compression";

/// The steps in which positions are told across the longest side.
const STEPS: f64 = 65_535.0;

/// Writes a binary glTF file (GLB) as small as can be: positions are rounded to a 65,535th of the
/// longest side, normals to a 127th, and all is coded as `EXT_meshopt_compression` says, which
/// readers must know. For the rest, see [`super::write_glb`].
///
/// Of a mesh with details finer than that, vertices may come to the same place.
///
/// # Errors
/// As [`super::write_glb`].
pub fn write_glb_compressed(mesh: &Mesh, out: &mut impl Write) -> Result<(), Error> {
    write(Geometry::of(mesh, MeshFormat::Glb, false)?, mesh, out)
}

/// Writes what was gathered of a mesh.
pub(super) fn write(
    mut geometry: Geometry<'_>,
    mesh: &Mesh,
    out: &mut impl Write,
) -> Result<(), Error> {
    for stretch in &geometry.primitives {
        // In the order in which they are used they take the least.
        let vertices = stretch.vertices.clone();
        let indices = &mut geometry.indices[stretch.indices.clone()];
        meshopt::optimize_vertex_cache_in_place(indices, vertices.len());
        let order = meshopt::optimize_vertex_fetch_remap(indices, vertices.len());
        for index in indices {
            *index = order[*index as usize];
        }
        reorder(&mut geometry.positions[vertices.clone()], &order);
        if !geometry.normals.is_empty() {
            reorder(&mut geometry.normals[vertices], &order);
        }
    }
    let grid = Grid::of(&geometry.positions);
    let fails = |error: meshopt::Error| Error::DoesNotFit {
        format: MeshFormat::Glb,
        problem: format!("it cannot be coded ({error}); write it without compression"),
    };
    let mut streams = vec![Stream::attributes(&geometry.positions, |place| {
        let [x, y, z] = grid
            .place(place.as_dvec3())
            .map(|step| (step as u16).to_le_bytes());
        [x[0], x[1], y[0], y[1], z[0], z[1], 0, 0]
    })];
    if !geometry.normals.is_empty() {
        streams.push(Stream::attributes(&geometry.normals, |normal| {
            let [x, y, z] = normal.to_array().map(|x| (127.0 * x).round() as i8 as u8);
            [x, y, z, 0]
        }));
    }
    for (narrow, stride) in [(false, 4), (true, 2)] {
        let same = geometry
            .primitives
            .iter()
            .filter(|s| s.is_narrow() == narrow);
        let indices: Vec<u32> = same
            .flat_map(|stretch| &geometry.indices[stretch.indices.clone()])
            .copied()
            .collect();
        if !indices.is_empty() {
            let vertices = indices.iter().max().map_or(0, |&last| last as usize + 1);
            streams.push(Stream {
                count: indices.len(),
                stride,
                mode: "TRIANGLES",
                code: meshopt::encode_index_buffer(&indices, vertices),
            });
        }
    }
    // Places of instances are told in the grid's steps, from its corner: those are their nodes' now.
    let translations: Vec<Vec3> = instances::translations(&geometry.instances)
        .map(|place| ((place.apply(grid.low) - grid.low) / grid.step).as_vec3())
        .collect();
    let rotations: Vec<Vec4> = instances::rotations(&geometry.instances)
        .map(|place| Vec4::from_array(place.rotation))
        .collect();
    if !translations.is_empty() {
        streams.push(Stream::attributes::<_, 12>(&translations, |place| {
            bytes(place.to_array())
        }));
    }
    if !rotations.is_empty() {
        streams.push(Stream::attributes::<_, 16>(&rotations, |turn| {
            bytes(turn.to_array())
        }));
    }
    let mut document = geometry.document(mesh, None)?;
    let (mut coded, mut plain) = (Vec::new(), 0);
    for (view, stream) in streams.into_iter().enumerate() {
        let code = stream.code.map_err(fails)?;
        let entry = &mut document["bufferViews"][view];
        let length = stream.count * stream.stride;
        entry["buffer"] = json!(1);
        entry["byteOffset"] = json!(plain);
        entry["byteLength"] = json!(length);
        if entry["byteStride"].is_number() {
            entry["byteStride"] = json!(stream.stride);
        }
        entry["extensions"] = json!({ EXTENSION: {
            "buffer": 0,
            "byteOffset": coded.len(),
            "byteLength": code.len(),
            "byteStride": stream.stride,
            "count": stream.count,
            "mode": stream.mode,
        }});
        plain += length.next_multiple_of(4);
        coded.extend(code);
        coded.resize(coded.len().next_multiple_of(4), 0);
    }
    document["buffers"] = json!([
        { "byteLength": coded.len() },
        { "byteLength": plain, "extensions": { EXTENSION: { "fallback": true } } },
    ]);
    grid.tell(
        &mut document,
        geometry.translation,
        !geometry.normals.is_empty(),
    );
    let mut extensions = vec![EXTENSION, "KHR_mesh_quantization"];
    if !geometry.instances.is_empty() {
        extensions.push(instances::EXTENSION);
    }
    let extensions = json!(extensions);
    document["extensionsUsed"] = extensions.clone();
    document["extensionsRequired"] = extensions;
    let json = serde_json::to_vec(&document).map_err(std::io::Error::from)?;
    write_chunks(json, coded.len(), out)?;
    Ok(out.write_all(&coded)?)
}

/// Puts what is at each place where `order` says.
fn reorder(all: &mut [Vec3], order: &[u32]) {
    let before = all.to_vec();
    for (value, &to) in before.into_iter().zip(order) {
        all[to as usize] = value;
    }
}

/// A buffer view.
struct Stream {
    count: usize,
    stride: usize,
    mode: &'static str,
    code: Result<Vec<u8>, meshopt::Error>,
}

impl Stream {
    fn attributes<T, const N: usize>(all: &[T], bytes: impl Fn(&T) -> [u8; N]) -> Self {
        let vertices: Vec<[u8; N]> = all.iter().map(bytes).collect();
        Self {
            count: vertices.len(),
            stride: N,
            mode: "ATTRIBUTES",
            // (The extension has the first version of the code.)
            code: meshopt::encode_vertex_buffer_level(&vertices, 2, Some(0)),
        }
    }
}

/// Little-endian.
fn bytes<const N: usize, const BYTES: usize>(numbers: [f32; N]) -> [u8; BYTES] {
    let all = numbers.map(f32::to_le_bytes);
    let all = all.as_flattened();
    std::array::from_fn(|index| all[index])
}

/// Where positions are rounded to.
struct Grid {
    low: DVec3,
    step: f64,
}

impl Grid {
    fn of(places: &[Vec3]) -> Self {
        let low = places.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let high = places.iter().copied().reduce(Vec3::max).unwrap_or_default();
        let size = (high.as_dvec3() - low.as_dvec3()).max_element();
        Self {
            low: low.as_dvec3(),
            step: if size > 0.0 { size / STEPS } else { 1.0 },
        }
    }

    fn place(&self, place: DVec3) -> [f64; 3] {
        let steps = (place - self.low) / self.step;
        steps.to_array().map(|step| step.round().clamp(0.0, STEPS))
    }

    /// Says in a document what its accessors hold now, and where that lies.
    fn tell(&self, document: &mut Value, translation: DVec3, with_normals: bool) {
        let scene = &document["scenes"][0]["nodes"][0];
        let model = scene.as_u64().unwrap_or_default() as usize;
        let nodes = document["nodes"][model]["children"].clone();
        for node in nodes
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_u64)
        {
            let node = &mut document["nodes"][node as usize];
            node["translation"] = json!((translation + self.low).to_array());
            node["scale"] = json!(DVec3::splat(self.step).to_array());
        }
        for accessor in document["accessors"].as_array_mut().into_iter().flatten() {
            let view = accessor["bufferView"].as_u64();
            let first = accessor["byteOffset"].as_u64().unwrap_or_default() / 12;
            if view == Some(0) {
                accessor["componentType"] = json!(5123);
                accessor["byteOffset"] = json!(8 * first);
                for bound in ["min", "max"] {
                    let at = |k: usize| accessor[bound][k].as_f64().unwrap_or_default();
                    let place = DVec3::new(at(0), at(1), at(2));
                    accessor[bound] = json!(self.place(place).map(|step| step as u16));
                }
            } else if view == Some(1) && with_normals {
                accessor["componentType"] = json!(5120);
                accessor["normalized"] = json!(true);
                accessor["byteOffset"] = json!(4 * first);
            }
        }
    }
}

/// What is decoded takes no more than so many times its code.
const MOST_EXPANDED: usize = 256;

/// Decodes the views that are coded, each into a buffer of its own.
pub(super) fn decode(
    document: &mut Document,
    buffers: &mut Vec<Contents<'_>>,
) -> Result<(), Error> {
    for (index, view) in document.buffer_views.iter_mut().enumerate() {
        let Some(coded) = view.extensions.meshopt.take() else {
            continue;
        };
        let wrong = |problem: &str| malformed(format!("buffer view {index}"), problem);
        let end = coded.byte_offset.checked_add(coded.byte_length);
        let code = end.and_then(|end| buffers.get(coded.buffer)?.get(coded.byte_offset..end));
        let code = code.ok_or_else(|| wrong(CUT_OFF))?;
        let length = coded.count.checked_mul(coded.byte_stride);
        if length.is_none_or(|length| length / MOST_EXPANDED > code.len()) {
            return Err(wrong("it would take far more than its code can say"));
        }
        let bytes = match (
            coded.mode.as_str(),
            coded.filter.as_deref().unwrap_or("NONE"),
        ) {
            ("ATTRIBUTES", "NONE") => attributes(code, coded.count, coded.byte_stride),
            ("ATTRIBUTES", "OCTAHEDRAL") => directions(code, coded.count, coded.byte_stride),
            ("TRIANGLES", "NONE") => indices(coded.byte_stride, coded.count % 3 == 0, |wide| {
                if wide {
                    meshopt::decode_index_buffer::<u32>(code, coded.count).map(bytes_of)
                } else {
                    meshopt::decode_index_buffer::<u16>(code, coded.count).map(bytes_of)
                }
            }),
            ("INDICES", "NONE") => indices(coded.byte_stride, true, |wide| {
                if wide {
                    meshopt::decode_index_sequence::<u32>(code, coded.count).map(bytes_of)
                } else {
                    meshopt::decode_index_sequence::<u16>(code, coded.count).map(bytes_of)
                }
            }),
            _ => None,
        };
        let problem = "its code is damaged, or of a kind that is not known here";
        let bytes = bytes.ok_or_else(|| wrong(problem))?;
        view.buffer = buffers.len();
        (view.byte_offset, view.byte_length) = (0, bytes.len());
        buffers.push(Contents::Read(bytes));
    }
    Ok(())
}

fn attributes(code: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    fn of<const N: usize>(code: &[u8], count: usize) -> Option<Vec<u8>>
    where
        [u8; N]: Clone + Default,
    {
        let decoded = meshopt::decode_vertex_buffer::<[u8; N]>(code, count);
        Some(decoded.ok()?.into_flattened())
    }
    match stride {
        4 => of::<4>(code, count),
        8 => of::<8>(code, count),
        12 => of::<12>(code, count),
        16 => of::<16>(code, count),
        20 => of::<20>(code, count),
        24 => of::<24>(code, count),
        28 => of::<28>(code, count),
        32 => of::<32>(code, count),
        _ => None,
    }
}

/// Directions coded as places on an octahedron.
fn directions(code: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    match stride {
        4 => {
            let mut all = meshopt::decode_vertex_buffer::<[i8; 4]>(code, count).ok()?;
            meshopt::decode_filter_oct(&mut all);
            Some(bytes_of(all))
        }
        8 => {
            let mut all = meshopt::decode_vertex_buffer::<[i16; 4]>(code, count).ok()?;
            meshopt::decode_filter_oct(&mut all);
            Some(bytes_of(all))
        }
        _ => None,
    }
}

fn indices(
    stride: usize,
    is_whole: bool,
    decode: impl Fn(bool) -> Result<Vec<u8>, meshopt::Error>,
) -> Option<Vec<u8>> {
    if !is_whole || !matches!(stride, 2 | 4) {
        return None;
    }
    decode(stride == 4).ok()
}

/// As little-endian machines hold them, which is as files do.
fn bytes_of<T: bytemuck::NoUninit>(all: impl AsRef<[T]>) -> Vec<u8> {
    bytemuck::cast_slice(all.as_ref()).to_vec()
}
