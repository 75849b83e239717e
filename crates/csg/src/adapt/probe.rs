//! Questions to a pruned program: where does the solid change along an edge,
//! and does it really change across these surfaces at this point?

use glam::{DVec3, UVec3};

use crate::numeric::tolerance::{DEPENDENT_IN_CELL, MAPPED};
use crate::program::{Cell, Changes, Origin, Surface, roots_between};

/// What the whole mesh has in common.
pub(super) struct Scene<'a> {
    /// The program's surfaces, in the local frame.
    pub surfaces: &'a [Surface],
    /// The primitives that literals come from.
    pub origins: &'a [Origin],
    /// The point of the lattice with coordinates 0, and the lattice's unit.
    pub first: DVec3,
    pub unit: f64,
    /// Distance to a surface below which a point lies on it.
    pub tolerance: f64,
}

/// A change of the solid along an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    /// The surface that causes it, by its number in the program, and the
    /// primitive it belongs to there.
    pub surface: u32,
    pub origin: u32,
    pub point: DVec3,
    pub enters: bool,
}

/// A root of one surface along an edge.
#[derive(Clone, Copy, Debug)]
struct Root {
    /// 0 to 1 along the edge.
    at: f64,
    /// Position of the surface in the cell.
    surface: u32,
}

/// Scratch memory.
#[derive(Debug, Default)]
pub(super) struct Probe {
    gates: Vec<u64>,
    signs: Vec<u64>,
    roots: Vec<Root>,
    truth: Changes,
}

/// More changes on one edge than this are beyond one word of assignments.
const MOST_ROOTS: usize = 62;

impl Probe {
    /// All changes of the solid from `start` to `end`, which differ along
    /// `axis` alone, in order. A surface's number of roots agrees with its
    /// signs at both ends. False if there are more than can be told apart.
    pub fn changes_along(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        axis: usize,
        [start, end]: [DVec3; 2],
        changes: &mut Vec<Change>,
    ) -> bool {
        self.roots.clear();
        self.signs.clear();
        for (position, &id) in cell.surfaces.iter().enumerate() {
            let surface = &scene.surfaces[id as usize];
            let (f0, f1) = (surface.value(start), surface.value(end));
            self.signs.push(if f0 <= 0.0 { u64::MAX } else { 0 });
            let (roots, count) =
                roots_between(surface.quadratic[axis], end[axis] - start[axis], f0, f1);
            for &at in &roots[..count] {
                self.roots.push(Root {
                    at,
                    surface: position as u32,
                });
            }
        }
        if self.roots.is_empty() {
            return true;
        }
        self.roots
            .sort_by(|a, b| a.at.total_cmp(&b.at).then(a.surface.cmp(&b.surface)));
        let complete = self.roots.len() <= MOST_ROOTS;
        if !complete {
            // Keep what the ends tell: all roots but one pass at once.
            let odd = |s: u32| self.roots.iter().filter(|r| r.surface == s).count() % 2 == 1;
            let middle = self.roots.len() / 2;
            let last = self.roots[middle];
            let mut ends: Vec<Root> = self
                .roots
                .iter()
                .copied()
                .filter(|r| odd(r.surface))
                .collect();
            ends.sort_by_key(|r| r.surface);
            ends.dedup_by_key(|r| r.surface);
            for root in &ends {
                self.signs[root.surface as usize] ^= u64::MAX << 1;
            }
            self.roots.clear();
            self.roots.push(Root {
                surface: ends.first().map_or(last.surface, |r| r.surface),
                ..last
            });
        }
        // Bit i: after the first i roots.
        if complete {
            for (rank, root) in self.roots.iter().enumerate() {
                self.signs[root.surface as usize] ^= u64::MAX << (rank + 1);
            }
        }
        let signs = &self.signs;
        let result = cell
            .formula
            .evaluate_words(&mut self.gates, |_, surface| signs[surface as usize]);
        for rank in 0..self.roots.len() {
            let (before, after) = (result >> rank & 1, result >> (rank + 1) & 1);
            if before == after {
                continue;
            }
            let root = self.roots[rank];
            let mut point = start;
            point[axis] += root.at * (end[axis] - start[axis]);
            changes.push(Change {
                surface: cell.surfaces[root.surface as usize],
                origin: self.origin_of(scene, cell, root.surface, rank),
                point,
                enters: after == 1,
            });
        }
        complete
    }

