//! Extrusions and revolutions: volumes against closed forms, meshes closed,
//! manifold, and not through themselves.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::measured::measured;
use crate::random::Random;
use crate::sweeps::one_in;
use csg::glam::DVec2;
use csg::{
    BoundaryOptions, Error, Join, Mesher, NodeFault, Path, Profile, ProfileFault, Program, Solid,
    turn,
};

const TOLERANCE: f64 = 2e-3;

/// Meshes a solid and holds its volume to `volume`, exactly if it is bounded
/// by planes.
fn assert_volume(what: &str, solid: &Solid, volume: f64) {
    let program = Program::lower(solid).unwrap_or_else(|e| panic!("{what}: {e}"));
    let meshed = Mesher::new().tolerance(TOLERANCE).mesh(&program);
    let meshed = meshed.unwrap_or_else(|e| panic!("{what}: {e}"));
    let report = &meshed.report;
    assert!(report.check.is_manifold(), "{what}: {}", report.check);
    assert_eq!(report.fallbacks, [], "{what}");
    assert_eq!(meshed.mesh.self_intersections().len(), 0, "{what}");
    let found = meshed.mesh.volume();
    let allowed = if report.method == "polyhedral" {
        1e-12 * volume
    } else {
        meshed.mesh.area() * TOLERANCE
    };
    assert!(
        (found - volume).abs() <= allowed,
        "{what}: {found}, not {volume} (within {allowed:e})"
    );
}

fn l_shape() -> Profile {
    Profile::polygon([[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]])
}

fn gear(teeth: usize) -> Profile {
    let corner = |k: usize| {
        let radius = if k % 4 < 2 { 1.0 } else { 0.8 };
        turn(k, 4 * teeth) * radius
    };
    Profile::polygon((0..4 * teeth).map(corner)) - Profile::circle(0.3)
}

#[test]
fn straight_extrusions() {
    let slot = Profile::slot(1.0, 0.3);
    for (what, profile, area) in [
        ("l", l_shape(), 3.0),
        ("circle", Profile::circle(1.0), PI),
        ("ellipse", Profile::ellipse([1.0, 0.5]), FRAC_PI_2),
        ("slot", slot.clone(), 0.6 + 0.09 * PI),
        ("turned slot", slot.rotate(0.4), 0.6 + 0.09 * PI),
        (
            "rounded",
            Profile::rounded_rectangle([2.0, 1.0], 0.2),
            2.0 - (4.0 - PI) * 0.04,
        ),
        (
            "frame",
            Profile::rectangle([2.0, 2.0]) - Profile::rectangle([1.0, 1.0]),
            3.0,
        ),
        (
            "grown l",
            l_shape().offset(0.2, Join::Round),
            3.0 + 1.6 - 0.04 + 1.25 * PI * 0.04,
        ),
        ("gear", gear(12), gear(12).area(1e-9).expect("an area")),
    ] {
        let solid = Solid::extrude(&profile, -0.5..1.0);
        assert_volume(what, &solid, 1.5 * area);
    }
}

