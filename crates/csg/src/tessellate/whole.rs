//! Parts of a mesh that are all of an ellipsoid.

use glam::DVec3;

use super::deviation::Shrinkage;
use super::region::{Bend, Region, Way};
use super::surfaced::Surfaced;
use crate::program::{Kind, Surface};
use crate::surface::Side;
use crate::surface::round::Round;

/// A part of a mesh that is all of an ellipsoid.
pub(super) struct Whole<'a> {
    pub surface: &'a Surface,
    pub region: Region,
    /// Whether it faces inward, as the wall of a void.
    pub is_void: bool,
    pub center: DVec3,
    radius: Option<f64>,
    /// The half axes and their directions.
    half_axes: [f64; 3],
    axes: [DVec3; 3],
}

impl<'a> Whole<'a> {
    /// None if there is more to the part.
    pub fn of(part: &Surfaced, surfaces: &'a [Surface]) -> Option<Self> {
        let group = *part.groups.first()?;
        let id = part.surface_of_group[group as usize];
        let surface = &surfaces[id];
        let is_whole = surface.kind == Kind::Ellipsoid && part.groups.iter().all(|&g| g == group);
        if !is_whole {
            return None;
        }
        let form = surface.standard_form();
        let half_axes = form.half_axes();
        let is_void = volume(part) < 0.0;
        let grows_outward = surface.definiteness() != Some(Side::Inside);
        let is_real = half_axes.iter().all(|axis| axis.is_finite());
        is_real.then(|| Self {
            surface,
            region: Region {
                surface: id,
                group,
                bend: Bend::of(surface),
                outward: if is_void == grows_outward { -1.0 } else { 1.0 },
                shrinkage: Shrinkage::of(surface),
                round: Round::of(surface, f64::INFINITY),
                way: Way::OneByOne,
            },
            is_void,
            center: form.center,
            radius: form.radius(),
            half_axes,
            axes: form.axes,
        })
    }

    /// The corners of the ellipsoid's bounds.
    pub fn bounds(&self) -> [DVec3; 2] {
        let axes = self.axes.iter().zip(self.half_axes);
        let squares: DVec3 = axes
            .map(|(&axis, half)| (half * axis) * (half * axis))
            .sum();
        let reach = DVec3::from_array(squares.to_array().map(f64::sqrt));
        [self.center - reach, self.center + reach]
    }

    /// The radius, if all half axes are the same but for rounding.
    pub fn radius(&self) -> Option<f64> {
        self.radius
    }
}

/// Six times the volume within a closed mesh, less than 0 if it faces inward.
fn volume(surfaced: &Surfaced) -> f64 {
    let Some(&about) = surfaced.positions.first() else {
        return 0.0;
    };
    let volume = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| surfaced.positions[corner as usize] - about);
        a.dot(b.cross(c))
    };
    surfaced.triangles.iter().map(volume).sum()
}
