//! New vertices on edges, and the way of those to their surfaces that would fold a
//! triangle on it.

use glam::DVec3;

use super::Grower;
use crate::tessellate::half_edges::{HalfEdges, Kind, next};
use crate::tessellate::piece::Piece;
use crate::tessellate::region::Way;
use crate::tessellate::shape::{faces_out_everywhere, outward_area};
use crate::tessellate::side::{Side, cut_of, splits_well, together};

/// Whether a triangle of a point and two vertices faces the way the surface along an
/// edge does.
fn faces_at(mesh: &HalfEdges<'_>, half: u32, at: DVec3, [b, c]: [u32; 2]) -> bool {
    let corners = [at, mesh.at(b), mesh.at(c)];
    faces_out_everywhere(mesh.surface(half), mesh.region(half), corners)
}

impl Grower<'_, '_> {
    /// Splits an edge at a new vertex, which on a face must split it well; `on`
    /// is the piece that the edge beyond it stands for.
    pub(super) fn insert(&mut self, half: u32, vertex: u32, on: Option<Piece>) {
        let target = self.mesh.at(vertex);
        let is_face = self.mesh.kinds[vertex as usize] == Kind::Face;
        let is_free = is_face || splits_well(self.mesh, half, target);
        if !is_free {
            let [p, q] = [self.mesh.origin(half), self.mesh.target(half)].map(|v| self.mesh.at(v));
            let share = (target - p).dot(q - p) / p.distance_squared(q);
            self.mesh.positions[vertex as usize] = p.lerp(q, share.clamp(0.05, 0.95));
        }
        let rest = self.mesh.split(half, vertex);
        if let Some(piece) = on {
            self.add_piece(rest, piece);
        }
        if !is_free && !self.push(vertex, target) {
            self.stuck.push((vertex, target));
        }
        self.touch(vertex);
    }

    /// All edges around a vertex are to be looked at again.
    pub(super) fn touch(&mut self, vertex: u32) {
        for spoke in self.mesh.around(vertex) {
            self.waiting.push(next(spoke));
            self.changed.extend([spoke, self.mesh.twin(spoke)]);
        }
    }

    /// The first edge that a vertex would cross on its way, and where: the share of the
    /// way at which the triangle between the two has no area left.
    fn blocking(&self, vertex: u32, target: DVec3) -> Option<(f64, u32)> {
        let mesh = &*self.mesh;
        let from = mesh.at(vertex);
        let crossing = |rim: u32| {
            let ends = [mesh.at(mesh.origin(rim)), mesh.at(mesh.target(rim))];
            let [before, after] = [from, target].map(|at| {
                let corners = [at, ends[0], ends[1]];
                outward_area(mesh.surface(rim), mesh.region(rim), corners)
            });
            (before / (before - after)).clamp(0.0, 1.0)
        };
        let rims = mesh.around(vertex).map(next);
        rims.filter(|&rim| !faces_at(mesh, rim, target, [mesh.origin(rim), mesh.target(rim)]))
            .map(|rim| (crossing(rim), rim))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Moves a vertex, flipping the edges that are in its way, each where the way
    /// crosses it; as far as it may go.
    fn push(&mut self, vertex: u32, target: DVec3) -> bool {
        const MOST_FLIPS: usize = 24;
        for _ in 0..MOST_FLIPS {
            let blocked = self.blocking(vertex, target);
            let mesh = &mut *self.mesh;
            let from = mesh.at(vertex);
            let Some((share, rim)) = blocked else {
                mesh.positions[vertex as usize] = target;
                return true;
            };
            if mesh.is_feature(rim) || mesh.is_contact(rim) {
                return false;
            }
            let (b, c) = (mesh.origin(rim), mesh.target(rim));
            let beyond = mesh.apex(mesh.twin(rim));
            let at = from.lerp(target, share);
            if !faces_at(mesh, rim, at, [b, beyond])
                || !faces_at(mesh, rim, at, [beyond, c])
                || mesh.are_joined(vertex, beyond)
            {
                return false;
            }
            mesh.positions[vertex as usize] = at;
            mesh.flip(rim);
        }
        false
    }

    /// Tries again to bring vertices to where they ought to be.
    pub(in super::super) fn free_stuck(&mut self) {
        let stuck = std::mem::take(&mut self.stuck);
        for (vertex, target) in stuck {
            if self.push(vertex, target) {
                self.touch(vertex);
            } else {
                self.stuck.push((vertex, target));
            }
        }
        self.flip();
    }

    /// Cuts chords of curves that keep vertices from where they ought to be, beside
    /// these: next to where curves touch, one may be beyond the other one's chord.
    pub(super) fn cut_beside_stuck(&mut self) {
        const MOST_ROUNDS: usize = 8;
        for _ in 0..MOST_ROUNDS {
            let before = self.stuck.len();
            let beside = self.stuck.iter();
            let beside = beside.filter_map(|&(vertex, target)| self.side_beside(vertex, target));
            let sides = together(self.mesh, beside.collect());
            if sides.is_empty() {
                break;
            }
            self.cut_all(&sides);
            self.flip();
            self.free_stuck();
            if self.stuck.len() > before {
                break;
            }
        }
    }

    /// The chord that keeps a vertex from where it ought to be, to be cut beside it.
    fn side_beside(&self, vertex: u32, target: DVec3) -> Option<Side> {
        let mesh = &*self.mesh;
        let (_, rim) = self.blocking(vertex, target)?;
        let sides = [rim, mesh.twin(rim)];
        let is_fixed = mesh.is_feature(rim) || mesh.is_contact(rim);
        let is_done = sides.iter().any(|&side| mesh.region(side).way == Way::Done);
        let is_straight = mesh.curve_surfaces(rim).iter().all(|s| s.is_plane());
        let may_be_cut = is_fixed && !is_done && !is_straight;
        let side = may_be_cut.then(|| cut_of(mesh, rim, target, self.precision))??;
        // Another one that is stuck ought to be there.
        let mut targets = self.stuck.iter().map(|(_, target)| target);
        let is_taken = targets.any(|target| side.target.distance(*target) <= self.precision);
        (!is_taken).then_some(side)
    }
}
