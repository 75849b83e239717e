//! Exact surface nets on a uniform sparse lattice: the lattice finds the
//! topology, the half-spaces give the geometry.
//!
//! 1. The box of bricks is halved recursively, the program pruned on the way;
//!    boxes in which nothing varies end there.
//! 2. Each remaining brick is classified bit-parallel ([`brick`]), its crossing
//!    edges are joined into loops cell by cell ([`loops`]), and every loop
//!    becomes a vertex on the surfaces that cause its crossings ([`place`],
//!    [`crate::surface::solve`]).
//! 3. Every crossing edge becomes a polygon between the vertices around it
//!    ([`stitch`]); triangles without area or folded over are taken out by
//!    collapses that keep every face on its surface ([`cleanup`]).
//!
//! Bricks share samples, not results: each computes what it needs bit for bit
//! alike, so they need no communication and their order does not matter. They
//! are done block by block, a batch of blocks at a time ([`assembly`]): what
//! vertices and triangles take is then known and written once, while the
//! batch is still at hand, and memory is used again by the next one.

mod assembly;
mod brick;
pub(crate) mod cleanup;
mod lattice;
mod loops;
mod meet;
mod near;
#[cfg(test)]
mod on_sample_tests;
mod part;
mod place;
mod quads;
mod scene;
#[cfg(test)]
mod simd_tests;
pub(crate) mod slab;
mod stitch;
#[cfg(test)]
mod topology_tests;
mod validity;
mod walk;

use crate::clock::Instant;
use std::cell::RefCell;
use std::mem;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use self::assembly::{Assembled, Assembly, Leftovers, Output};
use self::cleanup::Cleaner;
use self::lattice::{CELLS, Lattice};
use self::part::{FallbackKind, Part};
use self::scene::Scene;
use self::stitch::{Directory, Scratch, Stitcher};
use self::walk::{Block, WalkBlock, Walker, Wanted};
use crate::error::Error;
use crate::mesh::{Mesh, MeshSurface};
use crate::numeric::tolerance::{COORDINATE, ON_SURFACE};
use crate::program::{Bounds, Reach, SurfaceId};
use crate::report::Report;
use crate::task::Task;

/// Meshes a program with one vertex a loop, on its surfaces to rounding; in the
/// local frame, about the task's origin.
pub(crate) fn mesh(task: &Task<'_>, report: &mut Report) -> Result<Mesh, Error> {
    mesh_on(pulp::Arch::new(), task, report)
}

