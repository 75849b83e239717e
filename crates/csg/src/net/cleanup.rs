//! Triangles without area or folded over, taken out by edge collapses.
//!
//! They arise where the vertices of neighbouring cells come to lie on one
//! corner, or several on one stretch of a sharp edge. Vertex u may be merged
//! into its neighbour v if v lies on every surface that u does, so that no face
//! leaves its surface; if the link condition holds (the neighbours that u and v
//! share are just the two apexes of the triangles at their edge; Dey,
//! Edelsbrunner, Guha and Nekhayev 1999), so that the mesh stays manifold; and
//! if no other triangle is folded or flattened by it.
//!
//! Where two loops of one corner are joined by a pair of triangles that lie
//! back to back along an edge of the solid, the vertices to be merged are those
//! opposite to each other across the pair: the same as if the pair's diagonal
//! were flipped first.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::program::Surface;

/// A run of consecutive triangles on one surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    /// First triangle.
    pub start: u32,
    pub surface: u32,
    /// Whether the surface's gradient points into the solid.
    pub reversed: bool,
}

/// The triangles of a mesh under repair.
pub(super) struct Cleaner<'a> {
    pub positions: &'a [DVec3],
    pub triangles: &'a mut [[u32; 3]],
    pub runs: &'a [Run],
    pub surfaces: &'a [Surface],
    /// A triangle of less area than this is to be taken out.
    pub least_area: f64,
}

/// What came of it.
#[derive(Debug, Default)]
pub(super) struct Cleaned {
    /// Triangles that are gone, in ascending order.
    pub removed: Vec<u32>,
    /// Vertices that are gone.
    pub merged: FxHashSet<u32>,
    /// Triangles that stayed as they are.
    pub left: Vec<u32>,
}

/// The triangles around the vertices in question.
type Stars = FxHashMap<u32, Vec<u32>>;

