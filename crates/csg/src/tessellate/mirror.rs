//! Walls thinner than the tolerance.
//!
//! Chords and triangles of one surface run through another one that is nearer than they
//! stray, however the two are cut up: triangles as fine as a wall of a millionth would be
//! millions. But where each vertex of one surface is next to one of the other, and so is
//! each triangle, the gap between two triangles is at any point a mean of the gaps at their
//! corners, which are not negative. So of two closed surfaces that are all along within the
//! tolerance of each other one is cut up, and the other is its image.

mod faces;

use glam::DVec3;

pub(crate) use self::faces::mirrored;
use super::goal::Goal;
use super::outcome::Outcome;
use super::parts::Refined;
use super::shape::faces_in;
use super::surfaced::Surfaced;
use super::whole::Whole;

/// No part.
pub(super) const NONE: u32 = u32::MAX;

/// An ellipsoid by its bounds.
struct Bounded {
    part: u32,
    tolerance: f64,
    low: DVec3,
    high: DVec3,
}

impl Bounded {
    /// Whether the bounds of another one are next to these.
    fn is_next_to(&self, other: &Self) -> bool {
        let (low, high) = (self.low - other.low, self.high - other.high);
        let apart = low.abs().max(high.abs()).max_element();
        self.tolerance == other.tolerance && apart <= self.tolerance
    }
}

/// For each part the one whose image it may be, which is no image itself; or [`NONE`].
pub(super) fn originals(wholes: &[Option<Whole<'_>>], goal: &Goal) -> Vec<u32> {
    let mut original = vec![NONE; wholes.len()];
    let bounded = (0u32..).zip(wholes).filter_map(|(part, whole)| {
        let whole = whole.as_ref()?;
        let [low, high] = whole.bounds();
        let tolerance = goal.tolerance_on(whole.region.surface);
        Some(Bounded {
            part,
            tolerance,
            low,
            high,
        })
    });
    let mut bounded: Vec<Bounded> = bounded.collect();
    // Next to each other by one bound; of those that are the larger first.
    bounded.sort_by(|a, b| {
        let ends = b.high.x.total_cmp(&a.high.x);
        a.low.x.total_cmp(&b.low.x).then(ends)
    });
    for (place, one) in bounded.iter().enumerate() {
        if original[one.part as usize] != NONE {
            continue;
        }
        let others = bounded[place + 1..].iter();
        let near = others.take_while(|other| other.low.x - one.low.x <= one.tolerance);
        for other in near.filter(|other| one.is_next_to(other)) {
            let image = &mut original[other.part as usize];
            if *image == NONE {
                *image = one.part;
            }
        }
    }
    original
}

/// A part as the image of another one; none if that is not near enough, or folded.
pub(super) fn image(
    part: &Surfaced,
    whole: &Whole<'_>,
    original: &Refined,
    is_turned: bool,
    goal: &Goal,
) -> Option<Refined> {
    let (surface, region) = (whole.surface, &whole.region);
    let tolerance = goal.tolerance_on(region.surface);
    let place = |&at: &DVec3| {
        let place = region.project(surface, at)?;
        (place.distance(at) <= tolerance).then_some(place)
    };
    let positions: Option<Vec<DVec3>> = original.surfaced.positions.iter().map(place).collect();
    let turned = |&[a, b, c]: &[u32; 3]| if is_turned { [a, c, b] } else { [a, b, c] };
    let surfaced = Surfaced {
        positions: positions?,
        triangles: original.surfaced.triangles.iter().map(turned).collect(),
        groups: vec![region.group; original.surfaced.triangles.len()],
        ..part.empty()
    };
    let mut outcome = Outcome::default();
    for triangle in &surfaced.triangles {
        let corners = triangle.map(|corner| surfaced.positions[corner as usize]);
        let bound = region.bound(surface, corners);
        if bound > tolerance || faces_in(surface, region, corners) {
            return None;
        }
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        outcome.note(bound, middle, &[region.surface], goal.promised);
    }
    Some(Refined { surfaced, outcome })
}
