//! What is handed on of a boundary: half-edges along exact curves.

use glam::DVec3;

use super::boundary::{Boundary, NONE};
use super::curve::Curve;
use super::frame::Frame;
use super::pairs::curves;
use super::piece::{CurveId, Piece, Side};
use super::scene::Scene;
use crate::program::Surface;

/// A piece of an edge with a face on its left as seen from outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfEdge {
    /// The vertex it starts from.
    pub from: u32,
    /// The half-edge of the face on the other side.
    pub twin: u32,
    /// The one that follows around the face.
    pub next: u32,
    /// The patch of a surface that it bounds, which may have several parts.
    pub face: u32,
    pub curve: CurveId,
    /// Where on the curve it starts and ends; the second may be the lesser.
    pub places: [f64; 2],
}

/// The contours of a solid's faces, each cut into patches along seams.
pub(crate) struct Arrangement {
    /// Of the vertices: a place where the solid touches itself once for each fan of
    /// faces around it.
    pub points: Vec<DVec3>,
    pub faces: Vec<Side>,
    pub half_edges: Vec<HalfEdge>,
    /// For each curved surface its frame.
    pub frames: Vec<Option<Frame>>,
    /// Surfaces nearer to each other touch.
    near: f64,
    /// Distances that rounding may make.
    pub rounding: f64,
}

impl Arrangement {
    pub(super) fn new(scene: &Scene<'_>, boundary: &Boundary, pieces: &[Piece]) -> Self {
        let mut number = vec![NONE; boundary.half_edges.len()];
        let kept: Vec<u32> = (0..boundary.half_edges.len() as u32)
            .filter(|&half| !boundary.is_removed(half))
            .collect();
        for (new, &old) in (0u32..).zip(&kept) {
            number[old as usize] = new;
        }
        let (fan_of, point_of) = boundary.fans();
        let half_edge = |&old: &u32| {
            let half = boundary.at(old);
            let piece = &pieces[boundary.piece_of[old as usize / 2] as usize];
            let [from, to] = piece.places;
            HalfEdge {
                from: fan_of[old as usize],
                twin: number[half.twin as usize],
                next: number[half.next as usize],
                face: half.face,
                curve: piece.curve,
                places: if old % 2 == 0 { [from, to] } else { [to, from] },
            }
        };
        let mut all = Self {
            points: point_of
                .iter()
                .map(|&p| boundary.points[p as usize])
                .collect(),
            faces: boundary.faces.clone(),
            half_edges: kept.iter().map(half_edge).collect(),
            frames: scene.frames.to_vec(),
            near: scene.near,
            rounding: scene.rounding,
        };
        all.stretch_lines(scene.surfaces);
        all
    }

    /// Half-edges along lines may have been joined: these reach from vertex to vertex.
    fn stretch_lines(&mut self, surfaces: &[Surface]) {
        let is_plane = |id: u32| surfaces.get(id as usize).is_some_and(Surface::is_plane);
        for half in 0..self.half_edges.len() {
            let HalfEdge {
                from, twin, curve, ..
            } = self.half_edges[half];
            if !curve.surfaces.into_iter().all(is_plane) {
                continue;
            }
            let ends = [from, self.half_edges[twin as usize].from];
            if let Some(line @ Curve::Line { .. }) = self.curve(surfaces, curve) {
                let places = ends.map(|end| line.place(self.points[end as usize]));
                if let [Some(start), Some(end)] = places {
                    self.half_edges[half].places = [start, end];
                }
            }
        }
    }

    /// A curve that a half-edge lies on; none if it is not known any more, which would be
    /// a mistake.
    pub fn curve(&self, surfaces: &[Surface], id: CurveId) -> Option<Curve> {
        let [first, second] = id.surfaces.map(|id| id as usize);
        let other = if id.is_seam() {
            self.frames[first].as_ref()?.seams.get(id.seam as usize)?
        } else {
            &surfaces[second]
        };
        let mut branches = curves(&surfaces[first], other, self.near).ok()?;
        let branch = id.branch as usize;
        (branch < branches.len()).then(|| branches.swap_remove(branch).curve)
    }
}
