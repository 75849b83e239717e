//! STL, binary and text: triangles and nothing else. Names, colours and the
//! unit are lost; the numbers are the model's own.

use std::io::Write;

use csg::{LengthUnit, Merger, Mesh, SlabSource};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::assemble::{drop_vanished, with_triangles};
use crate::parts::{Parts, check_finite, face_normal};
use crate::rows::{push_f32, push_f64, write_rows};
use crate::weld::{self, weld};
use crate::{Error, MeshFormat, units};

/// Bytes before the first triangle of a binary file, and of each triangle.
const HEAD: usize = 84;
const RECORD: usize = 50;

/// Writes a binary STL file: 50 bytes a triangle, coordinates in single
/// precision about the origin (7 digits: move a small part that is far away,
/// or write text).
///
/// # Errors
/// An empty or invalid mesh, or one beyond single precision; failed writing.
pub fn write_stl(mesh: &Mesh, out: &mut impl Write) -> Result<(), Error> {
    Parts::of(mesh, MeshFormat::Stl)?;
    check_single(&mesh.positions)?;
    write_head(out, mesh.unit, mesh.triangles.len())?;
    write_records(out, mesh.triangles.len(), |row| mesh.corners(row))
}

/// Writes a mesh put together from slabs, piece by piece: the same file as [`write_stl`] writes
/// of the whole.
///
/// # Errors
/// An empty or invalid mesh, or one beyond single precision; slabs that cannot be read; failed
/// writing.
pub fn write_merged_stl(
    merger: &Merger<impl SlabSource>,
    out: &mut impl Write,
) -> Result<(), Error> {
    if merger.triangle_count() == 0 {
        return Err(Error::EmptyMesh);
    }
    write_head(out, merger.unit(), merger.triangle_count())?;
    for piece in 0..merger.pieces() {
        let corners = merger.triangles(piece, true)?.corners;
        check_finite(corners.as_flattened())?;
        check_single(corners.as_flattened())?;
        write_records(out, corners.len(), |row| corners[row])?;
    }
    Ok(())
}

/// The distance of the numbers in single precision that a mesh's coordinates are rounded to in
/// a binary file, at most: no vertex is moved by more than half of it along each axis.
#[must_use]
pub fn step_of_binary(mesh: &Mesh) -> f64 {
    let farthest = mesh
        .positions
        .iter()
        .fold(0.0, |most: f64, p| most.max(p.abs().max_element()));
    f64::from((farthest as f32).next_up()) - f64::from(farthest as f32)
}

/// The mesh with its coordinates rounded as in a binary file.
#[must_use]
pub fn as_in_binary(mesh: &Mesh) -> Mesh {
    let rounded = mesh.positions.iter().map(|p| p.as_vec3().as_dvec3());
    Mesh::new(rounded.collect(), mesh.triangles.clone())
}

/// Refuses what single precision cannot hold.
fn check_single(positions: &[DVec3]) -> Result<(), Error> {
    if positions.par_iter().all(|p| p.as_vec3().is_finite()) {
        return Ok(());
    }
    Err(Error::DoesNotFit {
        format: MeshFormat::Stl,
        problem: "its coordinates exceed single precision; write text, or scale it down".to_owned(),
    })
}

fn write_head(out: &mut impl Write, unit: LengthUnit, triangles: usize) -> Result<(), Error> {
    // (A binary header must not begin with "solid".)
    let mut head = format!("stereotomy: unit {}, Z up", units::name(unit)).into_bytes();
    head.resize(80, b' ');
    head.extend_from_slice(&(triangles as u32).to_le_bytes());
    out.write_all(&head)?;
    Ok(())
}

fn write_records(
    out: &mut impl Write,
    count: usize,
    corners: impl Fn(usize) -> [DVec3; 3] + Sync,
) -> Result<(), Error> {
    write_rows(out, count, |row, bytes| {
        let corners = corners(row);
        let normal = face_normal(corners).as_vec3();
        for vector in std::iter::once(normal).chain(corners.map(DVec3::as_vec3)) {
            for coordinate in vector.to_array() {
                bytes.extend_from_slice(&coordinate.to_le_bytes());
            }
        }
        bytes.extend_from_slice(&[0, 0]);
    })?;
    Ok(())
}

