//! Edge flips: triangles as round as can be in the metric of how their surface
//! bends.
//!
//! In a plane and on a sphere that is the Delaunay triangulation (Lawson,
//! *Software for C1 Surface Interpolation*, 1977). On a cylinder, where only
//! the way around counts, the vertices of two borders are joined to those
//! nearest in angle, so that no triangle spans more of it than one chord does.

use glam::DVec3;

use super::half_edges::{HalfEdges, next, previous};
use super::region::{Bend, Region, Way, metric};
use super::shape::{LEAST_COSINE, Sight};
use crate::numeric::tolerance::NEAR;
use crate::program::Surface;

/// Edges to be looked at for flipping, each once, the last ones first.
#[derive(Default)]
pub(super) struct Waiting {
    stack: Vec<u32>,
    is_on_stack: Vec<bool>,
}

impl Waiting {
    /// Adds an edge, unless this half of it waits already.
    #[inline]
    pub fn push(&mut self, half: u32) {
        let index = half as usize;
        if index >= self.is_on_stack.len() {
            self.is_on_stack.resize(2 * index + 256, false);
        }
        if !self.is_on_stack[index] {
            self.is_on_stack[index] = true;
            self.stack.push(half);
        }
    }

    /// Flips all edges that wait, and the sides of the triangles that are made, until
    /// none would be better flipped. `note` is told both halves of every new edge.
    pub fn flip_all(&mut self, mesh: &mut HalfEdges<'_>, mut note: impl FnMut([u32; 2])) {
        // Flipping makes the smallest angles grow but for rounding: this many are
        // never needed.
        let mut left = 200 + 40 * self.stack.len();
        while let Some(half) = self.stack.pop() {
            let twin = mesh.twin(half);
            let waited = std::mem::take(&mut self.is_on_stack[half as usize]);
            // The other half need not be looked at, too.
            if let Some(other) = self.is_on_stack.get_mut(twin as usize) {
                *other = false;
            }
            if waited && left > 0 && flip_if_better(mesh, half) {
                left -= 1;
                for rim in [half, next(half), twin, next(twin)] {
                    self.push(rim);
                }
                note([previous(half), previous(twin)]);
            }
        }
    }
}

#[inline]
fn flip_if_better(mesh: &mut HalfEdges<'_>, half: u32) -> bool {
    if mesh.is_feature(half) || mesh.is_contact(half) {
        return false;
    }
    let region = mesh.region(half);
    let quad = mesh.quad(half);
    let surface = &mesh.surfaces[region.surface];
    let at = |k: usize| mesh.at(quad[k]);
    let at = [at(0), at(1), at(2), at(3)];
    let sight = || Sight::new(surface, region, at);
    let is_better = if region.way == Way::Done {
        false
    } else if is_better_flipped(surface, region, at) {
        leaves_it_unfolded(&sight(), region.bend)
    } else {
        region.bend == Bend::Single && unwraps(&sight())
    };
    let flips = is_better && !mesh.are_joined(quad[1], quad[3]);
    if flips {
        mesh.flip(half);
    }
    flips
}

/// Whether the angles across from the edge from a to b, between the triangles a, b, c
/// and b, a, d, add up to more than π.
#[inline(always)]
fn is_better_flipped(surface: &Surface, region: &Region, [a, d, b, c]: [DVec3; 4]) -> bool {
    if region.bend == Bend::Double {
        // The circles of the metric are the sections by planes, as on a sphere:
        // the edges of the convex hull are the right ones.
        let normal = (b - a).cross(c - a);
        let convex = region.outward * surface.curvature_along(b - a);
        let above = normal.dot(d - a) * convex.signum();
        let scale = normal.length_squared() * (d - a).length_squared();
        return above > 0.0 && above * above > NEAR * NEAR * scale;
    }
    // The metric of all edges at once.
    if region.bend == Bend::Single {
        exceeds_half_turn([a, d, b, c], |edge| metric(surface, Bend::Single, edge))
    } else {
        exceeds_half_turn([a, d, b, c], DVec3::length_squared)
    }
}

/// Whether the angles at c and d add up to more than π in a metric, which gives the
/// squared length of an edge.
#[inline(always)]
fn exceeds_half_turn([a, d, b, c]: [DVec3; 4], square: impl Fn(DVec3) -> f64) -> bool {
    let ab = square(b - a);
    // Twice the product of the sides and the cosine, and the sides' squares.
    let angle = |ca: f64, cb: f64| (ca + cb - ab, 4.0 * ca * cb);
    let (at_c, sides_c) = angle(square(a - c), square(b - c));
    let (at_d, sides_d) = angle(square(a - d), square(b - d));
    // The cosines' squares with their signs, over a common denominator: their sum is
    // compared without a branch, as nobody could tell beforehand which way it goes.
    let (c2, d2) = (at_c * at_c.abs() * sides_d, at_d * at_d.abs() * sides_c);
    c2 + d2 < -NEAR * c2.max(d2)
}

/// The two triangles beside the edge from a to b, by the places of a, d, b and c, and those that
/// a flip would make.
const THERE: [[usize; 3]; 2] = [[0, 2, 3], [2, 0, 1]];
const MADE: [[usize; 3]; 2] = [[1, 2, 3], [3, 0, 1]];