#[test]
fn scaled_extrusions() {
    // ∫ (1 + (sx - 1) t) (1 + (sy - 1) t) dt.
    let share = |sx: f64, sy: f64| (2.0 * sx * sy + sx + sy + 2.0) / 6.0;
    let off = Profile::circle(0.5).translate([1.0, 0.0]);
    for (what, profile, scale, area) in [
        (
            "frustum",
            Profile::regular_polygon(5, 1.0),
            [0.5, 0.5],
            2.5 * turn(1, 5).y,
        ),
        ("l", l_shape(), [2.0, 2.0], 3.0),
        ("pyramid", l_shape(), [0.0, 0.0], 3.0),
        ("cone", Profile::circle(1.0), [0.3, 0.3], PI),
        ("oblique cone", off.clone(), [0.5, 0.5], 0.25 * PI),
        ("oblique tip", off, [0.0, 0.0], 0.25 * PI),
        ("wedge", Profile::rectangle([2.0, 1.0]), [0.5, 2.0], 2.0),
        ("roof", Profile::rectangle([2.0, 1.0]), [0.5, 0.0], 2.0),
        // Sides along axes but for rounding.
        (
            "turned roof",
            Profile::rectangle([1.0, 2.0]).rotate(FRAC_PI_2),
            [0.5, 0.0],
            2.0,
        ),
        (
            "saddles",
            Profile::regular_polygon(3, 1.0),
            [0.5, 1.5],
            1.5 * turn(1, 3).y,
        ),
    ] {
        let solid = Solid::extrude_scaled(&profile, 1.0..3.0, scale);
        assert_volume(what, &solid, 2.0 * area * share(scale[0], scale[1]));
    }
    // In flat steps.
    for scale in [[0.5, 2.0], [1.0, 0.0], [2.0, 1.5]] {
        let solid = Solid::extrude_scaled(&Profile::circle(1.0), 1.0..3.0, scale);
        let program = Program::lower(&solid).expect("a program");
        let mesh = Mesher::new().mesh(&program).expect("a mesh").mesh;
        let volume = 2.0 * PI * share(scale[0], scale[1]);
        let off = (mesh.volume() / volume - 1.0).abs();
        assert!(mesh.check().is_manifold() && off < 1e-3, "{scale:?}: {off}");
    }
    let pyramid = Solid::extrude_to_point(&l_shape(), 0.0..1.0, [0.5, 0.5]);
    assert_volume("pointed", &pyramid, 1.0);
}

/// The exact volume of a solid, which has to have an exact boundary.
fn exact(solid: &Solid) -> csg::brep::Bounded {
    let program = Program::lower(solid).expect("valid");
    let brep = program
        .boundary(&BoundaryOptions::new())
        .expect("a boundary");
    assert_eq!(brep.moved(), None);
    brep.measure().volume
}

/// Sides of a polygon that is scaled unevenly on its way up are saddles: the volume is the area times
/// the integral of (1 + (a - 1) t)(1 + (b - 1) t). Not all that end in a ridge, on which many saddles meet,
/// are told, nor some whose scales are nearly the same.
#[test]
fn polygons_scaled_unevenly_are_exact() {
    let mut random = Random(3);
    let (mut told, cases) = (0, 60);
    for case in 0..cases {
        let mut number = |from: f64, to: f64| from + (to - from) * random.unit();
        let corners = 3 + case % 5;
        let profile = Profile::regular_polygon(corners, 1.0)
            .scale_xy([number(0.5, 2.0), number(0.5, 2.0)])
            .rotate(number(0.0, TAU));
        let area = profile.area(1e-9).expect("an area");
        let [a, b] = [number(0.2, 1.8), [number(0.2, 1.8), 0.0][case % 2]];
        let share = 1.0 + 0.5 * (a + b - 2.0) + (a - 1.0) * (b - 1.0) / 3.0;
        let solid = Solid::extrude_scaled(&profile, 0.0..3.0, [a, b]);
        let program = Program::lower(&solid).expect("valid");
        let Ok(brep) = program.boundary(&BoundaryOptions::new()) else {
            assert!(b == 0.0 || (a - b).abs() < 0.01, "{case}: {a} {b}");
            continue;
        };
        told += 1;
        let volume = brep.measure().volume;
        let off = (volume.value - 3.0 * area * share).abs();
        assert!(off <= volume.error.max(1e-13), "{case}: {off:e}");
        assert!(volume.error < 1e-7, "{case}: {}", volume.error);
    }
    assert!(5 * told > 4 * cases, "{told} of {cases}");
}

