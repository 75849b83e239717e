//! Bodies of a mesh that are the same but for where they are and how they are turned.

use csg::Mesh;
use glam::{DMat3, DVec3};
use rustc_hash::FxHashMap;

use crate::parts::unit_normals;

/// Places that are the same differ by no more than this share of the coordinate that is farthest
/// from 0: they are computed to rounding, which is a 2^-53th of it, and some digits are lost where
/// surfaces meet at small angles.
pub(crate) const OF_COORDINATES: f64 = 1.0 / (1_u64 << 36) as f64;

/// Nor by more than this share of the body's own size.
pub(crate) const OF_SIZE: f64 = 1.0 / (1_u64 << 22) as f64;

/// Normals that are the same differ by no more than this: they are of single precision.
const OF_NORMALS: f64 = 1.0 / (1_u64 << 20) as f64;

/// How many half-edges of a body are tried for one of another. (It keeps bodies of many triangles
/// that are nearly alike from taking long.)
const TRIED: usize = 64;

/// No triangle, vertex or half-edge.
const NONE: u32 = u32::MAX;

/// Where a body is that is the same as another: its places are those of the other one, turned
/// about their centroid and moved.
pub(crate) struct Copy {
    pub rotation: DMat3,
    /// A vertex of the first body and the one that it becomes, for all vertices.
    pub vertices: Vec<(u32, u32)>,
    /// All triangles of the body, ascending.
    pub triangles: Vec<u32>,
}

/// A body that is there several times.
pub(crate) struct Repeat {
    /// All triangles of the first one, ascending.
    pub triangles: Vec<u32>,
    pub copies: Vec<Copy>,
}

/// Finds the bodies (connected parts) that are there several times: of the same triangles, with
/// the same labels, the same places up to one rotation and one translation, and normals that turn
/// with them. Mirrored ones are others.
///
/// Which vertex becomes which follows from a single pair of half-edges, as a connected surface
/// is walked through from there; pairs are tried by the lengths of their triangles' sides.
pub(crate) fn repeats(mesh: &Mesh, labels: &[u32]) -> Vec<Repeat> {
    let bodies = connected(mesh);
    let mut kinds: FxHashMap<(usize, Option<u32>), Vec<usize>> = FxHashMap::default();
    for (index, body) in bodies.iter().enumerate() {
        let label = body.iter().map(|&triangle| labels[triangle as usize]).min();
        kinds.entry((body.len(), label)).or_default().push(index);
    }
    let mut kinds: Vec<Vec<usize>> = kinds.into_values().filter(|kind| kind.len() > 1).collect();
    kinds.sort();
    if kinds.is_empty() {
        return Vec::new();
    }
    let largest = |size: f64, place: &DVec3| size.max(place.abs().max_element());
    let mut matcher = Matcher {
        mesh,
        labels,
        twins: twins(mesh),
        images: vec![NONE; mesh.triangles.len()],
        vertices: vec![NONE; mesh.positions.len()],
        origins: vec![NONE; mesh.positions.len()],
        rounding: OF_COORDINATES * mesh.positions.iter().fold(0.0, largest),
    };
    let mut found = Vec::new();
    for kind in kinds {
        let mut known: Vec<(Body, Vec<Copy>)> = Vec::new();
        for index in kind {
            let body = Body::of(mesh, &bodies[index]);
            let same = known.iter_mut().find_map(|(first, copies)| {
                let copy = matcher.copy(first, &body)?;
                Some((copies, copy))
            });
            match same {
                Some((copies, copy)) => copies.push(copy),
                None => known.push((body, Vec::new())),
            }
        }
        let repeated = known.into_iter().filter(|(_, copies)| !copies.is_empty());
        found.extend(repeated.map(|(body, copies)| Repeat {
            triangles: body.triangles.to_vec(),
            copies,
        }));
    }
    found.sort_by_key(|repeat| repeat.triangles[0]);
    found
}

/// The triangles of each connected part.
pub(crate) fn connected(mesh: &Mesh) -> Vec<Vec<u32>> {
    let components = mesh.components();
    let mut bodies = vec![Vec::new(); components.count];
    for (triangle, component) in components.of_triangles.iter().enumerate() {
        if let Some(component) = component {
            bodies[*component as usize].push(triangle as u32);
        }
    }
    bodies
}

/// For each half-edge (three of a triangle after each other) the opposite one; `NONE` where there
/// is none or not just one.
fn twins(mesh: &Mesh) -> Vec<u32> {
    let count = 3 * mesh.triangles.len();
    let ends = |half: usize| {
        let corners = mesh.triangles[half / 3];
        (corners[half % 3], corners[(half % 3 + 1) % 3])
    };
    let mut all: FxHashMap<(u32, u32), u32> = FxHashMap::default();
    all.reserve(count);
    for half in 0..count {
        let entry = all.entry(ends(half)).or_insert(half as u32);
        if *entry != half as u32 {
            *entry = NONE;
        }
    }
    let twin = |half| {
        let (from, to) = ends(half);
        all.get(&(to, from)).copied().unwrap_or(NONE)
    };
    (0..count).map(twin).collect()
}

