//! The polygons of a brick, grouped by provenance.

use super::Placer;
use crate::program::Cell;
use crate::surface_nets::brick;
use crate::surface_nets::part::{Part, PolygonCode, PolygonGroup};
use crate::surface_nets::scene::Scene;

impl Placer {
    /// Hands the collected polygons of a surface to the part, grouped by the
    /// side they face to and by the primitive that the surface belongs to
    /// there; the first of several if they differ in nothing that can be seen.
    #[inline(always)]
    pub(super) fn hand_over_polygons(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        s: usize,
        part: &mut Part,
    ) {
        let Some(first) = self.polygons.first() else {
            return;
        };
        let reversed = first.is_reversed();
        let mut own = cell
            .formula
            .literals()
            .iter()
            .filter(|l| l.surface as usize == s);
        let origin = own.next().map_or(0, |literal| literal.origin);
        let several = own.any(|literal| !scene.look_alike(literal.origin, origin));
        let differ = |codes: &[PolygonCode]| {
            let differing = codes.iter().map(|code| code.is_reversed() != reversed);
            differing.fold(false, |any, one| any | one)
        };
        if several || differ(&self.polygons) {
            self.hand_over_sorted(cell, s, (!several).then_some(origin), part);
            return;
        }
        part.polygons.extend_from_slice(&self.polygons);
        part.groups.push(PolygonGroup {
            surface: cell.surfaces[s],
            origin,
            reversed,
            count: self.polygons.len() as u32,
            entry: 0,
        });
    }

    /// The same polygon by polygon; `origin` is all polygons' primitive,
    /// unless it is to be found for each.
    #[inline(never)]
    fn hand_over_sorted(&mut self, cell: &Cell, s: usize, origin: Option<u32>, part: &mut Part) {
        let polygons = std::mem::take(&mut self.polygons);
        let mut sorted: Vec<(u32, bool, PolygonCode)> = polygons
            .iter()
            .map(|&code| {
                let origin = origin.unwrap_or_else(|| self.origin_at(cell, s as u32, code));
                (origin, code.is_reversed(), code)
            })
            .collect();
        sorted.sort_by_key(|&(origin, reversed, _)| (origin, reversed));
        for run in sorted.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            part.polygons.extend(run.iter().map(|&(.., code)| code));
            part.groups.push(PolygonGroup {
                surface: cell.surfaces[s],
                origin: run[0].0,
                reversed: run[0].1,
                count: run.len() as u32,
                entry: 0,
            });
        }
        self.polygons = polygons;
    }

    /// Of the primitives that share a surface, the first whose literal alone
    /// makes the solid change at a crossing; the first of all if none does.
    pub(super) fn origin_at(&mut self, cell: &Cell, surface: u32, code: PolygonCode) -> u32 {
        let literals = cell.formula.literals();
        let own: Vec<u32> = (0..literals.len() as u32)
            .filter(|&i| literals[i as usize].surface == surface)
            .take(63)
            .collect();
        let signs = &self.classified.signs;
        let sample = code.sample();
        let result = cell.formula.evaluate_words(&mut self.gates, |i, s| {
            let inside = brick::is_set(&signs[s as usize], sample);
            let sign = if inside { u64::MAX } else { 0 };
            // Assignment k + 1 toggles the k-th literal alone.
            match own.iter().position(|&o| o == i) {
                Some(k) => sign ^ 1 << (k + 1),
                None => sign,
            }
        });
        let decides = |k: &usize| (result >> (k + 1) ^ result) & 1 == 1;
        let chosen = (0..own.len()).find(decides).unwrap_or(0);
        literals[own[chosen] as usize].origin
    }
}