/// The same on vectors of a given width; the mesh does not depend on it.
fn mesh_on(arch: pulp::Arch, task: &Task<'_>, report: &mut Report) -> Result<Mesh, Error> {
    let start = Instant::now();
    let reaches = reaches(task);
    let scene = scene(task, &reaches)?;
    let wanted = Wanted::all();
    let (blocks, mut pruned) = walk::blocks(&scene, &task.program.root_cell(), &wanted);
    report.end_stage("blocks", start);

    let progress = task
        .control
        .stage((WALK + STITCH) * blocks.len() as u64, 0.0, 1.0);
    let mut parts: Vec<Part> = Vec::with_capacity(blocks.len());
    let mut walked_parts = Vec::new();
    let mut surfaces = TableOfSurfaces::default();
    let mut directory = Directory::default();
    let mut assembly = Assembly::default();
    let least_area = least_area(task);
    let at_once = blocks_at_once();
    // Memory for vertices, from batch to batch.
    let mut rooms: Vec<Vec<DVec3>> = vec![Vec::new(); at_once.min(blocks.len())];
    for batch in blocks.chunks(at_once) {
        let start = Instant::now();
        let first = parts.len();
        let walked = batch.par_iter().zip(&mut rooms).with_max_len(1);
        walked
            .map(|(block, room)| {
                let part = walked_part(arch, (&scene, &wanted), block, mem::take(room), task);
                progress.add(WALK);
                part
            })
            .collect_into_vec(&mut walked_parts);
        task.control.check()?;
        parts.append(&mut walked_parts);
        directory.extend(&parts[first..]);
        // The highest bit marks table entries of several loops.
        if directory.vertices >= 1 << 31 {
            return Err(Error::TooLarge {
                what: "vertices in one mesh",
                limit: 1 << 31,
            });
        }
        surfaces.enter(task, &mut parts[first..]);
        let start = report.add_to_stage("bricks", start);
        let stitcher = Stitcher {
            parts: &parts,
            directory: &directory,
            surfaces: &task.surfaces,
            least_area,
        };
        let done = parts.len() as f64 / blocks.len() as f64;
        assembly.add(&parts, first, done, |part, out| {
            let leftovers = stitched_part(arch, &stitcher, part, out);
            progress.add(STITCH);
            leftovers
        });
        for (room, part) in rooms.iter_mut().zip(&mut parts[first..]) {
            *room = mem::take(&mut part.vertices);
        }
        report.add_to_stage("stitch", start);
    }
    let start = Instant::now();
    let stitcher = Stitcher {
        parts: &parts,
        directory: &directory,
        surfaces: &task.surfaces,
        least_area,
    };
    let mut assembled = assembly.finish();
    let runs = near::runs(&parts, &assembled);
    let further = 2 * parts.iter().map(|part| part.polygons.len()).sum::<usize>();
    let further = further..assembled.triangles.len();
    let near = |vertices: &[u32]| {
        near::triangles_around(&stitcher, vertices.iter().copied(), further.clone())
    };
    let cleaned = Cleaner {
        positions: &assembled.positions,
        count: assembled.triangles.len(),
        triangles: &mut assembled.triangles,
        runs: &runs,
        near,
        unresolved: near::unresolved(&parts),
        surfaces: &task.surfaces,
        least_area,
        tolerance: merging_tolerance(&scene),
    }
    .clean(&assembled.bad);
    let Assembled {
        mut positions,
        mut triangles,
        surfaces: mut triangle_surfaces,
        ..
    } = assembled;
    for &triangle in &cleaned.left {
        let [p, q, r] = triangles[triangle as usize].map(|v| positions[v as usize]);
        let place = (p + q + r) / 3.0 + task.origin;
        report.add_fallback(FallbackKind::Degenerate.describe(), place);
    }
    if !cleaned.merged.is_empty() {
        let last = (positions.len() - cleaned.merged.len()) as u32..positions.len() as u32;
        let mut naming = near::triangles_around(&stitcher, last, further);
        naming.extend(cleaned.altered.iter().map(|&t| t as usize..t as usize + 1));
        remove_vertices(&mut positions, &mut triangles, &naming, &cleaned.merged);
    }
    remove_marked(&mut triangles, &cleaned.removed);
    remove_marked(&mut triangle_surfaces, &cleaned.removed);
    for part in &parts {
        report.surface_cells += part.surface_cells;
        report.cells_visited += part.bricks_sampled * (CELLS * CELLS * CELLS) as u64;
        pruned += part.cells_pruned;
    }
    report.cells_pruned = pruned;
    for fallback in parts.iter().flat_map(|part| &part.fallbacks) {
        report.add_fallback(fallback.kind.describe(), fallback.place + task.origin);
    }
    report.end_stage("cleanup", start);
    Ok(Mesh {
        positions,
        triangles,
        triangle_surfaces,
        surfaces: surfaces.surfaces,
        ..Mesh::default()
    })
}

thread_local! {
    /// Scratch memory that every worker keeps from block to block and from
    /// mesh to mesh, some 300 KiB and what the largest block left behind: fresh
    /// pages cost more than a small mesh.
    static WALKER: RefCell<Walker> = RefCell::default();
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// What all bricks have in common.
fn scene<'a>(task: &'a Task<'_>, reaches: &'a [Reach]) -> Result<Scene<'a>, Error> {
    let half = 0.5 * task.size;
    let local_bounds = Bounds {
        min: -half,
        max: half,
    };
    Ok(Scene {
        surfaces: &task.surfaces,
        reaches,
        origins: task.program.origins(),
        lattice: Lattice::around(&local_bounds, task.cell)?,
        // Far from the origin the surfaces' own places are rounded.
        tolerance: ON_SURFACE * task.size.max_element() + COORDINATE * task.origin.length(),
    })
}

fn reaches(task: &Task<'_>) -> Vec<Reach> {
    task.surfaces.iter().map(Reach::of).collect()
}

fn least_area(task: &Task<'_>) -> f64 {
    LEAST_AREA * task.cell * task.cell
}

