//! Meshes put together from slabs as GLB in chunks: no more of them is in memory at a time than
//! a slab and a chunk.
//!
//! glTF's JSON, which tells how long everything is, stands before the data, so the data goes to
//! a file beside first.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::ops::Range;

use csg::{Color, Merger, MeshSurface, SlabSource};
use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;
use serde_json::{Value, json};

use super::Z_UP_TO_Y_UP;
use super::write::{rounded_centre, write_chunks};
use crate::parts::{DEFAULT_COLOR, check_finite, in_gamut};
use crate::{Error, MeshFormat, units};

/// Triangles of a merged mesh that are one mesh of a GLB file.
pub const CHUNK: usize = 1 << 20;
/// Chunks in one file: some 1.3 GB, which programs with 2 GB for a buffer can load.
pub const CHUNKS_PER_FILE: usize = 64;

/// The files of a mesh put together from slabs, in chunks of so many triangles in their order:
/// each chunk a node with a mesh of its own, its faces of one colour a primitive.
///
/// The nodes have one translation, so that chunks fit together, and files do. Names and normals
/// are left out: viewers shade such meshes flat, whose triangles are small. The same bytes come
/// of any number of slabs.
pub(crate) struct MergedGlb<'a, S> {
    merger: &'a Merger<S>,
    chunk: usize,
    translation: DVec3,
}

/// What is written of a file: its data, and what there is to be told of it.
struct Data {
    out: BufWriter<File>,
    length: usize,
    chunks: Vec<Vec<Stretch>>,
}

/// Faces of one colour.
struct Stretch {
    color: Option<Color>,
    /// Bytes.
    positions: Range<usize>,
    indices: Range<usize>,
    is_narrow: bool,
    low: Vec3,
    high: Vec3,
}

/// Triangles of a chunk, by the numbers of their corners in the whole, with these corners.
#[derive(Default)]
struct Chunk {
    /// Colours as bits, in the order in which they come first.
    places: FxHashMap<Option<[u32; 4]>, usize>,
    groups: Vec<Group>,
    count: usize,
}

#[derive(Default)]
struct Group {
    color: Option<Color>,
    slots: FxHashMap<u32, u32>,
    positions: Vec<Vec3>,
    indices: Vec<u32>,
}

impl<'a, S: SlabSource> MergedGlb<'a, S> {
    pub(crate) fn new(merger: &'a Merger<S>, chunk: usize) -> Self {
        let bounds = merger.report().bounds;
        let translation = bounds.map_or(DVec3::ZERO, |b| rounded_centre((b.min, b.max)));
        Self {
            merger,
            chunk,
            translation,
        }
    }

    /// How many files there are, of so many chunks each.
    pub(crate) fn files(&self, chunks: usize) -> usize {
        self.merger
            .triangle_count()
            .div_ceil(self.chunk)
            .div_ceil(chunks)
    }

    /// Writes the files one after another, each of so many chunks; `data` makes a file for what
    /// is written on the way.
    pub(crate) fn write(
        &self,
        chunks: usize,
        outs: &mut [impl Write],
        mut data: impl FnMut() -> Result<File, Error>,
    ) -> Result<(), Error> {
        if self.merger.triangle_count() == 0 {
            return Err(Error::EmptyMesh);
        }
        let mut outs = outs.iter_mut();
        let mut file = Data::new(data()?);
        let mut chunk = Chunk::default();
        let mut left = self.merger.triangle_count();
        for piece in 0..self.merger.pieces() {
            let made = self.merger.triangles(piece, true)?;
            check_finite(made.corners.as_flattened())?;
            let color = |entry: &MeshSurface| entry.color.map(in_gamut);
            let colors: Vec<Option<Color>> = made.table.iter().map(color).collect();
            for ((numbers, corners), &entry) in
                made.triangles.iter().zip(&made.corners).zip(&made.surfaces)
            {
                let corners = corners.map(|p| (p - self.translation).as_vec3());
                chunk.add(colors[entry as usize], *numbers, corners);
                left -= 1;
                if chunk.count < self.chunk && left > 0 {
                    continue;
                }
                file.push(std::mem::take(&mut chunk))?;
                if file.chunks.len() == chunks || left == 0 {
                    let next = match left {
                        0 => None,
                        _ => Some(Data::new(data()?)),
                    };
                    let finished = match next {
                        Some(next) => std::mem::replace(&mut file, next),
                        None => return self.finish(file, outs.next()),
                    };
                    self.finish(finished, outs.next())?;
                }
            }
        }
        Ok(())
    }

    fn finish(&self, mut data: Data, out: Option<&mut impl Write>) -> Result<(), Error> {
        let Some(out) = out else { return Ok(()) };
        data.out.flush()?;
        let json = serde_json::to_vec(&self.document(&data)).map_err(std::io::Error::from)?;
        write_chunks(json, data.length, out)?;
        let mut file = data
            .out
            .into_inner()
            .map_err(std::io::IntoInnerError::into_error)?;
        file.seek(SeekFrom::Start(0))?;
        std::io::copy(&mut file, out)?;
        Ok(())
    }