/// A body as it is compared.
struct Body<'a> {
    triangles: &'a [u32],
    centroid: DVec3,
    /// The root mean square of its vertices' distances from their centroid, each counted as often
    /// as triangles have it. Where all places are within a distance, so are these of two bodies.
    spread: f64,
    /// The greatest of these distances.
    radius: f64,
    /// The half-edge that is tried with those of others, once it is known.
    start: Option<u32>,
}

impl<'a> Body<'a> {
    fn of(mesh: &Mesh, triangles: &'a [u32]) -> Self {
        let corners = || triangles.iter().flat_map(|&t| mesh.corners(t as usize));
        let count = 3.0 * triangles.len() as f64;
        // About a corner, so that little is lost far from the origin.
        let first = mesh.corners(triangles[0] as usize)[0];
        let centroid = first + corners().map(|p| p - first).sum::<DVec3>() / count;
        let squares = corners().map(|p| p.distance_squared(centroid));
        Self {
            triangles,
            centroid,
            spread: (squares.clone().sum::<f64>() / count).sqrt(),
            radius: squares.fold(0.0, f64::max).sqrt(),
            start: None,
        }
    }
}

/// The lengths of a triangle's sides, from one of its half-edges on.
fn sides(mesh: &Mesh, half: u32) -> [f64; 3] {
    let corners = mesh.corners(half as usize / 3);
    [0, 1, 2].map(|k| {
        let [from, to] = [k, k + 1].map(|k| corners[next(half, k) as usize % 3]);
        from.distance(to)
    })
}

/// The half-edge that follows another one in its triangle.
fn next(half: u32, steps: u32) -> u32 {
    half - half % 3 + (half % 3 + steps) % 3
}

struct Matcher<'a> {
    mesh: &'a Mesh,
    labels: &'a [u32],
    twins: Vec<u32>,
    /// For each triangle the half-edge that its first one becomes.
    images: Vec<u32>,
    /// For each vertex the one that it becomes, and the other way.
    vertices: Vec<u32>,
    origins: Vec<u32>,
    /// How far places that are the same may be from each other.
    rounding: f64,
}

