//! Surfaces that cross or touch curves of degree four: every root is found, as
//! halving the intervals between many samples finds it.

use glam::DVec3;

use super::curve::Curve;
use super::intersection::Nearness;
use super::pairs::curves;
use super::pairs::tests::{equal_but_for_digits, quadric};
use super::roots::Roots;
use super::rulings::Rulings;
use crate::program::Surface;
use crate::random::Random;

const NEAR: f64 = 1e-9;

/// A curve of degree four and where on it roots are looked for.
struct Stretch {
    curve: Curve,
    range: [f64; 2],
}

impl Stretch {
    /// All those of two quadrics, as far as they are within a reach of 3.
    fn of(surfaces: &[Surface; 2]) -> Vec<Self> {
        let branches = curves(&surfaces[0], &surfaces[1], Nearness::of(NEAR)).unwrap_or_default();
        let curves = branches.into_iter().map(|branch| branch.curve);
        let within = |curve: Curve| {
            let range = curve.range(DVec3::ZERO, 3.0)?;
            matches!(curve, Curve::Rulings(_)).then_some(Self { curve, range })
        };
        curves.filter_map(within).collect()
    }

    fn rulings(&self) -> &Rulings {
        match &self.curve {
            Curve::Rulings(rulings) => rulings,
            other => panic!("{other:?}"),
        }
    }

    /// In homogeneous coordinates, where nothing is infinite.
    fn value(&self, surface: &Surface, t: f64) -> f64 {
        let (at, weight) = self.rulings().weighted(t);
        let power = if surface.is_plane() { 1 } else { 2 };
        surface.value(at) * weight.powi(power)
    }

    fn at(&self, share: f64) -> f64 {
        let [start, end] = self.range;
        start + share * (end - start)
    }

    fn roots(&self, surface: &Surface) -> Roots {
        let mut roots = Roots::default();
        let candidates = self.rulings().candidates(surface, self.range);
        let candidates = candidates.expect("no branch runs along a random surface");
        let slope = surface.gradient(self.curve.at(self.at(0.5))).length();
        let value = |t: f64| self.value(surface, t);
        roots.find_at(&candidates, self.range, value, |_| NEAR * slope);
        roots.simple.sort_by(f64::total_cmp);
        roots
    }

    /// The root between two places of different sign, by bisection.
    fn bisect(&self, surface: &Surface, [mut low, mut high]: [f64; 2]) -> f64 {
        let is_negative = self.value(surface, low) <= 0.0;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if (self.value(surface, middle) <= 0.0) == is_negative {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// The roots between samples of different sign.
    fn sampled(&self, surface: &Surface) -> Vec<f64> {
        const SAMPLES: u32 = 4000;
        let places = (0..=SAMPLES).map(|k| self.at(f64::from(k) / f64::from(SAMPLES)));
        let samples: Vec<(f64, bool)> =
            places.map(|t| (t, self.value(surface, t) <= 0.0)).collect();
        samples
            .windows(2)
            .filter(|pair| pair[0].1 != pair[1].1)
            .map(|pair| self.bisect(surface, [pair[0].0, pair[1].0]))
            .collect()
    }
}

fn point(random: &mut Random) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0))
}

/// A plane or a quadric.
fn surface(random: &mut Random) -> Surface {
    if random.below(2) == 0 {
        return quadric(random);
    }
    Surface::plane(0.5 * point(random), point(random).normalize())
}

/// A surface moved and bent so that its value at a place on a curve is `value`, and
/// its gradient there at right angles to the curve.
fn tangent(surface: &Surface, stretch: &Stretch, t: f64, value: f64) -> Surface {
    let at = stretch.curve.at(t);
    let along = stretch.curve.direction(t).normalize();
    let mut moved = *surface;
    moved.linear -= surface.gradient(at).dot(along) * along;
    if moved.is_plane() {
        moved.linear = moved.linear.normalize();
    }
    moved.constant += value - moved.value(at);
    moved
}

/// Visits a place on each curve of many random pairs of quadrics, unless it is far
/// away or the curve turns back there.
fn on_random_curves(seed: u64, mut visit: impl FnMut(&Stretch, f64, &mut Random)) {
    let mut random = Random(seed);
    for _ in 0..400 {
        let pair = [quadric(&mut random), quadric(&mut random)];
        for stretch in Stretch::of(&pair) {
            let t = stretch.at(0.1 + 0.8 * random.unit());
            let (at, direction) = (stretch.curve.at(t), stretch.curve.direction(t));
            if at.length() > 2.0 || direction.length() < 1e-9 {
                continue;
            }
            visit(&stretch, t, &mut random);
        }
    }
}

