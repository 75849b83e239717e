//! Half-edges linked to edges and loops: seams, and where other parts touch, are passed over.

use std::f64::consts::TAU;

use crate::arrangement::{Arrangement, HalfEdge};
use crate::numeric::tolerance::SAME_PLACE;

/// No half-edge.
const NONE: u32 = u32::MAX;

/// For each half-edge of a face's border the one that follows along it.
pub(super) struct Links {
    /// [`NONE`] for those within a face.
    next: Vec<u32>,
    /// Whether it is one edge with the next.
    goes_on: Vec<bool>,
}

/// The half-edges of an edge, one after another along one of its faces.
pub(super) struct Chain {
    pub half_edges: Vec<u32>,
    /// Whether it closes on itself without a vertex.
    pub is_ring: bool,
}

impl Links {
    /// Of half-edges of which some are edges, on both sides, and others lie within a face.
    pub fn new(all: &Arrangement, is_edge: impl Fn(u32) -> bool) -> Self {
        let halves = 0..all.half_edges.len() as u32;
        let next = |half: u32| {
            if !is_edge(half) {
                return NONE;
            }
            let mut at = all.half_edges[half as usize].next;
            while !is_edge(at) {
                let twin = all.half_edges[at as usize].twin;
                at = all.half_edges[twin as usize].next;
            }
            at
        };
        let next: Vec<u32> = halves.clone().map(next).collect();
        let goes_on = |half: u32| {
            let after = next[half as usize];
            if after == NONE {
                return false;
            }
            let pair = [half, after].map(|half| &all.half_edges[half as usize]);
            let back = [pair[1], pair[0]].map(|half| &all.half_edges[half.twin as usize]);
            let is_alone = next[pair[1].twin as usize] == pair[0].twin;
            is_alone && is_one_curve(pair) && is_one_curve(back)
        };
        Self {
            goes_on: halves.map(goes_on).collect(),
            next,
        }
    }

    /// All edges, each by its half-edges on one side.
    pub fn edges(&self, all: &Arrangement) -> Vec<Chain> {
        let mut is_seen = vec![false; self.next.len()];
        let mut chains = Vec::new();
        let is_first = |half: u32| {
            // What the edge goes on from, seen from the other side.
            let twin = all.half_edges[half as usize].twin;
            let before = all.half_edges[self.next[twin as usize] as usize].twin;
            !(self.next[before as usize] == half && self.goes_on[before as usize])
        };
        let halves = 0..self.next.len() as u32;
        let edges = || {
            halves
                .clone()
                .filter(|&half| self.next[half as usize] != NONE)
        };
        // First those that begin somewhere, then rings.
        for (half, is_ring) in edges()
            .filter(|&half| is_first(half))
            .map(|half| (half, false))
            .chain(edges().map(|half| (half, true)))
        {
            if is_seen[half as usize] {
                continue;
            }
            let mut half_edges = Vec::new();
            let mut at = half;
            loop {
                is_seen[at as usize] = true;
                is_seen[all.half_edges[at as usize].twin as usize] = true;
                half_edges.push(at);
                if !self.goes_on[at as usize] || self.next[at as usize] == half {
                    break;
                }
                at = self.next[at as usize];
            }
            chains.push(Chain {
                half_edges,
                is_ring,
            });
        }
        chains
    }
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
    pub fn from(&mut self, half: u32) -> Option<Vec<Vec<u32>>> {
        let next = &self.links.next;
        if next[half as usize] == NONE || self.is_seen[half as usize] {
            return None;
        }
        let mut around = vec![half];
        let mut at = next[half as usize];
        while at != half {
            around.push(at);
            at = next[at as usize];
        }
        for &half in &around {
            self.is_seen[half as usize] = true;
        }
        // Begin where an edge does.
        let goes_on = |half: u32| self.links.goes_on[half as usize];
        let last = around.iter().rposition(|&half| !goes_on(half));
        around.rotate_left(last.map_or(0, |last| last + 1));
        let mut edges: Vec<Vec<u32>> = Vec::new();
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
