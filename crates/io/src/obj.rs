//! Wavefront OBJ (`.obj`) with its material library (`.mtl`).
//!
//! Numbers are written in the shortest form that reads back to the same bits,
//! and vertices keep their identity, so a mesh returns as it was. OBJ has
//! neither unit nor up axis: the numbers are the model's own, a comment
//! names the unit.
//!
//! (The reader is our own, not tobj, because vertices that coincide on
//! purpose, where a solid touches itself, must stay apart also between groups.)

use std::io::Write;

use csg::{Color, LengthUnit, Mesh};
use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;

use crate::assemble::Assembler;
use crate::parts::{DEFAULT_COLOR, DEFAULT_MATERIAL, Parts, unit_normals};
use crate::rows::{push_f32, push_f64, push_index, write_rows};
use crate::{Error, MeshFormat, units};

/// Writes an OBJ file: a group (`g`) for every name, a `usemtl` for every
/// colour, normals where the mesh has them. `mtl_name` names the file that
/// [`write_mtl`] fills; without it there are no materials.
///
/// Blanks and control characters in names become `_`.
///
/// # Errors
/// An empty or invalid mesh; failed writing.
pub fn write_obj(mesh: &Mesh, mtl_name: Option<&str>, out: &mut impl Write) -> Result<(), Error> {
    let parts = Parts::of(mesh, MeshFormat::Obj)?;
    writeln!(out, "# stereotomy: unit {}, Z up", units::name(mesh.unit))?;
    if let Some(name) = mtl_name {
        writeln!(out, "mtllib {name}")?;
    }
    write_rows(out, mesh.positions.len(), |row, text| {
        text.push(b'v');
        for coordinate in mesh.positions[row].to_array() {
            text.push(b' ');
            push_f64(text, coordinate);
        }
        text.push(b'\n');
    })?;
    let normals = Normals::of(mesh);
    write_rows(out, normals.distinct.len(), |row, text| {
        text.extend_from_slice(b"vn");
        for coordinate in normals.distinct[row].to_array() {
            text.push(b' ');
            push_f32(text, coordinate);
        }
        text.push(b'\n');
    })?;
    let mut name = None;
    for part in &parts.parts {
        if part.name != name {
            name = part.name;
            writeln!(out, "g {}", one_word(name.unwrap_or_default()))?;
        }
        if mtl_name.is_some() {
            writeln!(out, "usemtl {}", parts.color_name(part.color))?;
        }
        write_rows(out, part.triangles.len(), |row, text| {
            let triangle = part.triangles[row] as usize;
            text.push(b'f');
            for corner in 0..3 {
                text.push(b' ');
                push_index(text, u64::from(mesh.triangles[triangle][corner]) + 1);
                if let Some(normals) = normals.of_corners.get(triangle) {
                    text.extend_from_slice(b"//");
                    push_index(text, u64::from(normals[corner]) + 1);
                }
            }
            text.push(b'\n');
        })?;
    }
    Ok(())
}

/// Writes the material library of [`write_obj`]: the colours as sRGB (what
/// most programs take `Kd` for) and their opacity.
///
/// # Errors
/// As [`write_obj`].
pub fn write_mtl(mesh: &Mesh, out: &mut impl Write) -> Result<(), Error> {
    let parts = Parts::of(mesh, MeshFormat::Obj)?;
    let mut text = Vec::new();
    for (index, color) in parts.colors.iter().enumerate() {
        let color = color.unwrap_or(DEFAULT_COLOR);
        text.extend_from_slice(format!("newmtl {}\nKd", parts.color_name(index)).as_bytes());
        for component in color.to_srgb() {
            text.push(b' ');
            push_f32(&mut text, component);
        }
        text.extend_from_slice(b"\nd ");
        push_f32(&mut text, color.alpha);
        text.extend_from_slice(b"\nillum 1\n\n");
    }
    Ok(out.write_all(&text)?)
}

/// The distinct normals of a mesh, and each corner's index into them.
struct Normals {
    distinct: Vec<Vec3>,
    of_corners: Vec<[u32; 3]>,
}

