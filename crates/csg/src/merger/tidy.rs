//! Cleaning up a mesh in slabs: from the triangles around bad ones alone.
//!
//! A collapse in the first pass changes triangles at corners of bad ones; the
//! second one looks at the stars of these triangles' corners and of the corners
//! of those. So what may matter are the triangles at corners of bad ones, those
//! at their corners, and those at the corners of these, from whatever slabs.
//! What is done with them is what would be done in the whole mesh.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::slabs::{OwnedTriangle, Slabs};
use crate::error::Error;
use crate::program::Surface;
use crate::report::PLACES_PER_FALLBACK;
use crate::surface_nets::cleanup::{self, Cleaner, Run, UNRESOLVED_SHARE};
use crate::surface_nets::slab::{SlabEntry, SlabSource};

/// What cleaning up changes, by the numbers of vertices and triangles before.
#[derive(Debug, Default)]
pub(super) struct Edits {
    /// Triangles with other corners, in ascending order.
    pub altered: Vec<(u64, [u32; 3])>,
    /// Triangles from the end that take the places of removed ones, by these in
    /// ascending order.
    pub moved: Vec<(u64, OwnedTriangle)>,
    /// How many triangles are removed, and how many of them have a colour.
    pub removed: u64,
    pub removed_colored: u64,
    /// How many vertices are merged into others.
    pub merged: usize,
    /// Vertices that are merged, with the places of those from the end that
    /// come in their stead.
    pub filled: Vec<(u32, DVec3)>,
    /// These by what they were.
    pub renamed: FxHashMap<u32, u32>,
    /// How many triangles stay bad, and where the first are, in model units.
    pub left: u64,
    pub left_at: Vec<DVec3>,
    /// Where corners of altered and moved triangles are.
    places: FxHashMap<u32, DVec3>,
}

impl Edits {
    pub fn place(&self, vertex: u32) -> DVec3 {
        self.places.get(&vertex).copied().unwrap_or(DVec3::NAN)
    }

    /// What there is to do for a mesh.
    pub fn of<S: SlabSource>(slabs: &Slabs<S>) -> Result<Self, Error> {
        let mut edits = Self::default();
        let (bad, left) = bad_triangles(slabs);
        let first_left = &left[..left.len().min(PLACES_PER_FALLBACK)];
        let mut around = Around::of(slabs, &bad, first_left)?;
        let (removed, merged, still_bad) = around.clean(slabs, &bad);
        edits.left = (left.len() + still_bad.len()) as u64;
        let first_left = left.iter().chain(&still_bad).take(PLACES_PER_FALLBACK);
        let origin = slabs.first().origin;
        for triangle in first_left {
            let [p, q, r] = around.corners(*triangle).map(|v| around.place(v));
            edits.left_at.push((p + q + r) / 3.0 + origin);
        }
        edits.removed = removed.len() as u64;
        let colored = |triangle: &&u64| around.triangle(**triangle).entry.color.is_some();
        edits.removed_colored = removed.iter().filter(colored).count() as u64;
        edits.merged = merged.len();
        edits.altered = around
            .altered
            .iter()
            .map(|&t| (t, around.corners(t)))
            .collect();
        edits.close_gaps_in_triangles(slabs, &removed)?;
        edits.close_gaps_in_vertices(slabs, &merged)?;
        // Places of corners, for those who want them.
        let corners = edits.altered.iter().map(|&(_, corners)| corners);
        let corners = corners.chain(edits.moved.iter().map(|(_, moved)| moved.corners));
        let corners = corners.chain(slabs.further.iter().map(|further| further.corners));
        edits.places = places(slabs, corners.flatten().collect())?;
        Ok(edits)
    }

