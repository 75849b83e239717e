//! What a finished mesh gets from the surfaces it lies on: exact normals,
//! feature edges, and a measurement of how far it strays.

use crate::elementary;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::mesh::Mesh;
use crate::program::{Program, Surface};

/// The surface of every triangle.
pub(crate) fn surface_of<'a>(
    program: &'a Program,
    mesh: &Mesh,
    triangle: usize,
) -> Option<&'a Surface> {
    let entry = mesh.surface_of(triangle)?;
    program.carriers().get(entry.surface as usize)
}

/// Puts triangles on surfaces that may carry faces: where a way of meshing has found others on
/// planes that only part space, which rounding makes, on that of a triangle beside them.
pub(crate) fn put_on_carriers(program: &Program, mesh: &mut Mesh) {
    let count = program.carriers().len();
    let is_carrier = |entry: u32| (mesh.surfaces[entry as usize].surface as usize) < count;
    let Some(first) = (0..mesh.surfaces.len() as u32).find(|&entry| is_carrier(entry)) else {
        return;
    };
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    let others = (0..mesh.triangles.len()).filter(|&t| !is_carrier(mesh.triangle_surfaces[t]));
    let mut others: Vec<usize> = others.collect();
    while !others.is_empty() {
        let mut beside: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        for &triangle in &others {
            let sides = sides(mesh.triangles[triangle]);
            beside.extend(sides.map(|[from, to]| ([to, from], u32::MAX)));
        }
        let is_carrier = |entry: u32| (mesh.surfaces[entry as usize].surface as usize) < count;
        for (triangle, &entry) in mesh.triangles.iter().zip(&mesh.triangle_surfaces) {
            for side in sides(*triangle).into_iter().filter(|_| is_carrier(entry)) {
                beside.entry(side).and_modify(|known| *known = entry);
            }
        }
        let before = others.len();
        let mut found = Vec::new();
        others.retain(|&triangle| {
            let mut known = sides(mesh.triangles[triangle])
                .into_iter()
                .map(|[from, to]| beside[&[to, from]]);
            let entry = known.find(|&entry| entry != u32::MAX);
            found.extend(entry.map(|entry| (triangle, entry)));
            entry.is_none()
        });
        if others.len() == before {
            // Nothing of them is beside any other.
            found.extend(others.drain(..).map(|triangle| (triangle, first)));
        }
        for (triangle, entry) in found {
            mesh.triangle_surfaces[triangle] = entry;
        }
    }
}

/// The outward unit normals at the corners of every triangle: the gradient of
/// its surface there, on the side to which the triangle faces; the triangle's
/// own normal where the gradient vanishes (a cone's apex).
pub(crate) fn corner_normals<'a>(
    mesh: &Mesh,
    surface_of: impl Fn(usize) -> Option<&'a Surface> + Sync,
) -> Vec<[Vec3; 3]> {
    (0..mesh.triangles.len())
        .into_par_iter()
        .map(|triangle| {
            let [p, q, r] = mesh.corners(triangle);
            let facing = (q - p).cross(r - p).normalize_or_zero();
            let Some(surface) = surface_of(triangle) else {
                return [facing.as_vec3(); 3];
            };
            // One side for the whole triangle: at a corner the surface may
            // already have turned away from the chord.
            let middle = surface.gradient((p + q + r) / 3.0);
            let outward = if middle.dot(facing) < 0.0 { -1.0 } else { 1.0 };
            [p, q, r].map(|corner| {
                let gradient = surface.gradient(corner);
                gradient
                    .try_normalize()
                    .map_or(facing, |normal| outward * normal)
                    .as_vec3()
            })
        })
        .collect()
}

/// The largest distances, to first order, of a vertex and of a triangle's
/// centroid from the surface that the triangle is assigned to.
pub(crate) fn largest_distances(program: &Program, mesh: &Mesh) -> (f64, f64) {
    let distance = |surface: &Surface, point: DVec3| {
        let value = surface.value(point).abs();
        let gradient = surface.gradient(point).length();
        if gradient > 0.0 {
            value / gradient
        } else {
            value.sqrt()
        }
    };
    (0..mesh.triangles.len())
        .into_par_iter()
        .filter_map(|triangle| {
            let surface = surface_of(program, mesh, triangle)?;
            let [p, q, r] = mesh.corners(triangle);
            let vertices = [p, q, r].map(|corner| distance(surface, corner));
            let centroid = distance(surface, (p + q + r) / 3.0);
            Some((vertices.into_iter().fold(0.0, f64::max), centroid))
        })
        .reduce(|| (0.0, 0.0), |a, b| (a.0.max(b.0), a.1.max(b.1)))
}

