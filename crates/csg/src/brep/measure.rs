//! Measures of a solid from its exact boundary.
//!
//! By the divergence theorem, ∫ g dV = ∫ g p·n dA / (3 + k) for a form g of degree k in the
//! coordinates p.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::bounded::Bounded;
use super::curve::HalfAxes;
use super::data::{Brep, Patch, Stretch, range};
use super::quadrature::{self, Integrals, Scale, Sum, along};
use super::view::{Edge, Face};
use crate::numeric::tolerance::VALUE;

/// The measures of a solid, in the units of its model.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SolidMeasure {
    /// The volume.
    pub volume: Bounded,
    /// The area of the boundary.
    pub area: Bounded,
    /// The centroid, each coordinate with its bound; none of an empty solid.
    pub centroid: Option<[Bounded; 3]>,
    /// The second moments about the centroid: the integral of (x - c)(x - c)ᵀ over the
    /// volume; zero without a centroid.
    pub second_moments: DMat3,
    /// Bound on the error of each of the second moments.
    pub second_moments_error: f64,
}

impl SolidMeasure {
    /// The inertia tensor about the centroid at density 1:
    /// trace(M) I - M of the second moments M.
    #[must_use]
    pub fn inertia(&self) -> DMat3 {
        let m = self.second_moments;
        let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
        DMat3::from_diagonal(DVec3::splat(trace)) - m
    }
}

impl Brep {
    /// Volume, area, centroid and second moments, with bounds on their errors: some 1e-13 of
    /// the scene's size, raised to the power of each measure.
    ///
    /// The bounds are not proven: they count what changes where the rule of integration is
    /// refined, what rounding does to its terms and to the surfaces, how far curves pass by
    /// the vertices they should meet, how far surfaces were [`Self::moved`], and, but for the area,
    /// what was between those that were made one. Takes about 50 microseconds for every edge of a
    /// curved face.
    #[must_use]
    pub fn measure(&self) -> SolidMeasure {
        let about = self.middle(&self.patches);
        let sum = self.sum(&self.patches, about);
        self.solid_measure(&sum, about)
    }

    /// Between all edges of patches. Integrals about there are no larger than they need be, and
    /// what rounding changes of them.
    pub(super) fn middle(&self, patches: &[Patch]) -> DVec3 {
        let stretches = patches.iter().flat_map(|patch| &patch.stretches);
        let start = |stretch: &Stretch| {
            let at = self.curves[stretch.curve as usize].at(stretch.places[0]);
            (at, at)
        };
        let ends = stretches.map(start);
        let ends = ends.reduce(|(low, high), (at, _)| (low.min(at), high.max(at)));
        ends.map_or(DVec3::ZERO, |(low, high)| low.midpoint(high))
    }

    /// The integrals over patches, of points counted from `about`.
    pub(super) fn sum(&self, patches: &[Patch], about: DVec3) -> Sum {
        let sums = patches.par_iter().map(|patch| self.sum_of(patch, about));
        let sums: Vec<Sum> = sums.collect();
        let mut sum = Sum::default();
        for part in &sums {
            sum.add(part);
        }
        sum
    }

    fn sum_of(&self, patch: &Patch, about: DVec3) -> Sum {
        let chart = self.chart(patch);
        let mut sum = Sum::default();
        for stretch in &patch.stretches {
            let curve = &self.curves[stretch.curve as usize];
            let Stretch { places, gap, .. } = *stretch;
            let off = gap.max(self.rounding);
            let scene = Scale {
                about,
                size: self.size,
                off,
            };
            sum.add(&along(
                &chart,
                |t| curve.at(t),
                curve.is_line(),
                places,
                &scene,
            ));
        }
        sum
    }

    fn solid_measure(&self, sum: &Sum, about: DVec3) -> SolidMeasure {
        let mut errors = sum.errors;
        // Surfaces are where they should be but for rounding, and but for what moved them. The
        // layer between counts as much as a part of the boundary of so much area, at the least:
        // a form of degree k is 3 + k times its integral over the layer, within half the size.
        let off = self.rounding + self.moved.map_or(0.0, |moved| moved.distance);
        let layer = off * sum.values[10].abs();
        add_layer(&mut errors, layer + self.between, self.size);
        errors[10] += 3.0 * layer / self.size.max(f64::MIN_POSITIVE);
        let moment = |k: usize| sum.values[k] / divisor(k);
        let error = |k: usize| errors[k] / divisor(k);
        let volume = Bounded {
            value: moment(0),
            error: error(0),
        };
        let first = DVec3::new(moment(1), moment(2), moment(3));
        let is_something = volume.value > volume.error;
        let centroid = is_something.then(|| first / volume.value);
        let second = |k: usize, i: usize, j: usize| match centroid {
            Some(centroid) => moment(k) - volume.value * centroid[i] * centroid[j],
            None => 0.0,
        };
        let [xx, yy, zz] = [second(4, 0, 0), second(5, 1, 1), second(6, 2, 2)];
        let [xy, yz, zx] = [second(7, 0, 1), second(8, 1, 2), second(9, 2, 0)];
        let bounded = |k: usize, at: f64| Bounded {
            value: at + about[k] + self.origin[k],
            error: (error(k + 1) + at.abs() * volume.error) / volume.value
                + f64::EPSILON * (at.abs() + about[k].abs() + self.origin[k].abs()),
        };
        let of_second = (4..10).map(error).fold(0.0, f64::max);
        let reach = centroid.map_or(0.0, |centroid| centroid.abs().max_element());
        let of_first = (1..4).map(error).fold(0.0, f64::max);
        SolidMeasure {
            volume,
            area: Bounded {
                value: sum.values[10],
                error: errors[10],
            },
            centroid: centroid.map(|c| [0, 1, 2].map(|k| bounded(k, c[k]))),
            second_moments: DMat3::from_cols_array_2d(&[[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]),
            second_moments_error: of_second + reach * (2.0 * of_first + reach * volume.error),
        }
    }
}

/// What an integral is to be divided by for a moment of the volume.
fn divisor(k: usize) -> f64 {
    match k {
        0 => 3.0,
        1..=3 => 4.0,
        4..=9 => 5.0,
        _ => 1.0,
    }
}

/// Adds what a layer of some volume within a scene may change of the volume and its moments.
fn add_layer(errors: &mut Integrals, volume: f64, size: f64) {
    for (k, error) in errors[..10].iter_mut().enumerate() {
        *error += 3.0
            * volume
            * match k {
                0 => 1.0,
                1..=3 => size,
                _ => size * size,
            };
    }
}

impl Face<'_> {
    /// Its area.
    #[must_use]
    pub fn area(&self) -> Bounded {
        let brep = self.brep();
        let sum = brep.sum(&brep.patches[range(self.patches())], DVec3::ZERO);
        Bounded {
            value: sum.values[10],
            error: sum.errors[10],
        }
    }
}

impl Edge<'_> {
    /// Its length.
    #[must_use]
    pub fn length(&self) -> Bounded {
        let [from, to] = self.range();
        if let Some(HalfAxes {
            long, short, turn, ..
        }) = self.curve().half_axes()
        {
            let axes = [long, short].map(DVec3::length);
            return quadrature::arc_length(axes, [from - turn, to - turn]);
        }
        let off = VALUE * self.size_of_solid();
        quadrature::length(|t| self.at_about(t), [from, to], off)
    }
}