impl Matcher<'_> {
    fn copy(&mut self, first: &mut Body, other: &Body) -> Option<Copy> {
        let tolerance = self.rounding.min(OF_SIZE * first.radius);
        if (first.spread - other.spread).abs() > 2.0 * tolerance {
            return None;
        }
        let start = match first.start {
            Some(start) => start,
            None => self.rare(first, tolerance),
        };
        first.start = Some(start);
        let wanted = sides(self.mesh, start);
        let label = self.labels[start as usize / 3];
        let halves = other.triangles.iter().flat_map(|&t| 3 * t..3 * t + 3);
        let alike = halves.filter(|&half| {
            self.labels[half as usize / 3] == label && self.same_sides(half, wanted, tolerance)
        });
        // Those that are turned least come first: a ball is not turned without need.
        let ends = |half: u32, body: &Body| {
            [half, next(half, 1)].map(|half| self.origin(half) - body.centroid)
        };
        let [from, to] = ends(start, first);
        let mut candidates: Vec<(f64, u32)> = alike
            .map(|half| {
                let [other_from, other_to] = ends(half, other);
                let turned = from.distance_squared(other_from) + to.distance_squared(other_to);
                (turned, half)
            })
            .collect();
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        candidates.into_iter().take(TRIED).find_map(|(_, half)| {
            let vertices = self.walk(start, half, first.triangles.len(), tolerance);
            let copy = vertices.and_then(|vertices| {
                let rotation = self.rotation(first, other, &vertices, tolerance)?;
                let triangles = other.triangles.to_vec();
                self.normals_turn(first, &rotation).then_some(Copy {
                    rotation,
                    vertices,
                    triangles,
                })
            });
            self.forget(first, other);
            copy
        })
    }

    /// Where a half-edge begins.
    fn origin(&self, half: u32) -> DVec3 {
        let vertex = self.mesh.triangles[half as usize / 3][half as usize % 3];
        self.mesh.positions[vertex as usize]
    }

    /// Distances of places that are within a tolerance are within twice as much.
    fn same_sides(&self, half: u32, wanted: [f64; 3], tolerance: f64) -> bool {
        let found = sides(self.mesh, half);
        (0..3).all(|k| (found[k] - wanted[k]).abs() <= 2.0 * tolerance)
    }

    /// A half-edge whose length few others have.
    fn rare(&self, body: &Body, tolerance: f64) -> u32 {
        let halves = body.triangles.iter().flat_map(|&t| 3 * t..3 * t + 3);
        let mut all: Vec<(u32, f64, u32)> = halves
            .map(|half| {
                let label = self.labels[half as usize / 3];
                (label, sides(self.mesh, half)[0], half)
            })
            .collect();
        all.sort_by(|a, b| {
            (a.0.cmp(&b.0))
                .then(a.1.total_cmp(&b.1))
                .then(a.2.cmp(&b.2))
        });
        let alike =
            |a: &(u32, f64, u32), b: &(u32, f64, u32)| a.0 == b.0 && b.1 - a.1 <= 4.0 * tolerance;
        let runs = all.chunk_by(alike);
        let rarest = runs.min_by_key(|run| run.len());
        rarest.map_or(3 * body.triangles[0], |run| run[0].2)
    }

    /// Walks through two bodies at once, from a half-edge of each; gives the vertices that
    /// correspond if all `count` triangles do.
    fn walk(
        &mut self,
        start: u32,
        image: u32,
        count: usize,
        tolerance: f64,
    ) -> Option<Vec<(u32, u32)>> {
        let mut stack = vec![(start, image)];
        let mut pairs = Vec::new();
        let mut seen = 0;
        while let Some((half, image)) = stack.pop() {
            // What the triangle's first half-edge becomes.
            let first = next(image, 3 - half % 3);
            let known = &mut self.images[half as usize / 3];
            if *known != NONE {
                if *known != first {
                    return None;
                }
                continue;
            }
            *known = first;
            seen += 1;
            let label = |half: u32| self.labels[half as usize / 3];
            if label(half) != label(image)
                || !self.same_sides(image, sides(self.mesh, half), tolerance)
            {
                return None;
            }
            for step in 0..3 {
                let (half, image) = (next(half, step), next(image, step));
                let from = |half: u32| self.mesh.triangles[half as usize / 3][half as usize % 3];
                let (vertex, becomes) = (from(half), from(image));
                let vertex_image = &mut self.vertices[vertex as usize];
                let origin = &mut self.origins[becomes as usize];
                if *vertex_image == NONE && *origin == NONE {
                    (*vertex_image, *origin) = (becomes, vertex);
                    pairs.push((vertex, becomes));
                } else if *vertex_image != becomes || *origin != vertex {
                    return None;
                }
                match (self.twins[half as usize], self.twins[image as usize]) {
                    (NONE, NONE) => {}
                    (NONE, _) | (_, NONE) => return None,
                    twins => stack.push(twins),
                }
            }
        }
        (seen == count).then_some(pairs)
    }

    /// Makes ready for the next walk.
    fn forget(&mut self, first: &Body, other: &Body) {
        for &triangle in first.triangles.iter().chain(other.triangles) {
            self.images[triangle as usize] = NONE;
            for vertex in self.mesh.triangles[triangle as usize] {
                self.vertices[vertex as usize] = NONE;
                self.origins[vertex as usize] = NONE;
            }
        }
    }

    /// The rotation that brings each vertex to where its image is: none at all if that does.
    fn rotation(
        &self,
        first: &Body,
        other: &Body,
        pairs: &[(u32, u32)],
        tolerance: f64,
    ) -> Option<DMat3> {
        let arms = |&(from, to): &(u32, u32)| {
            let place = |vertex: u32| self.mesh.positions[vertex as usize];
            (place(from) - first.centroid, place(to) - other.centroid)
        };
        let fits = |turn: &DMat3| {
            let near = |pair| {
                let (from, to) = arms(pair);
                (*turn * from).distance(to) <= tolerance
            };
            pairs.iter().all(near)
        };
        if fits(&DMat3::IDENTITY) {
            return Some(DMat3::IDENTITY);
        }
        // Axes along the longest arms, where rounding turns them least.
        let longest = |length: &dyn Fn(DVec3) -> f64| {
            let pairs = pairs.iter().map(arms);
            pairs.max_by(|a, b| length(a.0).total_cmp(&length(b.0)))
        };
        let (from, to) = longest(&|arm| arm.length_squared())?;
        let axes = [from, to].map(DVec3::try_normalize);
        let (from_axis, to_axis) = (axes[0]?, axes[1]?);
        let (from, to) = longest(&|arm| arm.cross(from_axis).length_squared())?;
        let frame = |axis: DVec3, arm: DVec3| {
            let side = axis.cross(arm).try_normalize()?;
            Some(DMat3::from_cols(axis, side, axis.cross(side)))
        };
        let turn = frame(to_axis, to)? * frame(from_axis, from)?.transpose();
        fits(&turn).then_some(turn)
    }

    /// Whether the normals at the corners turn as the places do.
    fn normals_turn(&self, first: &Body, turn: &DMat3) -> bool {
        first.triangles.iter().all(|&triangle| {
            let image = self.images[triangle as usize];
            let normals = |half: u32| unit_normals(self.mesh, half as usize / 3);
            let (Some(from), Some(to)) = (normals(3 * triangle), normals(image)) else {
                return true;
            };
            (0..3).all(|k| {
                let to = to[next(image, k) as usize % 3].as_dvec3();
                (*turn * from[k as usize].as_dvec3()).distance(to) <= OF_NORMALS
            })
        })
    }
}

/// The unit quaternion (x, y, z, w) of a rotation, with the component of largest size not below 0.
pub(crate) fn quaternion(turn: &DMat3) -> [f64; 4] {
    let [x, y, z, w] = glam::DQuat::from_mat3(turn).normalize().to_array();
    let all = [x, y, z, w];
    let largest = all.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs()));
    let sign = largest.unwrap_or(1.0).signum();
    all.map(|component| sign * component + 0.0)
}
