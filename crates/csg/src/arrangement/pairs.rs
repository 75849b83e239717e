//! The curves in which two surfaces meet.

use super::coaxial::circles;
use super::conic::conic;
use super::curve::{Branch, Branches, Curve};
use super::intersection::{Nearness, Unknown, line};
use super::{parallel, pencil};
use crate::numeric::tolerance::{CANCELLED, NEAR};
use crate::program::{Kind, Surface};

/// The curves common to two surfaces: two planes meet in a line, a plane and a
/// quadric in conics, and two quadrics in curves of degree four (see
/// [`pencil`]) or, if their quadratic parts agree, in a plane; of one axis, in circles, and
/// cylinders along one direction in lines. Surfaces that
/// come nearer to each other than `near` without crossing touch.
pub(super) fn curves(a: &Surface, b: &Surface, nearness: Nearness) -> Result<Branches, Unknown> {
    if a.is_plane() && b.is_plane() {
        return Ok(line(a, b).into_iter().map(Branch::new).collect());
    }
    if a.is_plane() {
        return conic(a, b, nearness);
    }
    if b.is_plane() {
        return conic(b, a, nearness);
    }
    if let Some(plane) = radical_plane(a, b) {
        return plane.map_or(Ok(Branches::new()), |plane| conic(&plane, a, nearness));
    }
    if let Some(circles) = circles(a, b, nearness) {
        return Ok(circles);
    }
    if let Some(lines) = parallel::lines(a, b, nearness) {
        return Ok(lines);
    }
    let branches = pencil::curves(a, b, nearness)?;
    // Those of degree four pass at infinity where the lines of a saddle are, or where planes that a
    // hyperbolic cylinder comes near cut what goes on to infinity, too: where others cross them
    // there is not told reliably.
    let is = |kind: Kind| a.kind == kind || b.kind == kind;
    let is_open = a.kind.is_indefinite() && b.kind.is_indefinite();
    let is_doubtful = is(Kind::HyperbolicParaboloid) || is_open && is(Kind::HyperbolicCylinder);
    let is_straight_or_conic = |branch: &Branch| !matches!(branch.curve, Curve::Rulings(_));
    if is_doubtful && !branches.iter().all(is_straight_or_conic) {
        return Err(Unknown::NoForm);
    }
    Ok(branches)
}

/// The plane in which two quadrics of the same quadratic part, but for a factor,
/// meet. The inner option is none where they are parallel or the same.
#[allow(clippy::option_option)]
fn radical_plane(a: &Surface, b: &Surface) -> Option<Option<Surface>> {
    let dot = |p: &Surface, q: &Surface| -> f64 {
        p.quadratic
            .iter()
            .zip(q.quadratic)
            .map(|(p, q)| p * q)
            .sum()
    };
    let factor = dot(a, b) / dot(b, b);
    let rest = a.quadratic.iter().zip(b.quadratic);
    if rest
        .map(|(a, b)| (a - factor * b).abs())
        .fold(0.0, f64::max)
        > CANCELLED
    {
        return None;
    }
    // Linear: the same gradient everywhere.
    let at = 0.5 * (a.anchor + b.anchor);
    let gradient = a.gradient(at) - factor * b.gradient(at);
    let value = a.value(at) - factor * b.value(at);
    let length = gradient.length();
    let terms = a.gradient(at).length() + factor.abs() * b.gradient(at).length();
    if length <= NEAR * terms.max(f64::MIN_POSITIVE) {
        return Some(None);
    }
    Some(Some(Surface::plane(
        at - value / (length * length) * gradient,
        gradient / length,
    )))
}

#[cfg(test)]
pub(super) mod tests {
    use glam::{DMat3, DVec3};

    use super::super::conic::conics;
    use super::*;
    use crate::numeric::tolerance::NEAR;
    use crate::random::Random;
    use crate::surface::solve;

