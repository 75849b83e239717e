//! Is the mesh the boundary of a solid? Closed, oriented, manifold.

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use super::components::Components;
use super::star::{Stars, degenerate, in_range};
use crate::mesh::Mesh;
use crate::numeric::Groups;

/// How many places of each defect a [`MeshCheck`] keeps.
pub const PLACES_PER_DEFECT: usize = 8;

/// Vertices per parallel task: enough to pay for the task, and fixed, so that
/// the result does not depend on the number of threads.
const CHUNK: usize = 1 << 14;

/// What can be wrong with a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum MeshDefect {
    /// A triangle names a vertex that does not exist.
    OutOfRangeTriangle,
    /// A triangle names a vertex twice.
    DegenerateTriangle,
    /// A triangle has the same three vertices as another, in any order.
    DuplicateTriangle,
    /// An edge lies in an odd number of triangles: the surface ends there.
    OpenEdge,
    /// An edge lies in more than two triangles.
    NonManifoldEdge,
    /// Triangles at an edge disagree about which side is outside.
    MisorientedEdge,
    /// The triangles around a vertex form more than one fan.
    NonManifoldVertex,
    /// No usable triangle names the vertex.
    UnreferencedVertex,
    /// A coordinate is NaN or infinite.
    NonFiniteVertex,
}

impl MeshDefect {
    /// Every kind of defect, in the order of reports.
    pub const ALL: [Self; 9] = [
        Self::OutOfRangeTriangle,
        Self::DegenerateTriangle,
        Self::DuplicateTriangle,
        Self::OpenEdge,
        Self::NonManifoldEdge,
        Self::MisorientedEdge,
        Self::NonManifoldVertex,
        Self::UnreferencedVertex,
        Self::NonFiniteVertex,
    ];
}

impl fmt::Display for MeshDefect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OutOfRangeTriangle => "triangle with a vertex index out of range",
            Self::DegenerateTriangle => "triangle with a repeated vertex",
            Self::DuplicateTriangle => "duplicate triangle",
            Self::OpenEdge => "open edge",
            Self::NonManifoldEdge => "edge shared by more than two triangles",
            Self::MisorientedEdge => "edge between triangles of opposite orientation",
            Self::NonManifoldVertex => "non-manifold vertex",
            Self::UnreferencedVertex => "unreferenced vertex",
            Self::NonFiniteVertex => "vertex with a NaN or infinite coordinate",
        })
    }
}

/// One place where a mesh has a defect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DefectPlace {
    /// What is wrong.
    pub defect: MeshDefect,
    /// The triangle's index where a triangle is out of range or degenerate;
    /// the vertex's for a defect of a vertex; the lowest vertex's for an edge
    /// or a duplicate triangle.
    pub index: usize,
    /// The triangle's centroid, the vertex, or the edge's midpoint, in the
    /// mesh's unit; NaN for a triangle with vertices out of range.
    pub at: DVec3,
}

/// What [`Mesh::check`] found: counts, and some places of each defect.
///
/// Triangles with vertices out of range, or with a repeated vertex, are
/// counted as such and then left out: edges and links are those of the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshCheck {
    /// All triangles of the mesh.
    pub triangles: usize,
    /// Vertices that are part of a usable triangle.
    pub vertices: usize,
    /// Distinct edges of usable triangles.
    pub edges: usize,
    /// Parts that share no vertex.
    pub components: usize,
    /// Triangles that name a vertex that does not exist.
    pub out_of_range_triangles: usize,
    /// Triangles that name a vertex twice.
    pub degenerate_triangles: usize,
    /// Triangles beyond the first on the same three vertices, in any order.
    pub duplicate_triangles: usize,
    /// Edges in an odd number of triangles: the surface ends there.
    pub open_edges: usize,
    /// Edges in more than two triangles.
    pub non_manifold_edges: usize,
    /// Edges whose triangles run along them one way at least two times more
    /// often than the other way.
    pub misoriented_edges: usize,
    /// Vertices whose link is neither one cycle nor (at an open edge) one path.
    pub non_manifold_vertices: usize,
    /// Vertices that no usable triangle names; they do no harm.
    pub unreferenced_vertices: usize,
    /// Vertices with a NaN or infinite coordinate.
    pub non_finite_vertices: usize,
    /// Up to [`PLACES_PER_DEFECT`] places of each defect, ordered by defect
    /// and then by index.
    pub places: Vec<DefectPlace>,
}

