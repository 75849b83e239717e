//! Separates triangles that run through each other though their surfaces do not: cuts
//! those of their sides that stray farthest from surfaces and curves, at points of
//! them, or sides [beside](super::beside) each other's corners. So are those that
//! face into the solid.
//!
//! All vertices being on the solid's boundary, and all triangles in its topology,
//! the mesh runs through itself no more once it is fine enough there, and none of it
//! is folded.

use glam::DVec3;

use super::beside::sides_beside;
use super::fine::Fine;
use super::goal::Goal;
use super::grow::Grower;
use super::half_edges::{HalfEdges, first_of, halves_of};
use super::hand_back::hand_back;
use super::outcome::{Outcome, Unkept};
use super::shape::facing;
use super::side::{Side, halved, together};
use super::surfaced::Surfaced;
use crate::mesh::{Intersections, Mesh};
use crate::program::Surface;
use crate::surface::round::Round;

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

/// A mesh whose triangles run through each other or face into the solid, while they are
/// parted.
#[derive(Clone)]
pub(crate) struct Separation<'a> {
    mesh: HalfEdges<'a>,
    goal: &'a Goal,
    /// With how far what was cut strays.
    pub outcome: Outcome,
    /// The middle of the frame: whether triangles run through each other is asked about the
    /// true origin, as rounding decides where faces meet in a plane.
    origin: DVec3,
    intersections: Intersections,
    is_folded: Vec<bool>,
}

impl<'a> Separation<'a> {
    /// `None` if the mesh is no closed manifold.
    pub fn new(
        surfaced: &Surfaced,
        surfaces: &'a [Surface],
        goal: &'a Goal,
        outcome: Outcome,
        origin: DVec3,
    ) -> Option<Self> {
        let mesh = HalfEdges::new(surfaced, surfaces)?;
        let all = 0..mesh.triangle_count();
        Some(Self {
            intersections: Intersections::of(seen(&mesh, origin)),
            is_folded: all.map(|triangle| mesh.is_folded(triangle)).collect(),
            mesh,
            goal,
            outcome,
            origin,
        })
    }

    /// The pairs of triangles that run through each other; and twice each that faces into
    /// the solid.
    pub fn wrong(&self) -> Vec<[u32; 2]> {
        let folded = (0u32..).zip(&self.is_folded);
        let folded = folded.filter_map(|(triangle, &is_folded)| is_folded.then_some([triangle; 2]));
        let pairs = self.intersections.pairs().iter().copied();
        pairs.chain(folded).collect()
    }

    pub fn triangle_count(&self) -> usize {
        self.mesh.triangle_count() as usize
    }

    /// Cuts sides of pairs of triangles; false if there is nothing to be cut.
    pub fn cut(&mut self, pairs: &[[u32; 2]], parting: Parting) -> bool {
        let precision = self.mesh.precision;
        self.mesh.fix_contacts();
        let sides = pairs
            .iter()
            .flat_map(|&pair| sides_of(&self.mesh, pair, parting, precision));
        let sides = together(&self.mesh, sides.collect());
        let mut grower = Grower::new(&mut self.mesh, self.goal, precision);
        grower.outcome = std::mem::take(&mut self.outcome);
        let is_cut = grower.cut_sides(&sides);
        self.outcome = std::mem::take(&mut grower.outcome);
        let changed = self.intersections.update(seen(&self.mesh, self.origin));
        self.is_folded
            .resize(self.mesh.triangle_count() as usize, false);
        for triangle in changed {
            self.is_folded[triangle as usize] = self.mesh.is_folded(triangle);
        }
        is_cut
    }

    /// Notes where pairs of triangles still run through each other, or one faces into the
    /// solid, and hands back the mesh.
    pub fn finish(mut self, surfaced: &mut Surfaced) -> Outcome {
        for pair in self.wrong() {
            let place = self.mesh.corners(pair[0])[0];
            let reason = if pair[0] == pair[1] {
                Unkept::TurnedOver
            } else {
                Unkept::Crossing
            };
            self.outcome.unkept.push((reason, place));
            let surfaces = pair.map(|triangle| self.mesh.surface_id(first_of(triangle)));
            self.outcome.tighter.extend(surfaces);
        }
        hand_back(&self.mesh, &Fine::default(), surfaced);
        self.outcome
    }
}

