//! What of the boundary no sample saw: reported, never dropped silently.

use glam::DVec3;

use super::Placer;
use super::constraints::Constraints;
use super::vertices::NEAR;
use crate::program::{Cell, Surface};
use crate::surface::solve;
use crate::surface_nets::brick::Mask;
use crate::surface_nets::lattice::CELLS;
use crate::surface_nets::part::{Fallback, FallbackKind, Part};
use crate::surface_nets::scene::Scene;

impl Placer {
    /// Reports what lies unseen in a brick: tips of cones, and the point of each
    /// surface nearest to the brick's middle, if the solid changes across the
    /// surface there. If the samples of the solid differ (`is_mixed`), only tips,
    /// and surfaces that no sample of the brick saw at all, are suspects.
    #[inline(never)]
    pub(super) fn report_unseen(
        &mut self,
        scene: &Scene<'_>,
        cell: &Cell,
        is_mixed: bool,
        part: &mut Part,
    ) {
        let half = 0.5 * scene.lattice.step * CELLS as f64;
        let middle = self.samples.point(0) + half;
        let is_here = |place: &DVec3| (*place - middle).abs().max_element() <= half;
        for s in 0..cell.surfaces.len() as u16 {
            let is_silent = is_uniform(&self.classified.signs[usize::from(s)]);
            let surface = &scene.surfaces[cell.surfaces[usize::from(s)] as usize];
            let apex = surface.apex().filter(is_here);
            let place = apex.filter(|&apex| self.is_tip_unseen(scene, cell, s, apex));
            let place = place.or_else(|| {
                if is_mixed && !is_silent {
                    return None;
                }
                let place = solve::common_point(&[surface], middle, half).point;
                let inside = |sample| surface.value(sample) <= 0.0;
                let is_told = is_here(&place)
                    && !(is_silent && self.is_seen_around(scene, place, inside))
                    && self.is_valid(scene, cell, &Constraints::of(s), place);
                is_told.then_some(place)
            });
            part.fallbacks.extend(place.map(|place| Fallback {
                kind: FallbackKind::Unseen,
                place,
            }));
        }
    }

    /// Whether the solid ends at one of the tips of a cone, the `s`-th of the
    /// brick's surfaces, that no sample around its apex lies in.
    fn is_tip_unseen(&mut self, scene: &Scene<'_>, cell: &Cell, s: u16, apex: DVec3) -> bool {
        /// How far from the apex the solid is looked at, in cells.
        const BESIDE: f64 = 0.01;
        let surface = &scene.surfaces[cell.surfaces[usize::from(s)] as usize];
        let axis = surface.cone_axis();
        let across = axis.any_orthonormal_vector();
        let [within, beyond] = [axis, across].map(|d| surface.curvature_along(d));
        let spread = (-within / beyond).sqrt() * across;
        [axis, -axis].into_iter().any(|along| {
            let ruling = (along + spread).normalize();
            let place = apex + BESIDE * scene.lattice.step * ruling;
            let is_in_tip =
                |at: DVec3| surface.value(at) * within >= 0.0 && (at - apex).dot(along) > 0.0;
            !self.is_seen_around(scene, apex, is_in_tip)
                && self.is_valid(scene, cell, &Constraints::of(s), place)
        })
    }

    /// Whether some of the samples around a point, in this brick and in others,
    /// are `inside` of something and some are not: it reaches into this brick
    /// from where it is seen.
    fn is_seen_around(
        &self,
        scene: &Scene<'_>,
        place: DVec3,
        inside: impl Fn(DVec3) -> bool,
    ) -> bool {
        let (first, step) = (self.samples.point(0), scene.lattice.step);
        let cell = ((place - first) / step).floor();
        let mut seen = [false; 2];
        for index in 0..64u32 {
            let offset = DVec3::new(
                f64::from(index & 3),
                f64::from(index >> 2 & 3),
                f64::from(index >> 4),
            );
            seen[usize::from(inside(first + (cell + offset - 1.0) * step))] = true;
        }
        seen == [true; 2]
    }

    /// Whether the surfaces between which an edge, the last one that
    /// [`Self::edge_cause`] was asked about, runs through a part of the solid
    /// or of the space around it meet near there: it then cuts off a bit of a
    /// sharp edge, whose vertices are in the cells next to it. Else they are
    /// the sides of a wall or of a gap.
    pub(super) fn is_clipped(
        &self,
        scene: &Scene<'_>,
        cell: &Cell,
        surfaces: &Constraints,
        axis: usize,
        sample: usize,
    ) -> bool {
        let list = surfaces.as_slice();
        let own = self.roots.iter().filter(|(_, s)| list.contains(s));
        let between = own.map(|&(t, _)| t).sum::<f64>() / list.len() as f64;
        let mut point = self.samples.point(sample);
        point[axis] += between * scene.lattice.step;
        let surface = |&s: &u16| &scene.surfaces[cell.surfaces[usize::from(s)] as usize];
        let list: Vec<&Surface> = list.iter().map(surface).collect();
        let (step, before) = solve::step(&list, point);
        let after = solve::residual(list.iter().copied(), point + step);
        step.length() <= NEAR * scene.lattice.step && after <= 0.25 * before
    }
}

/// Whether all samples are on one side.
fn is_uniform(signs: &Mask) -> bool {
    let constant = if signs[0] & 1 == 1 { u64::MAX } else { 0 };
    signs.iter().all(|&word| word == constant)
}