    fn turn(random: &mut Random) -> DMat3 {
        let [x, y, z] = [(); 3].map(|()| 6.0 * random.unit());
        DMat3::from_euler(glam::EulerRot::XYZ, x, y, z)
    }

    /// A quadric of any kind about the origin, turned.
    pub fn quadric(random: &mut Random) -> Surface {
        let turn = turn(random);
        let mut number = |low: f64, high: f64| low + (high - low) * random.unit();
        let (a, b, c) = (number(0.3, 1.0), number(0.3, 1.0), number(0.2, 1.0));
        let (values, slope, constant) = match number(0.0, 6.0) as u32 {
            0 => ([1.0, a, b], 0.0, -c),
            1 => ([1.0, a, 0.0], 0.0, -c),
            2 => ([1.0, a, -b], 0.0, 0.0),
            3 => ([1.0, a, -b], 0.0, -c),
            4 => ([1.0, a, -b], 0.0, c),
            _ => ([1.0, a, 0.0], b, 0.0),
        };
        let center = DVec3::new(number(-0.5, 0.5), number(-0.5, 0.5), number(-0.5, 0.5));
        of_axes(center, turn, values, (slope, constant))
    }

    /// A quadric by the squares of its axes, turned; linear along the last of them.
    fn of_axes(
        center: DVec3,
        turn: DMat3,
        values: [f64; 3],
        (slope, constant): (f64, f64),
    ) -> Surface {
        let form = turn * DMat3::from_diagonal(values.into()) * turn.transpose();
        let entry = |i: usize, j: usize| form.col(j)[i];
        Surface::of_terms(
            center,
            [
                entry(0, 0),
                entry(1, 1),
                entry(2, 2),
                2.0 * entry(0, 1),
                2.0 * entry(1, 2),
                2.0 * entry(2, 0),
            ],
            slope * turn.z_axis,
            constant,
        )
    }

    /// How far a point is from a curve.
    fn distance(curve: &Curve, point: DVec3) -> f64 {
        const SAMPLES: u32 = 400;
        let Some([start, end]) = curve.range(DVec3::ZERO, 3.0) else {
            return f64::INFINITY;
        };
        let step = (end - start) / f64::from(SAMPLES);
        let off = |t: f64| curve.at(t).distance(point);
        let mut nearest = f64::INFINITY;
        for k in 0..SAMPLES {
            let (mut low, mut high) =
                (start + f64::from(k) * step, start + f64::from(k + 1) * step);
            // Next to a pole chords are long.
            let chord = curve.at(low).distance(curve.at(high));
            if off(low).min(off(high)) > chord {
                continue;
            }
            for _ in 0..60 {
                let (a, b) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
                if off(a) < off(b) {
                    high = b;
                } else {
                    low = a;
                }
            }
            nearest = nearest.min(off(0.5 * (low + high)));
        }
        nearest
    }

    #[test]
    fn planes_cut_a_saddle_in_two_curves_also_where_they_touch_it() {
        let surface = |quadratic, linear, constant| {
            Surface::of_terms(DVec3::ZERO, quadratic, linear, constant)
        };
        let saddle = surface([1.0, 1.0, -1.0, 0.0, 0.0, 0.0], DVec3::ZERO, -1.0);
        for (x, nodes) in [(1.0, 1), (0.5, 0), (1.5, 0)] {
            let plane = Surface {
                anchor: x * DVec3::X,
                ..surface([0.0; 6], DVec3::X, 0.0)
            };
            let found = curves(&plane, &saddle, Nearness::of(1e-9)).expect("they are known");
            assert_eq!(found.len(), 2, "{x}");
            for branch in &found {
                assert_eq!(branch.nodes.len(), nodes, "{x}");
                for t in [-0.7, 0.0, 0.4] {
                    let at = branch.curve.at(t);
                    assert!(solve::residual([&plane, &saddle].into_iter(), at) < 1e-14);
                }
            }
        }
    }