impl Normals {
    fn of(mesh: &Mesh) -> Self {
        let mut slots: FxHashMap<[u32; 3], u32> = FxHashMap::default();
        let mut normals = Self {
            distinct: Vec::new(),
            of_corners: Vec::with_capacity(mesh.corner_normals.len()),
        };
        // Most corners have the normal their vertex last had: look there first.
        let mut last = vec![0u32; mesh.positions.len()];
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            let Some(corners) = unit_normals(mesh, index) else {
                break;
            };
            normals.of_corners.push([0, 1, 2].map(|i| {
                let normal: Vec3 = corners[i];
                let last = &mut last[triangle[i] as usize];
                if normals.distinct.get(*last as usize) != Some(&normal) {
                    let key = normal.to_array().map(|x| (x + 0.0).to_bits());
                    *last = *slots.entry(key).or_insert_with(|| {
                        normals.distinct.push(normal);
                        normals.distinct.len() as u32 - 1
                    });
                }
                *last
            }));
        }
        normals
    }
}

/// A name without blanks, which separate names in OBJ.
fn one_word(name: &str) -> String {
    let plain = |c: char| {
        if c.is_whitespace() || c.is_control() {
            '_'
        } else {
            c
        }
    };
    match name {
        "" => "default".to_owned(),
        name => name.chars().map(plain).collect(),
    }
}

/// Reads an OBJ file; `load` fetches a material library by name, and where it
/// gives nothing the colours are left out.
///
/// Polygons are cut into triangles from their first corner. Groups and
/// objects become names, materials' diffuse colours (taken as sRGB) colours.
/// Lines, points, free-form surfaces and texture coordinates are passed over.
/// The unit is taken to be the millimetre.
///
/// # Errors
/// A face or number that is not valid, with its line.
pub fn read_obj(data: &[u8], mut load: impl FnMut(&str) -> Option<Vec<u8>>) -> Result<Mesh, Error> {
    let mut mesh = Assembler::new(LengthUnit::Millimetre);
    let mut normals: Vec<Vec3> = Vec::new();
    let mut materials: FxHashMap<String, Option<Color>> = FxHashMap::default();
    let mut name: Option<String> = None;
    let mut color = None;
    let mut changed = false;
    let mut face = Vec::new();
    for (number, line) in lines(data) {
        let place = || format!("line {number}");
        let mut words = words(&line);
        match words.next() {
            Some(b"v") => {
                let place = vector(&mut words).and_then(|v| mesh.vertex(v));
                place.ok_or_else(|| malformed(number, "v needs three finite numbers"))?;
            }
            Some(b"vn") => {
                let normal = vector(&mut words);
                let normal = normal.ok_or_else(|| malformed(number, "vn needs three numbers"))?;
                normals.push(normal.normalize_or_zero().as_vec3());
            }
            Some(b"f") => {
                if std::mem::take(&mut changed) {
                    mesh.begin_part(name.as_deref(), color);
                }
                face.clear();
                for word in words {
                    face.push(corner(word, mesh.vertex_count(), normals.len()).map_err(
                        |problem| Error::Malformed {
                            format: MeshFormat::Obj,
                            place: place(),
                            problem,
                        },
                    )?);
                }
                if face.len() < 3 {
                    return Err(malformed(number, "a face needs at least three corners"));
                }
                for i in 1..face.len() - 1 {
                    let corners = [face[0], face[i], face[i + 1]];
                    let [n0, n1, n2] = corners.map(|(_, normal)| normal.map(|n| normals[n]));
                    let normals = n0.zip(n1).zip(n2).map(|((a, b), c)| [a, b, c]);
                    mesh.triangle(corners.map(|(vertex, _)| vertex), normals);
                }
            }
            Some(b"g" | b"o") => {
                name = words.next().map(text).filter(|name| name != "default");
                changed = true;
            }
            Some(b"usemtl") => {
                let material = words.next().map(text).unwrap_or_default();
                color = materials.get(&material).copied().flatten();
                changed = true;
            }
            Some(b"mtllib") => {
                let rest: Vec<_> = words.map(text).collect();
                if let Some(library) = load(&rest.join(" ")) {
                    read_mtl(&library, &mut materials);
                }
            }
            _ => {}
        }
    }
    Ok(mesh.finish())
}