impl MeshCheck {
    /// Whether the surface has no border: every edge lies in an even number
    /// of triangles, and no triangle is unusable for a vertex out of range.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0 && self.out_of_range_triangles == 0
    }

    /// Whether no two triangles disagree about which side is outside.
    #[must_use]
    pub fn is_oriented(&self) -> bool {
        self.misoriented_edges == 0
    }

    /// Whether the mesh is a closed, oriented 2-manifold: each edge in exactly
    /// two different triangles that run along it in opposite directions, each
    /// vertex's link one cycle, all coordinates finite. (An empty mesh is.)
    #[must_use]
    pub fn is_manifold(&self) -> bool {
        self.is_closed()
            && self.is_oriented()
            && self.degenerate_triangles == 0
            && self.duplicate_triangles == 0
            && self.non_manifold_edges == 0
            && self.non_manifold_vertices == 0
            && self.non_finite_vertices == 0
    }

    /// Vertices minus edges plus triangles, of the usable triangles.
    #[must_use]
    pub fn euler_characteristic(&self) -> i64 {
        let faces = self.triangles - self.out_of_range_triangles - self.degenerate_triangles;
        self.vertices as i64 - self.edges as i64 + faces as i64
    }

    /// The number of handles, summed over the components: for each, the Euler
    /// characteristic is 2 - 2 genus. `None` unless the mesh is manifold.
    #[must_use]
    pub fn genus(&self) -> Option<i64> {
        self.is_manifold()
            .then(|| self.components as i64 - self.euler_characteristic() / 2)
    }

    /// How often a defect occurs.
    #[must_use]
    pub fn count(&self, defect: MeshDefect) -> usize {
        match defect {
            MeshDefect::OutOfRangeTriangle => self.out_of_range_triangles,
            MeshDefect::DegenerateTriangle => self.degenerate_triangles,
            MeshDefect::DuplicateTriangle => self.duplicate_triangles,
            MeshDefect::OpenEdge => self.open_edges,
            MeshDefect::NonManifoldEdge => self.non_manifold_edges,
            MeshDefect::MisorientedEdge => self.misoriented_edges,
            MeshDefect::NonManifoldVertex => self.non_manifold_vertices,
            MeshDefect::UnreferencedVertex => self.unreferenced_vertices,
            MeshDefect::NonFiniteVertex => self.non_finite_vertices,
        }
    }
}

impl fmt::Display for MeshCheck {
    /// One line: the counts, and every defect that occurs with its first place.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} triangles, {} edges, {} vertices, {} components",
            self.triangles, self.edges, self.vertices, self.components
        )?;
        for defect in MeshDefect::ALL {
            let count = self.count(defect);
            if count > 0 {
                write!(f, "; {count} x {defect}")?;
            }
            if let Some(place) = self.places.iter().find(|p| p.defect == defect) {
                write!(f, " (first at {})", place.at)?;
            }
        }
        Ok(())
    }
}

