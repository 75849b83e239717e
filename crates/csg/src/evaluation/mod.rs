//! The boundary of a solid from its surfaces, without sampling: exact where it
//! is bounded by planes, and else with exact vertices and edges along the true
//! curves.
//!
//! A solid's edges lie on the curves in which two of its surfaces meet, and its
//! vertices where a third one crosses. So:
//!
//! 1. Space is cut into blocks until few surfaces matter in each ([`cells`]).
//! 2. In a block every line in which two planes meet is cut up by the others;
//!    on each stretch the formula tells which of the sectors around the line
//!    are solid, and hence which faces meet there ([`sectors`], [`lines`]). All
//!    planes through one line are taken together.
//! 3. If there are curved surfaces, the same is done with the curves in which
//!    any two meet ([`pairs`], [`pencil`], [`curve`], [`rulings`]) and the points
//!    where others cross them ([`roots`], [`trig`]), as chains of chords
//!    ([`arcs`]). Their faces are cut into patches along seams, so that each can
//!    be seen from one side ([`frame`]).
//! 4. The pieces are linked to the contours of faces ([`boundary`]), and these
//!    cut into triangles ([`mod@triangulate`]), with more chords where they would
//!    run across each other ([`crossings`]). Points where something touches a face
//!    become vertices of it ([`contacts`]), and triangles that would face away from
//!    their surface are cut up anew ([`mod@unfold`], [`picture`]).
//!
//! This is the boundary evaluation of classical solid modelling (Requicha and
//! Voelcker, *Boolean Operations in Solid Modeling: Boundary Evaluation and
//! Merging Algorithms*, 1985) with a formula over half-spaces in place of point
//! membership tests. Walls and gaps must be thicker than [`WELD`] of the scene,
//! between curved surfaces than [`NEAR`].
//!
//! Where quadrics have a straight line in common besides other curves, or several
//! surfaces nearly touch, there may be no result: then cells must do.

mod arcs;
mod boundary;
mod cells;
mod contacts;
mod crossings;
mod curve;
mod frame;
mod lines;
mod pairs;
mod pencil;
mod picture;
#[cfg(test)]
mod picture_tests;
mod regions;
mod roots;
#[cfg(test)]
mod roots_tests;
mod rulings;
mod sectors;
mod triangulate;
mod trig;
mod unfold;
mod weld;

use std::time::Instant;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

pub(crate) use self::curve::Curve;
pub(crate) use self::pairs::conics;

use self::arcs::ArcTracer;
use self::boundary::Boundary;
use self::cells::{Block, cut};
use self::contacts::{Contact, add_contacts};
use self::frame::Frame;
use self::lines::{Piece, Tracer};
use self::picture::Picture;
use self::sectors::Side;
use self::triangulate::{Named, triangulate};
use self::unfold::unfold;
use crate::control::Control;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesher::Task;
use crate::program::{Origin, Program, Surface};
use crate::report::Report;

/// By how much chords turn at most, in radians; less where faces cannot be cut
/// into triangles so.
pub(crate) const LONG_CHORDS: [f64; 3] = [0.5, 0.2, 0.06];

/// The same where faces are so narrow that long chords are in each other's way.
pub(crate) const SHORT_CHORDS: [f64; 2] = [0.1, 0.03];

/// And where these are, too.
pub(crate) const SHORTEST_CHORDS: [f64; 2] = [0.03, 0.01];

/// Points nearer to each other than this share of the scene are one vertex.
const WELD: f64 = 3e-11;

/// A line nearer to a plane than this share of the scene lies in it.
const ON_PLANE: f64 = 3e-12;

/// Curved surfaces nearer to each other than this share of the scene, but not
/// crossing, touch.
const NEAR: f64 = 1e-9;

/// The box that is cut exceeds the solid's bounds by these shares of its
/// longest side: irrational, and different on all sides, so that no cut meets
/// the faces of models, which lie at round coordinates.
const BELOW: DVec3 = DVec3::new(
    0.138_196_601_125_011,
    0.141_421_356_237_310,
    0.130_277_563_773_199,
);
const ABOVE: DVec3 = DVec3::new(
    0.123_606_797_749_979,
    0.124_264_068_711_928,
    0.116_227_766_016_838,
);

