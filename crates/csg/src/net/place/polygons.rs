//! The polygons of a brick, grouped by provenance.

use super::{Placer, Scene};
use crate::net::brick;
use crate::net::part::{Part, PolygonCode, PolygonGroup};
use crate::program::Cell;

impl Placer {
    /// Moves the collected polygons to the part, grouped by surface and by
    /// the primitive that the surface belongs to there; the first of several
    /// if they differ in nothing that can be seen.
    pub(super) fn collect_polygons(&mut self, scene: &Scene<'_>, cell: &Cell, part: &mut Part) {
        for s in 0..cell.surfaces.len() {
            let polygons = std::mem::take(&mut self.polygons[s]);
            if polygons.is_empty() {
                self.polygons[s] = polygons;
                continue;
            }
            let mut own = cell
                .formula
                .literals()
                .iter()
                .filter(|l| l.surface as usize == s);
            let first = own.next().map_or(0, |literal| literal.origin);
            let several = own.any(|literal| !scene.look_alike(literal.origin, first));
            let facing = polygons[0].is_reversed();
            if several || polygons.iter().any(|code| code.is_reversed() != facing) {
                let mut sorted: Vec<(u32, bool, PolygonCode)> = polygons
                    .iter()
                    .map(|&code| {
                        let origin = if several {
                            self.origin_at(cell, s as u32, code)
                        } else {
                            first
                        };
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
                    });
                }
            } else {
                part.polygons.extend_from_slice(&polygons);
                part.groups.push(PolygonGroup {
                    surface: cell.surfaces[s],
                    origin: first,
                    reversed: facing,
                    count: polygons.len() as u32,
                });
            }
            self.polygons[s] = polygons;
        }
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
        let result = brick::evaluate_assignments(&cell.formula, &mut self.gates, |i, s| {
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