/// Round outlines end in a ridge, too, with corners on both sides of it that match or do not.
#[test]
fn round_outlines_end_in_a_ridge() {
    let slot = Profile::slot(1.0, 0.3);
    for (profile, area) in [
        (
            Profile::rounded_rectangle([3.0, 2.0], 0.5),
            6.0 - 0.25 * (4.0 - PI),
        ),
        (slot.clone(), 0.6 + 0.09 * PI),
        (slot.rotate(0.4).translate([0.1, 0.2]), 0.6 + 0.09 * PI),
    ] {
        for scale in [[1.0, 0.0], [0.0, 0.7]] {
            let larger = scale[0] + scale[1];
            let solid = Solid::extrude_scaled(&profile, 0.0..2.0, scale);
            let program = Program::lower(&solid).expect("a program");
            let meshed = Mesher::new().mesh(&program).expect("a mesh");
            let (mesh, report) = (meshed.mesh, meshed.report);
            assert_eq!(
                (report.method, &report.fallbacks[..]),
                ("polyhedral", &[][..])
            );
            assert!(report.check.is_manifold() && mesh.triangles.len() < 60_000);
            let expected = 2.0 * area * (0.5 + (larger - 1.0) / 6.0);
            // By chords and flat faces.
            let off = mesh.volume() / expected - 1.0;
            assert!(off.abs() < 1e-3, "{scale:?}: {off}");
        }
    }
}

/// What rounding leaves beside the axis is on it: a half disc by sines and cosines is a ball.
#[test]
fn corners_beside_the_axis_are_on_it() {
    let cylinder = |off: f64| {
        let rounding = off.abs().min(1e-15);
        Profile::polygon([
            [off, 0.0],
            [5.0, rounding],
            [5.0, 5.0],
            [-off, 5.0 - rounding],
        ])
    };
    for off in [0.0, 6e-17, 3e-16, 1e-12, 1e-9, -3e-16] {
        for (radians, share) in [(TAU, 1.0), (PI, 0.5), (5.0, 5.0 / TAU)] {
            let volume = exact(&Solid::revolve_by(&cylinder(off), radians));
            let expected = 125.0 * PI * share;
            // (The corners are off their places by as much.)
            let allowed = volume.error + 200.0 * off.abs();
            assert!(
                (volume.value - expected).abs() <= allowed,
                "{off} {radians}"
            );
        }
        let steps = Solid::revolve_in_steps(&cylinder(off), TAU, 8);
        let expected = 4.0 * 125.0 * std::f64::consts::FRAC_PI_4.sin();
        assert!((exact(&steps).value - expected).abs() <= 1e-12 + 200.0 * off.abs());
    }
    let beyond = Solid::revolve(&cylinder(-1e-6));
    let fault = Program::lower(&beyond).expect_err("beyond the axis");
    assert!(matches!(
        fault,
        Error::InvalidNode {
            fault: NodeFault::Profile(ProfileFault::BeyondAxis { .. }),
            ..
        }
    ));
}

#[test]
fn revolutions() {
    let vase = Path::from([0.0, 0.0])
        .line_to([1.0, 0.0])
        .line_to([1.5, 1.0])
        .line_to([0.7, 2.0])
        .line_to([0.7, 2.5])
        .line_to([0.5, 2.5])
        .line_to([0.5, 2.0])
        .line_to([1.2, 1.0])
        .line_to([0.8, 0.3])
        .line_to([0.0, 0.3])
        .close();
    let frustum = |a: f64, b: f64, h: f64| PI * h / 3.0 * (a * a + a * b + b * b);
    let vase_volume = frustum(1.0, 1.5, 1.0) + frustum(1.5, 0.7, 1.0) + frustum(0.7, 0.7, 0.5)
        - frustum(0.8, 1.2, 0.7)
        - frustum(1.2, 0.5, 1.0)
        - frustum(0.5, 0.5, 0.5);
    let half_disc = Profile::circle(1.0) & Profile::rectangle_between([0.0, -2.0], [2.0, 2.0]);
    let washer = Profile::rectangle_between([1.0, 0.0], [2.0, 0.5]);
    let diamond = Profile::polygon([[1.0, 0.0], [1.5, -0.5], [2.0, 0.0], [1.5, 0.5]]);
    let bullet = Path::from([0.0, 0.0])
        .line_to([1.0, 0.0])
        .line_to([1.0, 2.0])
        .arc_to([0.0, 3.0], FRAC_PI_2)
        .close();
    for (what, profile, volume) in [
        ("vase", vase, vase_volume),
        ("ball", half_disc, 4.0 / 3.0 * PI),
        ("washer", washer, 1.5 * PI),
        ("diamond", diamond, TAU * 1.5 * 0.5),
        ("bullet", bullet, 2.0 * PI + 2.0 / 3.0 * PI),
    ] {
        assert_volume(what, &Solid::revolve(&profile), volume);
        for share in [0.2, 0.5, 0.8] {
            let part = Solid::revolve_by(&profile, TAU * share);
            assert_volume(&format!("{share} {what}"), &part, volume * share);
        }
        let other = Program::lower(&Solid::revolve_by(&profile, -1.0)).expect("a program");
        let here = Program::lower(&Solid::revolve_by(&profile, 1.0)).expect("a program");
        for k in 0..200 {
            let (side, z) = (turn(k, 200), f64::from(k as u32 % 11) * 0.25 - 0.9);
            let at = |y: f64| [1.3 * side.x, y, z];
            assert_eq!(
                other.contains(at(-1.3 * side.y)),
                here.contains(at(1.3 * side.y))
            );
        }
    }
}

