//! Where a vertex lies: on all surfaces that cause its crossings, and where the
//! solid really changes across them.

use glam::DVec3;

use super::Placer;
use super::constraints::{Candidate, Constraints, MOST_CONSTRAINTS};
use crate::program::{Cell, Side};
use crate::surface::solve;
use crate::surface_nets::meet::{self, Batch};
use crate::surface_nets::part::{Fallback, FallbackKind, Part};
use crate::surface_nets::scene::Scene;
use crate::surface_nets::validity;

/// How far a vertex may lie from the middle of its cell along any axis, in
/// cells: a cell outside of it.
pub(super) const NEAR: f64 = 1.5;

/// The same for corners where the solid is known to change across three
/// surfaces: the tips of spikes and pyramids, which no sample reaches.
const FAR: f64 = 2.5;

/// Of the surfaces near a vertex in need of repair, how many are tried.
const MOST_EXTRAS: usize = 8;

impl Placer {
    /// Adds a vertex on all `constraints`, expected near `start`; `middle` is
    /// the middle of its cell or face, which it may leave by a cell at most.
    /// Where it lies, and whether the solid really changes there, is left to
    /// [`Self::settle`].
    pub(super) fn place_vertex(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: Constraints,
        start: DVec3,
        middle: DVec3,
        part: &mut Part,
    ) {
        if self.has_apexes
            && let Some(apex) = self.apex_vertex(scene, cell, &constraints, middle)
        {
            part.vertices.push(apex);
            return;
        }
        self.candidates.push(Candidate {
            vertex: part.vertices.len(),
            constraints,
            start,
            middle,
        });
        part.vertices.push(start);
    }

    /// Moves all vertices added since the last call onto their surfaces, and
    /// repairs those that have no common point, or across which the solid does
    /// not change as their crossings say.
    #[inline(always)]
    pub(super) fn settle(&mut self, scene: &Scene<'_>, cell: &Cell, part: &mut Part) {
        let mut candidates = std::mem::take(&mut self.candidates);
        let mut pending = std::mem::take(&mut self.pending);
        pending.clear();
        meet::<1>(scene, cell, &candidates, &mut pending, part);
        meet::<2>(scene, cell, &candidates, &mut pending, part);
        meet::<3>(scene, cell, &candidates, &mut pending, part);
        let many = |c: &Candidate| !(1..=3).contains(&c.constraints.len);
        pending.extend((0..candidates.len()).filter(|&i| many(&candidates[i])));
        // What the fast search did not find.
        pending.sort_unstable();
        let mut repaired = Vec::new();
        for &i in &pending {
            let candidate = candidates[i];
            let Candidate {
                vertex,
                constraints,
                start,
                middle,
            } = candidate;
            match self.try_constraints(scene, cell, &constraints, start, middle, NEAR) {
                Some(point) => part.vertices[vertex] = point,
                None => {
                    self.repair(scene, cell, &candidate, None, part);
                    repaired.push(i);
                }
            }
        }
        for &i in repaired.iter().rev() {
            candidates.swap_remove(i);
        }
        self.pending = pending;
        let mut tests = std::mem::take(&mut self.tests);
        for batch in candidates.chunks(validity::LANES) {
            let points = batch.iter().map(|c| part.vertices[c.vertex]);
            tests.begin(points, scene, cell);
            for (lane, candidate) in batch.iter().enumerate() {
                tests.free(lane, candidate.constraints.as_slice());
            }
            let valid = tests.evaluate(&cell.formula);
            for (lane, candidate) in batch.iter().enumerate() {
                let is_valid = match valid.get(lane, candidate.constraints.len) {
                    Some(valid) => valid,
                    None => {
                        let point = part.vertices[candidate.vertex];
                        self.is_valid(scene, cell, &candidate.constraints, point)
                    }
                };
                if !is_valid {
                    let point = part.vertices[candidate.vertex];
                    self.repair(scene, cell, candidate, Some(point), part);
                }
            }
        }
        self.tests = tests;
        candidates.clear();
        self.candidates = candidates;
    }

