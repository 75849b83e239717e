//! The curves of a quadric's lines that meet another quadric twice.

use std::f64::consts::{PI, TAU};

use glam::DMat4;
use smallvec::SmallVec;

use super::{Pencil, spread};
use crate::arrangement::curve::{Branch, Branches, Curve};
use crate::arrangement::intersection::Unknown;
use crate::arrangement::roots::Roots;
use crate::arrangement::rulings::{Lines, OnLines, Part, Rulings};
use crate::arrangement::trig::BEGIN;

impl Pencil<'_> {
    /// The curves on lines that meet the other surface twice.
    pub(super) fn on_lines(&self, lines: &Lines, other: &DMat4) -> Result<Branches, Unknown> {
        let is_on = |lines: &Lines| is_in_plane(lines, other);
        let mut branches = Branches::new();
        for (lines, until) in spread(lines, is_on) {
            let form = lines.form(other);
            let parts = match parts_of(&form, until) {
                Ok(parts) => parts,
                Err(NoParts::Lost) => return Err(Unknown::NoForm),
                Err(NoParts::Contact(angle)) => {
                    let part = (Part::Around { is_plus: true }, None);
                    let curve = self.rulings(&lines, &form, part);
                    let point = curve.at((angle - BEGIN).rem_euclid(TAU));
                    return self.through_contact(point);
                }
            };
            for part in parts {
                let narrow = self.on_narrow_lines(&lines, other, &part, until);
                let curve = narrow.unwrap_or_else(|| self.rulings(&lines, &form, (part, until)));
                let curves = curve.parts().into_iter();
                branches.extend(curves.map(|c| Branch::new(Curve::Rulings(Box::new(c)))));
            }
        }
        Ok(branches)
    }

    /// A curve that is on few of the lines, with these spread: as they are, its discriminant,
    /// a polynomial of degree four in their angle, would be what is left of terms the larger the
    /// fewer they are. So is all of a curve on a cone as flat as two planes.
    fn on_narrow_lines(
        &self,
        lines: &Lines,
        other: &DMat4,
        part: &Part,
        until: Option<f64>,
    ) -> Option<Rulings> {
        /// In radians, half of all. Digits are lost with its fourth power.
        const NARROW: f64 = 0.5;
        let &Part::Between { middle, half, .. } = part else {
            return None;
        };
        let off = (middle + PI).rem_euclid(TAU) - PI;
        let is_all = until.is_none_or(|until| off.abs() + half < until);
        if half > NARROW || !is_all {
            return None;
        }
        let lines = lines.spread(middle, half);
        let form = lines.form(other);
        let (discriminant, nothing) = form.discriminant();
        let mut roots = Roots::default();
        discriminant.roots(nothing, &mut roots);
        // The rest of the lines, now narrow, do not matter.
        let signed = |angle: &f64| (angle + PI).rem_euclid(TAU) - PI;
        let before = roots.simple.iter().map(signed).filter(|&angle| angle < 0.0);
        let after = roots.simple.iter().map(signed).filter(|&angle| angle > 0.0);
        let (from, to) = (before.reduce(f64::max)?, after.reduce(f64::min)?);
        let part = Part::between(from, to, &discriminant);
        (discriminant.value(0.0) > 0.0).then(|| self.rulings(&lines, &form, (part, None)))
    }
}

/// Whether curves on lines that are spread in a plane lie in that: most points of theirs are not
/// next to where it meets another plane. Curves of flat surfaces are.
fn is_in_plane(lines: &Lines, other: &DMat4) -> bool {
    const SAMPLES: u32 = 32;
    /// From there, of how far a plane's points are.
    const AWAY: f64 = 0.1;
    let form = lines.form(other);
    let (discriminant, nothing) = form.discriminant();
    let mut counts = [0, 0];
    for k in 0..SAMPLES {
        let angle = ((f64::from(k) + 0.5) / f64::from(SAMPLES) - 0.5) * PI;
        let square = discriminant.value(angle);
        if square <= nothing {
            continue;
        }
        let [a, b] = [&form.a, &form.b].map(|f| f.value(angle));
        let [p, q] = lines.lengths(angle);
        for root in [square.sqrt(), -square.sqrt()] {
            let is_away = ((root - b) * p).abs() > AWAY * (a * q).abs();
            counts[usize::from(is_away)] += 1;
        }
    }
    counts[1] > counts[0]
}

/// Why it is not told on which of a quadric's lines its curves are.
enum NoParts {
    /// The surfaces touch at a point of the line at this angle.
    Contact(f64),
    /// Rounding took one of a pair of roots.
    Lost,
}

/// On which of a quadric's lines its curves are: by where the discriminant of the other
/// surface's quadratic form on the lines is 0. Of few of them, those at angles up to `until`, it
/// does not matter what is on the others.
fn parts_of(form: &OnLines, until: Option<f64>) -> Result<SmallVec<[Part; 2]>, NoParts> {
    let (discriminant, nothing) = form.discriminant();
    let mut parts: SmallVec<[Part; 2]> = SmallVec::new();
    if discriminant.magnitude() <= nothing {
        parts.push(Part::Touching);
        return Ok(parts);
    }
    let mut roots = Roots::default();
    discriminant.roots(nothing, &mut roots);
    let is_own = |&angle: &f64| {
        let off = (angle + PI).rem_euclid(TAU) - PI;
        until.is_none_or(|until| off.abs() <= until)
    };
    if let Some(touching) = roots.touching.iter().copied().find(is_own) {
        return Err(NoParts::Contact(touching));
    }
    roots.simple.sort_by(f64::total_cmp);
    match roots.simple.as_slice() {
        [] if discriminant.value(0.0) < 0.0 => {}
        [] => parts.extend([true, false].map(|is_plus| Part::Around { is_plus })),
        angles if angles.len() % 2 == 1 => return Err(NoParts::Lost),
        angles => {
            // Where it is farthest from 0: at some angle of spread lines it is next to that.
            let value =
                |share: f64| discriminant.value(angles[0] + share * (angles[1] - angles[0]));
            let farthest = [0.2, 0.5, 0.8].map(value).into_iter();
            let farthest = farthest.max_by(|a, b| a.abs().total_cmp(&b.abs()));
            let is_between = farthest.is_some_and(|value| value > 0.0);
            for k in (usize::from(!is_between)..angles.len()).step_by(2) {
                let from = angles[k];
                let to = *angles.get(k + 1).unwrap_or(&(angles[0] + TAU));
                parts.push(Part::between(from, to, &discriminant));
            }
        }
    }
    Ok(parts)
}
