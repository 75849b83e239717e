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

mod around;
mod stars;

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use self::stars::{Face, Stars};
use crate::program::Surface;
use crate::surface::solve;

/// A run of consecutive triangles on one surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// First triangle.
    pub start: u32,
    pub surface: u32,
    /// Whether the surface's gradient points into the solid.
    pub reversed: bool,
}

/// The triangles of a mesh under repair.
pub(crate) struct Cleaner<'a, N> {
    pub positions: &'a [DVec3],
    pub triangles: &'a mut [[u32; 3]],
    /// How many triangles the whole mesh has, of which these may be some.
    pub count: usize,
    pub runs: &'a [Run],
    /// Tells ranges of triangles, in ascending order, among which are all that
    /// had one of the given vertices as a corner to begin with.
    pub near: N,
    /// The triangles around details smaller than a cell: ascending ranges.
    pub unresolved: Vec<Range<usize>>,
    pub surfaces: &'a [Surface],
    /// A triangle of less area than this is to be taken out.
    pub least_area: f64,
    /// Distance to a surface below which a vertex lies on it.
    pub tolerance: f64,
}

/// What came of it.
#[derive(Debug, Default)]
pub(crate) struct Cleaned {
    /// Triangles that are gone, in ascending order.
    pub removed: Vec<u32>,
    /// Vertices that are gone.
    pub merged: FxHashSet<u32>,
    /// Triangles that have got other corners, in ascending order.
    pub altered: Vec<u32>,
    /// Triangles that stayed as they are.
    pub left: Vec<u32>,
}

/// A bad triangle, and how many mergers there had been when it was last tried.
#[derive(Clone, Copy, Debug)]
struct Pending {
    face: Face,
    tried: Option<u32>,
}

/// Two vertices that may be merged: neighbours whose edge the two dying faces
/// share, or opposite to each other across them.
#[derive(Clone, Copy, Debug)]
struct Pair {
    gone: u32,
    kept: u32,
    dying: [Face; 2],
}

/// What is done so far, and what is known for what is to come.
#[derive(Default)]
struct Work {
    stars: Stars,
    removed: FxHashSet<u32>,
    merged: FxHashSet<u32>,
    altered: Vec<u32>,
    /// Triangles that lost their area.
    flattened: Vec<Face>,
    /// Scratch memory: the vertices around two vertices, and the faces that a
    /// merger would flatten.
    link: Vec<u32>,
    kept_link: Vec<u32>,
    flat: Vec<Face>,
}

