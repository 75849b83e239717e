//! How far a solid's boundary is moved where its surfaces are.
//!
//! In its faces as far as they are. An edge is moved farther: where two surfaces with outward
//! normals m and n are moved outward by d, by d / c, c = |m + n| / 2, to first order. That is
//! much at an edge as sharp as a blade's; where the surfaces go on into each other it is d,
//! although the curve in which they meet may move by any length. If they touch, c = 0, the wall
//! between them opens as their curvatures do: with κ half the sum of these across the edge, the
//! edge is moved by δ with c δ + κ δ² / 2 = d. A corner of three faces is moved by d / c if c is
//! the distance of the origin from the triangle of their normals, where no two of them are nearer.
//!
//! All this is to first order in d, and of contacts without an edge nothing is known: two balls
//! that overlap by d meet in a circle of radius √(R d), and none is left once they touch.

use glam::DVec3;

use crate::mesh::Mesh;
use crate::numeric::tolerance::{NEAR, TELLS_SIDE, TOUCHING};
use crate::surface::Surface;
use crate::surface::round::{cosine, distance_from_origin};

/// How far the boundary of which this is a mesh is moved, if each surface is by as far as is said
/// under its number: the farthest that an edge or corner is, and where. Zero if none is.
///
/// Takes n log n steps for n triangles.
pub(super) fn farthest(mesh: &Mesh, surfaces: &[Surface], moves: &[f64]) -> (f64, DVec3) {
    let at = |vertex: u32| mesh.positions[vertex as usize];
    let mut farthest = (0.0, DVec3::ZERO);
    let mut note = |distance: f64, vertex: u32| {
        if distance > farthest.0 {
            farthest = (distance, at(vertex));
        }
    };
    let mut at_vertices: Vec<(u32, Face)> = Vec::new();
    for ([from, to], triangles) in edges(mesh) {
        let faces = triangles.map(|triangle| Face::of(mesh, triangle as usize, surfaces));
        let [Some(one), Some(other)] = faces else {
            continue;
        };
        if one.surface == other.surface {
            continue;
        }
        let faces = [one, other];
        let moved = most_moved(&faces, moves);
        for vertex in [from, to] {
            note(of_edge(faces, at(to) - at(from), at(vertex), moved), vertex);
            at_vertices.extend(faces.map(|face| (vertex, face)));
        }
    }
    let key = |&(vertex, face): &(u32, Face)| (vertex, face.surface);
    at_vertices.sort_by_key(key);
    at_vertices.dedup_by_key(|entry| key(entry));
    for corner in at_vertices.chunk_by(|a, b| a.0 == b.0) {
        if let &[(vertex, a), (_, b), (_, c)] = corner {
            let faces = [a, b, c];
            note(
                of_corner(faces, at(vertex), most_moved(&faces, moves)),
                vertex,
            );
        }
    }
    farthest
}

/// How far one of these faces is moved at most.
fn most_moved(faces: &[Face<'_>], moves: &[f64]) -> f64 {
    let moved = faces.iter().map(|face| moves[face.surface]);
    moved.fold(0.0, f64::max)
}

/// A face at an edge or corner.
#[derive(Clone, Copy)]
struct Face<'a> {
    surface: usize,
    function: &'a Surface,
    /// 1 if the function grows outward, else -1.
    outward: f64,
}

impl<'a> Face<'a> {
    /// That of a triangle, if it tells which side is outside.
    fn of(mesh: &Mesh, triangle: usize, surfaces: &'a [Surface]) -> Option<Self> {
        let surface = mesh.surface_of(triangle)?.surface as usize;
        let function = surfaces.get(surface)?;
        let [p, q, r] = mesh.corners(triangle);
        let gradient = function.gradient((p + q + r) / 3.0);
        let facing = cosine((q - p).cross(r - p), gradient);
        (facing.abs() >= TELLS_SIDE).then_some(Self {
            surface,
            function,
            outward: facing.signum(),
        })
    }

    fn normal(&self, at: DVec3) -> DVec3 {
        self.outward * self.function.gradient(at).normalize_or_zero()
    }

    /// How fast the normal turns along a unit vector, in radians.
    fn bend(&self, at: DVec3, along: DVec3) -> f64 {
        (self.function.curvature_along(along) / self.function.gradient(at).length()).abs()
    }
}

/// The sides that two triangles have in common which do not come from one primitive's surface.
fn edges(mesh: &Mesh) -> Vec<([u32; 2], [u32; 2])> {
    let sides = (0u32..).zip(&mesh.triangles);
    let sides = sides.flat_map(|(triangle, &[a, b, c])| {
        [[a, b], [b, c], [c, a]].map(|[p, q]| ([p.min(q), p.max(q)], triangle))
    });
    let mut sides: Vec<([u32; 2], u32)> = sides.collect();
    sides.sort_unstable();
    let group = |triangle: u32| mesh.triangle_surfaces.get(triangle as usize);
    let pairs = sides.chunk_by(|a, b| a.0 == b.0);
    let pairs = pairs.filter_map(|side| match *side {
        [(ends, one), (_, other)] if group(one) != group(other) => Some((ends, [one, other])),
        _ => None,
    });
    pairs.collect()
}

