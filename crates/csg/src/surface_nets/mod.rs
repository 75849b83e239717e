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
mod cleanup;
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
mod stitch;
#[cfg(test)]
mod topology_tests;
mod validity;

use crate::clock::Instant;
use std::cell::RefCell;
use std::mem;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec3, UVec3};
use rayon::iter::{self, Either};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use self::assembly::{Assembled, Assembly, Leftovers, Output};
use self::cleanup::Cleaner;
use self::lattice::{CELLS, Lattice};
use self::part::{FallbackKind, Part};
use self::place::Placer;
use self::scene::Scene;
use self::stitch::{Directory, Scratch, Stitcher};
use crate::control::Control;
use crate::error::Error;
use crate::mesh::{Mesh, MeshSurface};
use crate::numeric::tolerance::{COORDINATE, ON_SURFACE};
use crate::program::{Bounds, Cell, Pruner, Reach};
use crate::report::Report;
use crate::task::Task;

/// Bricks from `from` to before `to`, with the program pruned to their box.
struct Block {
    from: UVec3,
    to: UVec3,
    cell: Cell,
}

/// Meshes a program with one vertex a loop, on its surfaces to rounding; in the
/// local frame, about the task's origin.
pub(crate) fn mesh(task: &Task<'_>, report: &mut Report) -> Result<Mesh, Error> {
    mesh_on(pulp::Arch::new(), task, report)
}

