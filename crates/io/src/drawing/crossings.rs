//! Where two curves cross as they are seen.

use glam::DVec2;

use super::seen::Seen;

/// Of the drawing's size: points as near are one.
pub(super) const NEAR: f64 = 1e-8;

/// Of the drawing's size: parts of curves that touch are looked at down to this length.
pub(super) const SHORT: f64 = 1e-6;

/// No pair of curves takes more boxes: such run along each other.
const MOST_BOXES: usize = 20_000;

/// Adds where two curves cross or touch, and where one ends on the other, to the places of each
/// at which what is seen may change. More places do no harm.
pub(super) fn cross(
    one: &Seen,
    other: &Seen,
    size: f64,
    [places, other_places]: [&mut Vec<f64>; 2],
) {
    let near = NEAR * size;
    if are_apart(one.bounds, other.bounds, near) {
        return;
    }
    for (a, b, places) in [(one, other, &mut *places), (other, one, &mut *other_places)] {
        for end in b.range {
            let (t, off) = a.nearest(b.at(end));
            if off <= near {
                places.push(t);
            }
        }
    }
    if run_along(one, other, near) || run_along(other, one, near) {
        return;
    }
    let short = SHORT * size;
    let mut touching: Vec<[f64; 2]> = Vec::new();
    let mut boxes = Vec::new();
    for part in parts(one) {
        boxes.extend(parts(other).map(|other| [part, other]));
    }
    let mut count = boxes.len();
    while let Some([a, b]) = boxes.pop() {
        let [chord, other_chord] = [Chord::of(one, a), Chord::of(other, b)];
        if chord.misses(&other_chord, near) || other_chord.misses(&chord, near) {
            continue;
        }
        if chord.reach() <= short && other_chord.reach() <= short {
            touching.push([a, b].map(|[from, to]| 0.5 * (from + to)));
            continue;
        }
        if chord.crosses_clearly(&other_chord) {
            if let Some([s, t]) = newton([one, other], [a, b]) {
                places.push(s);
                other_places.push(t);
            }
            continue;
        }
        count += 2;
        if count > MOST_BOXES {
            break;
        }
        if chord.reach() >= other_chord.reach() {
            let middle = 0.5 * (a[0] + a[1]);
            boxes.extend([[[a[0], middle], b], [[middle, a[1]], b]]);
        } else {
            let middle = 0.5 * (b[0] + b[1]);
            boxes.extend([[a, [b[0], middle]], [a, [middle, b[1]]]]);
        }
    }
    for [s, t] in middles(one, touching, short) {
        places.push(s);
        other_places.push(t);
    }
}

/// Where curves touch they are near each other for a while: of each such stretch the middle, by
/// the places in it.
fn middles(one: &Seen, mut touching: Vec<[f64; 2]>, short: f64) -> Vec<[f64; 2]> {
    touching.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let goes_on = |a: &[f64; 2], b: &[f64; 2]| one.at(a[0]).distance(one.at(b[0])) <= 4.0 * short;
    let stretches = touching.chunk_by(goes_on);
    stretches
        .map(|stretch| stretch[stretch.len() / 2])
        .collect()
}

fn parts(curve: &Seen) -> impl Iterator<Item = [f64; 2]> + '_ {
    let [from, to] = curve.range;
    let count = curve.first_parts();
    let at = move |k: u32| from + (to - from) * f64::from(k) / f64::from(count);
    (0..count).map(move |k| [at(k), at(k + 1)])
}

fn are_apart(one: [DVec2; 2], other: [DVec2; 2], near: f64) -> bool {
    (one[0] - near).cmpgt(other[1]).any() || (other[0] - near).cmpgt(one[1]).any()
}

/// Whether all of a curve lies on another one.
fn run_along(short: &Seen, long: &Seen, near: f64) -> bool {
    let [from, to] = short.range;
    let is_on = |share: f64| long.nearest(short.at(from + share * (to - from))).1 <= near;
    let inner = [0.13, 0.38, 0.5, 0.71, 0.92];
    if inner.into_iter().all(is_on) {
        return true;
    }
    // Lines that overlap in part.
    if short.is_straight && long.is_straight {
        let side = long.at(long.range[1]) - long.at(long.range[0]);
        let off = |t: f64| {
            (short.at(t) - long.at(long.range[0])).perp_dot(side).abs() / side.length() <= near
        };
        return short.range.into_iter().all(off);
    }
    false
}

/// A part of a curve as a chord, and how far it strays from that.
struct Chord {
    ends: [DVec2; 2],
    stray: f64,
}

impl Chord {
    fn of(curve: &Seen, [from, to]: [f64; 2]) -> Self {
        // A line's is exact.
        let bend = if curve.is_straight { 0.0 } else { curve.bend };
        Self {
            ends: [curve.at(from), curve.at(to)],
            stray: 0.125 * bend * (to - from) * (to - from),
        }
    }

    fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }

    fn reach(&self) -> f64 {
        self.length() + self.stray
    }

    /// Whether another one is on one side of this one, or beyond its ends.
    fn misses(&self, other: &Self, near: f64) -> bool {
        let apart = self.stray + other.stray + near;
        let [from, to] = self.ends;
        let length = self.length();
        let along = if length > 0.0 {
            (to - from) / length
        } else {
            DVec2::X
        };
        let [a, b] = other.ends.map(|end| end - from);
        let [high, low] = [a.perp_dot(along), b.perp_dot(along)];
        if high.min(low) > apart || high.max(low) < -apart {
            return true;
        }
        let [a, b] = [a.dot(along), b.dot(along)];
        a.min(b) > length + apart || a.max(b) < -apart
    }

    /// Whether both are nearly straight and not nearly parallel.
    fn crosses_clearly(&self, other: &Self) -> bool {
        const STRAIGHT: f64 = 0.02;
        const SINE: f64 = 0.15;
        let [a, b] = [self.ends[1] - self.ends[0], other.ends[1] - other.ends[0]];
        let lengths = a.length() * b.length();
        self.stray <= STRAIGHT * a.length()
            && other.stray <= STRAIGHT * b.length()
            && a.perp_dot(b).abs() >= SINE * lengths
    }
}

/// Where two parts that are nearly straight cross, by Newton's method.
fn newton(curves: [&Seen; 2], parts: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let mut at = parts.map(|[from, to]| 0.5 * (from + to));
    for _ in 0..8 {
        let gap = curves[1].at(at[1]) - curves[0].at(at[0]);
        let [a, b] = [curves[0].slope(at[0]), curves[1].slope(at[1])];
        let area = a.perp_dot(b);
        if area == 0.0 {
            return None;
        }
        at[0] += gap.perp_dot(b) / area;
        at[1] += gap.perp_dot(a) / area;
    }
    // (Neighbours find the same point, if it is where they meet.)
    let is_within = |t: f64, [from, to]: [f64; 2]| {
        let slack = 1e-3 * (to - from);
        t >= from - slack && t <= to + slack
    };
    (is_within(at[0], parts[0]) && is_within(at[1], parts[1])).then_some(at)
}
