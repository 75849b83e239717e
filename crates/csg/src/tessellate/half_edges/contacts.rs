//! Finds the edges along which the solid touches itself, and holds them.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::{HalfEdges, Kind};
use crate::numeric::tolerance::{NEAR_OF_REFINED, TOUCHING_AT_ENDS};
use crate::program::SurfaceId;
use crate::tessellate::contacts::Contacts;
use crate::tessellate::curves::on_curve;

impl HalfEdges<'_> {
    /// For each vertex the first one in the same place.
    pub fn places(&self) -> Vec<u32> {
        // Zero has two signs.
        let bits = |at: DVec3| (at + DVec3::ZERO).to_array().map(f64::to_bits);
        let mut first_at = FxHashMap::default();
        first_at.reserve(self.positions.len());
        let first = |(vertex, &at): (u32, &DVec3)| match self.kinds[vertex as usize] {
            Kind::Gone => vertex,
            _ => *first_at.entry(bits(at)).or_insert(vertex),
        };
        (0u32..).zip(&self.positions).map(first).collect()
    }

    /// Lets no vertex move that is in the same place as another one, where the
    /// solid touches itself, and leaves edges as they are that join the same two
    /// places as another one.
    pub fn fix_contacts(&mut self) {
        let places = self.places();
        let mut is_shared = vec![false; self.positions.len()];
        for (vertex, &place) in (0u32..).zip(&places) {
            if place != vertex {
                for shared in [place, vertex] {
                    self.kinds[shared as usize] = Kind::Corner;
                    is_shared[shared as usize] = true;
                }
            }
        }
        if !is_shared.contains(&true) {
            self.contacts = Contacts::default();
            return;
        }
        let mut edges: Vec<([u32; 2], [u32; 2])> = Vec::new();
        for half in self.halves() {
            let ends = [self.origin(half), self.target(half)];
            let mut between = ends.map(|v| places[v as usize]);
            if ends[0] < ends[1] && ends.iter().any(|&v| is_shared[v as usize]) {
                between.sort_unstable();
                edges.push((between, ends));
            }
        }
        edges.sort_unstable();
        let alike = edges.chunk_by(|a, b| a.0 == b.0).filter(|e| e.len() > 1);
        let alike = alike.map(|edges| {
            let edges = edges.iter().map(|edge| edge.1).collect();
            self.along_one_curve(edges)
        });
        let edges: Vec<Vec<[u32; 2]>> = alike.filter(|edges| edges.len() > 1).collect();
        let places = (0..).zip(&edges);
        let place_of = places.flat_map(|(place, edges)| edges.iter().map(move |&e| (e, place)));
        self.contacts = Contacts {
            place_of: place_of.collect(),
            edges,
        };
    }

    /// Of edges that join the same two places those whose surfaces go through the
    /// point at which their curve would be cut: a chord of one face may join the ends of
    /// an edge that it has nothing to do with. None if all of them are such chords.
    fn along_one_curve(&self, mut edges: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
        let Some(curve) = self.contact_curve(&edges) else {
            return Vec::new();
        };
        let curve = curve.map(|id| &self.surfaces[id]);
        let [p, q] = edges[0].map(|v| self.at(v));
        if let Some(middle) = on_curve(curve, p.midpoint(q), 0.5 * p.distance(q), self.precision) {
            let is_on = |half: u32| {
                let surface = self.surface(half);
                let off = surface.value(middle).abs();
                off <= NEAR_OF_REFINED * self.precision * surface.gradient(middle).length()
            };
            edges.retain(|&ends| {
                let half = self.between(ends);
                half.is_some_and(|half| is_on(half) && is_on(self.twin(half)))
            });
        }
        edges
    }

    pub fn between(&self, [from, to]: [u32; 2]) -> Option<u32> {
        self.around(from).find(|&half| self.target(half) == to)
    }

    /// Whether another edge joins the same two places, so that it is to stay.
    #[inline(always)]
    pub fn is_contact(&self, half: u32) -> bool {
        !self.contacts.is_empty() && self.contacts.place_of.contains_key(&self.ends(half))
    }

    /// The surfaces on whose curve edges at the same place are: those on both sides of
    /// the first that runs between two, or, if all run along faces, two that touch each
    /// other at both ends.
    pub fn contact_curve(&self, edges: &[[u32; 2]]) -> Option<[SurfaceId; 2]> {
        let halves = edges.iter().filter_map(|&ends| self.between(ends));
        if let Some(border) = halves.clone().find(|&half| self.is_on_curve(half)) {
            return Some(self.curve(border));
        }
        let ends = edges.first()?.map(|end| self.at(end));
        let mut surfaces = halves.map(|half| self.surface_id(half));
        let one = surfaces.next()?;
        let touches = |&other: &SurfaceId| {
            let pair = [one, other].map(|id| &self.surfaces[id]);
            let is_parallel = |&at: &DVec3| {
                let [n, m] = pair.map(|s| s.gradient(at).normalize_or_zero());
                n.cross(m).length() <= TOUCHING_AT_ENDS
            };
            one != other && ends.iter().all(is_parallel)
        };
        Some([one, surfaces.find(touches)?])
    }
}
