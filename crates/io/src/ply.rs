//! The Stanford polygon format (PLY), with a colour for each triangle.
//!
//! The numbers are the model's own in double precision; a comment names the
//! unit. Names and normals are lost.
//!
//! Many programs pass over colours of faces and read those of vertices. Blender does: its importer
//! reads `red`, `green`, `blue` and `alpha` of vertices, and nothing of faces but their corners
//! (`load_vertex_element` and `load_face_element` in its `source/blender/io/ply/importer`). For
//! these there are [`WriteOptions::vertex_colors`].

use std::io::Write;

use csg::{Color, LengthUnit, Merger, Mesh, MeshSurface, SlabSource};
use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::assemble::{Assembler, with_triangles};
use crate::parts::{DEFAULT_COLOR, Parts, byte, check_finite, in_gamut};
use crate::rows::write_rows;
use crate::{Error, MeshFormat, WriteOptions, units};

/// Writes a binary little-endian PLY file; where any triangle has a colour,
/// each gets one (sRGB and opacity, in bytes).
///
/// # Errors
/// An empty or invalid mesh; failed writing.
pub fn write_ply(mesh: &Mesh, out: &mut impl Write) -> Result<(), Error> {
    write_ply_with(mesh, &WriteOptions::default(), out)
}

/// [`write_ply`] with choices: with [`WriteOptions::vertex_colors`] vertices have colours, too, and
/// are there once for each colour around them. Where a mesh has no colours that makes no difference.
///
/// The vertices that are there again come last; an element `vertex_copy` says of each which it is,
/// so that [`read_ply`] gives the same mesh as without the choice.
///
/// # Errors
/// As [`write_ply`]; more vertices than 32 bits can number.
pub fn write_ply_with(
    mesh: &Mesh,
    options: &WriteOptions,
    out: &mut impl Write,
) -> Result<(), Error> {
    let parts = Parts::of(mesh, MeshFormat::Ply)?;
    let mut colors: Vec<[u8; 4]> = Vec::new();
    if parts.has_colors() {
        colors.resize(mesh.triangles.len(), [0; 4]);
        for part in parts.groups() {
            let color = parts.colors[part.color].unwrap_or(DEFAULT_COLOR);
            for &triangle in &part.triangles {
                colors[triangle as usize] = bytes_of(color);
            }
        }
    }
    if options.vertex_colors && !colors.is_empty() {
        return write_split(mesh, &colors, out);
    }
    let counts = (mesh.positions.len(), mesh.triangles.len());
    write_header(out, mesh.unit, counts, !colors.is_empty(), None)?;
    write_vertices(out, &mesh.positions)?;
    write_faces(out, &mesh.triangles, |row| colors.get(row).copied())
}

/// The element that says of the last vertices which others they are.
const COPIES: &str = "vertex_copy";

/// Writes a mesh with colours of its triangles and of vertices of its own for each colour.
fn write_split(mesh: &Mesh, colors: &[[u8; 4]], out: &mut impl Write) -> Result<(), Error> {
    let count = mesh.positions.len();
    let mut of_vertex: Vec<Option<[u8; 4]>> = vec![None; count];
    let mut copies: Vec<(u32, [u8; 4])> = Vec::new();
    let mut known: FxHashMap<(u32, [u8; 4]), u32> = FxHashMap::default();
    let mut triangles = mesh.triangles.clone();
    for (corners, &color) in triangles.iter_mut().zip(colors) {
        for vertex in corners {
            if *of_vertex[*vertex as usize].get_or_insert(color) != color {
                *vertex = *known.entry((*vertex, color)).or_insert_with(|| {
                    copies.push((*vertex, color));
                    (count + copies.len() - 1) as u32
                });
            }
        }
    }
    if u32::try_from(count + copies.len()).is_err() {
        return Err(Error::DoesNotFit {
            format: MeshFormat::Ply,
            problem: "with a vertex for each colour it has more than 2^32; write it without"
                .to_owned(),
        });
    }
    let counts = (count + copies.len(), triangles.len());
    write_header(out, mesh.unit, counts, true, Some(copies.len()))?;
    write_rows(out, counts.0, |row, bytes| {
        let (vertex, color) = match row.checked_sub(count) {
            Some(copy) => (copies[copy].0 as usize, copies[copy].1),
            None => (row, of_vertex[row].unwrap_or(bytes_of(DEFAULT_COLOR))),
        };
        for coordinate in mesh.positions[vertex].to_array() {
            bytes.extend_from_slice(&coordinate.to_le_bytes());
        }
        bytes.extend_from_slice(&color);
    })?;
    write_faces(out, &triangles, |row| Some(colors[row]))?;
    Ok(write_rows(out, copies.len(), |row, bytes| {
        bytes.extend_from_slice(&copies[row].0.to_le_bytes());
    })?)
}

