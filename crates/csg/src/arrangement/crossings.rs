//! Edges that run across each other although their curves do not: chords of
//! curves that are close to each other, or touch. More chords part them.

use glam::{DMat3, DVec2, DVec3};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::boundary::{Boundary, HalfEdge};
use super::curve::Curve;
use super::frame::Frame;
use super::ids::{FaceId, HalfEdgeId, VertexId};
use super::roots::bracketed;
use super::scene::Scene;
use crate::mesh::predicates::orient;
use crate::surface::solve;

/// A point of an edge's curve at which a vertex may part it from another one. One
/// half of the edge stands for both.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub half_edge: HalfEdgeId,
    at: DVec3,
}

impl Boundary {
    /// Puts a vertex of their curve in the middle of edges, and of all others along
    /// the same stretch of it, where the solid touches itself. One half of each edge
    /// that was split; none if one has no such point.
    pub fn split(&mut self, scene: &Scene<'_>, edges: &[HalfEdgeId]) -> Option<Vec<HalfEdgeId>> {
        let splits = edges.iter().map(|&half_edge| self.halve(scene, half_edge));
        let splits: Vec<Split> = splits.collect::<Option<_>>()?;
        Some(self.split_all(scene, &splits))
    }

    /// The split of an edge in its middle.
    fn halve(&self, scene: &Scene<'_>, half_edge: HalfEdgeId) -> Option<Split> {
        Some(self.split_of(half_edge, self.middle(scene, half_edge)?))
    }

    /// The split of an edge, given by either half, at a point of its curve.
    fn split_of(&self, half_edge: HalfEdgeId, at: DVec3) -> Split {
        let half_edge = half_edge.min(self.at(half_edge).twin);
        Split { half_edge, at }
    }

    /// Splits edges, each no more than once, and all others along the same stretch
    /// of their curves. One half of each edge that was split.
    pub fn split_all(&mut self, scene: &Scene<'_>, splits: &[Split]) -> Vec<HalfEdgeId> {
        let mut between: FxHashMap<[VertexId; 2], SmallVec<[HalfEdgeId; 2]>> = FxHashMap::default();
        let sorted_ends = |all: &Self, half_edge| {
            let mut ends = all.ends(half_edge);
            ends.sort_unstable();
            ends
        };
        for half_edge in self.edges() {
            let alike = between.entry(sorted_ends(self, half_edge));
            alike.or_default().push(half_edge);
        }
        let mut split = Vec::new();
        for &Split { half_edge, at } in splits {
            let alike = between.get(&sorted_ends(self, half_edge));
            let Some(alike) = alike.filter(|alike| alike.contains(&half_edge)) else {
                // Split already, with another one.
                continue;
            };
            for &other in alike {
                if other == half_edge || self.runs_through(scene, other, at) {
                    let places = self.both(other).map(|half| self.place_of(scene, half, at));
                    self.split_at(other, at, places);
                    split.push(other);
                }
            }
        }
        split
    }

    /// Whether an edge's curve goes through a point next to its chord.
    fn runs_through(&self, scene: &Scene<'_>, half_edge: HalfEdgeId, point: DVec3) -> bool {
        let [face, other] = self.faces_of(half_edge);
        if face != other && self.surfaces_of(scene, half_edge).is_some() {
            let near = self.next_to(scene, half_edge, point);
            return near.is_some_and(|near| near.distance(point) <= scene.weld);
        }
        // Within a face, which others touch there.
        let surface = scene.surface(self.side(half_edge).plane);
        surface.value(point).abs() <= scene.weld * surface.gradient(point).length()
    }

    /// The point of an edge's curve next to the middle of its chord.
    pub fn middle(&self, scene: &Scene<'_>, half_edge: HalfEdgeId) -> Option<DVec3> {
        let [a, b] = self.chord(half_edge);
        self.next_to(scene, half_edge, 0.5 * (a + b))
    }

