//! All roots of a smooth function on an interval, none of them missed.
//!
//! Intervals are halved until a bound on the second derivative tells that the
//! function has no root in them, or is monotonic and has as many as its signs
//! at the ends do (the exclusion test of interval bisection: Moore, *Interval
//! Analysis*, 1966).

use glam::DVec3;
use smallvec::SmallVec;

use crate::elementary;
use crate::numeric::tolerance::{NEAR, TOUCHING};

/// A place and the function's value there.
pub(super) type Sample = (f64, f64);

/// A place where a function may be 0: once, or, on a stretch around it that reaches so far,
/// without changing its sign, or more than once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub place: f64,
    pub reach: f64,
}

impl Candidate {
    fn stretch(&self, [start, end]: [f64; 2]) -> [f64; 2] {
        [
            (self.place - self.reach).max(start),
            (self.place + self.reach).min(end),
        ]
    }
}

/// All points in some part of space that a curve may have in common with a surface.
#[derive(Clone, Debug, Default)]
pub(super) struct Known {
    pub points: SmallVec<[DVec3; 8]>,
    /// Nearer to the origin than this.
    pub reach: f64,
}

/// A function that crosses 0 touches it there if it is next to 0 so far to both sides, in
/// radians: at a smaller angle than surfaces that touch.
const FLAT: f64 = NEAR / TOUCHING;

/// A function that is next to 0 on more than this share of an interval is on
/// all of it.
const LONG: f64 = 0.0625;

/// Where a function is 0.
#[derive(Clone, Debug, Default)]
pub(super) struct Roots {
    /// Where its sign changes.
    pub simple: Vec<f64>,
    /// Where it comes near 0, or changes sign more often than can be told.
    pub touching: Vec<f64>,
    /// Whether the function is next to 0 on a long stretch: then not all roots
    /// were looked for.
    pub is_lost: bool,
}

/// Which values of a function are as good as 0, at a place and at most anywhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerance<F> {
    pub at: F,
    pub most: f64,
}

impl Tolerance<fn(f64) -> f64> {
    /// The same at all places.
    pub fn everywhere(value: f64) -> Tolerance<impl Fn(f64) -> f64> {
        Tolerance {
            at: move |_| value,
            most: value,
        }
    }
}

impl Roots {
    pub fn clear(&mut self) {
        self.simple.clear();
        self.touching.clear();
        self.is_lost = false;
    }