/// The triangles of a mesh, with those that are gone, about the true origin.
fn seen(mesh: &HalfEdges<'_>, origin: DVec3) -> Mesh {
    let triangles = (0..mesh.triangle_count()).map(|triangle| {
        let is_gone = mesh.is_gone(triangle);
        if is_gone {
            [0; 3]
        } else {
            mesh.triangle(triangle)
        }
    });
    let positions = mesh.positions.iter().map(|&p| p + origin);
    Mesh::new(positions.collect(), triangles.collect())
}

/// The triangles that face against the rest of their face: into the solid.
pub(crate) fn folded(surfaced: &Surfaced, surfaces: &[Surface]) -> Vec<u32> {
    // (Mostly there are none, which is told without the faces.)
    if face_alike(surfaced, surfaces) {
        return Vec::new();
    }
    HalfEdges::new(surfaced, surfaces).map_or_else(Vec::new, |mesh| {
        let all = 0..mesh.triangle_count();
        all.filter(|&triangle| mesh.is_folded(triangle)).collect()
    })
}

/// Whether of each group all triangles that have an area face the same way.
fn face_alike(surfaced: &Surfaced, surfaces: &[Surface]) -> bool {
    let mut ways = vec![0.0f64; surfaced.surface_of_group.len()];
    let of_group = surfaced.surface_of_group.iter();
    let rounds: Vec<Option<Round>> = of_group
        .map(|&surface| Round::of(&surfaces[surface], surfaced.reach))
        .collect();
    let mut triangles = surfaced.triangles.iter().zip(&surfaced.groups);
    triangles.all(|(triangle, &group)| {
        let surface = &surfaces[surfaced.surface_of_group[group as usize]];
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

    use super::*;
    use crate::program::{Program, SurfaceId};
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
            surface_of_group: [0, 1].map(SurfaceId).into(),
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
                SurfaceId(on.expect("its surface") as u32);
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
            keeps_vertices: false,
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
            assert!(mesh(&surfaced).self_intersections().len() > 20, "{radii:?}");
            let outcome = parted(&mut surfaced, &surfaces, &goal, Parting::Farthest);
            assert_eq!(
                mesh(&surfaced).self_intersections(),
                [[0; 2]; 0],
                "{radii:?}"
            );
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
                let surface = surfaced.surface_of_group[group as usize].index();
                farthest = farthest.max(of_triangle(&surfaces[surface], corners));
            }
            assert_eq!(outcome.unkept, [], "{radii:?}");
            assert!(farthest < 0.2, "{farthest}");
        }
    }

    /// Parts the triangles of a mesh in some rounds.
    fn parted(
        surfaced: &mut Surfaced,
        surfaces: &[Surface],
        goal: &Goal,
        parting: Parting,
    ) -> Outcome {
        let origin = DVec3::ZERO;
        let separation = Separation::new(surfaced, surfaces, goal, Outcome::default(), origin);
        let mut separation = separation.expect("closed");
        for _ in 0..14 {
            let wrong = separation.wrong();
            if wrong.is_empty() {
                break;
            }
            assert!(separation.cut(&wrong, parting));
        }
        separation.finish(surfaced)
    }

    /// How many pairs of triangles of two spheres that touch still cross after some
    /// rounds.
    fn left(parting: Parting, radius: f64, rows: [u32; 2]) -> usize {
        let touching = (1.0 - radius) * DVec3::new(0.6, 0.48, 0.64);
        let (mut surfaced, surfaces) = spheres([1.0, radius], touching, rows);
        let before = mesh(&surfaced).self_intersections().len();
        assert!(before > 10, "{before}");
        let goal = goal(0.2);
        let outcome = parted(&mut surfaced, &surfaces, &goal, parting);
        let pairs = mesh(&surfaced).self_intersections();
        assert!(mesh(&surfaced).check().is_manifold());
        let mut others = outcome.unkept.iter();
        assert!(others.all(|(reason, _)| *reason == Unkept::Crossing));
        assert_eq!(outcome.unkept.len(), pairs.len());
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
            surface_of_group: [1 - plane, plane].map(SurfaceId).into(),
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
        let origin = DVec3::ZERO;
        let separation = Separation::new(&surfaced, &surfaces, &goal, Outcome::default(), origin);
        let mut separation = separation.expect("closed");
        assert!(separation.cut(&[[triangle; 2]], Parting::Farthest));
        separation.finish(&mut surfaced);
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