    /// One a little longer along an axis, as rounded matrices make it.
    #[test]
    fn curves_of_balls_that_are_none_by_little_are_known() {
        let ball = |center: DVec3, along: f64| {
            Surface::of_terms(center, [along, 1.0, 1.0, 0.0, 0.0, 0.0], DVec3::ZERO, -1.0)
        };
        let one = ball(DVec3::new(0.0, 0.0, 0.075), 1.0);
        for power in 3..10 {
            let other = ball(
                DVec3::new(0.0, -0.0866, -0.075),
                1.0 - 7.0 * 10f64.powi(-power),
            );
            let found = curves(&one, &other, Nearness::of(1e-9));
            let found = found.unwrap_or_else(|why| panic!("{power}: {why:?}"));
            assert!(!found.is_empty(), "{power}");
            for branch in &found {
                for k in 0..20 {
                    let at = branch.curve.at(0.3 * f64::from(k));
                    if at.length() > 2.0 {
                        continue;
                    }
                    let off = solve::residual([&one, &other].into_iter(), at);
                    assert!(off < 1e-13, "{power}: {off}");
                }
            }
        }
    }

    /// Balls of radius 1, one of them no ball by less than they overlap, have a loop in common,
    /// however small it is; or nothing, or touch.
    #[test]
    fn balls_that_nearly_touch_meet_in_loops() {
        let mut random = Random(3);
        for case in 0..200 {
            let overlap = 10f64.powi(-6 - case % 6);
            let turn = turn(&mut random);
            let along = turn * DVec3::X;
            let one = of_axes(DVec3::ZERO, DMat3::IDENTITY, [1.0; 3], (0.0, -1.0));
            let other = |off: f64, odd: f64| {
                let center = (2.0 + off) * along;
                of_axes(center, turn, [1.0, 1.0, 1.0 + odd], (0.0, -1.0))
            };
            let overlapping = other(-overlap, 0.3 * overlap);
            let found = curves(&one, &overlapping, Nearness::of(NEAR));
            let found = found.unwrap_or_else(|why| panic!("{case}: {why:?}"));
            assert!(!found.is_empty(), "{case}: {overlap}");
            let radius = overlap.sqrt();
            for branch in &found {
                let [start, end] = branch.curve.range(DVec3::ZERO, 3.0).expect("it is near");
                for k in 0..50 {
                    let at = branch.curve.at(start + f64::from(k) / 50.0 * (end - start));
                    let off = solve::residual([&one, &overlapping].into_iter(), at);
                    assert!(off < 2e-15, "{case}: {off}");
                    let from_axis = at.reject_from(along).length();
                    assert!(
                        (from_axis / radius - 1.0).abs() < 0.2,
                        "{case}: {from_axis}"
                    );
                }
            }
            let apart = curves(&one, &other(overlap, 0.3 * overlap), Nearness::of(NEAR));
            assert!(apart.is_ok_and(|none| none.is_empty()), "{case}");
            let touching = curves(&one, &other(0.0, 0.0), Nearness::of(NEAR));
            assert!(
                matches!(touching, Err(Unknown::Touch(_))),
                "{case}: {touching:?}"
            );
        }
    }