impl Cleaner<'_> {
    /// Takes out the `bad` triangles as far as that can be done.
    pub fn clean(&mut self, bad: &[u32]) -> Cleaned {
        let mut cleaned = Cleaned::default();
        if bad.is_empty() {
            return cleaned;
        }
        let mut stars = self.stars(bad);
        let mut removed = FxHashSet::default();
        let mut pending: Vec<u32> = bad.to_vec();
        // A collapse may make room for another.
        const ROUNDS: usize = 3;
        for _ in 0..ROUNDS {
            let before = pending.len();
            pending.retain(|&triangle| {
                !removed.contains(&triangle)
                    && self.is_bad(triangle)
                    && !self.take_out(triangle, &mut stars, &mut removed, &mut cleaned.merged)
            });
            if pending.is_empty() || pending.len() == before {
                break;
            }
        }
        cleaned.left = pending;
        cleaned.removed = removed.into_iter().collect();
        cleaned.removed.sort_unstable();
        cleaned
    }

    fn stars(&self, bad: &[u32]) -> Stars {
        let mut wanted = vec![false; self.positions.len()];
        for &triangle in bad {
            for vertex in self.triangles[triangle as usize] {
                wanted[vertex as usize] = true;
            }
        }
        let around: Vec<u32> = self
            .triangles
            .par_iter()
            .enumerate()
            .filter(|(_, corners)| corners.iter().any(|&v| wanted[v as usize]))
            .map(|(triangle, _)| triangle as u32)
            .collect();
        let mut stars = Stars::default();
        for triangle in around {
            for vertex in self.triangles[triangle as usize] {
                if wanted[vertex as usize] {
                    stars.entry(vertex).or_default().push(triangle);
                }
            }
        }
        stars
    }

    fn run_of(&self, triangle: u32) -> &Run {
        let after = self.runs.partition_point(|run| run.start <= triangle);
        &self.runs[after.saturating_sub(1)]
    }

    /// Twice the area of a triangle, negative if it is folded over.
    fn signed_area(&self, triangle: u32, corners: [u32; 3]) -> f64 {
        let [p, q, r] = corners.map(|v| self.positions[v as usize]);
        let run = self.run_of(triangle);
        let gradient = self.surfaces[run.surface as usize].gradient((p + q + r) / 3.0);
        let outward = if run.reversed { -gradient } else { gradient };
        (q - p).cross(r - p).dot(outward.normalize_or_zero())
    }

    fn is_bad(&self, triangle: u32) -> bool {
        self.signed_area(triangle, self.triangles[triangle as usize]) <= 2.0 * self.least_area
    }

    /// Merges two vertices of the triangle, the nearest that may be; else one
    /// of them and the vertex opposite to it in a neighbouring triangle.
    fn take_out(
        &mut self,
        triangle: u32,
        stars: &mut Stars,
        removed: &mut FxHashSet<u32>,
        merged: &mut FxHashSet<u32>,
    ) -> bool {
        let [a, b, c] = self.triangles[triangle as usize];
        let length = |&(u, v, _): &(u32, u32, u32)| {
            self.positions[u as usize].distance_squared(self.positions[v as usize])
        };
        let sides = [(a, b), (b, c), (c, a)];
        let other = sides.map(|(u, v)| self.neighbour(triangle, u, v, stars));
        let mut edges = Vec::with_capacity(6);
        for ((u, v), other) in sides.into_iter().zip(other) {
            edges.extend(other.map(|other| (u, v, other)));
        }
        let mut across = Vec::with_capacity(6);
        for ((u, v), other) in sides.into_iter().zip(other) {
            let Some(other) = other else { continue };
            let apex = |t: u32| {
                self.triangles[t as usize]
                    .into_iter()
                    .find(|&w| w != u && w != v)
            };
            if let (Some(own), Some(opposite)) = (apex(triangle), apex(other)) {
                across.push((own, opposite, other));
            }
        }
        for mut pairs in [edges, across] {
            pairs.extend(pairs.clone().into_iter().map(|(u, v, t)| (v, u, t)));
            pairs.sort_by(|x, y| length(x).total_cmp(&length(y)));
            for (gone, kept, other) in pairs {
                let dying = [triangle, other];
                if self.may_merge(gone, kept, dying, stars) {
                    self.merge(gone, kept, dying, stars, removed);
                    merged.insert(gone);
                    return true;
                }
            }
        }
        false
    }

    /// The other triangle at the edge between two vertices.
    fn neighbour(&self, triangle: u32, u: u32, v: u32, stars: &Stars) -> Option<u32> {
        let mut star = stars.get(&u)?.iter().copied();
        star.find(|&t| t != triangle && self.triangles[t as usize].contains(&v))
    }

    /// Whether vertex `gone` may be moved onto `kept`: neighbours whose edge
    /// the `dying` triangles share, or opposite to each other across them.
    fn may_merge(&self, gone: u32, kept: u32, dying: [u32; 2], stars: &Stars) -> bool {
        let (Some(star), Some(kept_star)) = (stars.get(&gone), stars.get(&kept)) else {
            return false;
        };
        let surfaces: Vec<u32> = kept_star.iter().map(|&t| self.run_of(t).surface).collect();
        if !star
            .iter()
            .all(|&t| surfaces.contains(&self.run_of(t).surface))
        {
            return false;
        }
        let (neighbours, kept_neighbours) = (self.link(gone, star), self.link(kept, kept_star));
        let shared = neighbours.iter().filter(|v| kept_neighbours.contains(v));
        let shared: Vec<u32> = shared.copied().collect();
        let [first, second] = shared[..] else {
            return false;
        };
        let own_edge = dying.iter().all(|&t| {
            let corners = self.triangles[t as usize];
            corners.contains(&gone) && corners.contains(&kept)
        });
        if !own_edge && neighbours.contains(&kept) {
            return false;
        }
        let survives = |t: &&u32| !dying.contains(t);
        // An edge between the two apexes that both links share: a tetrahedron
        // would be flattened.
        let spans = |star: &[u32]| {
            star.iter().filter(survives).any(|&t| {
                let corners = self.triangles[t as usize];
                corners.contains(&first) && corners.contains(&second)
            })
        };
        if spans(star) && spans(kept_star) {
            return false;
        }
        star.iter().filter(survives).all(|&t| {
            let moved = self.triangles[t as usize].map(|v| if v == gone { kept } else { v });
            let area = self.signed_area(t, moved);
            area > 2.0 * self.least_area || (self.is_bad(t) && area >= 0.0)
        })
    }

    /// The vertices around a vertex.
    fn link(&self, vertex: u32, star: &[u32]) -> Vec<u32> {
        let corners = star.iter().flat_map(|&t| self.triangles[t as usize]);
        let mut link: Vec<u32> = corners.filter(|&v| v != vertex).collect();
        link.sort_unstable();
        link.dedup();
        link
    }

    fn merge(
        &mut self,
        gone: u32,
        kept: u32,
        dying: [u32; 2],
        stars: &mut Stars,
        removed: &mut FxHashSet<u32>,
    ) {
        for triangle in dying {
            removed.insert(triangle);
            for vertex in self.triangles[triangle as usize] {
                if let Some(star) = stars.get_mut(&vertex) {
                    star.retain(|&t| t != triangle);
                }
            }
        }
        let star = stars.remove(&gone).unwrap_or_default();
        for &triangle in &star {
            let corners = &mut self.triangles[triangle as usize];
            *corners = corners.map(|v| if v == gone { kept } else { v });
        }
        if let Some(kept_star) = stars.get_mut(&kept) {
            kept_star.extend(star);
        }
    }
}
