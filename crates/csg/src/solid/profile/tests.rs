//! Formulas against winding numbers, areas against closed forms.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DAffine2, DVec2, dvec2};

use super::polygon::encloses;
use super::*;
use crate::random::Random;
use crate::sweeps::one_in;
use crate::{BoundaryOptions, Program};

fn set_of(profile: &Profile) -> PlaneSet {
    let sagitta = Sagitta::of_length(1e-6);
    formula(profile, sagitta, &|_| true).expect("a formula").set
}

/// How often closed contours wind around a point.
fn winding(contours: &[Vec<DVec2>], point: DVec2) -> i64 {
    let turns = |contour: &Vec<DVec2>| {
        let next = contour.iter().cycle().skip(1);
        let angle = |(a, b): (&DVec2, &DVec2)| (*a - point).angle_to(*b - point);
        (contour.iter().zip(next).map(angle).sum::<f64>() / TAU).round() as i64
    };
    contours.iter().map(turns).sum()
}

fn random_point(random: &mut Random, size: f64) -> DVec2 {
    dvec2(random.unit() - 0.5, random.unit() - 0.5) * (2.0 * size)
}

fn assert_same(set: &PlaneSet, inside: impl Fn(DVec2) -> bool, random: &mut Random, what: &str) {
    for _ in 0..200 {
        let point = random_point(random, 1.3);
        assert_eq!(set.contains(point), inside(point), "{point} of {what}");
    }
}

/// Corners in any order: they cross themselves wildly.
#[test]
fn crossing_polygons_follow_their_rule() {
    let mut random = Random(5);
    for round in 0..300 {
        let contours: Vec<Vec<DVec2>> = (0..1 + random.below(3))
            .map(|_| {
                let count = 3 + random.below(9);
                (0..count).map(|_| random_point(&mut random, 1.0)).collect()
            })
            .collect();
        for rule in [FillRule::EvenOdd, FillRule::NonZero] {
            let profile = Profile::polygons_of(contours.clone(), rule);
            let set = set_of(&profile);
            let inside = |point| rule.is_inside(winding(&contours, point));
            assert_same(&set, inside, &mut random, &format!("{round} {contours:?}"));
        }
    }
}

/// Corners on a small grid, upright and turned: straight corners, corners on sides, spikes, sides
/// and corners that are the same, all at once, or the same but for rounding.
#[test]
fn degenerate_polygons_follow_their_rule() {
    let mut random = Random(6);
    for round in 0..1200 {
        let turned = if round % 2 == 0 {
            DVec2::X
        } else {
            DVec2::from_angle(random.unit())
        };
        let contours: Vec<Vec<DVec2>> = (0..1 + random.below(3))
            .map(|_| {
                let count = 3 + random.below(8);
                let coordinate = |random: &mut Random| random.below(4) as f64 * 0.5 - 0.75;
                (0..count)
                    .map(|_| dvec2(coordinate(&mut random), coordinate(&mut random)))
                    .map(|point| turned.rotate(point))
                    .collect()
            })
            .collect();
        for rule in [FillRule::EvenOdd, FillRule::NonZero] {
            let profile = Profile::polygons_of(contours.clone(), rule);
            let set = set_of(&profile);
            let inside = |point| rule.is_inside(winding(&contours, point));
            assert_same(&set, inside, &mut random, &format!("{round} {contours:?}"));
        }
    }
}

/// Gears, spirals and combs: many corners, deep pockets, straight rows.
#[test]
fn large_simple_polygons_use_each_side_once() {
    let mut random = Random(7);
    let star: Vec<DVec2> = (0..400)
        .map(|k| turn(k, 400) * (0.3 + 0.7 * random.unit()))
        .collect();
    let spiral: Vec<DVec2> = (0..200)
        .map(|k| turn(k, 40) * (0.1 + 0.004 * k as f64))
        .chain(
            (0..200)
                .rev()
                .map(|k| turn(k, 40) * (0.15 + 0.004 * k as f64)),
        )
        .collect();
    let comb: Vec<DVec2> = (0..60)
        .map(|k| {
            dvec2(
                0.03 * f64::from(k / 2) - 0.5,
                if (k + 1) / 2 % 2 == 0 { 0.4 } else { -0.4 },
            )
        })
        .chain([dvec2(0.45, -0.8), dvec2(-0.6, -0.8)])
        .collect();
    for (what, polygon) in [("star", star), ("spiral", spiral), ("comb", comb)] {
        let set = set_of(&Profile::polygon(polygon.clone()));
        assert_eq!(set.leaves().count(), polygon.len(), "{what}");
        let contour: Contour = polygon.into_iter().map(Corner::straight).collect();
        assert_same(&set, |point| encloses(&contour, point), &mut random, what);
    }
}

