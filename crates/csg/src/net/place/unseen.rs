//! What of the boundary no sample saw: reported, never dropped silently.

use glam::DVec3;

use super::vertices::{Constraints, NEAR};
use super::{Placer, Scene};
use crate::net::brick::Mask;
use crate::net::lattice::CELLS;
use crate::net::part::{Fallback, FallbackKind, Part};
use crate::net::solve;
use crate::program::{Cell, Surface};

impl Placer {
    /// Reports what lies unseen in a brick: the point of each surface nearest
    /// to the brick's middle, if the solid changes across the surface there. If
    /// the samples of the solid differ (`is_mixed`), only surfaces that no
    /// sample of the brick saw at all are suspects.
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
        for s in 0..cell.surfaces.len() as u16 {
            let is_silent = is_uniform(&self.classified.signs[usize::from(s)]);
            if is_mixed && !is_silent {
                continue;
            }
            let surface = &scene.surfaces[cell.surfaces[usize::from(s)] as usize];
            let place = solve::common_point(&[surface], middle, half).point;
            let mut constraints = Constraints::default();
            constraints.insert(s);
            if (place - middle).abs().max_element() <= half
                && !(is_silent && self.is_seen_around(scene, surface, place))
                && self.is_valid(scene, cell, &constraints, place)
            {
                part.fallbacks.push(Fallback {
                    kind: FallbackKind::Unseen,
                    place,
                });
            }
        }
    }

    /// Whether the samples of the cells around a point, in this brick and in
    /// others, lie on both sides of a surface: it reaches into this brick
    /// from where it is seen.
    fn is_seen_around(&self, scene: &Scene<'_>, surface: &Surface, place: DVec3) -> bool {
        let (first, step) = (self.samples.point(0), scene.lattice.step);
        let cell = ((place - first) / step).floor();
        let mut seen = [false; 2];
        for index in 0..64u32 {
            let offset = DVec3::new(
                f64::from(index & 3),
                f64::from(index >> 2 & 3),
                f64::from(index >> 4),
            );
            let sample = first + (cell + offset - 1.0) * step;
            seen[usize::from(surface.value(sample) <= 0.0)] = true;
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
