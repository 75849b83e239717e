//! Faces of polyhedra that nothing else comes near: each is one of the solid's as it was given,
//! or none of them, and only the rest needs to be cut by anything.
//!
//! A face is uncut if the box around it meets nothing but its own polyhedron. Of the rest a
//! solid is made that agrees with the whole one all around its faces, and is empty where only
//! uncut ones are. Its boundary ends there on planes that part space: what lies on these and on
//! uncut faces is left out, and those are put back as they are. As they share their edges with
//! the rest, and nothing crosses these, both fit.
//!
//! What is told of one face holds for all that it leads to without coming upon the rest:
//! whether it is on the boundary, that is, whether the formula's value depends on its
//! polyhedron there.

use std::ops::Range;

use glam::DVec3;

use super::lower::Finished;
use super::lowered::Lowered;
use super::outline::Outline;
use super::placed::{Convex, IsNeeded, Region};
use crate::mesh::Shells;
use crate::mesh::box_tree::{self, BoxTree, Boxed, along_curve};
use crate::numeric::Groups;
use crate::solid::partition::Part;
use crate::surface::{Bounds, Side, Surface};

/// What of a solid's boundary is uncut.
#[derive(Debug)]
pub(crate) struct Uncut {
    /// Of each surface of the rest its number, if faces on it are meant.
    pub meant: Vec<Option<u32>>,
    /// What is nearer to each other may be one vertex.
    pub margin: f64,
    pub vertices: Vec<DVec3>,
    /// The faces of the boundary, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Of each triangle the surface and the primitive.
    pub faces: Vec<(u32, u32)>,
    /// Of each triangle which of its sides, from each corner to the next, are those of faces of
    /// the rest.
    pub rims: Vec<[bool; 3]>,
}

/// Of all triangles so many must be uncut: the rest takes some ten times as long as the same
/// triangles where nothing is left out. Tunes speed only; small solids of tests have fewer.
const WORTHWHILE: f64 = if cfg!(test) { 0.1 } else { 0.9 };

impl Uncut {
    /// What of a solid is uncut, and the rest; none if that is not much.
    pub(super) fn of(outline: &Outline) -> Option<(Self, Lowered)> {
        let margin = outline.margin();
        let shells = outline.shells();
        let others = Others::new(&outline.others, outline.carriers());
        let faces: Vec<Adjacency> = outline.regions.iter().map(Adjacency::of).collect();
        let mut is_cut = shells.beside_others();
        for (triangle, is_cut) in is_cut.iter_mut().enumerate() {
            *is_cut = *is_cut || others.meet(shells.box_of(triangle, margin));
        }
        let is_cut_on = cut_surfaces(outline, shells, &faces, &is_cut);
        for (shell, region) in outline.regions.iter().enumerate() {
            let own = &mut is_cut[shells.triangles_of(shell)];
            for (is_cut, &(surface, _)) in own.iter_mut().zip(&region.surfaces) {
                *is_cut = is_cut_on[surface as usize];
            }
        }
        let uncut = is_cut.iter().filter(|&&is_cut| !is_cut).count();
        if (uncut as f64) < WORTHWHILE * is_cut.len() as f64 {
            return None;
        }
        let is_needed = |region: u32, parts: &[Part], ends: [DVec3; 2]| {
            let first = shells.triangles_of(region as usize).start;
            parts.iter().any(|part| is_cut[first + part.facet as usize])
                || shells.has_other(region, ends)
                || others.meet(ends)
        };
        let is_needed: IsNeeded<'_> = &is_needed;
        let Finished { lowered, ids } = outline.written(Some(is_needed)).ok()?;
        let is_meant = |&id: &u32| is_cut_on.get(id as usize).copied().unwrap_or(false);
        let mut found = Self {
            meant: ids
                .into_iter()
                .map(|id| Some(id).filter(is_meant))
                .collect(),
            margin,
            vertices: Vec::new(),
            triangles: Vec::new(),
            faces: Vec::new(),
            rims: Vec::new(),
        };
        found.add_all(outline, shells, &faces, &is_cut);
        Some((found, lowered))
    }

