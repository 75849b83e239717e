//! Corner normals for meshes that bring none.

use csg::Mesh;
use glam::{DVec3, Vec3};

/// Two faces whose normals differ by less than this angle (in radians, 30
/// degrees) are taken for one smooth surface, unless they are known to lie on
/// different ones.
pub const CREASE_ANGLE: f64 = std::f64::consts::FRAC_PI_6;

/// Unit normals at the corners of each triangle: the mesh's own if it has
/// them, otherwise the mean of the normals, weighted by the angle at the
/// vertex, of those triangles around it that lie on the same surface (if the
/// mesh says so) and whose normals are within `crease_angle` of this one's.
/// Degenerate triangles get a zero normal. O(sum of squared valences).
#[must_use]
pub fn corner_normals(mesh: &Mesh, crease_angle: f64) -> Vec<[Vec3; 3]> {
    if mesh.corner_normals.len() == mesh.triangles.len() {
        return mesh.corner_normals.clone();
    }
    let corners = |t: &[u32; 3]| {
        let at = |i: u32| mesh.positions.get(i as usize).copied();
        Some([at(t[0])?, at(t[1])?, at(t[2])?])
    };
    let faces: Vec<DVec3> = mesh
        .triangles
        .iter()
        .map(|t| {
            corners(t).map_or(DVec3::ZERO, |[a, b, c]| {
                (b - a).cross(c - a).normalize_or_zero()
            })
        })
        .collect();
    // Triangles around each vertex, as one array with offsets.
    let mut offsets = vec![0u32; mesh.positions.len() + 1];
    let usable = |t: &&[u32; 3]| t.iter().all(|&v| (v as usize) < mesh.positions.len());
    for triangle in mesh.triangles.iter().filter(usable) {
        for &v in triangle {
            offsets[v as usize + 1] += 1;
        }
    }
    for i in 1..offsets.len() {
        offsets[i] += offsets[i - 1];
    }
    let mut fill = offsets.clone();
    let mut around = vec![(0u32, 0u32); offsets.last().copied().unwrap_or(0) as usize];
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        if usable(&triangle) {
            for (k, &v) in triangle.iter().enumerate() {
                around[fill[v as usize] as usize] = (index as u32, k as u32);
                fill[v as usize] += 1;
            }
        }
    }
    let angle_at = |triangle: u32, k: u32| {
        corners(&mesh.triangles[triangle as usize]).map_or(0.0, |p| {
            let k = k as usize;
            let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            u.cross(v).length().atan2(u.dot(v))
        })
    };
    let surface = |triangle: u32| mesh.triangle_surfaces.get(triangle as usize);
    let cos_crease = crease_angle.cos();
    mesh.triangles
        .iter()
        .enumerate()
        .map(|(index, triangle)| {
            let face = faces[index];
            triangle.map(|v| {
                let v = v as usize;
                if v + 1 >= offsets.len() {
                    return Vec3::ZERO;
                }
                let mut sum = DVec3::ZERO;
                for &(other, k) in &around[offsets[v] as usize..offsets[v + 1] as usize] {
                    if surface(other) == surface(index as u32)
                        && faces[other as usize].dot(face) >= cos_crease
                    {
                        sum += faces[other as usize] * angle_at(other, k);
                    }
                }
                let normal = sum.normalize_or_zero();
                if normal == DVec3::ZERO { face } else { normal }.as_vec3()
            })
        })
        .collect()
}
