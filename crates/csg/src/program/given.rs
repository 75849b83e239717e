//! Edges and vertices that were given with the faces of polyhedra: planes of neighbours may
//! differ by so little that their common points would be worse than what was given.

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use crate::numeric::eigen_symmetric;
use crate::numeric::tolerance::ON_LINE;
use crate::surface::{Surface, SurfaceId};

/// The number of what belongs to no polyhedron alone.
const NONE: u32 = u32::MAX;

/// The ends of an edge, as numbers of vertices.
pub(crate) type Ends = [u32; 2];

/// The edges and vertices of all polyhedra of a program.
#[derive(Clone, Debug, Default)]
pub(crate) struct Given {
    vertices: Vec<DVec3>,
    /// Vertices nearer to planes of their polyhedron are on them.
    slack: f64,
    /// For each surface the polyhedron that alone has faces on it, or [`NONE`].
    owners: Vec<u32>,
    /// Whether a surface only parts space.
    cuts: Vec<bool>,
    are_walls: bool,
    /// For two surfaces, the lesser first, the edges in which their faces meet.
    edges: FxHashMap<[SurfaceId; 2], SmallVec<[Ends; 1]>>,
    /// Of edges that others cover, the stretch from the first end that is left.
    left: FxHashMap<Ends, [f64; 2]>,
    /// The vertices of each surface's faces, ascending, and where they begin.
    vertices_of: Vec<u32>,
    first_of: Vec<u32>,
}

/// What is known of the surfaces of polyhedra while a program is lowered.
#[derive(Debug, Default)]
pub(super) struct Gathered {
    vertices: Vec<DVec3>,
    /// Triangles with the numbers of their vertices, their surfaces and the numbers of
    /// their polyhedra.
    triangles: Vec<([u32; 3], SurfaceId, u32)>,
    polyhedra: u32,
    /// Points nearer to planes were taken to be on them.
    pub slack: f64,
    pub cuts: Vec<SurfaceId>,
    /// Whether there may be faces on cuts.
    pub are_walls: bool,
}

impl Gathered {
    /// Adds a polyhedron in place, and the surface of each of its triangles.
    pub fn add(
        &mut self,
        vertices: impl Iterator<Item = DVec3>,
        triangles: impl Iterator<Item = ([u32; 3], SurfaceId)>,
    ) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(vertices);
        let owner = self.polyhedra;
        self.triangles.extend(
            triangles.map(|(corners, surface)| (corners.map(|v| v + first), surface, owner)),
        );
        self.polyhedra += 1;
    }

    /// Gives surfaces other numbers; what is on those without one is left out.
    pub fn renumber(&mut self, number: impl Fn(SurfaceId) -> Option<SurfaceId>) {
        let triangles = std::mem::take(&mut self.triangles).into_iter();
        let renumbered = |(corners, surface, owner)| Some((corners, number(surface)?, owner));
        self.triangles = triangles.filter_map(renumbered).collect();
        let cuts = std::mem::take(&mut self.cuts).into_iter();
        self.cuts = cuts.filter_map(number).collect();
    }

    /// The edges and vertices, if there are any, of a program of so many surfaces in which
    /// `others` belong to other primitives.
    pub fn finish(self, surfaces: usize, others: impl Iterator<Item = SurfaceId>) -> Option<Given> {
        if self.triangles.is_empty() {
            return None;
        }
        const FREE: u32 = NONE - 1;
        let mut owners = vec![FREE; surfaces];
        let mut cuts = vec![false; surfaces];
        for &cut in &self.cuts {
            cuts[cut.index()] = true;
        }
        for surface in others {
            owners[surface.index()] = NONE;
            cuts[surface.index()] = false;
        }
        let mut sides: FxHashMap<Ends, SmallVec<[SurfaceId; 2]>> = FxHashMap::default();
        let mut pairs: Vec<(SurfaceId, u32)> = Vec::with_capacity(3 * self.triangles.len());
        for &([a, b, c], surface, owner) in &self.triangles {
            let known = &mut owners[surface.index()];
            *known = match *known {
                FREE => owner,
                same if same == owner => owner,
                _ => NONE,
            };
            cuts[surface.index()] = false;
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let ends = [from.min(to), from.max(to)];
                let around = sides.entry(ends).or_default();
                if !around.contains(&surface) {
                    around.push(surface);
                }
            }
            pairs.extend([a, b, c].map(|vertex| (surface, vertex)));
        }
        for owner in owners.iter_mut().filter(|owner| **owner == FREE) {
            *owner = NONE;
        }
        let mut edges: FxHashMap<[SurfaceId; 2], SmallVec<[Ends; 1]>> = FxHashMap::default();
        for (ends, mut around) in sides {
            around.sort_unstable();
            // More than two meet where the polyhedron touches itself: the first two stand
            // for all of them.
            if let &[first, second, ..] = &around[..] {
                edges.entry([first, second]).or_default().push(ends);
            }
        }
        let left = parted(&mut edges, &self.vertices, self.slack);
        pairs.sort_unstable();
        pairs.dedup();
        let mut first_of = vec![0; surfaces + 1];
        for &(surface, _) in &pairs {
            first_of[surface.index() + 1] += 1;
        }
        for surface in 0..surfaces {
            first_of[surface + 1] += first_of[surface];
        }
        Some(Given {
            vertices: self.vertices,
            slack: self.slack,
            owners,
            cuts,
            are_walls: self.are_walls,
            edges,
            left,
            vertices_of: pairs.into_iter().map(|(_, vertex)| vertex).collect(),
            first_of,
        })
    }
}