/// A ring of round section is faceted along its section alone.
#[test]
fn tori_are_faceted_to_a_tolerance() {
    let section = Profile::circle(0.3).translate([1.0, 0.0]).flattened(5e-3);
    let ring = Solid::revolve(&section);
    // Pappus, of the polygon.
    assert_volume("ring", &ring, TAU * section.area(1.0).expect("an area"));
}

#[test]
fn flat_steps() {
    let washer = Profile::rectangle_between([1.0, 0.0], [2.0, 0.5]);
    let diamond = Profile::polygon([[1.0, 0.0], [1.5, -0.5], [2.0, 0.0], [1.5, 0.5]]);
    // Each step is a prism whose section shrinks towards the axis.
    for (what, profile, moment) in [("washer", washer, 0.75), ("diamond", diamond, 0.75)] {
        for (angle, steps) in [(TAU, 3), (TAU, 16), (2.0, 5), (4.5, 7), (-1.0, 1)] {
            let solid = Solid::revolve_in_steps(&profile, angle, steps);
            let step = angle.abs() / steps as f64;
            let volume = moment * step.sin() * steps as f64;
            assert_volume(&format!("{what} {angle} {steps}"), &solid, volume);
        }
    }
}

#[test]
fn mistakes_say_where() {
    let circle = Profile::circle(1.0);
    let fault = |solid: &Solid| match Program::lower(&(Solid::cube(1.0) | solid)) {
        Err(Error::InvalidNode { path, fault }) => {
            assert_eq!(path.steps.len(), 2);
            (path.steps[1].kind, fault)
        }
        other => panic!("{other:?}"),
    };
    let (function, found) = fault(&Solid::extrude(&Profile::circle(-1.0), 0.0..1.0));
    assert_eq!(function, "extrude");
    assert!(matches!(
        found,
        NodeFault::Profile(ProfileFault::NotPositive { .. })
    ));
    let (_, found) = fault(&Solid::extrude(&circle, 1.0..1.0));
    assert!(matches!(found, NodeFault::NotPositive { .. }));
    let (_, found) = fault(&Solid::extrude(&circle, 0.0..f64::NAN));
    assert!(matches!(found, NodeFault::NotFinite { .. }));
    let (_, found) = fault(&Solid::extrude_scaled(&circle, 0.0..1.0, [1.0, -1.0]));
    assert!(matches!(found, NodeFault::NotPositive { .. }));
    let (function, found) = fault(&Solid::revolve(&circle));
    assert_eq!(function, "revolve");
    assert!(matches!(found, NodeFault::Profile(ProfileFault::BeyondAxis { x }) if x < -0.99));
    let off = circle.translate([2.0, 0.0]);
    let (_, found) = fault(&Solid::revolve_by(&off, 7.0));
    assert!(matches!(found, NodeFault::AngleOutOfRange { .. }));
    let (_, found) = fault(&Solid::revolve_in_steps(&off, TAU, 2));
    assert!(matches!(found, NodeFault::TooFewSteps { .. }));
}