/// The edges between triangles of different surfaces whose normals there
/// differ by more than `angle` radians, joined into polylines: from branching
/// to branching, or closed (the first vertex again at the end). In a fixed
/// order.
pub(crate) fn feature_edges(program: &Program, mesh: &Mesh, angle: f64) -> Vec<Vec<u32>> {
    let mut sides: FxHashMap<(u32, u32), usize> = FxHashMap::default();
    let mut edges: Vec<(u32, u32)> = Vec::new();
    let least_cosine = elementary::cos(angle);
    // Only vertices on several surfaces have such edges.
    let on_feature = vertices_on_several(mesh);
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let (u, v) = (corners[i], corners[(i + 1) % 3]);
            if !(on_feature[u as usize] && on_feature[v as usize]) {
                continue;
            }
            let key = (u.min(v), u.max(v));
            let Some(&other) = sides.get(&key) else {
                sides.insert(key, triangle);
                continue;
            };
            let surface = |t: usize| mesh.surface_of(t).map(|entry| entry.surface);
            if surface(other) != surface(triangle)
                && edge_cosine(program, mesh, other, triangle, key) < least_cosine
            {
                edges.push(key);
            }
        }
    }
    edges.sort_unstable();
    polylines(&edges)
}

/// For every vertex whether triangles of more than one surface meet there.
fn vertices_on_several(mesh: &Mesh) -> Vec<bool> {
    const NONE: u32 = u32::MAX;
    let mut first = vec![NONE; mesh.positions.len()];
    let mut several = vec![false; mesh.positions.len()];
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        let Some(entry) = mesh.surface_of(triangle) else {
            continue;
        };
        for &vertex in corners {
            let known = &mut first[vertex as usize];
            if *known == NONE {
                *known = entry.surface;
            } else if *known != entry.surface {
                several[vertex as usize] = true;
            }
        }
    }
    several
}

/// The cosine of the angle between the two surfaces' outward normals at the
/// middle of an edge.
fn edge_cosine(
    program: &Program,
    mesh: &Mesh,
    first: usize,
    second: usize,
    (u, v): (u32, u32),
) -> f64 {
    let middle = 0.5 * (mesh.positions[u as usize] + mesh.positions[v as usize]);
    let normal = |triangle: usize| {
        let [p, q, r] = mesh.corners(triangle);
        let facing = (q - p).cross(r - p);
        let gradient =
            surface_of(program, mesh, triangle).map_or(facing, |surface| surface.gradient(middle));
        let normal = gradient.normalize_or_zero();
        if normal.dot(facing) < 0.0 {
            -normal
        } else {
            normal
        }
    };
    normal(first).dot(normal(second))
}

/// Joins edges into polylines.
fn polylines(edges: &[(u32, u32)]) -> Vec<Vec<u32>> {
    let mut around: FxHashMap<u32, Vec<usize>> = FxHashMap::default();
    for (index, &(u, v)) in edges.iter().enumerate() {
        around.entry(u).or_default().push(index);
        around.entry(v).or_default().push(index);
    }
    let mut used = vec![false; edges.len()];
    let mut lines = Vec::new();
    let mut follow = |start: u32, edge: usize, used: &mut [bool]| {
        let mut line = vec![start];
        let (mut at, mut edge) = (start, edge);
        loop {
            used[edge] = true;
            let (u, v) = edges[edge];
            at = if u == at { v } else { u };
            line.push(at);
            let next = around[&at].iter().copied().find(|&e| !used[e]);
            match next {
                Some(next) if around[&at].len() == 2 => edge = next,
                _ => break,
            }
        }
        lines.push(line);
    };
    // From ends and branchings first; what is left then is closed.
    for closed in [false, true] {
        for (index, &(u, v)) in edges.iter().enumerate() {
            for start in [u, v] {
                if !used[index] && (closed || around[&start].len() != 2) {
                    follow(start, index, &mut used);
                }
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshSurface;
    use crate::solid::Solid;

    #[test]
    fn triangles_on_planes_that_part_space_take_the_surface_beside_them() {
        let program = Program::lower(&Solid::cuboid([1.0; 3])).expect("valid");
        let beyond = program.carriers().len() as u32;
        let on = |surface: u32| MeshSurface {
            surface,
            ..MeshSurface::default()
        };
        // A strip, of which the two in the middle are on none, and one on its own.
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO; 9],
            triangles: vec![[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [6, 7, 8]],
            surfaces: vec![on(beyond), on(1), on(2)],
            triangle_surfaces: vec![1, 0, 0, 2, 0],
            ..Mesh::default()
        };
        put_on_carriers(&program, &mut mesh);
        assert_eq!(mesh.triangle_surfaces, [1, 1, 2, 2, 1]);
    }
}
