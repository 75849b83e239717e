//! All roots of a smooth function on an interval, none of them missed.
//!
//! Intervals are halved until a bound on the second derivative tells that the
//! function has no root in them, or is monotonic and has as many as its signs
//! at the ends do (the exclusion test of interval bisection: Moore, *Interval
//! Analysis*, 1966).

use smallvec::SmallVec;

/// A place and the function's value there.
pub(super) type Sample = (f64, f64);

/// A place where a function may be 0, and whether it may be so without changing
/// its sign, or more than once.
pub(super) type Candidate = (f64, bool);

/// A function that is next to 0 on more than this share of an interval is on
/// all of it.
const LONG: f64 = 0.0625;

/// Where a function is 0.
#[derive(Debug, Default)]
pub(super) struct Roots {
    /// Where its sign changes.
    pub simple: Vec<f64>,
    /// Where it comes near 0, or changes sign more often than can be told.
    pub touching: Vec<f64>,
    /// Whether the function is next to 0 on a long stretch: then not all roots
    /// were looked for.
    pub is_lost: bool,
}

impl Roots {
    pub fn clear(&mut self) {
        self.simple.clear();
        self.touching.clear();
        self.is_lost = false;
    }

    /// Adds the roots between `start` and `end` of a function whose second
    /// derivative between two places is at most `bend` of them. Values below
    /// `tolerance` are rounding.
    pub fn find(
        &mut self,
        [start, end]: [f64; 2],
        value: impl Fn(f64) -> f64,
        bend: impl Fn(f64, f64) -> f64,
        tolerance: f64,
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
        let range = end - start;
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
            if !differ && least > off + tolerance {
                continue;
            }
            let is_monotonic = (at_b - at_a).abs() > bend * width * width;
            // Away from both ends by more than rounding, a root is safe.
            if is_monotonic && !differ && least > tolerance {
                continue;
            }
            if is_monotonic && differ {
                self.simple.push(bracketed(&value, [a, b], [at_a, at_b]));
                continue;
            }
            if is_monotonic || halvings == MOST_HALVINGS || off <= 0.1 * tolerance {
                // Of a function that rises or falls one end is next to 0, or all of it.
                let is_all = at_a.abs().max(at_b.abs()) <= tolerance;
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
        [start, end]: [f64; 2],
        value: impl Fn(f64) -> f64,
        tolerance: impl Fn(f64) -> f64,
    ) {
        let sample = |t: f64| (t, value(t));
        let is_negative = |sample: Sample| sample.1 <= 0.0;
        let mut before = start;
        let mut low = None;
        for (index, &(place, touches)) in places.iter().enumerate() {
            let after = places.get(index + 1).map_or(end, |next| next.0);
            let from = low.unwrap_or_else(|| sample(0.5 * (before + place)));
            let (here, to) = (sample(place), sample(0.5 * (place + after)));
            if is_negative(from) != is_negative(to) {
                let root = bracketed(&value, [from.0, to.0], [from.1, to.1]);
                self.simple.push(root);
                if touches && here.1.abs() <= tolerance(place) {
                    self.touching.push(root);
                }
            } else if here.1.abs() <= tolerance(place) {
                self.touching.push(place);
            } else if is_negative(from) != is_negative(here) {
                // Two that could not be told apart.
                for [a, b] in [[from, here], [here, to]] {
                    self.simple.push(bracketed(&value, [a.0, b.0], [a.1, b.1]));
                }
            }
            before = place;
            low = Some(to);
        }
    }

    /// Adds the place at which a function is nearest to 0 on a stretch on which
    /// it is next to 0.
    fn touch(&mut self, stretch: Option<[Sample; 2]>, value: impl Fn(f64) -> f64) {
        const STEPS: u32 = 40;
        let Some([(a, at_a), (b, at_b)]) = stretch else {
            return;
        };
        if (at_a <= 0.0) != (at_b <= 0.0) {
            let root = bracketed(&value, [a, b], [at_a, at_b]);
            self.simple.push(root);
            self.touching.push(root);
            return;
        }
        // The extremum, by golden sections.
        let (mut low, mut high) = (a, b);
        for _ in 0..STEPS {
            let [first, second] = [0.382, 0.618].map(|share| low + share * (high - low));
            if at_a.signum() * value(first) < at_a.signum() * value(second) {
                high = second;
            } else {
                low = first;
            }
        }
        self.touching.push(0.5 * (low + high));
    }
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