    /// Puts the touching places that were found after so many simple and touching ones where the
    /// function is 0 more than once ([`multiple_near`]), no farther off than `far` a step.
    pub fn tell_multiple(
        &mut self,
        [simple, touching]: [usize; 2],
        (nothing, far): (impl Fn(f64) -> f64, f64),
        derivative: impl Fn(usize, f64) -> f64,
    ) {
        for place in &mut self.touching[touching..] {
            let told = multiple_near(*place, [nothing(*place), far], &derivative);
            // Where the sign changes, too, it is both.
            let mut found = self.simple[simple..].iter_mut();
            if let Some(root) = found.find(|root| *root == place) {
                *root = told;
            }
            *place = told;
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.simple.is_empty() && self.touching.is_empty() && !self.is_lost
    }

    /// Forgets those beyond a range.
    pub fn keep_within(&mut self, [start, end]: [f64; 2]) {
        for roots in [&mut self.simple, &mut self.touching] {
            roots.retain(|&t| start <= t && t <= end);
        }
    }

    /// Adds the roots between `start` and `end`, which are part of a range that is so long, of a
    /// function whose second derivative between two places is at most `bend` of them. Values within
    /// `tolerance` are as good as 0.
    pub fn find_in_part(
        &mut self,
        [start, end]: [f64; 2],
        range: f64,
        value: impl Fn(f64) -> f64,
        bend: impl Fn(f64, f64) -> f64,
        tolerance: &Tolerance<impl Fn(f64) -> f64>,
    ) {
        const PARTS: u32 = 8;
        /// Halvings until roots that are still together are one.
        const MOST_HALVINGS: u32 = 40;
        /// Intervals after which there are too many places next to 0.
        const MOST_INTERVALS: u32 = 1 << 14;
        let at = |k: u32| {
            let t = start + f64::from(k) / f64::from(PARTS) * (end - start);
            let t = if k == PARTS { end } else { t };
            (t, value(t))
        };
        let samples: [Sample; PARTS as usize + 1] = std::array::from_fn(|k| at(k as u32));
        // The first on top, so that intervals are met in order.
        let mut pending: SmallVec<[(Sample, Sample, u32); 64]> = SmallVec::new();
        pending.extend(samples.windows(2).rev().map(|w| (w[0], w[1], 0)));
        let mut near: Option<[Sample; 2]> = None;
        let mut intervals = 0;
        while let Some((from, to, halvings)) = pending.pop() {
            intervals += 1;
            if intervals > MOST_INTERVALS {
                self.is_lost = true;
                return;
            }
            let ((a, at_a), (b, at_b)) = (from, to);
            let width = b - a;
            let bend = bend(a, b);
            let off = 0.125 * bend * width * width;
            let differ = (at_a <= 0.0) != (at_b <= 0.0);
            let least = at_a.abs().min(at_b.abs());
            if !differ && least > off + tolerance.most {
                continue;
            }
            let is_monotonic = (at_b - at_a).abs() > bend * width * width;
            if is_monotonic && differ {
                self.simple.push(bracketed(&value, [a, b], [at_a, at_b]));
                continue;
            }
            let [of_a, of_b] = [a, b].map(&tolerance.at);
            // What rises or falls is nearest to 0 at one end.
            let reach = match (is_monotonic, at_a.abs() <= at_b.abs()) {
                (false, _) => off + of_a.max(of_b),
                (true, true) => of_a,
                (true, false) => of_b,
            };
            if !differ && least > reach {
                continue;
            }
            if is_monotonic || halvings == MOST_HALVINGS || off <= 0.1 * of_a.min(of_b) {
                // Of a function that rises or falls one end is next to 0, or all of it.
                let is_all = at_a.abs() <= of_a && at_b.abs() <= of_b;
                let stretch = match is_monotonic && !is_all {
                    true if at_a.abs() <= at_b.abs() => [from, from],
                    true => [to, to],
                    false => [from, to],
                };
                near = Some(match near {
                    Some([first, last]) if last.0 == stretch[0].0 => [first, stretch[1]],
                    before => {
                        self.touch(before, &value);
                        stretch
                    }
                });
                if near.is_some_and(|[first, last]| last.0 - first.0 > LONG * range) {
                    self.is_lost = true;
                    return;
                }
                continue;
            }
            let middle = 0.5 * (a + b);
            let middle = (middle, value(middle));
            pending.push((middle, to, halvings + 1));
            pending.push((from, middle, halvings + 1));
        }
        self.touch(near, &value);
    }

    /// Adds the roots of a function that can be 0 at some places alone, given in
    /// order. Values below the tolerance at a place are rounding.
    pub fn find_at(
        &mut self,
        places: &[Candidate],
        range @ [start, end]: [f64; 2],
        value: impl Fn(f64) -> f64,
        tolerance: impl Fn(f64) -> f64,
    ) {
        let sample = |t: f64| (t, value(t));
        let mut before = start;
        let mut low = None;
        for (index, candidate) in places.iter().enumerate() {
            let stretch @ [first, last] = candidate.stretch(range);
            let after = places.get(index + 1).map_or(end, |c| c.stretch(range)[0]);
            let from = low.unwrap_or_else(|| sample(0.5 * (before + first)));
            let to = sample(0.5 * (last + after));
            if candidate.reach == 0.0 {
                self.find_between(&[from, sample(candidate.place), to], &value, &tolerance);
            } else {
                let ends = [from, to];
                self.find_on_stretch(ends, candidate.place, stretch, &value, &tolerance);
            }
            before = last;
            low = Some(to);
        }
    }

    /// Adds the root between the first and last of three places, if the sign changes, or
    /// the two on both sides of the middle one, or that one, if it is next to 0.
    fn find_between(
        &mut self,
        &[from, here, to]: &[Sample; 3],
        value: impl Fn(f64) -> f64,
        tolerance: impl Fn(f64) -> f64,
    ) {
        let is_negative = |sample: Sample| sample.1 <= 0.0;
        let mut root = |a: Sample, b: Sample| {
            self.simple.push(bracketed(&value, [a.0, b.0], [a.1, b.1]));
        };
        if is_negative(from) != is_negative(to) {
            root(from, to);
        } else if here.1.abs() <= tolerance(here.0) {
            self.touching.push(here.0);
        } else if is_negative(from) != is_negative(here) {
            root(from, here);
            root(here, to);
        }
    }

    /// Adds the roots on a stretch around a place on which they are too close to be told apart
    /// otherwise, and between it and samples on both sides.
    fn find_on_stretch(
        &mut self,
        [from, to]: [Sample; 2],
        place: f64,
        [first, last]: [f64; 2],
        value: impl Fn(f64) -> f64,
        tolerance: impl Fn(f64) -> f64,
    ) {
        /// So many parts are looked at: a curve of two quadrics meets a third one at most
        /// eight times.
        const PARTS: u32 = 16;
        let is_negative = |sample: &Sample| sample.1 <= 0.0;
        let is_nothing = |sample: &Sample| sample.1.abs() <= tolerance(sample.0);
        let step = (last - first) / f64::from(PARTS);
        let sample = |t: f64| (t, value(t));
        let mut samples: SmallVec<[Sample; 20]> = SmallVec::new();
        samples.push(from);
        samples.extend((0..=PARTS).map(|k| sample(first + f64::from(k) * step)));
        samples.push(to);
        let crosses = is_negative(&from) != is_negative(&to);
        if !crosses {
            let sign = from.1.signum();
            let inner = 1..samples.len() - 1;
            let nearest =
                inner.min_by(|&a, &b| (sign * samples[a].1).total_cmp(&(sign * samples[b].1)));
            let nearest = nearest.unwrap_or(1);
            let around = [samples[nearest - 1].0, samples[nearest + 1].0];
            let extreme = sample(extremum(around, sign, &value));
            let is_beyond = |sample: &Sample| sign * sample.1 < 0.0 && !is_nothing(sample);
            if !is_beyond(&extreme) && !is_beyond(&samples[nearest]) {
                // The equation tells best where it touches.
                let touching = [sample(place), extreme].into_iter().find(is_nothing);
                self.touching.extend(touching.map(|(t, _)| t));
                return;
            }
            if sign * extreme.1 < sign * samples[nearest].1 {
                samples[nearest] = extreme;
            }
        }
        let ends: SmallVec<[[Sample; 2]; 8]> = samples
            .windows(2)
            .filter(|w| is_negative(&w[0]) != is_negative(&w[1]))
            .map(|w| [w[0], w[1]])
            .collect();
        let root = |[a, b]: &[Sample; 2]| bracketed(&value, [a.0, b.0], [a.1, b.1]);
        let (Some(one), Some(other)) = (ends.first(), ends.last()) else {
            return;
        };
        let between = samples
            .iter()
            .filter(|s| one[1].0 <= s.0 && s.0 <= other[0].0);
        if !crosses || ends.len() > 1 && !between.into_iter().all(is_nothing) {
            self.simple.extend(ends.iter().map(root));
            return;
        }
        let root = root(&ends[ends.len() / 2]);
        self.simple.push(root);
        if [root - FLAT, root + FLAT]
            .map(sample)
            .iter()
            .all(|s| s.1.abs() <= tolerance(root))
        {
            self.touching.push(root);
        }
    }

    /// Adds the place at which a function is nearest to 0 on a stretch on which
    /// it is next to 0.
    fn touch(&mut self, stretch: Option<[Sample; 2]>, value: impl Fn(f64) -> f64) {
        let Some([(a, at_a), (b, at_b)]) = stretch else {
            return;
        };
        if (at_a <= 0.0) != (at_b <= 0.0) {
            let root = bracketed(&value, [a, b], [at_a, at_b]);
            self.simple.push(root);
            self.touching.push(root);
            return;
        }
        self.touching.push(extremum([a, b], at_a.signum(), value));
    }
}

/// The place near `start` at which a function is 0 more than once, as far as values below `nothing`
/// tell, by Newton's method: a root of its first derivative; or of the second or third one, if
/// more of what keeps it so near to 0 is of a root of multiplicity three or four, as of that
/// derivative alone it is a simple one. If steps are longer than `far`, the start itself.
fn multiple_near(
    start: f64,
    [nothing, far]: [f64; 2],
    derivative: impl Fn(usize, f64) -> f64,
) -> f64 {
    const STEPS: u32 = 4;
    // How far around it the function is next to nothing, if all but one derivative were 0.
    let mut factorial = 1.0;
    let reaches = [2usize, 3, 4].map(|order| {
        factorial *= order as f64;
        let term = derivative(order, start).abs() / factorial;
        (elementary::pow(nothing / term, 1.0 / order as f64), order)
    });
    let least = reaches.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let order = least.map_or(2, |(_, order)| order);
    let mut t = start;
    for _ in 0..STEPS {
        let step = derivative(order - 1, t) / derivative(order, t);
        if step.is_nan() || step.abs() >= far {
            return start;
        }
        t -= step;
    }
    t
}

/// Where a function of a sign is nearest to 0, or farthest beyond, by golden sections.
fn extremum([mut low, mut high]: [f64; 2], sign: f64, value: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 40;
    for _ in 0..STEPS {
        let [first, second] = [0.382, 0.618].map(|share| low + share * (high - low));
        if sign * value(first) < sign * value(second) {
            high = second;
        } else {
            low = first;
        }
    }
    0.5 * (low + high)
}

/// A bound on a second derivative in an interval: what it is at most anywhere, and
/// where that is less, what a bound on the third one permits. Where surfaces have
/// more than a tangent in common, both are next to 0 and the second one is far
/// below its bound.
pub(super) fn bend_within(
    [from, to]: [f64; 2],
    most: f64,
    second: impl Fn(f64) -> f64,
    third: f64,
) -> f64 {
    let half = 0.5 * (to - from);
    if half * third > 0.1 * most {
        return most;
    }
    most.min(second(from + half).abs() + half * third)
}

/// The root between two places of different sign, by the method of Ridders (*A
/// New Algorithm for Computing a Single Root of a Real Continuous Function*,
/// 1979).
pub(super) fn bracketed(
    value: impl Fn(f64) -> f64,
    [mut a, mut b]: [f64; 2],
    ends: [f64; 2],
) -> f64 {
    const MOST_STEPS: u32 = 60;
    let [mut at_a, mut at_b] = ends;
    let mut best = if at_a.abs() < at_b.abs() { a } else { b };
    for _ in 0..MOST_STEPS {
        let middle = 0.5 * (a + b);
        if at_a == 0.0 {
            return a;
        }
        if at_b == 0.0 {
            return b;
        }
        if middle <= a || middle >= b {
            break;
        }
        let at_middle = value(middle);
        let root = (at_middle * at_middle - at_a * at_b).sqrt();
        let new = middle + (middle - a) * (at_a - at_b).signum() * at_middle / root;
        if !new.is_finite() || at_middle == 0.0 {
            return middle;
        }
        let new = new.clamp(a, b);
        let at_new = value(new);
        let done = (new - best).abs() <= 2.0 * f64::EPSILON * (b.abs() + a.abs());
        best = new;
        if at_new == 0.0 || done {
            break;
        }
        let ([low, high], [at_low, at_high]) = if new < middle {
            ([new, middle], [at_new, at_middle])
        } else {
            ([middle, new], [at_middle, at_new])
        };
        // Of the three intervals the one where the sign changes.
        let is_negative = |v: f64| v <= 0.0;
        if is_negative(at_low) != is_negative(at_high) {
            (a, b, at_a, at_b) = (low, high, at_low, at_high);
        } else if is_negative(at_a) != is_negative(at_low) {
            (b, at_b) = (low, at_low);
        } else {
            (a, at_a) = (high, at_high);
        }
    }
    best
}