    /// The point of an edge halfway between its places on its curve.
    pub fn halfway(&self, scene: &Scene<'_>, half_edge: HalfEdgeId) -> Option<DVec3> {
        let [a, b] = self.chord(half_edge);
        let surfaces = self.surfaces_of(scene, half_edge);
        if surfaces.is_none_or(|s| s.iter().all(|s| s.is_plane())) {
            return Some(a.midpoint(b));
        }
        let HalfEdge { curve, places, .. } = *self.at(half_edge);
        match scene.curve(curve)? {
            Curve::Line { .. } => Some(a.midpoint(b)),
            curve => Some(curve.at(0.5 * (places[0] + places[1]))),
        }
    }

    /// The point of an edge's curve next to another point; none if that is not
    /// between the edge's ends, or these are one but for rounding.
    fn next_to(&self, scene: &Scene<'_>, half_edge: HalfEdgeId, point: DVec3) -> Option<DVec3> {
        let rounded = self.rounded(scene, half_edge);
        let [a, b] = self.chord(half_edge);
        let half = 0.5 * rounded.length(b - a);
        let found = self.on_curve(scene, half_edge, point)?;
        let is_between = rounded.length(found - a.midpoint(b)) <= 0.9 * half;
        is_between.then_some(found)
    }

    /// How lengths are measured along an edge: as its face is seen, where a quadric is round
    /// however flat or long it is. There its curves turn as little as their chords let them;
    /// in space they may turn back between two ends that are side by side.
    fn rounded(&self, scene: &Scene<'_>, half_edge: HalfEdgeId) -> Rounded {
        let mut frames = self.both(half_edge).into_iter();
        let frame = frames.find_map(|half| scene.frame(self.side(half).plane));
        Rounded(frame.map_or(DMat3::IDENTITY, Frame::to_frame))
    }

    /// The point of an edge's curve beside another point, or else the end that is nearer
    /// to that; none if the ends are one but for rounding.
    pub fn on_curve(
        &self,
        scene: &Scene<'_>,
        half_edge: HalfEdgeId,
        point: DVec3,
    ) -> Option<DVec3> {
        let [a, b] = self.chord(half_edge);
        let straight = || Some(a + (point - a).project_onto(b - a));
        let surfaces = self.surfaces_of(scene, half_edge);
        let Some(surfaces) = surfaces.filter(|s| s.iter().any(|s| !s.is_plane())) else {
            return straight();
        };
        if a.distance(b) <= 20.0 * scene.weld {
            return None;
        }
        let curve = scene.curve(self.at(half_edge).curve)?;
        if matches!(curve, Curve::Line { .. }) {
            return straight();
        }
        let start = curve.at(self.place_beside(scene, &curve, half_edge, point));
        let reach = scene.touching_reach();
        let found = solve::sharp_common_point(&surfaces, start, reach, scene.blur());
        if found.residual <= scene.weld && found.point.distance(start) <= reach {
            return Some(found.point);
        }
        let is_on = solve::residual(surfaces.into_iter(), start) <= scene.weld;
        is_on.then_some(start)
    }

    /// Where on its curve an edge is beside a point.
    fn place_of(&self, scene: &Scene<'_>, half_edge: HalfEdgeId, point: DVec3) -> f64 {
        let curve = scene.curve(self.at(half_edge).curve);
        let place = curve.map(|curve| self.place_beside(scene, &curve, half_edge, point));
        place.unwrap_or(self.at(half_edge).places[0])
    }

    /// Where an edge is in the plane through a point across its chord, or else the end
    /// that is nearer to that.
    fn place_beside(
        &self,
        scene: &Scene<'_>,
        curve: &Curve,
        half_edge: HalfEdgeId,
        point: DVec3,
    ) -> f64 {
        let rounded = self.rounded(scene, half_edge);
        let [a, b] = self.chord(half_edge);
        let along = rounded.across(b - a);
        let mut ends = self.at(half_edge).places;
        let beyond = |place: f64| (curve.at(place) - point).dot(along);
        let mut values = ends.map(beyond);
        if values[0] >= 0.0 {
            return ends[0];
        }
        if values[1] <= 0.0 {
            return ends[1];
        }
        if ends[0] > ends[1] {
            ends.reverse();
            values.reverse();
        }
        bracketed(beyond, ends, values)
    }