/// Writes a text STL file, with every digit of double precision.
///
/// # Errors
/// An empty or invalid mesh; failed writing.
pub fn write_stl_text(mesh: &Mesh, out: &mut impl Write) -> Result<(), Error> {
    Parts::of(mesh, MeshFormat::Stl)?;
    out.write_all(b"solid stereotomy\n")?;
    write_rows(out, mesh.triangles.len(), |row, text| {
        let corners = mesh.corners(row);
        text.extend_from_slice(b"facet normal");
        for coordinate in face_normal(corners).as_vec3().to_array() {
            text.push(b' ');
            push_f32(text, coordinate);
        }
        text.extend_from_slice(b"\n outer loop\n");
        for corner in corners {
            text.extend_from_slice(b"  vertex");
            for coordinate in corner.to_array() {
                text.push(b' ');
                push_f64(text, coordinate);
            }
            text.push(b'\n');
        }
        text.extend_from_slice(b" endloop\nendfacet\n");
    })?;
    Ok(out.write_all(b"endsolid stereotomy\n")?)
}

/// Reads a binary or text STL file.
///
/// Corners at exactly the same place become one vertex; triangles that
/// thereby vanish are left out, and so are the file's normals (they follow
/// from the corners). The unit is taken to be the millimetre.
///
/// # Errors
/// A file that is neither, or is cut off, has a coordinate that is not finite, or
/// no triangles.
pub fn read_stl(data: &[u8]) -> Result<Mesh, Error> {
    with_triangles(read_either(data)?, MeshFormat::Stl, data).map(|read| read.mesh)
}

fn read_either(data: &[u8]) -> Result<Mesh, Error> {
    // Some binary files begin with "solid" too: the length tells.
    let count = data.get(80..HEAD).and_then(|bytes| bytes.try_into().ok());
    let count = count.map(|bytes| u32::from_le_bytes(bytes) as usize);
    match count {
        Some(count) if data.len() == HEAD + count * RECORD => read_binary(data),
        _ if data.trim_ascii_start().starts_with(b"solid") => read_text(data),
        Some(count) if data.len() > HEAD + count * RECORD => read_binary(data),
        Some(count) => Err(malformed(
            format!("byte {}", data.len()),
            format!(
                "a binary STL file of {count} triangles is {} bytes long; \
                     this one may have been cut off",
                HEAD + count * RECORD
            ),
        )),
        None => Err(malformed(
            "byte 0",
            "this is no STL file: too short for either kind",
        )),
    }
}

fn malformed(place: impl Into<String>, problem: impl Into<String>) -> Error {
    Error::Malformed {
        format: MeshFormat::Stl,
        place: place.into(),
        problem: problem.into(),
    }
}

/// Reads as many triangles as the header promises; the data is long enough.
fn read_binary(data: &[u8]) -> Result<Mesh, Error> {
    /// Triangles per block.
    const TRIANGLES: usize = weld::BLOCK / 3;
    let count = u32::from_le_bytes([data[80], data[81], data[82], data[83]]) as usize;
    let records = &data[HEAD..HEAD + count * RECORD];
    let blocks: Vec<&[u8]> = records.chunks(TRIANGLES * RECORD).collect();
    let lengths: Vec<usize> = blocks.iter().map(|b| b.len() / RECORD * 3).collect();
    let mut triangles = vec![[0; 3]; count];
    let positions = weld(triangles.as_flattened_mut(), &lengths, |block, places| {
        for (index, record) in blocks[block].chunks_exact(RECORD).enumerate() {
            let real = |at: usize| {
                f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
            };
            for at in [12, 24, 36] {
                let place = Vec3::new(real(at), real(at + 4), real(at + 8));
                if !place.is_finite() {
                    let problem = format!("its corner at {place} is not finite");
                    let place = format!("triangle {}", block * TRIANGLES + index);
                    return Err(malformed(place, problem));
                }
                places.push(place);
            }
        }
        Ok(())
    })?;
    let positions = positions.ok_or_else(|| malformed("header", "it has too many triangles"))?;
    Ok(bare_mesh(positions, triangles))
}

/// A mesh of triangles alone, without those that vanish.
fn bare_mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let mut mesh = Mesh::new(positions, triangles);
    mesh.unit = LengthUnit::Millimetre;
    drop_vanished(&mut mesh);
    mesh
}