    /// Of the primitives that share a surface, the first whose literal alone
    /// makes the solid change; the first of all if they look alike.
    fn origin_of(&mut self, scene: &Scene<'_>, cell: &Cell, surface: u32, rank: usize) -> u32 {
        let literals = cell.formula.literals();
        let own = || (0u32..).zip(literals).filter(|(_, l)| l.surface == surface);
        let Some((_, first)) = own().next() else {
            return 0;
        };
        let looks = |origin: u32| &scene.origins[origin as usize];
        if own().all(|(_, l)| {
            l.origin == first.origin || looks(l.origin).looks_like(looks(first.origin))
        }) {
            return first.origin;
        }
        let signs = &self.signs;
        // Assignment k + 1 toggles the k-th literal alone.
        let result = cell.formula.evaluate_words(&mut self.gates, |i, s| {
            let inside = if signs[s as usize] >> rank & 1 == 1 {
                u64::MAX
            } else {
                0
            };
            match own().position(|(o, _)| o == i) {
                Some(k) if k < 63 => inside ^ 1 << (k + 1),
                _ => inside,
            }
        });
        own()
            .take(63)
            .enumerate()
            .find(|(k, _)| (result >> (k + 1) ^ result) & 1 == 1)
            .map_or(first.origin, |(_, (_, literal))| literal.origin)
    }

    /// Whether the solid changes across each of the surfaces at `point`: the
    /// formula over all their sign combinations, the other surfaces as they
    /// are there (both ways where they pass through the point, too). The cell
    /// must contain the point.
    pub fn changes_across(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: &[u32],
        point: DVec3,
    ) -> bool {
        let (surfaces, tolerance) = (scene.surfaces, scene.tolerance);
        self.truth
            .across(surfaces, cell, constraints, point, tolerance)
    }
}

/// A surface over a box: its gradient in the middle, and by what share of it
/// the gradient changes at most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flatness {
    /// The unit gradient in the middle.
    pub normal: DVec3,
    /// The value in the middle over the gradient's length.
    pub value: f64,
    /// The quadratic coefficients over the gradient's length.
    pub quadratic: [f64; 6],
    /// The largest |∇f - ∇f(middle)| in the box over |∇f(middle)|.
    pub spread: f64,
}

impl Flatness {
    pub fn over(surface: &Surface, middle: DVec3, half: f64) -> Self {
        let gradient = surface.gradient(middle);
        let length = gradient.length();
        let [xx, yy, zz, xy, yz, zx] = surface.quadratic.map(f64::abs);
        let change = half * DVec3::new(2.0 * xx + xy + zx, 2.0 * yy + yz + xy, 2.0 * zz + zx + yz);
        Self {
            normal: gradient / length,
            value: surface.value(middle) / length,
            quadratic: surface.quadratic.map(|c| c / length),
            spread: change.length() / length,
        }
    }

    /// Whether the two surfaces cross, wherever they meet in the box, at an
    /// angle that is not nothing.
    pub fn crosses(&self, other: &Self) -> bool {
        let limit = self.spread + other.spread;
        let sine = self.normal.cross(other.normal).length();
        sine > limit + DEPENDENT_IN_CELL
    }
}

/// Whether some combination Σ weight f of the surfaces has no root in the box
/// of the given half side: then they have no common point there.
pub(super) fn have_no_common_point(surfaces: &[(f64, &Flatness)], half: f64) -> bool {
    let mut value = 0.0;
    let mut slope = DVec3::ZERO;
    let mut quadratic = [0.0; 6];
    let mut magnitude = 0.0;
    for &(weight, surface) in surfaces {
        value += weight * surface.value;
        slope += weight * surface.normal;
        for (sum, c) in quadratic.iter_mut().zip(surface.quadratic) {
            *sum += weight * c;
        }
        magnitude += weight.abs() * (surface.value.abs() + half);
    }
    let reach = half * (slope.x.abs() + slope.y.abs() + slope.z.abs())
        + half * half * quadratic.iter().map(|c| c.abs()).sum::<f64>();
    value.abs() > reach + MAPPED * magnitude
}

impl Scene<'_> {
    /// Where a corner of the lattice lies.
    pub fn point(&self, corner: UVec3) -> DVec3 {
        corner.as_dvec3() * self.unit + self.first
    }
}