/// Walls with merlons of whole sizes, turned: their tops and bottoms are in line but for rounding,
/// and have the area that their corners say.
#[test]
fn turned_battlements_have_their_areas() {
    let mut state = 7_u64;
    let mut below = |count: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        ((state >> 33) % count) as f64
    };
    for round in 0..200 {
        let mut corners = vec![DVec2::ZERO];
        let (mut x, mut area) = (0.0, 0.0);
        for _ in 0..2 + below(5) as usize {
            let (height, width) = (10.0 + below(3), 1.0 + below(2));
            corners.extend([x, x + width].map(|x| DVec2::new(x, height)));
            x += width;
            area += width * height;
        }
        corners.push(DVec2::new(x, 0.0));
        corners.dedup();
        let turn = DVec2::from_angle(0.001 * below(6283));
        let wall = Profile::polygon(corners.into_iter().map(|corner| turn.rotate(corner)));
        let program = Program::lower(&Solid::extrude(&wall, 0.0..1.0)).expect("a program");
        let boundary = program
            .boundary(&BoundaryOptions::new())
            .expect("a boundary");
        let volume = boundary.measure().volume;
        assert!(
            (volume.value - area).abs() <= volume.error.max(1e-12 * area),
            "{round}: {volume:?}, not {area}"
        );
    }
}

/// Many lines are a polyhedron: alone, drawn together and with other shapes, which stay exact.
#[test]
fn fine_polygons_are_prisms() {
    let mut random = Random(11);
    for round in 0..6 {
        let count = 60 + 10 * round;
        let wave = 0.3 * random.unit();
        let corner = |k: usize| {
            let radius = 2.0 + wave * (0.5 + random.unit());
            turn(k, count) * radius
        };
        let corners: Vec<DVec2> = (0..count).map(corner).collect();
        let next = corners.iter().cycle().skip(1);
        let area: f64 = corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum();
        let area = 0.5 * area;
        let outline = Profile::polygon(corners.iter().copied());
        let hole = Profile::circle(0.5).translate([0.5, 0.0]);
        let square = Profile::rectangle([1.0, 1.0]).rotate(random.unit());
        let bored = &outline - &hole;
        let framed = &outline - &square;
        let bar = Profile::rectangle_between([0.0, -0.25], [5.0, 0.25]);
        let handled = &outline | &bar;
        let bar_within = (&outline & &bar).exact_area().expect("lines");
        for (what, profile, area) in [
            ("outline", &outline, area),
            ("bored", &bored, area - 0.25 * PI),
            ("framed", &framed, area - 1.0),
            ("handled", &handled, area + 2.5 - bar_within),
        ] {
            let what = format!("{what} {round}");
            for (solid, volume) in [
                (Solid::extrude(profile, 1.0..3.0), 2.0 * area),
                (
                    Solid::extrude_scaled(profile, 0.0..3.0, [0.5, 0.5]),
                    1.75 * area,
                ),
                (Solid::extrude_to_point(profile, 0.0..3.0, [0.0, 0.0]), area),
            ] {
                let boundary = Program::lower(&solid)
                    .and_then(|program| program.boundary(&BoundaryOptions::new()))
                    .unwrap_or_else(|e| panic!("{what}: {e}"));
                let found = boundary.measure().volume;
                let off = (found.value - volume).abs();
                assert!(
                    off <= found.error + 1e-12 * volume && found.error < 1e-9 * volume,
                    "{what}: {found:?}, not {volume}"
                );
            }
            assert_volume(&what, &Solid::extrude(profile, 1.0..3.0), 2.0 * area);
        }
    }
}