/// Reads the pieces of a text file in parallel. Where anything is wrong, one
/// thread goes over it again, to say at which line.
fn read_text(data: &[u8]) -> Result<Mesh, Error> {
    let pieces = text_pieces(data);
    let parts: Result<Vec<TextPart>, Error> = pieces.into_par_iter().map(TextPart::parse).collect();
    let whole = |parts: &Vec<TextPart>| {
        let inner = parts.len().saturating_sub(1);
        parts[..inner].iter().all(|part| part.open == 0)
    };
    let parts = match parts.ok().filter(whole) {
        Some(parts) => parts,
        None => vec![TextPart::parse(data)?],
    };
    if parts.iter().rev().find_map(|part| part.ended) != Some(true) {
        return Err(malformed(
            "end of file",
            "\"endsolid\" is missing; the file may have been cut off",
        ));
    }
    // (Corners of a facet without its end are no triangle.)
    let blocks: Vec<&[DVec3]> = parts
        .iter()
        .flat_map(|part| part.places[..part.places.len() - part.open].chunks(weld::BLOCK))
        .collect();
    let lengths: Vec<usize> = blocks.iter().map(|block| block.len()).collect();
    let mut triangles = vec![[0; 3]; lengths.iter().sum::<usize>() / 3];
    let positions = weld(triangles.as_flattened_mut(), &lengths, |block, to| {
        to.extend_from_slice(blocks[block]);
        Ok::<_, Error>(())
    })?;
    let positions =
        positions.ok_or_else(|| malformed("end of file", "it has too many triangles"))?;
    Ok(bare_mesh(positions, triangles))
}

/// Cuts a text file into pieces of some megabytes that begin with a facet.
fn text_pieces(data: &[u8]) -> Vec<&[u8]> {
    const LEAST: usize = 1 << 21;
    let mut pieces = Vec::new();
    let mut rest = data;
    while rest.len() > 2 * LEAST {
        let lines = rest[LEAST..].split_inclusive(|&b| b == b'\n');
        let mut end = LEAST;
        // (What is before the first line break is the end of another line.)
        for (index, line) in lines.enumerate() {
            if index > 0 && line.trim_ascii_start().starts_with(b"facet") {
                break;
            }
            end += line.len();
        }
        let (piece, later) = rest.split_at(end);
        pieces.push(piece);
        rest = later;
    }
    pieces.push(rest);
    pieces
}

/// What a piece of a text file says.
struct TextPart {
    /// The corners, three to a facet.
    places: Vec<DVec3>,
    /// The corners at the end that belong to no complete facet.
    open: usize,
    /// Whether the last solid that is begun or ended here is ended.
    ended: Option<bool>,
}

impl TextPart {
    fn parse(data: &[u8]) -> Result<Self, Error> {
        let mut places = Vec::new();
        let mut corners = 0;
        let mut ended = None;
        for (index, line) in data.split(|&b| b == b'\n').enumerate() {
            let place = || format!("line {}", index + 1);
            let mut words = line
                .split(u8::is_ascii_whitespace)
                .filter(|word| !word.is_empty());
            match words.next() {
                Some(b"vertex") => {
                    let mut number = || {
                        words
                            .next()
                            .and_then(|w| std::str::from_utf8(w).ok()?.parse().ok())
                    };
                    let numbers = [number(), number(), number()];
                    let vertex = match numbers {
                        [Some(x), Some(y), Some(z)] => Some(DVec3::new(x, y, z)),
                        _ => None,
                    };
                    let problem = "vertex needs three finite numbers";
                    let vertex = vertex.filter(|place| place.is_finite());
                    places.push(vertex.ok_or_else(|| malformed(place(), problem))?);
                    corners += 1;
                }
                Some(b"endloop") if corners == 3 => corners = 0,
                Some(b"endloop") => {
                    return Err(malformed(place(), "a facet needs exactly three vertices"));
                }
                Some(b"endsolid") => ended = Some(true),
                Some(b"solid") => ended = Some(false),
                Some(b"facet" | b"outer" | b"endfacet") | None => {}
                Some(word) => {
                    let word = String::from_utf8_lossy(word);
                    return Err(malformed(
                        place(),
                        format!("{word:?} does not belong in an STL file"),
                    ));
                }
            }
        }
        Ok(Self {
            places,
            open: corners,
            ended,
        })
    }
}
