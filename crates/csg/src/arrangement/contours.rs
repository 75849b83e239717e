//! Which half-edge of a contour follows which: around each vertex and in each face,
//! by the directions in which the curves leave.

use crate::elementary;
use std::mem::replace;

use glam::DVec3;
use smallvec::SmallVec;

use super::boundary::Boundary;
use super::ids::{HalfEdgeId, VertexId};
use super::scene::Scene;
use crate::numeric::tolerance::{SAME_ANGLE, SAME_BEND, TOUCHING};
use crate::program::Surface;
use crate::undecided::{Stop, Why};

/// How a curve leaves a vertex in the plane in which its face is seen.
#[derive(Clone, Copy, Debug)]
struct Departure {
    half_edge: HalfEdgeId,
    /// The vertex, and the edge's other end.
    ends: [DVec3; 2],
    /// Of its tangent.
    angle: f64,
    /// Its curvature, positive to the left; no number where it is not known.
    bend: f64,
}

impl Boundary {
    /// Finds every half-edge's next: around each vertex and in each face, the
    /// one that starts where the face's sector left of it ends.
    pub fn link_contours(&mut self, scene: &Scene<'_>) -> Result<(), Stop> {
        // Half-edges by the vertex they start from.
        let mut first_at = vec![0u32; self.points.len() + 1];
        for half_edge in &self.half_edges {
            first_at[half_edge.from.index() + 1] += 1;
        }
        for vertex in 0..self.points.len() {
            first_at[vertex + 1] += first_at[vertex];
        }
        let mut filled = first_at.clone();
        let mut leaving = vec![HalfEdgeId(0); self.half_edges.len()];
        for half_edge in self.halves() {
            let slot = &mut filled[self.at(half_edge).from.index()];
            leaving[*slot as usize] = half_edge;
            *slot += 1;
        }
        let mut is_next = vec![false; self.half_edges.len()];
        let mut out: SmallVec<[HalfEdgeId; 4]> = SmallVec::new();
        for vertex in VertexId::all(self.points.len()) {
            scene.go_on()?;
            let open = Stop::undecided(Why::Contour, self.point(vertex));
            let [start, end] = [0, 1].map(|k| first_at[vertex.index() + k] as usize);
            for k in start..end {
                // Each arrives as another one's twin.
                let arriving = self.at(leaving[k]).twin;
                let face = self.at(arriving).face;
                let same_face = |&half: &HalfEdgeId| self.at(half).face == face;
                out.clear();
                out.extend(leaving[start..end].iter().copied().filter(same_face));
                let next = match out.as_slice() {
                    &[only] => only,
                    many => self.end_of_sector(scene, arriving, many).ok_or(open)?,
                };
                if replace(&mut is_next[next.index()], true) {
                    return Err(open);
                }
                self.join(arriving, next);
            }
        }
        Ok(())
    }

    /// Of the half-edges that leave the vertex where another arrives, in the
    /// same face, the first clockwise from it: between the two lies the face.
    fn end_of_sector(
        &self,
        scene: &Scene<'_>,
        arriving: HalfEdgeId,
        leaving: &[HalfEdgeId],
    ) -> Option<HalfEdgeId> {
        use std::f64::consts::TAU;
        let back = self.departure(scene, arriving, true);
        // Next to where curves touch they are one curve but for rounding, too, and
        // their order is that of their bends.
        let same = |bends: f64| (2.0 * scene.touch * bends.abs()).sqrt().max(SAME_ANGLE);
        let clockwise = |&half_edge: &HalfEdgeId| {
            let leaves = self.departure(scene, half_edge, false);
            let turn = (back.angle - leaves.angle).rem_euclid(TAU);
            let is_same = turn.min(TAU - turn) < same(back.bend - leaves.bend);
            // Along one curve the face goes all around: both sides of a slit.
            let turn = match is_same {
                true if self.is_left(scene, &back, &leaves) => 0.0,
                true => TAU,
                false => turn,
            };
            (turn, leaves)
        };
        let in_order = |a: &(f64, Departure), b: &(f64, Departure)| {
            if (a.0 - b.0).abs() >= same(a.1.bend - b.1.bend) {
                a.0.total_cmp(&b.0)
            } else {
                let is_left = [[a, b], [b, a]].map(|[a, b]| self.is_left(scene, &a.1, &b.1));
                is_left[1].cmp(&is_left[0])
            }
        };
        let first = leaving.iter().map(clockwise).min_by(in_order);
        first.map(|(_, leaves)| leaves.half_edge)
    }