    /// Adds the uncut faces that are on the boundary.
    fn add_all(
        &mut self,
        outline: &Outline,
        shells: &Shells,
        faces: &[Adjacency],
        is_cut: &[bool],
    ) {
        let all_patches = Patches::of(outline, shells, faces, is_cut);
        let patches = all_patches.tell(outline).into_iter();
        // Of the vertices of the region that comes next.
        let mut vertex_of: Vec<Option<u32>> = Vec::new();
        let mut current = None;
        for (patch, is_flipped) in all_patches.all.iter().zip(patches) {
            let Some(is_flipped) = is_flipped else {
                continue;
            };
            let number = patch.region as usize;
            let (region, faces) = (&outline.regions[number], &faces[number]);
            let is_cut = &is_cut[shells.triangles_of(number)];
            if current.replace(number) != Some(number) {
                vertex_of.clear();
                vertex_of.resize(region.vertices.len(), None);
            }
            for &triangle in &all_patches.triangles[patch.triangles.clone()] {
                let index = triangle as usize;
                let mut corners = region.triangles[index].map(|vertex| {
                    *vertex_of[vertex as usize].get_or_insert_with(|| {
                        self.vertices.push(region.vertices[vertex as usize]);
                        self.vertices.len() as u32 - 1
                    })
                });
                let mut rims = faces.twins[index].map(|twin| is_cut[twin as usize]);
                if is_flipped {
                    corners.swap(1, 2);
                    rims.swap(0, 2);
                }
                self.triangles.push(corners);
                self.faces.push((region.surfaces[index].0, region.origin));
                self.rims.push(rims);
            }
        }
    }

    /// The box around the uncut faces.
    pub fn bounds(&self) -> Bounds {
        let corners = self.vertices.iter();
        corners.fold(Bounds::NOTHING, |all, &v| {
            all.united(Bounds::around(v, DVec3::ZERO))
        })
    }
}

/// Which surfaces carry faces that may be cut: with all of one surface, as they may be one
/// face, and of both if edges of only two go on straight over a vertex, which is none then.
fn cut_surfaces(
    outline: &Outline,
    shells: &Shells,
    faces: &[Adjacency],
    is_cut: &[bool],
) -> Vec<bool> {
    let count = outline.carriers().len();
    let mut groups = Groups::new(count);
    let mut is_cut_on = vec![false; count];
    for other in &outline.others {
        for &(surface, _) in &other.half_spaces {
            is_cut_on[surface as usize] = true;
        }
    }
    for ((shell, region), faces) in outline.regions.iter().enumerate().zip(faces) {
        let is_cut = &is_cut[shells.triangles_of(shell)];
        for (index, &(surface, _)) in region.surfaces.iter().enumerate() {
            is_cut_on[surface as usize] |= is_cut[index] || faces.is_odd[index];
        }
        for vertex in 0..region.vertices.len() {
            let around = faces.around(vertex).iter();
            let mut around = around.map(|&triangle| region.surfaces[triangle as usize].0);
            let Some(first) = around.next() else {
                continue;
            };
            let Some(second) = around.find(|&surface| surface != first) else {
                continue;
            };
            if around.all(|surface| surface == first || surface == second) {
                groups.join([first, second]);
            }
        }
    }
    for surface in 0..count {
        let group = groups.first(surface as u32) as usize;
        is_cut_on[group] |= is_cut_on[surface];
    }
    (0..count as u32)
        .map(|surface| is_cut_on[groups.first(surface) as usize])
        .collect()
}

