//! STL, binary and text: triangles and nothing else. Names, colours and the
//! unit are lost; the numbers are the model's own.

use std::io::Write;

use csg::{LengthUnit, Mesh};
use glam::{DVec3, Vec3};

use crate::assemble::Assembler;
use crate::parts::{Parts, face_normal};
use crate::rows::{push_f32, push_f64, write_rows};
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
    if !mesh.positions.iter().all(|p| p.as_vec3().is_finite()) {
        return Err(Error::DoesNotFit {
            format: MeshFormat::Stl,
            problem: "its coordinates exceed single precision; write text, or scale it down"
                .to_owned(),
        });
    }
    // (A binary header must not begin with "solid".)
    let mut head = format!("stereotomy: unit {}, Z up", units::name(mesh.unit)).into_bytes();
    head.resize(80, b' ');
    head.extend_from_slice(&(mesh.triangles.len() as u32).to_le_bytes());
    out.write_all(&head)?;
    write_rows(out, mesh.triangles.len(), |row, bytes| {
        let corners = mesh.corners(row);
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
/// A file that is neither, or is cut off, or has a coordinate that is not
/// finite.
pub fn read_stl(data: &[u8]) -> Result<Mesh, Error> {
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
    let count = u32::from_le_bytes([data[80], data[81], data[82], data[83]]) as usize;
    let mut mesh = Assembler::new(LengthUnit::Millimetre);
    // A closed mesh has half as many vertices as triangles.
    mesh.reserve(count / 2, count);
    for (index, record) in data[HEAD..].chunks_exact(RECORD).take(count).enumerate() {
        let real = |at: usize| {
            f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
        };
        let mut corners = [0; 3];
        for (corner, slot) in corners.iter_mut().enumerate() {
            let at = 12 + corner * 12;
            let place = Vec3::new(real(at), real(at + 4), real(at + 8)).as_dvec3();
            *slot = mesh.weld(place).ok_or_else(|| {
                let problem = format!("its corner at {place} is not finite");
                malformed(format!("triangle {index}"), problem)
            })?;
        }
        mesh.triangle(corners, None);
    }
    Ok(mesh.finish())
}

fn read_text(data: &[u8]) -> Result<Mesh, Error> {
    let mut mesh = Assembler::new(LengthUnit::Millimetre);
    let mut corners = Vec::with_capacity(3);
    let mut ended = false;
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
                    [Some(x), Some(y), Some(z)] => mesh.weld(DVec3::new(x, y, z)),
                    _ => None,
                };
                let problem = "vertex needs three finite numbers";
                corners.push(vertex.ok_or_else(|| malformed(place(), problem))?);
            }
            Some(b"endloop") => match *corners {
                [a, b, c] => {
                    mesh.triangle([a, b, c], None);
                    corners.clear();
                }
                _ => return Err(malformed(place(), "a facet needs exactly three vertices")),
            },
            Some(b"endsolid") => ended = true,
            Some(b"solid") => ended = false,
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
    if !ended {
        return Err(malformed(
            "end of file",
            "\"endsolid\" is missing; the file may have been cut off",
        ));
    }
    Ok(mesh.finish())
}