/// Around what a closed line winds an odd number of times, by strips between the heights of its corners and
/// crossings.
fn area_by_strips(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let sides: Vec<[DVec2; 2]> = corners.iter().zip(next).map(|(&a, &b)| [a, b]).collect();
    let mut heights: Vec<f64> = corners.iter().map(|corner| corner.y).collect();
    for (k, [a, b]) in sides.iter().enumerate() {
        for [c, d] in &sides[..k] {
            let (u, v) = (b - a, d - c);
            let across = u.perp_dot(v);
            let [s, t] = [v, u].map(|way| (c - a).perp_dot(way) / across);
            if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
                heights.push(a.y + s * u.y);
            }
        }
    }
    heights.sort_by(f64::total_cmp);
    let strips = heights.windows(2).filter(|pair| pair[0] < pair[1]);
    let area = |pair: &[f64]| {
        let y = pair[0].midpoint(pair[1]);
        let crosses = |[a, b]: &&[DVec2; 2]| (a.y > y) != (b.y > y);
        let at = |[a, b]: &[DVec2; 2]| a.x + (y - a.y) * (b.x - a.x) / (b.y - a.y);
        let mut places: Vec<f64> = sides.iter().filter(crosses).map(at).collect();
        places.sort_by(f64::total_cmp);
        let widths = places.chunks_exact(2).map(|pair| pair[1] - pair[0]);
        (pair[1] - pair[0]) * widths.sum::<f64>()
    };
    strips.map(area).sum()
}

/// Polygons whose sides cross many times touch themselves in as many upright edges, with short pieces of
/// sides between them.
#[test]
fn polygons_that_cross_themselves_are_exact() {
    let mut random = Random(5);
    for case in 0..60 / one_in(5) {
        let count = [8, 20, 40, 80][case % 4];
        let mut number = |from: f64, to: f64| from + (to - from) * random.unit();
        let start = number(0.0, TAU);
        let corners: Vec<DVec2> = (0..count)
            .map(|k| match case / 4 % 3 {
                0 => DVec2::new(number(-10.0, 10.0), number(-10.0, 10.0)),
                1 => DVec2::new(number(-4.0, 4.0).round(), number(-4.0, 4.0).round()),
                // Far round: many cross next to one place.
                _ => {
                    10.0 * DVec2::from_angle(
                        start + TAU * (k * (count / 2 - 1)) as f64 / count as f64,
                    )
                }
            })
            .collect();
        let profile = Profile::polygon(corners.iter().copied());
        let area = area_by_strips(&corners);
        let whole = Solid::extrude(&profile, 0.0..3.0);
        let volume = exact(&whole);
        let off = (volume.value - 3.0 * area).abs();
        assert!(off <= volume.error + 1e-11 * area, "{case}: {off:e}");
        assert!(volume.error <= 1e-8 * area, "{case}: {}", volume.error);
        assert_volume(&format!("{case}"), &whole, 3.0 * area);
        let narrow = exact(&Solid::extrude_scaled(&profile, 0.0..3.0, [0.5, 0.5]));
        let off = (narrow.value - 1.75 * area).abs();
        assert!(off <= narrow.error + 1e-11 * area, "{case}: {off:e}");
        let block = Solid::cuboid([4.0, 5.0, 3.0]).translate([number(-3.0, 3.0).round(), 0.5, 2.0]);
        let parts = [exact(&(&whole - &block)), exact(&(&whole & &block))];
        let off = (parts[0].value + parts[1].value - volume.value).abs();
        assert!(off <= 1e-8 * area, "{case}: {off:e}");
    }
}