    /// The last triangles take the places of removed ones, as when these are
    /// taken out of a list one by one, the last one first.
    fn close_gaps_in_triangles<S: SlabSource>(
        &mut self,
        slabs: &Slabs<S>,
        removed: &[u64],
    ) -> Result<(), Error> {
        let mut now_at: FxHashMap<u64, u64> = FxHashMap::default();
        let mut end = slabs.all_triangles();
        for &triangle in removed.iter().rev() {
            end -= 1;
            let last = now_at.get(&end).copied().unwrap_or(end);
            now_at.insert(triangle, last);
        }
        let mut moved: Vec<(u64, u64)> = now_at.into_iter().filter(|&(to, _)| to < end).collect();
        moved.sort_unstable();
        let mut wanted: Vec<u64> = moved.iter().map(|&(_, from)| from).collect();
        wanted.sort_unstable();
        let mut found: FxHashMap<u64, OwnedTriangle> = FxHashMap::default();
        for_each_triangle(
            slabs,
            |range| is_any_in(&wanted, &range),
            |number, triangle| {
                if wanted.binary_search(&number).is_ok() {
                    found.insert(number, triangle.owned());
                }
            },
        )?;
        for &(number, corners) in &self.altered {
            if let Some(triangle) = found.get_mut(&number) {
                triangle.corners = corners;
            }
        }
        let moved = moved.into_iter();
        self.moved = moved
            .filter_map(|(to, from)| Some((to, found.get(&from)?.clone())))
            .collect();
        Ok(())
    }

    /// The last vertices take the places of merged ones.
    fn close_gaps_in_vertices<S: SlabSource>(
        &mut self,
        slabs: &Slabs<S>,
        merged: &FxHashSet<u32>,
    ) -> Result<(), Error> {
        let all = slabs.vertices();
        let kept = all - merged.len() as u32;
        let mut holes: Vec<u32> = merged.iter().copied().filter(|&v| v < kept).collect();
        holes.sort_unstable();
        let last: Vec<u32> = (kept..all)
            .filter(|vertex| !merged.contains(vertex))
            .collect();
        let places = places(slabs, last.clone())?;
        self.filled = holes
            .iter()
            .zip(&last)
            .map(|(&hole, vertex)| (hole, places[vertex]))
            .collect();
        self.renamed = last.into_iter().zip(holes).collect();
        Ok(())
    }
}

/// The bad triangles that are to be taken out, and those that are not worth the
/// while, each in ascending order.
fn bad_triangles<S: SlabSource>(slabs: &Slabs<S>) -> (Vec<u64>, Vec<u64>) {
    // A block may have bricks in several slabs.
    let heads = slabs.heads();
    let blocks = heads.clone().flat_map(|head| &head.blocks);
    let unresolved: FxHashSet<u64> = blocks
        .filter(|(_, is_unresolved)| *is_unresolved)
        .map(|&(block, _)| block)
        .collect();
    let mut bad: Vec<(u64, bool)> = Vec::new();
    let mut further = slabs.first_triangle(slabs.len());
    for (slab, head) in heads.enumerate() {
        for &(triangle, block) in &head.bad {
            let number = match triangle.checked_sub(head.triangles) {
                None => slabs.first_triangle(slab) + u64::from(triangle),
                Some(after) => further + u64::from(after),
            };
            let block = block.map(|block| head.blocks[block as usize].0);
            bad.push((
                number,
                block.is_some_and(|block| unresolved.contains(&block)),
            ));
        }
        further += u64::from(head.further);
    }
    bad.sort_unstable();
    let all = slabs.all_triangles() as usize;
    let mut left = Vec::new();
    if cleanup::are_many(bad.len(), all, UNRESOLVED_SHARE) {
        left.extend(bad.extract_if(.., |&mut (_, unresolved)| unresolved));
    }
    let numbers = |bad: Vec<(u64, bool)>| bad.into_iter().map(|(number, _)| number).collect();
    (numbers(bad), numbers(left))
}

/// A triangle of a slab at hand.
struct Seen<'a> {
    corners: [u32; 3],
    entry: &'a SlabEntry,
    reversed: bool,
}

impl Seen<'_> {
    fn owned(&self) -> OwnedTriangle {
        OwnedTriangle {
            corners: self.corners,
            entry: Arc::new(self.entry.clone()),
            reversed: self.reversed,
        }
    }
}

