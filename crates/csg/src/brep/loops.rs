//! Half-edges linked to edges and loops: seams, and where other parts touch, are passed over.

use std::f64::consts::TAU;
use std::mem::replace;

use rustc_hash::{FxHashMap, FxHashSet};

use super::slits::place;
use crate::arrangement::{Arrangement, HalfEdge, HalfEdgeId, VertexId};
use crate::numeric::tolerance::SAME_PLACE;

/// For each half-edge of a face's border the one that follows along it.
pub(super) struct Links {
    /// None for those within a face.
    next: Vec<Option<HalfEdgeId>>,
    /// Whether it is one edge with the next.
    goes_on: Vec<bool>,
}

/// The half-edges of an edge, one after another along one of its faces.
pub(super) struct Chain {
    pub half_edges: Vec<HalfEdgeId>,
    /// Whether it closes on itself without a vertex.
    pub is_ring: bool,
}

impl Links {
    /// Of half-edges of which some are edges, on both sides, and others lie within a face. Edges end
    /// where their loops touch themselves, if so asked.
    pub fn new(
        all: &Arrangement,
        is_edge: impl Fn(HalfEdgeId) -> bool,
        ends_at_touches: bool,
    ) -> Self {
        let next = |half: HalfEdgeId| {
            is_edge(half).then(|| {
                let mut at = all.at(half).next;
                while !is_edge(at) {
                    at = all.at(all.at(at).twin).next;
                }
                at
            })
        };
        let next: Vec<Option<HalfEdgeId>> = all.halves().map(next).collect();
        let is_touched = if ends_at_touches {
            touched(all, &next)
        } else {
            FxHashSet::default()
        };
        let goes_on = |half: HalfEdgeId| {
            let Some(after) = next[half.index()] else {
                return false;
            };
            let pair = [half, after].map(|half| all.at(half));
            let back = [pair[1], pair[0]].map(|half| all.at(half.twin));
            let is_alone = next[pair[1].twin.index()] == Some(pair[0].twin);
            let is_touched = is_touched.contains(&pair[1].from);
            is_alone && !is_touched && is_one_curve(pair) && is_one_curve(back)
        };
        Self {
            goes_on: all.halves().map(goes_on).collect(),
            next,
        }
    }

    /// All edges, each by its half-edges on one side.
    pub fn edges(&self, all: &Arrangement) -> Vec<Chain> {
        let mut is_seen = vec![false; self.next.len()];
        let mut chains = Vec::new();
        let is_first = |&half: &HalfEdgeId| {
            // What the edge goes on from, seen from the other side.
            let before = self.next[all.at(half).twin.index()].map(|after| all.at(after).twin);
            before.and_then(|before| self.after(before)) != Some(half)
        };
        let edges = || {
            all.halves()
                .filter(|half| self.next[half.index()].is_some())
        };
        // First those that begin somewhere, then rings.
        for (half, is_ring) in edges()
            .filter(is_first)
            .map(|half| (half, false))
            .chain(edges().map(|half| (half, true)))
        {
            if is_seen[half.index()] {
                continue;
            }
            let mut half_edges = Vec::new();
            let mut at = Some(half);
            while let Some(here) = at {
                is_seen[here.index()] = true;
                is_seen[all.at(here).twin.index()] = true;
                half_edges.push(here);
                at = self.after(here).filter(|&after| after != half);
            }
            chains.push(Chain {
                half_edges,
                is_ring,
            });
        }
        chains
    }

    /// What a half-edge is one edge with.
    fn after(&self, half: HalfEdgeId) -> Option<HalfEdgeId> {
        self.next[half.index()].filter(|_| self.goes_on[half.index()])
    }
}

/// The vertices at places through which a loop leads more than once: one for each part of the solid
/// that touches another one there.
fn touched(all: &Arrangement, next: &[Option<HalfEdgeId>]) -> FxHashSet<VertexId> {
    let mut touched = FxHashSet::default();
    let mut is_seen = vec![false; next.len()];
    for start in all.halves().filter(|half| next[half.index()].is_some()) {
        let mut at: FxHashMap<[u64; 3], VertexId> = FxHashMap::default();
        let mut here = start;
        while !replace(&mut is_seen[here.index()], true) {
            let vertex = all.at(here).from;
            let other = *at
                .entry(place(all.points[vertex.index()]))
                .or_insert(vertex);
            if other != vertex {
                touched.extend([other, vertex]);
            }
            let Some(after) = next[here.index()] else {
                break;
            };
            here = after;
        }
    }
    touched
}

/// Whether two half-edges that follow each other run on along one curve. Where this passes
/// through itself they may not: then their places there differ.
fn is_one_curve([one, other]: [&HalfEdge; 2]) -> bool {
    let grows = |half: &HalfEdge| half.places[1] > half.places[0];
    let off = (other.places[0] - one.places[1]).rem_euclid(TAU);
    let goes_on = one.is_line || off.min(TAU - off) < SAME_PLACE;
    one.curve == other.curve && grows(one) == grows(other) && goes_on
}

/// The loops of faces.
pub(super) struct Loops<'a> {
    links: &'a Links,
    is_seen: Vec<bool>,
}

impl<'a> Loops<'a> {
    pub fn new(links: &'a Links) -> Self {
        Self {
            is_seen: vec![false; links.next.len()],
            links,
        }
    }

    /// The loop through a half-edge as the half-edges of each of its edges; none if that
    /// lies within a face, or was asked for before.
    pub fn from(&mut self, half: HalfEdgeId) -> Option<Vec<Vec<HalfEdgeId>>> {
        if self.is_seen[half.index()] {
            return None;
        }
        let mut around = vec![half];
        let mut at = self.links.next[half.index()]?;
        while at != half {
            around.push(at);
            at = self.links.next[at.index()]?;
        }
        for &half in &around {
            self.is_seen[half.index()] = true;
        }
        // Begin where an edge does.
        let goes_on = |half: HalfEdgeId| self.links.goes_on[half.index()];
        let last = around.iter().rposition(|&half| !goes_on(half));
        around.rotate_left(last.map_or(0, |last| last + 1));
        let mut edges: Vec<Vec<HalfEdgeId>> = Vec::new();
        let mut is_new = true;
        for half in around {
            match edges.last_mut() {
                Some(edge) if !is_new => edge.push(half),
                _ => edges.push(vec![half]),
            }
            is_new = !goes_on(half);
        }
        Some(edges)
    }
}