/// n·x - offset, at most 0 inside.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: DVec3,
    offset: f64,
}

impl Plane {
    fn value(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// What all blocks have in common.
struct Scene<'a> {
    surfaces: &'a [Surface],
    planes: &'a [Plane],
    /// For each curved surface its frame, if it has one.
    frames: &'a [Option<Frame>],
    /// For each primitive the first that looks like it.
    looks: &'a [u32],
    on_plane: f64,
    near: f64,
    weld: f64,
    /// Distances that rounding may make.
    rounding: f64,
    control: &'a Control,
}

impl Scene<'_> {
    /// The point common to three planes, the same to the bit in whatever order
    /// they are named.
    fn common_point(&self, mut ids: [u32; 3]) -> DVec3 {
        ids.sort_unstable();
        let planes = ids.map(|id| self.planes[id as usize]);
        let [p, q, r] = planes.map(|plane| plane.normal);
        let crosses = [q.cross(r), r.cross(p), p.cross(q)];
        let solve = |values: [f64; 3]| {
            (values[0] * crosses[0] + values[1] * crosses[1] + values[2] * crosses[2])
                / p.dot(crosses[0])
        };
        let point = solve(planes.map(|plane| plane.offset));
        // A step of iterative refinement.
        point - solve(planes.map(|plane| plane.value(point)))
    }

    /// A point of a face seen from outside, along the axis that its plane faces
    /// most: no coordinate is rounded.
    fn flatten(&self, side: &Side, point: DVec3) -> DVec2 {
        if let Some(frame) = &self.frames[side.plane as usize] {
            return frame.flatten(side.patch, side.along_normal, point);
        }
        let normal = self.planes[side.plane as usize].normal;
        let axis = normal.abs().max_position();
        let (u, v) = (point[(axis + 1) % 3], point[(axis + 2) % 3]);
        if (normal[axis] > 0.0) == side.along_normal {
            DVec2::new(u, v)
        } else {
            DVec2::new(v, u)
        }
    }
}

/// Whether a program has planes alone.
pub(crate) fn is_polyhedral(program: &Program) -> bool {
    program.surfaces().iter().all(Surface::is_plane)
}

/// The boundary of a solid, in the local frame: of planes alone the exact one,
/// with as few triangles as its faces' corners and holes permit; else one whose
/// vertices are on their surfaces, of the right topology, to be refined.
///
/// Chords of curves turn by no more than about the first of `turns` that will
/// do.
///
/// None where surfaces meet at so small angles, or so nearly in one point, that
/// rounding leaves contours open, or where their curves are not known. Takes
/// about a microsecond a triangle, and where surfaces are curved one for every
/// three of them in a block.
pub(crate) fn mesh(
    task: &Task<'_>,
    turns: &[f64],
    report: &mut Report,
) -> Result<Option<Mesh>, Error> {
    let start = Instant::now();
    let longest = task.size.max_element();
    let planes: Vec<Plane> = task.surfaces.iter().map(Plane::of).collect();
    let reach = task.size.length();
    let frames = task.surfaces.iter().map(|s| Frame::of(s, reach));
    let frames: Vec<Option<Frame>> = frames.collect();
    let looks = looks(task.program.origins());
    let rounding = 16.0 * f64::EPSILON * (task.origin.length() + longest);
    let scene = Scene {
        surfaces: &task.surfaces,
        planes: &planes,
        frames: &frames,
        looks: &looks,
        on_plane: ON_PLANE * longest + rounding,
        near: NEAR * longest + rounding,
        weld: WELD * longest + 10.0 * rounding,
        rounding,
        control: task.control,
    };
    let root = Block {
        low: -0.5 * task.size - BELOW * longest,
        high: 0.5 * task.size + ABOVE * longest,
        cell: task.program.root_cell(),
    };
    let (blocks, counts) = cut(&task.surfaces, &root, task.control)?;
    report.cells_visited = counts.visited;
    report.cells_pruned = counts.pruned;
    report.surface_cells = blocks.len() as u64;
    let start = report.end_stage("blocks", start);
    let mesh = if is_polyhedral(task.program) {
        let traced = trace(&scene, &blocks, Tracer::default, |tracer, block, traced| {
            tracer.trace(&scene, block, &mut traced.pieces)
        });
        mesh_of(&scene, task, traced, report, start)?
    } else {
        mesh_of_curved(&scene, task, &blocks, turns, report)?
    };
    if let Some(mesh) = mesh.as_ref().filter(|_| is_polyhedral(task.program)) {
        let (deviation, farthest) = deviation(&scene, mesh);
        report.deviation = Some(deviation);
        report.farthest = Some(farthest + task.origin);
    }
    Ok(mesh)
}