    /// Whether of two edges that leave a vertex in the same direction the first is to
    /// the left of the second: by their bends, and where these are the same by where
    /// their curves are.
    fn is_left(&self, scene: &Scene<'_>, one: &Departure, other: &Departure) -> bool {
        let bends = one.bend - other.bend;
        if bends.abs() > (SAME_BEND * one.bend.abs()).max(scene.same_bend()) {
            return bends > 0.0;
        }
        // Beside the far end of the shorter one.
        let [length, other_length] = [one, other].map(|d| d.ends[0].distance(d.ends[1]));
        let is_shorter = length <= other_length;
        let [shorter, longer] = if is_shorter {
            [one, other]
        } else {
            [other, one]
        };
        let at = shorter.ends[1];
        let Some(near) = self.on_curve(scene, longer.half_edge, at) else {
            return false;
        };
        let side = self.side(one.half_edge);
        let off = scene.flatten(side, at) - scene.flatten(side, near);
        let left = elementary::direction(one.angle).perp_dot(off);
        at.distance(near) > scene.weld && (left > 0.0) == is_shorter
    }

    /// How a half-edge leaves the vertex it starts from, or, going back, the one
    /// it ends in, as its face is seen. By the curve, not by its chord: of curves
    /// that touch there the chords may be the other way round.
    fn departure(&self, scene: &Scene<'_>, half_edge: HalfEdgeId, is_back: bool) -> Departure {
        let side = self.side(half_edge);
        let ends = self.chord(half_edge);
        let ends @ [here, there] = if is_back { [ends[1], ends[0]] } else { ends };
        let flat = |direction: DVec3| scene.flatten_direction(side, direction);
        let chord = there - here;
        let along_curve = |[first, second]: [DVec3; 2]| {
            let (first, second) = (flat(first) * first.dot(chord).signum(), flat(second));
            Departure {
                half_edge,
                ends,
                angle: elementary::atan2(first.y, first.x),
                bend: first.perp_dot(second) / first.length().powi(3),
            }
        };
        if let Some(derivatives) = self.derivatives(scene, half_edge, here) {
            return along_curve(derivatives);
        }
        let along_chord = || Departure {
            half_edge,
            ends,
            angle: {
                let chord = flat(chord);
                elementary::atan2(chord.y, chord.x)
            },
            bend: 0.0,
        };
        let Some([a, b]) = self.surfaces_of(scene, half_edge) else {
            return along_chord();
        };
        let [p, q] = [a, b].map(|s| s.gradient(here));
        let cross = p.cross(q);
        if a.is_plane() && b.is_plane() {
            return along_chord();
        }
        if cross.length() <= TOUCHING * p.length() * q.length() {
            let place = self.at(half_edge).places[usize::from(is_back)];
            let curve = scene.curve(self.at(half_edge).curve);
            let Some(curve) = curve else {
                return along_chord();
            };
            // How it bends where surfaces touch, differences do not tell.
            return Departure {
                bend: f64::NAN,
                ..along_curve([curve.direction(place), DVec3::ZERO])
            };
        }
        let tangent = cross.normalize();
        // The second derivative keeps to both surfaces.
        let [u, v] = [a, b].map(|s| -s.curvature_along(tangent));
        let second = (u * q.cross(tangent) + v * tangent.cross(p)) / cross.dot(tangent);
        along_curve([tangent, second])
    }

    /// The derivatives at a vertex of the conic that a half-edge is a piece of; none on a
    /// line of two planes, along which points tell better.
    fn derivatives(
        &self,
        scene: &Scene<'_>,
        half_edge: HalfEdgeId,
        at: DVec3,
    ) -> Option<[DVec3; 2]> {
        let id = self.at(half_edge).curve;
        let mut surfaces = id.surfaces().map(|id| scene.surface(id));
        if surfaces.all(Surface::is_plane) {
            return None;
        }
        let common = scene.common(id).ok()?;
        let curve = &common.get(usize::from(id.branch))?.curve;
        curve.derivatives(curve.place(at)?)
    }
}