#[test]
fn shapes_have_their_areas_and_points() {
    let circle = PI * 0.25;
    let lens = Path::from([-0.5, 0.0])
        .arc_to([0.5, 0.0], FRAC_PI_2)
        .arc_to([-0.5, 0.0], FRAC_PI_2)
        .close();
    // A disc with a bite, and a pocket that an arc bulges into.
    let moon = Path::from([0.0, -0.5])
        .arc_through([0.5, 0.0], [0.0, 0.5])
        .arc_through([0.2, 0.0], [0.0, -0.5])
        .close();
    let (r, h) = (0.725, 0.2);
    let bite = r * r * (0.5_f64 / r).asin() - 0.5 * (r - h);
    let keyhole = Path::from([-0.1, -0.8])
        .line_to([0.1, -0.8])
        .line_to([0.1, 0.0])
        .arc_through([0.0, 0.7], [-0.1, 0.0])
        .close();
    let radius = (0.7_f64.powi(2) + 0.1_f64.powi(2)) / 1.4;
    let head = {
        let half = (0.1 / radius).asin();
        radius * radius * (PI - half) + 0.1 * radius * half.cos()
    };
    let square = Profile::rectangle([1.0, 1.0]);
    for (what, profile, area) in [
        ("circle", Profile::circle(0.5), circle),
        ("ellipse", Profile::ellipse([0.5, 0.25]), circle / 2.0),
        ("slot", Profile::slot(0.6, 0.2), 0.24 + 0.04 * PI),
        (
            "rounded",
            Profile::rounded_rectangle([1.0, 0.8], 0.1),
            0.8 - (4.0 - PI) * 0.01,
        ),
        (
            "hexagon",
            Profile::regular_polygon(6, 1.0),
            1.5 * 3.0_f64.sqrt(),
        ),
        ("lens", lens, 0.5 * (FRAC_PI_2 - 1.0)),
        ("moon", moon, FRAC_PI_2 * 0.25 - bite),
        ("keyhole", keyhole, 0.16 + head),
        ("frame", &square - Profile::circle(0.5), 1.0 - circle),
        (
            "ring",
            square.offset(0.2, Join::Round) - &square,
            0.8 + 0.04 * PI,
        ),
        ("turned", square.rotate(1.0).scale_xyz_test(), 0.5),
        ("mitre", square.offset(0.2, Join::Mitre(2.0)), 1.96),
        ("bevel", square.offset(0.2, Join::Bevel), 1.88),
        (
            "square",
            square.offset(0.2, Join::Square),
            1.96 - 4.0 * (0.2 * (2.0_f64.sqrt() - 1.0)).powi(2),
        ),
        ("shrunk", square.offset(-0.2, Join::Round), 0.36),
        ("none", square.offset(-0.6, Join::Round), 0.0),
        (
            "shrunk slot",
            Profile::slot(0.6, 0.2).offset(-0.1, Join::Round),
            0.12 + 0.01 * PI,
        ),
        (
            "hull",
            (square.translate([0.0, 0.3])
                | Profile::polygon([[0.0, -1.0], [0.1, -0.5], [-0.1, -0.5]]))
            .hull(),
            1.4,
        ),
    ] {
        let found = profile.area(1e-9).expect(what);
        assert!((found - area).abs() < 2e-8, "{what}: {found}, not {area}");
        // And as a formula: of points spread evenly (Roberts' R2 sequence) as many.
        let set = set_of(&profile);
        let n = 300_000;
        let at = |k: u32, step: f64| (0.5 + f64::from(k) * step).fract() * 2.4 - 1.2;
        let spread = (0..n).map(|k| {
            dvec2(
                at(k, 0.754_877_666_246_692_8),
                at(k, 0.569_840_290_998_053_3),
            )
        });
        let hits = spread.filter(|&point| set.contains(point)).count();
        let counted = hits as f64 * 2.4 * 2.4 / f64::from(n);
        assert!(
            (counted - area).abs() < 2e-3,
            "{what}: {counted}, not {area}"
        );
    }
}

impl Profile {
    fn scale_xyz_test(&self) -> Self {
        self.scale_xy([-0.5, 1.0])
    }
}

