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

use super::solve;
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
    /// Distance to a surface below which a vertex lies on it.
    pub tolerance: f64,
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

/// What is done so far, and what is known for what is to come.
#[derive(Default)]
struct Work {
    stars: Stars,
    removed: FxHashSet<u32>,
    merged: FxHashSet<u32>,
    /// Triangles that lost their area.
    flattened: Vec<u32>,
    /// Whether to thin out the vertices around a triangle that stays bad.
    thorough: bool,
}

impl Cleaner<'_> {
    /// Takes out the `bad` triangles as far as that can be done.
    pub fn clean(&mut self, bad: &[u32]) -> Cleaned {
        /// A collapse may make room for another.
        const ROUNDS: usize = 4;
        let mut work = Work::default();
        let mut pending: Vec<u32> = bad.to_vec();
        for thorough in [false, true] {
            pending.retain(|&triangle| self.is_bad(triangle));
            if pending.is_empty() {
                break;
            }
            work.thorough = thorough;
            work.stars = self.stars(&pending, &work);
            for _ in 0..ROUNDS {
                let before = pending.len();
                pending.retain(|&triangle| {
                    let is_done = work.removed.contains(&triangle)
                        || !self.is_bad(triangle)
                        || self.take_out(triangle, &mut work)
                        || (thorough && self.thin_out(triangle, &mut work));
                    !is_done
                });
                let is_stuck = pending.len() == before;
                pending.append(&mut work.flattened);
                if is_stuck || pending.is_empty() {
                    break;
                }
            }
            pending.retain(|triangle| !work.removed.contains(triangle));
        }
        let mut removed: Vec<u32> = work.removed.into_iter().collect();
        removed.sort_unstable();
        Cleaned {
            removed,
            merged: work.merged,
            left: pending,
        }
    }

    /// The stars of all vertices of the bad triangles; if it is to be thorough,
    /// of their neighbours, too.
    fn stars(&self, bad: &[u32], work: &Work) -> Stars {
        let around = |wanted: &[bool]| -> Vec<u32> {
            self.triangles
                .par_iter()
                .enumerate()
                .filter(|(_, corners)| corners.iter().any(|&v| wanted[v as usize]))
                .map(|(triangle, _)| triangle as u32)
                .filter(|triangle| !work.removed.contains(triangle))
                .collect()
        };
        let mut wanted = vec![false; self.positions.len()];
        let mark = |triangles: &[u32], wanted: &mut [bool]| {
            for &triangle in triangles {
                for vertex in self.triangles[triangle as usize] {
                    wanted[vertex as usize] = true;
                }
            }
        };
        mark(bad, &mut wanted);
        if work.thorough {
            mark(&around(&wanted), &mut wanted);
        }
        let mut stars = Stars::default();
        for triangle in around(&wanted) {
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
    fn take_out(&mut self, triangle: u32, work: &mut Work) -> bool {
        let [a, b, c] = self.triangles[triangle as usize];
        let length = |&(u, v, _): &(u32, u32, u32)| {
            self.positions[u as usize].distance_squared(self.positions[v as usize])
        };
        let sides = [(a, b), (b, c), (c, a)];
        let other = sides.map(|(u, v)| self.neighbour(triangle, u, v, &work.stars));
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
                if let Some(flat) = self.may_merge(gone, kept, dying, &work.stars) {
                    work.flattened.extend(flat);
                    self.merge(gone, kept, dying, work);
                    return true;
                }
            }
        }
        false
    }

    /// Merges neighbours of the triangle's vertices into these, the nearest
    /// first, until the triangle can be taken out.
    fn thin_out(&mut self, triangle: u32, work: &mut Work) -> bool {
        const MOST_MERGERS: usize = 6;
        for _ in 0..MOST_MERGERS {
            let corners = self.triangles[triangle as usize];
            let mut pairs = Vec::new();
            for kept in corners {
                let Some(star) = work.stars.get(&kept) else {
                    continue;
                };
                let place = self.positions[kept as usize];
                for gone in self.link(kept, star) {
                    let shared = star.iter().copied();
                    let both: Vec<u32> = shared
                        .filter(|&t| self.triangles[t as usize].contains(&gone))
                        .collect();
                    if let ([first, second], false) = (&both[..], corners.contains(&gone)) {
                        let square = place.distance_squared(self.positions[gone as usize]);
                        pairs.push((square, gone, kept, [*first, *second]));
                    }
                }
            }
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            let allowed = pairs.into_iter().find(|&(_, gone, kept, dying)| {
                let flat = self.may_merge(gone, kept, dying, &work.stars);
                flat.is_some_and(|flat| flat.is_empty())
            });
            let Some((_, gone, kept, dying)) = allowed else {
                return false;
            };
            self.merge(gone, kept, dying, work);
            if !self.is_bad(triangle) || self.take_out(triangle, work) {
                return true;
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
    /// the `dying` triangles share, or opposite to each other across them. If
    /// so, the triangles that have no area afterwards, which is all right for
    /// those that had none before and for those with two vertices in one place:
    /// their turn comes.
    fn may_merge(&self, gone: u32, kept: u32, dying: [u32; 2], stars: &Stars) -> Option<Vec<u32>> {
        let (star, kept_star) = (stars.get(&gone)?, stars.get(&kept)?);
        let place = self.positions[kept as usize];
        let mut tried = Vec::with_capacity(4);
        for surface in star.iter().map(|&t| self.run_of(t).surface) {
            if tried.contains(&surface) {
                continue;
            }
            tried.push(surface);
            let is_known = || kept_star.iter().any(|&t| self.run_of(t).surface == surface);
            let surface = &self.surfaces[surface as usize];
            let is_on = || solve::residual(std::iter::once(surface), place) <= self.tolerance;
            if !(is_known() || is_on()) {
                return None;
            }
        }
        let (neighbours, kept_neighbours) = (self.link(gone, star), self.link(kept, kept_star));
        let shared = neighbours.iter().filter(|v| kept_neighbours.contains(v));
        let shared: Vec<u32> = shared.copied().collect();
        let [first, second] = shared[..] else {
            return None;
        };
        let own_edge = dying.iter().all(|&t| {
            let corners = self.triangles[t as usize];
            corners.contains(&gone) && corners.contains(&kept)
        });
        if !own_edge && neighbours.contains(&kept) {
            return None;
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
            return None;
        }
        let limit = 2.0 * self.least_area;
        let mut flat = Vec::new();
        for &t in star.iter().filter(survives) {
            let moved = self.triangles[t as usize].map(|v| if v == gone { kept } else { v });
            let area = self.signed_area(t, moved);
            if area > limit {
                continue;
            }
            let is_flat = area >= -limit;
            if !(is_flat && (self.is_bad(t) || self.has_short_edge(moved))) {
                return None;
            }
            flat.push(t);
        }
        Some(flat)
    }

    /// Whether two of the corners are in one place.
    fn has_short_edge(&self, corners: [u32; 3]) -> bool {
        let [p, q, r] = corners.map(|v| self.positions[v as usize]);
        let squares = [(p, q), (q, r), (r, p)].map(|(a, b)| a.distance_squared(b));
        squares
            .into_iter()
            .any(|square| square <= 1e-4 * self.least_area)
    }

    /// The vertices around a vertex.
    fn link(&self, vertex: u32, star: &[u32]) -> Vec<u32> {
        let corners = star.iter().flat_map(|&t| self.triangles[t as usize]);
        let mut link: Vec<u32> = corners.filter(|&v| v != vertex).collect();
        link.sort_unstable();
        link.dedup();
        link
    }

    fn merge(&mut self, gone: u32, kept: u32, dying: [u32; 2], work: &mut Work) {
        for triangle in dying {
            work.removed.insert(triangle);
            for vertex in self.triangles[triangle as usize] {
                if let Some(star) = work.stars.get_mut(&vertex) {
                    star.retain(|&t| t != triangle);
                }
            }
        }
        let star = work.stars.remove(&gone).unwrap_or_default();
        for &triangle in &star {
            let corners = &mut self.triangles[triangle as usize];
            *corners = corners.map(|v| if v == gone { kept } else { v });
        }
        if let Some(kept_star) = work.stars.get_mut(&kept) {
            kept_star.extend(star);
        }
        work.merged.insert(gone);
    }
}
