//! Edges and vertices that were given with the faces of polyhedra: planes of neighbours may
//! differ by so little that their common points would be worse than what was given.

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use crate::surface::SurfaceId;

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
        for runs in edges.values_mut() {
            runs.sort_unstable();
        }
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
            vertices_of: pairs.into_iter().map(|(_, vertex)| vertex).collect(),
            first_of,
        })
    }
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

    /// The same for a program in which surfaces were replaced by others.
    pub fn renumbered(&self, in_place: impl Fn(SurfaceId) -> SurfaceId) -> Self {
        let surfaces = self.owners.len();
        let mut owners = vec![NONE; surfaces];
        let mut is_met = vec![false; surfaces];
        let mut cuts = vec![true; surfaces];
        let mut pairs = Vec::with_capacity(self.vertices_of.len());
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
            pairs.extend(self.vertices_on(old).iter().map(|&vertex| (new, vertex)));
        }
        pairs.sort_unstable();
        pairs.dedup();
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
        for runs in edges.values_mut() {
            runs.sort_unstable();
        }
        Self {
            vertices: self.vertices.clone(),
            slack: self.slack,
            owners,
            cuts,
            are_walls: self.are_walls,
            edges,
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