/// Stepped shafts and bushes, their walls upright but for a hair, or exactly: each step is a frustum.
#[test]
fn walls_upright_but_for_a_hair_are_there() {
    let mut random = Random(5);
    for case in 0..80 {
        let hair = 10f64.powi(-3 - random.below(11) as i32);
        let bore = [0.0, 1.5][random.below(2)];
        let mut off = || hair * [0.0, 1.0, -1.0][random.below(3)];
        let mut corners = vec![[bore, 0.0]];
        let mut height = 0.0;
        for step in 0..2 + case % 3 {
            let radius = [3.0, 4.0, 6.0, 8.0][(case / 3 + 5 * step) % 4];
            corners.push([radius + off(), height]);
            height += 3.0;
            corners.push([radius, height]);
        }
        corners.push([if bore > 0.0 { bore + off() } else { bore }, height]);
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        let frusta = sides.map(|([a, low], [b, high])| (high - low) * (a * a + a * b + b * b));
        let whole = frusta.sum::<f64>() * PI / 3.0;
        let angle = [TAU, FRAC_PI_2, 4.0][case % 3];
        let solid = Solid::revolve_by(&Profile::polygon(corners.clone()), angle);
        let brep = Program::lower(&solid).and_then(|p| p.boundary(&BoundaryOptions::new()));
        let found = brep
            .unwrap_or_else(|e| panic!("{e}: {corners:?}"))
            .measure()
            .volume;
        let volume = whole * angle / TAU;
        assert!(
            (found.value - volume).abs() < 1e-9 * volume,
            "{corners:?}, {angle}: {found:?}, not {volume}"
        );
    }
}

/// Turned steps whose treads rise or fall by a hair: flat cones, on one axis with what they meet. From a
/// millionth on they are level, and that is told.
#[test]
fn treads_level_but_for_a_hair_are_there() {
    let mut random = Random(7);
    for case in 0..80 {
        let hair = 10f64.powi(-2 - random.below(10) as i32);
        let mut off = || hair * [0.0, 1.0, -1.0][random.below(3)];
        let mut corners = vec![[0.0, 0.0], [8.0, off()]];
        let mut height = 0.0;
        for (step, radius) in [8.0, 6.0, 3.0].into_iter().enumerate().skip(case % 2) {
            height += 2.0 + step as f64;
            let within = [6.0, 3.0, 0.0][step];
            corners.push([radius, height + off()]);
            corners.push([within, height + off()]);
        }
        // Between radii the area under a side, turned.
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        let rings = sides
            .map(|([a, low], [b, high])| (a - b) * (low * (2.0 * a + b) + high * (a + 2.0 * b)));
        let volume = rings.sum::<f64>() * PI / 3.0;
        let solid = Solid::revolve(&Profile::polygon(corners.clone()));
        let brep = Program::lower(&solid).and_then(|p| p.boundary(&BoundaryOptions::new()));
        let found = brep
            .unwrap_or_else(|e| panic!("{e}: {corners:?}"))
            .measure();
        let strays = solid.strays().unwrap_or(0.0);
        assert!(strays <= 0.5e-6 * 8.0 + 1e-15, "{corners:?}: {strays}");
        let within = found.volume.error + strays * found.area.value + 1e-11 * volume;
        let off = (found.volume.value - volume).abs();
        assert!(
            off <= within,
            "{corners:?}: {off} beyond {within} of {volume}"
        );
        assert!(within < 2e-5 * volume, "{corners:?}: {within}");
    }
}

/// A disc and a bar beside it that begins tangent to it, drawn in by little on the way: cones whose
/// apex is far away keep the digits of their radii, turned or not.
#[test]
fn discs_drawn_in_by_little_keep_their_digits() {
    let bar = Profile::rectangle([2.95, 0.1]).translate([1.475, 1.05]);
    let profile = bar | Profile::circle(1.0).translate([1.0, 1.1]);
    let area = PI + 0.295 - (0.1 * 0.99f64.sqrt() + 0.1f64.asin());
    for power in 1..10 {
        for sign in [1.0, -1.0] {
            let scale = 1.0 - sign * 10f64.powi(-power);
            let drawn = Solid::extrude_scaled(&profile, 0.0..3.0, [scale, scale]);
            let wanted = area * (1.0 + scale + scale * scale);
            for solid in [
                drawn.clone(),
                drawn
                    .rotate_z(1.0)
                    .rotate_x(0.7)
                    .translate([5.0, -4.0, 3.0]),
            ] {
                let found = measured(&format!("{scale}"), &solid);
                let off = (found.value - wanted).abs();
                assert!(found.error < 1e-9, "{scale}: {found:?}");
                assert!(off <= found.error, "{scale}: {found:?}, not {wanted}");
            }
        }
    }
}