/// Writes a mesh put together from slabs, piece by piece: the same file as [`write_ply`] writes
/// of the whole.
///
/// # Errors
/// An empty or invalid mesh; slabs that cannot be read; failed writing.
pub fn write_merged_ply(
    merger: &Merger<impl SlabSource>,
    out: &mut impl Write,
) -> Result<(), Error> {
    let counts = (merger.vertex_count(), merger.triangle_count());
    if counts.1 == 0 {
        return Err(Error::EmptyMesh);
    }
    write_header(out, merger.unit(), counts, merger.has_colors(), None)?;
    for piece in 0..merger.pieces() {
        let positions = merger.positions(piece)?;
        check_finite(&positions)?;
        write_vertices(out, &positions)?;
    }
    for piece in 0..merger.pieces() {
        let made = merger.triangles(piece, false)?;
        let color = |entry: &MeshSurface| bytes_of(entry.color.map_or(DEFAULT_COLOR, in_gamut));
        let colors: Vec<[u8; 4]> = made.table.iter().map(color).collect();
        write_faces(out, &made.triangles, |row| {
            let is_told = merger.has_colors();
            is_told.then(|| colors[made.surfaces[row] as usize])
        })?;
    }
    Ok(())
}

/// With `copies` vertices have colours as triangles have, and so many of them are copies.
fn write_header(
    out: &mut impl Write,
    unit: LengthUnit,
    (vertices, triangles): (usize, usize),
    has_colors: bool,
    copies: Option<usize>,
) -> Result<(), Error> {
    let colors =
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment stereotomy: unit {}, Z up\n\
         element vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n{}\
         element face {triangles}\nproperty list uchar uint vertex_indices\n{}",
        units::name(unit),
        if copies.is_some() { colors } else { "" },
        if has_colors { colors } else { "" },
    )?;
    if let Some(copies) = copies {
        writeln!(out, "element {COPIES} {copies}\nproperty uint of")?;
    }
    Ok(writeln!(out, "end_header")?)
}

fn write_vertices(out: &mut impl Write, positions: &[DVec3]) -> Result<(), Error> {
    write_rows(out, positions.len(), |row, bytes| {
        for coordinate in positions[row].to_array() {
            bytes.extend_from_slice(&coordinate.to_le_bytes());
        }
    })?;
    Ok(())
}

fn write_faces(
    out: &mut impl Write,
    triangles: &[[u32; 3]],
    color: impl Fn(usize) -> Option<[u8; 4]> + Sync,
) -> Result<(), Error> {
    write_rows(out, triangles.len(), |row, bytes| {
        bytes.push(3);
        for vertex in triangles[row] {
            bytes.extend_from_slice(&vertex.to_le_bytes());
        }
        bytes.extend(color(row).into_iter().flatten());
    })?;
    Ok(())
}

/// A colour as files have it.
fn bytes_of(color: Color) -> [u8; 4] {
    let [r, g, b] = color.to_srgb().map(byte);
    [r, g, b, byte(color.alpha)]
}

