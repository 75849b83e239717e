//! Exact surface nets on a uniform sparse lattice: the lattice finds the
//! topology, the half-spaces give the geometry.
//!
//! 1. The box of bricks is halved recursively, the program pruned on the way;
//!    boxes in which nothing varies end there.
//! 2. Each remaining brick is classified bit-parallel ([`brick`]), its crossing
//!    edges are joined into loops cell by cell ([`loops`]), and every loop
//!    becomes a vertex on the surfaces that cause its crossings ([`place`],
//!    [`solve`]).
//! 3. Every crossing edge becomes a polygon between the vertices around it
//!    ([`stitch`]); triangles without area or folded over are taken out by
//!    collapses that keep every face on its surface ([`cleanup`]).
//!
//! Bricks share samples, not results: each computes what it needs bit for bit
//! alike, so they need no communication and their order does not matter.

mod brick;
mod cleanup;
mod lattice;
mod loops;
mod part;
mod place;
pub(crate) mod solve;
mod stitch;
#[cfg(test)]
mod topology_tests;
mod validity;

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, UVec3};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use self::cleanup::{Cleaner, Run};
use self::lattice::{CELLS, Lattice};
use self::part::{FallbackKind, Part};
use self::place::{Placer, Scene};
use self::stitch::{Stitched, Stitcher, Table};
use crate::error::Error;
use crate::mesh::{Mesh, MeshSurface};
use crate::mesher::Task;
use crate::program::{Bounds, Cell, Pruner};
use crate::report::Report;

/// Bricks from `from` to before `to`, with the program pruned to their box.
struct Block {
    from: UVec3,
    to: UVec3,
    cell: Cell,
}

/// Meshes a program with one vertex a loop, on its surfaces to rounding.
pub(crate) fn mesh(task: &Task<'_>, report: &mut Report) -> Result<Mesh, Error> {
    let start = Instant::now();
    let half = 0.5 * task.size;
    let local_bounds = Bounds {
        min: -half,
        max: half,
    };
    let scene = Scene {
        surfaces: &task.surfaces,
        origins: task.program.origins(),
        lattice: Lattice::around(&local_bounds, task.cell)?,
        // Far from the origin the surfaces' own places are rounded.
        tolerance: ON_SURFACE * task.size.max_element() + 8.0 * f64::EPSILON * task.origin.length(),
    };
    let mut pruned = 0;
    let blocks = blocks(&scene, task.program.root_cell(), &mut pruned);
    let start = report.end_stage("blocks", start);

    let stage = task.control.stage(blocks.len() as u64, 0.0, 0.7);
    let arch = pulp::Arch::new();
    let parts: Vec<Part> = blocks
        .par_iter()
        .map(|block| {
            let mut part = Part::with_room_for(cells_in(block.from, block.to));
            if task.control.check().is_ok() {
                WALKER.with_borrow_mut(|walker| {
                    arch.dispatch(WalkBlock(walker, &scene, block, &mut part));
                });
            }
            stage.add(1);
            part
        })
        .collect();
    task.control.check()?;
    let start = report.end_stage("bricks", start);

    let vertices: usize = parts.iter().map(|part| part.vertices.len()).sum();
    // The highest bit marks table entries of several loops.
    if vertices >= 1 << 31 {
        return Err(Error::TooLarge {
            what: "vertices in one mesh",
            limit: 1 << 31,
        });
    }
    let mut positions = concatenate(&parts, |part| &part.vertices);
    let least_area = LEAST_AREA * task.cell * task.cell;
    let stitcher = Stitcher::new(&parts, &positions, &task.surfaces, least_area);
    let stage = task.control.stage(parts.len() as u64, 0.7, 1.0);
    let stitched: Vec<Stitched> = (0..parts.len())
        .into_par_iter()
        .map(|part| {
            let stitched =
                TABLE.with_borrow_mut(|table| arch.dispatch(StitchPart(&stitcher, part, table)));
            stage.add(1);
            stitched
        })
        .collect();
    let mut triangles = concatenate(&stitched, |part| &part.triangles);
    let (surfaces, mut triangle_surfaces) = provenance(task, &parts, &stitched);
    let start = report.end_stage("stitch", start);
    let runs = runs(&parts, &stitched);
    let bad = bad_triangles(&stitched);
    let cleaned = Cleaner {
        positions: &positions,
        triangles: &mut triangles,
        runs: &runs,
        surfaces: &task.surfaces,
        least_area,
        // Of the rounding that vertices are allowed most is spent on their
        // own surfaces.
        tolerance: 0.25 * scene.tolerance,
    }
    .clean(&bad);
    for &triangle in &cleaned.left {
        let [p, q, r] = triangles[triangle as usize].map(|v| positions[v as usize]);
        let place = (p + q + r) / 3.0 + task.origin;
        report.add_fallback(FallbackKind::Degenerate.describe(), place);
    }
    remove_marked(&mut triangles, &cleaned.removed);
    remove_marked(&mut triangle_surfaces, &cleaned.removed);
    remove_vertices(&mut positions, &mut triangles, &cleaned.merged);
    if task.origin != DVec3::ZERO {
        positions
            .par_chunks_mut(4096)
            .for_each(|chunk| chunk.iter_mut().for_each(|p| *p += task.origin));
    }
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
        surfaces,
        ..Mesh::default()
    })
}

