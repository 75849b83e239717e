//! Separates triangles that run through each other though their surfaces do not: cuts
//! those of their sides that stray farthest from surfaces and curves, at points of
//! them, or sides [beside](super::beside) each other's corners. So are those that
//! face into the solid.
//!
//! All vertices being on the solid's boundary, and all triangles in its topology,
//! the mesh runs through itself no more once it is fine enough there, and none of it
//! is folded.

use super::beside::sides_beside;
use super::fine::Fine;
use super::goal::Goal;
use super::grow::Grower;
use super::half_edges::{HalfEdges, first_of, halves_of};
use super::hand_back::hand_back;
use super::outcome::Outcome;
use super::round::Round;
use super::shape::{faces_in, facing};
use super::side::{Side, halved, together};
use super::surfaced::Surfaced;
use crate::program::Surface;

/// How triangles that run through each other are parted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parting {
    /// By cuts of the sides that stray farthest: in the end all is fine enough, where
    /// surfaces do not touch.
    Farthest,
    /// By cuts [beside](super::beside) corners of the other triangle, and of the sides
    /// that stray farthest where there are none: where surfaces touch.
    Beside,
}

/// Cuts sides of the pairs of triangles, and notes in `outcome` how far what comes
/// of it strays; false if there is nothing to be cut.
pub(crate) fn separate(
    surfaced: &mut Surfaced,
    surfaces: &[Surface],
    goal: &Goal,
    pairs: &[[u32; 2]],
    parting: Parting,
    outcome: &mut Outcome,
) -> bool {
    let precision = surfaced.precision;
    let Some(mut mesh) = HalfEdges::new(surfaced, surfaces) else {
        return false;
    };
    mesh.fix_contacts();
    let sides = pairs
        .iter()
        .flat_map(|&pair| sides_of(&mesh, pair, parting, precision))
        .collect();
    let sides = together(&mesh, sides);
    let mut grower = Grower::new(&mut mesh, goal, precision);
    grower.outcome = std::mem::take(outcome);
    let is_changed = grower.cut_sides(&sides);
    *outcome = std::mem::take(&mut grower.outcome);
    hand_back(&mesh, &Fine::default(), surfaced);
    is_changed
}

/// The triangles that face against the rest of their face: into the solid.
pub(crate) fn folded(surfaced: &Surfaced, surfaces: &[Surface]) -> Vec<u32> {
    // (Mostly there are none, which is told without the faces.)
    if face_alike(surfaced, surfaces) {
        return Vec::new();
    }
    HalfEdges::new(surfaced, surfaces).map_or_else(Vec::new, |mesh| {
        let is_folded = |&triangle: &u32| {
            let half = first_of(triangle);
            faces_in(
                mesh.surface(half),
                mesh.region(half),
                mesh.corners(triangle),
            )
        };
        (0..mesh.triangle_count()).filter(is_folded).collect()
    })
}

/// Whether of each group all triangles that have an area face the same way.
fn face_alike(surfaced: &Surfaced, surfaces: &[Surface]) -> bool {
    let mut ways = vec![0.0f64; surfaced.surface_of_group.len()];
    let of_group = surfaced.surface_of_group.iter();
    let rounds: Vec<Option<Round>> = of_group
        .map(|&surface| Round::of(&surfaces[surface as usize]))
        .collect();
    let mut triangles = surfaced.triangles.iter().zip(&surfaced.groups);
    triangles.all(|(triangle, &group)| {
        let surface = &surfaces[surfaced.surface_of_group[group as usize] as usize];
        let corners = triangle.map(|v| surfaced.positions[v as usize]);
        let way = facing(surface, rounds[group as usize].as_ref(), corners);
        let known = &mut ways[group as usize];
        if *known == 0.0 {
            *known = way;
        }
        way * *known >= 0.0
    })
}

/// The sides of two triangles to be cut.
fn sides_of(mesh: &HalfEdges<'_>, pair: [u32; 2], parting: Parting, precision: f64) -> Vec<Side> {
    let beside = match parting {
        Parting::Farthest => Vec::new(),
        Parting::Beside => sides_beside(mesh, pair, precision),
    };
    if beside.is_empty() {
        farthest_sides(mesh, pair, precision)
    } else {
        beside
    }
}