    fn document(&self, data: &Data) -> Value {
        let unit = self.merger.unit();
        let metres = unit.in_metres();
        let (mut views, mut accessors) = (Vec::new(), Vec::new());
        let (mut materials, mut known) = (Vec::new(), BTreeMap::new());
        let mut meshes = Vec::new();
        for chunk in &data.chunks {
            let primitives = chunk.iter().map(|stretch| {
                let next = materials.len();
                let material = *known.entry(bits(stretch.color)).or_insert_with(|| {
                    materials.push(material(stretch.color));
                    next
                });
                for (bytes, target) in [(&stretch.positions, 34962), (&stretch.indices, 34963)] {
                    views.push(json!({
                        "buffer": 0, "byteOffset": bytes.start, "byteLength": bytes.len(),
                        "target": target,
                    }));
                }
                let view = views.len() - 2;
                let (component, size) = if stretch.is_narrow {
                    (5123, 2)
                } else {
                    (5125, 4)
                };
                accessors.push(json!({
                    "bufferView": view, "componentType": 5126, "type": "VEC3",
                    "count": stretch.positions.len() / 12,
                    "min": stretch.low.to_array(), "max": stretch.high.to_array(),
                }));
                accessors.push(json!({
                    "bufferView": view + 1, "componentType": component, "type": "SCALAR",
                    "count": stretch.indices.len() / size,
                }));
                json!({
                    "attributes": { "POSITION": accessors.len() - 2 },
                    "indices": accessors.len() - 1,
                    "material": material,
                })
            });
            let primitives: Vec<Value> = primitives.collect();
            meshes.push(json!({ "primitives": primitives }));
        }
        let mut nodes: Vec<Value> = (0..meshes.len())
            .map(|mesh| json!({ "mesh": mesh, "translation": self.translation.to_array() }))
            .collect();
        let children: Vec<usize> = (0..nodes.len()).collect();
        let [x, y, z] = Z_UP_TO_Y_UP.map(|column| column.map(|entry| entry * metres));
        nodes.push(json!({
            "name": "model",
            "children": children,
            "matrix": [
                x[0], x[1], x[2], 0.0, y[0], y[1], y[2], 0.0,
                z[0], z[1], z[2], 0.0, 0.0, 0.0, 0.0, 1.0,
            ],
        }));
        json!({
            "asset": {
                "version": "2.0",
                "generator": concat!("stereotomy ", env!("CARGO_PKG_VERSION")),
                "extras": {
                    "unit": units::name(unit), "unitInMetres": metres, "modelUpAxis": "Z",
                },
            },
            "scene": 0,
            "scenes": [{ "nodes": [nodes.len() - 1] }],
            "nodes": nodes,
            "meshes": meshes,
            "materials": materials,
            "accessors": accessors,
            "bufferViews": views,
            "buffers": [{ "byteLength": data.length }],
        })
    }
}

fn bits(color: Option<Color>) -> Option<[u32; 4]> {
    color.map(
        |Color {
             rgb: [r, g, b],
             alpha,
         }| [r, g, b, alpha].map(f32::to_bits),
    )
}

fn material(color: Option<Color>) -> Value {
    let Color {
        rgb: [r, g, b],
        alpha,
    } = color.unwrap_or(DEFAULT_COLOR);
    json!({
        "alphaMode": if alpha < 1.0 { "BLEND" } else { "OPAQUE" },
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, alpha], "metallicFactor": 0.0, "roughnessFactor": 0.5,
        },
    })
}

impl Chunk {
    fn add(&mut self, color: Option<Color>, numbers: [u32; 3], corners: [Vec3; 3]) {
        let next = self.groups.len();
        let place = *self.places.entry(bits(color)).or_insert(next);
        if place == next {
            self.groups.push(Group {
                color,
                ..Group::default()
            });
        }
        let group = &mut self.groups[place];
        for (number, corner) in numbers.into_iter().zip(corners) {
            let slot = *group.slots.entry(number).or_insert_with(|| {
                group.positions.push(corner);
                group.positions.len() as u32 - 1
            });
            group.indices.push(slot);
        }
        self.count += 1;
    }
}

impl Data {
    fn new(file: File) -> Self {
        Self {
            out: BufWriter::with_capacity(1 << 20, file),
            length: 0,
            chunks: Vec::new(),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.out.write_all(bytes)?;
        self.length += bytes.len();
        Ok(())
    }

    /// Positions and indices of each colour, little-endian; what begins does so at a multiple
    /// of 4.
    fn push(&mut self, chunk: Chunk) -> Result<(), Error> {
        let mut stretches = Vec::new();
        for group in chunk.groups {
            if !group.positions.iter().all(|p| p.is_finite()) {
                return Err(Error::DoesNotFit {
                    format: MeshFormat::Glb,
                    problem: "its coordinates exceed single precision; scale the model down"
                        .to_owned(),
                });
            }
            let mut bytes = Vec::with_capacity(12 * group.positions.len());
            for coordinate in group.positions.iter().flat_map(Vec3::to_array) {
                bytes.extend_from_slice(&coordinate.to_le_bytes());
            }
            let start = self.length;
            self.write(&bytes)?;
            let middle = self.length;
            let is_narrow = group.positions.len() <= usize::from(u16::MAX);
            bytes.clear();
            for index in group.indices {
                bytes.extend_from_slice(&index.to_le_bytes()[..if is_narrow { 2 } else { 4 }]);
            }
            let end = middle + bytes.len();
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            self.write(&bytes)?;
            let positions = group.positions.iter();
            stretches.push(Stretch {
                color: group.color,
                positions: start..middle,
                indices: middle..end,
                is_narrow,
                low: positions.clone().fold(Vec3::INFINITY, |low, &p| low.min(p)),
                high: positions.fold(Vec3::NEG_INFINITY, |high, &p| high.max(p)),
            });
        }
        self.chunks.push(stretches);
        Ok(())
    }
}