/// Where nothing crosses, an offset keeps its arcs: one circle per corner.
#[test]
fn offsets_keep_arcs() {
    let plate = Profile::rectangle([2.0, 1.0]).offset(0.25, Join::Round);
    let discs = set_of(&plate)
        .leaves()
        .filter(|leaf| matches!(leaf, Leaf::Disc(_)))
        .count();
    assert_eq!(discs, 4);
    // Of an L shape, too, though its inner corner is none.
    let corners = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
    let grown = Profile::polygon(corners).offset(0.25, Join::Round);
    assert_eq!(
        set_of(&grown)
            .leaves()
            .filter(|leaf| matches!(leaf, Leaf::Disc(_)))
            .count(),
        5
    );
    let area = 3.0 + 8.0 * 0.25 - 0.0625 + 5.0 / 4.0 * PI * 0.0625;
    assert!((grown.area(1e-9).expect("an area") - area).abs() < 1e-7);
}

#[test]
fn maps_move_profiles() {
    let half = Profile::circle(1.0) - Profile::rectangle_between([-2.0, -2.0], [2.0, 0.0]);
    let map = DAffine2::from_scale_angle_translation(dvec2(2.0, -0.5), 0.7, dvec2(1.0, 3.0));
    let moved = half.affine(map);
    let set = set_of(&moved);
    let mut random = Random(8);
    for _ in 0..500 {
        let point = random_point(&mut random, 1.3);
        let inside = point.length() < 1.0 && point.y > 0.0;
        assert_eq!(set.contains(map.transform_point2(point)), inside, "{point}");
    }
}

#[test]
fn mistakes_are_named() {
    let faults = [
        Profile::circle(-1.0),
        Profile::rectangle([1.0, f64::NAN]),
        Profile::regular_polygon(2, 1.0),
        Profile::rounded_rectangle([1.0, 1.0], 0.6),
        Profile::polygon([[0.0, 0.0], [1.0, 0.0]]),
        Profile::polygon([[0.0, 0.0], [1.0, 0.0], [f64::INFINITY, 1.0]]),
        Profile::circle(1.0).scale_xy([1.0, 0.0]),
        Profile::circle(1.0).offset(f64::NAN, Join::Round),
        Path::from([0.0, 0.0]).arc_to([1.0, 0.0], 7.0).close(),
        Path::from([0.0, 0.0]).line_to([1.0, 0.0]).close(),
    ];
    for profile in faults {
        assert!(profile.contours(1e-3).is_err(), "{profile:?}");
        let within = Profile::circle(1.0) - profile;
        assert!(
            formula(&within, Sagitta::of_length(1e-3), &|_| true).is_err(),
            "{within:?}"
        );
    }
}

/// A contour with an arc that crosses another side, by the rule of all others.
#[test]
fn arcs_may_cross() {
    let bow = Path::from([-1.0, 0.0])
        .arc_to([1.0, 0.0], PI)
        .line_to([1.0, -0.5])
        .line_to([-1.0, -0.5])
        .close();
    let lid = Profile::rectangle_between([-1.0, -1.0], [1.0, -0.5]);
    let set = set_of(&bow);
    // The half disc below y = 0 is wound around where the rectangle is not.
    let inside = |point: DVec2| {
        let dip = point.length() < 1.0 && point.y < 0.0;
        let band = point.x.abs() < 1.0 && (-0.5..0.0).contains(&point.y);
        dip != band
    };
    assert_same(&set, inside, &mut Random(9), "a bow");
    assert!(set_of(&(bow - lid)).contains(dvec2(-0.95, -0.4)));
}

/// Of lines and arcs, some on a grid: sides that touch, are tangent, or the same.
fn random_profile(random: &mut Random, on_grid: bool) -> Profile {
    let coordinate = |random: &mut Random| {
        let value = 2.0 * random.unit() - 1.0;
        if on_grid {
            (4.0 * value).round() * 0.25
        } else {
            value
        }
    };
    let mut profile = Profile::empty();
    for k in 0..1 + random.below(4) {
        let size = 0.25 * (1.0 + (4.0 * coordinate(random).abs()).floor());
        let shape = match random.below(4) {
            0 => Profile::circle(size),
            1 => Profile::rectangle([size, 0.5]),
            2 => Profile::rounded_rectangle([2.0 * size, 0.5], 0.125),
            _ => Profile::slot(2.0 * size + 0.5, 0.5),
        };
        let place = dvec2(coordinate(random), coordinate(random));
        // Chords, to compare with, have slits where sides are the same but for rounding.
        let shape = if on_grid {
            let quarter = turn(random.below(4), 4);
            shape.affine(DAffine2::from_mat2(DMat2::from_cols(
                quarter,
                quarter.perp(),
            )))
        } else {
            shape.rotate(coordinate(random))
        };
        let shape = shape.translate(place);
        profile = match random.below(if k == 0 { 1 } else { 4 }) {
            0 | 1 => profile | shape,
            2 => profile - shape,
            _ => profile & (shape | Profile::rectangle([1.5, 1.0])),
        };
    }
    profile
}