    /// Finds another place for a vertex: with one more surface, for a feature
    /// that no sample saw, or on fewer, and reports what it had to settle for.
    /// `plain` is the common point of its constraints, if there is one.
    #[inline(never)]
    pub(super) fn repair(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        candidate: &Candidate,
        plain: Option<DVec3>,
        part: &mut Part,
    ) {
        let Candidate {
            vertex,
            constraints,
            start,
            middle,
        } = candidate;
        if let Some(point) = self.hidden_corner(scene, cell, candidate) {
            part.vertices[*vertex] = point;
            return;
        }
        let kind = if plain.is_some() {
            FallbackKind::HiddenFeature
        } else {
            FallbackKind::NoCommonPoint
        };
        let place = plain.unwrap_or(*start);
        part.fallbacks.push(Fallback { kind, place });
        if plain.is_some() {
            return;
        }
        // As many of the surfaces as have a common point.
        let mut fewer = vec![*constraints];
        while let Some(candidates) = shrink(&fewer) {
            for candidate in &candidates {
                let point = self.try_constraints(scene, cell, candidate, *start, *middle, NEAR);
                if let Some(point) = point {
                    part.vertices[*vertex] = point;
                    return;
                }
            }
            fewer = candidates;
        }
    }

    /// A point on all surfaces of a vertex and on one or two more that pass
    /// near it, where the solid changes across each of them.
    fn hidden_corner(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        candidate: &Candidate,
    ) -> Option<DVec3> {
        let Candidate {
            constraints,
            start,
            middle,
            ..
        } = *candidate;
        let extras = |reach: f64| {
            let half = DVec3::splat((reach - 0.5) * scene.lattice.step);
            let is_near = move |&extra: &u16| {
                let surface = &scene.surfaces[cell.surfaces[usize::from(extra)] as usize];
                !constraints.as_slice().contains(&extra)
                    && surface.side_of_box(middle, half) == Side::Crossing
            };
            let all = 0..cell.surfaces.len() as u16;
            all.filter(is_near).take(MOST_EXTRAS).collect::<Vec<u16>>()
        };
        for reach in [NEAR, FAR] {
            let extras = extras(reach);
            let mut sets = Vec::new();
            if reach > NEAR {
                sets.push(constraints);
            }
            if constraints.len < 3 {
                sets.extend(extras.iter().map(|&extra| constraints.with(extra)));
            }
            if constraints.len < 2 {
                for (i, &first) in extras.iter().enumerate() {
                    let pairs = extras[..i].iter();
                    sets.extend(pairs.map(|&second| constraints.with(first).with(second)));
                }
            }
            // Farther away only corners of planes, of which there is one: an
            // edge would do in many places, and curves meet more than once.
            let is_plane =
                |&s: &u16| scene.surfaces[cell.surfaces[usize::from(s)] as usize].is_plane();
            let is_enough = |set: &Constraints| {
                reach == NEAR || (set.len >= 3 && set.as_slice().iter().all(is_plane))
            };
            for set in sets.iter().filter(|set| is_enough(set)) {
                let found = self.meet_within(scene, cell, set, start, middle, reach);
                if found.is_some() {
                    return found;
                }
            }
        }
        None
    }

    /// The apex of one of the surfaces, if it is on all of them, a part of the
    /// solid's boundary, and either marked for this cell or, where several
    /// surfaces meet in nothing but the apex, within the reach of a vertex.
    pub(super) fn apex_vertex(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: &Constraints,
        middle: DVec3,
    ) -> Option<DVec3> {
        let step = scene.lattice.step;
        let surface = |s: u16| &scene.surfaces[cell.surfaces[usize::from(s)] as usize];
        let list = constraints.as_slice();
        let mut apexes = list.iter().filter_map(|&s| surface(s).apex());
        let reach = if list.len() > 1 {
            1.5 * step
        } else {
            0.5 * step
        };
        let apex = apexes.find(|&apex| {
            let holds = (apex - middle).abs().max_element() <= reach;
            let is_marked = self.apexes.iter().any(|&(sample, marked)| {
                marked == apex && self.samples.point(usize::from(sample)) + 0.5 * step == middle
            });
            holds || is_marked
        })?;
        let on_all = solve::residual(list.iter().map(|&s| surface(s)), apex) <= scene.tolerance;
        (on_all && self.is_valid(scene, cell, constraints, apex)).then_some(apex)
    }