/// The sides of two triangles that stray farthest.
fn farthest_sides(mesh: &HalfEdges<'_>, pair: [u32; 2], precision: f64) -> Vec<Side> {
    /// Of the farthest one's distance.
    const FAR: f64 = 0.5;
    let halves = pair.iter().flat_map(|&t| halves_of(t));
    let sides = halves.filter_map(|half| halved(mesh, half, precision));
    let mut sides: Vec<(f64, Side)> = sides.filter(|side| side.0 > 100.0 * precision).collect();
    let farthest = sides.iter().map(|side| side.0).fold(0.0, f64::max);
    sides.retain(|side| side.0 >= FAR * farthest);
    sides.into_iter().map(|(_, side)| side).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::mesh::Mesh;
    use crate::program::Program;
    use crate::solid::Solid;
    use crate::tessellate::deviation::of_triangle;

    /// A sphere about the origin and one in it, each of so many times the triangles of
    /// an octahedron.
    pub fn spheres(radii: [f64; 2], center: DVec3, rows: [u32; 2]) -> (Surfaced, Vec<Surface>) {
        let inner = Solid::sphere(radii[1]).translate(center);
        let solid = Solid::sphere(radii[0]) - inner;
        let program = Program::lower(&solid).expect("a valid solid");
        let surfaces = program.surfaces().to_vec();
        let mut all = Surfaced {
            surface_of_group: [0, 1].into(),
            precision: 1e-12,
            ..Surfaced::default()
        };
        let centers = [DVec3::ZERO, center];
        for (group, ((radius, center), rows)) in
            (0u32..).zip(radii.into_iter().zip(centers).zip(rows))
        {
            let on = surfaces
                .iter()
                .position(|s| s.value(center + radius * DVec3::X).abs() < 1e-14);
            Arc::make_mut(&mut all.surface_of_group)[group as usize] =
                on.expect("its surface") as u32;
            octahedron(radius, center, rows, group, &mut all);
        }
        (all, surfaces)
    }

    /// Adds an octahedron of which each triangle is cut into `rows` rows of
    /// triangles, all vertices at a distance from the centre; the second one's
    /// triangles face inwards.
    fn octahedron(radius: f64, center: DVec3, rows: u32, group: u32, all: &mut Surfaced) {
        let mut number_of = std::collections::HashMap::new();
        for signs in 0..8u32 {
            let sign = |axis: u32| 1.0 - 2.0 * f64::from(signs >> axis & 1);
            let signs = DVec3::new(sign(0), sign(1), sign(2));
            let is_mirrored = (signs.x * signs.y * signs.z < 0.0) != (group == 1);
            let mut vertex = |i: u32, j: u32| {
                let place = DVec3::new(f64::from(i), f64::from(j), f64::from(rows - i - j));
                let place = signs * place + DVec3::ZERO;
                let key = place.to_array().map(|k| k as i32);
                *number_of.entry(key).or_insert_with(|| {
                    all.positions.push(center + radius * place.normalize());
                    all.positions.len() as u32 - 1
                })
            };
            let mut triangles = Vec::new();
            for i in 0..rows {
                for j in 0..rows - i {
                    triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                    if i + j + 1 < rows {
                        triangles.push([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
                    }
                }
            }
            for [a, b, c] in triangles {
                all.triangles
                    .push(if is_mirrored { [a, c, b] } else { [a, b, c] });
                all.groups.push(group);
            }
        }
    }

    fn mesh(surfaced: &Surfaced) -> Mesh {
        Mesh::new(surfaced.positions.clone(), surfaced.triangles.clone())
    }

    pub fn goal(tolerance: f64) -> Goal {
        Goal {
            tolerance,
            promised: tolerance,
            even_curves: false,
            angle: None,
            tight: rustc_hash::FxHashMap::default(),
        }
    }

    /// The long chords of one sphere run through another one just below it.
    #[test]
    fn spheres_that_cross_by_their_chords_are_separated() {
        for (radii, rows) in [
            ([1.0, 0.97], [4, 9]),
            ([1.0, 0.9], [2, 12]),
            ([1.0, 0.99], [5, 8]),
        ] {
            let (mut surfaced, surfaces) = spheres(radii, DVec3::ZERO, rows);
            assert!(mesh(&surfaced).check().is_manifold());
            let goal = goal(0.2);
            let mut outcome = Outcome::default();
            let before = mesh(&surfaced).self_intersections();
            assert!(before.len() > 20, "{radii:?}: {}", before.len());
            let mut pairs = before;
            for _ in 0..14 {
                if pairs.is_empty() {
                    break;
                }
                assert!(separate(
                    &mut surfaced,
                    &surfaces,
                    &goal,
                    &pairs,
                    Parting::Farthest,
                    &mut outcome
                ));
                pairs = mesh(&surfaced).self_intersections();
            }
            assert_eq!(pairs, [[0; 2]; 0], "{radii:?}");
            let made = mesh(&surfaced);
            assert!(made.check().is_manifold());
            assert_eq!(made.check().components, 2);
            // All vertices are where they belong, and the outcome says how far
            // what was made strays.
            let mut farthest = 0.0f64;
            for (corners, &group) in surfaced.triangles.iter().zip(&surfaced.groups) {
                let corners = corners.map(|c| surfaced.positions[c as usize]);
                for corner in corners {
                    assert!((corner.length() - radii[group as usize]).abs() < 1e-14);
                }
                let surface = surfaced.surface_of_group[group as usize] as usize;
                farthest = farthest.max(of_triangle(&surfaces[surface], corners));
            }
            assert_eq!(outcome.unkept, [], "{radii:?}");
            assert!(farthest < 0.2, "{farthest}");
        }
    }

    /// How many pairs of triangles of two spheres that touch still cross after some
    /// rounds.
    fn left(parting: Parting, radius: f64, rows: [u32; 2]) -> usize {
        let touching = (1.0 - radius) * DVec3::new(0.6, 0.48, 0.64);
        let (mut surfaced, surfaces) = spheres([1.0, radius], touching, rows);
        let mut pairs = mesh(&surfaced).self_intersections();
        assert!(pairs.len() > 10, "{}", pairs.len());
        let (goal, mut outcome) = (goal(0.2), Outcome::default());
        for _ in 0..14 {
            if pairs.is_empty() {
                break;
            }
            let (all, outcome) = (&mut surfaced, &mut outcome);
            assert!(separate(all, &surfaces, &goal, &pairs, parting, outcome));
            pairs = mesh(&surfaced).self_intersections();
        }
        assert_eq!(outcome.unkept, [], "{radius}");
        assert!(mesh(&surfaced).check().is_manifold());
        pairs.len()
    }

    /// Next to where they touch chords of both cross however short they are.
    #[test]
    fn spheres_that_touch_are_parted_beside_each_others_corners() {
        for (radius, rows) in [(0.7, [2, 3]), (0.8, [2, 5]), (0.9, [3, 4]), (0.9, [4, 4])] {
            assert_ne!(left(Parting::Farthest, radius, rows), 0, "{radius}");
            assert_eq!(left(Parting::Beside, radius, rows), 0, "{radius}");
        }
    }

    /// Half a ball: of its surface the upper half of the octahedron's triangles, and
    /// a fan of them on the plane below. All sides but those of the fan stray alike.
    pub fn half_ball() -> (Surfaced, Vec<Surface>) {
        let solid = Solid::sphere(1.0) & Solid::half_space([0.0, 0.0, -1.0], 0.0);
        let surfaces = Program::lower(&solid).expect("valid").surfaces().to_vec();
        let plane = surfaces.iter().position(Surface::is_plane);
        let plane = plane.expect("a plane") as u32;
        let (top, middle) = (4, 5);
        let rim = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
        let next = |k: u32| (k + 1) % 4;
        let upper = (0..4).map(|k| [k, next(k), top]);
        let lower = (0..4).map(|k| [next(k), k, middle]);
        let all = Surfaced {
            positions: rim.into_iter().chain([DVec3::Z, DVec3::ZERO]).collect(),
            triangles: upper.chain(lower).collect(),
            groups: vec![0, 0, 0, 0, 1, 1, 1, 1],
            surface_of_group: [1 - plane, plane].into(),
            precision: 1e-12,
            ..Surfaced::default()
        };
        (all, surfaces)
    }

    /// The new vertices after a triangle was cut next to itself, as if it were
    /// folded.
    fn cuts(triangle: u32) -> Vec<DVec3> {
        let (mut surfaced, surfaces) = half_ball();
        assert!(mesh(&surfaced).check().is_manifold());
        let before = surfaced.positions.clone();
        let goal = goal(1.0);
        let pairs = [[triangle; 2]];
        let mut outcome = Outcome::default();
        assert!(separate(
            &mut surfaced,
            &surfaces,
            &goal,
            &pairs,
            Parting::Farthest,
            &mut outcome
        ));
        assert!(mesh(&surfaced).check().is_manifold());
        let is_new = |p: &DVec3| before.iter().all(|q| q.distance(*p) > 1e-9);
        surfaced.positions.into_iter().filter(is_new).collect()
    }

    #[test]
    fn the_sides_that_stray_farthest_are_cut() {
        let on_rim = DVec3::new(0.5f64.sqrt(), 0.5f64.sqrt(), 0.0);
        let inside = [DVec3::X, DVec3::Y].map(|p| (p + DVec3::Z).normalize());
        let are = |found: Vec<DVec3>, wanted: &[DVec3]| {
            let has = |p: &DVec3| found.iter().any(|q| q.distance(*p) < 1e-14);
            found.len() == wanted.len() && wanted.iter().all(has)
        };
        assert!(are(cuts(0), &[on_rim, inside[0], inside[1]]));
        assert!(are(cuts(4), &[on_rim]));
    }
}
