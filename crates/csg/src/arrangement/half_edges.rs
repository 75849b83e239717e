//! What is handed on of a boundary: half-edges along exact curves.

use std::collections::hash_map::Entry;
use std::f64::consts::TAU;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::boundary::{self, Boundary};
use super::curve::Curve;
use super::frame::Frame;
use super::ids::{FaceId, HalfEdgeId, VertexId};
use super::piece::{CurveId, Side};
use super::scene::Scene;
use crate::program::SurfaceId;

/// A piece of an edge with a face on its left as seen from outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfEdge {
    /// The vertex it starts from.
    pub from: VertexId,
    /// The half-edge of the face on the other side.
    pub twin: HalfEdgeId,
    /// The one that follows around the face.
    pub next: HalfEdgeId,
    /// The patch of a surface that it bounds, which may have several parts.
    pub face: FaceId,
    pub curve: CurveId,
    /// Whether that is a straight line; along others places are angles, or like these.
    pub is_line: bool,
    /// Where on the curve it starts and ends; the second may be the lesser.
    pub places: [f64; 2],
}

/// The contours of a solid's faces, each cut into patches along seams.
#[derive(Default)]
pub(crate) struct Arrangement {
    /// Of the vertices: a place where the solid touches itself once for each fan of
    /// faces around it.
    pub points: Vec<DVec3>,
    pub faces: Vec<Side>,
    pub half_edges: Vec<HalfEdge>,
    /// The curves of half-edges; one that is missing would be a mistake.
    pub curves: FxHashMap<CurveId, Curve>,
    /// For each curved surface its frame.
    pub frames: Vec<Option<Frame>>,
    /// Distances that rounding may make.
    pub rounding: f64,
}

impl Arrangement {
    pub fn at(&self, half_edge: HalfEdgeId) -> &HalfEdge {
        &self.half_edges[half_edge.index()]
    }

    /// Of the face on its left.
    pub fn side(&self, half_edge: HalfEdgeId) -> &Side {
        &self.faces[self.at(half_edge).face.index()]
    }

    pub fn halves(&self) -> impl Iterator<Item = HalfEdgeId> + Clone + use<> {
        HalfEdgeId::all(self.half_edges.len())
    }

    /// The points that a half-edge joins.
    pub fn chord(&self, half_edge: &HalfEdge) -> [DVec3; 2] {
        let ends = [half_edge.from, self.at(half_edge.twin).from];
        ends.map(|vertex| self.points[vertex.index()])
    }

    /// Of a curved surface.
    pub fn frame(&self, surface: SurfaceId) -> Option<&Frame> {
        self.frames[surface.index()].as_ref()
    }

    pub(super) fn new(scene: &Scene<'_>, boundary: &Boundary) -> Self {
        // Without those that were taken out.
        let mut kept = 0;
        let number = |half: &boundary::HalfEdge| {
            let number = HalfEdgeId(kept);
            kept += u32::from(!half.is_removed);
            number
        };
        let numbers: Vec<HalfEdgeId> = boundary.half_edges.iter().map(number).collect();
        let (fan_of, point_of) = boundary.fans();
        let half_edge = |old: HalfEdgeId| {
            let half = boundary.at(old);
            HalfEdge {
                from: VertexId(fan_of[old.index()]),
                twin: numbers[half.twin.index()],
                next: numbers[half.next.index()],
                face: half.face,
                curve: half.curve,
                is_line: false,
                places: half.places,
            }
        };
        let mut all = Self {
            points: point_of
                .iter()
                .map(|&vertex| boundary.point(vertex))
                .collect(),
            faces: boundary.faces.clone(),
            half_edges: boundary.halves().map(half_edge).collect(),
            curves: FxHashMap::default(),
            frames: scene.frames.to_vec(),
            rounding: scene.rounding,
        };
        for half_edge in &all.half_edges {
            if let Entry::Vacant(entry) = all.curves.entry(half_edge.curve)
                && let Some(curve) = scene.curve(half_edge.curve)
            {
                entry.insert(curve);
            }
        }
        all.fit_places();
        all
    }

    /// Makes half-edges reach from vertex to vertex: along lines they may have been joined,
    /// and where surfaces touch a place is known to fewer digits than the point.
    pub fn fit_places(&mut self) {
        for half in 0..self.half_edges.len() {
            let HalfEdge {
                from, twin, curve, ..
            } = self.half_edges[half];
            let Some(curve) = self.curves.get(&curve) else {
                continue;
            };
            let ends = [from, self.at(twin).from];
            self.half_edges[half].is_line = matches!(curve, Curve::Line { .. });
            let places = &mut self.half_edges[half].places;
            for (place, end) in places.iter_mut().zip(ends) {
                let point = self.points[end.index()];
                *place = match curve {
                    Curve::Line { .. } => curve.place(point).unwrap_or(*place),
                    _ => nearest(curve, *place, point, self.rounding),
                };
            }
        }
    }
}

/// Where a curve is nearest to a point, from a place in the same turn of it: by steps of
/// Newton's method as long as these bring it nearer, if it is off by more than rounding.
fn nearest(curve: &Curve, before: f64, point: DVec3, rounding: f64) -> f64 {
    const MOST_STEPS: u32 = 8;
    /// In which the curve's direction is found.
    const STEP: f64 = 1e-6;
    let mut place = before;
    let mut off = curve.at(place).distance(point);
    // Far away on conics that are nearly straight chords have been joined.
    if off > rounding
        && let Some(known) = curve.place(point)
    {
        let turn = if curve.is_closed() {
            TAU
        } else {
            f64::INFINITY
        };
        let turns = ((before - known) / turn).round();
        let known = if turns == 0.0 {
            known
        } else {
            known + turns * turn
        };
        let known_off = curve.at(known).distance(point);
        if known_off < off {
            (place, off) = (known, known_off);
        }
    }
    for _ in 0..MOST_STEPS {
        if off <= rounding {
            break;
        }
        let direction = (curve.at(place + STEP) - curve.at(place - STEP)) / (2.0 * STEP);
        let next = place + (point - curve.at(place)).dot(direction) / direction.length_squared();
        let next_off = curve.at(next).distance(point);
        // Not so where it is singular.
        if next_off >= off || next_off.is_nan() {
            break;
        }
        (place, off) = (next, next_off);
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane beside a cone's apex cuts it in a hyperbola of two nearly straight halves, along
    /// which places grow as the logarithm of the distance.
    #[test]
    fn places_far_along_a_curve_are_found() {
        let curve = Curve::Hyperbola {
            center: DVec3::new(-0.25, 0.75, 0.5),
            a: DVec3::new(0.0, 0.0, -5e-8),
            b: DVec3::new(4e-8, 0.0, 0.0),
        };
        for (before, place) in [(16.3, 17.6), (17.6, 16.3), (-17.7, -15.0), (-15.0, -17.7)] {
            let found = nearest(&curve, before, curve.at(place), 1e-15);
            assert!((found - place).abs() < 1e-7, "{found}, not {place}");
            assert!(curve.at(found).distance(curve.at(place)) < 1e-15);
        }
        let circle = Curve::Ellipse {
            center: DVec3::X,
            a: DVec3::X,
            b: DVec3::Y,
        };
        for (before, place) in [(0.1, -0.2), (6.2, 6.4), (7.0, 6.0)] {
            let found = nearest(&circle, before, circle.at(place), 1e-15);
            assert!((found - place).abs() < 1e-14, "{found}, not {place}");
        }
    }
}
