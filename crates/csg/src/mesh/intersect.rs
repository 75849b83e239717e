//! Where a mesh runs through itself, decided exactly.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec2;

use super::apart::{Face, clearly_apart};
use super::box_tree::{BoxTree, TOLD};
use super::predicates::{Triangle, flattened, side, turn};
use super::sheets::in_sheets;
use crate::mesh::Mesh;

impl Mesh {
    /// The pairs of triangles that run through each other or overlap in
    /// area, as triangle indices, the lower first, in ascending order.
    ///
    /// Contact is not intersection as long as the triangles share only single
    /// points (a vertex, or a vertex on a face) or lie edge on edge (in whole
    /// or in part, with the same vertices or with vertices of their own):
    /// solids that touch there are still simple. An edge that lies in the
    /// other triangle's face, and faces that overlap, are intersections.
    ///
    /// The answer is exact for the coordinates as they are (Shewchuk's
    /// adaptive predicates in the test of Guigue and Devillers, *Fast and
    /// Robust Triangle-Triangle Overlap Test Using Orientation Predicates*,
    /// 2003), short of underflow. Triangles that name no three different
    /// vertices, are not finite or have no area are passed over.
    ///
    /// n log n for n triangles of similar size, in parallel; the same for any
    /// number of threads. Half as long or less where neighbours share their
    /// vertices as where each triangle has its own: most of them are then told
    /// apart all at once.
    #[must_use]
    pub fn self_intersections(&self) -> Vec<[u32; 2]> {
        self.self_intersections_told(&|_| ())
    }

    /// The same, and tells what share of it is done, from whatever thread did it.
    pub(crate) fn self_intersections_told(&self, tell: &(impl Fn(f64) + Sync)) -> Vec<[u32; 2]> {
        // (As one task: else each step would wait for the pool's threads to wake up.)
        rayon::scope(|_| pairs_in(self, tell).1)
    }
}

/// The triangles of a mesh, and the pairs that run through each other.
pub(super) fn pairs_in(mesh: &Mesh, tell: &(impl Fn(f64) + Sync)) -> (BoxTree, Vec<[u32; 2]>) {
    /// Shares of the whole, about as long as they take.
    const IN_SHEETS: f64 = 0.4;
    const IN_TREE: f64 = 0.55;
    let test = |first, second| run_through(mesh, [first, second]);
    let sheets = in_sheets(mesh);
    tell(IN_SHEETS);
    let mut tree = BoxTree::new(sheets);
    tell(IN_TREE);
    let searched = AtomicUsize::new(0);
    let mut pairs = tree.pairs(&test, &|| {
        let searched = 1 + searched.fetch_add(1, Ordering::Relaxed);
        tell(IN_TREE + (1.0 - IN_TREE) * searched as f64 / TOLD as f64);
    });
    if !pairs.is_empty() {
        // Where something runs through what others stand on these may, too.
        tree.stand_on_nothing();
        pairs = tree.pairs(&test, &|| ());
    }
    (tree, pairs)
}

/// Whether two triangles of a mesh intersect in the sense of [`Mesh::self_intersections`]:
/// both must have an area.
pub(super) fn run_through(mesh: &Mesh, pair: [u32; 2]) -> bool {
    let [one, other] = pair.map(|index| Face {
        corners: mesh.corners(index as usize),
        vertices: mesh.triangles[index as usize],
    });
    !clearly_apart(&one, &other) && intersect(one.corners, other.corners)
}

/// Whether two triangles with area intersect in the sense of
/// [`Mesh::self_intersections`].
fn intersect(mut first: Triangle, mut second: Triangle) -> bool {
    let sides = |of: &Triangle, plane: &Triangle| {
        of.map(|p| {
            if plane.contains(&p) {
                0
            } else {
                side(*plane, p)
            }
        })
    };
    let first_sides = sides(&first, &second);
    if first_sides == [0; 3] {
        return overlap_in_plane(&first, &second);
    }
    let Some(first_apex) = apex(first_sides) else {
        return false;
    };
    let second_sides = sides(&second, &first);
    let Some(second_apex) = apex(second_sides) else {
        return false;
    };
    let edge_in_plane = |sides: [i8; 3]| sides.iter().filter(|&&s| s == 0).count() == 2;
    if edge_in_plane(first_sides) && edge_in_plane(second_sides) {
        // Both meet the planes' common line in an edge: edge on edge at most.
        return false;
    }
    // Bring each apex to the front and above the other's plane.
    first.rotate_left(first_apex);
    second.rotate_left(second_apex);
    if first_sides[first_apex] < 0 {
        second.swap(1, 2);
    }
    if second_sides[second_apex] < 0 {
        first.swap(1, 2);
    }
    // The planes' common line meets each triangle in a segment from its edge
    // pq to its edge pr: do the two segments overlap in more than a point?
    let [p1, q1, r1] = first;
    let [p2, q2, r2] = second;
    side([p1, q1, p2], q2) < 0 && side([p1, r1, r2], p2) < 0
}

/// The corner that is strictly on one side of a plane while the other two are
/// not on that side; none if the triangle meets the plane in a point at most.
fn apex(sides: [i8; 3]) -> Option<usize> {
    (0..3).find(|&i| sides[i] != 0 && (1..3).all(|k| sides[i] * sides[(i + k) % 3] <= 0))
}

/// Whether two triangles in one plane overlap in more than edges and points:
/// no edge of either may have the other wholly on its outer side.
fn overlap_in_plane(first: &Triangle, second: &Triangle) -> bool {
    let separates = |[a, b, c]: [DVec2; 3], other: [DVec2; 3]| {
        let inner = turn([a, b, c]);
        [[a, b], [b, c], [c, a]]
            .into_iter()
            .any(|[from, to]| other.iter().all(|&p| turn([from, to, p]) * inner <= 0))
    };
    (0..3)
        .map(|axis| [first, second].map(|triangle| flattened(*triangle, axis)))
        .find(|[first, _]| turn(*first) != 0)
        .is_some_and(|[first, second]| !separates(first, second) && !separates(second, first))
}
