//! Polyhedra that touch themselves, taken apart there.

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::placed::Region;
use crate::elementary;
use crate::numeric::Groups;

impl Region {
    /// The same faces with a vertex for each fan of them: where edges or vertices of the polyhedron
    /// touch, each wedge of it between two faces has its own, at the same place.
    pub(super) fn parted(&self) -> Self {
        let origins = self.triangles.as_flattened();
        let next = |half: usize| if half % 3 == 2 { half - 2 } else { half + 1 };
        let mut along: FxHashMap<[u32; 2], SmallVec<[usize; 2]>> = FxHashMap::default();
        for half in 0..origins.len() {
            let [from, to] = [origins[half], origins[next(half)]];
            along
                .entry([from.min(to), from.max(to)])
                .or_default()
                .push(half);
        }
        // Corners are one vertex that faces beside each other have in common.
        let mut groups = Groups::new(origins.len());
        for (edge, mut halves) in along {
            if halves.len() > 2 {
                self.turn_about(edge, &mut halves);
            }
            let goes_on = |half: usize| origins[half] == edge[0];
            // Of the wedges outside every other is within the polyhedron: between a face that
            // runs back along the edge and the next one, which does not.
            let first = halves.iter().position(|&half| !goes_on(half)).unwrap_or(0);
            halves.rotate_left(first);
            for pair in halves.chunks_exact(2) {
                let [one, other] = [pair[0], pair[1]];
                if goes_on(one) != goes_on(other) {
                    groups.join([one as u32, next(other) as u32]);
                    groups.join([next(one) as u32, other as u32]);
                }
            }
        }
        let mut vertices = Vec::with_capacity(self.vertices.len());
        let mut number_of = vec![None; origins.len()];
        let mut number = |corner: usize| {
            *number_of[groups.first(corner as u32) as usize].get_or_insert_with(|| {
                vertices.push(self.vertices[origins[corner] as usize]);
                vertices.len() as u32 - 1
            })
        };
        let triangles = (0..self.triangles.len())
            .map(|triangle| [0, 1, 2].map(|k| number(3 * triangle + k)))
            .collect();
        Self {
            vertices,
            triangles,
            surfaces: self.surfaces.clone(),
            origin: self.origin,
        }
    }

    /// Puts the faces at half-edges along an edge in the order in which they follow each other
    /// around it, counter-clockwise seen against it.
    fn turn_about(&self, edge: [u32; 2], halves: &mut [usize]) {
        let [from, to] = edge.map(|vertex| self.vertices[vertex as usize]);
        let (x, y) = (to - from).normalize_or_zero().any_orthonormal_pair();
        let (x, y) = if x.cross(y).dot(to - from) > 0.0 {
            (x, y)
        } else {
            (y, x)
        };
        let angle = |half: usize| {
            let opposite = self.triangles[half / 3][(half + 2) % 3];
            let across: DVec3 = self.vertices[opposite as usize] - from;
            elementary::atan2(across.dot(y), across.dot(x))
        };
        halves.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
    }
}
