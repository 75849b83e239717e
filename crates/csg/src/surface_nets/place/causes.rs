//! Which surface causes each crossing.

use glam::DVec3;

use super::constraints::Constraints;
use super::{Crossings, EDGES, Placer};
use crate::program::{Cell, roots_between};
use crate::surface_nets::brick::{self, Mask, WORDS};
use crate::surface_nets::part::{Fallback, FallbackKind, Part, PolygonCode};
use crate::surface_nets::scene::Scene;

impl Placer {
    /// Finds the surface of every crossing, of those on which one surface alone
    /// changes sign only around the cells that will ask for it (`self.slow`);
    /// and hands the polygons of the edges that the brick owns to `part`,
    /// surface by surface.
    #[inline(always)]
    pub(super) fn find_causes(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        crossings: &Crossings,
        part: &mut Part,
    ) {
        self.contested.clear();
        self.crowded.clear();
        if !self.one_surface {
            self.find_contested(scene, cell, crossings, part);
        }
        let mut slow = [0; WORDS];
        for &sample in &self.slow {
            slow[usize::from(sample >> 6) % WORDS] |= 1 << (sample & 63);
        }
        let causes_are_wanted = !self.one_surface && !self.slow.is_empty();
        let mut wanted = [[0; WORDS]; 3];
        for (axis, wanted) in wanted.iter_mut().enumerate() {
            if causes_are_wanted {
                brick::edges_of_cells(axis, &slow, wanted);
            }
        }
        for s in 0..cell.surfaces.len() {
            self.polygons.clear();
            for axis in 0..3 {
                let mut edges = self.sole_changes(crossings, s, axis);
                if edges.iter().fold(0, |any, edges| any | edges) == 0 {
                    continue;
                }
                if causes_are_wanted {
                    let mut asked_for = edges;
                    for (asked_for, wanted) in asked_for.iter_mut().zip(&wanted[axis]) {
                        *asked_for &= wanted;
                    }
                    let list = &mut *self.list;
                    let count = brick::expand(&asked_for, list, |_, _, sample| sample);
                    for &sample in &list[..count] {
                        self.cause[axis][usize::from(sample) % EDGES] = s as u16;
                    }
                }
                for (edges, owned) in edges.iter_mut().zip(&brick::OWNED) {
                    *edges &= owned;
                }
                self.collect_edges(axis, s, &edges);
            }
            if self
                .contested
                .iter()
                .any(|&(cause, _)| usize::from(cause) == s)
            {
                let own = self.contested.iter();
                let own = own.filter(|&&(cause, _)| usize::from(cause) == s);
                self.polygons.extend(own.map(|&(_, code)| code));
            }
            self.hand_over_polygons(scene, cell, s, part);
        }
    }

    /// Adds the polygons of edges on one surface to `self.polygons`.
    #[inline(always)]
    fn collect_edges(&mut self, axis: usize, s: usize, edges: &Mask) {
        let (solid, signs) = (&self.classified.solid, &self.classified.signs[s]);
        let list = &mut *self.list;
        let count = brick::expand(edges, list, |word, bit, sample| {
            let inside = solid[word].wrapping_shr(bit) & 1;
            let within = signs[word].wrapping_shr(bit) & 1;
            PolygonCode::pack(axis, inside as u16, within as u16, sample)
        });
        let codes = list[..count].iter().map(|&code| PolygonCode::unpack(code));
        self.polygons.extend(codes);
    }