/// The same on vectors of a given width; the mesh does not depend on it.
fn mesh_on(arch: pulp::Arch, task: &Task<'_>, report: &mut Report) -> Result<Mesh, Error> {
    let start = Instant::now();
    let half = 0.5 * task.size;
    let local_bounds = Bounds {
        min: -half,
        max: half,
    };
    let reaches: Vec<Reach> = task.surfaces.iter().map(Reach::of).collect();
    let scene = Scene {
        surfaces: &task.surfaces,
        reaches: &reaches,
        origins: task.program.origins(),
        lattice: Lattice::around(&local_bounds, task.cell)?,
        // Far from the origin the surfaces' own places are rounded.
        tolerance: ON_SURFACE * task.size.max_element() + COORDINATE * task.origin.length(),
    };
    let (blocks, mut pruned) = blocks(&scene, &task.program.root_cell());
    report.end_stage("blocks", start);

    let progress = task
        .control
        .stage((WALK + STITCH) * blocks.len() as u64, 0.0, 1.0);
    let mut parts: Vec<Part> = Vec::with_capacity(blocks.len());
    let mut walked_parts = Vec::new();
    let mut surfaces = TableOfSurfaces::default();
    let mut directory = Directory::default();
    let mut assembly = Assembly::default();
    let least_area = LEAST_AREA * task.cell * task.cell;
    let at_once = blocks_at_once();
    // Memory for vertices, from batch to batch.
    let mut rooms: Vec<Vec<DVec3>> = vec![Vec::new(); at_once.min(blocks.len())];
    for batch in blocks.chunks(at_once) {
        let start = Instant::now();
        let first = parts.len();
        let walked = batch.par_iter().zip(&mut rooms).with_max_len(1);
        walked
            .map(|(block, room)| {
                let part = WALKER.with_borrow_mut(|walker| {
                    arch.dispatch(WalkBlock(walker, &scene, block, task.control));
                    walker.part.take(mem::take(room))
                });
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
            let leftovers = SCRATCH.with_borrow_mut(|scratch| {
                arch.dispatch(StitchPart(&stitcher, part, scratch, out))
            });
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
        triangles: &mut assembled.triangles,
        runs: &runs,
        near,
        unresolved: near::unresolved(&parts),
        surfaces: &task.surfaces,
        least_area,
        // Of the rounding that vertices are allowed most is spent on their
        // own surfaces.
        tolerance: 0.25 * scene.tolerance,
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

/// The work on one block, compiled for every SIMD level: what is inlined here
/// runs on vectors as wide as the machine's.
struct WalkBlock<'a, 's>(&'a mut Walker, &'a Scene<'s>, &'a Block, &'a Control);

impl pulp::WithSimd for WalkBlock<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        self.0.block(simd, self.1, self.2, self.3);
    }
}

/// The same for stitching one part.
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

/// About what is held at a time for each vertex and what becomes of it.
const BYTES_PER_VERTEX: usize = 150;

/// A triangle smaller than this share of a cell's face counts as having no
/// area.
const LEAST_AREA: f64 = 1e-7;

/// At most this many blocks along each axis are handed out to threads; a
/// constant, so that the order of the output is one, too.
const BLOCKS_ALONG: u32 = 8;

fn cells_in(from: UVec3, to: UVec3) -> u64 {
    let bricks = (to - from).as_u64vec3();
    bricks.x * bricks.y * bricks.z * (CELLS * CELLS * CELLS) as u64
}

/// The halves of a range of bricks along every axis longer than one.
fn children(from: UVec3, to: UVec3) -> impl Iterator<Item = (UVec3, UVec3)> {
    let middle = from + (to - from + 1) / 2;
    (0..8u32).filter_map(move |octant| {
        let upper = UVec3::new(octant & 1, octant >> 1 & 1, octant >> 2);
        let pick = |axis: usize| {
            if upper[axis] == 0 {
                (from[axis], middle[axis])
            } else {
                (middle[axis], to[axis])
            }
        };
        let [x, y, z] = [pick(0), pick(1), pick(2)];
        let (from, to) = (UVec3::new(x.0, y.0, z.0), UVec3::new(x.1, y.1, z.1));
        from.cmplt(to).all().then_some((from, to))
    })
}

/// The blocks in which something varies, in a fixed order; and how many cells
/// are in none.
fn blocks(scene: &Scene<'_>, root: &Cell) -> (Vec<Block>, u64) {
    let all = scene.lattice.bricks;
    let largest = all.max_element().div_ceil(BLOCKS_ALONG);
    let is_small = |block: &Block| (block.to - block.from).max_element() <= largest;
    let outside = AtomicU64::new(0);
    let varying = |above: &Cell, from, to, pruner: &mut Pruner| {
        let (center, half) = scene.lattice.bricks_box(from, to);
        let mut cell = Cell::default();
        above.prune_reaching_into(scene.table(), center, half, pruner, &mut cell);
        if cell.constant().is_some() {
            outside.fetch_add(cells_in(from, to), Ordering::Relaxed);
            return None;
        }
        Some(Block { from, to, cell })
    };
    let whole = varying(root, UVec3::ZERO, all, &mut Pruner::default());
    let mut blocks: Vec<Block> = whole.into_iter().collect();
    while !blocks.iter().all(is_small) {
        let halves = blocks.into_par_iter().flat_map(|block| {
            if is_small(&block) {
                return Either::Left(iter::once(block));
            }
            let halves: Vec<_> = children(block.from, block.to).collect();
            let halves = halves
                .into_par_iter()
                .map_init(Pruner::default, move |pruner, (from, to)| {
                    varying(&block.cell, from, to, pruner)
                });
            Either::Right(halves.flatten_iter())
        });
        blocks = halves.collect();
    }
    (blocks, outside.into_inner())
}

/// One worker: walks the bricks of a block, its scratch memory reused.
#[derive(Default)]
struct Walker {
    levels: Vec<Cell>,
    pruner: Pruner,
    placer: Placer,
    pending: Vec<(UVec3, UVec3, usize)>,
    /// What the block leaves behind.
    part: Part,
}

impl Walker {
    #[inline(always)]
    fn block<S: pulp::Simd>(
        &mut self,
        simd: S,
        scene: &Scene<'_>,
        block: &Block,
        control: &Control,
    ) {
        let part = &mut self.part;
        part.clear();
        self.pending.clear();
        self.pending.push((block.from, block.to, 0));
        while let Some((from, to, level)) = self.pending.pop() {
            if control.check().is_err() {
                return;
            }
            if self.levels.len() <= level {
                self.levels.resize_with(level + 1, Cell::default);
            }
            let (above, below) = self.levels.split_at_mut(level);
            let cell = if let Some(parent) = above.last() {
                let (center, half) = scene.lattice.bricks_box(from, to);
                let cell = &mut below[0];
                parent.prune_reaching_into(scene.table(), center, half, &mut self.pruner, cell);
                cell
            } else {
                below[0].clone_from(&block.cell);
                &mut below[0]
            };
            if cell.constant().is_some() {
                part.cells_pruned += cells_in(from, to);
            } else if to - from == UVec3::ONE {
                let before = part.vertices.len();
                self.placer.brick(simd, scene, cell, from, part);
                let bytes = BYTES_PER_VERTEX * (part.vertices.len() - before);
                let cells = (CELLS * CELLS * CELLS) as u64;
                if control.spend(cells, bytes as u64).is_err() {
                    return;
                }
            } else {
                let halves = children(from, to).map(|(from, to)| (from, to, level + 1));
                self.pending.extend(halves);
            }
        }
    }
}

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
                let surface = task.mesh_surface(group.surface, group.origin);
                self.surfaces.push(surface);
                self.surfaces.len() as u32 - 1
            });
        }
    }
}