    /// Adds splits that part edges of the same face which run across each other as
    /// it is seen. If there are none, edges are split beside corners that are nearer
    /// to their curves, and if there are none of these, either, of each contour
    /// that goes around the wrong way the edge that is farthest from its curve is
    /// halved. Half-edges are given by contour.
    pub fn part(
        &self,
        scene: &Scene<'_>,
        face: FaceId,
        contours: &[Vec<HalfEdgeId>],
        splits: &mut Vec<Split>,
    ) {
        let side = &self.faces[face.index()];
        let flat = |vertex: VertexId| scene.flatten(side, self.point(vertex));
        let edges = contours.iter().flatten().map(|&half_edge| {
            let ends = self.ends(half_edge);
            (half_edge, ends, ends.map(flat))
        });
        let edges: Vec<(HalfEdgeId, [VertexId; 2], [DVec2; 2])> = edges.collect();
        let known = splits.len();
        let crosses = |one: usize, other: usize| {
            let [(first, ends, places), (second, others, other_places)] =
                [one, other].map(|k| edges[k]);
            second != self.at(first).twin && cross(ends, places, others, other_places)
        };
        let extents = edges
            .iter()
            .map(|(_, _, [a, b])| [a.x.min(b.x), a.x.max(b.x)]);
        for pair in pairs_that_overlap(extents, crosses) {
            splits.extend(self.split_between(scene, pair.map(|k| edges[k].0)));
        }
        if splits.len() > known {
            return;
        }
        let beside = |edge: &(HalfEdgeId, _, _)| self.split_beside_corner(scene, edge.0, contours);
        splits.extend(edges.iter().filter_map(beside));
        if splits.len() > known {
            return;
        }
        // A face narrower than its curves bend may be turned over as a whole.
        for contour in contours {
            let area = |&half_edge: &HalfEdgeId| {
                let [from, to] = self.ends(half_edge).map(flat);
                from.perp_dot(to)
            };
            if contour.iter().map(area).sum::<f64>() <= 0.0 {
                let rounded = self.rounded(scene, contour[0]);
                let sagitta = |half_edge: &HalfEdgeId| self.sagitta(scene, *half_edge, rounded);
                let by_sagitta =
                    |a: &&HalfEdgeId, b: &&HalfEdgeId| sagitta(a).total_cmp(&sagitta(b));
                let worst = contour.iter().max_by(by_sagitta);
                splits.extend(worst.and_then(|&h| self.halve(scene, h)));
            }
        }
    }

    /// Splits of edges that are too coarse for the faces next to them: beside a corner
    /// that is nearer to the edge's curve, or else in the middle; none if one has
    /// no such point. Contours are given by face.
    pub fn refine(
        &self,
        scene: &Scene<'_>,
        edges: &[HalfEdgeId],
        contours: &[Vec<Vec<HalfEdgeId>>],
    ) -> Option<Vec<Split>> {
        let split = |&half_edge: &HalfEdgeId| {
            let both = self.both(half_edge).into_iter();
            let mut beside = both.filter_map(|half| {
                let contours = &contours[self.at(half).face.index()];
                self.split_beside_corner(scene, half, contours)
            });
            beside.next().or_else(|| self.halve(scene, half_edge))
        };
        edges.iter().map(split).collect()
    }

