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
//!    any two meet ([`pairs`], [`conic`], [`pencil`], [`curve`], [`rulings`]; each pair's
//!    are found once, [`relations`]) and the points where others cross them ([`roots`],
//!    [`trig`]) or touch them ([`triple`]), as chains of chords
//!    ([`arcs`], [`arc`]): on each surface with those alone that matter there
//!    ([`mod@faces`], [`together`]), and along each curve where edges may lie alone. Their faces are cut into patches along seams, so that each can be
//!    seen from one side ([`frame`]).
//! 4. The pieces are linked to the contours of faces ([`boundary`], [`mod@contours`]), and these
//!    cut into triangles ([`crate::mesh::triangulate`]), with more chords where they would
//!    run across each other ([`crossings`]). Points where something touches a face
//!    become vertices of it ([`contacts`]), and triangles that would face away from
//!    their surface are cut up anew ([`mod@unfold`], [`picture`]), until all faces
//!    fit each other ([`mod@assemble`]).
//!
//! This is the boundary evaluation of classical solid modelling (Requicha and
//! Voelcker, *Boolean Operations in Solid Modeling: Boundary Evaluation and
//! Merging Algorithms*, 1985) with a formula over half-spaces in place of point
//! membership tests. Walls and gaps must be thicker than [`WELD`] of the scene,
//! between curved surfaces than [`NEAR`].
//!
//! Where quadrics have a straight line in common besides other curves, or several
//! surfaces nearly touch, there may be no result: then cells must do.

mod alone;
mod arc;
mod arcs;
mod assemble;
mod ball;
mod block;
mod boundary;
#[cfg(test)]
mod boundary_tests;
mod cells;
mod chords;
mod coaxial;
mod common;
mod conic;
mod contacts;
mod contours;
mod crossings;
mod curve;
mod edges;
mod faces;
mod frame;
mod half_edges;
mod ids;
mod intersection;
mod line;
mod lines;
mod pairs;
mod parallel;
mod pencil;
mod picture;
#[cfg(test)]
mod picture_tests;
mod piece;
pub(crate) mod rational;
mod regions;
mod relations;
mod roots;
#[cfg(test)]
mod roots_tests;
mod rulings;
mod scene;
mod sectors;
mod together;
mod traced;
mod trig;
mod triple;
mod unfold;
mod weld;

use crate::clock::Instant;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

pub(crate) use self::boundary::Borders;
pub(crate) use self::chords::Chords;
pub(crate) use self::conic::conics;
pub(crate) use self::curve::Curve;
pub(crate) use self::frame::Frame;
pub(crate) use self::half_edges::{Arrangement, HalfEdge};
pub(crate) use self::ids::{FaceId, HalfEdgeId, VertexId};
#[cfg(test)]
pub(crate) use self::pairs::tests::quadric as random_quadric;
pub(crate) use self::piece::{CurveId, Other, Side};

use self::alone::Alone;
use self::arcs::ArcTracer;
use self::assemble::assemble;
use self::block::Block;
use self::boundary::Boundary;
use self::cells::cut;
use self::chords::Chord;
use self::contacts::Contact;
use self::lines::Tracer;
use self::relations::Relations;
use self::scene::{Plane, Scene};
use self::traced::Traced;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::numeric::tolerance::{NEAR, ON_PLANE, TOUCH, VALUE, WELD};
use crate::program::{Origin, Program, SurfaceId};
use crate::report::Report;
use crate::task::Task;
use crate::undecided::{Stop, Undecided};

/// Surfaces that are nowhere farther apart than this share of the scene bound walls or
/// gaps that the stages of the evaluation are not asked to tell from none: a curve on the
/// one is on the other, too, by [`ON_PLANE`], and points of both are one, by [`NEAR`]. Planes
/// alone are told apart as far as their vertices are, by [`WELD`].
pub(crate) fn unresolved(program: &Program) -> f64 {
    if program.is_polyhedral() {
        3.0 * WELD
    } else {
        NEAR
    }
}

/// The box that is cut exceeds the solid's bounds by these shares of its
/// longest side: irrational, and different on all sides, so that no cut meets
/// the faces of models, which lie at round coordinates; and small, as whatever
/// cuts a model mostly ends a little beyond it, with faces that do not matter.
const BELOW: DVec3 = DVec3::new(
    0.027_639_320_225_002,
    0.028_284_271_247_462,
    0.026_055_512_754_640,
);
const ABOVE: DVec3 = DVec3::new(
    0.024_721_359_549_996,
    0.024_852_813_742_386,
    0.023_245_553_203_368,
);