impl Mesh {
    /// Checks whether the mesh is closed, oriented and manifold, and says
    /// where it is not. Never panics, whatever the indices are.
    ///
    /// Linear in the size of the mesh (but for vertices with defects, whose
    /// triangles are sorted); needs some 24 bytes a triangle and 8 a vertex.
    #[must_use]
    pub fn check(&self) -> MeshCheck {
        let (tally, components) = rayon::join(|| self.tally(), || Components::of(self).count);
        let [
            out_of_range_triangles,
            degenerate_triangles,
            duplicate_triangles,
            open_edges,
            non_manifold_edges,
            misoriented_edges,
            non_manifold_vertices,
            unreferenced_vertices,
            non_finite_vertices,
        ] = tally.counts;
        MeshCheck {
            triangles: self.triangles.len(),
            vertices: self.positions.len() - unreferenced_vertices,
            edges: tally.edges,
            components,
            out_of_range_triangles,
            degenerate_triangles,
            duplicate_triangles,
            open_edges,
            non_manifold_edges,
            misoriented_edges,
            non_manifold_vertices,
            unreferenced_vertices,
            non_finite_vertices,
            places: tally.places.into_iter().flatten().collect(),
        }
    }

    /// The defects of triangles and of vertices' stars, and the edges.
    fn tally(&self) -> Tally {
        let mut tally = Tally::default();
        self.check_triangles(&mut tally);
        let stars = Stars::new(self);
        // In chunk order, so that the places kept are the same for any number
        // of threads.
        let vertices = self.positions.len();
        let parts: Vec<Tally> = (0..vertices.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut part = Tally::default();
                let mut star = StarCheck::default();
                for vertex in chunk * CHUNK..vertices.min((chunk + 1) * CHUNK) {
                    star.check(self, &stars, vertex, &mut part);
                }
                part
            })
            .collect();
        for part in parts {
            tally.merge(part);
        }
        tally
    }

    fn check_triangles(&self, tally: &mut Tally) {
        for (index, triangle) in self.triangles.iter().enumerate() {
            if !in_range(triangle, self.positions.len()) {
                tally.add(MeshDefect::OutOfRangeTriangle, index, || DVec3::NAN);
            } else if degenerate(triangle) {
                tally.add(MeshDefect::DegenerateTriangle, index, || {
                    self.corners(index).iter().sum::<DVec3>() / 3.0
                });
            }
        }
    }
}

/// Defects found so far.
#[derive(Default)]
struct Tally {
    edges: usize,
    /// Indexed by [`MeshDefect`], as are the places.
    counts: [usize; MeshDefect::ALL.len()],
    places: [Vec<DefectPlace>; MeshDefect::ALL.len()],
}

impl Tally {
    fn add(&mut self, defect: MeshDefect, index: usize, at: impl FnOnce() -> DVec3) {
        self.counts[defect as usize] += 1;
        let places = &mut self.places[defect as usize];
        if places.len() < PLACES_PER_DEFECT {
            let at = at();
            places.push(DefectPlace { defect, index, at });
        }
    }

    fn merge(&mut self, other: Self) {
        self.edges += other.edges;
        for (mine, its) in self.counts.iter_mut().zip(other.counts) {
            *mine += its;
        }
        for (mine, its) in self.places.iter_mut().zip(other.places) {
            let room = PLACES_PER_DEFECT - mine.len();
            mine.extend(its.into_iter().take(room));
        }
    }
}

/// Checks the star of one vertex after another, reusing its buffers.
#[derive(Default)]
struct StarCheck {
    links: Vec<[u32; 2]>,
    /// The other end of each edge's side that runs away from the vertex, as
    /// `2 * end`, or towards it, as `2 * end + 1`.
    sides: Vec<u64>,
    neighbours: Vec<u32>,
    parts: Groups,
}

impl StarCheck {
    fn check(&mut self, mesh: &Mesh, stars: &Stars, vertex: usize, tally: &mut Tally) {
        let at = mesh.positions[vertex];
        if !at.is_finite() {
            tally.add(MeshDefect::NonFiniteVertex, vertex, || at);
        }
        let links = stars.of(vertex);
        if links.is_empty() {
            tally.add(MeshDefect::UnreferencedVertex, vertex, || at);
            return;
        }
        self.links.clear();
        self.links.extend_from_slice(links);
        if is_one_cycle(&mut self.links) {
            // An edge belongs to the lower of its vertices.
            tally.edges += links.iter().filter(|l| l[0] as usize > vertex).count();
        } else {
            self.check_irregular(mesh, links, vertex, tally);
        }
    }

