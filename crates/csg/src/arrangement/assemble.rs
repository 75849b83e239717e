//! The triangles of all faces together: what two of them share must be an edge of
//! both, and only once.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::boundary::Boundary;
use super::contacts::{Contact, add_contacts};
use super::ids::{FaceId, HalfEdgeId};
use super::picture::{NONE, Picture, Slits};
use super::piece::Side;
use super::scene::Scene;
use super::unfold::unfold;
use crate::mesh::Mesh;
use crate::mesh::triangulate::{Named, Scratch, triangulate};
use crate::program::SurfaceId;
use crate::task::Task;
use crate::undecided::{Stop, Why};

/// Triangles of all faces. Where chords of curves run across each other, or along a
/// diagonal of another face, more of them are made.
pub(super) fn assemble(
    scene: &Scene<'_>,
    task: &Task<'_>,
    boundary: &mut Boundary,
    contacts: &[Contact],
) -> Result<Mesh, Stop> {
    const MOST_TRIES: u32 = 6;
    /// Splits make triangles Delaunay again, and with that other diagonals.
    const MOST_SPLITS: u32 = 4;
    let mut place = DVec3::ZERO;
    for tries in 1..=MOST_TRIES {
        let Cut {
            mut positions,
            contours,
            slits,
            triangles,
        } = Cut::new(scene, boundary)?;
        let mut triangles: Vec<_> = triangles.into_iter().flatten().collect();
        let faces = &boundary.faces;
        add_contacts(
            scene,
            contacts,
            faces,
            &slits,
            &mut triangles,
            &mut positions,
        );
        let mut coarse = Vec::new();
        for (side, triangles) in faces.iter().zip(&mut triangles) {
            unfold(scene, side, triangles, &mut positions, &slits, &mut coarse);
        }
        let coarse = boundary.curves_between(scene, &coarse);
        if tries < MOST_TRIES
            && !coarse.is_empty()
            && let Some(splits) = boundary.refine(scene, &coarse, &contours)
        {
            boundary.split_all(scene, &splits);
            continue;
        }
        let faces = &boundary.faces;
        let mut doubled = doubled_edges(&triangles, positions.len());
        for _ in 0..MOST_SPLITS {
            if doubled.is_empty() {
                break;
            }
            split_diagonals(
                scene,
                faces,
                &doubled,
                &slits,
                &mut triangles,
                &mut positions,
            );
            doubled = doubled_edges(&triangles, positions.len());
        }
        if doubled.is_empty() {
            return Ok(finished(task, faces, triangles, positions));
        }
        let doubled: Vec<[u32; 2]> = doubled.into_iter().map(|(ends, _)| ends).collect();
        place = positions[doubled[0][0] as usize];
        let chords = boundary.curves_between(scene, &doubled);
        if chords.is_empty() || boundary.split(scene, &chords).is_none() {
            break;
        }
    }
    Err(Stop::undecided(Why::Edge, place))
}

/// The mesh of all faces' triangles.
fn finished(
    task: &Task<'_>,
    faces: &[Side],
    triangles: Vec<Vec<[u32; 3]>>,
    positions: Vec<DVec3>,
) -> Mesh {
    let mut mesh = Mesh {
        positions,
        ..Mesh::default()
    };
    let mut entry_of: FxHashMap<(SurfaceId, u32), u32> = FxHashMap::default();
    for (side, triangles) in faces.iter().zip(triangles) {
        if triangles.is_empty() {
            continue;
        }
        let entry = *entry_of.entry((side.plane, side.look)).or_insert_with(|| {
            mesh.surfaces.push(task.mesh_surface(side.plane, side.look));
            mesh.surfaces.len() as u32 - 1
        });
        mesh.triangle_surfaces
            .extend(std::iter::repeat_n(entry, triangles.len()));
        mesh.triangles.extend(triangles);
    }
    mesh
}

