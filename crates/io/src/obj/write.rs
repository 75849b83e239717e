//! The OBJ writer.

use std::io::Write;

use csg::Mesh;
use glam::Vec3;
use rustc_hash::FxHashMap;

use crate::parts::{DEFAULT_COLOR, Parts, unit_normals};
use crate::rows::{push_f32, push_f64, push_index, write_rows};
use crate::{Error, MeshFormat, units};

/// Writes an OBJ file: an object (`o`) for every part whose faces have names in common
/// (`outer/inner`), a group (`g`) for every other name, a `usemtl` for every
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
    for part in &parts.parts {
        if !part.names.is_empty() {
            writeln!(out, "o {}", one_word(&part.names.join("/")))?;
        }
        let mut names = &part.names;
        for group in &part.groups {
            if group.names != *names {
                names = &group.names;
                writeln!(out, "g {}", one_word(names.last().unwrap_or(&"")))?;
            }
            if mtl_name.is_some() {
                writeln!(out, "usemtl {}", parts.color_name(group.color))?;
            }
            write_rows(out, group.triangles.len(), |row, text| {
                let triangle = group.triangles[row] as usize;
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