/// Which triangles of a polyhedron are beside each other.
struct Adjacency {
    /// Of each triangle the others at its sides, from each corner to the next.
    twins: Vec<[u32; 3]>,
    /// Whether a triangle is where the polyhedron touches itself.
    is_odd: Vec<bool>,
    /// The triangles around each vertex, and where these begin.
    triangles_at: Vec<u32>,
    first_at: Vec<u32>,
}

impl Adjacency {
    fn of(region: &Region) -> Self {
        let mut first_at = vec![0u32; region.vertices.len() + 2];
        for &vertex in region.triangles.iter().flatten() {
            first_at[vertex as usize + 2] += 1;
        }
        for vertex in 2..first_at.len() {
            first_at[vertex] += first_at[vertex - 1];
        }
        let mut triangles_at = vec![0u32; 3 * region.triangles.len()];
        for (index, triangle) in (0u32..).zip(&region.triangles) {
            for &vertex in triangle {
                let slot = &mut first_at[vertex as usize + 1];
                triangles_at[*slot as usize] = index;
                *slot += 1;
            }
        }
        first_at.pop();
        let mut all = Self {
            twins: Vec::with_capacity(region.triangles.len()),
            is_odd: vec![false; region.triangles.len()],
            triangles_at,
            first_at,
        };
        for (index, &triangle) in region.triangles.iter().enumerate() {
            let twins = [0, 1, 2].map(|k| all.beside(region, triangle[k], triangle[(k + 1) % 3]));
            all.is_odd[index] = twins.contains(&None);
            all.twins
                .push(twins.map(|twin| twin.unwrap_or(index as u32)));
        }
        for vertex in 0..region.vertices.len() {
            if !all.is_fan(region, vertex as u32) {
                let ends = [0, 1].map(|k| all.first_at[vertex + k] as usize);
                for &triangle in &all.triangles_at[ends[0]..ends[1]] {
                    all.is_odd[triangle as usize] = true;
                }
            }
        }
        all
    }

    fn around(&self, vertex: usize) -> &[u32] {
        &self.triangles_at[self.first_at[vertex] as usize..self.first_at[vertex + 1] as usize]
    }

    /// The triangle on the other side of an edge; none if two or more run along it.
    fn beside(&self, region: &Region, from: u32, to: u32) -> Option<u32> {
        let mut twin = None;
        let mut along = 0;
        for &other in self.around(from as usize) {
            let corners = region.triangles[other as usize];
            for k in 0..3 {
                match [corners[k], corners[(k + 1) % 3]] {
                    [a, b] if [a, b] == [from, to] => along += 1,
                    [a, b] if [a, b] == [to, from] => {
                        along += 1;
                        twin = Some(other);
                    }
                    _ => {}
                }
            }
        }
        twin.filter(|_| along == 2)
    }

    /// Whether the triangles around a vertex lead around it once.
    fn is_fan(&self, region: &Region, vertex: u32) -> bool {
        let around = self.around(vertex as usize);
        let Some(&start) = around.first() else {
            return true;
        };
        let mut at = start;
        for count in 1..=around.len() {
            let corners = region.triangles[at as usize];
            let Some(k) = corners.iter().position(|&corner| corner == vertex) else {
                return false;
            };
            at = self.twins[at as usize][k];
            if at == start {
                return count == around.len();
            }
        }
        false
    }
}

/// The primitives that are no polyhedra.
struct Others<'a> {
    convex: &'a [Convex],
    surfaces: &'a [Surface],
    tree: BoxTree,
}

impl<'a> Others<'a> {
    fn new(convex: &'a [Convex], surfaces: &'a [Surface]) -> Self {
        let boxes = convex.iter().map(|convex| box_tree::Bounds {
            low: convex.bounds.min,
            high: convex.bounds.max,
        });
        let boxes: Vec<box_tree::Bounds> = boxes.collect();
        let order = along_curve(boxes.iter().copied()).into_iter();
        let entries = order.map(|index| Boxed {
            bounds: boxes[index as usize],
            index,
            sheet: 0,
        });
        Self {
            convex,
            surfaces,
            tree: BoxTree::new(entries.collect()),
        }
    }

