//! Sections with planes anywhere, and just beside faces, vertices and seams, against closed forms.

use std::f64::consts::PI;

use csg::glam::{DAffine3, DVec2, DVec3};
use csg::{BoundaryOptions, Join, Profile, Program, Solid};

use crate::random::Random;

/// How far beside what it is next to a plane is.
const BESIDE: [f64; 15] = [
    0.0, 1e-12, -1e-12, 1e-11, -1e-11, 1e-10, -1e-10, 1e-9, -1e-9, 1e-8, -1e-8, 1e-6, -1e-6, 1e-4,
    -1e-4,
];

/// The area of what is just below a plane, or just above where that is nothing.
fn area(what: &str, solid: &Solid, frame: DAffine3) -> f64 {
    let parts = solid
        .cut_at(frame)
        .unwrap_or_else(|e| panic!("{what}: {e}"));
    let area = |part: &Solid| -> f64 {
        let program = Program::lower(part).unwrap_or_else(|e| panic!("{what}: {e}"));
        let brep = program.boundary(&BoundaryOptions::new());
        let brep = brep.unwrap_or_else(|e| panic!("{what}: {e}"));
        let faces = brep.faces().filter(csg::brep::Face::is_in_plane);
        faces.map(|face| face.area().value).sum()
    };
    let areas: Vec<f64> = parts.iter().map(area).collect();
    areas.into_iter().find(|&area| area > 0.0).unwrap_or(0.0)
}

fn across_z(z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::Z * z)
}

/// The plane at a height of y; x is that of the model, and y of the plane its z.
fn across_y(y: f64) -> DAffine3 {
    DAffine3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y, DVec3::Y * y)
}

#[track_caller]
fn assert_area(what: &str, solid: &Solid, frame: DAffine3, wanted: f64, slack: f64) {
    let found = area(what, solid, frame);
    assert!(
        (found - wanted).abs() <= slack,
        "{what}: {found}, not {wanted}"
    );
}

/// Cylinders, frusta and balls along an axis, next to each other.
#[test]
fn lathe_parts_at_and_beside_their_shoulders() {
    let mut random = Random(11);
    for round in 0..12 {
        let count = 2 + random.below(3);
        let mut z = 10.0 * random.unit() - 5.0;
        let mut parts = Vec::new();
        let mut spans: Vec<([f64; 2], [f64; 2])> = Vec::new();
        for _ in 0..count {
            let height = 1.0 + 30.0 * random.unit();
            let [low, high] = [(); 2].map(|()| 2.0 + 10.0 * random.unit());
            let radii = if random.below(2) == 0 {
                [low; 2]
            } else {
                [low, high]
            };
            parts.push(if radii[0] == radii[1] {
                Solid::cylinder(low, z..z + height)
            } else {
                Solid::frustum(low, high, z..z + height)
            });
            spans.push(([z, z + height], radii));
            z += height;
        }
        let solid = Solid::union(parts);
        let [bottom, top] = [spans[0].0[0], z];
        let radius = |z: f64| {
            // Of what is below, where a shoulder is in the plane.
            let span = spans.iter().find(|(ends, _)| z <= ends[1]);
            let (ends, radii) = span.copied().unwrap_or(spans[count - 1]);
            let share = (z - ends[0]) / (ends[1] - ends[0]);
            radii[0] + share * (radii[1] - radii[0])
        };
        let shoulders = spans.iter().map(|(ends, _)| ends[0]).chain([top]);
        for shoulder in shoulders {
            for beside in BESIDE {
                let z = shoulder + beside;
                let what = format!("{round}: z = {shoulder} + {beside:e}");
                // (Within rounding of a shoulder either side may be meant.)
                let is_in = beside.abs() < 2e-12 && z != shoulder;
                if is_in || z > top && beside.abs() < 2e-12 {
                    continue;
                }
                let wanted = match (bottom..=top).contains(&z) {
                    true => PI * radius(z).powi(2),
                    false => 0.0,
                };
                assert_area(&what, &solid, across_z(z), wanted, 1e-9 * (wanted + 100.0));
            }
        }
        for _ in 0..4 {
            let z = bottom + (top - bottom) * random.unit();
            let wanted = PI * radius(z).powi(2);
            let what = format!("{round}: z = {z}");
            assert_area(&what, &solid, across_z(z), wanted, 1e-9 * wanted);
        }
    }
}

/// From where to where a convex polygon that has grown by a radius is at a height.
fn width(corners: &[DVec2], radius: f64, y: f64) -> f64 {
    let far = |sign: f64| -> f64 {
        let next = corners.iter().cycle().skip(1);
        let sides = corners.iter().zip(next);
        let along = |(from, to): (&DVec2, &DVec2)| {
            // Concave along a side: how far right a disc there reaches.
            let at = |t: f64| {
                let point = from.lerp(*to, t);
                let off = y - point.y;
                match off.abs() <= radius {
                    true => sign * point.x + (radius * radius - off * off).sqrt(),
                    false => -off.abs() * 1e6,
                }
            };
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..200 {
                let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
                if at(a) < at(b) { low = a } else { high = b }
            }
            at(low).max(at(0.0)).max(at(1.0))
        };
        sides.map(along).fold(-1e9, f64::max)
    };
    (far(1.0) + far(-1.0)).max(0.0)
}

