//! Solids from meshes that are nearly the boundary of one.
//!
//! Triangles are sewn to patches across the edges that two of them share, those that look
//! the other way than their neighbours turned, and gaps closed, so that each patch is a
//! shell. Which side of a shell is solid is told by how often the larger ones wind around
//! it (A. Jacobson, L. Kavan, O. Sorkine-Hornung, "Robust Inside-Outside Segmentation using
//! Generalized Winding Numbers", 2013); shells that run through others are united with
//! them, exactly.

use std::collections::VecDeque;
use std::fmt;

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::from_mesh::MeshFaults;
use super::polyhedron::triangles_of;
use super::tree::Solid;
use crate::mesh::Mesh;
use crate::mesh::shells::turns;
use crate::numeric::Welder;
use crate::numeric::tolerance::{NO_VOLUME, SEWN};

/// How many holes [`Repairs`] names.
const PLACES: usize = 8;

/// What [`Solid::repaired`] changed; nothing if the mesh bounded a solid.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Repairs {
    /// Triangles left out that name no vertex, or one that is no number.
    pub unusable: usize,
    /// Triangles left out that name a vertex twice, or are there twice: both, if they look
    /// opposite ways, as where two boxes stand side by side.
    pub spare: usize,
    /// Vertices at gaps that became one with another one beside them.
    pub sewn: usize,
    /// Triangles turned that looked the other way than their neighbours.
    pub turned: usize,
    /// How many holes were closed.
    pub holes: usize,
    /// Some of them: their middle, and how many edges they had.
    pub hole_places: Vec<(DVec3, usize)>,
    /// Shells left out that enclose nothing.
    pub flat_shells: usize,
    /// Shells turned whose triangles all looked inwards, though they are in no other.
    pub turned_shells: usize,
    /// All shells, if some of them ran through others, or lay in others that look the same way:
    /// they were united.
    pub united_shells: usize,
}

impl Repairs {
    /// Whether nothing was changed.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for Repairs {
    /// What was changed, each with how often.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let holes = match self.hole_places.first() {
            Some((p, edges)) => format!(
                "holes closed, first one of {edges} edges about ({:.6}, {:.6}, {:.6})",
                p.x, p.y, p.z
            ),
            None => String::new(),
        };
        let counts = [
            (self.unusable, "unusable triangles left out"),
            (self.spare, "triangles without area or there twice left out"),
            (self.sewn, "vertices at gaps joined to others beside them"),
            (
                self.turned,
                "triangles turned to look as their neighbours do",
            ),
            (self.holes, holes.as_str()),
            (self.flat_shells, "shells that enclose nothing left out"),
            (self.turned_shells, "shells that looked inwards turned"),
            (
                self.united_shells,
                "shells united, as some ran through others or lay in them",
            ),
        ];
        let said: Vec<String> = counts
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} x {what}"))
            .collect();
        if said.is_empty() {
            return f.write_str("nothing was changed");
        }
        f.write_str(&said.join("; "))
    }
}

impl Solid {
    /// The solid that a mesh nearly bounds, and what was changed to make it bound one: see
    /// [`Repairs`]. A mesh that bounds one is taken as it is, as by [`Solid::from_mesh`].
    ///
    /// Vertices at gaps are one if they are nearer than a millionth of the mesh's longest
    /// side; other holes are closed by triangles between their corners. What is enclosed once
    /// or more is solid, but for shells within others that look inwards: they are hollows.
    ///
    /// # Errors
    /// What is still wrong, as of the repaired mesh: a shell that runs through itself, or has
    /// one side only.
    pub fn repaired(mesh: &Mesh) -> Result<(Self, Repairs), Box<MeshFaults>> {
        let faults = match Self::from_mesh(mesh) {
            Ok(solid) => return Ok((solid, Repairs::default())),
            Err(faults) => faults,
        };
        let mut repairs = Repairs::default();
        let mut sewn = Sewn::new(mesh, &mut repairs);
        sewn.join_gaps(&mut repairs);
        sewn.leave_out_spare(&mut repairs);
        let mut shells = sewn.shells(&mut repairs);
        if shells.is_empty() {
            return Err(faults);
        }
        orient(&mut shells, &sewn.positions, &mut repairs);
        let triangles = shells.iter().flat_map(|shell| &shell.triangles);
        let whole = mesh_of(&sewn.positions, triangles.copied().collect());
        let faults = match Self::from_mesh(&whole) {
            Ok(solid) => return Ok((solid, repairs)),
            Err(faults) => faults,
        };
        if shells.len() == 1 {
            return Err(faults);
        }
        repairs.united_shells = shells.len();
        let mut all = Self::empty();
        for shell in shells {
            let hollow = shell.is_hollow;
            let solid = shell.solid(&sewn.positions)?;
            all = if hollow { all - solid } else { all | solid };
        }
        Ok((all, repairs))
    }
}