/// The boundary with curved faces: vertices are exact, and edges along curves
/// chains of chords.
fn mesh_of_curved(
    scene: &Scene<'_>,
    task: &Task<'_>,
    blocks: &[Block],
    turns: &[f64],
    report: &mut Report,
) -> Result<Option<Mesh>, Error> {
    for &turn in turns {
        let start = Instant::now();
        let traced = trace(
            scene,
            blocks,
            ArcTracer::default,
            |tracer, block, traced| tracer.trace(scene, block, turn, traced).is_some(),
        );
        if traced.is_none() {
            break;
        }
        let mesh = mesh_of(scene, task, traced, report, start)?;
        if mesh.is_some() {
            return Ok(mesh);
        }
    }
    task.control.check()?;
    Ok(None)
}

/// Links pieces to contours, and cuts the faces into triangles.
fn mesh_of(
    scene: &Scene<'_>,
    task: &Task<'_>,
    traced: Option<Traced>,
    report: &mut Report,
    start: Instant,
) -> Result<Option<Mesh>, Error> {
    task.control.check()?;
    let Some(mut traced) = traced else {
        return Ok(None);
    };
    let start = report.end_stage("edges", start);
    let boundary = Boundary::link(scene, &traced.pieces, &mut traced.contacts);
    task.control.check()?;
    let Some(mut boundary) = boundary else {
        return Ok(None);
    };
    task.control.tell(0.9);
    let start = report.end_stage("contours", start);
    let mesh = assemble(scene, task, &mut boundary, &traced.contacts);
    task.control.check()?;
    report.end_stage("triangles", start);
    Ok(mesh)
}

impl Plane {
    fn of(surface: &Surface) -> Self {
        Self {
            normal: surface.linear,
            offset: surface.linear.dot(surface.anchor),
        }
    }
}

/// For each primitive the first that looks like it.
fn looks(origins: &[Origin]) -> Vec<u32> {
    let mut first: FxHashMap<_, u32> = FxHashMap::default();
    let key = |origin: &Origin| {
        let color = origin.color.map(|c| {
            let [r, g, b] = c.rgb.map(f32::to_bits);
            [r, g, b, c.alpha.to_bits()]
        });
        (origin.kind, origin.name.clone(), color)
    };
    (0u32..)
        .zip(origins)
        .map(|(index, origin)| *first.entry(key(origin)).or_insert(index))
        .collect()
}

/// About what is held at a time for each piece and what becomes of it.
const BYTES_PER_PIECE: usize = 400;

/// What is found in blocks.
#[derive(Default)]
struct Traced {
    /// Of edges.
    pieces: Vec<Piece>,
    contacts: Vec<Contact>,
}

/// What is found in all blocks, in their order.
fn trace<T>(
    scene: &Scene<'_>,
    blocks: &[Block],
    tracer: impl Fn() -> T + Sync,
    trace: impl Fn(&mut T, &Block, &mut Traced) -> bool + Sync,
) -> Option<Traced> {
    /// Blocks that are worth handing to another thread.
    const AT_ONCE: usize = 64;
    let stage = scene.control.stage(blocks.len() as u64, 0.2, 0.8);
    let trace_some = |blocks: &[Block]| {
        let mut tracer = tracer();
        let mut traced = Traced::default();
        let is_known = blocks.iter().all(|block| {
            let before = traced.pieces.len();
            let is_known = trace(&mut tracer, block, &mut traced);
            stage.add(1);
            let bytes = BYTES_PER_PIECE * (traced.pieces.len() - before);
            is_known && scene.control.spend(0, bytes as u64).is_ok()
        });
        is_known.then_some(traced)
    };
    if blocks.len() <= AT_ONCE {
        return trace_some(blocks);
    }
    // All of them, whichever fails first: what is spent must not depend on it.
    let parts: Vec<Option<Traced>> = blocks.par_chunks(AT_ONCE).map(trace_some).collect();
    let mut all = Traced::default();
    for part in parts {
        let part = part?;
        all.pieces.extend(part.pieces);
        all.contacts.extend(part.contacts);
    }
    Some(all)
}

