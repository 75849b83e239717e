//! Where a mesh that changes in few places runs through itself.

use std::sync::Arc;

use super::Mesh;
use super::box_tree::{Bounds, BoxTree};
use super::intersect::{pairs_in, run_through};
use super::sheets::has_area;

/// The pairs of triangles of a mesh that run through each other, as
/// [`Mesh::self_intersections`] tells, kept while the mesh changes: what did not change is not
/// tested again.
#[derive(Clone)]
pub(crate) struct Intersections {
    /// As it was last seen, without attributes.
    mesh: Mesh,
    /// As the mesh was at first, or when much of it had changed.
    tree: Arc<BoxTree>,
    /// The triangles that have changed since.
    changed: Vec<u32>,
    is_changed: Vec<bool>,
    pairs: Vec<[u32; 2]>,
}

impl Intersections {
    /// Takes as long as [`Mesh::self_intersections`].
    pub(crate) fn of(mesh: Mesh) -> Self {
        let (tree, pairs) = pairs_in(&mesh, &|_| ());
        Self {
            is_changed: vec![false; mesh.triangles.len()],
            tree: Arc::new(tree),
            changed: Vec::new(),
            pairs,
            mesh,
        }
    }

    /// The pairs, the lower triangle first, in ascending order.
    pub(crate) fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// Sees the mesh as it is now: with more vertices and triangles, and some of the others
    /// in other places. Returns the triangles that changed.
    ///
    /// Some nanoseconds a triangle, and log n for each that changed.
    pub(crate) fn update(&mut self, mesh: Mesh) -> Vec<u32> {
        let before = std::mem::replace(&mut self.mesh, mesh);
        let mesh = &self.mesh;
        let is_same = |&triangle: &u32| {
            let index = triangle as usize;
            before.triangles.get(index).is_some_and(|&corners| {
                let is_there =
                    |v: u32| before.positions.get(v as usize) == mesh.positions.get(v as usize);
                corners == mesh.triangles[index] && corners.into_iter().all(is_there)
            })
        };
        let all = 0..mesh.triangles.len() as u32;
        let new: Vec<u32> = all.filter(|triangle| !is_same(triangle)).collect();
        self.is_changed.resize(mesh.triangles.len(), false);
        for &triangle in &new {
            let was_known = std::mem::replace(&mut self.is_changed[triangle as usize], true);
            if !was_known {
                self.changed.push(triangle);
            }
        }
        /// So large a share of the triangles is a new tree worth. Tunes speed only.
        const MUCH: usize = 16;
        if MUCH * self.changed.len() > mesh.triangles.len() {
            *self = Self::of(std::mem::take(&mut self.mesh));
            return new;
        }
        let mut is_new = vec![false; mesh.triangles.len()];
        for &triangle in &new {
            is_new[triangle as usize] = true;
        }
        self.pairs
            .retain(|pair| !pair.iter().any(|&triangle| is_new[triangle as usize]));
        let bounds = |triangle: u32| Bounds::around(&mesh.corners(triangle as usize));
        let has_area = |triangle: u32| has_area(mesh, &mesh.triangles[triangle as usize]);
        let changed = self.changed.iter().copied();
        let changed: Vec<(u32, Bounds)> = changed
            .filter(|&triangle| has_area(triangle))
            .map(|triangle| (triangle, bounds(triangle)))
            .collect();
        for &triangle in &new {
            if !has_area(triangle) {
                continue;
            }
            let around = bounds(triangle);
            let mut try_pair = |other: u32| {
                // Of two that are new each meets the other.
                let is_met = is_new[other as usize] && other <= triangle;
                let pair = [triangle.min(other), triangle.max(other)];
                if !is_met && run_through(mesh, pair) {
                    self.pairs.push(pair);
                }
            };
            self.tree.overlapping(&around, &mut |other| {
                if !self.is_changed[other as usize] {
                    try_pair(other);
                }
            });
            for (other, bounds) in &changed {
                if bounds.overlaps(&around) {
                    try_pair(*other);
                }
            }
        }
        self.pairs.sort_unstable();
        new
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::*;
    use crate::sweeps::one_in;

    /// Triangles strewn about the unit cube, of which some share vertices.
    fn strewn() -> impl Strategy<Value = Mesh> {
        let point = proptest::array::uniform3(0.0..1.0f64);
        let points = proptest::collection::vec(point, 60..90);
        let triangles = proptest::collection::vec(proptest::array::uniform3(0u32..60), 20..80);
        (points, triangles).prop_map(|(points, triangles)| {
            let positions = points.into_iter().map(|p| 0.3 * DVec3::from(p));
            Mesh::new(positions.collect(), triangles)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256 / one_in(4) as u32))]

        /// What is kept is what is told anew, whatever changes.
        #[test]
        fn intersections_are_kept_while_the_mesh_changes(
            mut mesh in strewn(),
            // Most of them change nothing near most triangles.
            changes in proptest::collection::vec(
                (0u32..60, proptest::array::uniform3(0.0..0.3f64), 0usize..20),
                1..12,
            ),
            copies in 1usize..12,
        ) {
            // (Copies far away, so that few of all triangles change.)
            let (count, triangles) = (mesh.positions.len() as u32, mesh.triangles.clone());
            for copy in 1..=copies {
                let apart = copy as f64 * DVec3::X;
                let moved: Vec<DVec3> =
                    mesh.positions[..count as usize].iter().map(|&p| p + apart).collect();
                mesh.positions.extend(moved);
                let renamed = |corners: &[u32; 3]| corners.map(|v| v + copy as u32 * count);
                mesh.triangles.extend(triangles.iter().map(renamed));
            }
            let mut kept = Intersections::of(mesh.clone());
            prop_assert_eq!(kept.pairs(), mesh.self_intersections());
            for (vertex, place, triangle) in changes {
                let place = DVec3::from(place);
                mesh.positions.push(place);
                let new = mesh.positions.len() as u32 - 1;
                let [a, b, _] = mesh.triangles[triangle];
                mesh.triangles[triangle][2] = new;
                mesh.triangles.push([b, a, new]);
                mesh.positions[vertex as usize] = DVec3::new(place.z, place.x, place.y);
                kept.update(mesh.clone());
                prop_assert_eq!(kept.pairs(), mesh.self_intersections());
            }
        }
    }
}