fn has(found: &[f64], wanted: f64, within: f64) -> bool {
    found.iter().any(|root| (root - wanted).abs() <= within)
}

#[test]
fn roots_on_curves_of_degree_four_are_those_between_samples() {
    let mut random = Random(3);
    check_roots(3, || [quadric(&mut random), quadric(&mut random)]);
}

#[test]
fn roots_on_curves_in_two_planes_but_for_little_are_those_between_samples() {
    let mut random = Random(4);
    check_roots(5, || equal_but_for_digits(&mut random));
}

fn check_roots(seed: u64, mut next: impl FnMut() -> [Surface; 2]) {
    let mut random = Random(seed);
    let (mut stretches, mut wanted_roots) = (0, 0);
    for case in 0..400 {
        let pair = next();
        for stretch in Stretch::of(&pair) {
            let third = surface(&mut random);
            let found = stretch.roots(&third);
            stretches += 1;
            let wanted = stretch.sampled(&third);
            wanted_roots += wanted.len();
            for &root in &wanted {
                assert!(
                    has(&found.simple, root, 1e-9),
                    "case {case}: {root} is missing in {:?}",
                    found.simple
                );
            }
            // Those that are not between samples come in pairs, and are roots.
            assert_eq!(found.simple.len() % 2, wanted.len() % 2, "case {case}");
            for &root in &found.simple {
                let step = 1e-7;
                let [before, after] =
                    [root - step, root + step].map(|t| stretch.value(&third, t) <= 0.0);
                assert!(before != after, "case {case}: no root at {root}");
            }
        }
    }
    assert!(
        stretches > 400 && wanted_roots > 600,
        "{stretches} {wanted_roots}"
    );
}

#[test]
fn surfaces_that_touch_curves_of_degree_four_are_found() {
    let mut touched = 0;
    on_random_curves(5, |stretch, t, random| {
        let third = tangent(&surface(random), stretch, t, 0.0);
        let found = stretch.roots(&third);
        touched += 1;
        // Where it touches the value is rounding within 1e-6 of it, and more.
        let near = [&found.touching, &found.simple].map(|roots| has(roots, t, 1e-4));
        assert!(near.contains(&true), "{t} is missing in {found:?}");
        for root in stretch.sampled(&third) {
            let is_found = has(&found.simple, root, 1e-9) || (root - t).abs() < 1e-4;
            assert!(is_found, "{root} is missing in {found:?}");
        }
    });
    assert!(touched > 300, "{touched}");
}

/// Two roots next to each other, far closer than any samples.
#[test]
fn close_pairs_of_roots_on_curves_of_degree_four_are_told_apart() {
    let mut pairs = 0;
    on_random_curves(9, |stretch, t, random| {
        let base = surface(random);
        for half in [1e-2, 1e-3, 1e-4] {
            // The value half the distance away, where it grows with the square.
            let touching = tangent(&base, stretch, t, 0.0);
            let [left, right] = [t - half, t + half].map(|t| stretch.value(&touching, t));
            let is_even = left * right > 0.0 && (left / right - 1.0).abs() < 0.3;
            let weight = stretch.rulings().weighted(t).1;
            let power = if base.is_plane() { 1 } else { 2 };
            let drop = 0.5 * left / weight.powi(power);
            if !is_even || drop.abs() < 1e3 * NEAR {
                continue;
            }
            let third = tangent(&base, stretch, t, -drop);
            let brackets = [[t - half, t], [t, t + half]];
            let sign = |t: f64| stretch.value(&third, t) <= 0.0;
            if brackets.iter().any(|b| sign(b[0]) == sign(b[1])) {
                continue;
            }
            pairs += 1;
            let found = stretch.roots(&third);
            for bracket in brackets {
                let root = stretch.bisect(&third, bracket);
                assert!(
                    has(&found.simple, root, 1e-8),
                    "{half}: {root} is missing in {found:?}"
                );
            }
        }
    });
    assert!(pairs > 300, "{pairs}");
}

