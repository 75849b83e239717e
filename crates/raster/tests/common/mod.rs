//! Meshes that the tests draw.
#![allow(dead_code, reason = "every test binary uses its own part")]

use std::collections::HashMap;

use csg::{Color, Mesh, MeshSurface};
use glam::{DMat3, DVec3};
use raster::View;

/// An axis-aligned cuboid, each side a surface of its own.
pub fn cuboid(low: DVec3, high: DVec3) -> Mesh {
    let positions = (0..8)
        .map(|i| {
            DVec3::new(
                if i & 1 == 0 { low.x } else { high.x },
                if i & 2 == 0 { low.y } else { high.y },
                if i & 4 == 0 { low.z } else { high.z },
            )
        })
        .collect();
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let mut mesh = Mesh::new(positions, Vec::new());
    for (side, [a, b, c, d]) in quads.into_iter().enumerate() {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
        mesh.triangle_surfaces.extend([side as u32; 2]);
        mesh.surfaces.push(MeshSurface {
            surface: side as u32,
            ..MeshSurface::default()
        });
    }
    mesh
}

/// A subdivided icosahedron with 20 * 4^level triangles and exact normals.
pub fn icosphere(centre: DVec3, radius: f64, level: u32) -> Mesh {
    let t = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut unit: Vec<DVec3> = [
        [-1.0, t, 0.0],
        [1.0, t, 0.0],
        [-1.0, -t, 0.0],
        [1.0, -t, 0.0],
        [0.0, -1.0, t],
        [0.0, 1.0, t],
        [0.0, -1.0, -t],
        [0.0, 1.0, -t],
        [t, 0.0, -1.0],
        [t, 0.0, 1.0],
        [-t, 0.0, -1.0],
        [-t, 0.0, 1.0],
    ]
    .into_iter()
    .map(|p| DVec3::from_array(p).normalize())
    .collect();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..level {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut next = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(i, j)| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    unit.push((unit[i as usize] + unit[j as usize]).normalize());
                    unit.len() as u32 - 1
                })
            });
            next.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = next;
    }
    let normals = triangles
        .iter()
        .map(|t| t.map(|v| unit[v as usize].as_vec3()))
        .collect();
    let mut mesh = Mesh::new(
        unit.into_iter().map(|p| centre + p * radius).collect(),
        triangles,
    );
    mesh.corner_normals = normals;
    mesh
}

/// A mesh whose faces show their other sides.
pub fn inside_out(mut mesh: Mesh) -> Mesh {
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    mesh
}

/// Both meshes as one.
pub fn merge(mut a: Mesh, b: &Mesh) -> Mesh {
    let base = a.positions.len() as u32;
    a.positions.extend(&b.positions);
    a.triangles
        .extend(b.triangles.iter().map(|t| t.map(|v| v + base)));
    if a.corner_normals.len() + b.triangles.len() == a.triangles.len() {
        a.corner_normals.extend(&b.corner_normals);
    }
    let surfaces = a.surfaces.len() as u32;
    a.triangle_surfaces
        .extend(b.triangle_surfaces.iter().map(|s| s + surfaces));
    a.surfaces.extend(b.surfaces.iter().cloned());
    a
}

/// The whole mesh as one surface of one colour.
pub fn colored(mut mesh: Mesh, srgb: [f32; 3]) -> Mesh {
    mesh.triangle_surfaces = vec![0; mesh.triangles.len()];
    mesh.surfaces = vec![MeshSurface {
        color: Some(Color::from_srgb(srgb)),
        ..MeshSurface::default()
    }];
    mesh
}

/// What a stack of colours and opacities, from the nearest, looks like.
pub fn blended(layers: &[([f32; 3], f32)]) -> [u8; 4] {
    let (mut sum, mut through) = ([0.0; 3], 1.0);
    for &(rgb, alpha) in layers {
        for (sum, channel) in sum.iter_mut().zip(rgb) {
            *sum += through * alpha * channel;
        }
        through *= 1.0 - alpha;
    }
    let opacity = 1.0 - through;
    let encoded = Color::from_linear(sum.map(|c| c / opacity.max(f32::MIN_POSITIVE))).to_srgb();
    let [r, g, b] = encoded.map(|c| (c * 255.0).round() as u8);
    [r, g, b, (opacity * 255.0).round() as u8]
}

/// The reversed depth of each triangle's plane as (a, b, c): a x + b y + c at
/// the window position (x, y). Homogeneously z = a x + b y + c w at its
/// corners. The corners are those that a scene keeps: in single precision
/// relative to its centre.
pub fn reversed_depth_planes(mesh: &Mesh, view: &View, size: [u32; 2]) -> Vec<DVec3> {
    let [half_x, half_y] = size.map(|side| f64::from(side) / 2.0);
    let low = mesh.positions.iter().copied().reduce(DVec3::min).unwrap();
    let high = mesh.positions.iter().copied().reduce(DVec3::max).unwrap();
    let centre = low / 2.0 + high / 2.0;
    let plane = |triangle: usize| {
        let corners = mesh.corners(triangle).map(|p| {
            let kept = (p - centre).as_vec3().as_dvec3() + centre;
            view.world_to_clip() * kept.extend(1.0)
        });
        let rows = corners.map(|p| DVec3::new((p.x + p.w) * half_x, (p.w - p.y) * half_y, p.w));
        let depths = DVec3::from_array(corners.map(|p| (p.w - p.z) / 2.0));
        let matrix = DMat3::from_cols_array_2d(&rows.map(|r| r.to_array())).transpose();
        matrix.inverse() * depths
    };
    (0..mesh.triangles.len()).map(plane).collect()
}

/// Between what a triangle's reversed depth is held: that of its corners, and
/// what snapping them to 1/256 pixel can change of it; without bounds where it
/// is clipped.
pub fn depth_bounds(
    mesh: &Mesh,
    view: &View,
    [width, height]: [u32; 2],
    triangle: u32,
    plane: DVec3,
) -> [f64; 2] {
    let viewport = raster::Viewport::of_image(width, height);
    let slack = plane.truncate().abs().element_sum() / 256.0;
    let mut bounds = [f64::INFINITY, f64::NEG_INFINITY];
    for p in mesh.corners(triangle as usize) {
        match viewport.project(view, p).map(|window| 1.0 - window.z) {
            Some(z) if (0.0..=1.0).contains(&z) => {
                bounds = [bounds[0].min(z - slack), bounds[1].max(z + slack)];
            }
            _ => return [f64::NEG_INFINITY, f64::INFINITY],
        }
    }
    bounds
}

/// How far, in units of 2^-24, a pixel's reversed depth is from that of its
/// triangle's plane ([`reversed_depth_planes`]) within its bounds: corners are
/// snapped to 1/256 pixel, so that a pixel may lie so far outside its triangle.
/// A triangle whose depth runs through a quarter of its range within 1/256
/// pixel is seen edge-on to within snapping and has no plane to speak of: it
/// is only held within its bounds.
pub fn depth_error(found: f64, plane: DVec3, [low, high]: [f64; 2], pixel: [u32; 2]) -> f64 {
    let [x, y] = pixel.map(|v| f64::from(v) + 0.5);
    let wanted = if plane.truncate().length() < 64.0 {
        plane.dot(DVec3::new(x, y, 1.0))
    } else {
        found
    };
    (found - wanted.clamp(low, high)).abs() * f64::from(1 << 24)
}