/// Adds a library's materials; `None` for the one that stands for no colour.
fn read_mtl(data: &[u8], materials: &mut FxHashMap<String, Option<Color>>) {
    let mut current = String::new();
    for (_, line) in lines(data) {
        let mut words = words(&line);
        let keyword = words.next();
        if keyword == Some(b"newmtl") {
            current = words.next().map(text).unwrap_or_default();
            materials.insert(current.clone(), None);
        } else if let Some(color) = materials.get_mut(&current)
            && current != DEFAULT_MATERIAL
        {
            match keyword {
                Some(b"Kd") => {
                    if let Some(rgb) = vector(&mut words) {
                        let alpha = color.map_or(1.0, |c| c.alpha);
                        let opaque = Color::from_srgb(rgb.as_vec3().to_array());
                        *color = Some(opaque.with_alpha(alpha));
                    }
                }
                Some(b"d") => {
                    if let Some(alpha) = words.next().and_then(number) {
                        *color = Some(color.unwrap_or(DEFAULT_COLOR).with_alpha(alpha as f32));
                    }
                }
                _ => {}
            }
        }
    }
}

fn malformed(line: usize, problem: &str) -> Error {
    Error::Malformed {
        format: MeshFormat::Obj,
        place: format!("line {line}"),
        problem: problem.to_owned(),
    }
}

/// A corner `v`, `v/t`, `v//n` or `v/t/n`: indices from 1, or from -1
/// backwards. The vertex and the normal, counted from 0.
fn corner(word: &[u8], vertices: usize, normals: usize) -> Result<(u32, Option<usize>), String> {
    let index = |digits: &[u8], count: usize, what: &str| {
        let wrong = || {
            let digits = String::from_utf8_lossy(digits);
            format!("{digits:?} names none of the {count} {what} so far")
        };
        let number: i64 = std::str::from_utf8(digits)
            .ok()
            .and_then(|d| d.parse().ok())
            .ok_or_else(wrong)?;
        let index = if number < 0 {
            count as i64 + number
        } else {
            number - 1
        };
        usize::try_from(index)
            .ok()
            .filter(|&i| i < count)
            .ok_or_else(wrong)
    };
    let mut fields = word.split(|&b| b == b'/');
    let vertex = index(fields.next().unwrap_or_default(), vertices, "vertices")?;
    let normal = match fields.nth(1) {
        Some(digits) if !digits.is_empty() => Some(index(digits, normals, "normals")?),
        _ => None,
    };
    Ok((vertex as u32, normal))
}

/// The lines with their numbers (from 1), continued ones joined, without
/// comments.
fn lines(data: &[u8]) -> impl Iterator<Item = (usize, std::borrow::Cow<'_, [u8]>)> {
    let mut rest = data.split(|&b| b == b'\n').enumerate();
    std::iter::from_fn(move || {
        let (index, line) = rest.next()?;
        let mut line = std::borrow::Cow::Borrowed(line.trim_ascii_end());
        while line.ends_with(b"\\") {
            let line = line.to_mut();
            line.pop();
            line.push(b' ');
            if let Some((_, more)) = rest.next() {
                line.extend_from_slice(more.trim_ascii_end());
            }
        }
        if let Some(comment) = line.iter().position(|&b| b == b'#') {
            match &mut line {
                std::borrow::Cow::Borrowed(line) => *line = &line[..comment],
                std::borrow::Cow::Owned(line) => line.truncate(comment),
            }
        }
        Some((index + 1, line))
    })
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

fn text(word: &[u8]) -> String {
    String::from_utf8_lossy(word).into_owned()
}

fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

fn vector<'a>(words: &mut impl Iterator<Item = &'a [u8]>) -> Option<DVec3> {
    let mut next = || words.next().and_then(number);
    Some(DVec3::new(next()?, next()?, next()?))
}