/// A quadric with a plane that contains a tangent of a conic of it, counted twice,
/// has four points in common with the conic where that touches it.
#[test]
fn contacts_of_fourth_order_are_found() {
    let mut random = Random(9);
    let mut found = 0;
    for case in 0..400 {
        let quadric = quadric(&mut random);
        let mut number = || 2.0 * random.unit() - 1.0;
        let mut vector = || DVec3::new(number(), number(), number());
        let plane = Surface::plane(quadric.anchor + 0.3 * vector(), vector().normalize());
        let across = vector();
        for branch in curves(&plane, &quadric, Nearness::of(NEAR)).unwrap_or_default() {
            let curve = branch.curve;
            let Some(range) = curve.range(DVec3::ZERO, 2.0) else {
                continue;
            };
            if matches!(curve, Curve::Line { .. }) {
                continue;
            }
            let t = range[0] + 0.43 * (range[1] - range[0]);
            let (at, tangent) = (curve.at(t), curve.direction(t).normalize());
            let normal = across.reject_from(tangent).normalize();
            let is_small = curve.at(range[0]).distance(at) < 0.2;
            let is_straight = curve.direction(range[0]).normalize().dot(tangent).abs() > 0.95;
            if is_small
                || is_straight
                || normal.cross(plane.linear).length() < 0.2
                || at.length() > 2.0
            {
                continue;
            }
            found += 1;
            let [x, y, z] = normal.to_array();
            let square = [x * x, y * y, z * z, 2.0 * x * y, 2.0 * y * z, 2.0 * z * x];
            let offset = normal.dot(quadric.anchor - at);
            let other = Surface::of_terms(
                quadric.anchor,
                std::array::from_fn(|k| quadric.quadratic[k] + 0.7 * square[k]),
                quadric.linear + 1.4 * offset * normal,
                quadric.constant + 0.7 * offset * offset,
            );
            let mut roots = Roots::default();
            curve.meet(&other, range, [1e-12, NEAR], &mut roots);
            assert!(!roots.is_lost, "case {case}");
            let all = roots.simple.iter().chain(&roots.touching);
            let off = all.clone().map(|&t| curve.at(t).distance(at));
            assert!(off.clone().count() > 0, "case {case}");
            let farthest = off.fold(0.0, f64::max);
            assert!(farthest < 0.1, "case {case}: {farthest} {roots:?}");
        }
    }
    assert!(found > 200, "{found}");
}

/// Where a curve crosses the middle of a thin plate it crosses both its faces, however near
/// to each other they are, and touches neither.
#[test]
fn curves_cross_both_faces_of_a_plate() {
    let mut random = Random(12);
    let mut crossed = 0;
    for case in 0..400 {
        let pair = [quadric(&mut random), quadric(&mut random)];
        let mut number = || 2.0 * random.unit() - 1.0;
        let mut vector = || DVec3::new(number(), number(), number());
        let plane = Surface::plane(pair[0].anchor + 0.3 * vector(), vector().normalize());
        let (center, normal) = (0.3 * vector(), vector().normalize());
        let half = 10f64.powf(-3.2 + 1.1 * number());
        let across = normal.any_orthonormal_vector();
        let axes = [across / 1.5, normal.cross(across) / 1.2, normal / half];
        let sum = |i: usize, j: usize| axes.iter().map(|a| a[i] * a[j]).sum::<f64>();
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
        let square = pairs.map(|(i, j)| if i == j { 1.0 } else { 2.0 } * sum(i, j));
        let square = square.map(|entry| half * half * entry);
        let plate = Surface::of_terms(center, square, DVec3::ZERO, -half * half);
        let middle = Surface::plane(center, normal);
        let found = [
            curves(&pair[0], &pair[1], Nearness::of(NEAR)),
            curves(&plane, &pair[0], Nearness::of(NEAR)),
        ];
        for branch in found.into_iter().flat_map(Result::unwrap_or_default) {
            let curve = branch.curve;
            let Some(range) = curve.range(DVec3::ZERO, 3.0) else {
                continue;
            };
            let meet = |surface: &Surface| {
                let mut roots = Roots::default();
                curve.meet(surface, range, [1e-12, NEAR], &mut roots);
                roots
            };
            let of_plate = meet(&plate);
            for t in meet(&middle).simple {
                let (at, sine) = (curve.at(t), curve.direction(t).normalize().dot(normal));
                let [x, y, _] = axes.map(|axis| axis.dot(at - center));
                // Far from its rim, at no small angle, and where the curve hardly turns.
                let turn =
                    [-3.0, 3.0].map(|off| curve.direction(t + off * half / sine).normalize());
                if x.hypot(y) > 0.8 || sine.abs() < 0.3 || turn[0].dot(turn[1]) < 0.99 {
                    continue;
                }
                crossed += 1;
                let near = |roots: &[f64]| {
                    let is_near = |t: &&f64| curve.at(**t).distance(at) < 1.5 * half / sine.abs();
                    roots.iter().filter(is_near).count()
                };
                let counts = [near(&of_plate.simple), near(&of_plate.touching)];
                assert_eq!(counts, [2, 0], "case {case}: {half} {curve:?} {plate:?}");
            }
        }
    }
    assert!(crossed > 300, "{crossed}");
}