/// How far an edge is moved at a point of it.
fn of_edge(faces: [Face<'_>; 2], edge: DVec3, at: DVec3, moved: f64) -> f64 {
    let [m, n] = faces.map(|face| face.normal(at));
    let c = 0.5 * (m + n).length();
    let across = edge.cross(m - n).normalize_or_zero();
    let bend = 0.5 * (faces[0].bend(at, across) + faces[1].bend(at, across));
    let root = c + (c * c + 2.0 * bend * moved).sqrt();
    if moved > 0.0 { 2.0 * moved / root } else { 0.0 }
}

/// How far a corner is moved of which no two faces make as sharp an edge; none of others, nor
/// where two of them touch: these open as they bend.
fn of_corner(faces: [Face<'_>; 3], at: DVec3, moved: f64) -> f64 {
    let normals @ [a, b, c] = faces.map(|face| face.normal(at));
    let of_edges = [[a, b], [b, c], [c, a]].map(|sides| distance_from_origin(&sides));
    let of_edges = of_edges.into_iter().fold(f64::INFINITY, f64::min);
    let of_corner = distance_from_origin(&normals);
    if of_edges > TOUCHING && of_corner < (1.0 - NEAR) * of_edges {
        moved / of_corner
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::sweeps::one_in;
    use crate::{Mesher, Program, Solid};

    /// A mesh, and the farthest that its edges are moved if each surface is by as much.
    fn meshed(solid: &Solid, tolerance: Option<f64>, moved: f64) -> (Mesh, f64) {
        let program = Program::lower(solid).expect("a valid solid");
        let mesher = tolerance.map_or_else(Mesher::new, |t| Mesher::new().tolerance(t));
        let mesh = mesher.mesh(&program).expect("a mesh").mesh;
        let moves = vec![moved; program.surfaces().len()];
        let (distance, _) = farthest(&mesh, program.surfaces(), &moves);
        (mesh, distance)
    }

    fn distance_to(mesh: &Mesh, point: DVec3) -> f64 {
        let corners = (0..mesh.triangles.len()).map(|t| mesh.corners(t).map(|c| c - point));
        let distances = corners.map(|corners| distance_from_origin(&corners));
        distances.fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256 / one_in(4) as u32))]

        /// Of tetrahedra, some as sharp as blades and needles.
        #[test]
        fn corners_and_edges_are_moved_no_farther_than_is_said(
            corners in prop::array::uniform4(prop::array::uniform3(-1.0..1.0f64)),
            thin in -3.0..0.0f64,
            moves in prop::array::uniform4(-1.0..1.0f64),
        ) {
            const MOVED: f64 = 1e-7;
            let thin = DVec3::new(1.0, 1.0, 10f64.powf(thin));
            let corners = corners.map(|c| DVec3::from(c) * thin);
            let center = corners.iter().sum::<DVec3>() / 4.0;
            let planes = [0, 1, 2, 3].map(|k| {
                let [a, b, c] = [1, 2, 3].map(|j| corners[(k + j) % 4]);
                let normal = (b - a).cross(c - a).normalize_or_zero();
                let normal = normal * normal.dot(a - center).signum();
                (normal, normal.dot(a))
            });
            let depth = |&(normal, offset): &(DVec3, f64)| offset - normal.dot(center);
            prop_assume!(planes.iter().all(|plane| depth(plane) > 1e-4));
            let solid = |by: [f64; 4]| {
                let sides = [0, 1, 2, 3].map(|k| {
                    Solid::half_space(planes[k].0, planes[k].1 + MOVED * by[k])
                });
                sides.into_iter().reduce(|a, b| a & b).expect("four")
            };
            let (before, said) = meshed(&solid([0.0; 4]), None, MOVED);
            for by in [moves, [1.0; 4]] {
                let (after, _) = meshed(&solid(by), None, MOVED);
                let one_way = after.positions.iter().map(|&p| distance_to(&before, p));
                let other_way = before.positions.iter().map(|&p| distance_to(&after, p));
                let moved = one_way.chain(other_way).fold(0.0, f64::max);
                prop_assert!(moved <= 1.01 * said + 1e-12, "{moved}, said {said}");
                // All of them outward the sharpest corner is as far as it can be.
                prop_assert!(by != [1.0; 4] || said <= 1.2 * moved, "{moved}, said {said}");
            }
        }
    }

    /// Of the rim in which two balls meet, down to those that touch.
    #[test]
    fn rims_of_lenses_are_moved_as_far_as_is_said() {
        const MOVED: f64 = 1e-6;
        for half_thickness in [0.1, 1e-2, 1e-3, 1e-4] {
            let off = 1.0 - half_thickness;
            let ball = |side: f64| Solid::sphere(1.0).translate([0.0, 0.0, side * off]);
            let lens = ball(1.0) & ball(-1.0);
            let (_, said) = meshed(&lens, Some(0.01 * half_thickness), MOVED);
            let rim = |radius: f64| (radius * radius - off * off).sqrt();
            let moved = rim(1.0 + MOVED) - rim(1.0);
            assert!(
                (0.9 * moved..1.1 * moved).contains(&said),
                "{moved}, said {said}"
            );
        }
    }

    /// Where faces go on into each other, none is moved farther than its surface.
    #[test]
    fn smooth_edges_are_moved_as_far_as_their_surfaces() {
        const MOVED: f64 = 1e-6;
        let (_, said) = meshed(&Solid::capsule(0.5, 0.0..1.0), Some(0.01), MOVED);
        assert!((said - MOVED).abs() < 1e-3 * MOVED, "{said}");
    }
}
