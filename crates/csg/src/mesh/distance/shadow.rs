//! How high a triangle is above many triangles of another mesh.
//!
//! Triangles that face it are looked for from one below it on, over all sides that lead through what is
//! below it. If each of them faces it (or each has its back to it), they cover it: around each point that
//! is covered, on a triangle, a side or a corner, all is, as the triangles around face it, too; so nothing is
//! left out of what is in one piece. Then no point is farther from the mesh than what is right below it,
//! and height is linear on each triangle, so it is largest at a corner of what both have in common.

use std::cmp::Ordering;

use glam::DVec3;
use rustc_hash::FxHashSet;
use smallvec::SmallVec;

use super::super::twins::NONE;
use super::{Plane, Target, cut, longest};

impl Target<'_> {
    /// The greatest height of a triangle above the mesh, which is a bound of its distance, and
    /// where it is so high; none if the mesh below does not lie like a sheet. `start` is below it.
    pub(super) fn height_of(&self, corners: [DVec3; 3], start: u32) -> Option<(f64, DVec3)> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let up = normal.try_normalize()?;
        // What is nearer to a side is not asked for: it is off the rest of the triangle, which is the
        // same but smaller, by as much of its length.
        let rim = self.rounding;
        let around = a.distance(b) + b.distance(c) + c.distance(a);
        let inner_radius = normal.length() / around;
        let sides = [[a, b], [b, c], [c, a]];
        let sides = sides.map(|[from, to]| (from, (to - from).cross(up).normalize_or_zero()));
        let faces = |triangle: u32| {
            let [a, b, c] = self.corners(triangle);
            (b - a).cross(c - a).dot(up)
        };
        let way = faces(start).signum();
        let mut highest = (0.0, a);
        let mut is_below = false;
        let mut seen = FxHashSet::default();
        let mut waiting = vec![start];
        seen.insert(start);
        while let Some(triangle) = waiting.pop() {
            // (Nor if that is not a number.)
            if (way * faces(triangle)).partial_cmp(&0.0) != Some(Ordering::Greater) {
                return None;
            }
            let corners = self.corners(triangle);
            let mut common: SmallVec<[DVec3; 8]> = SmallVec::from_slice(&corners);
            for &(from, out) in &sides {
                common = cut(&common, (from, out), rim)
                    .into_iter()
                    .next()
                    .unwrap_or_default();
            }
            for &corner in &common {
                let height = (corner - a).dot(up);
                if height.abs() > highest.0 {
                    highest = (height.abs(), corner - height * up);
                }
            }
            is_below |= triangle == start && {
                let middle = common.iter().sum::<DVec3>() / common.len() as f64;
                sides
                    .iter()
                    .all(|&(from, out)| (middle - from).dot(out) < -rim)
            };
            if !is_below {
                return None;
            }
            for side in 0..3 {
                if !leads_through([corners[side], corners[(side + 1) % 3]], &sides, rim) {
                    continue;
                }
                let twin = self.twins[3 * triangle as usize + side];
                if twin == NONE {
                    return None;
                }
                if seen.insert(twin / 3) {
                    waiting.push(twin / 3);
                }
            }
        }
        let (height, place) = highest;
        Some((height + rim + rim / inner_radius * longest(corners), place))
    }
}

/// Whether a line has points farther than a rim inside of all sides.
fn leads_through([from, to]: [DVec3; 2], sides: &[Plane; 3], rim: f64) -> bool {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for &(on, out) in sides {
        let [here, there] = [from, to].map(|end| (end - on).dot(out) + rim);
        if here > 0.0 && there > 0.0 {
            return false;
        }
        let at = here / (here - there);
        if here > 0.0 {
            first = first.max(at);
        } else if there > 0.0 {
            last = last.min(at);
        }
    }
    first <= last
}

#[cfg(test)]
pub(super) mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::Mesh;

    /// A sheet over the unit square of so many squares along each side.
    pub fn sheet([columns, rows]: [u32; 2], place: impl Fn(f64, f64) -> DVec3) -> Mesh {
        let mut mesh = Mesh::default();
        for k in 0..(columns + 1) * (rows + 1) {
            let share = |k: u32, count: u32| f64::from(k) / f64::from(count);
            let [x, y] = [k % (columns + 1), k / (columns + 1)];
            mesh.positions
                .push(place(share(x, columns), share(y, rows)));
        }
        for k in 0..columns * rows {
            let corner = k / columns * (columns + 1) + k % columns;
            let above = corner + columns + 1;
            mesh.triangles.push([corner, corner + 1, above + 1]);
            mesh.triangles.push([corner, above + 1, above]);
        }
        mesh
    }

    proptest! {
        /// Points of a triangle above a sheet with waves, folds, shear and holes are no farther from it than
        /// is told, and where nothing folds and no hole is, it is told.
        #[test]
        fn nothing_is_farther_than_the_height(
            corners in prop::array::uniform3(prop::array::uniform3(0.2..0.8)),
            wave in 0.0..0.2_f64,
            fold in prop_oneof![Just(0.0), -0.4..0.4_f64],
            hole in prop_oneof![Just(None), (0..200usize).prop_map(Some)],
            start in 0..200usize,
        ) {
            let mut mesh = sheet([10, 10], |x, y| {
                let (z, bend) = (wave * (9.0 * x + 5.0 * y).sin(), fold * (12.0 * x).sin());
                DVec3::new(x + bend, y, z)
            });
            if let Some(hole) = hole {
                mesh.triangles.swap_remove(hole);
            }
            let target = Target::new(&mesh, 1e-12);
            let corners = corners.map(|[x, y, z]| DVec3::new(x, y, 0.2 * z));
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let near = target.near(middle, None).triangle;
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
            if fold == 0.0 && hole.is_none() && wave < 1e-3 && normal.z.abs() > 0.99 {
                prop_assert!(target.height_of(corners, near).is_some());
            }
            for start in [near as usize, start % mesh.triangles.len()] {
                let Some((height, place)) = target.height_of(corners, start as u32) else {
                    continue;
                };
                let of_place = target.near(place, None).distance;
                prop_assert!(of_place <= height + 1e-12);
                for k in 0..400 {
                    let (s, t) = (f64::from(k % 20) / 19.0, f64::from(k / 20) / 19.0);
                    let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                    let point = corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0]);
                    let distance = target.near(point, None).distance;
                    prop_assert!(distance <= height + 1e-12, "{point}: {distance} of {height}");
                }
            }
        }
    }
}
