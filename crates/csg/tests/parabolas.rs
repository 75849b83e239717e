//! Profiles with quadratic Bézier curves: solids of parabolic cylinders and cones, held against
//! closed forms of their volumes.

use std::f64::consts::TAU;

use csg::glam::{DAffine3, DVec2};
use csg::{BoundaryOptions, Brep, Path, Profile, Program, Solid};

use crate::random::Random;
use crate::sweeps::one_in;

/// A closed contour of curves that are tangent where they join, in the middles between control
/// points; and its area, by triangles, and two thirds of those of curves (Archimedes).
fn smooth(controls: &[DVec2]) -> (Path, f64) {
    let count = controls.len();
    let joint = |k: usize| controls[k % count].midpoint(controls[(k + 1) % count]);
    let mut path = Path::from(joint(count - 1));
    let mut doubled = 0.0;
    for (k, &control) in controls.iter().enumerate() {
        let (from, to) = (joint(k + count - 1), joint(k));
        path = path.quadratic_to(control, to);
        doubled += from.perp_dot(to) + (control - from).perp_dot(to - from) * (2.0 / 3.0);
    }
    (path, 0.5 * doubled)
}

/// Around the origin, at distances of 1 and up to `wobble` more or less.
fn around(random: &mut Random, count: usize, wobble: f64) -> Vec<DVec2> {
    let place = |k: usize| {
        let radius = 1.0 + wobble * (2.0 * random.unit() - 1.0);
        let angle = k as f64 / count as f64 * TAU;
        radius * DVec2::new(1.3 * angle.cos(), angle.sin())
    };
    (0..count).map(place).collect()
}

fn boundary(solid: &Solid) -> Brep {
    let program = Program::lower(solid).expect("a program");
    let boundary = program.boundary(&BoundaryOptions::new().most_moved(0.0));
    let boundary = boundary.unwrap_or_else(|why| panic!("{why}"));
    assert_eq!(solid.strays(), None);
    boundary
}

#[track_caller]
fn assert_volume(solid: &Solid, wanted: f64, case: &str) {
    let volume = boundary(solid).measure().volume;
    let off = (volume.value - wanted).abs();
    assert!(off <= volume.error, "{case}: {volume:?}, not {wanted}");
    assert!(volume.error < 1e-9 * wanted, "{case}: {volume:?}");
}

/// Where all is symmetric neighbours have the tangent and the curvature in common.
#[test]
fn smooth_contours_are_exact_straight_and_drawn_in() {
    let mut random = Random(1);
    for case in (0..60).step_by(one_in(3)) {
        let count = 4 + random.below(if case % 10 == 0 { 40 } else { 12 });
        let wobble = if case % 3 == 0 {
            0.0
        } else {
            0.4 * random.unit()
        };
        let (path, area) = smooth(&around(&mut random, count, wobble));
        let scale = [1.0, 1.0, 0.5, 1.8, 0.0][case % 5];
        let angle = 2.0 * random.unit();
        let solid = Solid::extrude_scaled(&path.close(), 0.0..1.5, [scale; 2]);
        let solid = solid.rotate_x(angle).rotate_z(0.7 * angle);
        let wanted = area * 1.5 * (1.0 + scale + scale * scale) / 3.0;
        assert_volume(&solid, wanted, &format!("{case}: {count} {wobble} {scale}"));
    }
}

/// Over any place in the profile or beside it: there all cones and planes meet.
#[test]
fn contours_are_drawn_to_any_point() {
    let mut random = Random(5);
    for case in (0..40).step_by(one_in(3)) {
        let count = 3 + random.below(8);
        let mut controls = around(&mut random, count, [0.0, 0.1][case % 2]);
        let aside = [0.0, 0.25, 0.6, 1.0, 3.0].map(|share| share * DVec2::new(1.0, 0.4));
        let aside = aside[random.below(5)];
        controls.iter_mut().for_each(|control| *control += aside);
        let (path, area) = smooth(&controls);
        let scale = [0.0, 0.3][case % 4 / 2];
        let solid = Solid::extrude_scaled(&path.close(), 0.0..1.5, [scale; 2]);
        let solid = solid.rotate_x(random.unit());
        let wanted = area * 1.5 * (1.0 + scale + scale * scale) / 3.0;
        let case = format!("{case}: {count} {aside} {scale}");
        assert_volume(&solid, wanted, &case);
    }
}