fn distance_to(contours: &[Vec<DVec2>], point: DVec2) -> f64 {
    let sides = contours.iter().flat_map(|contour| {
        let next = contour.iter().cycle().skip(1);
        contour.iter().zip(next)
    });
    let away = |(&a, &b): (&DVec2, &DVec2)| {
        let share = (point - a).dot(b - a) / (b - a).length_squared();
        a.lerp(b, share.clamp(0.0, 1.0)).distance(point)
    };
    sides.map(away).fold(f64::INFINITY, f64::min)
}

/// An offset has the points up to a distance from the profile, by its chords.
#[test]
fn offsets_of_combinations_are_exact() {
    const NEAR: f64 = 1e-5;
    let mut random = Random(32);
    let mut told = [0; 2];
    let mut open = 0;
    let mut profile = Profile::empty();
    let rounds = 1200 / one_in(4);
    for round in 0..rounds {
        // Every third one is made of the one before it.
        if round % 3 != 2 {
            profile = random_profile(&mut random, round % 2 == 0);
        }
        let contours = profile.contours(0.1 * NEAR).expect("contours");
        if contours.is_empty() {
            continue;
        }
        let distance = 0.0625 * (random.below(13) as f64 - 6.0);
        let Some(moved) = profile.exact_offset(distance, Join::Round) else {
            open += 1;
            continue;
        };
        let set = set_of(&moved);
        for _ in 0..100 {
            let point = random_point(&mut random, 2.0);
            let away = distance_to(&contours, point);
            let off = if winding(&contours, point) > 0 {
                -away
            } else {
                away
            };
            if (off - distance).abs() > NEAR {
                let is_in = set.contains(point);
                told[usize::from(is_in)] += 1;
                // Where circles touch, chords leave slivers and slits, which hold no samples.
                let mut holds = || {
                    let unmoved = set_of(&profile);
                    let place = |_| {
                        let along = DVec2::from_angle(TAU * random.unit());
                        point + distance * random.unit().sqrt() * along
                    };
                    let mut samples = (0..2000).map(place);
                    if distance > 0.0 {
                        samples.any(|sample| unmoved.contains(sample))
                    } else {
                        samples.all(|sample| unmoved.contains(sample))
                    }
                };
                assert!(
                    is_in == (off < distance) || is_in == holds(),
                    "{round}: {point} by {distance} of {profile:?}"
                );
            }
        }
        profile = moved;
    }
    assert_eq!(open, 0);
    let least = 5000 * rounds / 1200;
    assert!(told.iter().all(|&count| count > least), "{told:?}");
}

/// A chain of many unions neither recurses nor nests.
#[test]
fn long_chains_are_flat() {
    let dots = (0..2000).map(|k| Profile::circle(0.4).translate([f64::from(k), 0.0]));
    let all = dots.fold(Profile::empty(), |all, dot| all | dot);
    assert_eq!(all.steps.len(), 2002);
    assert_eq!(set_of(&all).leaves().count(), 2000);
}

