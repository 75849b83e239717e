//! Where a curve on the lines of a quadric may meet a third surface: roots of a trigonometric
//! polynomial, or known points.

use std::f64::consts::TAU;

use glam::{DMat4, DVec4};

use super::{Along, OnLines, Part, Rulings, matrix};
use crate::arrangement::roots::{Candidate, Known, Roots, Tolerance, bracketed};
use crate::arrangement::trig::Trig;
use crate::elementary;
use crate::numeric::tolerance::{CANCELLED, POLYNOMIAL, SAME_ROOT};
use crate::program::Surface;

impl Rulings {
    /// What vanishes on the lines on which the curve meets a plane. On such a line
    /// α : β = q : -p, by the plane's values at p and q. And how large its terms
    /// are.
    pub(super) fn on_plane(&self, plane: DVec4) -> (Trig, f64) {
        let [p, q] = self.lines.values(plane);
        let OnLines { a, b, c } = &self.on_lines;
        let [size_a, size_b, size_c] = self.on_lines.magnitudes();
        let [size_p, size_q] = [&p, &q].map(Trig::magnitude);
        match self.part {
            Part::Once => (
                a.times(&q).plus(-2.0, &b.times(&p)),
                size_a * size_q + size_b * size_p,
            ),
            _ => {
                let mixed = b.times(&p).times(&q);
                let ends = a.times(&q).times(&q).plus(1.0, &c.times(&p).times(&p));
                let size = (size_a * size_q + size_b * size_p) * size_q + size_c * size_p * size_p;
                (ends.plus(-2.0, &mixed), size)
            }
        }
    }

    /// The same for another quadric: its value at the one point of a line, or the
    /// resultant of the two equations for α : β.
    fn on_quadric(&self, other: &DMat4) -> (Trig, f64) {
        let OnLines { a, b, c } = &self.on_lines;
        let form = self.lines.form(other);
        let [size_a, size_b, size_c] = self.on_lines.magnitudes();
        let [form_a, form_b, form_c] = form.magnitudes();
        let one_point = |factor: f64| {
            let squares = form.a.times(&b.times(b));
            let mixed = form.b.times(&a.times(b));
            let sum = squares.plus(-2.0 * factor, &mixed);
            let size = (form_a * size_b + form_b * size_a) * size_b + form_c * size_a * size_a;
            (sum.plus(factor * factor, &form.c.times(&a.times(a))), size)
        };
        match self.part {
            // α : β = -2 b : a, and -b : a.
            Part::Once => one_point(0.5),
            Part::Touching => one_point(1.0),
            Part::Around { .. } | Part::Between { .. } => {
                let minor =
                    |[p, q]: [&Trig; 2], [r, s]: [&Trig; 2]| p.times(s).plus(-1.0, &q.times(r));
                let ac = minor([a, c], [&form.a, &form.c]);
                let ab = minor([a, b], [&form.a, &form.b]);
                let bc = minor([b, c], [&form.b, &form.c]);
                let size_ac = size_a * form_c + size_c * form_a;
                let size_ab = size_a * form_b + size_b * form_a;
                let size_bc = size_b * form_c + size_c * form_b;
                (
                    ac.times(&ac).plus(-4.0, &ab.times(&bc)),
                    size_ac * size_ac + size_ab * size_bc,
                )
            }
        }
    }

    /// What vanishes where the curve meets a surface in whose equation above all terms
    /// cancel on every line: the surface contains one branch of the curve. If it is this
    /// one, on whose lines the two equations for α : β have the same only root, there is
    /// none. Else it is the other one, and this one meets the surface where both its
    /// roots on a line are common.
    fn beside_branch(&self, surface: &Surface) -> Option<(Trig, f64)> {
        if matches!(self.part, Part::Once | Part::Touching) {
            return None;
        }
        let OnLines { a, b, c } = &self.on_lines;
        let [size_a, size_b, size_c] = self.on_lines.magnitudes();
        if surface.is_plane() {
            // It meets a line once, or contains it.
            let [p, q] = self.lines.values(self.plane(surface));
            let sizes = [&p, &q].map(Trig::magnitude);
            let size = sizes[0].max(sizes[1]);
            return Some((if sizes[0] >= sizes[1] { p } else { q }, size));
        }
        // The minors of both equations are k u², 2 k u v and k v², and u and v are never
        // 0 together: k is what vanishes.
        let form = self.lines.form(&matrix(surface, self.origin, self.unit));
        let [form_a, form_b, form_c] = form.magnitudes();
        let minor = |[p, q]: [&Trig; 2], [r, s]: [&Trig; 2]| p.times(s).plus(-1.0, &q.times(r));
        let ab = minor([a, b], [&form.a, &form.b]);
        let bc = minor([b, c], [&form.b, &form.c]);
        let size = size_a * form_b + size_b * (form_a + form_c) + size_c * form_b;
        Some((ab.plus(1.0, &bc), size))
    }

    /// A plane in the coordinates of the lines.
    fn plane(&self, surface: &Surface) -> DVec4 {
        surface
            .linear
            .extend(surface.value(self.origin) / self.unit)
    }