/// Triangles with the vertices that they share.
struct Sewn {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

fn ascending([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl Sewn {
    /// Of all triangles that can be used; vertices at the same place are one.
    fn new(mesh: &Mesh, repairs: &mut Repairs) -> Self {
        let mut first: FxHashMap<[u64; 3], u32> = FxHashMap::default();
        let same: Vec<u32> = (0..)
            .zip(&mesh.positions)
            .map(|(index, at)| {
                // Adding zero makes -0 and 0 the same.
                let key = at.to_array().map(|c| (c + 0.0).to_bits());
                *first.entry(key).or_insert(index)
            })
            .collect();
        let named = |&corner: &u32| {
            let vertex = *same.get(corner as usize)?;
            let is_number = mesh.positions[vertex as usize].is_finite();
            is_number.then_some(vertex)
        };
        let usable = mesh.triangles.iter().filter_map(|corners| {
            let [a, b, c] = corners.each_ref().map(named);
            Some([a?, b?, c?])
        });
        let triangles: Vec<[u32; 3]> = usable.collect();
        repairs.unusable = mesh.triangles.len() - triangles.len();
        Self {
            positions: mesh.positions.clone(),
            triangles,
        }
    }

    fn at(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    /// The triangles at each edge.
    fn edges(&self) -> FxHashMap<[u32; 2], SmallVec<[u32; 2]>> {
        let mut edges: FxHashMap<[u32; 2], SmallVec<[u32; 2]>> = FxHashMap::default();
        for (index, &triangle) in (0u32..).zip(&self.triangles) {
            for side in sides(triangle) {
                edges.entry(ascending(side)).or_default().push(index);
            }
        }
        edges
    }

    /// Makes vertices of open edges one with the first beside them.
    fn join_gaps(&mut self, repairs: &mut Repairs) {
        let open = self.edges().into_iter().filter(|(_, at)| at.len() == 1);
        let mut rim: Vec<u32> = open.flat_map(|(ends, _)| ends).collect();
        rim.sort_unstable();
        rim.dedup();
        let used = || self.triangles.iter().flatten().map(|&v| self.at(v));
        let low = used().fold(DVec3::INFINITY, DVec3::min);
        let high = used().fold(DVec3::NEG_INFINITY, DVec3::max);
        let near = SEWN * (high - low).max_element();
        if near == 0.0 {
            return;
        }
        let mut welder = Welder::new(near);
        let mut first: FxHashMap<u32, u32> = FxHashMap::default();
        let mut joined: FxHashMap<u32, u32> = FxHashMap::default();
        for vertex in rim {
            let first = *first
                .entry(welder.number(self.at(vertex)))
                .or_insert(vertex);
            if first != vertex {
                joined.insert(vertex, first);
            }
        }
        repairs.sewn = joined.len();
        for corner in self.triangles.iter_mut().flatten() {
            *corner = joined.get(corner).copied().unwrap_or(*corner);
        }
    }

    /// Leaves out triangles that name a vertex twice, or are there twice: both, if they look
    /// opposite ways.
    fn leave_out_spare(&mut self, repairs: &mut Repairs) {
        // The vertices in ascending order, and whether the triangle goes around them so.
        let named = |corners: [u32; 3]| {
            let first = corners.iter().min_by_key(|&&v| v).copied();
            let at = corners.iter().position(|&v| Some(v) == first).unwrap_or(0);
            let [a, b, c] = [0, 1, 2].map(|k| corners[(at + k) % 3]);
            ([a, b.min(c), b.max(c)], b < c)
        };
        let mut ways: FxHashMap<[u32; 3], i32> = FxHashMap::default();
        for &corners in &self.triangles {
            let (named, is_ascending) = named(corners);
            *ways.entry(named).or_default() += if is_ascending { 1 } else { -1 };
        }
        let before = self.triangles.len();
        self.triangles.retain(|&corners| {
            let (named, is_ascending) = named(corners);
            let [a, b, c] = named;
            let left = ways.get_mut(&named);
            a != b
                && b != c
                && left.is_some_and(|left| {
                    let is_wanted = if is_ascending { *left > 0 } else { *left < 0 };
                    // The first one.
                    *left = if is_wanted { 0 } else { *left };
                    is_wanted
                })
        });
        repairs.spare = before - self.triangles.len();
    }

    /// The patches, closed, of which all triangles look the same way; from the largest.
    fn shells(&mut self, repairs: &mut Repairs) -> Vec<Shell> {
        let edges = self.edges();
        let patch_of = self.turn(&edges, repairs);
        let patches = patch_of.iter().max().map_or(0, |&last| last as usize + 1);
        let mut of_patch = vec![Vec::new(); patches];
        for (&patch, &triangle) in patch_of.iter().zip(&self.triangles) {
            of_patch[patch as usize].push(triangle);
        }
        let size = self.positions.iter().filter(|p| p.is_finite());
        let size = size.map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let mut shells = Vec::with_capacity(patches);
        for mut triangles in of_patch {
            for hole in holes(&triangles) {
                let corners: Vec<DVec3> = hole.iter().map(|&v| self.at(v)).collect();
                let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
                repairs.holes += 1;
                if repairs.hole_places.len() < PLACES {
                    repairs.hole_places.push((middle, corners.len()));
                }
                let cap = triangles_of(&corners).into_iter();
                triangles.extend(cap.map(|cap| cap.map(|k| hole[k])));
            }
            let shell = Shell::new(&self.positions, triangles);
            if shell.volume.abs() > NO_VOLUME * size.powi(3) {
                shells.push(shell);
            } else {
                repairs.flat_shells += 1;
            }
        }
        shells.sort_by(|a, b| b.volume.abs().total_cmp(&a.volume.abs()));
        shells
    }

    /// Turns triangles so that all of a patch look the same way, as most of them do; the
    /// patch of each.
    fn turn(
        &mut self,
        edges: &FxHashMap<[u32; 2], SmallVec<[u32; 2]>>,
        repairs: &mut Repairs,
    ) -> Vec<u32> {
        const NONE: u32 = u32::MAX;
        let count = self.triangles.len();
        let mut patch_of = vec![NONE; count];
        let mut patch = 0;
        for first in 0..count as u32 {
            if patch_of[first as usize] != NONE {
                continue;
            }
            let (mut turned, mut all) = (Vec::new(), vec![first]);
            patch_of[first as usize] = patch;
            let mut waiting = VecDeque::from([first]);
            while let Some(triangle) = waiting.pop_front() {
                for side in sides(self.triangles[triangle as usize]) {
                    let [one, other] = edges[&ascending(side)][..] else {
                        continue;
                    };
                    let next = if one == triangle { other } else { one };
                    if patch_of[next as usize] != NONE {
                        continue;
                    }
                    patch_of[next as usize] = patch;
                    all.push(next);
                    waiting.push_back(next);
                    if sides(self.triangles[next as usize]).contains(&side) {
                        self.triangles[next as usize].reverse();
                        turned.push(next);
                    }
                }
            }
            repairs.turned += turned.len().min(all.len() - turned.len());
            if 2 * turned.len() > all.len() {
                for triangle in all {
                    self.triangles[triangle as usize].reverse();
                }
            }
            patch += 1;
        }
        patch_of
    }
}

/// The polygons that close the holes of a patch.
fn holes(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut balance: FxHashMap<[u32; 2], i32> = FxHashMap::default();
    for side in triangles.iter().flat_map(|&triangle| sides(triangle)) {
        let sign = if side[0] < side[1] { 1 } else { -1 };
        *balance.entry(ascending(side)).or_default() += sign;
    }
    // The edges that are missing, by where they start.
    let mut missing: Vec<[u32; 2]> = Vec::new();
    for ([a, b], sum) in balance {
        let way = if sum > 0 { [b, a] } else { [a, b] };
        missing.extend((0..sum.abs()).map(|_| way));
    }
    missing.sort_unstable();
    let mut onward: FxHashMap<u32, SmallVec<[u32; 2]>> = FxHashMap::default();
    for &[from, to] in missing.iter().rev() {
        onward.entry(from).or_default().push(to);
    }
    let mut holes = Vec::new();
    for &[start, _] in &missing {
        let mut path = vec![start];
        while let Some(&last) = path.last() {
            let Some(to) = onward.get_mut(&last).and_then(SmallVec::pop) else {
                break;
            };
            // Where the way comes back to itself it goes around one of them.
            match path.iter().position(|&v| v == to) {
                Some(k) => {
                    holes.push(path.drain(k..).collect());
                    path.push(to);
                }
                None => path.push(to),
            }
        }
    }
    holes
}

/// A closed surface.
struct Shell {
    triangles: Vec<[u32; 3]>,
    low: DVec3,
    high: DVec3,
    volume: f64,
    /// Whether what it encloses is not solid.
    is_hollow: bool,
}

impl Shell {
    fn new(positions: &[DVec3], triangles: Vec<[u32; 3]>) -> Self {
        let points = || triangles.iter().flatten().map(|&v| positions[v as usize]);
        let low = points().fold(DVec3::INFINITY, DVec3::min);
        let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
        let middle = 0.5 * (low + high);
        let volume = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| positions[v as usize] - middle);
            a.dot(b.cross(c)) / 6.0
        };
        Self {
            volume: triangles.iter().map(volume).sum(),
            triangles,
            low,
            high,
            is_hollow: false,
        }
    }

    fn turn(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.reverse());
        self.volume = -self.volume;
    }

    /// How often it winds around a point.
    fn winding(&self, positions: &[DVec3], point: DVec3) -> f64 {
        if point.cmplt(self.low).any() || point.cmpgt(self.high).any() {
            return 0.0;
        }
        let corners = self.triangles.iter();
        let corners = corners.map(|named| named.map(|v| positions[v as usize]));
        corners.map(|corners| turns(&corners, point)).sum()
    }

    /// Some points of it.
    fn samples(&self, positions: &[DVec3]) -> impl Iterator<Item = DVec3> {
        const COUNT: usize = 8;
        let some = self.triangles.iter();
        let some = some.step_by(self.triangles.len().div_ceil(COUNT));
        some.map(|corners| corners.map(|v| positions[v as usize]).iter().sum::<DVec3>() / 3.0)
    }

    /// What it encloses.
    fn solid(mut self, positions: &[DVec3]) -> Result<Solid, Box<MeshFaults>> {
        if self.volume < 0.0 {
            self.turn();
        }
        Solid::from_mesh(&mesh_of(positions, self.triangles))
    }
}

/// A mesh of the vertices that triangles name.
fn mesh_of(positions: &[DVec3], mut triangles: Vec<[u32; 3]>) -> Mesh {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    for corner in triangles.iter_mut().flatten() {
        *corner = used.partition_point(|v| v < corner) as u32;
    }
    let positions = used.iter().map(|&v| positions[v as usize]).collect();
    Mesh::new(positions, triangles)
}

/// Turns shells that look inwards, but for those within larger ones: these are hollows.
fn orient(shells: &mut [Shell], positions: &[DVec3], repairs: &mut Repairs) {
    for index in 0..shells.len() {
        let (larger, rest) = shells.split_at_mut(index);
        let shell = &mut rest[0];
        if shell.volume > 0.0 {
            continue;
        }
        let winding = |at: DVec3| -> f64 { larger.iter().map(|s| s.winding(positions, at)).sum() };
        let is_hollow = shell.samples(positions).all(|at| winding(at) > 0.5);
        shell.is_hollow = is_hollow;
        if !is_hollow {
            shell.turn();
            repairs.turned_shells += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Program;

    /// A box as eight vertices and twelve triangles.
    fn cuboid(low: [f64; 3], high: [f64; 3]) -> Mesh {
        let [low, high] = [DVec3::from(low), DVec3::from(high)];
        let corner = |k: usize| {
            let bit = |axis: usize| {
                if k >> axis & 1 == 1 {
                    high[axis]
                } else {
                    low[axis]
                }
            };
            DVec3::new(bit(0), bit(1), bit(2))
        };
        let faces = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let corners = (0..8).map(corner).collect();
        Mesh::from_polygons(corners, faces).expect("vertices that exist")
    }

    fn joined(meshes: &[Mesh]) -> Mesh {
        let mut all = Mesh::default();
        for mesh in meshes {
            let first = all.positions.len() as u32;
            all.positions.extend(&mesh.positions);
            let moved = mesh.triangles.iter().map(|t| t.map(|v| v + first));
            all.triangles.extend(moved);
        }
        all
    }

    fn turned(mut mesh: Mesh) -> Mesh {
        mesh.triangles.iter_mut().for_each(|t| t.reverse());
        mesh
    }

    fn volume(solid: &Solid) -> f64 {
        let program = Program::lower(solid).expect("valid");
        let boundary = program.boundary(&crate::BoundaryOptions::default());
        boundary.expect("a boundary").measure().volume.value
    }

    fn unit() -> Mesh {
        cuboid([0.0; 3], [1.0; 3])
    }

    fn check(mesh: &Mesh, wanted: f64, changed: &Repairs) {
        let (solid, repairs) = Solid::repaired(mesh).expect("a solid");
        assert_eq!(&repairs, changed, "{repairs}");
        let volume = volume(&solid);
        assert!((volume - wanted).abs() < 1e-9, "{volume}, not {wanted}");
    }

    #[test]
    fn a_solid_is_left_as_it_is() {
        check(&unit(), 1.0, &Repairs::default());
    }

    #[test]
    fn triangles_that_look_the_other_way_are_turned() {
        let mut mesh = unit();
        for k in [1, 4, 5, 9] {
            mesh.triangles[k].reverse();
        }
        let changed = Repairs {
            turned: 4,
            ..Repairs::default()
        };
        check(&mesh, 1.0, &changed);
        let changed = Repairs {
            turned_shells: 1,
            ..Repairs::default()
        };
        check(&turned(unit()), 1.0, &changed);
    }

    #[test]
    fn holes_are_closed() {
        let mut mesh = unit();
        mesh.triangles.truncate(10);
        let changed = Repairs {
            holes: 1,
            hole_places: vec![(DVec3::new(1.0, 0.5, 0.5), 4)],
            ..Repairs::default()
        };
        check(&mesh, 1.0, &changed);
        // Two that have a corner in common.
        let mut mesh = unit();
        mesh.triangles.remove(8);
        mesh.triangles.remove(2);
        let (solid, repairs) = Solid::repaired(&mesh).expect("a solid");
        assert_eq!(repairs.holes, 2, "{repairs}");
        assert!((volume(&solid) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn doubled_flat_and_unusable_triangles_are_left_out_and_gaps_sewn() {
        let mut mesh = unit();
        let again = mesh.triangles[3];
        mesh.triangles.push(again);
        mesh.triangles.push([again[1], again[0], again[2]]);
        mesh.triangles.push([0, 0, 1]);
        mesh.triangles.push([0, 1, 99]);
        mesh.positions.push(DVec3::NAN);
        mesh.triangles.push([0, 1, 8]);
        // A soup, to single precision, of which one corner is a little off.
        let corner = mesh.triangles[0][0] as usize;
        let beside = mesh.positions.len() as u32;
        mesh.positions.push(mesh.positions[corner] + 3e-7);
        mesh.triangles[0][0] = beside;
        let changed = Repairs {
            spare: 3,
            unusable: 2,
            sewn: 1,
            ..Repairs::default()
        };
        check(&mesh, 1.0, &changed);
    }

    #[test]
    fn shells_are_solids_hollows_and_islands() {
        let inner = |by: f64| cuboid([by; 3], [1.0 - by; 3]);
        let mut broken = inner(0.3);
        broken.triangles[0].reverse();
        let mesh = joined(&[unit(), turned(inner(0.1)), broken]);
        let changed = Repairs {
            turned: 1,
            ..Repairs::default()
        };
        check(&mesh, 1.0 - 0.8f64.powi(3) + 0.4f64.powi(3), &changed);
        // Through each other, one inside out.
        let beside = turned(cuboid([0.5, 0.25, 0.25], [1.5, 0.75, 0.75]));
        let changed = Repairs {
            turned_shells: 1,
            united_shells: 2,
            ..Repairs::default()
        };
        check(&joined(&[unit(), beside]), 1.125, &changed);
        // A wall within parts two of them, and a sheet encloses nothing.
        let mut halves = joined(&[unit(), cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0])]);
        halves.positions.push(DVec3::splat(5.0));
        let last = halves.positions.len() as u32 - 1;
        halves.triangles.push([0, 1, last]);
        let (solid, repairs) = Solid::repaired(&halves).expect("a solid");
        assert_eq!(repairs.flat_shells, 1, "{repairs}");
        assert!((volume(&solid) - 2.0).abs() < 1e-9, "{repairs}");
    }

    /// What cannot be told is still an error, with its place.
    #[test]
    fn shells_through_themselves_are_errors() {
        let mut mesh = unit();
        mesh.positions[7] = DVec3::new(-0.5, -0.5, -0.5);
        let faults = Solid::repaired(&mesh).expect_err("no solid");
        assert!(faults.crossings > 0, "{faults}");
        assert!(Solid::repaired(&Mesh::default()).is_err());
    }
}