impl<N: Fn(&[u32]) -> Vec<Range<usize>> + Sync> Cleaner<'_, N> {
    /// Takes out the `bad` triangles as far as that can be done.
    pub fn clean(&mut self, bad: &[u32]) -> Cleaned {
        /// A collapse may make room for another.
        const ROUNDS: usize = 4;
        let mut work = Work::default();
        let pending = bad.par_iter().map(|&triangle| self.face(triangle));
        let mut pending: Vec<Face> = pending.filter(|&face| self.is_bad(face)).collect();
        let mut left = Vec::new();
        if self.are_many(pending.len(), UNRESOLVED_SHARE) {
            left.extend(pending.extract_if(.., |face| self.is_unresolved(*face)));
        }
        for thorough in [false, true] {
            // The work grows with the number of neighbours.
            if pending.is_empty() || (thorough && self.are_many(pending.len(), 500)) {
                break;
            }
            work.altered.sort_unstable();
            work.altered.dedup();
            work.stars = self.stars(&pending, thorough, &work);
            let mut tries: Vec<Pending> = pending.iter().map(|&face| Pending::new(face)).collect();
            for _ in 0..ROUNDS {
                let before = tries.len();
                tries.retain_mut(|pending| !self.is_done(pending, thorough, &mut work));
                let is_stuck = tries.len() == before;
                tries.extend(work.flattened.drain(..).map(Pending::new));
                if is_stuck || tries.is_empty() {
                    break;
                }
            }
            let rest = tries.iter().map(|pending| pending.face);
            pending.clear();
            pending.extend(rest.filter(|face| !work.removed.contains(&face.triangle)));
            pending.retain(|&face| self.is_bad(face));
        }
        let mut removed: Vec<u32> = work.removed.into_iter().collect();
        removed.sort_unstable();
        work.altered.sort_unstable();
        left.extend(pending);
        Cleaned {
            removed,
            merged: work.merged,
            altered: work.altered,
            left: left.iter().map(|face| face.triangle).collect(),
        }
    }

    /// Whether so many are more than one of `share` triangles.
    fn are_many(&self, count: usize, share: usize) -> bool {
        are_many(count, self.count, share)
    }

    fn is_unresolved(&self, face: Face) -> bool {
        let at = face.triangle as usize;
        let after = self.unresolved.partition_point(|range| range.end <= at);
        let range = self.unresolved.get(after);
        range.is_some_and(|range| range.contains(&at))
    }

    /// Tries to take out a triangle; whether it is gone, or no longer bad.
    fn is_done(&mut self, pending: &mut Pending, thorough: bool, work: &mut Work) -> bool {
        let face = pending.face;
        if work.removed.contains(&face.triangle) {
            return true;
        }
        // What failed fails again until something near has changed.
        let is_new = |since| self.changed_around(face, since, &work.stars);
        if !pending.tried.is_none_or(is_new) {
            return false;
        }
        pending.tried = Some(work.merged.len() as u32);
        !self.is_bad(face) || self.take_out(face, work) || (thorough && self.thin_out(face, work))
    }

    /// The area of a face with the given corners.
    fn area(&self, face: Face, corners: [u32; 3]) -> Area {
        let corners = corners.map(|v| self.positions[v as usize]);
        let surface = &self.surfaces[face.surface as usize];
        Area::of(corners, surface, face.reversed)
    }

    fn is_bad(&self, face: Face) -> bool {
        let area = self.area(face, self.corners(face));
        !area.is_above(self.least_area)
    }

    fn square(&self, u: u32, v: u32) -> f64 {
        self.positions[u as usize].distance_squared(self.positions[v as usize])
    }

    /// Merges two vertices of the triangle, the nearest that may be; else one
    /// of them and the vertex opposite to it in a neighbouring triangle.
    fn take_out(&mut self, face: Face, work: &mut Work) -> bool {
        let [a, b, c] = self.corners(face);
        let sides = [(a, b, c), (b, c, a), (c, a, b)];
        let other = sides.map(|(u, v, _)| self.neighbour(face, u, v, &work.stars));
        let along = |i: usize| {
            let (u, v, _) = sides[i];
            Some((u, v, other[i]?))
        };
        let across = |i: usize| {
            let (u, v, apex) = sides[i];
            let mut corners = self.corners(other[i]?).into_iter();
            let opposite = corners.find(|&w| w != u && w != v)?;
            Some((apex, opposite, other[i]?))
        };
        let (along, across) = ([0, 1, 2].map(along), [0, 1, 2].map(across));
        for candidates in [along, across] {
            // Both ways round, the nearest first.
            let mut pairs = [None; 6];
            for (i, candidate) in candidates.into_iter().enumerate() {
                pairs[i] = candidate.map(|(gone, kept, other)| {
                    let dying = [face, other];
                    (self.square(gone, kept), Pair { gone, kept, dying })
                });
                pairs[i + 3] = pairs[i].map(|(square, pair)| {
                    let (gone, kept) = (pair.kept, pair.gone);
                    (square, Pair { gone, kept, ..pair })
                });
            }
            let square = |pair: &Option<(f64, Pair)>| pair.map_or(f64::INFINITY, |(s, _)| s);
            pairs.sort_by(|a, b| square(a).total_cmp(&square(b)));
            for (_, pair) in pairs.into_iter().flatten() {
                if self.may_merge(&pair, work) {
                    work.flattened.extend_from_slice(&work.flat);
                    self.merge(&pair, work);
                    return true;
                }
            }
        }
        false
    }

    /// Merges neighbours of the triangle's vertices into these, the nearest
    /// first, until the triangle can be taken out.
    fn thin_out(&mut self, face: Face, work: &mut Work) -> bool {
        const MOST_MERGERS: usize = 6;
        for _ in 0..MOST_MERGERS {
            let corners = self.corners(face);
            let mut pairs = Vec::new();
            for kept in corners {
                let Some(star) = work.stars.get(kept) else {
                    continue;
                };
                let mut link = Vec::new();
                self.link(kept, &star.faces, &mut link);
                link.sort_unstable();
                for gone in link {
                    let shared = star.faces.iter().copied();
                    let mut shared = shared.filter(|&f| self.corners(f).contains(&gone));
                    let (first, second, third) = (shared.next(), shared.next(), shared.next());
                    if let (Some(first), Some(second), None) = (first, second, third)
                        && !corners.contains(&gone)
                    {
                        let dying = [first, second];
                        pairs.push((self.square(kept, gone), Pair { gone, kept, dying }));
                    }
                }
            }
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut pairs = pairs.into_iter();
            let allowed =
                pairs.find(|(_, pair)| self.may_merge(pair, work) && work.flat.is_empty());
            let Some((_, pair)) = allowed else {
                return false;
            };
            self.merge(&pair, work);
            if !self.is_bad(face) || self.take_out(face, work) {
                return true;
            }
        }
        false
    }

    /// Whether one vertex of a pair may be moved onto the other. If so,
    /// `work.flat` has the triangles without area afterwards, which is all
    /// right for those that had none before and for those with two vertices in
    /// one place: their turn comes.
    fn may_merge(&self, pair: &Pair, work: &mut Work) -> bool {
        let &Pair { gone, kept, dying } = pair;
        let (Some(star), Some(kept_star)) = (work.stars.get(gone), work.stars.get(kept)) else {
            return false;
        };
        let (star, kept_star) = (&star.faces, &kept_star.faces);
        let place = self.positions[kept as usize];
        let is_kept = |surface: u32| {
            let known = || kept_star.iter().any(|face| face.surface == surface);
            let surface = &self.surfaces[surface as usize];
            known() || solve::residual(std::iter::once(surface), place) <= self.tolerance
        };
        let mut last = u32::MAX;
        for face in star {
            if face.surface != last && !is_kept(face.surface) {
                return false;
            }
            last = face.surface;
        }
        let survives = |face: &&Face| !dying.contains(face);
        // The test that fails most often comes first.
        work.flat.clear();
        for &face in star.iter().filter(survives) {
            let moved = self.corners(face).map(|v| if v == gone { kept } else { v });
            let area = self.area(face, moved);
            if area.is_above(self.least_area) {
                continue;
            }
            let is_flat = area.is_within(self.least_area);
            if !(is_flat && (self.is_bad(face) || self.has_short_edge(moved))) {
                return false;
            }
            work.flat.push(face);
        }
        self.link(gone, star, &mut work.link);
        self.link(kept, kept_star, &mut work.kept_link);
        let mut shared = work.link.iter().filter(|v| work.kept_link.contains(v));
        let (Some(&first), Some(&second), None) = (shared.next(), shared.next(), shared.next())
        else {
            return false;
        };
        let own_edge = dying.iter().all(|&face| {
            let corners = self.corners(face);
            corners.contains(&gone) && corners.contains(&kept)
        });
        if !own_edge && work.link.contains(&kept) {
            return false;
        }
        // An edge between the two apexes that both links share: a tetrahedron
        // would be flattened.
        let spans = |star: &[Face]| {
            star.iter().filter(survives).any(|&face| {
                let corners = self.corners(face);
                corners.contains(&first) && corners.contains(&second)
            })
        };
        !(spans(star) && spans(kept_star))
    }

    /// Whether two of the corners are in one place.
    fn has_short_edge(&self, [p, q, r]: [u32; 3]) -> bool {
        let mut squares = [(p, q), (q, r), (r, p)].into_iter();
        squares.any(|(a, b)| self.square(a, b) <= 1e-4 * self.least_area)
    }

    fn merge(&mut self, pair: &Pair, work: &mut Work) {
        let &Pair { gone, kept, dying } = pair;
        work.merged.insert(gone);
        let now = work.merged.len() as u32;
        let stars = &mut work.stars;
        let change = |corners: [u32; 3], stars: &mut Stars| {
            for vertex in corners {
                if let Some(star) = stars.get_mut(vertex) {
                    star.changed = now;
                }
            }
        };
        for face in dying {
            work.removed.insert(face.triangle);
            change(self.corners(face), stars);
            for vertex in self.corners(face) {
                if let Some(star) = stars.get_mut(vertex) {
                    star.faces.retain(|&other| other != face);
                }
            }
        }
        let star = stars.get_mut(gone);
        let star = star.map_or_else(Vec::new, |star| std::mem::take(&mut star.faces));
        for &face in &star {
            let corners = &mut self.triangles[face.triangle as usize];
            *corners = corners.map(|v| if v == gone { kept } else { v });
            work.altered.push(face.triangle);
            change(*corners, stars);
        }
        if let Some(kept_star) = stars.get_mut(kept) {
            kept_star.faces.extend(star);
            kept_star.changed = now;
        }
    }
}

