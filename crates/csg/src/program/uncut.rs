//! Faces of polyhedra that nothing else comes near: each is one of the solid's as it was given,
//! or none of them, and only the rest needs to be cut by anything.
//!
//! A face is uncut if the box around it meets nothing but its own polyhedron, or is a piece of one
//! that clearly crosses others ([`super::crossed`]). Of the rest a
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
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::crossed::{Crossed, Soup};
use super::lower::Finished;
use super::lowered::Lowered;
use super::outline::Outline;
use super::placed::{Convex, IsNeeded, Region};
use crate::mesh::box_tree::{self, BoxTree};
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
        let given = outline.regions.par_iter();
        let parted: Vec<(Option<Region>, Adjacency)> = given.map(Adjacency::parted).collect();
        let (parted, faces): (Vec<_>, Vec<_>) = parted.into_iter().unzip();
        let regions = outline.regions.iter().zip(&parted);
        let regions: Vec<&Region> = regions
            .map(|(r, parted)| parted.as_ref().unwrap_or(r))
            .collect();
        let mut soup = Soup::new(&regions, shells, margin);
        let crossed = Crossed::of(&mut soup);
        let count = outline.regions.iter().map(|r| r.triangles.len()).sum();
        let is_met = |triangle: usize| others.meet(shells.box_of(triangle, margin));
        let all_surfaces = || outline.regions.iter().flat_map(|region| &region.surfaces);
        let mut on_surface = vec![0u32; outline.carriers().len()];
        for &(surface, _) in all_surfaces() {
            on_surface[surface as usize] += 1;
        }
        let surface_of = |triangle: u32| {
            let (region, index) = soup.place_of(triangle);
            outline.regions[region].surfaces[index].0
        };
        let is_one_of_several = |triangle: u32| on_surface[surface_of(triangle) as usize] > 1;
        let mut is_cut: Vec<bool> = (0..count).into_par_iter().map(is_met).collect();
        for &triangle in &crossed.in_doubt {
            is_cut[triangle as usize] = true;
        }
        let is_cut_on = loop {
            let is_cut_on = cut_surfaces(outline, &regions, &faces, &is_cut);
            for (is_cut, &(surface, _)) in is_cut.iter_mut().zip(all_surfaces()) {
                *is_cut = is_cut_on[surface as usize];
            }
            if !crossed.cut_where_faces_are_one(&mut is_cut, &is_one_of_several) {
                break is_cut_on;
            }
        };
        let uncut = is_cut.iter().filter(|&&is_cut| !is_cut).count();
        if (uncut as f64) < WORTHWHILE * is_cut.len() as f64 {
            return None;
        }
        let is_needed = |region: u32, parts: &[Part], ends: [DVec3; 2]| {
            let first = shells.triangles_of(region as usize).start;
            parts.iter().any(|part| is_cut[first + part.facet as usize])
                || shells.has_other(region, ends, |triangle| is_cut[triangle as usize])
                || others.meet(ends)
        };
        let is_needed: IsNeeded<'_> = &is_needed;
        let Finished { lowered, ids } = if others.convex.is_empty() && uncut == is_cut.len() {
            Finished::NOTHING
        } else {
            outline.written(Some(is_needed)).ok()?
        };
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
        let pieces = Pieces::of(&soup, &crossed, &faces, &is_cut);
        let patches = Patches::of(&pieces, outline);
        let idle = patches.idle_lines(&pieces);
        let is_whole = if idle.is_empty() {
            found.add_all(outline, &pieces, &patches)
        } else {
            // These have no vertices at their ends in the rest, either.
            let crossed = crossed.without(&soup, &idle);
            let pieces = Pieces::of(&soup, &crossed, &faces, &is_cut);
            found.add_all(outline, &pieces, &Patches::of(&pieces, outline))
        };
        is_whole.then_some((found, lowered))
    }

    /// Adds the pieces that are on the boundary; whether it ends nowhere but beside the rest.
    fn add_all(&mut self, outline: &Outline, pieces: &Pieces<'_>, patches: &Patches) -> bool {
        let mut vertex_of: Vec<Option<u32>> = vec![None; pieces.soup.points.len()];
        // Where two polyhedra cross, by their ends.
        let mut open: FxHashSet<[u32; 2]> = FxHashSet::default();
        for (patch, is_flipped) in patches.all.iter().zip(&patches.told) {
            let &Some(is_flipped) = is_flipped else {
                continue;
            };
            for &piece in &patches.pieces[patch.pieces.clone()] {
                let mut corners = pieces.corners(piece);
                let mut beyond = [0, 1, 2].map(|side| pieces.beyond(piece, side));
                if is_flipped {
                    corners.swap(1, 2);
                    beyond.swap(0, 2);
                }
                for side in 0..3 {
                    let [from, to] = [corners[side], corners[(side + 1) % 3]];
                    if beyond[side] == Beyond::Line && !open.remove(&[to, from]) {
                        // (Twice if both polyhedra are on the boundary on both sides.)
                        if !open.insert([from, to]) {
                            return false;
                        }
                    }
                }
                self.triangles.push(corners.map(|vertex| {
                    *vertex_of[vertex as usize].get_or_insert_with(|| {
                        self.vertices.push(pieces.soup.points[vertex as usize]);
                        self.vertices.len() as u32 - 1
                    })
                }));
                let (region, triangle) = pieces.soup.place_of(pieces.owner(piece));
                let region = &outline.regions[region];
                self.faces
                    .push((region.surfaces[triangle].0, region.origin));
                self.rims.push(beyond.map(|beyond| beyond == Beyond::Rest));
            }
        }
        open.is_empty()
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
    regions: &[&Region],
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
    for ((shell, region), faces) in regions.iter().enumerate().zip(faces) {
        let is_cut = &is_cut[outline.shells().triangles_of(shell)];
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
    /// Whether a triangle is where the polyhedron touches itself, or is not closed.
    is_odd: Vec<bool>,
    /// The triangles around each vertex, and where these begin.
    triangles_at: Vec<u32>,
    first_at: Vec<u32>,
}

impl Adjacency {
    /// Of a polyhedron that does not touch itself, or of one like it that does not.
    fn parted(region: &Region) -> (Option<Region>, Self) {
        let all = Self::of(region);
        if !all.is_odd.contains(&true) {
            return (None, all);
        }
        let parted = region.parted();
        let all = Self::of(&parted);
        (Some(parted), all)
    }

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
        Self {
            convex,
            surfaces,
            tree: BoxTree::numbered(&boxes),
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

/// What is on the other side of a side of a piece.
#[derive(Clone, Copy, PartialEq)]
enum Beyond {
    /// Another piece of the same polyhedron.
    Piece(u32),
    /// A line in which another polyhedron crosses.
    Line,
    /// What is cut by half-spaces.
    Rest,
}

/// Uncut triangles, and behind all triangles the pieces of those that are crossed.
struct Pieces<'a> {
    soup: &'a Soup<'a>,
    crossed: &'a Crossed,
    faces: &'a [Adjacency],
    is_cut: &'a [bool],
    /// Whether a triangle is uncut.
    is_whole: Vec<bool>,
    /// Each, and the triangle that it is a piece of.
    parts: Vec<([u32; 3], u32)>,
    /// The pieces by their sides.
    by_side: FxHashMap<[u32; 2], u32>,
}

impl<'a> Pieces<'a> {
    fn of(
        soup: &'a Soup<'a>,
        crossed: &'a Crossed,
        faces: &'a [Adjacency],
        is_cut: &'a [bool],
    ) -> Self {
        let mut found = Self {
            soup,
            crossed,
            faces,
            is_cut,
            is_whole: is_cut.iter().map(|is_cut| !is_cut).collect(),
            parts: Vec::new(),
            by_side: FxHashMap::default(),
        };
        for (triangle, pieces) in &crossed.all {
            if !std::mem::replace(&mut found.is_whole[*triangle as usize], false) {
                continue;
            }
            for &corners in pieces {
                let piece = (is_cut.len() + found.parts.len()) as u32;
                found.parts.push((corners, *triangle));
                let sides = [0, 1, 2].map(|k| [corners[k], corners[(k + 1) % 3]]);
                found.by_side.extend(sides.map(|side| (side, piece)));
            }
        }
        found
    }

    fn part(&self, piece: u32) -> Option<&([u32; 3], u32)> {
        let index = (piece as usize).checked_sub(self.is_cut.len());
        index.map(|index| &self.parts[index])
    }

    /// The triangle that a piece is of.
    fn owner(&self, piece: u32) -> u32 {
        self.part(piece).map_or(piece, |&(_, triangle)| triangle)
    }

    fn corners(&self, piece: u32) -> [u32; 3] {
        let part = self.part(piece);
        part.map_or_else(|| self.soup.corners(piece), |&(corners, _)| corners)
    }

    fn beyond(&self, piece: u32, side: usize) -> Beyond {
        let owner = self.owner(piece);
        let (region, index) = self.soup.place_of(owner);
        // The triangle beside the owner.
        let twin = |side: usize| owner - index as u32 + self.faces[region].twins[index][side];
        if piece == owner && self.is_whole[twin(side) as usize] {
            return Beyond::Piece(twin(side));
        }
        let corners = self.corners(piece);
        let [from, to] = [corners[side], corners[(side + 1) % 3]];
        if let Some(line) = self.crossed.lines.get(&[from.min(to), from.max(to)]) {
            let is_cut = line.iter().any(|&triangle| self.is_cut[triangle as usize]);
            return if is_cut { Beyond::Rest } else { Beyond::Line };
        }
        if let Some(&piece) = self.by_side.get(&[to, from]) {
            return Beyond::Piece(piece);
        }
        // A whole side of the owner, or part of one, beyond which there are other parts.
        let own = self.soup.corners(owner);
        let whole = (0..3).find(|&k| own[k] == from && own[(k + 1) % 3] == to);
        match whole.map(twin) {
            Some(twin) if !self.is_cut[twin as usize] => Beyond::Piece(twin),
            _ => Beyond::Rest,
        }
    }
}

/// Pieces of a region that lead to each other.
struct Patch {
    region: u32,
    pieces: Range<usize>,
    /// In one of them.
    point: DVec3,
}

/// All pieces.
struct Patches {
    all: Vec<Patch>,
    /// Their numbers, ascending in each.
    pieces: Vec<u32>,
    /// Of each patch whether it is the other way round on the boundary; none if it is not there.
    told: Vec<Option<bool>>,
}

impl Patches {
    fn of(pieces: &Pieces<'_>, outline: &Outline) -> Self {
        let mut found = Self {
            all: Vec::new(),
            pieces: Vec::new(),
            told: Vec::new(),
        };
        let mut waiting = Vec::new();
        let mut is_done: Vec<bool> = pieces.is_whole.iter().map(|is_whole| !is_whole).collect();
        is_done.resize(is_done.len() + pieces.parts.len(), false);
        for start in 0..is_done.len() as u32 {
            if std::mem::replace(&mut is_done[start as usize], true) {
                continue;
            }
            let first = found.pieces.len();
            waiting.push(start);
            while let Some(piece) = waiting.pop() {
                found.pieces.push(piece);
                for side in 0..3 {
                    if let Beyond::Piece(other) = pieces.beyond(piece, side)
                        && !std::mem::replace(&mut is_done[other as usize], true)
                    {
                        waiting.push(other);
                    }
                }
            }
            let own = &mut found.pieces[first..];
            own.sort_unstable();
            // The largest of some.
            let corners = |&piece: &u32| {
                let corners = pieces.corners(piece);
                corners.map(|vertex| pieces.soup.points[vertex as usize])
            };
            let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length_squared();
            let some = own.iter().step_by(own.len().div_ceil(64)).map(corners);
            let largest = some.max_by(|&s, &t| area(s).total_cmp(&area(t)));
            let corners = largest.unwrap_or_default();
            found.all.push(Patch {
                region: pieces.soup.place_of(pieces.owner(start)).0 as u32,
                pieces: first..found.pieces.len(),
                point: corners.into_iter().sum::<DVec3>() / 3.0,
            });
        }
        found.told = found.tell(outline);
        found
    }

    /// The lines on both sides of which the boundary is the same.
    fn idle_lines(&self, pieces: &Pieces<'_>) -> Vec<[u32; 2]> {
        let mut first_told: FxHashMap<([u32; 2], u32), Option<bool>> = FxHashMap::default();
        let mut idle = Vec::new();
        for (patch, &told) in self.all.iter().zip(&self.told) {
            let own = self.pieces[patch.pieces.clone()].iter();
            for (corners, owner) in own.filter_map(|&piece| pieces.part(piece)) {
                for side in 0..3 {
                    let [from, to] = [corners[side], corners[(side + 1) % 3]];
                    let line = [from.min(to), from.max(to)];
                    if pieces.crossed.lines.contains_key(&line)
                        && first_told.insert((line, *owner), told) == Some(told)
                    {
                        idle.push(line);
                    }
                }
            }
        }
        idle
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
