//! Whole spheres as geodesic polyhedra.
//!
//! The sides of an octahedron or an icosahedron are cut into n equal arcs and its faces into
//! n² triangles, which are nearly equilateral and nearly alike. (Kenner, *Geodesic Math and
//! How to Use It*, 1976: class I.) Equilateral triangles of one size would be 4.84 r / d for
//! a sphere of radius r from which they stray by d; those of an icosahedron are 5.33 r / d.

use crate::elementary;
use std::ops::Range;
use std::sync::LazyLock;

use glam::DVec3;

use super::goal::Goal;
use super::outcome::Outcome;
use super::parts::Refined;
use super::surfaced::{BYTES_PER_FINISHED, Surfaced};
use super::whole::Whole;
use crate::control::Control;
use crate::error::Error;

/// After so many vertices it is asked whether to go on.
const VERTICES_PER_CHECK: usize = 1 << 14;

/// Sides are shorter than so many n-ths of the arc of an edge: less than 1.468 of an octahedron, whose
/// faces are larger than those of an icosahedron.
const LONGEST_SIDE: f64 = 1.47;

/// A regular polyhedron of triangles.
struct Regular {
    /// Of unit length.
    vertices: Vec<DVec3>,
    /// From the lesser vertex to the greater.
    edges: Vec<[u32; 2]>,
    /// Counter-clockwise as seen from outside.
    faces: Vec<[u32; 3]>,
    /// The angle of an edge at the centre.
    arc: f64,
    /// The triangles of n² to a face stray by more than this by n² of the radius.
    strays: f64,
}

/// The coarsest first.
static REGULAR: LazyLock<[Regular; 2]> = LazyLock::new(|| {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter();
    let octahedron = axes.flat_map(|axis| [axis, -axis]);
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let corners = [1.0, -1.0]
        .into_iter()
        .flat_map(|a| [[a, golden], [a, -golden]]);
    let icosahedron = corners.flat_map(|[a, b]| {
        let turns = [[0.0, a, b], [a, b, 0.0], [b, 0.0, a]];
        turns.map(|corner| DVec3::from(corner).normalize())
    });
    [
        Regular::of(octahedron.collect(), 0.42),
        Regular::of(icosahedron.collect(), 0.2),
    ]
});

impl Regular {
    /// Of unit vectors, of which those nearest to each other are joined.
    fn of(vertices: Vec<DVec3>, strays: f64) -> Self {
        /// Less than between the cosines of those that are joined and of others: 0.9 and 1.
        const GAP: f64 = 0.1;
        let count = vertices.len() as u32;
        let cosine = |a: u32, b: u32| vertices[a as usize].dot(vertices[b as usize]);
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
        let nearest = pairs
            .clone()
            .fold(-1.0f64, |most, [a, b]| most.max(cosine(a, b)));
        let is_joined = |a: u32, b: u32| cosine(a, b) > nearest - GAP;
        let edges: Vec<[u32; 2]> = pairs.filter(|&[a, b]| is_joined(a, b)).collect();
        let mut faces = Vec::new();
        for &[a, b] in &edges {
            for c in (b + 1..count).filter(|&c| is_joined(a, c) && is_joined(b, c)) {
                let [p, q, r] = [a, b, c].map(|corner| vertices[corner as usize]);
                let is_outward = p.dot(q.cross(r)) > 0.0;
                faces.push(if is_outward { [a, b, c] } else { [a, c, b] });
            }
        }
        Self {
            vertices,
            edges,
            faces,
            arc: elementary::acos(nearest),
            strays,
        }
    }

    /// How many triangles it becomes.
    fn count(&self, n: usize) -> usize {
        self.faces.len().saturating_mul(n.saturating_mul(n))
    }

    /// The least n for which the triangles are near enough to the unit sphere, and their sides
    /// short enough.
    fn fewest(&self, tolerance: f64, angle: Option<f64>) -> usize {
        let for_distance = (self.strays / tolerance).sqrt();
        let for_angle = angle.map_or(0.0, |angle| self.arc / angle);
        let mut n = (for_distance.max(for_angle) as usize).max(1);
        while !Geodesic::new(self, n).is_enough(tolerance, angle) {
            n += 1;
        }
        n
    }
}

/// A regular polyhedron with n² triangles to a face, on the unit sphere. A place on a face is
/// [i, j]: i steps from its first corner towards the second and j towards the third.
struct Geodesic<'a> {
    regular: &'a Regular,
    n: usize,
    /// Of so many n-ths of an edge's arc.
    sines: Vec<f64>,
}

impl<'a> Geodesic<'a> {
    fn new(regular: &'a Regular, n: usize) -> Self {
        let sine = |k: usize| elementary::sin(k as f64 / n as f64 * regular.arc);
        Self {
            regular,
            n,
            sines: (0..=n).map(sine).collect(),
        }
    }

    /// The triangles of a face, counter-clockwise.
    fn triangles(&self) -> impl Iterator<Item = [[usize; 2]; 3]> {
        self.triangles_within(0..self.n)
    }