/// Reads a PLY file, text or binary of either byte order.
///
/// Polygons are cut into triangles from their first corner; colours of faces
/// (not of vertices) are kept. Vertices that [`write_ply_with`] wrote again are one. The unit is
/// taken to be the millimetre.
///
/// # Errors
/// A damaged header, data that ends too early, indices out of range, no faces.
pub fn read_ply(data: &[u8]) -> Result<Mesh, Error> {
    let header = Header::parse(data)?;
    let mut values = Values {
        encoding: header.encoding,
        data,
        at: header.end,
    };
    let mut mesh = Assembler::new(LengthUnit::Millimetre);
    // Faces may come before the vertices they name.
    let mut faces: Vec<(Vec<f64>, Option<Color>)> = Vec::new();
    // What the last vertices are copies of.
    let mut copies: Vec<f64> = Vec::new();
    for element in &header.elements {
        let column = |name: &str| element.properties.iter().position(|p| p.name == name);
        let place = [column("x"), column("y"), column("z")];
        let indices = column("vertex_indices").or(column("vertex_index"));
        let color = ["red", "green", "blue", "alpha"].map(column);
        // Rows without properties take no bytes: a count could be anything.
        let count = if element.properties.is_empty() {
            0
        } else {
            element.count
        };
        let mut row: Vec<f64> = Vec::new();
        let mut list: Vec<f64> = Vec::new();
        for index in 0..count {
            let wrong = |problem: &str| malformed(format!("{} {index}", element.name), problem);
            let cut_off = || wrong("the data ends here; the file may have been cut off");
            row.clear();
            for (number, property) in element.properties.iter().enumerate() {
                let Some(length) = property.list_length else {
                    row.push(values.next(property.kind).ok_or_else(cut_off)?);
                    continue;
                };
                let length = values.next(length).ok_or_else(cut_off)?;
                let wanted = Some(number) == indices;
                if wanted {
                    list.clear();
                }
                for _ in 0..length as usize {
                    let value = values.next(property.kind).ok_or_else(cut_off)?;
                    if wanted {
                        list.push(value);
                    }
                }
                row.push(f64::NAN);
            }
            if element.name == "vertex" {
                let [Some(x), Some(y), Some(z)] = place else {
                    return Err(wrong("vertices need the properties x, y and z"));
                };
                let vertex = mesh.vertex(DVec3::new(row[x], row[y], row[z]));
                vertex.ok_or_else(|| wrong("its coordinates are not finite"))?;
            } else if element.name == "face" && indices.is_some() {
                let component = |column: Option<usize>| {
                    let column = column?;
                    let full = element.properties[column].kind.full_scale();
                    Some((row[column] / full) as f32)
                };
                let [r, g, b, a] = color.map(component);
                let color = r
                    .zip(g)
                    .zip(b)
                    .map(|((r, g), b)| Color::from_srgb([r, g, b]).with_alpha(a.unwrap_or(1.0)));
                faces.push((list.clone(), color));
            } else if element.name == COPIES
                && let Some(of) = column("of")
            {
                copies.push(row[of]);
            }
        }
    }
    let count = mesh.vertex_count();
    let first_copy = first_copy(count, &copies)?;
    mesh.keep_vertices(first_copy);
    let vertex = |corner: f64| match (corner as usize).checked_sub(first_copy) {
        Some(copy) => copies[copy] as u32,
        None => corner as u32,
    };
    for (number, (corners, color)) in faces.iter().enumerate() {
        mesh.begin_part(&[], *color);
        // (Negative and fractional numbers fail the test as well.)
        if let Some(bad) = corners
            .iter()
            .find(|&&c| !(c >= 0.0 && c < count as f64 && c == c.trunc()))
        {
            let problem = format!("it names vertex {bad}, but there are only {count}");
            return Err(malformed(format!("face {number}"), problem));
        }
        for pair in corners.windows(2).skip(1) {
            mesh.triangle([corners[0], pair[0], pair[1]].map(vertex), None);
        }
    }
    with_triangles(mesh.finish(), MeshFormat::Ply, data).map(|read| read.mesh)
}

/// How many vertices are no copies.
fn first_copy(count: usize, copies: &[f64]) -> Result<usize, Error> {
    let wrong = |number: usize, problem: &str| malformed(format!("{COPIES} {number}"), problem);
    let first = count.checked_sub(copies.len());
    let first = first.ok_or_else(|| wrong(count, "there are more of these than vertices"))?;
    // (Negative and fractional numbers fail the test as well.)
    let is_good = |of: &f64| *of >= 0.0 && *of < first as f64 && *of == of.trunc();
    match copies.iter().position(|of| !is_good(of)) {
        None => Ok(first),
        Some(number) => Err(wrong(number, "it names no vertex that is no copy")),
    }
}