    /// A point on all constraints near `middle`, by `reach` cells along any
    /// axis at most, if there is one.
    pub(super) fn try_constraints(
        &self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: &Constraints,
        start: DVec3,
        middle: DVec3,
        reach: f64,
    ) -> Option<DVec3> {
        let mut list = [&scene.surfaces[0]; MOST_CONSTRAINTS];
        for (slot, &s) in list.iter_mut().zip(constraints.as_slice()) {
            *slot = &scene.surfaces[cell.surfaces[usize::from(s)] as usize];
        }
        let step = scene.lattice.step;
        let solution = solve::common_point(&list[..constraints.len], start, step);
        let near = (solution.point - middle).abs().max_element() <= reach * step;
        (near && solution.residual <= scene.tolerance).then_some(solution.point)
    }

    /// A point on all constraints within a cell of `middle` at which the solid
    /// changes across each of them, if there is one.
    pub(super) fn meet_at(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: &Constraints,
        start: DVec3,
        middle: DVec3,
    ) -> Option<DVec3> {
        self.meet_within(scene, cell, constraints, start, middle, NEAR)
    }

    fn meet_within(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: &Constraints,
        start: DVec3,
        middle: DVec3,
        reach: f64,
    ) -> Option<DVec3> {
        let point = self.try_constraints(scene, cell, constraints, start, middle, reach)?;
        self.is_valid(scene, cell, constraints, point)
            .then_some(point)
    }

    /// Whether the solid changes across each of the constraints at `point`.
    pub(super) fn is_valid(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        constraints: &Constraints,
        point: DVec3,
    ) -> bool {
        let mut ids = [0; MOST_CONSTRAINTS];
        for (id, &s) in ids.iter_mut().zip(constraints.as_slice()) {
            *id = cell.surfaces[usize::from(s)];
        }
        let own = &ids[..constraints.len];
        let tolerance = scene.tolerance;
        self.truth
            .across(scene.surfaces, cell, own, point, tolerance)
    }
}

/// Moves the vertices of candidates with `N` surfaces onto these, many at a
/// time; those that do not get there, or too far from their cells, become
/// pending.
#[inline(always)]
fn meet<const N: usize>(
    scene: &Scene<'_>,
    cell: &Cell,
    candidates: &[Candidate],
    pending: &mut Vec<usize>,
    part: &mut Part,
) {
    let step = scene.lattice.step;
    let mut batch = Batch::<N>::new();
    let mut members = [0; meet::LANES];
    let mut count = 0;
    for i in 0..=candidates.len() {
        if batch.is_full() || (i == candidates.len() && count > 0) {
            for (&i, point) in members.iter().zip(batch.solve(step, scene.tolerance)) {
                let Candidate { vertex, middle, .. } = candidates[i];
                let is_near = |p: &DVec3| (*p - middle).abs().max_element() <= NEAR * step;
                match point.filter(is_near) {
                    Some(point) => part.vertices[vertex] = point,
                    None => pending.push(i),
                }
            }
            batch.clear();
            count = 0;
        }
        if let Some(candidate) = candidates.get(i)
            && let Ok(own) = <[u16; N]>::try_from(candidate.constraints.as_slice())
        {
            let surface = |s: u16| &scene.surfaces[cell.surfaces[usize::from(s)] as usize];
            batch.push(candidate.start, own.map(surface));
            members[count] = i;
            count += 1;
        }
    }
}

/// All sets with one constraint less.
fn shrink(sets: &[Constraints]) -> Option<Vec<Constraints>> {
    let smaller: Vec<Constraints> = sets
        .iter()
        .take(8)
        .flat_map(|set| (0..set.len).rev().map(|i| set.without(i)))
        .filter(|set| set.len > 0)
        .collect();
    (!smaller.is_empty()).then_some(smaller)
}
