//! Walls thinner than the tolerance.
//!
//! Chords and triangles of one surface run through another one that is nearer than they
//! stray, however the two are cut up: triangles as fine as a wall of a millionth would be
//! millions. But where each vertex of one surface is next to one of the other, and so is
//! each triangle, the gap between two triangles is at any point a mean of the gaps at their
//! corners, which are not negative. So of two closed surfaces that are all along within the
//! tolerance of each other one is cut up, and the other is its image.

use glam::DVec3;

use super::deviation::Shrinkage;
use super::goal::Goal;
use super::outcome::Outcome;
use super::parts::Refined;
use super::region::{Bend, Region, Way};
use super::round::Round;
use super::shape::faces_in;
use super::surfaced::Surfaced;
use crate::program::{Kind, Surface};
use crate::surface::Side;

/// No part.
pub(super) const NONE: u32 = u32::MAX;

/// A part of a mesh that is all of an ellipsoid.
struct Whole {
    part: u32,
    surface: u32,
    /// The corners of the ellipsoid's bounds.
    low: DVec3,
    high: DVec3,
}

impl Whole {
    fn of(part: u32, surfaced: &Surfaced, surfaces: &[Surface]) -> Option<Self> {
        let group = *surfaced.groups.first()?;
        let index = surfaced.surface_of_group[group as usize];
        let surface = &surfaces[index as usize];
        let is_whole =
            surface.kind == Kind::Ellipsoid && surfaced.groups.iter().all(|&g| g == group);
        if !is_whole {
            return None;
        }
        let form = surface.standard_form();
        let squares = form.values.map(|value| -form.constant / value);
        let axes = form.axes.iter().zip(squares);
        let reach: DVec3 = axes.map(|(&axis, square)| square * axis * axis).sum();
        let reach = reach.to_array().map(f64::sqrt);
        let reach = DVec3::from_array(reach);
        reach.is_finite().then_some(Self {
            part,
            surface: index,
            low: form.center - reach,
            high: form.center + reach,
        })
    }

    /// Whether the bounds of another one, which is no larger, are next to these.
    fn is_around(&self, other: &Self, goal: &Goal) -> bool {
        let tolerances = [self, other].map(|whole| goal.tolerance_on(whole.surface));
        let apart = (self.low - other.low)
            .abs()
            .max((self.high - other.high).abs());
        tolerances[0] == tolerances[1] && apart.max_element() <= tolerances[0]
    }
}

/// For each part the one whose image it may be, which is no image itself; or [`NONE`].
pub(super) fn originals(parts: &[Surfaced], surfaces: &[Surface], goal: &Goal) -> Vec<u32> {
    let mut original = vec![NONE; parts.len()];
    let wholes = (0u32..).zip(parts);
    let wholes = wholes.filter_map(|(part, surfaced)| Whole::of(part, surfaced, surfaces));
    let mut wholes: Vec<Whole> = wholes.collect();
    let size = |whole: &Whole| (whole.high - whole.low).length_squared();
    // Next to each other by one bound; of those that are the larger first.
    wholes.sort_by(|a, b| {
        a.low
            .x
            .total_cmp(&b.low.x)
            .then(size(b).total_cmp(&size(a)))
    });
    for (place, whole) in wholes.iter().enumerate() {
        if original[whole.part as usize] != NONE {
            continue;
        }
        let reach = goal.tolerance_on(whole.surface);
        let near = wholes[place + 1..].iter();
        let near = near.take_while(|other| other.low.x - whole.low.x <= reach);
        for other in near.filter(|other| whole.is_around(other, goal)) {
            let image = &mut original[other.part as usize];
            if *image == NONE {
                *image = whole.part;
            }
        }
    }
    original
}

/// A part as the image of another one; none if that is not near enough, or folded.
pub(super) fn image(
    part: &Surfaced,
    original: &Refined,
    surfaces: &[Surface],
    goal: &Goal,
) -> Option<Refined> {
    let group = *part.groups.first()?;
    let index = part.surface_of_group[group as usize];
    let surface = &surfaces[index as usize];
    let tolerance = goal.tolerance_on(index);
    let (ours, theirs) = (volume(part), volume(&original.surfaced));
    let region = Region {
        surface: index,
        group,
        bend: Bend::of(surface),
        outward: along_gradient(surface) * ours.signum(),
        shrinkage: Shrinkage::of(surface),
        round: Round::of(surface),
        way: Way::OneByOne,
    };
    let place = |&at: &DVec3| {
        let place = region.project(surface, at)?;
        (place.distance(at) <= tolerance).then_some(place)
    };
    let positions: Option<Vec<DVec3>> = original.surfaced.positions.iter().map(place).collect();
    let turned = |&[a, b, c]: &[u32; 3]| {
        if ours * theirs < 0.0 {
            [a, c, b]
        } else {
            [a, b, c]
        }
    };
    let surfaced = Surfaced {
        positions: positions?,
        triangles: original.surfaced.triangles.iter().map(turned).collect(),
        groups: vec![group; original.surfaced.triangles.len()],
        ..part.empty()
    };
    let mut outcome = Outcome::default();
    for triangle in &surfaced.triangles {
        let corners = triangle.map(|corner| surfaced.positions[corner as usize]);
        let bound = region.bound(surface, corners);
        if bound > tolerance || faces_in(surface, &region, corners) {
            return None;
        }
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        outcome.note(bound, middle, &[index], goal.promised);
    }
    Some(Refined { surfaced, outcome })
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

/// 1 if the gradient of an ellipsoid points away from its middle, else -1.
fn along_gradient(surface: &Surface) -> f64 {
    match surface.definiteness() {
        Some(Side::Inside) => -1.0,
        _ => 1.0,
    }
}
