//! Which face of the exact boundary each triangle of a mesh is part of.

use csg::brep::Face;
use csg::{Brep, Color, Mesh};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// No face.
pub(crate) const NONE: u32 = u32::MAX;

/// What a triangle and its face have in common: the surface, and the look.
type Key<'a> = (usize, Option<&'a str>, Option<[u32; 4]>);

fn look(color: Option<Color>) -> Option<[u32; 4]> {
    color.map(
        |Color {
             rgb: [r, g, b],
             alpha,
         }| [r, g, b, alpha].map(f32::to_bits),
    )
}

fn key_of<'a>(face: &Face<'a>) -> Key<'a> {
    let origin = face.origin();
    (
        face.surface_index(),
        origin.name.as_deref(),
        look(origin.color),
    )
}

/// For each triangle the number of its face, or [`NONE`] where that cannot be told.
///
/// Mesh and boundary are made apart, but have the same surfaces. Where several faces lie on
/// one, the connected parts of its triangles are told apart by the faces' vertices, which are
/// vertices of the mesh, too; a part without any is that of the nearest points.
pub(crate) fn of_triangles(mesh: &Mesh, brep: &Brep) -> Vec<u32> {
    let mut candidates: FxHashMap<Key<'_>, Vec<Face<'_>>> = FxHashMap::default();
    for face in brep.faces() {
        candidates.entry(key_of(&face)).or_default().push(face);
    }
    let mut faces = vec![NONE; mesh.triangles.len()];
    let mut shared: FxHashMap<Key<'_>, Vec<u32>> = FxHashMap::default();
    for (triangle, face) in faces.iter_mut().enumerate() {
        let Some(surface) = mesh.surface_of(triangle) else {
            continue;
        };
        let key = (
            surface.surface as usize,
            surface.name.as_deref(),
            look(surface.color),
        );
        match candidates.get(&key).map_or(&[][..], |found| found) {
            [] => {}
            [only] => *face = only.id().index() as u32,
            _ => shared.entry(key).or_default().push(triangle as u32),
        }
    }
    for (key, triangles) in &shared {
        tell_apart(mesh, &candidates[key], triangles, &mut faces);
    }
    faces
}

/// Gives triangles of one surface to the faces on it.
fn tell_apart(mesh: &Mesh, candidates: &[Face<'_>], triangles: &[u32], faces: &mut [u32]) {
    let part_of = parts(mesh, triangles);
    let mut corners: Vec<(f64, DVec3, u32)> = Vec::with_capacity(3 * triangles.len());
    // No model has its vertices across this.
    let order = DVec3::new(0.611_317, 0.274_093, 0.742_391);
    for (triangle, &part) in triangles.iter().zip(&part_of) {
        for corner in mesh.corners(*triangle as usize) {
            corners.push((corner.dot(order), corner, part));
        }
    }
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    let largest = corners.iter().map(|(_, p, _)| p.abs().max_element());
    let near = 1e-7 * largest.fold(0.0, f64::max);
    let mut face_of_part: FxHashMap<u32, u32> = FxHashMap::default();
    let mut unplaced = Vec::new();
    for face in candidates {
        let mut votes: FxHashMap<u32, usize> = FxHashMap::default();
        let ends = face.edges().filter_map(|edge| edge.vertices());
        for point in ends.flatten().map(|vertex| vertex.point()) {
            let along = point.dot(order);
            let first = corners.partition_point(|corner| corner.0 < along - near);
            let within = corners[first..].iter().take_while(|c| c.0 <= along + near);
            let mut found: Vec<u32> = within
                .filter(|(_, corner, _)| corner.distance(point) <= near)
                .map(|&(_, _, part)| part)
                .collect();
            found.sort_unstable();
            found.dedup();
            for part in found {
                *votes.entry(part).or_default() += 1;
            }
        }
        // (Parts that touch the face in a corner have fewer of its vertices.)
        match votes.into_iter().max_by_key(|&(part, votes)| (votes, part)) {
            Some((part, _)) => {
                face_of_part.insert(part, face.id().index() as u32);
            }
            None => unplaced.push(face),
        }
    }
    for face in unplaced {
        let points = face.points();
        let distance = |corner: DVec3| {
            let squares = points.iter().map(|point| point.distance_squared(corner));
            squares.fold(f64::INFINITY, f64::min)
        };
        let free = corners.iter().filter(|c| !face_of_part.contains_key(&c.2));
        let nearest = free.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        if let Some(&(_, _, part)) = nearest {
            face_of_part.insert(part, face.id().index() as u32);
        }
    }
    for (triangle, part) in triangles.iter().zip(&part_of) {
        faces[*triangle as usize] = face_of_part.get(part).copied().unwrap_or(NONE);
    }
}

/// For each of some triangles the connected part of them that it is in: the place of one of
/// its triangles.
fn parts(mesh: &Mesh, triangles: &[u32]) -> Vec<u32> {
    let mut above: Vec<u32> = (0..triangles.len() as u32).collect();
    fn root(above: &mut [u32], mut k: u32) -> u32 {
        while above[k as usize] != k {
            above[k as usize] = above[above[k as usize] as usize];
            k = above[k as usize];
        }
        k
    }
    let mut beside: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for (k, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = mesh.triangles[*triangle as usize];
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let edge = [from.min(to), from.max(to)];
            let other = *beside.entry(edge).or_insert(k as u32);
            let (one, other) = (root(&mut above, k as u32), root(&mut above, other));
            above[one.max(other) as usize] = one.min(other);
        }
    }
    (0..triangles.len() as u32)
        .map(|k| root(&mut above, k))
        .collect()
}

#[cfg(test)]
mod tests {
    use csg::{BoundaryOptions, Mesher, Program, Solid};

    use super::*;

    /// The triangles of each face cover it: their area is the face's but for the chords.
    fn check(solid: &Solid) {
        let program = Program::lower(solid).expect("valid");
        let brep = program.boundary(&BoundaryOptions::new()).expect("decided");
        let mesher = Mesher::new().tolerance(1e-4);
        let mesh = mesher.mesh(&program).expect("a mesh").mesh;
        let faces = of_triangles(&mesh, &brep);
        let mut areas = vec![0.0; brep.faces().len()];
        for (triangle, face) in faces.iter().enumerate() {
            let [a, b, c] = mesh.corners(triangle);
            areas[*face as usize] += 0.5 * (b - a).cross(c - a).length();
        }
        for (face, area) in brep.faces().zip(areas) {
            let exact = face.area().value;
            assert!((area - exact).abs() < 2e-3 * exact, "{area} of {exact}");
        }
    }

    #[test]
    fn faces_on_one_surface_are_told_apart() {
        // Two ends of one rod, whose sides are one cylinder and whose caps two planes; the
        // cube's faces with the rod's ends stay whole.
        let rod = Solid::cylinder(0.3, -2.0..2.0).named("rod");
        check(&(Solid::cube(1.0) | rod.clone()));
        // Four corners of a plate are left on each plane, and faces without vertices: rings.
        let cross = Solid::cuboid([0.4, 3.0, 3.0]) | Solid::cuboid([3.0, 0.4, 3.0]);
        check(&(Solid::cuboid([2.0, 2.0, 0.5]) - cross));
        let balls = Solid::sphere(1.0) - Solid::cuboid([3.0, 3.0, 0.5]);
        check(&balls);
        let groove = Solid::cylinder(1.0, -1.0..1.0)
            - (Solid::cylinder(2.0, -0.1..0.1) - Solid::cylinder(0.8, -1.0..1.0));
        check(&groove);
    }
}