fn malformed(place: impl Into<String>, problem: impl Into<String>) -> Error {
    Error::Malformed {
        format: MeshFormat::Ply,
        place: place.into(),
        problem: problem.into(),
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The scalar types, under their old and new names.
#[derive(Clone, Copy)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// What stands for a full colour component.
    const fn full_scale(self) -> f64 {
        match self {
            Self::F32 | Self::F64 => 1.0,
            Self::U16 | Self::I16 => 65535.0,
            _ => 255.0,
        }
    }
}

struct Property {
    name: String,
    kind: Kind,
    /// The type of a list's length.
    list_length: Option<Kind>,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// Where the data begins.
    end: usize,
}

impl Header {
    fn parse(data: &[u8]) -> Result<Self, Error> {
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut end = 0;
        for (index, line) in data.split_inclusive(|&b| b == b'\n').enumerate() {
            end += line.len();
            let line = String::from_utf8_lossy(line);
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let wrong = |problem: &str| malformed(format!("line {}", index + 1), problem);
            match words[..] {
                _ if index == 0 => {
                    if words != ["ply"] {
                        return Err(wrong("this is no PLY file: it must begin with \"ply\""));
                    }
                }
                ["format", name, _] => {
                    encoding = Some(match name {
                        "ascii" => Encoding::Text,
                        "binary_little_endian" => Encoding::LittleEndian,
                        "binary_big_endian" => Encoding::BigEndian,
                        _ => return Err(wrong("the format is unknown")),
                    });
                }
                ["element", name, count] => elements.push(Element {
                    name: name.to_owned(),
                    count: count.parse().map_err(|_| wrong("the count is no number"))?,
                    properties: Vec::new(),
                }),
                ["property", ref rest @ .., name] => {
                    let kind = |name: &str| Kind::named(name).ok_or_else(|| wrong("unknown type"));
                    let (kind, list_length) = match *rest {
                        [one] => (kind(one)?, None),
                        ["list", length, of] => (kind(of)?, Some(kind(length)?)),
                        _ => return Err(wrong("a property has a type and a name")),
                    };
                    let element = elements.last_mut();
                    let element = element.ok_or_else(|| wrong("it belongs to no element"))?;
                    element.properties.push(Property {
                        name: name.to_owned(),
                        kind,
                        list_length,
                    });
                }
                ["end_header"] => {
                    let encoding = encoding.ok_or_else(|| wrong("there was no format line"))?;
                    return Ok(Self {
                        encoding,
                        elements,
                        end,
                    });
                }
                ["comment" | "obj_info", ..] | [] => {}
                _ => return Err(wrong("this does not belong in a PLY header")),
            }
        }
        Err(malformed(
            "header",
            "\"end_header\" is missing; the file may have been cut off",
        ))
    }
}

/// The numbers after the header, one by one.
struct Values<'a> {
    encoding: Encoding,
    data: &'a [u8],
    at: usize,
}

impl Values<'_> {
    fn next(&mut self, kind: Kind) -> Option<f64> {
        if self.encoding == Encoding::Text {
            let rest = &self.data[self.at..];
            let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
            let rest = &rest[start..];
            let length = rest.iter().position(u8::is_ascii_whitespace);
            let length = length.unwrap_or(rest.len());
            self.at += start + length;
            return std::str::from_utf8(&rest[..length]).ok()?.parse().ok();
        }
        Some(match kind {
            Kind::I8 => f64::from(i8::from_le_bytes(self.bytes()?)),
            Kind::U8 => f64::from(u8::from_le_bytes(self.bytes()?)),
            Kind::I16 => f64::from(i16::from_le_bytes(self.bytes()?)),
            Kind::U16 => f64::from(u16::from_le_bytes(self.bytes()?)),
            Kind::I32 => f64::from(i32::from_le_bytes(self.bytes()?)),
            Kind::U32 => f64::from(u32::from_le_bytes(self.bytes()?)),
            Kind::F32 => f64::from(f32::from_le_bytes(self.bytes()?)),
            Kind::F64 => f64::from_le_bytes(self.bytes()?),
        })
    }

    /// The next bytes of a number, the least one first.
    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut bytes: [u8; N] = self.data.get(self.at..self.at + N)?.try_into().ok()?;
        self.at += N;
        if self.encoding == Encoding::BigEndian {
            bytes.reverse();
        }
        Some(bytes)
    }
}
