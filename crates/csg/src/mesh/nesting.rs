//! Whether shells within each other look in turn outwards and inwards.

use super::shells::Shells;
use super::star::usable;
use crate::mesh::Mesh;
use crate::numeric::Groups;

impl Mesh {
    /// A triangle that does not have the outside before it and the inside behind it, of a mesh
    /// that is closed, faces out as a whole and does not run through itself: part of a shell
    /// that looks the same way as the one that it lies in, or inwards beside others.
    ///
    /// That is told of one triangle of each patch, which are those that are joined over edges of
    /// two triangles; nothing crosses a patch, so that all of one have the same on either side.
    /// n log n steps for n triangles, and as many for each patch where everything else fails.
    pub(crate) fn misplaced(&self) -> Option<u32> {
        let patches = self.patches();
        if patches.len() < 2 {
            return None;
        }
        let corners = (0..self.triangles.len()).map(|k| self.corners(k));
        let whole = Shells::new([corners], 0.0);
        let mut patches = patches.into_iter();
        patches.find(|&largest| !whole.has_outside_before(largest))
    }

    /// The largest triangle of each patch.
    fn patches(&self) -> Vec<u32> {
        let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * self.triangles.len());
        for (index, triangle) in (0..).zip(&self.triangles) {
            if usable(triangle, self.positions.len()) {
                let [a, b, c] = *triangle;
                let ends = [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
                sides.extend(ends.map(|ends| (ends, index)));
            }
        }
        sides.sort_unstable();
        let mut groups = Groups::new(self.triangles.len());
        for beside in sides.chunk_by(|a, b| a.0 == b.0) {
            if let &[(_, one), (_, other)] = beside {
                groups.join([one, other]);
            }
        }
        let area = |index: u32| {
            let [a, b, c] = self.corners(index as usize);
            (b - a).cross(c - a).length_squared()
        };
        let mut largest: Vec<Option<(u32, f64)>> = vec![None; self.triangles.len()];
        for (index, triangle) in (0..).zip(&self.triangles) {
            if !usable(triangle, self.positions.len()) {
                continue;
            }
            let known = &mut largest[groups.first(index) as usize];
            let own = area(index);
            if known.is_none_or(|(_, area)| own > area) {
                *known = Some((index, own));
            }
        }
        // What has no area has no sides.
        let found = largest.into_iter().flatten();
        found
            .filter(|&(_, area)| area > 0.0)
            .map(|(index, _)| index)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, dvec3};
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::boxes::cuboid;

    /// A box, its faces inwards if it is a hollow.
    fn add(mesh: &mut Mesh, [low, high]: [DVec3; 2], is_hollow: bool) {
        let first = mesh.positions.len() as u32;
        let cuboid = cuboid(low, high);
        mesh.positions.extend(cuboid.positions);
        for corners in cuboid.triangles {
            let [a, b, c] = corners.map(|k| first + k);
            mesh.triangles
                .push(if is_hollow { [a, c, b] } else { [a, b, c] });
        }
    }

    /// Fills a box with up to two others side by side, each as deep again.
    fn fill(
        mesh: &mut Mesh,
        within: [DVec3; 2],
        depth: u32,
        turned: &mut impl Iterator<Item = u8>,
    ) -> bool {
        let mut is_right = true;
        let [low, high] = within;
        let size = high - low;
        for side in 0..2 {
            let what = turned.next().unwrap_or(3);
            if what > 2 {
                continue;
            }
            let own_low = low + size * dvec3(0.5 * f64::from(side) + 0.1, 0.1, 0.1);
            let own = [own_low, own_low + size * dvec3(0.3, 0.8, 0.8)];
            let should = depth % 2 == 1;
            let is_hollow = should != (what == 2);
            is_right &= is_hollow == should;
            add(mesh, own, is_hollow);
            if depth < 3 {
                is_right &= fill(mesh, own, depth + 1, turned);
            }
        }
        is_right
    }

    proptest! {
        #[test]
        fn shells_must_look_out_and_in_by_turns(
            turned in prop::collection::vec(0..5u8, 30),
            keeps in prop::bool::ANY,
        ) {
            let mut mesh = Mesh::new(Vec::new(), Vec::new());
            // Half of them without any that is turned.
            let mut turned = turned.into_iter().map(|what| if keeps && what == 2 { 0 } else { what });
            let is_right = fill(&mut mesh, [DVec3::ZERO, DVec3::ONE], 0, &mut turned);
            let found = mesh.misplaced();
            let shells = mesh.triangles.len() / 12;
            prop_assert_eq!(found.is_none(), is_right || shells < 2, "{:?}", mesh);
        }
    }

    /// A box with another one within it that reaches to one of its corners: a hollow or not.
    #[test]
    fn shells_that_touch_are_told_apart() {
        for (is_hollow, misplaced) in [(true, false), (false, true)] {
            let mut mesh = Mesh::new(Vec::new(), Vec::new());
            add(&mut mesh, [DVec3::ZERO, DVec3::ONE], false);
            add(
                &mut mesh,
                [DVec3::splat(0.25), DVec3::splat(0.5)],
                is_hollow,
            );
            // The hollow's corner on one of the box's.
            mesh.positions[8] = DVec3::ZERO;
            for vertex in mesh.triangles.iter_mut().flatten() {
                *vertex = if *vertex == 8 { 0 } else { *vertex };
            }
            assert_eq!(mesh.misplaced().is_some(), misplaced, "{is_hollow}");
        }
    }
}