/// Sorts the edges between the same two surfaces, which may be those of parts of a polyhedron that
/// nearly touch. Of those that others cover, on the same line but for so much, the stretch from the
/// first end that is left.
fn parted(
    edges: &mut FxHashMap<[SurfaceId; 2], SmallVec<[Ends; 1]>>,
    vertices: &[DVec3],
    slack: f64,
) -> FxHashMap<Ends, [f64; 2]> {
    let mut left = FxHashMap::default();
    for runs in edges.values_mut().filter(|runs| runs.len() > 1) {
        runs.sort_unstable();
        part(runs, vertices, ON_LINE * slack, &mut left);
    }
    left
}

/// The same of the edges between two surfaces.
fn part(runs: &[Ends], vertices: &[DVec3], within: f64, left: &mut FxHashMap<Ends, [f64; 2]>) {
    let at = |vertex: u32| vertices[vertex as usize];
    let lengths = runs.iter().map(|&[from, to]| at(from).distance(at(to)));
    let longest = lengths.zip(runs).max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, &[from, to])) = longest else {
        return;
    };
    let direction = (at(to) - at(from)).normalize_or_zero();
    let along = |vertex: u32| direction.dot(at(vertex));
    // Where each begins and ends along the longest, and which it is.
    let ranges = runs.iter().map(|&ends| {
        let [from, to] = ends.map(along);
        (from.min(to), from.max(to), ends)
    });
    let mut ranges: Vec<(f64, f64, Ends)> = ranges.collect();
    ranges.sort_unstable_by(|a, b| {
        a.0.total_cmp(&b.0)
            .then(b.1.total_cmp(&a.1))
            .then(a.2.cmp(&b.2))
    });
    // The one that goes farthest so far.
    let mut last: Option<(f64, Ends)> = None;
    for (low, high, ends) in ranges {
        let covered = last.filter(|&(end, [from, to])| {
            let line = (at(to) - at(from)).normalize_or_zero();
            let off = |vertex: u32| line.cross(at(vertex) - at(from)).length();
            end > low && off(ends[0]).max(off(ends[1])) <= within
        });
        if let Some((end, _)) = covered {
            let length = at(ends[0]).distance(at(ends[1]));
            let share = ((end - low) / (high - low)).min(1.0);
            let runs_back = along(ends[0]) > along(ends[1]);
            let stretch = if runs_back {
                [0.0, (1.0 - share) * length]
            } else {
                [share * length, length]
            };
            left.insert(ends, stretch);
        }
        if last.is_none_or(|(end, _)| high > end) {
            last = Some((high, ends));
        }
    }
}