/// Against how far discs reach in all directions.
#[test]
fn hulls_of_discs_reach_as_far_as_these() {
    /// Between two of them less than the distance below is missed along a side of length 4.
    const DIRECTIONS: u32 = 2000;
    const NEAR: f64 = 1e-2;
    let mut random = Random(31);
    let mut told = [0; 2];
    for round in 0..300 {
        let count = 1 + random.below(6);
        let is_round = round % 3 == 0;
        let discs: Vec<(DVec2, f64)> = (0..count)
            .map(|_| {
                let center = random_point(&mut random, 1.0);
                let radius = match random.below(4) {
                    0 => 0.0,
                    1 => 0.5,
                    _ => random.unit(),
                };
                // On a grid some are in line, touch from within, or reach as far.
                let to_grid = |x: f64| if is_round { (4.0 * x).round() / 4.0 } else { x };
                (dvec2(to_grid(center.x), to_grid(center.y)), to_grid(radius))
            })
            .collect();
        if discs.iter().all(|&(_, radius)| radius == 0.0) {
            continue;
        }
        let hull = Profile::hull_of_discs(discs.iter().copied());
        let contours = hull
            .contours(0.1 * NEAR)
            .unwrap_or_else(|e| panic!("{e}: {discs:?}"));
        assert_eq!(contours.len(), 1, "{discs:?}");
        for _ in 0..50 {
            let point = random_point(&mut random, 2.0);
            let beyond = |k: u32| {
                let along = DVec2::from_angle(TAU * f64::from(k) / f64::from(DIRECTIONS));
                let reach = |&(center, radius): &(DVec2, f64)| along.dot(center) + radius;
                along.dot(point) - discs.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
            };
            let off = (0..DIRECTIONS)
                .map(beyond)
                .fold(f64::NEG_INFINITY, f64::max);
            if off.abs() > NEAR {
                assert_eq!(
                    winding(&contours, point),
                    i64::from(off < 0.0),
                    "{discs:?} {point}"
                );
                told[usize::from(off < 0.0)] += 1;
            }
        }
    }
    assert!(told.iter().all(|&count| count > 1000), "{told:?}");
}

/// A slot, a drop, and a circle with another one in it.
#[test]
fn hulls_of_discs_have_arcs() {
    let slot = [
        (DVec2::ZERO, 1.0),
        (dvec2(1.0, 0.0), 1.0),
        (dvec2(3.0, 0.0), 1.0),
    ];
    let drop = [(DVec2::ZERO, 1.0), (dvec2(2.0, 0.0), 0.0)];
    let within = [(DVec2::ZERO, 1.0), (dvec2(0.5, 0.0), 0.5)];
    for (discs, area) in [
        (&slot[..], PI + 6.0),
        (&drop, PI - PI / 3.0 + 3f64.sqrt()),
        (&within, PI),
    ] {
        let found = Profile::hull_of_discs(discs.iter().copied())
            .area(1e-9)
            .expect("valid");
        assert!((found - area).abs() < 1e-7, "{found}, not {area}");
        let circles = discs.iter().map(|&(center, radius)| match radius {
            0.0 => Profile::polygon([center, center + 1e-12, dvec2(center.x - 1e-12, center.y)]),
            _ => Profile::circle(radius).translate(center),
        });
        let hull = Profile::union(circles).hull();
        assert!((hull.area(1e-9).expect("valid") - area).abs() < 1e-7);
    }
}

/// Two arcs, or an arc and its chord: between coarse chords there is nothing.
#[test]
fn what_two_sides_enclose_is_not_lost() {
    let disc = Profile::circle(5.0);
    let lens = |apart: f64, radius: f64| {
        let half = 0.5 * apart;
        2.0 * radius * radius * (half / radius).acos()
            - apart * (radius * radius - half * half).sqrt()
    };
    let segment = |height: f64, radius: f64| 0.5 * lens(2.0 * height, radius);
    let cap = &disc - Profile::rectangle_between([-6.0, -6.0], [3.0, 6.0]);
    let drawn_in = |profile: &Profile, by: f64| profile.offset(-by, Join::Round);
    for (what, profile, area) in [
        ("thin", &disc & disc.translate([9.99, 0.0]), lens(9.99, 5.0)),
        (
            "lens",
            drawn_in(&(&disc & disc.translate([6.0, 0.0])), 1.0),
            lens(6.0, 4.0),
        ),
        ("cap", drawn_in(&cap, 0.5), segment(3.5, 4.5)),
    ] {
        let bounds = profile.bounds(10.0).expect(what);
        let (min, max) = bounds.unwrap_or_else(|| panic!("{what} is lost"));
        let exact = profile.exact_area().expect(what);
        assert!(
            (exact / area - 1.0).abs() < 1e-10,
            "{what}: {exact}, not {area}"
        );
        assert!((max - min).min_element() > 0.0, "{what}");
        let solid = Solid::extrude(&profile, 0.0..1.0);
        let brep = Program::lower(&solid)
            .expect(what)
            .boundary(&BoundaryOptions::default());
        let volume = brep.expect(what).measure().volume;
        assert!(
            (volume.value / area - 1.0).abs() < 1e-10,
            "{what}: {volume:?}, not {area}"
        );
    }
}