    /// Decides about the edges on which several surfaces change sign. Where the
    /// solid does not, it may still have changed twice.
    #[inline(always)]
    fn find_contested(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        crossings: &Crossings,
        part: &mut Part,
    ) {
        for axis in 0..3 {
            for word in 0..WORDS {
                let solid = crossings.solid[axis][word];
                let mut bits = crossings.several[axis][word] & (solid | brick::OWNED[word]);
                while bits != 0 {
                    let bit = bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    let sample = word * 64 + bit;
                    let (s, all) = self.edge_cause(scene, cell, axis, sample);
                    if solid >> bit & 1 == 0 {
                        if all.len > 1 && !self.is_clipped(scene, cell, &all, axis, sample) {
                            part.fallbacks.push(Fallback {
                                kind: FallbackKind::SeveralCrossings,
                                place: self.edge_middle(scene, axis, sample),
                            });
                        }
                        continue;
                    }
                    self.cause[axis][sample] = s;
                    let is_owned = brick::is_set(&brick::OWNED, sample);
                    if all.len > 1 {
                        let middle = self.edge_middle(scene, axis, sample);
                        if self.meet_at(scene, cell, &all, middle, middle).is_some() {
                            self.crowded.push(((axis << 12 | sample) as u16, all));
                        } else if is_owned {
                            part.fallbacks.push(Fallback {
                                kind: FallbackKind::SeveralCrossings,
                                place: self.samples.point(sample),
                            });
                        }
                    }
                    if !is_owned {
                        continue;
                    }
                    let inside = brick::is_set(&self.classified.solid, sample);
                    let within = brick::is_set(&self.classified.signs[usize::from(s)], sample);
                    let code = PolygonCode::new(axis, inside, within, sample as u16);
                    self.contested.push((s, code));
                }
            }
        }
    }

    /// The crossing of an edge on which several surfaces change sign: their
    /// roots in order, the formula between them, and of the odd number of
    /// transitions the one nearest to the middle that goes the way the whole
    /// edge does; with the surfaces of all of them.
    #[inline(never)]
    pub(super) fn edge_cause(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        axis: usize,
        sample: usize,
    ) -> (u16, Constraints) {
        let (start, step) = (self.samples.point(sample), scene.lattice.step);
        let end = self.samples.point(sample + (1 << (4 * axis)));
        let mut roots = std::mem::take(&mut self.roots);
        roots.clear();
        for (s, changes) in self.changes.iter().enumerate() {
            if brick::is_set(&changes[axis], sample) {
                let surface = &scene.surfaces[cell.surfaces[s] as usize];
                let (f0, f1) = (surface.value(start), surface.value(end));
                let ([t, _], _) = roots_between(surface.quadratic[axis], step, f0, f1);
                roots.push((t, s as u16));
            }
        }
        roots.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // Bit i of an assignment: after the first i roots.
        roots.truncate(63);
        let signs = &self.classified.signs;
        let result = cell.formula.evaluate_words(&mut self.gates, |_, surface| {
            let inside = brick::is_set(&signs[surface as usize], sample);
            let before = if inside { u64::MAX } else { 0 };
            match roots.iter().position(|&(_, s)| u32::from(s) == surface) {
                Some(rank) => before ^ (u64::MAX << (rank + 1)),
                None => before,
            }
        });
        let transitions = (result ^ result >> 1) & !(u64::MAX << roots.len());
        let nth = |n: u32| {
            (0..roots.len())
                .filter(|i| transitions >> i & 1 == 1)
                .nth(n as usize)
        };
        let chosen = nth((transitions.count_ones() / 2) & !1).unwrap_or(roots.len() / 2);
        let mut all = Constraints::default();
        for (i, &(_, s)) in roots.iter().enumerate() {
            if transitions >> i & 1 == 1 {
                all.insert(s);
            }
        }
        let cause = roots[chosen].1;
        self.roots = roots;
        (cause, all)
    }

    /// The surfaces of a vertex's crossings together with those of all other
    /// transitions on its edges, where there are any that meet in one point.
    pub(super) fn crowd(
        &self,
        causes: &Constraints,
        edges: impl Iterator<Item = (usize, usize)>,
    ) -> Option<Constraints> {
        if self.crowded.is_empty() {
            return None;
        }
        let mut more = *causes;
        for (axis, sample) in edges {
            let edge = (axis << 12 | sample) as u16;
            for (_, all) in self.crowded.iter().filter(|&&(known, _)| known == edge) {
                all.as_slice().iter().for_each(|&s| more.insert(s));
            }
        }
        (more.len > causes.len).then_some(more)
    }

    /// The surface that causes a crossing.
    pub(super) fn cause(&self, axis: usize, sample: usize) -> u16 {
        if self.one_surface {
            0
        } else {
            self.cause[axis][sample % EDGES]
        }
    }

    /// The middle of a lattice edge.
    pub(super) fn edge_middle(&self, scene: &Scene<'_>, axis: usize, sample: usize) -> DVec3 {
        let mut point = self.samples.point(sample);
        point[axis] += 0.5 * scene.lattice.step;
        point
    }
}