/// Faces cut into triangles.
#[derive(Default)]
struct Cut {
    positions: Vec<DVec3>,
    /// Of each face its half-edges.
    contours: Vec<Vec<Vec<HalfEdgeId>>>,
    slits: Slits,
    /// Of each face; none where it could not be cut.
    triangles: Vec<Option<Vec<[u32; 3]>>>,
}

impl Cut {
    /// Cuts all faces, with more chords where these help.
    fn new(scene: &Scene<'_>, boundary: &mut Boundary) -> Result<Self, Stop> {
        /// Times that edges of faces that cannot be cut are split.
        const ROUNDS: u32 = 12;
        /// Times as many corners as at first, and as many besides, after which more are of no
        /// help: those that are split are not the ones in the way.
        const MOST_GROWTH: [usize; 2] = [4, 64];
        let mut most = usize::MAX;
        let mut cut = Self::default();
        let mut place = DVec3::ZERO;
        let mut faces: Vec<FaceId> = FaceId::all(boundary.faces.len()).collect();
        for round in 0..=ROUNDS {
            cut.cut_faces(scene, boundary, &faces);
            let failed = |&face: &FaceId| cut.triangles[face.index()].is_none();
            let failed: Vec<FaceId> = faces.iter().copied().filter(failed).collect();
            let Some(&first) = failed.first() else {
                return Ok(cut);
            };
            scene.go_on()?;
            let corner = cut.contours[first.index()][0][0];
            place = boundary.point(boundary.at(corner).from);
            let mut splits = Vec::new();
            for face in failed {
                let contours = &cut.contours[face.index()];
                boundary.part(scene, face, contours, &mut splits);
            }
            let corners = cut.contours.iter().flatten().map(Vec::len).sum::<usize>();
            if round == 0 {
                most = MOST_GROWTH[0] * corners + MOST_GROWTH[1];
            }
            if round == ROUNDS || splits.is_empty() || corners > most {
                break;
            }
            let split = boundary.split_all(scene, &splits);
            // The faces on both sides have more corners.
            let sides = split.iter().flat_map(|&edge| boundary.faces_of(edge));
            faces = sides.collect();
            faces.sort_unstable();
            faces.dedup();
        }
        Err(Stop::undecided(Why::Face, place))
    }

    /// Cuts some faces, for the first time or once more. Vertices keep their
    /// numbers when edges are split.
    fn cut_faces(&mut self, scene: &Scene<'_>, boundary: &Boundary, faces: &[FaceId]) {
        const MANY_FACES: usize = 64;
        let (fan_of, point_of) = boundary.fans();
        let points = point_of.iter().map(|&vertex| boundary.point(vertex));
        self.positions = points.collect();
        self.contours = boundary.contours();
        self.slits = boundary.slits(&fan_of);
        self.triangles.resize(boundary.faces.len(), None);
        let stage = scene.control.stage(faces.len() as u64, 0.9, 1.0);
        let cut_face = |scratch: &mut Scratch, face: FaceId| {
            scene.control.check().ok()?;
            stage.add(1);
            let side = &boundary.faces[face.index()];
            let name = |&half_edge: &HalfEdgeId| {
                let fan = fan_of[half_edge.index()];
                (scene.flatten(side, self.positions[fan as usize]), fan)
            };
            let flat: Vec<Vec<Named>> = self.contours[face.index()]
                .iter()
                .map(|contour| contour.iter().map(name).collect())
                .collect();
            triangulate(&flat, scene.weld, &|| scene.go_on().is_ok(), scratch)
        };
        let cut: Vec<Option<Vec<[u32; 3]>>> = if faces.len() < MANY_FACES {
            let mut scratch = Scratch::default();
            faces.iter().map(|&f| cut_face(&mut scratch, f)).collect()
        } else {
            let faces = faces.par_iter();
            faces
                .map_init(Scratch::default, |scratch, &f| cut_face(scratch, f))
                .collect()
        };
        for (&face, triangles) in faces.iter().zip(cut) {
            self.triangles[face.index()] = triangles;
        }
    }
}