/// A solid's boundary.
pub(crate) struct Evaluated {
    pub mesh: Mesh,
    pub borders: Borders,
}

/// By how much rounding may move points of a scene around `center` whose longest side is
/// `size`: some operations on its coordinates.
pub(crate) fn rounding(center: DVec3, size: f64) -> f64 {
    VALUE * (center.length() + size)
}

/// The boundary of a solid, in the local frame: of planes alone the exact one,
/// with as few triangles as its faces' corners and holes permit; else one whose
/// vertices are on their surfaces, of the right topology, to be refined.
///
/// Curves are cut into chords for a mesh to a tolerance.
///
/// The inner error says what could not be told, and where: surfaces may meet at so
/// small angles, or so nearly in one point, that rounding leaves contours open, or
/// along curves that are not known. Takes about a microsecond a triangle, and where
/// surfaces are curved one for every three of them in a block.
pub(crate) fn mesh(
    task: &Task<'_>,
    (chords, tolerance): (&Chords, f64),
    report: &mut Report,
) -> Result<Result<Evaluated, Undecided>, Error> {
    let alone = |scene: &Scene<'_>| Alone::of(task, scene);
    in_blocks(task, report, alone, |scene, blocks, alone, report| {
        let evaluated = chords.first_of(scene, tolerance, |chord| {
            let Linked {
                mut boundary,
                contacts,
                ..
            } = linked(scene, blocks, chord, report)?;
            let start = Instant::now();
            boundary.split_double_edges(scene)?;
            let mut mesh = assemble(scene, task, &mut boundary, &contacts)?;
            if let Some(alone) = alone {
                alone.add_to(&mut mesh, task);
            }
            scene.go_on()?;
            report.end_stage("triangles", start);
            let borders = boundary.borders();
            Ok(Evaluated { mesh, borders })
        })?;
        if task.program.is_polyhedral() {
            let (deviation, farthest) = deviation(scene, &evaluated.mesh);
            report.deviation = Some(deviation);
            report.farthest = Some(farthest + task.origin);
        }
        Ok(evaluated)
    })
}

/// The contours of all faces of a solid, along the exact curves, in the local frame.
///
/// The inner error is that of [`mesh`].
pub(crate) fn arrangement(
    task: &Task<'_>,
    report: &mut Report,
) -> Result<Result<Arrangement, Undecided>, Error> {
    let whole = |_: &Scene<'_>| None;
    in_blocks(task, report, whole, |scene, blocks, _, report| {
        let Linked { boundary, .. } =
            Chords::LONG.first_of(scene, 0.0, |chord| linked(scene, blocks, chord, report))?;
        Ok(Arrangement::new(scene, &boundary))
    })
}