    /// Counts what is wrong around a vertex whose link is not one cycle.
    fn check_irregular(
        &mut self,
        mesh: &Mesh,
        links: &[[u32; 2]],
        vertex: usize,
        tally: &mut Tally,
    ) {
        let at = mesh.positions[vertex];
        self.sides.clear();
        self.neighbours.clear();
        for &[next, previous] in links {
            self.sides.push(u64::from(next) * 2);
            self.sides.push(u64::from(previous) * 2 + 1);
        }
        self.sides.sort_unstable();
        let mut branches = false;
        for sides in self.sides.chunk_by(|a, b| a / 2 == b / 2) {
            let end = (sides[0] / 2) as u32;
            let away = sides.iter().filter(|&&side| side % 2 == 0).count();
            let towards = sides.len() - away;
            self.neighbours.push(end);
            branches |= sides.len() > 2;
            if end as usize <= vertex {
                continue;
            }
            tally.edges += 1;
            let middle = || at.midpoint(mesh.positions[end as usize]);
            if sides.len() % 2 == 1 {
                tally.add(MeshDefect::OpenEdge, vertex, middle);
            }
            if sides.len() > 2 {
                tally.add(MeshDefect::NonManifoldEdge, vertex, middle);
            }
            if away.abs_diff(towards) > 1 {
                tally.add(MeshDefect::MisorientedEdge, vertex, middle);
            }
        }
        if branches || !self.link_is_connected(links) {
            tally.add(MeshDefect::NonManifoldVertex, vertex, || at);
        }
        self.count_duplicates(mesh, vertex, tally);
    }

    /// Whether the link hangs together (union-find over the neighbours).
    fn link_is_connected(&mut self, links: &[[u32; 2]]) -> bool {
        let neighbours = &self.neighbours;
        self.parts.reset(neighbours.len());
        let mut parts = neighbours.len();
        for link in links {
            let pair = link.map(|end| {
                let slot = neighbours.partition_point(|&neighbour| neighbour < end);
                slot as u32
            });
            parts -= usize::from(self.parts.join(pair));
        }
        parts == 1
    }

    /// Two triangles on the same three vertices are seen at the lowest one.
    fn count_duplicates(&mut self, mesh: &Mesh, vertex: usize, tally: &mut Tally) {
        self.links
            .retain(|l| l.iter().all(|&end| end as usize > vertex));
        for link in &mut self.links {
            link.sort_unstable();
        }
        self.links.sort_unstable();
        for pair in self.links.windows(2).filter(|pair| pair[0] == pair[1]) {
            tally.add(MeshDefect::DuplicateTriangle, vertex, || {
                let [b, c] = pair[0].map(|end| mesh.positions[end as usize]);
                (mesh.positions[vertex] + b + c) / 3.0
            });
        }
    }
}

/// Whether the opposite edges, in any order, form one cycle of at least three
/// edges, all in the same direction. Sorts them if there are many.
fn is_one_cycle(links: &mut [[u32; 2]]) -> bool {
    /// Up to here a scan is faster than sorting.
    const FEW: usize = 12;
    if links.len() < 3 {
        return false;
    }
    let sorted = links.len() > FEW;
    if sorted {
        links.sort_unstable();
        if links.windows(2).any(|pair| pair[0][0] == pair[1][0]) {
            return false;
        }
    } else if (1..links.len()).any(|i| links[..i].iter().any(|l| l[0] == links[i][0])) {
        return false;
    }
    // No two edges start at the same end: following them is a walk without
    // choices, and one cycle if it first comes home after all edges.
    let home = links[0][0];
    let mut end = links[0][1];
    for _ in 1..links.len() {
        let onward = if sorted {
            links.binary_search_by_key(&end, |link| link[0]).ok()
        } else {
            links.iter().position(|link| link[0] == end)
        };
        match onward {
            Some(index) if end != home => end = links[index][1],
            _ => return false,
        }
    }
    end == home
}