/// Plates whose corners are round: flat sides go over into arcs, without a corner.
#[test]
fn round_plates_at_and_beside_their_seams() {
    let mut random = Random(5);
    for round in 0..8 {
        let count = 3 + random.below(4);
        let corners: Vec<DVec2> = (0..count)
            .map(|k| {
                let turn = (k as f64 + 0.6 * random.unit()) / count as f64;
                let (sin, cos) = (2.0 * PI * turn).sin_cos();
                DVec2::new(20.0 * cos, 14.0 * sin)
            })
            .collect();
        let radius = 1.0 + 2.0 * random.unit();
        let height = 4.0 + 10.0 * random.unit();
        let profile = Profile::polygon(corners.clone()).offset(radius, Join::Round);
        let solid = Solid::extrude(&profile, 0.0..height);
        let next = corners.iter().cycle().skip(1);
        let seams = corners.iter().zip(next).flat_map(|(from, to)| {
            let out = radius * (*from - *to).perp().normalize();
            [from.y + out.y, to.y + out.y]
        });
        for seam in seams.chain(corners.iter().map(|corner| corner.y)) {
            for beside in BESIDE.into_iter().chain([2e-5, -2e-5, 1e-5, -1e-5]) {
                let y = seam + beside;
                let wanted = height * width(&corners, radius, y);
                let what = format!("{round}: y = {seam} + {beside:e}");
                // (Next to where a side lies in the plane a width is known to half of the digits.)
                assert_area(&what, &solid, across_y(y), wanted, 1e-6 * height * 40.0);
            }
        }
    }
}

/// The pieces of one drawing do not depend on each other.
#[test]
fn faces_just_beside_the_plane_are_not_in_it() {
    let disc = 49.0 * PI;
    let cylinder = Solid::cylinder(7.0, 0.0..35.0);
    let cube = Solid::cuboid([4.0, 40.0, 4.0]).translate([60.0, 0.0, 0.0]);
    let both = &cylinder | &cube;
    for z in [1e-12, 1e-9, 1e-8, 1e-6, 1e-4, 1.0] {
        assert_area(
            &format!("cylinder {z:e}"),
            &cylinder,
            across_z(z),
            disc,
            1e-9,
        );
    }
    for z in [1e-11, 1e-9, 1e-8, 1e-6] {
        assert_area(
            &format!("both {z:e}"),
            &both,
            across_z(z),
            disc + 160.0,
            1e-9,
        );
        assert_area(&format!("both -{z:e}"), &both, across_z(-z), 160.0, 1e-9);
    }
    assert_area("both 0", &both, across_z(0.0), 160.0, 1e-9);
    assert_area("top", &both, across_z(35.0), disc, 1e-9);
    let offset = Profile::polygon([
        [18.0, 0.0],
        [9.5, 16.4545],
        [-8.5, 14.7224],
        [-10.0, 0.0],
        [-6.0, -10.3923],
        [6.5, -11.2583],
    ]);
    let plate = Solid::extrude(&offset.offset(2.0, Join::Round), 0.0..16.0);
    for y in [0.91791, 0.917913, 0.91792, 0.91793, 0.918] {
        assert_area(&format!("plate {y}"), &plate, across_y(y), 507.1, 2e-3);
        let with = &plate | &cube.translate([0.0, 0.0, 5.0]);
        assert_area(&format!("both {y}"), &with, across_y(y), 523.1, 2e-3);
    }
}

/// Cones through their apex, cylinders along and beside their side, balls at their pole.
#[test]
fn curved_faces_where_a_plane_touches_them() {
    let cone = Solid::frustum(5.0, 0.0, 0.0..10.0);
    assert_area("through the apex", &cone, across_y(0.0), 50.0, 1e-9);
    for y in [1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-4] {
        let section = cone.section(across_y(y), 1e-3).expect("a section");
        let found = section.area(1e-3).expect("an area");
        assert!((found - 50.0).abs() < 0.05, "beside it {y:e}: {found}");
    }
    let rod = Solid::cylinder(7.0, 0.0..35.0);
    assert_area("touches", &rod, across_y(7.0), 0.0, 1e-3);
    for depth in [1e-9_f64, 1e-6, 1e-3, 1.0] {
        let half = (49.0 - (7.0 - depth) * (7.0 - depth)).sqrt();
        let what = format!("{depth:e} below");
        assert_area(&what, &rod, across_y(7.0 - depth), 70.0 * half, 1e-4);
        let block = Solid::cuboid([40.0, 40.0, 40.0]) - &rod;
        let what = format!("{depth:e} below in a block");
        let wanted = 1600.0 - 40.0 * half;
        assert_area(&what, &block, across_y(7.0 - depth), wanted, 1e-4);
    }
    let ball = Solid::sphere(3.0);
    for depth in [1e-6, 1e-3, 1.0] {
        let wanted = PI * (9.0 - (3.0 - depth) * (3.0 - depth));
        let what = format!("cap {depth:e}");
        assert_area(&what, &ball, across_z(3.0 - depth), wanted, 1e-9);
    }
    let shell = Profile::circle(4.0) - Profile::circle(3.0);
    let tube = Solid::extrude(&shell, 0.0..10.0);
    for beside in BESIDE {
        let area = area("bore", &tube, across_y(3.0 + beside));
        let wanted = 20.0 * 7.0_f64.sqrt();
        assert!((area - wanted).abs() < 0.6, "{beside:e}: {area}");
    }
}
