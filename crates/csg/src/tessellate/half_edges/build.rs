//! From triangles to half-edges.

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::pairing::{NONE, halves_of, pair_up};
use super::{HalfEdges, Kind};
use crate::numeric::tolerance::{ON_REFINED, TOUCHING};
use crate::program::Surface;
use crate::tessellate::contacts::Contacts;
use crate::tessellate::regions::regions;
use crate::tessellate::surfaced::Surfaced;

impl<'a> HalfEdges<'a> {
    /// `None` if the triangles are no closed, oriented 2-manifold.
    pub fn new(surfaced: &Surfaced, surfaces: &'a [Surface]) -> Option<Self> {
        let positions = surfaced.positions.clone();
        let halves = pair_up(positions.len(), &surfaced.triangles)?;
        let mut leaving = vec![NONE; positions.len()];
        for (triangle, corners) in (0u32..).zip(&surfaced.triangles) {
            for (half, &origin) in halves_of(triangle).zip(corners) {
                leaving[origin as usize] = half;
            }
        }
        let mut mesh = Self {
            surfaces,
            regions: Vec::new(),
            kinds: vec![Kind::Gone; positions.len()],
            positions,
            leaving,
            halves,
            piece_halves: Vec::new(),
            free: Vec::new(),
            fine_edges: FxHashSet::default(),
            contacts: Contacts::default(),
            borders: surfaced.borders.clone(),
            precision: surfaced.precision,
        };
        mesh.regions = regions(&mut mesh, surfaced);
        for vertex in 0..mesh.positions.len() as u32 {
            if mesh.leaving[vertex as usize] != NONE {
                mesh.kinds[vertex as usize] = mesh.kind_of(vertex);
            }
        }
        Some(mesh)
    }

    fn kind_of(&self, vertex: u32) -> Kind {
        let mut features = [NONE; 2];
        let mut count = 0;
        for half in self.around(vertex) {
            if self.is_feature(half) {
                if count == 2 {
                    return Kind::Corner;
                }
                features[count] = half;
                count += 1;
            }
        }
        match count {
            0 if self.has_apex(self.leaving[vertex as usize], self.at(vertex)) => Kind::Corner,
            0 => Kind::Face,
            2 => {
                let [first, second] = features.map(|half| {
                    let [a, b] = self.curve(half);
                    (a.min(b), a.max(b))
                });
                // A border within one surface of which no more is known is nobody's
                // to move.
                let is_curve = first == second && first.0 != first.1;
                let sides = [features[0], self.twin(features[0])];
                let is_apex = sides
                    .iter()
                    .any(|&half| self.has_apex(half, self.at(vertex)));
                if is_curve && !is_apex && !self.is_node(vertex, features) {
                    Kind::Curve
                } else {
                    Kind::Corner
                }
            }
            _ => Kind::Corner,
        }
    }

    /// Whether two surfaces touch where two edges of theirs meet, and not all along these: their
    /// curve has branches there, and the edges may be of different ones.
    fn is_node(&self, vertex: u32, edges: [u32; 2]) -> bool {
        let surfaces = self.curve_surfaces(edges[0]);
        let touch = |vertex: u32| {
            let [u, v] = surfaces.map(|surface| surface.gradient(self.at(vertex)));
            u.cross(v).length() <= TOUCHING * u.length() * v.length()
        };
        touch(vertex) && !edges.iter().all(|&half| touch(self.target(half)))
    }

    /// Whether a point is the apex of a half-edge's surface.
    fn has_apex(&self, half: u32, at: DVec3) -> bool {
        let apex = self.surface(half).apex();
        apex.is_some_and(|apex| apex.distance(at) <= ON_REFINED * (at.length() + apex.length()))
    }
}