    /// Those of which both steps of the first corners are in a range.
    fn triangles_within(&self, steps: Range<usize>) -> impl Iterator<Item = [[usize; 2]; 3]> {
        let n = self.n;
        steps.clone().flat_map(move |j| {
            (steps.start..steps.end.min(n - j)).flat_map(move |i| {
                let up = [[i, j], [i + 1, j], [i, j + 1]];
                let down = [[i + 1, j], [i + 1, j + 1], [i, j + 1]];
                std::iter::once(up).chain((i + j + 1 < n).then_some(down))
            })
        })
    }

    /// The point at a place of a face: between corners at equal arcs, and inside so that
    /// these go on.
    fn at(&self, face: [u32; 3], [i, j]: [usize; 2]) -> DVec3 {
        let [a, b, c] = face.map(|corner| self.regular.vertices[corner as usize]);
        let k = self.n - i - j;
        (self.sines[k] * a + self.sines[i] * b + self.sines[j] * c).normalize()
    }

    /// Whether triangles are near enough and sides short enough, by one of the faces, which
    /// are all alike.
    fn is_enough(&self, tolerance: f64, angle: Option<f64>) -> bool {
        let is_short = |angle: f64| {
            LONGEST_SIDE * self.regular.arc <= angle * self.n as f64
                || self.triangles().all(|places| self.longest(places) <= angle)
        };
        let mut in_middle = self.triangles_within(self.middle());
        in_middle.all(|places| self.strays(places) <= tolerance) && angle.is_none_or(is_short)
    }

    /// Where the triangles are that stray most, by the steps of their first corners.
    fn middle(&self) -> Range<usize> {
        let third = self.n / 3;
        third.saturating_sub(1)..(third + 2).min(self.n)
    }

    fn strays(&self, places: [[usize; 2]; 3]) -> f64 {
        let face = self.regular.faces[0];
        strays(DVec3::ZERO, 1.0, places.map(|place| self.at(face, place)))
    }

    /// The longest side, as an arc.
    fn longest(&self, places: [[usize; 2]; 3]) -> f64 {
        let [p, q, r] = places.map(|place| self.at(self.regular.faces[0], place));
        let sides = [(p, q), (q, r), (r, p)];
        let arcs = sides.map(|(a, b)| elementary::angle_between(a, b));
        arcs.into_iter().fold(0.0, f64::max)
    }

    /// All vertices: those of the regular polyhedron, those on its edges, those in its faces.
    fn vertices(&self) -> impl Iterator<Item = DVec3> {
        let Regular {
            vertices,
            edges,
            faces,
            ..
        } = self.regular;
        let on_edges = edges
            .iter()
            .flat_map(move |&[a, b]| (1..self.n).map(move |i| self.at([a, b, b], [i, 0])));
        let inside = faces.iter().flat_map(move |&face| {
            let rows = 1..self.n;
            rows.flat_map(move |j| (1..self.n - j).map(move |i| self.at(face, [i, j])))
        });
        vertices.iter().copied().chain(on_edges).chain(inside)
    }

    /// The number of the vertex at a place of a face.
    fn name(&self, face: usize, [i, j]: [usize; 2]) -> u32 {
        let Regular {
            vertices,
            edges,
            faces,
            ..
        } = self.regular;
        let (n, k) = (self.n, self.n - i - j);
        let [a, b, c] = faces[face];
        let on_edge = |from: u32, to: u32, steps: usize| {
            let ends = [from.min(to), from.max(to)];
            let edge = edges.iter().position(|&edge| edge == ends).unwrap_or(0);
            let steps = if from < to { steps } else { n - steps };
            (vertices.len() + edge * (n - 1) + steps - 1) as u32
        };
        match [k, i, j] {
            [_, 0, 0] => a,
            [0, _, 0] => b,
            [0, 0, _] => c,
            [_, _, 0] => on_edge(a, b, i),
            [_, 0, _] => on_edge(a, c, j),
            [0, _, _] => on_edge(b, c, j),
            _ => {
                // Rows of n - 2, n - 3, … places.
                let before = (j - 1) * (2 * n - j - 2) / 2;
                let inside = face * (n - 1) * (n - 2) / 2 + before + i - 1;
                (vertices.len() + edges.len() * (n - 1) + inside) as u32
            }
        }
    }
}

/// How far a triangle of a sphere strays from it: its plane is no nearer to the centre.
fn strays(center: DVec3, radius: f64, [p, q, r]: [DVec3; 3]) -> f64 {
    let normal = (q - p).cross(r - p).normalize();
    radius - normal.dot(p - center)
}