/// Distance to a surface below which a vertex may be merged into one on it: of
/// the rounding that vertices are allowed most is spent on their own surfaces.
fn merging_tolerance(scene: &Scene<'_>) -> f64 {
    0.25 * scene.tolerance
}

/// Walks the wanted bricks of a block; `room` is memory for its vertices.
fn walked_part(
    arch: pulp::Arch,
    (scene, wanted): (&Scene<'_>, &Wanted),
    block: &Block,
    room: Vec<DVec3>,
    task: &Task<'_>,
) -> Part {
    WALKER.with_borrow_mut(|walker| {
        arch.dispatch(WalkBlock {
            walker,
            scene,
            block,
            wanted,
            control: task.control,
        });
        walker.part.take(room)
    })
}

/// Stitches a part, by its place among them.
fn stitched_part(
    arch: pulp::Arch,
    stitcher: &Stitcher<'_>,
    part: usize,
    out: &mut Output<'_>,
) -> Leftovers {
    SCRATCH.with_borrow_mut(|scratch| arch.dispatch(StitchPart(stitcher, part, scratch, out)))
}

/// Stitching one part, compiled for every SIMD level as walking is.
struct StitchPart<'a, 's, 'o>(&'a Stitcher<'s>, usize, &'a mut Scratch, &'a mut Output<'o>);

impl pulp::WithSimd for StitchPart<'_, '_, '_> {
    type Output = Leftovers;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> Leftovers {
        self.0.part(simd, self.1, self.2, self.3)
    }
}

/// How many blocks are walked, then stitched, before the next: on one thread so
/// few that what the one leaves to the other is still at hand, on several so
/// many that these wait for each other once or twice in a whole mesh.
fn blocks_at_once() -> usize {
    match rayon::current_num_threads() {
        1 => 8,
        several => 256 * several,
    }
}

/// Shares of the work on a block.
const WALK: u64 = 2;
const STITCH: u64 = 1;

/// A triangle smaller than this share of a cell's face counts as having no
/// area.
const LEAST_AREA: f64 = 1e-7;

/// Removes the items at the given ascending places; the last ones take them.
fn remove_marked<T>(items: &mut Vec<T>, removed: &[u32]) {
    for &index in removed.iter().rev() {
        items.swap_remove(index as usize);
    }
}

/// Removes vertices that no triangle is to name any more; the last ones take
/// their places. All triangles that name those are in the given ranges.
fn remove_vertices(
    positions: &mut Vec<DVec3>,
    triangles: &mut [[u32; 3]],
    naming: &[Range<usize>],
    removed: &FxHashSet<u32>,
) {
    let kept = positions.len() - removed.len();
    let mut holes: Vec<u32> = removed
        .iter()
        .copied()
        .filter(|&v| (v as usize) < kept)
        .collect();
    holes.sort_unstable();
    let mut holes = holes.into_iter();
    let new_places: Vec<u32> = (kept as u32..positions.len() as u32)
        .map(|vertex| {
            let stays = !removed.contains(&vertex);
            stays.then(|| holes.next()).flatten().unwrap_or(vertex)
        })
        .collect();
    for (i, &to) in new_places.iter().enumerate() {
        positions[to as usize] = positions[kept + i];
    }
    positions.truncate(kept);
    for triangle in naming.iter().cloned().flatten() {
        for corner in &mut triangles[triangle] {
            if let Some(&to) = new_places.get((*corner as usize).wrapping_sub(kept)) {
                *corner = to;
            }
        }
    }
}

/// The mesh's table of surfaces, in the order in which polygons first name
/// them.
#[derive(Default)]
struct TableOfSurfaces {
    /// By surface and primitive.
    index: FxHashMap<(u32, u32), u32>,
    surfaces: Vec<MeshSurface>,
}

impl TableOfSurfaces {
    /// Enters what the groups of parts lie on; every group learns its entry.
    fn enter(&mut self, task: &Task<'_>, parts: &mut [Part]) {
        for group in parts.iter_mut().flat_map(|part| &mut part.groups) {
            let key = (group.surface, group.origin);
            group.entry = *self.index.entry(key).or_insert_with(|| {
                let surface = task.mesh_surface(SurfaceId(group.surface), group.origin);
                self.surfaces.push(surface);
                self.surfaces.len() as u32 - 1
            });
        }
    }
}
