//! The Object File Format (OFF): vertices and polygons as text. Names, colours
//! and the unit are lost.

use std::io::Write;

use csg::Mesh;
use glam::DVec3;

use crate::assemble::{drop_vanished, with_triangles};
use crate::parts::Parts;
use crate::rows::{push_f64, push_index, write_rows};
use crate::{Error, MeshFormat};

/// Writes an OFF file, with every digit of double precision.
///
/// # Errors
/// An empty or invalid mesh; failed writing.
pub fn write_off(mesh: &Mesh, out: &mut impl Write) -> Result<(), Error> {
    Parts::of(mesh, MeshFormat::Off)?;
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    writeln!(out, "OFF\n{vertices} {faces} 0")?;
    write_rows(out, vertices, |row, text| {
        for coordinate in mesh.positions[row].to_array() {
            push_f64(text, coordinate);
            text.push(b' ');
        }
        text.push(b'\n');
    })?;
    write_rows(out, faces, |row, text| {
        text.push(b'3');
        for vertex in mesh.triangles[row] {
            text.push(b' ');
            push_index(text, vertex.into());
        }
        text.push(b'\n');
    })?;
    Ok(())
}

/// Reads an OFF file: `OFF`, the numbers of vertices, faces and edges, the
/// vertices, and for each face its number of corners and these. Colours after a
/// face's corners are passed over; polygons are cut into triangles.
///
/// # Errors
/// A damaged file, with the line; no faces.
pub fn read_off(data: &[u8]) -> Result<Mesh, Error> {
    let text = String::from_utf8_lossy(data);
    let lines = (1..).zip(text.lines()).map(|(number, line)| {
        let line = line.split('#').next().unwrap_or_default();
        (number, line.trim())
    });
    let mut lines = lines.filter(|(_, line)| !line.is_empty());
    let mut next = |wanted: &str| {
        lines.next().ok_or_else(|| {
            let problem = format!("{wanted} is missing; the file may have been cut off");
            malformed("the end", problem)
        })
    };
    let (number, first) = next("the header")?;
    let Some(rest) = first.strip_prefix("OFF") else {
        return Err(at(
            number,
            "this is no OFF file: it must begin with \"OFF\"",
        ));
    };
    let (number, counts) = if rest.trim().is_empty() {
        next("the line of counts")?
    } else {
        (number, rest)
    };
    let mut counts = counts.split_ascii_whitespace().map(str::parse::<u32>);
    let (Some(Ok(vertices)), Some(Ok(faces))) = (counts.next(), counts.next()) else {
        return Err(at(number, "it needs the numbers of vertices and of faces"));
    };
    let mut positions = Vec::new();
    for _ in 0..vertices {
        let (number, line) = next("a vertex")?;
        let mut numbers = line.split_ascii_whitespace().map(str::parse::<f64>);
        let (Some(Ok(x)), Some(Ok(y)), Some(Ok(z))) =
            (numbers.next(), numbers.next(), numbers.next())
        else {
            return Err(at(number, "a vertex needs three numbers"));
        };
        let position = DVec3::new(x, y, z);
        if !position.is_finite() {
            return Err(at(number, "its coordinates are not finite"));
        }
        positions.push(position);
    }
    let mut polygons = Vec::new();
    for _ in 0..faces {
        let (number, line) = next("a face")?;
        let mut words = line.split_ascii_whitespace();
        let count = words.next().and_then(|word| word.parse::<usize>().ok());
        let count = count.ok_or_else(|| at(number, "a face begins with its number of corners"))?;
        let corners: Vec<u32> = words.take(count).map_while(|w| w.parse().ok()).collect();
        if corners.len() < count {
            return Err(at(number, "the face has fewer corners than it says"));
        }
        if let Some(bad) = corners.iter().find(|&&corner| corner >= vertices) {
            let problem = format!("it names vertex {bad}, but there are only {vertices}");
            return Err(at(number, problem));
        }
        polygons.push(corners);
    }
    let mesh = Mesh::from_polygons(positions, polygons);
    let mut mesh = mesh.ok_or_else(|| malformed("the faces", "a vertex does not exist"))?;
    drop_vanished(&mut mesh);
    with_triangles(mesh, MeshFormat::Off, data).map(|read| read.mesh)
}

fn at(line: usize, problem: impl Into<String>) -> Error {
    malformed(format!("line {line}"), problem)
}

fn malformed(place: impl Into<String>, problem: impl Into<String>) -> Error {
    Error::Malformed {
        format: MeshFormat::Off,
        place: place.into(),
        problem: problem.into(),
    }
}