/// A part that is all of a sphere as a geodesic polyhedron; none of other parts.
pub(super) fn sphere(
    part: &Surfaced,
    whole: &Whole<'_>,
    goal: &Goal,
    control: &Control,
) -> Result<Option<Refined>, Error> {
    let region = &whole.region;
    let tolerance = goal.aim_on(region.surface);
    let Some(radius) = whole.radius() else {
        return Ok(None);
    };
    let share = tolerance / radius;
    // Before any of it is made.
    let least = REGULAR[1].count((REGULAR[1].strays / share).sqrt() as usize);
    control.check_triangles(least)?;
    control.check_memory(BYTES_PER_FINISHED.saturating_mul(least))?;
    let all = REGULAR
        .iter()
        .map(|regular| (regular, regular.fewest(share, goal.angle)));
    let Some((regular, n)) = all.min_by_key(|(regular, n)| regular.count(*n)) else {
        return Ok(None);
    };
    let geodesic = Geodesic::new(regular, n);
    let mut positions = Vec::with_capacity(regular.count(n) / 2 + 2);
    for (index, at) in geodesic.vertices().enumerate() {
        if index % VERTICES_PER_CHECK == 0 {
            control.check()?;
        }
        let Some(at) = region.project(whole.surface, whole.center + radius * at) else {
            return Ok(None);
        };
        positions.push(at);
    }
    let mut surfaced = Surfaced {
        positions,
        ..part.empty()
    };
    let mut outcome = Outcome::default();
    for face in 0..regular.faces.len() {
        control.check()?;
        for places in geodesic.triangles() {
            let names = places.map(|place| geodesic.name(face, place));
            let corners = names.map(|name| surfaced.positions[name as usize]);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let strays = strays(whole.center, radius, corners);
            outcome.note(strays, middle, &[region.surface], goal.promised);
            let [a, b, c] = names;
            surfaced
                .triangles
                .push(if whole.is_void { [a, c, b] } else { [a, b, c] });
        }
    }
    surfaced.groups = vec![region.group; surfaced.triangles.len()];
    Ok(Some(Refined { surfaced, outcome }))
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    /// With all numbers of triangles that are tried.
    #[test]
    fn those_that_stray_most_are_in_the_middle_and_sides_are_short() {
        let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        for regular in &*REGULAR {
            for n in (1..80).chain([199, 200, 201, 400]) {
                let geodesic = Geodesic::new(regular, n);
                let strays = |places| geodesic.strays(places);
                let all = most(&mut geodesic.triangles().map(strays));
                let middle = geodesic.triangles_within(geodesic.middle());
                let middle = most(&mut middle.map(strays));
                assert!(all <= middle + 1e-15, "{n}: {all:e} {middle:e}");
                let longest = most(&mut geodesic.triangles().map(|p| geodesic.longest(p)));
                let bound = LONGEST_SIDE * regular.arc / n as f64;
                assert!(longest < bound, "{n}: {longest} {bound}");
            }
        }
    }

    #[test]
    fn geodesic_polyhedra_are_closed_and_as_near_as_is_said() {
        for (regular, ideal) in REGULAR.iter().zip([7.0, 5.6]) {
            let euler = regular.vertices.len() + regular.faces.len() - regular.edges.len();
            assert_eq!(euler, 2);
            for tolerance in [1.0, 0.3, 0.1, 0.03, 0.01, 1e-3] {
                let n = regular.fewest(tolerance, None);
                let geodesic = Geodesic::new(regular, n);
                let vertices: Vec<DVec3> = geodesic.vertices().collect();
                let mut sides = HashSet::new();
                let mut farthest = 0.0f64;
                for (face, &corners) in regular.faces.iter().enumerate() {
                    for places in geodesic.triangles() {
                        let names = places.map(|place| geodesic.name(face, place));
                        let [p, q, r] = names.map(|name| vertices[name as usize]);
                        for (name, place) in names.into_iter().zip(places) {
                            let at = geodesic.at(corners, place);
                            assert!(vertices[name as usize].distance(at) < 1e-15);
                        }
                        assert!((q - p).cross(r - p).dot(p) > 0.0);
                        let samples = (0..=20).flat_map(|i| (0..=20 - i).map(move |j| (i, j)));
                        for (i, j) in samples {
                            let (i, j) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                            let point = p + i * (q - p) + j * (r - p);
                            farthest = farthest.max(1.0 - point.length());
                        }
                        let [a, b, c] = names;
                        for side in [[a, b], [b, c], [c, a]] {
                            assert!(sides.insert(side));
                        }
                    }
                }
                assert!(sides.iter().all(|&[a, b]| sides.contains(&[b, a])));
                assert_eq!(sides.len(), 3 * regular.count(n));
                assert_eq!(vertices.len(), regular.count(n) / 2 + 2);
                assert!(farthest <= tolerance, "{farthest} {tolerance}");
                // One less is not enough.
                assert!(n == 1 || !Geodesic::new(regular, n - 1).is_enough(tolerance, None));
                let fair = ideal / tolerance * (1.0 + 1.0 / n as f64).powi(2);
                assert!(
                    (regular.count(n) as f64) < fair.max(20.0),
                    "{tolerance}: {n}"
                );
            }
            let n = regular.fewest(1.0, Some(0.1));
            assert!(
                (regular.arc / 0.1..2.0 * regular.arc / 0.1).contains(&(n as f64)),
                "{n}"
            );
        }
    }
}
