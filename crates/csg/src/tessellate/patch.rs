//! One large triangle filled with small ones: a regular pattern inside, strips
//! along the sides.

use glam::DVec3;

use super::deviation::Corner;
use super::fine::INNER;
use super::region::{Region, metric};
use crate::program::Surface;

/// A large triangle being filled; scratch memory.
#[derive(Default)]
pub(super) struct Patch {
    /// What the vertices are called elsewhere.
    pub names: Vec<u32>,
    /// First the rim, counter-clockwise, then the inner vertices.
    pub positions: Vec<DVec3>,
    /// Where on the rim the sides begin; the last is the rim's length.
    pub starts: [u32; 4],
    pub triangles: Vec<[u32; 3]>,
    pub corners: Vec<Corner>,
    outer: Vec<u32>,
    inner: Vec<u32>,
}

impl Patch {
    pub fn clear(&mut self) {
        self.names.clear();
        self.positions.clear();
        self.triangles.clear();
        self.corners.clear();
    }

    pub fn add(&mut self, name: u32, position: DVec3) {
        self.names.push(name);
        self.positions.push(position);
    }

    fn at(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    /// The number of chords on a side.
    fn chords(&self, side: usize) -> u32 {
        self.starts[side + 1] - self.starts[side]
    }

    /// The i-th vertex of a side from its start.
    fn on_side(&self, side: usize, i: u32) -> u32 {
        let vertex = self.starts[side] + i;
        if vertex == self.starts[3] { 0 } else { vertex }
    }

    pub fn fill(&mut self, surface: &Surface, region: &Region, rows: u32) {
        let length = |a: DVec3, b: DVec3| metric(surface, region.bend, b - a);
        if rows < 3 {
            self.fill_polygon(length);
            return;
        }
        self.place_inner(surface, region, rows);
        // Inside: a regular pattern of so many rows.
        let k = rows - 3;
        let base = self.starts[3];
        // The i-th vertex of the j-th row, counted from the first side.
        let inner = |i: u32, j: u32| base + j * (k + 1) - (j * j - j) / 2 + i;
        for j in 0..k {
            for i in 0..k - j {
                let (a, b, c) = (inner(i, j), inner(i + 1, j), inner(i, j + 1));
                self.triangles.push([a, b, c]);
                if i + j + 1 < k {
                    self.triangles.push([b, inner(i + 1, j + 1), c]);
                }
            }
        }
        // At a corner: across it, or from it to the pattern.
        let insides = [inner(0, 0), inner(k, 0), inner(0, k)];
        let mut cut = [false; 3];
        for ((corner, cut), inside) in cut.iter_mut().enumerate().zip(insides) {
            let previous = (corner + 2) % 3;
            let before = self.chords(previous);
            let vertex = self.on_side(corner, 0);
            let on = self.on_side(corner, 1);
            let back = self.on_side(previous, before - 1);
            *cut = before > 1
                && self.chords(corner) > 1
                && length(self.at(on), self.at(back)) < length(self.at(vertex), self.at(inside));
            if *cut {
                self.triangles.push([back, vertex, on]);
                self.triangles.push([back, on, inside]);
            }
        }
        for side in 0..3 {
            let (from, to) = (
                u32::from(cut[side]),
                self.chords(side) - u32::from(cut[(side + 1) % 3]),
            );
            self.outer.clear();
            for i in from..=to {
                self.outer.push(self.on_side(side, i));
            }
            self.inner.clear();
            self.inner.extend((0..=k).map(|i| match side {
                0 => inner(i, 0),
                1 => inner(k - i, i),
                _ => inner(0, k - i),
            }));
            zip(
                &self.outer,
                &self.inner,
                &self.positions,
                &mut self.triangles,
                length,
            );
        }
    }

    /// Puts the inner vertices where the rim says, and then on the surface.
    fn place_inner(&mut self, surface: &Surface, region: &Region, rows: u32) {
        let corners @ [a, b, c] = [0, 1, 2].map(|side| self.at(self.starts[side]));
        let n = f64::from(rows);
        let off_chord = |patch: &Self, side: usize, share: f64| {
            patch.on_rim(side, share) - corners[side].lerp(corners[(side + 1) % 3], share)
        };
        let mut name = INNER;
        for j in 1..rows - 1 {
            for i in 1..rows - j {
                let (v, w) = (f64::from(i) / n, f64::from(j) / n);
                let u = 1.0 - v - w;
                let flat = u * a + v * b + w * c;
                // By how much the sides are off their chords (Coons).
                let off = off_chord(self, 0, v / (u + v)) * (1.0 - w) * (1.0 - w)
                    + off_chord(self, 1, w / (v + w)) * (1.0 - u) * (1.0 - u)
                    + off_chord(self, 2, u / (w + u)) * (1.0 - v) * (1.0 - v);
                let start = flat + off;
                self.add(name, region.project(surface, start).unwrap_or(start));
                name += 1;
            }
        }
    }

    /// The point at a share of a side.
    fn on_rim(&self, side: usize, share: f64) -> DVec3 {
        let chords = self.chords(side);
        let along = share * f64::from(chords);
        let i = (along as u32).min(chords - 1);
        let [p, q] = [i, i + 1].map(|i| self.at(self.on_side(side, i)));
        p.lerp(q, along - f64::from(i))
    }

    /// Fills the rim without vertices inside.
    fn fill_polygon(&mut self, length: impl Fn(DVec3, DVec3) -> f64 + Copy) {
        let single = (0..3).find(|&side| self.chords(side) == 1);
        if let Some(single) = single {
            // From the corner across up both sides.
            let (down, up) = ((single + 1) % 3, (single + 2) % 3);
            self.fill_corner((up, self.chords(up)), (down, 0), length);
            return;
        }
        // From the middle of the longest side to the corner across.
        let longest = (0..3).max_by_key(|&side| self.chords(side)).unwrap_or(0);
        let (after, before) = ((longest + 1) % 3, (longest + 2) % 3);
        let middle = self.chords(longest) / 2;
        // Up from the ends of the longest side: between it and the sides.
        self.fill_corner((longest, middle), (before, 0), length);
        self.fill_corner((after, self.chords(after)), (longest, middle), length);
    }

    /// Fills the strip between two sides from the corner where they meet: up to
    /// a chord of the one that starts there, and down to one of the other.
    fn fill_corner(
        &mut self,
        (right, last): (usize, u32),
        (left, first): (usize, u32),
        length: impl Fn(DVec3, DVec3) -> f64,
    ) {
        self.outer.clear();
        for i in 1..=last {
            self.outer.push(self.on_side(right, i));
        }
        self.inner.clear();
        for i in (first..self.chords(left)).rev() {
            self.inner.push(self.on_side(left, i));
        }
        let corner = self.on_side(right, 0);
        self.triangles.push([corner, self.outer[0], self.inner[0]]);
        zip(
            &self.outer,
            &self.inner,
            &self.positions,
            &mut self.triangles,
            length,
        );
    }
}

/// Fills the strip between two rows of vertices, the second to the left of the
/// first: of the two next edges across always the shorter one.
fn zip(
    right: &[u32],
    left: &[u32],
    positions: &[DVec3],
    triangles: &mut Vec<[u32; 3]>,
    length: impl Fn(DVec3, DVec3) -> f64,
) {
    let at = |vertex: u32| positions[vertex as usize];
    let (mut i, mut j) = (0, 0);
    while i + 1 < right.len() || j + 1 < left.len() {
        let goes_right = if i + 1 == right.len() {
            false
        } else if j + 1 == left.len() {
            true
        } else {
            length(at(right[i + 1]), at(left[j])) <= length(at(right[i]), at(left[j + 1]))
        };
        if goes_right {
            triangles.push([right[i], right[i + 1], left[j]]);
            i += 1;
        } else {
            triangles.push([right[i], left[j + 1], left[j]]);
            j += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::SurfaceId;
    use crate::tessellate::deviation::Shrinkage;
    use crate::tessellate::region::{Bend, Way};
    use crate::{Program, Solid};
    use proptest::prelude::*;
    use std::collections::HashSet;

    proptest! {
        /// Whatever the numbers, a triangle of a sphere is covered once; by small
        /// ones that face outward, unless there are many more rows than chords:
        /// such folds are found when triangles are bounded.
        #[test]
        fn any_numbers_fit_together(
            chords in prop::array::uniform3(1..12u32),
            rows in 1..12u32,
        ) {
            let program = Program::lower(&Solid::sphere(1.0)).expect("valid");
            let surface = &program.surfaces()[0];
            let region = Region {
                surface: SurfaceId(0),
                group: 0,
                bend: Bend::Double,
                outward: 1.0,
                shrinkage: Shrinkage::NONE,
                round: None,
                way: Way::AtOnce,
            };
            let corners = [[1.0, 0.1, 0.0], [1.0, 0.5, 0.1], [1.0, 0.3, 0.4]];
            let corners = corners.map(|p| DVec3::from(p).normalize());
            let mut patch = Patch::default();
            for side in 0..3 {
                patch.starts[side] = patch.names.len() as u32;
                let (p, q) = (corners[side], corners[(side + 1) % 3]);
                for i in 0..chords[side] {
                    let place = p.lerp(q, f64::from(i) / f64::from(chords[side]));
                    patch.add(patch.names.len() as u32, place.normalize());
                }
            }
            let rim = patch.names.len() as u32;
            patch.starts[3] = rim;
            patch.fill(surface, &region, rows);
            let count = patch.positions.len() as u32;
            prop_assert_eq!(patch.triangles.len() as u32, 2 * count - rim - 2);
            let sides = patch.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
            let directed: HashSet<_> = sides.collect();
            prop_assert_eq!(directed.len(), 3 * patch.triangles.len());
            for &(a, b) in &directed {
                let is_on_rim = b == (a + 1) % rim && a < rim;
                prop_assert!(directed.contains(&(b, a)) != is_on_rim);
            }
            if chords.iter().all(|&count| rows <= 2 * count) {
                for corners in &patch.triangles {
                    let [p, q, r] = corners.map(|corner| patch.at(corner));
                    prop_assert!((q - p).cross(r - p).dot(p + q + r) > 0.0);
                }
            }
        }
    }
}