    /// The split of an edge beside a corner of its face that is nearer to the edge's
    /// curve than the edge is, where that is farthest off: next to where curves touch,
    /// faces are narrower than chords stray, however short these are, unless the
    /// vertices on both sides of the face are side by side.
    fn split_beside_corner(
        &self,
        scene: &Scene<'_>,
        half_edge: HalfEdgeId,
        contours: &[Vec<HalfEdgeId>],
    ) -> Option<Split> {
        /// Of an arc's middle no other point is much farther from the chord.
        const FARTHEST: f64 = 1.5;
        let rounded = self.rounded(scene, half_edge);
        let [a, b] = self.chord(half_edge);
        let off_chord = |point: DVec3| rounded.off(point - a, b - a);
        let reach = 2.0 * FARTHEST * off_chord(self.middle(scene, half_edge)?);
        let corners = contours.iter().flatten();
        let corners = corners.map(|&corner| self.point(self.at(corner).from));
        let beside = corners.filter(|&corner| off_chord(corner) < reach);
        let beside = beside.filter_map(|corner| {
            let at = self.next_to(scene, half_edge, corner)?;
            let off = off_chord(at);
            (rounded.length(corner - at) < off).then_some((off, at))
        });
        let (_, at) = beside.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(self.split_of(half_edge, at))
    }

    /// How far an edge's curve is from the middle of its chord.
    fn sagitta(&self, scene: &Scene<'_>, half_edge: HalfEdgeId, rounded: Rounded) -> f64 {
        let [a, b] = self.chord(half_edge);
        let middle = self.middle(scene, half_edge);
        middle.map_or(0.0, |m| rounded.length(m - a.midpoint(b)))
    }

    /// What parts two edges that run across each other: the middle of the one that
    /// is farther from its curve. But where one curve goes by an end of the other
    /// edge more closely than that, a vertex beside this end: next to where curves
    /// touch, chords of about the same curvature cross however short they are,
    /// unless their vertices are side by side.
    fn split_between(&self, scene: &Scene<'_>, [first, second]: [HalfEdgeId; 2]) -> Option<Split> {
        let rounded = self.rounded(scene, first);
        let [one, other] = [first, second].map(|h| self.sagitta(scene, h, rounded));
        let beside = [(first, second), (second, first)].into_iter();
        let beside = beside.flat_map(|(half_edge, other)| {
            self.chord(other).into_iter().filter_map(move |end| {
                let at = self.next_to(scene, half_edge, end)?;
                Some((rounded.length(at - end), half_edge, at))
            })
        });
        let closest = beside.min_by(|a, b| a.0.total_cmp(&b.0));
        match closest.filter(|closest| closest.0 <= one.max(other)) {
            Some((_, half_edge, at)) => Some(self.split_of(half_edge, at)),
            None => self.halve(scene, if one >= other { first } else { second }),
        }
    }
}

/// Lengths as measured in the frame of a quadric, where it is round.
#[derive(Clone, Copy, Debug)]
struct Rounded(DMat3);

impl Rounded {
    fn length(self, direction: DVec3) -> f64 {
        (self.0 * direction).length()
    }

    /// How far a direction leads off another one.
    fn off(self, direction: DVec3, along: DVec3) -> f64 {
        (self.0 * direction).reject_from(self.0 * along).length()
    }

    /// The normal of the planes across a direction.
    fn across(self, direction: DVec3) -> DVec3 {
        self.0.transpose() * (self.0 * direction)
    }
}

/// The pairs of intervals that overlap and are wanted, by their numbers, in order.
fn pairs_that_overlap(
    intervals: impl Iterator<Item = [f64; 2]>,
    is_wanted: impl Fn(usize, usize) -> bool,
) -> Vec<[usize; 2]> {
    let mut by_start: Vec<([f64; 2], usize)> = intervals.zip(0..).collect();
    by_start.sort_unstable_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    let mut pairs = Vec::new();
    for (index, &([_, end], k)) in by_start.iter().enumerate() {
        let after = by_start[index + 1..].iter();
        let beside = after.take_while(|([start, _], _)| *start <= end);
        let beside = beside.map(|&(_, other)| [k.min(other), k.max(other)]);
        pairs.extend(beside.filter(|&[one, other]| is_wanted(one, other)));
    }
    pairs.sort_unstable();
    pairs
}

/// Whether two edges have more in common than their ends.
fn cross(
    ends: [VertexId; 2],
    [a, b]: [DVec2; 2],
    others: [VertexId; 2],
    [c, d]: [DVec2; 2],
) -> bool {
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