    /// A cone or cylinder, and the same turned by a matrix of six digits: their curves lie in
    /// two planes but for that.
    pub fn equal_but_for_digits(random: &mut Random) -> [Surface; 2] {
        let values = [[1.0, 1.0, -0.25 - random.unit()], [1.0, 1.0, 0.0]];
        let values = values[random.below(2)];
        let constant = if values[2] == 0.0 { -0.3 } else { 0.0 };
        let one = of_axes(DVec3::ZERO, turn(random), values, (0.0, constant));
        let [xx, yy, zz, xy, yz, zx] = one.quadratic;
        let [xy, yz, zx] = [xy, yz, zx].map(|mixed| 0.5 * mixed);
        let form = DMat3::from_cols_array(&[xx, xy, zx, xy, yy, yz, zx, yz, zz]);
        let angle = [90.0f64, 120.0, 45.0][random.below(3)].to_radians();
        let [sin, cos] = [angle.sin(), angle.cos()].map(|number| (number * 1e6).round() * 1e-6);
        let back = DMat3::from_cols_array(&[cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0]);
        let turned = back.transpose() * form * back;
        let entry = |i: usize, j: usize| turned.col(j)[i];
        let mixed = |i: usize, j: usize| 2.0 * entry(i, j);
        let [xx, yy, zz] = [0, 1, 2].map(|k| entry(k, k));
        let quadratic = [xx, yy, zz, mixed(0, 1), mixed(1, 2), mixed(2, 0)];
        // Off the axis about which one was turned, more or less.
        let off = 0.3 * random.unit() * DVec3::X;
        let other = Surface::of_terms(back.transpose() * off, quadratic, DVec3::ZERO, constant);
        [Surface { anchor: off, ..one }, other]
    }

    #[test]
    fn curves_in_two_planes_but_for_little_are_known_and_all() {
        let mut random = Random(4);
        let (mut known, mut points) = (0, 0);
        for case in 0..300 {
            let surfaces = equal_but_for_digits(&mut random);
            let Ok(branches) = curves(&surfaces[0], &surfaces[1], Nearness::of(NEAR)) else {
                continue;
            };
            for branch in &branches {
                let Some([start, end]) = branch.curve.range(DVec3::ZERO, 3.0) else {
                    continue;
                };
                for k in 0..50 {
                    let at = branch.curve.at(start + f64::from(k) / 50.0 * (end - start));
                    let off = solve::residual(surfaces.iter(), at);
                    assert!(
                        off < 1e-11 * (1.0 + at.length()),
                        "{case}: {off} {surfaces:?}"
                    );
                }
            }
            known += 1;
            points += check(&surfaces, branches, &mut random);
        }
        assert!(known > 290 && points > 700, "{known} {points}");
    }

    /// The apex of one is on the other one: their curve passes through it twice.
    #[test]
    fn nodes_are_on_the_pieces_of_curves_that_have_them() {
        let mut random = Random(1);
        let mut all = 0;
        for trial in 0..100 {
            let [a, b] = [(); 2].map(|()| 0.2 + random.unit());
            let apex = DVec3::new(a, 0.0, 1.0);
            let one = of_axes(DVec3::ZERO, DMat3::IDENTITY, [1.0, 1.0, -a * a], (0.0, 0.0));
            let other = of_axes(apex, turn(&mut random), [1.0, 1.0, -b * b], (0.0, 0.0));
            let Ok(found) = curves(&one, &other, Nearness::of(1e-9)) else {
                continue;
            };
            let mut count = 0;
            for branch in &found {
                let range = branch.curve.range(apex, 1.0);
                for &node in &branch.nodes {
                    let is_within = range.is_some_and(|[from, to]| from < node && node < to);
                    assert!(is_within, "{trial}: {node} of {range:?}");
                    let off = branch.curve.at(node).distance(apex);
                    assert!(off < 1e-9, "{trial}: {off}");
                    count += 1;
                }
            }
            assert_eq!(count % 2, 0, "{trial}");
            all += count;
        }
        assert!(all > 50, "{all}");
    }

