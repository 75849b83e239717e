//! Edges that run across each other although their curves do not: chords of
//! curves that are close to each other, or touch. More chords part them.

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::Scene;
use super::boundary::Boundary;
use super::triangulate::orient;
use crate::net::solve;

impl Boundary {
    /// Puts a vertex of their curve in the middle of edges, and of all others along
    /// the same stretch of it, where the solid touches itself. One half of each edge
    /// that was split; none if one has no such point.
    pub fn split(&mut self, scene: &Scene<'_>, edges: &[u32]) -> Option<Vec<u32>> {
        let mut between: FxHashMap<[u32; 2], SmallVec<[u32; 2]>> = FxHashMap::default();
        for half_edge in 0..self.half_edges.len() as u32 {
            if !self.is_removed(half_edge) && half_edge < self.at(half_edge).twin {
                between
                    .entry(self.ends(half_edge))
                    .or_default()
                    .push(half_edge);
            }
        }
        let mut split: Vec<u32> = Vec::new();
        for &half_edge in edges {
            let half_edge = half_edge.min(self.at(half_edge).twin);
            let alike = between.get(&self.ends(half_edge));
            let Some(alike) = alike.filter(|alike| alike.contains(&half_edge)) else {
                // Split already, with another one.
                continue;
            };
            let middle = self.middle(scene, half_edge)?;
            for &other in alike {
                if other == half_edge || self.runs_through(scene, other, middle) {
                    self.split_at(other, middle);
                    split.push(other);
                }
            }
        }
        Some(split)
    }

    /// The points that an edge joins, in ascending order.
    fn ends(&self, half_edge: u32) -> [u32; 2] {
        let [a, b] = [self.at(half_edge).from, self.end(half_edge)];
        [a.min(b), a.max(b)]
    }

    /// Whether an edge's curve goes through a point next to the middle of its chord.
    fn runs_through(&self, scene: &Scene<'_>, half_edge: u32, point: DVec3) -> bool {
        if self.surfaces_of(scene, half_edge).is_some() {
            let middle = self.middle(scene, half_edge);
            return middle.is_some_and(|middle| middle.distance(point) <= scene.weld);
        }
        // Within a face, which others touch there.
        let face = &self.faces[self.at(half_edge).face as usize];
        let surface = &scene.surfaces[face.plane as usize];
        surface.value(point).abs() <= scene.weld * surface.gradient(point).length()
    }

    /// The point of an edge's curve next to the middle of its chord.
    pub fn middle(&self, scene: &Scene<'_>, half_edge: u32) -> Option<DVec3> {
        let [a, b] =
            [self.at(half_edge).from, self.end(half_edge)].map(|p| self.points[p as usize]);
        let (middle, half) = (0.5 * (a + b), 0.5 * a.distance(b));
        let surfaces = self.surfaces_of(scene, half_edge);
        let Some(surfaces) = surfaces.filter(|s| s.iter().any(|s| !s.is_plane())) else {
            return Some(middle);
        };
        let found = solve::common_point(&surfaces, middle, half);
        let is_near = found.point.distance(middle) <= 0.9 * half;
        (is_near && found.residual <= scene.weld && half > 10.0 * scene.weld).then_some(found.point)
    }

    /// Adds the edges that run across others of the same face as it is seen: of
    /// each two the one that is farther from its curve. If there are none, the one
    /// that is farthest of each contour that goes around the wrong way. Half-edges
    /// are given by contour.
    pub fn crossing_edges(
        &self,
        scene: &Scene<'_>,
        face: u32,
        contours: &[Vec<u32>],
        crossing: &mut Vec<u32>,
    ) {
        let side = &self.faces[face as usize];
        let flat = |vertex: u32| scene.flatten(side, self.points[vertex as usize]);
        let edges: Vec<(u32, [u32; 2], [DVec2; 2])> = contours
            .iter()
            .flatten()
            .map(|&h| {
                let ends = [self.at(h).from, self.end(h)];
                (h, ends, ends.map(flat))
            })
            .collect();
        let sagitta = |half_edge: u32| {
            let [a, b] =
                [self.at(half_edge).from, self.end(half_edge)].map(|p| self.points[p as usize]);
            let middle = self.middle(scene, half_edge);
            middle.map_or(0.0, |m| m.distance(0.5 * (a + b)))
        };
        let known = crossing.len();
        for (k, (first, ends, places)) in edges.iter().enumerate() {
            for (second, others, other_places) in &edges[k + 1..] {
                if *second == self.at(*first).twin || !cross(*ends, *places, *others, *other_places)
                {
                    continue;
                }
                let [one, other] = [*first, *second].map(sagitta);
                let worse = if one >= other { *first } else { *second };
                // One half of an edge stands for both.
                crossing.push(worse.min(self.at(worse).twin));
            }
        }
        if crossing.len() > known {
            return;
        }
        // A face narrower than its curves bend may be turned over as a whole.
        for contour in contours {
            let area = |&h: &u32| flat(self.at(h).from).perp_dot(flat(self.end(h)));
            if contour.iter().map(area).sum::<f64>() <= 0.0 {
                let by_sagitta = |a: &&u32, b: &&u32| sagitta(**a).total_cmp(&sagitta(**b));
                let worst = contour.iter().max_by(by_sagitta);
                crossing.extend(worst.map(|&h| h.min(self.at(h).twin)));
            }
        }
    }
}

/// Whether two edges have more in common than their ends.
fn cross(ends: [u32; 2], [a, b]: [DVec2; 2], others: [u32; 2], [c, d]: [DVec2; 2]) -> bool {
    let apart = |p: DVec2, q: DVec2, r: DVec2, s: DVec2| {
        p.max(q).cmplt(r.min(s)).any() || r.max(s).cmplt(p.min(q)).any()
    };
    if apart(a, b, c, d) {
        return false;
    }
    let shared = ends.iter().position(|end| others.contains(end));
    if let Some(k) = shared {
        // In one direction from their common end.
        let (here, one) = if k == 0 { (a, b) } else { (b, a) };
        let other = if others[0] == ends[k] { d } else { c };
        return orient(here, one, other) == 0.0 && (one - here).dot(other - here) > 0.0;
    }
    let sides = |p, q, r, s| orient(p, q, r) * orient(p, q, s) <= 0.0;
    sides(a, b, c, d) && sides(c, d, a, b)
}