/// Whether the triangles that a flip would make face the way their surface does, next to all
/// their points if those that there are do: a flip makes edges longer than a cut does. On
/// surfaces that bend the same way everywhere, where flips lead to the convex hull, triangles
/// that are folded may also be flipped into some that are less so: a narrow strip whose sides
/// are joined askew is unfolded flip by flip.
#[inline]
fn leaves_it_unfolded(quad: &Sight<'_, 4>, bend: Bend) -> bool {
    if MADE.iter().all(|&made| quad.faces_out_in_the_middle(made)) {
        return bend == Bend::Flat
            || faces_out_everywhere(quad, MADE)
            || !faces_out_everywhere(quad, THERE);
    }
    if bend != Bend::Double {
        return false;
    }
    let [before, after] = [THERE, MADE].map(|both| {
        let [one, other] = both.map(|triangle| quad.cosine(triangle));
        one.min(other)
    });
    before < LEAST_COSINE
        && after > before
        && !leads_around(
            THERE.map(|triangle| quad.range(triangle)),
            MADE.map(|triangle| quad.range(triangle)),
        )
}

#[inline]
fn faces_out_everywhere(quad: &Sight<'_, 4>, [one, other]: [[usize; 3]; 2]) -> bool {
    quad.faces_out_everywhere(one) && quad.faces_out_everywhere(other)
}

/// Whether a flip would lead to the other side of the axis or the centre of a surface that
/// bends around it, by how much the triangles before and after it face outward: the least and
/// the most. Then the axis runs through the tetrahedron between them.
fn leads_around(before: [[f64; 2]; 2], after: [[f64; 2]; 2]) -> bool {
    let is_pierced = |[least, most]: [f64; 2]| least < 0.0 && most > 0.0;
    let faces_in = |[_, most]: [f64; 2]| most < 0.0;
    let faces_out = |[least, _]: [f64; 2]| least > 0.0;
    before.into_iter().any(is_pierced)
        || (before.into_iter().all(faces_in) && after.into_iter().all(faces_out))
}

/// Whether an edge around more than half of a tube, which a chord of less is not told from by
/// its length, becomes one that is not.
#[inline]
fn unwraps(quad: &Sight<'_, 4>) -> bool {
    !faces_out_everywhere(quad, THERE) && faces_out_everywhere(quad, MADE)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::program::SurfaceId;
    use crate::tessellate::Surfaced;
    use crate::tessellate::deviation::Shrinkage;

    /// A convex polygon as a fan of triangles, closed by another fan with an apex
    /// below, whose triangles are faces of their own.
    fn fan<'a>(angles: &[f64], plane: &'a [Surface]) -> HalfEdges<'a> {
        let count = angles.len() as u32;
        let corner = |angle: &f64| DVec3::new(2.0 * angle.cos(), angle.sin(), 0.0);
        let corners = angles.iter().map(corner).chain([DVec3::NEG_Z]);
        let above = (1..count - 1).map(|k| [0, k, k + 1]);
        let below = (0..count).map(|k| [(k + 1) % count, k, count]);
        let triangles: Vec<[u32; 3]> = above.chain(below).collect();
        let groups = 0..triangles.len() as u32;
        let groups = groups.map(|triangle| (triangle + 3).saturating_sub(count));
        let surfaced = Surfaced {
            positions: corners.collect(),
            surface_of_group: vec![SurfaceId(0); triangles.len()].into(),
            groups: groups.collect(),
            triangles,
            ..Surfaced::default()
        };
        HalfEdges::new(&surfaced, plane).expect("closed")
    }

    proptest! {
        /// No corner is within the circle through those of a triangle beside its own,
        /// also where edges come into the way of others that were good before.
        #[test]
        fn flat_faces_end_delaunay(
            mut angles in proptest::collection::vec(0.0..std::f64::consts::TAU, 8..40)
        ) {
            angles.sort_by(f64::total_cmp);
            angles.dedup_by(|a, b| *a - *b < 0.01);
            prop_assume!(angles.len() > 5);
            let plane = [Surface::plane(DVec3::ZERO, DVec3::Z)];
            let mut mesh = fan(&angles, &plane);
            let mut waiting = Waiting::default();
            for half in mesh.edges() {
                waiting.push(half);
            }
            waiting.flip_all(&mut mesh, |_| {});
            for half in mesh.edges().filter(|&half| !mesh.is_feature(half)) {
                let [a, d, b, c] = mesh.quad(half).map(|vertex| {
                    let at = mesh.at(vertex);
                    robust::Coord { x: at.x, y: at.y }
                });
                prop_assert!(robust::incircle(a, b, c, d) < 1e-9);
            }
        }
    }

    /// The corners of a rod's stub at angles in degrees, on its one end or the other.
    fn on_rod([a, d, b, c]: [(f64, f64); 4]) -> [DVec3; 4] {
        [a, d, b, c].map(|(angle, z)| {
            let angle = angle.to_radians();
            DVec3::new(angle.cos(), angle.sin(), z)
        })
    }

    /// An edge from -13 to 180 degrees is as long as one the other way around.
    #[test]
    fn an_edge_around_more_than_half_of_a_rod_is_flipped() {
        let solid = crate::Solid::cylinder(1.0, 0.0..9.0);
        let program = crate::Program::lower(&solid).expect("a program");
        let mut all = program.surfaces().iter();
        let surface = all.find(|s| !s.is_plane()).expect("the cylinder");
        let region = Region {
            surface: SurfaceId(0),
            group: 0,
            bend: Bend::of(surface),
            outward: 1.0,
            shrinkage: Shrinkage::of(surface),
            round: None,
            way: Way::OneByOne,
        };
        let corners = on_rod([(-13.0, 9.0), (90.0, 0.0), (180.0, 0.0), (60.0, 9.0)]);
        assert!(!is_better_flipped(surface, &region, corners));
        assert!(unwraps(&Sight::new(surface, &region, corners)));
        // Nothing is to be gained where all face out.
        let corners = on_rod([(180.0, 0.0), (240.0, 0.0), (260.0, 9.0), (200.0, 9.0)]);
        assert!(!unwraps(&Sight::new(surface, &region, corners)));
    }
}