    /// Their apexes differ in the last digit.
    #[test]
    fn cones_of_one_apex_but_for_rounding_meet_in_lines_of_both() {
        let apex = DVec3::new(-0.661, 0.001, 0.552);
        let other = DVec3::new(apex.x, apex.y, apex.z.next_up());
        let cone = |anchor: DVec3, quadratic: [f64; 6]| {
            Surface::of_terms(anchor, quadratic, DVec3::ZERO, 0.0)
        };
        let upright = cone(apex, [1.0, 1.0, -1.0, 0.0, 0.0, 0.0]);
        let along_x = [-1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
        for anchor in [apex, other] {
            let found = curves(&upright, &cone(anchor, along_x), Nearness::of(1e-9))
                .expect("they are known");
            assert_eq!(found.len(), 2);
            for branch in &found {
                for t in [-0.7, 0.4] {
                    let surfaces = [&upright, &cone(anchor, along_x)];
                    let off = solve::residual(surfaces.into_iter(), branch.curve.at(t));
                    assert!(off < 1e-9, "{off}");
                }
            }
        }
    }

    #[test]
    fn planes_nearly_along_a_cylinder_cut_it_in_two_known_to_the_last_digits() {
        let cylinder = Surface::of_terms(
            DVec3::new(0.2, -0.1, 0.3),
            [1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            DVec3::ZERO,
            -0.5625,
        );
        for power in 1..11 {
            let tilt = 10f64.powi(-power);
            let plane = Surface::plane(
                DVec3::new(0.5, 0.3, 0.1),
                DVec3::new(0.8, 0.6, tilt).normalize(),
            );
            let found = curves(&plane, &cylinder, Nearness::of(NEAR)).expect("they are known");
            for side in [-1.0, 1.0] {
                for z in [-0.5, 0.0, 0.4] {
                    let height = plane.linear.z * (z - plane.anchor.z)
                        / plane.linear.x.hypot(plane.linear.y);
                    let foot = DVec3::new(0.5, 0.3, 0.0) - height * DVec3::new(0.8, 0.6, 0.0);
                    let along = DVec3::new(-0.6, 0.8, 0.0);
                    // From the axis.
                    let off = foot - cylinder.anchor.with_z(0.0);
                    let (b, c) = (off.dot(along), off.length_squared() - 0.5625);
                    let point = foot + (side * (b * b - c).sqrt() - b) * along + z * DVec3::Z;
                    let on = found.iter().map(|branch| distance(&branch.curve, point));
                    let nearest = on.fold(f64::INFINITY, f64::min);
                    assert!(nearest < 1e-7, "{tilt}: {nearest} {found:?}");
                }
            }
            for branch in &found {
                for t in [-0.6, 0.1, 0.5] {
                    let at = branch.curve.at(t);
                    if at.length() > 2.0 {
                        continue;
                    }
                    let off = solve::residual([&plane, &cylinder].into_iter(), at);
                    assert!(off < 1e-13, "{tilt}: {off} {found:?}");
                }
            }
        }
    }

    #[test]
    fn quadrics_that_touch_along_a_conic_have_it_in_common_once() {
        let mut random = Random(3);
        for case in 0..300 {
            let touching = quadric(&mut random);
            // Another one of their pencil with a plane counted twice.
            let mut number = || 2.0 * random.unit() - 1.0;
            let normal = DVec3::new(number(), number(), number()).normalize();
            let (factor, share) = (0.5 * number(), 1.0 + 0.5 * number());
            let foot = touching.anchor + 0.3 * number() * normal;
            let [x, y, z] = normal.to_array();
            let square = [x * x, y * y, z * z, 2.0 * x * y, 2.0 * y * z, 2.0 * z * x];
            let offset = normal.dot(touching.anchor - foot);
            let other = Surface {
                anchor: touching.anchor,
                quadratic: std::array::from_fn(|k| {
                    share * touching.quadratic[k] + factor * square[k]
                }),
                linear: share * touching.linear + 2.0 * factor * offset * normal,
                constant: share * touching.constant + factor * offset * offset,
                kind: touching.kind,
            };
            let plane = Surface::plane(foot, normal);
            let [wanted, found] = [
                curves(&plane, &touching, Nearness::of(1e-9)),
                curves(&touching, &other, Nearness::of(1e-9)),
            ]
            .map(|curves| curves.map_or(0, |branches| branches.len()));
            assert_eq!(
                found,
                wanted,
                "case {case} {factor} {share} {foot} {normal}{touching:?} {:?}",
                curves(&touching, &other, Nearness::of(1e-9))
            );
            let branches = curves(&touching, &other, Nearness::of(1e-9)).unwrap_or_default();
            for branch in branches {
                assert!(!matches!(branch.curve, Curve::Rulings(_)), "case {case}");
                let [start, end] = branch.curve.range(DVec3::ZERO, 3.0).expect("a range");
                for k in 0..50 {
                    let at = branch.curve.at(start + f64::from(k) / 50.0 * (end - start));
                    let off = plane
                        .value(at)
                        .abs()
                        .max(solve::residual([&touching].into_iter(), at));
                    assert!(off < 1e-9 * (1.0 + at.length()), "case {case}: {off}");
                }
            }
        }
    }

    /// Planes nearly along a ruling of a cone: the centres of the conics are up to
    /// 1e10 away.
    #[test]
    fn conics_whose_centre_is_far_away_keep_their_digits() {
        const NEAR: f64 = 1e-9;
        let cone = Surface::of_terms(
            DVec3::new(0.1, -0.2, 0.3),
            [1.0, 1.0, -1.0, 0.0, 0.0, 0.0],
            DVec3::ZERO,
            0.0,
        );
        let mut random = Random(11);
        for tilt in [1e-4, 1e-6, 1e-8, 1e-10].into_iter().flat_map(|t| [t, -t]) {
            let plane = Surface::plane(
                cone.anchor + 0.5 * DVec3::X,
                DVec3::new(1.0, 0.0, -1.0 + tilt).normalize(),
            );
            let found = conics(&plane, &cone, NEAR);
            for curve in &found {
                let Some([start, end]) = curve.range(DVec3::ZERO, 3.0) else {
                    continue;
                };
                for k in 0..=50 {
                    let at = curve.at(start + f64::from(k) / 50.0 * (end - start));
                    let off = solve::residual([&plane, &cone].into_iter(), at);
                    assert!(off < 1e-14 * (1.0 + at.length_squared()), "{tilt}: {off}");
                }
            }
            let mut points = 0;
            for _ in 0..50 {
                let start = DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
                let common = solve::common_point(&[&plane, &cone], start, 0.5);
                if common.residual > 1e-13 || common.point.length() > 2.0 {
                    continue;
                }
                points += 1;
                let off = found.iter().map(|c| distance(c, common.point));
                let off = off.fold(f64::INFINITY, f64::min);
                assert!(off < 1e-7, "{tilt}: {off}");
            }
            assert!(points > 10, "{points}");
        }
    }

    /// Checks that curves are on two surfaces, and all that these have in common
    /// near the origin, at random points of it; how many points these were.
    fn check(surfaces: &[Surface; 2], branches: Branches, random: &mut Random) -> u32 {
        let curves: Vec<Curve> = branches.into_iter().map(|b| b.curve).collect();
        for curve in &curves {
            let Some([start, end]) = curve.range(DVec3::ZERO, 3.0) else {
                continue;
            };
            for k in 0..50 {
                let at = curve.at(start + f64::from(k) / 50.0 * (end - start));
                let off = solve::residual(surfaces.iter(), at);
                assert!(
                    off < 1e-7 * (1.0 + at.length()),
                    "{surfaces:?}: {off} {curve:?}"
                );
            }
        }
        let mut points = 0;
        for _ in 0..10 {
            let start = DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
            let found = solve::common_point(&[&surfaces[0], &surfaces[1]], start, 0.5);
            if found.residual > 1e-13 || found.point.length() > 2.0 {
                continue;
            }
            points += 1;
            let off = curves.iter().map(|c| distance(c, found.point));
            let off = off.fold(f64::INFINITY, f64::min);
            assert!(off < 1e-5, "{off} of {} {surfaces:?}", curves.len());
        }
        points
    }

    #[test]
    fn curves_are_all_that_two_surfaces_have_in_common() {
        const NEAR: f64 = 1e-9;
        let mut random = Random(7);
        let (mut known, mut points) = (0, 0);
        for _ in 0..400 {
            let surfaces = [quadric(&mut random), quadric(&mut random)];
            let Ok(branches) = curves(&surfaces[0], &surfaces[1], Nearness::of(NEAR)) else {
                continue;
            };
            known += 1;
            points += check(&surfaces, branches, &mut random);
        }
        assert!(known == 400 && points > 1000, "{known} {points}");
    }

    #[test]
    fn curves_through_apexes_of_cones_are_known() {
        const NEAR: f64 = 1e-9;
        let mut random = Random(5);
        let (mut known, mut points) = (0, 0);
        while known < 200 {
            let mut cone = quadric(&mut random);
            let other = quadric(&mut random);
            let on_other = solve::common_point(&[&other], cone.anchor, 0.5);
            if cone.apex().is_none() || other.apex().is_some() || on_other.residual > 1e-15 {
                continue;
            }
            cone.anchor = on_other.point;
            for surfaces in [[cone, other], [other, cone]] {
                let found = curves(&surfaces[0], &surfaces[1], Nearness::of(NEAR));
                let branches = found.unwrap_or_else(|e| panic!("{e:?} {surfaces:?}"));
                known += 1;
                points += check(&surfaces, branches, &mut random);
            }
        }
        assert!(points > 500, "{points}");
    }

    /// Checks the curves of pairs of the cones and cylinders y² = z l(x, y, z), which touch the
    /// plane z = 0 along the x axis, the second perhaps rolled about it, and both turned; at how
    /// many common points.
    fn check_along_a_line(seed: u64, is_rolled: bool) -> u32 {
        let mut random = Random(seed);
        let mut points = 0;
        for round in 0..200 {
            let turn = turn(&mut random);
            let mut number = |low: f64, high: f64| low + (high - low) * random.unit();
            let mut touching = |is_cone: bool, roll: f64| {
                let [slope, skew, wide] =
                    [(0.3, 1.0), (-0.3, 0.3), (-1.0, -0.3)].map(|(a, b)| number(a, b));
                let (along, constant) = if is_cone {
                    (slope, -slope * number(-1.0, 1.0))
                } else {
                    (0.0, slope)
                };
                let form = [0.0, 1.0, -wide, 0.0, -skew, -along];
                let surface = Surface::of_terms(DVec3::ZERO, form, -constant * DVec3::Z, 0.0);
                let turn = turn * DMat3::from_rotation_x(roll);
                surface.pulled_back(&turn.transpose(), DVec3::ZERO)
            };
            let roll = |share: f64| if is_rolled { 0.2 + 5.8 * share } else { 0.0 };
            let one = touching(true, 0.0);
            let surfaces = [one, touching(round % 3 > 0, roll(f64::from(round) / 200.0))];
            let branches =
                curves(&surfaces[0], &surfaces[1], Nearness::of(NEAR)).expect("they are known");
            let line = turn.x_axis;
            for place in [-0.7, 0.2] {
                let on = branches.iter().map(|b| distance(&b.curve, place * line));
                assert!(on.fold(f64::INFINITY, f64::min) < 1e-5, "{round}");
            }
            // They have one tangent plane where the cubic meets the line.
            let nodes = branches
                .iter()
                .flat_map(|b| b.nodes.iter().map(|&node| b.curve.at(node)));
            for at in nodes.filter(|at| is_rolled && at.length() < 3.0) {
                let [p, q] = surfaces.map(|s| s.gradient(at));
                assert!(p.cross(q).length() < 1e-6, "{round}: {at}");
            }
            points += check(&surfaces, branches, &mut random);
        }
        points
    }

    /// Of these every quadric of the pencil is singular.
    #[test]
    fn curves_of_cones_that_touch_along_a_line_are_known() {
        let points = check_along_a_line(7, false);
        assert!(points > 500, "{points}");
    }

    /// These meet else in a twisted cubic.
    #[test]
    fn curves_of_cones_that_cross_along_a_line_are_known() {
        let points = check_along_a_line(8, true);
        assert!(points > 500, "{points}");
    }
}