/// Whether a triangle on a surface has less area than it should, or is folded over.
pub(super) fn is_bad(
    corners: [DVec3; 3],
    (surface, reversed): (&Surface, bool),
    least_area: f64,
) -> bool {
    !Area::of(corners, surface, reversed).is_above(least_area)
}

/// Whether so many are more than one of `share` of all triangles.
pub(crate) fn are_many(count: usize, all: usize, share: usize) -> bool {
    count > 1000 + all / share
}

/// Bad triangles of which more than one of so many are too many for those
/// among details smaller than a cell to be tried: most would stay.
pub(crate) const UNRESOLVED_SHARE: usize = 50;

/// A triangle's area, seen from outside: negative if it is folded over.
#[derive(Clone, Copy)]
struct Area {
    /// Twice the area times the length of the surface's gradient,
    scaled: f64,
    /// and the square of that length.
    square: f64,
}

impl Area {
    fn of([p, q, r]: [DVec3; 3], surface: &Surface, reversed: bool) -> Self {
        let gradient = surface.gradient((p + q + r) / 3.0);
        let outward = if reversed { -gradient } else { gradient };
        Self {
            scaled: (q - p).cross(r - p).dot(outward),
            square: gradient.length_squared(),
        }
    }

    fn is_above(self, limit: f64) -> bool {
        self.scaled > 0.0 && self.scaled * self.scaled > 4.0 * limit * limit * self.square
    }

    /// Whether it is as good as none, either way.
    fn is_within(self, limit: f64) -> bool {
        self.scaled * self.scaled <= 4.0 * limit * limit * self.square
    }
}

impl Pending {
    fn new(face: Face) -> Self {
        Self { face, tried: None }
    }
}
