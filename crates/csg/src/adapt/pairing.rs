//! Which crossings of a face are joined: those that the solid's boundary
//! joins. Two crossings on one surface lie on one arc of it, two on different
//! surfaces are joined by way of a point where both surfaces meet in the face;
//! of all pairings without crossing arcs the one that fits best is taken.

use glam::DVec3;

use super::complex::{FaceCrossing, Pairing};
use super::probe::{Change, Probe, Scene};
use crate::numeric::tolerance::NEAR;
use crate::program::{Cell, Surface};
use crate::surface::solve;

/// Pairs the crossings of one cell's faces, or of all.
pub(super) struct Geometric<'a, F> {
    pub scene: &'a Scene<'a>,
    pub probe: &'a mut Probe,
    pub changes: &'a [Change],
    /// The axis of a transition's edge.
    pub axes: &'a [u8],
    /// The program in the cell of the given number.
    pub cell: F,
}

/// More crossings on one face are paired neighbour with neighbour.
const MOST_CROSSINGS: usize = 24;

/// The cost of joining what nothing seems to join.
const UNFOUNDED: f64 = 100.0;

impl<'a, F: Fn(u32) -> &'a Cell> Pairing for Geometric<'a, F> {
    fn pair(&mut self, crossings: &[FaceCrossing], pairs: &mut Vec<(usize, usize)>) {
        let n = crossings.len();
        let directed = |a: usize, b: usize| if crossings[a].enters { (b, a) } else { (a, b) };
        if n > MOST_CROSSINGS {
            pairs.extend((0..n / 2).map(|k| directed(2 * k, 2 * k + 1)));
            return;
        }
        let cell = (self.cell)(crossings[0].any_cell());
        let normal = crossings[0].normal(usize::from(self.axes[crossings[0].transition as usize]));
        // best[i][j]: the least cost of pairing i..j, and i's partner in it.
        let mut best = vec![(0.0f64, 0usize); (n + 1) * (n + 1)];
        for length in (2..=n).step_by(2) {
            for i in 0..=n - length {
                let j = i + length;
                let mut least = (f64::INFINITY, i + 1);
                for partner in (i + 1..j).step_by(2) {
                    let cost = self.cost(cell, normal, crossings[i], crossings[partner])
                        + best[(i + 1) * (n + 1) + partner].0
                        + best[(partner + 1) * (n + 1) + j].0;
                    if cost < least.0 {
                        least = (cost, partner);
                    }
                }
                best[i * (n + 1) + j] = least;
            }
        }
        let mut pending = vec![(0, n)];
        while let Some((i, j)) = pending.pop() {
            if i < j {
                let partner = best[i * (n + 1) + j].1;
                pairs.push(directed(i, partner));
                pending.push((i + 1, partner));
                pending.push((partner + 1, j));
            }
        }
    }
}

impl<'a, F: Fn(u32) -> &'a Cell> Geometric<'a, F> {
    /// How ill an arc between two crossings fits: its distance from where the
    /// boundary can be, in lengths of its chord.
    fn cost(&mut self, cell: &Cell, normal: usize, a: FaceCrossing, b: FaceCrossing) -> f64 {
        let (a, b) = (
            self.changes[a.transition as usize],
            self.changes[b.transition as usize],
        );
        let middle = 0.5 * (a.point + b.point);
        let length = (b.point - a.point).length();
        if length == 0.0 {
            return 0.0;
        }
        let face = Surface::plane(middle, DVec3::AXES[normal]);
        let surface = |id: u32| &self.scene.surfaces[id as usize];
        let two = [a.surface, b.surface];
        let constraints = if a.surface == b.surface {
            &two[..1]
        } else {
            &two[..]
        };
        let solution = match constraints {
            [only] => solve::common_point(&[surface(*only), &face], middle, length),
            _ => solve::common_point(&[surface(two[0]), surface(two[1]), &face], middle, length),
        };
        let distance = (solution.point - middle).length() / length;
        let founded = solution.residual <= self.scene.tolerance.max(NEAR * length)
            && self
                .probe
                .changes_across(self.scene, cell, constraints, solution.point);
        // Of two equally near the one on a single surface.
        distance + if founded { 0.0 } else { UNFOUNDED } + 0.01 * (constraints.len() - 1) as f64
    }
}
