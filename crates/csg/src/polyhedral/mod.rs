//! Solids bounded by planes alone: their exact boundary, without sampling.
//!
//! A polyhedral solid's edges lie on lines in which two planes meet, and its
//! vertices where a third one crosses. So:
//!
//! 1. Space is cut into blocks until few planes matter in each ([`cells`]).
//! 2. In a block every line in which two planes meet is cut up by the others;
//!    on each stretch the formula tells which of the sectors around the line
//!    are solid, and hence which faces meet there ([`lines`]). All planes
//!    through one line are taken together.
//! 3. The pieces are linked to the contours of faces ([`boundary`]), and these
//!    cut into triangles ([`triangulate`]).
//!
//! This is the boundary evaluation of classical solid modelling (Requicha and
//! Voelcker, *Boolean Operations in Solid Modeling: Boundary Evaluation and
//! Merging Algorithms*, 1985) with a formula over half-spaces in place of point
//! membership tests. Walls and gaps must be thicker than [`WELD`] of the scene.

mod boundary;
mod cells;
mod lines;
mod regions;
mod triangulate;
mod weld;

use std::time::Instant;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use self::boundary::Boundary;
use self::cells::{Block, cut};
use self::lines::{Piece, Side, Tracer};
use self::triangulate::{Named, triangulate};
use crate::control::Control;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesher::Task;
use crate::program::{Origin, Program, Surface};
use crate::report::Report;

/// Points nearer to each other than this share of the scene are one vertex.
const WELD: f64 = 3e-11;

/// A line nearer to a plane than this share of the scene lies in it.
const ON_PLANE: f64 = 3e-12;

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
    planes: &'a [Plane],
    /// For each primitive the first that looks like it.
    looks: &'a [u32],
    on_plane: f64,
    weld: f64,
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

/// The exact boundary of a solid bounded by planes, in the local frame, with as
/// few triangles as its faces' corners and holes permit.
///
/// None where planes meet at so small angles, or so nearly in one point, that
/// rounding leaves contours open. Takes about a microsecond a triangle.
pub(crate) fn mesh(task: &Task<'_>, report: &mut Report) -> Result<Option<Mesh>, Error> {
    let start = Instant::now();
    let longest = task.size.max_element();
    let planes: Vec<Plane> = task.surfaces.iter().map(Plane::of).collect();
    let looks = looks(task.program.origins());
    let rounding = 16.0 * f64::EPSILON * task.origin.length();
    let scene = Scene {
        planes: &planes,
        looks: &looks,
        on_plane: ON_PLANE * longest + rounding,
        weld: WELD * longest + 10.0 * rounding,
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
    let pieces = trace(&scene, &blocks);
    task.control.check()?;
    let Some(pieces) = pieces else {
        return Ok(None);
    };
    let start = report.end_stage("edges", start);
    let boundary = Boundary::link(&scene, &pieces);
    task.control.check()?;
    let Some(boundary) = boundary else {
        return Ok(None);
    };
    task.control.tell(0.9);
    let start = report.end_stage("contours", start);
    let mesh = assemble(&scene, task, &boundary);
    task.control.check()?;
    report.end_stage("triangles", start);
    if let Some(mesh) = &mesh {
        let (deviation, farthest) = deviation(&scene, mesh);
        report.deviation = Some(deviation);
        report.farthest = Some(farthest + task.origin);
    }
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

/// The pieces of edges in all blocks, in their order.
fn trace(scene: &Scene<'_>, blocks: &[Block]) -> Option<Vec<Piece>> {
    /// Blocks that are worth handing to another thread.
    const AT_ONCE: usize = 64;
    let stage = scene.control.stage(blocks.len() as u64, 0.2, 0.8);
    let trace_some = |blocks: &[Block]| {
        let mut tracer = Tracer::default();
        let mut pieces = Vec::new();
        let traced = blocks.iter().all(|block| {
            let before = pieces.len();
            let traced = tracer.trace(scene, block, &mut pieces);
            stage.add(1);
            let bytes = BYTES_PER_PIECE * (pieces.len() - before);
            traced && scene.control.spend(0, bytes as u64).is_ok()
        });
        traced.then_some(pieces)
    };
    if blocks.len() <= AT_ONCE {
        return trace_some(blocks);
    }
    // All of them, whichever fails first: what is spent must not depend on it.
    let parts: Vec<Option<Vec<Piece>>> = blocks.par_chunks(AT_ONCE).map(trace_some).collect();
    let parts: Option<Vec<Vec<Piece>>> = parts.into_iter().collect();
    Some(parts?.concat())
}

/// Triangles of all faces.
fn assemble(scene: &Scene<'_>, task: &Task<'_>, boundary: &Boundary) -> Option<Mesh> {
    const MANY_FACES: usize = 64;
    let (fan_of, point_of) = boundary.fans();
    let mut mesh = Mesh {
        positions: point_of
            .iter()
            .map(|&p| boundary.points[p as usize])
            .collect(),
        ..Mesh::default()
    };
    let contours = boundary.contours();
    let stage = scene.control.stage(boundary.faces.len() as u64, 0.9, 1.0);
    let cut_face = |face: usize| {
        stage.add(1);
        let side = &boundary.faces[face];
        let name = |&half_edge: &u32| {
            let fan = fan_of[half_edge as usize];
            (scene.flatten(side, mesh.positions[fan as usize]), fan)
        };
        let flat: Vec<Vec<Named>> = contours[face]
            .iter()
            .map(|contour| contour.iter().map(name).collect())
            .collect();
        triangulate(&flat, scene.weld, scene.control)
    };
    let faces = boundary.faces.len();
    let triangles: Option<Vec<Vec<[u32; 3]>>> = if faces < MANY_FACES {
        (0..faces).map(cut_face).collect()
    } else {
        (0..faces).into_par_iter().map(cut_face).collect()
    };
    let mut entry_of: FxHashMap<(u32, u32), u32> = FxHashMap::default();
    for (side, triangles) in boundary.faces.iter().zip(triangles?) {
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
    has_no_double_edge(&mesh.triangles).then_some(mesh)
}

/// Whether no directed edge occurs twice: diagonals of two faces, or a diagonal
/// and an edge, might join the same two vertices.
fn has_no_double_edge(triangles: &[[u32; 3]]) -> bool {
    let mut edges: Vec<u64> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[from, to]| u64::from(from) << 32 | u64::from(to))
        .collect();
    edges.sort_unstable();
    edges.windows(2).all(|pair| pair[0] != pair[1])
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