thread_local! {
    /// Scratch memory that every worker keeps from block to block and from
    /// mesh to mesh, some 300 KiB: fresh pages cost more than a small mesh.
    static WALKER: RefCell<Walker> = RefCell::default();
    static TABLE: RefCell<Table> = RefCell::default();
}

/// The work on one block, compiled for every SIMD level: what is inlined here
/// runs on vectors as wide as the machine's.
struct WalkBlock<'a, 's>(&'a mut Walker, &'a Scene<'s>, &'a Block, &'a mut Part);

impl pulp::WithSimd for WalkBlock<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.0.block(self.1, self.2, self.3);
    }
}

/// The same for stitching one part.
struct StitchPart<'a, 's>(&'a Stitcher<'s>, usize, &'a mut Table);

impl pulp::WithSimd for StitchPart<'_, '_> {
    type Output = Stitched;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Stitched {
        self.0.part(self.1, self.2)
    }
}

/// A point nearer to a surface than this share of the scene lies on it.
const ON_SURFACE: f64 = 2e-13;

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

/// The blocks in which something varies, in a fixed order.
fn blocks(scene: &Scene<'_>, root: Cell, pruned: &mut u64) -> Vec<Block> {
    let all = scene.lattice.bricks;
    let largest = all.max_element().div_ceil(BLOCKS_ALONG);
    let mut pruner = Pruner::default();
    let mut done = Vec::new();
    let mut pending = vec![Block {
        from: UVec3::ZERO,
        to: all,
        cell: root,
    }];
    while let Some(block) = pending.pop() {
        let (center, half) = scene.lattice.bricks_box(block.from, block.to);
        let mut cell = Cell::default();
        block
            .cell
            .prune_into(scene.surfaces, center, half, &mut pruner, &mut cell);
        let Block { from, to, .. } = block;
        if cell.constant().is_some() {
            *pruned += cells_in(from, to);
        } else if (to - from).max_element() <= largest {
            done.push(Block { from, to, cell });
        } else {
            pending.extend(children(from, to).map(|(from, to)| Block {
                from,
                to,
                cell: cell.clone(),
            }));
        }
    }
    done
}

/// One worker: walks the bricks of a block, its scratch memory reused.
#[derive(Default)]
struct Walker {
    levels: Vec<Cell>,
    pruner: Pruner,
    placer: Placer,
    pending: Vec<(UVec3, UVec3, usize)>,
}

impl Walker {
    #[inline(always)]
    fn block(&mut self, scene: &Scene<'_>, block: &Block, part: &mut Part) {
        self.pending.clear();
        self.pending.push((block.from, block.to, 0));
        while let Some((from, to, level)) = self.pending.pop() {
            if self.levels.len() <= level {
                self.levels.resize_with(level + 1, Cell::default);
            }
            let (above, below) = self.levels.split_at_mut(level);
            let cell = if let Some(parent) = above.last() {
                let (center, half) = scene.lattice.bricks_box(from, to);
                let cell = &mut below[0];
                parent.prune_into(scene.surfaces, center, half, &mut self.pruner, cell);
                cell
            } else {
                below[0].clone_from(&block.cell);
                &mut below[0]
            };
            if cell.constant().is_some() {
                part.cells_pruned += cells_in(from, to);
            } else if to - from == UVec3::ONE {
                self.placer.brick(scene, cell, from, part);
            } else {
                let halves = children(from, to).map(|(from, to)| (from, to, level + 1));
                self.pending.extend(halves);
            }
        }
    }
}

/// All lists in one, copied in parallel.
fn concatenate<T, U>(lists: &[T], list: impl Fn(&T) -> &Vec<U> + Sync) -> Vec<U>
where
    T: Sync,
    U: bytemuck::Zeroable + Copy + Send + Sync,
{
    let total = lists.iter().map(|l| list(l).len()).sum();
    // Zeroed pages come from the system untouched until they are copied to.
    let mut all: Vec<U> = bytemuck::zeroed_vec(total);
    let mut pieces = Vec::with_capacity(lists.len());
    let mut rest = all.as_mut_slice();
    for source in lists {
        let (piece, after) = rest.split_at_mut(list(source).len());
        pieces.push((piece, source));
        rest = after;
    }
    pieces
        .into_par_iter()
        .for_each(|(piece, source)| piece.copy_from_slice(list(source)));
    all
}

/// The runs of triangles on one surface.
fn runs(parts: &[Part], stitched: &[Stitched]) -> Vec<Run> {
    let groups = parts.iter().zip(stitched);
    let groups = groups.flat_map(|(part, s)| part.groups.iter().zip(&s.group_triangles));
    let mut start = 0;
    groups
        .map(|(group, &count)| {
            let run = Run {
                start,
                surface: group.surface,
                reversed: group.reversed,
            };
            start += count;
            run
        })
        .collect()
}

/// The triangles to look at again, in the whole mesh's count.
fn bad_triangles(stitched: &[Stitched]) -> Vec<u32> {
    let mut bad = Vec::new();
    let mut before = 0;
    for part in stitched {
        bad.extend(part.bad.iter().map(|&triangle| before + triangle));
        before += part.triangles.len() as u32;
    }
    bad
}

/// Removes the items at the given ascending places; the last ones take them.
fn remove_marked<T>(items: &mut Vec<T>, removed: &[u32]) {
    for &index in removed.iter().rev() {
        items.swap_remove(index as usize);
    }
}

/// Removes vertices that no triangle names any more; the last ones take their
/// places.
fn remove_vertices(
    positions: &mut Vec<DVec3>,
    triangles: &mut [[u32; 3]],
    removed: &FxHashSet<u32>,
) {
    if removed.is_empty() {
        return;
    }
    let kept = positions.len() - removed.len();
    let mut holes: Vec<u32> = removed
        .iter()
        .copied()
        .filter(|&v| (v as usize) < kept)
        .collect();
    holes.sort_unstable();
    let movers = (kept as u32..positions.len() as u32).filter(|v| !removed.contains(v));
    let moves: FxHashMap<u32, u32> = movers.zip(holes).collect();
    for (&from, &to) in &moves {
        positions[to as usize] = positions[from as usize];
    }
    positions.truncate(kept);
    triangles.par_chunks_mut(4096).for_each(|chunk| {
        for corner in chunk.iter_mut().flatten() {
            if *corner >= kept as u32 {
                *corner = moves[corner];
            }
        }
    });
}

/// The mesh's table of surfaces, in the order in which triangles first name
/// them, and the entry of every triangle.
fn provenance(
    task: &Task<'_>,
    parts: &[Part],
    stitched: &[Stitched],
) -> (Vec<MeshSurface>, Vec<u32>) {
    let mut index: FxHashMap<(u32, u32), u32> = FxHashMap::default();
    let mut surfaces = Vec::new();
    let total = stitched.iter().map(|s| s.triangles.len()).sum();
    let mut triangle_surfaces = Vec::with_capacity(total);
    for (part, stitched) in parts.iter().zip(stitched) {
        for (group, &count) in part.groups.iter().zip(&stitched.group_triangles) {
            let entry = *index
                .entry((group.surface, group.origin))
                .or_insert_with(|| {
                    let origin = &task.program.origins()[group.origin as usize];
                    surfaces.push(MeshSurface {
                        surface: group.surface,
                        primitive: group.origin,
                        name: origin.name.as_ref().map(Arc::clone),
                        color: origin.color,
                    });
                    surfaces.len() as u32 - 1
                });
            triangle_surfaces.extend(std::iter::repeat_n(entry, count as usize));
        }
    }
    (surfaces, triangle_surfaces)
}