#[test]
fn holes_bites_and_overlapping_strokes_add_up() {
    let mut random = Random(2);
    for case in (0..24).step_by(one_in(3)) {
        let count = 5 + random.below(9);
        let controls = around(&mut random, count, 0.2);
        let inner: Vec<DVec2> = controls.iter().rev().map(|p| 0.5 * p).collect();
        let ([outer, hole], [area, inner_area]) = {
            let both = [smooth(&controls), smooth(&inner)];
            (
                both.clone().map(|(path, _)| path),
                both.map(|(_, area)| area),
            )
        };
        let ring = Profile::paths([outer.clone(), hole], csg::FillRule::NonZero);
        let ring = Solid::extrude(&ring, 0.0..1.0);
        // (The hole runs the other way round.)
        assert_volume(&ring, area + inner_area, &format!("{case}: ring"));
        // A stroke across it, wound around twice where both are, and what both are but once.
        let shift = DVec2::new(0.9, 0.3 * random.unit());
        let moved: Vec<DVec2> = controls.iter().map(|p| *p + shift).collect();
        let strokes = Profile::paths([outer.clone(), smooth(&moved).0], csg::FillRule::NonZero);
        let volume = |solid: &Solid| boundary(solid).measure().volume;
        let united = volume(&Solid::extrude(&strokes, 0.0..1.0));
        let [one, other] = [outer, smooth(&moved).0].map(|path| {
            let profile = path.close();
            Solid::extrude(&profile, 0.0..1.0)
        });
        let common = volume(&(one & other));
        let off = (united.value + common.value - 2.0 * area).abs();
        assert!(off <= united.error + common.error, "{case}: {off}");
    }
}

/// As designers draw them whose outlines are of whole numbers.
#[test]
fn curves_that_are_nearly_straight_keep_their_digits() {
    let mut random = Random(3);
    for case in (0..40).step_by(one_in(4)) {
        let mut number = || 2.0 * random.unit() - 1.0;
        let bend = 10f64.powi(-1 - case % 3);
        let corners = [[-3.0, -2.0], [4.0, -1.5], [3.5, 2.0], [-2.5, 2.5]];
        let corners = corners.map(|[x, y]| DVec2::new(x + 0.5 * number(), y + 0.5 * number()));
        let mut path = Path::from(corners[3]);
        let mut doubled = 0.0;
        for k in 0..4 {
            let (from, to) = (corners[(k + 3) % 4], corners[k]);
            let along = to - from;
            let across = along.perp() * (0.5 + 0.5 * number().abs()).copysign(number());
            let control = from.midpoint(to) + bend * (across + number() * along);
            path = path.quadratic_to(control, to);
            doubled += from.perp_dot(to) + (control - from).perp_dot(to - from) * (2.0 / 3.0);
        }
        let solid = Solid::extrude(&path.close(), 0.0..1.0).rotate_y(0.4 * number());
        assert_volume(&solid, 0.5 * doubled, &format!("{case}: {bend}"));
    }
}

/// A curve on its chord, a lens, and what is cut off by z = 0.
#[test]
fn few_corners_are_enough() {
    let bowl = Path::from([-1.0, 0.0]).quadratic_to([0.0, -2.0], [1.0, 0.0]);
    let volume = |path: Path| boundary(&Solid::extrude(&path.close(), -1.0..1.0));
    let lens = bowl.clone().quadratic_to([0.0, 2.0], [-1.0, 0.0]);
    for (path, wanted) in [(bowl, 8.0 / 3.0), (lens, 16.0 / 3.0)] {
        let volume = volume(path).measure().volume;
        assert!((volume.value - wanted).abs() < 1e-12, "{volume:?}");
    }
    let (path, area) = smooth(&around(&mut Random(4), 9, 0.3));
    let solid = Solid::extrude(&path.close(), -1.0..1.0);
    let section = solid.section(DAffine3::IDENTITY, 1e-3).expect("a section");
    let again = Solid::extrude(&section, 0.0..1.0);
    assert_volume(&again, area, "its section");
}
