//! The curves of a quadric's lines that meet another quadric twice.

use std::f64::consts::{PI, TAU};

use glam::DMat4;
use smallvec::SmallVec;

use super::Pencil;
use crate::arrangement::curve::{Branch, Branches, Curve};
use crate::arrangement::intersection::Unknown;
use crate::arrangement::roots::Roots;
use crate::arrangement::rulings::{Lines, OnLines, Part, Rulings};
use crate::arrangement::trig::BEGIN;

impl Pencil<'_> {
    /// The curves on lines that meet the other surface twice.
    pub(super) fn on_lines(
        &self,
        lines: &Lines,
        other: &DMat4,
        near: f64,
    ) -> Result<Branches, Unknown> {
        let form = lines.form(other);
        let parts = match parts_of(&form) {
            Ok(parts) => parts,
            Err(NoParts::Lost) => return Err(Unknown::NoForm),
            Err(NoParts::Contact(angle)) => {
                let curve = self.rulings(lines, &form, Part::Around { is_plus: true });
                let point = curve.at((angle - BEGIN).rem_euclid(TAU));
                return self.through_contact(point, near);
            }
        };
        let mut branches = Branches::new();
        for part in parts {
            let narrow = self.on_narrow_lines(lines, other, &part);
            let curve = narrow.unwrap_or_else(|| self.rulings(lines, &form, part));
            let curves = curve.cut_at_infinity().into_iter();
            branches.extend(curves.map(|c| Branch::new(Curve::Rulings(Box::new(c)))));
        }
        Ok(branches)
    }

    /// A curve that is on few of the lines, with these spread: as they are, its discriminant,
    /// a polynomial of degree four in their angle, would be what is left of terms the larger the
    /// fewer they are. So is all of a curve on a cone as flat as two planes.
    fn on_narrow_lines(&self, lines: &Lines, other: &DMat4, part: &Part) -> Option<Rulings> {
        /// In radians, half of all. Digits are lost with its fourth power.
        const NARROW: f64 = 0.5;
        let &Part::Between { middle, half, .. } = part else {
            return None;
        };
        if half > NARROW {
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
        (discriminant.value(0.0) > 0.0).then(|| self.rulings(&lines, &form, part))
    }
}

/// Why it is not told on which of a quadric's lines its curves are.
enum NoParts {
    /// The surfaces touch at a point of the line at this angle.
    Contact(f64),
    /// Rounding took one of a pair of roots.
    Lost,
}

/// On which of a quadric's lines its curves are: by where the discriminant of the other
/// surface's quadratic form on the lines is 0.
fn parts_of(form: &OnLines) -> Result<SmallVec<[Part; 2]>, NoParts> {
    let (discriminant, nothing) = form.discriminant();
    let mut parts: SmallVec<[Part; 2]> = SmallVec::new();
    if discriminant.magnitude() <= nothing {
        parts.push(Part::Touching);
        return Ok(parts);
    }
    let mut roots = Roots::default();
    discriminant.roots(nothing, &mut roots);
    if let Some(&touching) = roots.touching.first() {
        return Err(NoParts::Contact(touching));
    }
    roots.simple.sort_by(f64::total_cmp);
    match roots.simple.as_slice() {
        [] if discriminant.value(0.0) < 0.0 => {}
        [] => parts.extend([true, false].map(|is_plus| Part::Around { is_plus })),
        angles if angles.len() % 2 == 1 => return Err(NoParts::Lost),
        angles => {
            let is_between = discriminant.value(0.5 * (angles[0] + angles[1])) > 0.0;
            for k in (usize::from(!is_between)..angles.len()).step_by(2) {
                let from = angles[k];
                let to = *angles.get(k + 1).unwrap_or(&(angles[0] + TAU));
                parts.push(Part::between(from, to, &discriminant));
            }
        }
    }
    Ok(parts)
}