/// Triangles of all faces. Where chords of curves run across each other, or along a
/// diagonal of another face, more of them are made.
fn assemble(
    scene: &Scene<'_>,
    task: &Task<'_>,
    boundary: &mut Boundary,
    contacts: &[Contact],
) -> Option<Mesh> {
    const MOST_TRIES: u32 = 6;
    /// Splits make triangles Delaunay again, and with that other diagonals.
    const MOST_SPLITS: u32 = 4;
    for tries in 1..=MOST_TRIES {
        let Cut {
            mut positions,
            triangles,
            ..
        } = Cut::new(scene, boundary)?;
        let triangles: Option<Vec<_>> = triangles.into_iter().collect();
        let mut triangles = triangles?;
        let faces = &boundary.faces;
        add_contacts(scene, contacts, faces, &mut triangles, &mut positions);
        let mut coarse = Vec::new();
        for (side, triangles) in faces.iter().zip(&mut triangles) {
            unfold(scene, side, triangles, &mut positions, &mut coarse);
        }
        let coarse = boundary.curves_between(scene, &coarse);
        if tries < MOST_TRIES && !coarse.is_empty() && boundary.split(scene, &coarse).is_some() {
            continue;
        }
        let faces = &boundary.faces;
        let mut doubled = doubled_edges(&triangles, positions.len());
        for _ in 0..MOST_SPLITS {
            if doubled.is_empty() {
                break;
            }
            split_diagonals(scene, faces, &doubled, &mut triangles, &mut positions);
            doubled = doubled_edges(&triangles, positions.len());
        }
        if doubled.is_empty() {
            return Some(finished(task, faces, triangles, positions));
        }
        let doubled: Vec<[u32; 2]> = doubled.into_iter().map(|(ends, _)| ends).collect();
        let chords = boundary.curves_between(scene, &doubled);
        if chords.is_empty() || boundary.split(scene, &chords).is_none() {
            return None;
        }
    }
    None
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
    let mut entry_of: FxHashMap<(u32, u32), u32> = FxHashMap::default();
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
    contours: Vec<Vec<Vec<u32>>>,
    /// Of each face; none where it could not be cut.
    triangles: Vec<Option<Vec<[u32; 3]>>>,
}

impl Cut {
    /// Cuts all faces; none where more chords do not help.
    fn new(scene: &Scene<'_>, boundary: &mut Boundary) -> Option<Self> {
        /// Times that edges of faces that cannot be cut are split.
        const ROUNDS: u32 = 12;
        let mut cut = Self::default();
        let mut faces: Vec<u32> = (0..boundary.faces.len() as u32).collect();
        for round in 0..=ROUNDS {
            cut.cut_faces(scene, boundary, &faces);
            let failed = |&face: &u32| cut.triangles[face as usize].is_none();
            let failed: Vec<u32> = faces.iter().copied().filter(failed).collect();
            if failed.is_empty() {
                return Some(cut);
            }
            scene.control.check().ok()?;
            let mut crossing = Vec::new();
            for face in failed {
                let contours = &cut.contours[face as usize];
                boundary.crossing_edges(scene, face, contours, &mut crossing);
            }
            crossing.sort_unstable();
            crossing.dedup();
            if round == ROUNDS || crossing.is_empty() {
                return None;
            }
            let split = boundary.split(scene, &crossing)?;
            // The faces on both sides have more corners.
            let sides = split.iter().flat_map(|&edge| boundary.faces_of(edge));
            faces = sides.collect();
            faces.sort_unstable();
            faces.dedup();
        }
        None
    }

