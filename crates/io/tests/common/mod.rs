//! Meshes to write and read, for several test files.
#![allow(dead_code, reason = "not every test file uses every item")]

use std::sync::Arc;

use csg::{Color, LengthUnit, Mesh, MeshSurface};
use glam::{DVec3, Vec3, dvec3};

/// A model of a tetrahedron, and of two of them put together, one of which is mirrored.
pub const MODEL: &str = r##"<?xml version="1.0" encoding="UTF-8"?>
<model unit="centimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
       xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02">
 <resources>
  <basematerials id="5"><base name="a" displaycolor="#FF8000"/></basematerials>
  <m:colorgroup id="6"><m:color color="#0040FF80"/></m:colorgroup>
  <object id="1" type="model" name="Tetra &amp; eder" pid="5" pindex="0"><mesh>
   <vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>
    <vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices>
   <triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/>
    <triangle v1="1" v2="2" v3="3" pid="6" p1="0"/><triangle v1="2" v2="0" v3="3"/></triangles>
  </mesh></object>
  <object id="2"><components>
   <component objectid="1"/>
   <component objectid="1" transform="-2 0 0 0 1 0 0 0 1 -5 0 0"/>
  </components></object>
 </resources>
 <build><item objectid="2" transform="1 0 0 0 1 0 0 0 1 10 20 30"/></build>
</model>
"##;

/// A model in an archive, without a list of what is in it.
pub fn archive(model: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    zip.start_file("3D/3dmodel.model", options).expect("begun");
    zip.write_all(model).expect("written");
    zip.finish().expect("finished").into_inner()
}

/// A box from corner to corner, with face normals at its corners, each pair
/// of opposite faces a surface of its own: one unnamed, one named, one named
/// and coloured, ...
pub fn colored_box(low: DVec3, high: DVec3) -> Mesh {
    let positions = (0..8)
        .map(|i| {
            let pick = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 1 { high } else { low };
            dvec3(
                pick(0, low.x, high.x),
                pick(1, low.y, high.y),
                pick(2, low.z, high.z),
            )
        })
        .collect();
    let quads = [
        ([0, 2, 3, 1], Vec3::NEG_Z, 0),
        ([4, 5, 7, 6], Vec3::Z, 1),
        ([0, 1, 5, 4], Vec3::NEG_Y, 2),
        ([2, 6, 7, 3], Vec3::Y, 2),
        ([0, 4, 6, 2], Vec3::NEG_X, 3),
        ([1, 3, 7, 5], Vec3::X, 4),
    ];
    let mut mesh = Mesh {
        positions,
        ..Mesh::default()
    };
    for ([a, b, c, d], normal, surface) in quads {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
        mesh.corner_normals.extend([[normal; 3]; 2]);
        mesh.triangle_surfaces.extend([surface; 2]);
    }
    let looks = [
        (None, None),
        (Some("hub"), Some(Color::from_srgb([1.0, 0.5, 0.0]))),
        (Some("hub"), None),
        (
            Some("Nabe 2 <&\">"),
            Some(Color::from_srgb([0.0, 0.25, 1.0]).with_alpha(0.5)),
        ),
        (None, Some(Color::from_srgb([1.0, 0.5, 0.0]))),
    ];
    mesh.surfaces = (0..)
        .zip(looks)
        .map(|(index, (name, color))| MeshSurface {
            surface: index,
            primitive: index / 2,
            name: name.map(Arc::from),
            color,
            ..MeshSurface::default()
        })
        .collect();
    mesh
}

/// The box from 0 to (1, 2, 3).
pub fn small_box() -> Mesh {
    colored_box(DVec3::ZERO, dvec3(1.0, 2.0, 3.0))
}

/// A sphere with irrational coordinates and exact normals, without names.
pub fn sphere(centre: DVec3, radius: f64, rings: u32) -> Mesh {
    let around = 2 * rings;
    let mut normals = vec![DVec3::NEG_Z];
    for i in 1..rings {
        let (sin, cos) = (std::f64::consts::PI * f64::from(i) / f64::from(rings)).sin_cos();
        for j in 0..around {
            let angle = std::f64::consts::TAU * f64::from(j) / f64::from(around);
            normals.push(dvec3(sin * angle.cos(), sin * angle.sin(), -cos));
        }
    }
    normals.push(DVec3::Z);
    let last = normals.len() as u32 - 1;
    let at = |i: u32, j: u32| match i {
        0 => 0,
        i if i == rings => last,
        i => 1 + (i - 1) * around + j % around,
    };
    let mut triangles = Vec::new();
    for i in 0..rings {
        for j in 0..around {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            if i > 0 {
                triangles.push([a, b, c]);
            }
            if i + 1 < rings {
                triangles.push([a, c, d]);
            }
        }
    }
    let corner_normals = triangles
        .iter()
        .map(|t: &[u32; 3]| t.map(|v| normals[v as usize].as_vec3()))
        .collect();
    Mesh {
        corner_normals,
        ..Mesh::new(
            normals.iter().map(|&n| centre + radius * n).collect(),
            triangles,
        )
    }
}

/// The same mesh in another unit.
pub fn in_unit(mesh: Mesh, unit: LengthUnit) -> Mesh {
    Mesh { unit, ..mesh }
}

/// A triangle as its corners, its name and its colour: what a file may
/// reorder but not change.
pub type Face = (Vec<[u64; 3]>, Option<String>, Option<[u32; 4]>);

/// The faces of a mesh as a sorted list; the first corner is the least.
pub fn faces(mesh: &Mesh) -> Vec<Face> {
    let mut faces: Vec<Face> = (0..mesh.triangles.len())
        .map(|index| {
            let mut corners: Vec<_> = mesh
                .corners(index)
                .iter()
                .map(|p| p.to_array().map(|x| (x + 0.0).to_bits()))
                .collect();
            let least = (0..3).min_by_key(|&i| corners[i]).expect("three corners");
            corners.rotate_left(least);
            let surface = mesh.surface_of(index);
            let name = surface.and_then(|s| s.name.as_deref().map(str::to_owned));
            let color = surface
                .and_then(|s| s.color)
                .map(|c| [c.rgb[0], c.rgb[1], c.rgb[2], c.alpha].map(f32::to_bits));
            (corners, name, color)
        })
        .collect();
    faces.sort();
    faces
}

/// Colours compared as bytes of sRGB: what OBJ and PLY keep.
pub fn srgb_bytes(color: Color) -> [u8; 4] {
    let [r, g, b] = color.to_srgb();
    [r, g, b, color.alpha].map(|x| (x * 255.0).round() as u8)
}