    /// Whether the boundary of one may be in a box.
    fn meet(&self, [low, high]: [DVec3; 2]) -> bool {
        if self.convex.is_empty() {
            return false;
        }
        let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
        let is_met = |index: u32| {
            let mut crosses = false;
            for &(surface, is_before) in &self.convex[index as usize].half_spaces {
                match self.surfaces[surface as usize].side_of_box(center, half) {
                    Side::Crossing => crosses = true,
                    side if (side == Side::Outside) != is_before => return false,
                    _ => {}
                }
            }
            crosses
        };
        let bounds = box_tree::Bounds { low, high };
        self.tree.any_overlapping(None, &bounds, &mut { is_met })
    }
}

/// Uncut faces of a region that lead to each other.
struct Patch {
    region: u32,
    triangles: Range<usize>,
    /// In one of them.
    point: DVec3,
}

/// All uncut faces.
struct Patches {
    all: Vec<Patch>,
    /// The numbers of their triangles, ascending in each.
    triangles: Vec<u32>,
}

impl Patches {
    fn of(outline: &Outline, shells: &Shells, faces: &[Adjacency], is_cut: &[bool]) -> Self {
        let mut found = Self {
            all: Vec::new(),
            triangles: Vec::new(),
        };
        let mut waiting = Vec::new();
        for ((number, region), faces) in (0u32..).zip(&outline.regions).zip(faces) {
            let mut is_done = is_cut[shells.triangles_of(number as usize)].to_vec();
            for start in 0..is_done.len() as u32 {
                if std::mem::replace(&mut is_done[start as usize], true) {
                    continue;
                }
                let first = found.triangles.len();
                waiting.push(start);
                while let Some(triangle) = waiting.pop() {
                    found.triangles.push(triangle);
                    for &twin in &faces.twins[triangle as usize] {
                        if !std::mem::replace(&mut is_done[twin as usize], true) {
                            waiting.push(twin);
                        }
                    }
                }
                let own = &mut found.triangles[first..];
                own.sort_unstable();
                // The largest of some.
                let corners = |&triangle: &u32| region.corners(region.triangles[triangle as usize]);
                let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length_squared();
                let some = own.iter().step_by(own.len().div_ceil(64)).map(corners);
                let largest = some.max_by(|&s, &t| area(s).total_cmp(&area(t)));
                let corners = largest.unwrap_or_default();
                found.all.push(Patch {
                    region: number,
                    triangles: first..found.triangles.len(),
                    point: corners.into_iter().sum::<DVec3>() / 3.0,
                });
            }
        }
        found
    }

    /// Of each whether it is the other way round on the boundary; none if it is not there. 64
    /// at once.
    fn tell(&self, outline: &Outline) -> Vec<Option<bool>> {
        let cell = outline.cell();
        let mut told = Vec::with_capacity(self.all.len());
        let mut words = vec![0u64; cell.surfaces.len()];
        let mut gates = Vec::new();
        for some in self.all.chunks(64) {
            words.fill(0);
            for (bit, patch) in some.iter().enumerate() {
                let mut tell = |place: usize| words[place] |= 1 << bit;
                outline.insides(patch.point, Some(patch.region), &mut tell);
            }
            let mut value = |words: &[u64]| {
                let formula = &cell.formula;
                formula.evaluate_words(&mut gates, |_, place| words[place as usize])
            };
            let without = value(&words);
            for (bit, patch) in some.iter().enumerate() {
                if let Some(place) = outline.place_of(patch.region) {
                    words[place] |= 1 << bit;
                }
            }
            let with = value(&words);
            told.extend((0..some.len()).map(|bit| {
                let [with, without] = [with, without].map(|word| word >> bit & 1 == 1);
                (with != without).then_some(without)
            }));
        }
        told
    }
}