/// Directed edges that occur twice, with the faces: diagonals of two faces, or a
/// diagonal and an edge, may join the same two vertices. And those of triangles
/// back to back: of a lens of which three vertices are known.
fn doubled_edges(triangles: &[Vec<[u32; 3]>], vertices: usize) -> Vec<([u32; 2], FaceId)> {
    // The edges that leave each vertex, by counting.
    let mut starts = vec![0u32; vertices + 2];
    for &corner in triangles.iter().flatten().flatten() {
        starts[corner as usize + 2] += 1;
    }
    for vertex in 2..starts.len() {
        starts[vertex] += starts[vertex - 1];
    }
    let mut edges = vec![(0u32, FaceId(0)); starts[vertices + 1] as usize];
    for (face, triangles) in FaceId::all(triangles.len()).zip(triangles) {
        for [from, to] in triangles.iter().flat_map(|&corners| sides(corners)) {
            let slot = &mut starts[from as usize + 1];
            edges[*slot as usize] = (to, face);
            *slot += 1;
        }
    }
    let mut doubled = Vec::new();
    for (from, ends) in (0u32..).zip(starts[..=vertices].windows(2)) {
        let leaving = &mut edges[ends[0] as usize..ends[1] as usize];
        leaving.sort_unstable();
        let same = leaving.chunk_by(|a, b| a.0 == b.0);
        let same = same.filter(|same| same.len() > 1).flatten();
        doubled.extend(same.map(|&(to, face)| ([from, to], face)));
    }
    let leaving = |vertex: u32| {
        let vertex = vertex as usize;
        &edges[starts[vertex] as usize..starts[vertex + 1] as usize]
    };
    for vertex in 0..vertices as u32 {
        if let &[(p, one), (q, other)] = leaving(vertex)
            && let &[(r, _), (s, _)] = leaving(p)
            && [[vertex, q], [q, vertex]].contains(&[r, s])
        {
            doubled.extend([one, other].map(|face| ([vertex, p], face)));
        }
    }
    doubled
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Faces on both sides of a curve may have cut off the same ear along it: in those
/// that are curved the diagonals get a vertex in their middle, and so does a face
/// of one triangle.
fn split_diagonals(
    scene: &Scene<'_>,
    faces: &[Side],
    doubled: &[([u32; 2], FaceId)],
    slits: &Slits,
    triangles: &mut [Vec<[u32; 3]>],
    positions: &mut Vec<DVec3>,
) {
    let ends: FxHashSet<[u32; 2]> = doubled.iter().map(|&(ends, _)| ends).collect();
    let mut concerned: Vec<FaceId> = doubled.iter().map(|&(_, face)| face).collect();
    concerned.sort_unstable();
    concerned.dedup();
    for face in concerned {
        let side = &faces[face.index()];
        let Some(frame) = scene.frame(side.plane) else {
            continue;
        };
        let surface = scene.surface(side.plane);
        let lift = |sum: DVec3, count: f64| frame.lift(surface, side.patch, sum / count);
        let triangles = &mut triangles[face.index()];
        let mut picture = Picture::new(scene, side, std::mem::take(triangles), slits);
        if let &[corners] = picture.triangles.as_slice() {
            let sum = corners.iter().map(|&c| positions[c as usize]).sum();
            positions.push(lift(sum, 3.0));
            picture.split_triangle(0, positions.len() as u32 - 1, positions);
        }
        // Others are only added behind.
        for half in 0..picture.twins.len() as u32 {
            let [from, to] = picture.ends(half);
            let is_doubled = ends.contains(&[from, to]) || ends.contains(&[to, from]);
            if is_doubled && picture.twins[half as usize] != NONE {
                positions.push(lift(positions[from as usize] + positions[to as usize], 2.0));
                picture.split_edge(half, positions.len() as u32 - 1, positions);
            }
        }
        *triangles = picture.triangles;
    }
}