/// The shortest way from a point to where planes meet that pass by it, as far as these meet
/// at such sines as [`ON_LINE`] says.
fn onto<'a>(planes: impl Iterator<Item = &'a Surface>, point: DVec3) -> DVec3 {
    let mut squares = [0.0; 6];
    let mut off = DVec3::ZERO;
    for plane in planes {
        let n = plane.linear;
        let mixed = 2.0 * DVec3::new(n.x * n.y, n.y * n.z, n.z * n.x);
        let products = (n * n).to_array().into_iter().chain(mixed.to_array());
        for (sum, product) in squares.iter_mut().zip(products) {
            *sum += product;
        }
        off += plane.value(point) * n;
    }
    let (values, vectors) = eigen_symmetric(squares);
    let axes = [vectors.x_axis, vectors.y_axis, vectors.z_axis];
    let all = values.into_iter().zip(axes);
    let told = all.filter(|&(value, _)| value > ON_LINE.powi(-2));
    told.map(|(value, axis)| -axis.dot(off) / value * axis)
        .sum()
}

impl Given {
    /// The same about another origin.
    pub fn about(&self, origin: DVec3) -> Self {
        let mut moved = self.clone();
        for vertex in &mut moved.vertices {
            *vertex -= origin;
        }
        moved
    }