    /// All places between two at which the curve may meet a surface, in order, and
    /// whether it may touch it there.
    pub fn candidates(
        &self,
        surface: &Surface,
        [start, end]: [f64; 2],
    ) -> Result<Vec<Candidate>, Along> {
        let (mut equation, mut size) = if surface.is_plane() {
            self.on_plane(self.plane(surface))
        } else {
            self.on_quadric(&matrix(surface, self.origin, self.unit))
        };
        if equation.magnitude() <= CANCELLED * size {
            (equation, size) = self.beside_branch(surface).ok_or(Along::Within)?;
            if equation.magnitude() <= CANCELLED * size {
                return Err(Along::Within);
            }
        }
        let nothing = (CANCELLED * equation.magnitude()).max(POLYNOMIAL * size);
        let mut roots = Roots::default();
        // Elsewhere it may be next to nothing for long.
        let lines = match (self.part, self.until) {
            (Part::Between { middle, half, .. }, _) => Some((middle, half)),
            (_, Some(until)) => Some((0.0, until)),
            _ => None,
        };
        match lines {
            Some((middle, half)) => {
                const MARGIN: f64 = 1.01;
                let range = [middle - MARGIN * half, middle + MARGIN * half];
                equation.roots_on(range, &Tolerance::everywhere(nothing), &mut roots);
            }
            None => equation.roots(nothing, &mut roots),
        }
        if roots.is_lost {
            return Err(Along::Beside);
        }
        let mut places: Vec<Candidate> = Vec::new();
        let mut add = |angle: f64, reach: f64| {
            for candidate in self.places(angle, reach) {
                let place = start + (candidate.place - start).rem_euclid(TAU);
                let at = |place| Candidate { place, ..candidate };
                places.push(at(place));
                // A stretch may reach beyond both ends of a piece.
                if reach > 0.0 && self.between.is_some() {
                    places.extend([place - TAU, place + TAU].map(at));
                }
            }
        };
        for &angle in &roots.simple {
            add(angle, 0.0);
        }
        for &angle in &roots.touching {
            add(angle, stretch_around(&equation, angle, nothing));
        }
        let is_within = |c: &Candidate| c.place + c.reach > start && c.place - c.reach < end;
        places.retain(is_within);
        // By where stretches begin: what overlaps any of those before overlaps the last.
        let stretch = |c: &Candidate| [c.place - c.reach, c.place + c.reach];
        places.sort_by(|a, b| stretch(a)[0].total_cmp(&stretch(b)[0]));
        places.dedup_by(|a, b| {
            let ([from, to], [low, high]) = (stretch(a), stretch(b));
            let is_same = from < high || a.place - b.place < SAME_ROOT * (end - start);
            if is_same && (a.reach > 0.0 || b.reach > 0.0) {
                let high = high.max(to);
                b.place = 0.5 * (low + high);
                b.reach = 0.5 * (high - low);
            }
            is_same
        });
        Ok(places)
    }

    /// Puts the places of known points in the place of all candidates that are where these are
    /// known.
    pub(in crate::arrangement) fn tell_apart(
        &self,
        candidates: &mut Vec<Candidate>,
        [start, end]: [f64; 2],
        known: &Known,
    ) {
        /// Points next to the end of where they are known may be candidates, too.
        const SLACK: f64 = 1.01;
        let Some(to_shares) = self.lines.to_shares() else {
            return;
        };
        *candidates = self.beyond(candidates, known.reach);
        let points = known.points.iter();
        let points = points.filter(|point| point.length() < SLACK * known.reach);
        candidates.extend(points.filter_map(|point| {
            let along = to_shares * ((point - self.origin) / self.unit).extend(1.0);
            let [beta, alpha, x, y] = along.to_array();
            let angle = elementary::atan2(y / alpha, x / alpha);
            let place = self.place(angle, [alpha, beta])?;
            let place = start + (place - start).rem_euclid(TAU);
            (place < end).then_some(Candidate { place, reach: 0.0 })
        }));
        candidates.sort_by(|a, b| a.place.total_cmp(&b.place));
        candidates.dedup_by(|a, b| a.place - b.place < SAME_ROOT * TAU && a.reach == b.reach);
    }

    /// What of candidates is farther from the origin than `reach`: of a stretch that is in part where
    /// the curve comes and goes, between which and another place all of that is.
    fn beyond(&self, candidates: &[Candidate], reach: f64) -> Vec<Candidate> {
        /// In which half a stretch is looked at.
        const PARTS: u32 = 8;
        let beyond = |t: f64| self.at(t).length() - reach;
        let mut found = Vec::new();
        for &stretch in candidates {
            let Candidate { place, reach } = stretch;
            let part = |k: u32| place + (f64::from(k) / f64::from(PARTS) - 1.0) * reach;
            let before = found.len();
            for ends in (0..2 * PARTS).map(|k| [part(k), part(k + 1)]) {
                let values = ends.map(beyond);
                if (values[0] <= 0.0) != (values[1] <= 0.0) {
                    let place = bracketed(beyond, ends, values);
                    found.push(Candidate { place, reach: 0.0 });
                }
            }
            if found.len() == before && beyond(place) > 0.0 {
                found.push(stretch);
            }
        }
        found
    }
}

/// How far around a place on both sides of it a function is as good as 0, or a little more.
fn stretch_around(function: &Trig, place: f64, nothing: f64) -> f64 {
    /// Of roots that cannot be told apart, in radians, and where there are no others.
    const LEAST: f64 = 1e-9;
    const MOST: f64 = 0.1;
    let mut reach = LEAST;
    let is_nothing = |t: f64| function.value(t).abs() <= nothing;
    while reach < MOST && (is_nothing(place - reach) || is_nothing(place + reach)) {
        reach *= 2.0;
    }
    reach
}