    /// Cuts some faces, for the first time or once more. Vertices keep their
    /// numbers when edges are split.
    fn cut_faces(&mut self, scene: &Scene<'_>, boundary: &Boundary, faces: &[u32]) {
        const MANY_FACES: usize = 64;
        let (fan_of, point_of) = boundary.fans();
        let points = point_of.iter().map(|&p| boundary.points[p as usize]);
        self.positions = points.collect();
        self.contours = boundary.contours();
        self.triangles.resize(boundary.faces.len(), None);
        let stage = scene.control.stage(faces.len() as u64, 0.9, 1.0);
        let cut_face = |&face: &u32| {
            scene.control.check().ok()?;
            stage.add(1);
            let side = &boundary.faces[face as usize];
            let name = |&half_edge: &u32| {
                let fan = fan_of[half_edge as usize];
                (scene.flatten(side, self.positions[fan as usize]), fan)
            };
            let flat: Vec<Vec<Named>> = self.contours[face as usize]
                .iter()
                .map(|contour| contour.iter().map(name).collect())
                .collect();
            triangulate(&flat, scene.weld, scene.control)
        };
        let cut: Vec<Option<Vec<[u32; 3]>>> = if faces.len() < MANY_FACES {
            faces.iter().map(cut_face).collect()
        } else {
            faces.par_iter().map(cut_face).collect()
        };
        for (&face, triangles) in faces.iter().zip(cut) {
            self.triangles[face as usize] = triangles;
        }
    }
}

/// Directed edges that occur twice, with the faces: diagonals of two faces, or a
/// diagonal and an edge, may join the same two vertices. And those of triangles
/// back to back: of a lens of which three vertices are known.
fn doubled_edges(triangles: &[Vec<[u32; 3]>], vertices: usize) -> Vec<([u32; 2], u32)> {
    // The edges that leave each vertex, by counting.
    let mut starts = vec![0u32; vertices + 2];
    for &corner in triangles.iter().flatten().flatten() {
        starts[corner as usize + 2] += 1;
    }
    for vertex in 2..starts.len() {
        starts[vertex] += starts[vertex - 1];
    }
    let mut edges = vec![(0u32, 0u32); starts[vertices + 1] as usize];
    for (face, triangles) in (0u32..).zip(triangles) {
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
    doubled: &[([u32; 2], u32)],
    triangles: &mut [Vec<[u32; 3]>],
    positions: &mut Vec<DVec3>,
) {
    let ends: FxHashSet<[u32; 2]> = doubled.iter().map(|&(ends, _)| ends).collect();
    let mut concerned: Vec<u32> = doubled.iter().map(|&(_, face)| face).collect();
    concerned.sort_unstable();
    concerned.dedup();
    for face in concerned {
        let side = &faces[face as usize];
        let Some(frame) = &scene.frames[side.plane as usize] else {
            continue;
        };
        let surface = &scene.surfaces[side.plane as usize];
        let lift = |sum: DVec3, count: f64| frame.lift(surface, side.patch, sum / count);
        let triangles = &mut triangles[face as usize];
        let mut picture = Picture::new(scene, side, std::mem::take(triangles));
        if let &[corners] = picture.triangles.as_slice() {
            let sum = corners.iter().map(|&c| positions[c as usize]).sum();
            positions.push(lift(sum, 3.0));
            picture.split_triangle(0, positions.len() as u32 - 1, positions);
        }
        // Others are only added behind.
        for half in 0..picture.twins.len() as u32 {
            let [from, to] = picture.ends(half);
            let is_doubled = ends.contains(&[from, to]) || ends.contains(&[to, from]);
            if is_doubled && picture.twins[half as usize] != picture::NONE {
                positions.push(lift(positions[from as usize] + positions[to as usize], 2.0));
                picture.split_edge(half, positions.len() as u32 - 1, positions);
            }
        }
        *triangles = picture.triangles;
    }
}

/// The largest distance of a vertex from a plane of its triangles, and where.
/// Contours and planes being the boundary's own, no other point of the mesh is
/// farther from the boundary, nor of the boundary from the mesh.
fn deviation(scene: &Scene<'_>, mesh: &Mesh) -> (f64, DVec3) {
    let mut farthest = (0.0, DVec3::ZERO);
    for (corners, &entry) in mesh.triangles.iter().zip(&mesh.triangle_surfaces) {
        let plane = &scene.planes[mesh.surfaces[entry as usize].surface as usize];
        for &corner in corners {
            let point = mesh.positions[corner as usize];
            let distance = plane.value(point).abs();
            if distance > farthest.0 {
                farthest = (distance, point);
            }
        }
    }
    farthest
}