    /// The same for a program in which surfaces were replaced by others, which are among all of
    /// them (`placed`) and no farther off than `moved`. Vertices go along.
    pub fn renumbered(
        &self,
        in_place: impl Fn(SurfaceId) -> SurfaceId,
        placed: &[Surface],
        moved: f64,
    ) -> Self {
        let surfaces = self.owners.len();
        let slack = self.slack + moved;
        let mut owners = vec![NONE; surfaces];
        let mut is_met = vec![false; surfaces];
        let mut cuts = vec![true; surfaces];
        let mut pairs = Vec::with_capacity(self.vertices_of.len());
        // The vertices of faces whose planes were replaced, and all planes that they are on.
        let mut concerned: FxHashMap<u32, SmallVec<[SurfaceId; 4]>> = FxHashMap::default();
        for (old, &owner) in (0u32..).map(SurfaceId).zip(&self.owners) {
            let new = in_place(old);
            let slot = new.index();
            owners[slot] = if !is_met[slot] || owners[slot] == owner {
                owner
            } else {
                NONE
            };
            is_met[slot] = true;
            cuts[slot] &= self.cuts[old.index()];
            let own = self.vertices_on(old);
            pairs.extend(own.iter().map(|&vertex| (new, vertex)));
            if new != old {
                concerned.extend(own.iter().map(|&vertex| (vertex, SmallVec::new())));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut vertices = self.vertices.clone();
        if !concerned.is_empty() {
            for &(surface, vertex) in &pairs {
                if let Some(planes) = concerned.get_mut(&vertex) {
                    planes.push(surface);
                }
            }
            for (vertex, ids) in concerned {
                let planes = ids.iter().map(|id| &placed[id.index()]);
                let at = &mut vertices[vertex as usize];
                *at += onto(planes, *at);
            }
        }
        let mut first_of = vec![0; surfaces + 1];
        for &(surface, _) in &pairs {
            first_of[surface.index() + 1] += 1;
        }
        for surface in 0..surfaces {
            first_of[surface + 1] += first_of[surface];
        }
        let mut edges: FxHashMap<[SurfaceId; 2], SmallVec<[Ends; 1]>> = FxHashMap::default();
        for (pair, runs) in &self.edges {
            let mut pair = pair.map(&in_place);
            pair.sort_unstable();
            if pair[0] != pair[1] {
                edges.entry(pair).or_default().extend(runs.iter().copied());
            }
        }
        let left = parted(&mut edges, &vertices, slack);
        Self {
            vertices,
            slack,
            owners,
            cuts,
            are_walls: self.are_walls,
            edges,
            left,
            vertices_of: pairs.into_iter().map(|(_, vertex)| vertex).collect(),
            first_of,
        }
    }

    /// Vertices nearer to planes of their polyhedron are on them.
    pub fn slack(&self) -> f64 {
        self.slack
    }

    pub fn vertex(&self, vertex: u32) -> DVec3 {
        self.vertices[vertex as usize]
    }

    /// Whether cuts may carry faces, where a polyhedron is left out beyond them.
    pub fn are_walls(&self) -> bool {
        self.are_walls
    }

    /// Whether a surface only parts space, and carries no face but as a wall.
    pub fn is_cut(&self, surface: SurfaceId) -> bool {
        self.cuts[surface.index()]
    }

    /// Whether two surfaces carry faces of one polyhedron and of nothing else: then they
    /// meet along its edges alone.
    pub fn are_of_one(&self, one: SurfaceId, other: SurfaceId) -> bool {
        let owner = self.owners[one.index()];
        owner != NONE && owner == self.owners[other.index()]
    }

    /// Whether a surface carries faces of polyhedra.
    pub fn has_faces(&self, surface: SurfaceId) -> bool {
        !self.vertices_on(surface).is_empty()
    }

    /// Whether a surface carries faces of one polyhedron and of nothing else.
    pub fn is_of_polyhedron(&self, surface: SurfaceId) -> bool {
        self.owners[surface.index()] != NONE
    }

    /// Whether a surface shares an edge with one of two others.
    pub fn is_beside(&self, surface: SurfaceId, pair: [SurfaceId; 2]) -> bool {
        pair.iter()
            .any(|&one| !self.edges_of([surface, one]).is_empty())
    }

    /// The edges in which faces on two surfaces meet.
    pub fn edges_of(&self, mut pair: [SurfaceId; 2]) -> &[Ends] {
        pair.sort_unstable();
        self.edges.get(&pair).map_or(&[], |runs| &runs[..])
    }

    /// The line along an edge from the first of its ends, named in either order: that, the
    /// direction, and where the edge begins and ends, as far as no other one covers it. None if
    /// nothing of it is left.
    pub fn line_of(&self, ends: Ends) -> Option<(DVec3, DVec3, [f64; 2])> {
        let [from, to] = ends.map(|vertex| self.vertex(vertex));
        let length = from.distance(to);
        let stretch = match self.left.get(&[ends[0].min(ends[1]), ends[0].max(ends[1])]) {
            None => [0.0, length],
            Some(&left) if ends[0] < ends[1] => left,
            Some(&[start, end]) => [length - end, length - start],
        };
        (stretch[0] < stretch[1]).then(|| (from, (to - from) / length, stretch))
    }

    /// The vertices of faces on a surface, ascending.
    pub fn vertices_on(&self, surface: SurfaceId) -> &[u32] {
        let ends = [0, 1].map(|k| self.first_of[surface.index() + k] as usize);
        &self.vertices_of[ends[0]..ends[1]]
    }

    /// Whether a face on a surface has a vertex.
    pub fn has_vertex(&self, surface: SurfaceId, vertex: u32) -> bool {
        self.vertices_on(surface).binary_search(&vertex).is_ok()
    }

    /// The vertices that faces on three surfaces have in common.
    pub fn common_vertices(&self, ids: [SurfaceId; 3]) -> impl Iterator<Item = DVec3> {
        let mut lists = ids.map(|id| (self.vertices_on(id), id));
        lists.sort_unstable_by_key(|(list, _)| list.len());
        let [(shortest, _), (_, one), (_, other)] = lists;
        let common = shortest
            .iter()
            .filter(move |&&v| self.has_vertex(one, v) && self.has_vertex(other, v));
        common.map(|&v| self.vertex(v))
    }
}