/// Calls `visit` for every triangle of the slabs that are wanted, by the range
/// of their triangles, and of the further ones; in ascending order.
fn for_each_triangle<S: SlabSource>(
    slabs: &Slabs<S>,
    is_wanted: impl Fn(Range<u64>) -> bool,
    mut visit: impl FnMut(u64, &Seen<'_>),
) -> Result<(), Error> {
    for slab in 0..slabs.len() {
        let numbers = slabs.first_triangle(slab)..slabs.first_triangle(slab + 1);
        if numbers.is_empty() || !is_wanted(numbers.clone()) {
            continue;
        }
        let opened = slabs.open(slab)?;
        let triangles = slabs.global_triangles(slab, &opened)?;
        let mut numbered = numbers.zip(triangles);
        for group in &opened.body.groups {
            let entry = &opened.body.entries[group.entry as usize];
            for (number, corners) in numbered.by_ref().take(group.triangles as usize) {
                let seen = Seen {
                    corners,
                    entry,
                    reversed: group.reversed,
                };
                visit(number, &seen);
            }
        }
    }
    for (number, triangle) in (slabs.first_triangle(slabs.len())..).zip(&slabs.further) {
        let seen = Seen {
            corners: triangle.corners,
            entry: &triangle.entry,
            reversed: triangle.reversed,
        };
        visit(number, &seen);
    }
    Ok(())
}

/// Whether any of some numbers in ascending order is in a range.
fn is_any_in(numbers: &[u64], range: &Range<u64>) -> bool {
    let first = numbers.partition_point(|&number| number < range.start);
    numbers.get(first).is_some_and(|&number| number < range.end)
}

/// Where vertices are, about the middle of the bounds.
fn places<S: SlabSource>(
    slabs: &Slabs<S>,
    mut vertices: Vec<u32>,
) -> Result<FxHashMap<u32, DVec3>, Error> {
    vertices.sort_unstable();
    vertices.dedup();
    let mut places = FxHashMap::default();
    let mut vertices = vertices.into_iter().peekable();
    for slab in 0..slabs.len() {
        let own = slabs.vertices_of(slab);
        if vertices.peek().is_none_or(|&vertex| vertex >= own.end) {
            continue;
        }
        let positions = slabs.local_positions(slab)?;
        while let Some(vertex) = vertices.next_if(|&vertex| vertex < own.end) {
            places.insert(vertex, positions[(vertex - own.start) as usize]);
        }
    }
    Ok(places)
}

/// A bit for every vertex.
struct VertexSet(Vec<u64>);

impl VertexSet {
    fn none_of(count: usize) -> Self {
        Self(vec![0; count.div_ceil(64)])
    }

    fn insert(&mut self, vertices: [u32; 3]) {
        for vertex in vertices {
            self.0[vertex as usize / 64] |= 1 << (vertex % 64);
        }
    }

    fn contains(&self, vertex: u32) -> bool {
        self.0[vertex as usize / 64] >> (vertex % 64) & 1 == 1
    }
}

/// The triangles around bad ones, by themselves, in the order of the mesh.
#[derive(Default)]
struct Around {
    numbers: Vec<u64>,
    /// With the corners' numbers in the mesh.
    triangles: Vec<OwnedTriangle>,
    altered: Vec<u64>,
    places: FxHashMap<u32, DVec3>,
}

impl Around {
    fn of<S: SlabSource>(slabs: &Slabs<S>, bad: &[u64], left: &[u64]) -> Result<Self, Error> {
        const RINGS: usize = 3;
        let mut around = Self::default();
        if bad.is_empty() && left.is_empty() {
            return Ok(around);
        }
        let all = slabs.vertices() as usize;
        let mut vertices = VertexSet::none_of(all);
        if !bad.is_empty() {
            let has_bad = |range| is_any_in(bad, &range);
            for_each_triangle(slabs, has_bad, |number, triangle| {
                if bad.binary_search(&number).is_ok() {
                    vertices.insert(triangle.corners);
                }
            })?;
        }
        for _ in 1..RINGS {
            let mut next = VertexSet::none_of(all);
            for_each_triangle(
                slabs,
                |_| !bad.is_empty(),
                |_, triangle| {
                    if triangle.corners.iter().any(|&v| vertices.contains(v)) {
                        next.insert(triangle.corners);
                    }
                },
            )?;
            vertices = next;
        }
        // What lies on a surface shares what is known of it.
        let mut known: FxHashMap<(u32, u32), Arc<SlabEntry>> = FxHashMap::default();
        for_each_triangle(
            slabs,
            |_| true,
            |number, triangle| {
                if triangle.corners.iter().any(|&v| vertices.contains(v)) || left.contains(&number)
                {
                    let key = (triangle.entry.surface, triangle.entry.primitive);
                    let entry = known
                        .entry(key)
                        .or_insert_with(|| Arc::new(triangle.entry.clone()));
                    around.numbers.push(number);
                    around.triangles.push(OwnedTriangle {
                        corners: triangle.corners,
                        entry: Arc::clone(entry),
                        reversed: triangle.reversed,
                    });
                }
            },
        )?;
        let corners = around
            .triangles
            .iter()
            .flat_map(|triangle| triangle.corners);
        around.places = places(slabs, corners.collect())?;
        Ok(around)
    }

    /// The triangles that go, the vertices that are merged, and the triangles
    /// that stay bad; the others are changed here.
    fn clean<S: SlabSource>(
        &mut self,
        slabs: &Slabs<S>,
        bad: &[u64],
    ) -> (Vec<u64>, FxHashSet<u32>, Vec<u64>) {
        if bad.is_empty() {
            return Default::default();
        }
        let head = slabs.first();
        // Vertices, triangles and surfaces by themselves, their order kept.
        let mut vertices: Vec<u32> = self.places.keys().copied().collect();
        vertices.sort_unstable();
        let positions: Vec<DVec3> = vertices.iter().map(|vertex| self.places[vertex]).collect();
        let local = |vertex: u32| vertices.partition_point(|&other| other < vertex) as u32;
        let corners = self
            .triangles
            .iter()
            .map(|triangle| triangle.corners.map(local));
        let mut triangles: Vec<[u32; 3]> = corners.collect();
        let mut numbers: FxHashMap<u32, u32> = FxHashMap::default();
        let mut surfaces: Vec<Surface> = Vec::new();
        let runs = (0..).zip(&self.triangles).map(|(start, triangle)| Run {
            start,
            surface: *numbers.entry(triangle.entry.surface).or_insert_with(|| {
                surfaces.push(triangle.entry.shape.relative_to(head.origin));
                surfaces.len() as u32 - 1
            }),
            reversed: triangle.reversed,
        });
        let runs: Vec<Run> = runs.collect();
        let bad: Vec<u32> = bad.iter().map(|&number| self.at(number) as u32).collect();
        let count = triangles.len();
        let cleaned = Cleaner {
            positions: &positions,
            triangles: &mut triangles,
            count: slabs.all_triangles() as usize,
            runs: &runs,
            near: |_: &[u32]| std::iter::once(0..count).collect(),
            unresolved: Vec::new(),
            surfaces: &surfaces,
            least_area: head.least_area,
            tolerance: head.tolerance,
        }
        .clean(&bad);
        for &at in &cleaned.altered {
            let corners = triangles[at as usize].map(|vertex| vertices[vertex as usize]);
            self.triangles[at as usize].corners = corners;
        }
        let number = |&at: &u32| self.numbers[at as usize];
        let mut altered: Vec<u64> = cleaned.altered.iter().map(number).collect();
        altered.dedup();
        let removed = cleaned.removed.iter().map(number).collect();
        let left = cleaned.left.iter().map(number).collect();
        self.altered = altered;
        let merged = cleaned.merged.into_iter();
        let merged = merged.map(|vertex| vertices[vertex as usize]);
        (removed, merged.collect(), left)
    }

    fn at(&self, number: u64) -> usize {
        self.numbers.partition_point(|&other| other < number)
    }

    fn triangle(&self, number: u64) -> &OwnedTriangle {
        &self.triangles[self.at(number)]
    }

    fn corners(&self, number: u64) -> [u32; 3] {
        self.triangle(number).corners
    }

    fn place(&self, vertex: u32) -> DVec3 {
        self.places[&vertex]
    }
}