/// Cuts space into blocks, without what is alone, and hands them on with what they have in common.
fn in_blocks<T>(
    task: &Task<'_>,
    report: &mut Report,
    alone: impl FnOnce(&Scene<'_>) -> Option<Alone>,
    evaluate: impl FnOnce(&Scene<'_>, &[Block], Option<&Alone>, &mut Report) -> Result<T, Stop>,
) -> Result<Result<T, Undecided>, Error> {
    let start = Instant::now();
    let longest = task.size.max_element();
    let planes: Vec<Plane> = task.surfaces.iter().map(Plane::of).collect();
    let reach = task.size.length();
    let frames = task.surfaces.iter().map(|s| Frame::of(s, reach));
    let frames: Vec<Option<Frame>> = frames.collect();
    let looks = looks(task.program.origins());
    let rounding = rounding(task.origin, longest);
    let given = task.program.given().map(|given| given.about(task.origin));
    let scene = Scene {
        surfaces: &task.surfaces,
        planes: &planes,
        frames: &frames,
        looks: &looks,
        on_plane: ON_PLANE * longest + rounding,
        near: NEAR * longest + rounding,
        touch: TOUCH * longest + rounding,
        reach,
        weld: WELD * longest + 10.0 * rounding,
        rounding,
        given: given.as_ref(),
        relations: &Relations::default(),
        control: task.control,
    };
    let bounds = [
        -0.5 * task.size - BELOW * longest,
        0.5 * task.size + ABOVE * longest,
    ];
    let alone = alone(&scene);
    let rest = alone.as_ref().map(|alone| &alone.rest);
    let surfaces = (task.program, &task.surfaces[..], rest);
    let (blocks, counts) = cut(surfaces, given.as_ref(), bounds, task.control)?;
    report.cells_visited = counts.visited;
    report.cells_pruned = counts.pruned;
    report.surface_cells = blocks.len() as u64;
    report.end_stage("blocks", start);
    match evaluate(&scene, &blocks, alone.as_ref(), report) {
        Ok(evaluated) => Ok(Ok(evaluated)),
        Err(Stop::Undecided(undecided)) => Ok(Err(Undecided {
            place: undecided.place + task.origin,
            ..undecided
        })),
        Err(Stop::Halted) => {
            task.control.check()?;
            Err(Error::Cancelled)
        }
    }
}

/// The contours of all faces, and where other faces touch them.
struct Linked {
    boundary: Boundary,
    contacts: Vec<Contact>,
}

/// Finds the pieces of edges in blocks, curves, if there are any, as chords, and links them to
/// contours.
fn linked(
    scene: &Scene<'_>,
    blocks: &[Block],
    chord: Option<Chord>,
    report: &mut Report,
) -> Result<Linked, Stop> {
    let start = Instant::now();
    let traced = match chord {
        None => trace(scene, blocks, Tracer::default, |tracer, block, traced| {
            tracer.trace(scene, block, &mut traced.pieces)
        }),
        Some(chord) => trace(
            scene,
            blocks,
            ArcTracer::default,
            |tracer, block, traced| tracer.trace(scene, block, chord, traced),
        ),
    };
    let Traced {
        pieces,
        mut contacts,
    } = traced?;
    let start = report.end_stage("edges", start);
    let boundary = Boundary::link(scene, &pieces, &mut contacts)?;
    scene.go_on()?;
    scene.control.tell(0.9);
    report.end_stage("contours", start);
    Ok(Linked { boundary, contacts })
}

/// For each primitive the first that looks like it.
pub(crate) fn looks(origins: &[Origin]) -> Vec<u32> {
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

/// What is found in all blocks, in their order.
fn trace<T>(
    scene: &Scene<'_>,
    blocks: &[Block],
    tracer: impl Fn() -> T + Sync,
    trace: impl Fn(&mut T, &Block, &mut Traced) -> Result<(), Stop> + Sync,
) -> Result<Traced, Stop> {
    /// Blocks that are worth handing to another thread. Tunes speed only.
    const AT_ONCE: usize = 64;
    let stage = scene.control.stage(blocks.len() as u64, 0.2, 0.8);
    let trace_some = |blocks: &[Block]| {
        let mut tracer = tracer();
        let mut traced = Traced::default();
        for block in blocks {
            let before = traced.pieces.len();
            trace(&mut tracer, block, &mut traced)?;
            stage.add(1);
            let bytes = BYTES_PER_PIECE * (traced.pieces.len() - before);
            let spent = scene.control.spend(0, bytes as u64);
            spent.map_err(|_| Stop::Halted)?;
        }
        Ok(traced)
    };
    if blocks.len() <= AT_ONCE {
        return trace_some(blocks);
    }
    // All of them, whichever fails first: what is spent must not depend on it.
    let parts: Vec<Result<Traced, Stop>> = blocks.par_chunks(AT_ONCE).map(trace_some).collect();
    let mut all = Traced::default();
    for part in parts {
        let part = part?;
        all.pieces.extend(part.pieces);
        all.contacts.extend(part.contacts);
    }
    Ok(all)
}

/// The largest distance of a vertex from a plane of its triangles, and where.
/// Contours and planes being the boundary's own, no other point of the mesh is
/// farther from the boundary, nor of the boundary from the mesh.
fn deviation(scene: &Scene<'_>, mesh: &Mesh) -> (f64, DVec3) {
    let mut farthest = (0.0, DVec3::ZERO);
    for (corners, &entry) in mesh.triangles.iter().zip(&mesh.triangle_surfaces) {
        let plane = scene.plane(SurfaceId(mesh.surfaces[entry as usize].surface));
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
