//! Solids that are hard to mesh to a tolerance: thin walls, wires and slots,
//! sharp wedges and spikes, apexes, surfaces that touch. Each promise is kept,
//! or the report names the place where it is not.

use std::f64::consts::{PI, TAU};
use std::time::Instant;

use csg::{Meshed, Mesher, Plane, Program, Solid};
use glam::{DVec3, dvec3};
use stereotomy::csg;

use super::defects;
use super::tolerance::distance;
use crate::random::Random;

/// A solid and what is known of it.
struct Case {
    name: String,
    solid: Solid,
    volume: f64,
    parts: usize,
    genus: i64,
    /// What tolerances are relative to.
    size: f64,
}

impl Case {
    fn new(name: &str, solid: Solid, volume: f64, parts: usize, genus: i64) -> Self {
        Self {
            name: name.to_owned(),
            solid,
            volume,
            parts,
            genus,
            size: 1.0,
        }
    }

    /// With a ball aside, so that it is not bounded by planes alone.
    fn beside_a_ball(self) -> Self {
        const RADIUS: f64 = 0.3;
        let ball = Solid::sphere(RADIUS).translate([0.0, -2.0, 0.0]);
        Self {
            solid: self.solid | ball,
            volume: self.volume + 4.0 / 3.0 * PI * RADIUS.powi(3),
            parts: self.parts + 1,
            ..self
        }
    }

    fn turned(&self) -> Self {
        Self {
            name: format!("{} turned", self.name),
            solid: self.solid.rotate_xyz(0.3, 0.5, 0.7),
            ..*self
        }
    }

    fn scaled(&self, by: f64) -> Self {
        Self {
            name: format!("{} by {by}", self.name),
            solid: self.solid.scale(by),
            volume: self.volume * by.powi(3),
            size: self.size * by,
            ..*self
        }
    }
}

/// What is wrong with a mesh of a case that its report does not say; and
/// whether it reports anything.
fn complaints(case: &Case, tolerance: f64) -> (Vec<String>, Meshed) {
    let program = Program::lower(&case.solid).expect("a valid solid");
    let mesher = Mesher::new().tolerance(tolerance);
    let meshed = mesher.mesh(&program);
    let meshed = meshed.unwrap_or_else(|e| panic!("{}: {e}", case.name));
    let Meshed { mesh, report, .. } = &meshed;
    let mut wrong = Vec::new();
    if !report.check.is_manifold() {
        wrong.push(report.check.to_string());
    }
    let says = |words: &str| report.fallbacks.iter().any(|f| f.kind.contains(words));
    let crossings = mesh.self_intersections().len();
    if crossings > 0 && !says("runs through itself") {
        wrong.push(format!("{crossings} crossings"));
    }
    if report.fallbacks.is_empty() {
        let off = (mesh.volume() - case.volume).abs();
        if off > mesh.area() * tolerance + 1e-12 * case.volume {
            wrong.push(format!("volume off by {off:e} of {:e}", case.volume));
        }
        let deviation = report.deviation.unwrap_or(f64::INFINITY);
        if deviation > tolerance {
            wrong.push(format!("deviation {deviation:e}"));
        }
        let (parts, genus) = (report.check.components, report.check.genus());
        if (parts, genus) != (case.parts, Some(case.genus)) {
            wrong.push(format!("{parts} parts of genus {genus:?}"));
        }
        let defects = defects::measure(&program, mesh);
        if defects.folded > 0 {
            wrong.push(format!("{} folds: {:?}", defects.folded, defects.places));
        }
    }
    (wrong, meshed)
}

/// Asserts it of all cases, at home and turned, to some relative tolerances. At
/// least so many of the meshes must keep everything, with nothing to report.
fn assert_kept_or_named(cases: &[Case], tolerances: &[f64], perfect: usize) {
    let mut failures = Vec::new();
    let mut reported = Vec::new();
    let mut without_report = 0;
    for case in cases
        .iter()
        .flat_map(|case| [case.turned(), case.scaled(1.0)])
    {
        for &tolerance in tolerances {
            let (wrong, meshed) = complaints(&case, tolerance * case.size);
            let name = format!("{} to {tolerance:e}", case.name);
            if !wrong.is_empty() {
                let fallbacks = &meshed.report.fallbacks;
                failures.push(format!("{name}: {} {fallbacks:?}", wrong.join(", ")));
            }
            match &meshed.report.fallbacks[..] {
                [] => without_report += 1,
                [first, ..] => reported.push(format!("{name}: {first}")),
            }
        }
    }
    assert!(
        failures.is_empty() && without_report >= perfect,
        "{}\n{without_report} without a report\n{}",
        failures.join("\n"),
        reported.join("\n")
    );
}

fn pyramid(sides: u32, radius: f64, height: f64) -> (Solid, f64) {
    let apex = DVec3::Z * height;
    let side = |k: u32| {
        let angle = TAU * f64::from(k) / f64::from(sides);
        Plane::through(apex, dvec3(angle.cos(), angle.sin(), radius / height))
    };
    let base = Plane::through(DVec3::ZERO, -DVec3::Z);
    let solid = Solid::convex_polyhedron((0..sides).map(side).chain([base]));
    let n = f64::from(sides);
    (solid, n * radius * radius * (PI / n).tan() * height / 3.0)
}

/// The wall between two meshes of spheres about the origin is, everywhere, as
/// thick as it should be to within a half.
#[test]
fn shells_are_whole_to_a_quarter_of_their_thickness() {
    for thickness in [1e-2, 1e-3, 1e-4] {
        let solid = Solid::sphere(1.0) - Solid::sphere(1.0 - thickness);
        let volume = 4.0 / 3.0 * PI * (1.0 - (1.0 - thickness).powi(3));
        let case = Case::new("shell", solid, volume, 2, 0);
        let tolerance = 0.25 * thickness;
        let (wrong, meshed) = complaints(&case, tolerance);
        assert_eq!(wrong, [""; 0], "{thickness}");
        assert_eq!(meshed.report.fallbacks, [], "{thickness}");
        let mesh = &meshed.mesh;
        // For the inner and the outer wall: the least distance of a triangle,
        // and the greatest of a corner, from the centre.
        let mut radii = [(f64::INFINITY, 0.0f64); 2];
        for triangle in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(triangle);
            let plane = a.dot((b - a).cross(c - a).normalize());
            let (least, greatest) = &mut radii[usize::from(plane > 0.0)];
            *least = least.min(distance(DVec3::ZERO, [a, b, c]));
            *greatest = [a, b, c]
                .map(DVec3::length)
                .into_iter()
                .fold(*greatest, f64::max);
        }
        let [inner, outer] = radii;
        let (thinnest, thickest) = (outer.0 - inner.1, outer.1 - inner.0);
        assert!(
            thinnest > 0.5 * thickness && thickest < 1.5 * thickness,
            "{thickness}: {thinnest} to {thickest}"
        );
    }
}

#[test]
fn wires_slots_walls_and_pin_holes_are_kept_or_named() {
    let radius = 0.5e-3;
    let wire = Solid::cylinder(radius, -0.7..0.7);
    let wired = Case::new(
        "wire",
        Solid::cube(1.0) | wire,
        1.0 + 0.4 * PI * radius * radius,
        1,
        0,
    );
    let half = 0.5e-4;
    let slot = Solid::cuboid([2.0 * half, 3.0, 3.0]);
    let left = PI - 2.0 * (half * (1.0 - half * half).sqrt() + half.asin());
    let slotted = Case::new("slot", Solid::cylinder(1.0, 0.0..1.0) - slot, left, 2, 0);
    let walls = Solid::cube(1.0) - Solid::cube(1.0 - 2e-6);
    let walls = Case::new("box of walls", walls, 1.0 - (1.0 - 2e-6f64).powi(3), 2, 0);
    let cases = [wired, slotted, walls.beside_a_ball()];
    assert_kept_or_named(&cases, &[1e-3, 1e-4], 12);

    let mut random = Random::new(1);
    let pins = (0..1000).map(|i| {
        let jitter = 0.4 * random.unit();
        let place = [f64::from(i % 40), f64::from(i / 40), 0.0].map(|k| 0.02 * (k + jitter) - 0.4);
        Solid::cylinder(radius, -1.0..1.0).translate(place)
    });
    let plate = Solid::cuboid([1.0, 1.0, 0.01]) - Solid::union(pins.collect::<Vec<_>>());
    let volume = 0.01 * (1.0 - 1000.0 * PI * radius * radius);
    let pierced = Case::new("pin holes", plate, volume, 1, 1000);
    let (wrong, meshed) = complaints(&pierced, 1e-4);
    assert_eq!(wrong, [""; 0], "{:?}", meshed.report.fallbacks);
    assert_eq!(meshed.report.check.genus(), Some(1000));
    let off = (meshed.mesh.volume() - volume).abs();
    assert!(off <= 1e-4 * meshed.mesh.area(), "{off}");
}

/// Two planes whose ridge is where no cell expects it.
#[test]
fn wedges_are_kept_or_named_at_every_scale() {
    let mut cases = Vec::new();
    for degrees in [30f64, 10.0, 1.0] {
        let height = degrees.to_radians().tan();
        let wedge = Solid::prism([[0.0, 0.0], [1.0, 0.0], [1.0, height]], 0.0..1.0);
        let alone = Case::new(&format!("wedge of {degrees}"), wedge, 0.5 * height, 1, 0);
        let case = alone.beside_a_ball();
        cases.extend([1e-3, 1.0, 1e3].map(|scale| case.scaled(scale)));
    }
    assert_kept_or_named(&cases, &[1e-3], 18);
}

#[test]
fn spikes_and_many_planes_through_a_point_are_kept_or_named() {
    let mut cases = Vec::new();
    for (sides, radius, height) in [(12, 0.05, 2.0), (12, 1e-3, 1.0), (30, 1.0, 1.0)] {
        let (solid, volume) = pyramid(sides, radius, height);
        let name = format!("{sides} planes, {radius} wide");
        cases.push(Case::new(&name, solid, volume, 1, 0).beside_a_ball());
    }
    assert_kept_or_named(&cases, &[1e-2, 1e-3, 1e-4], 18);
}

#[test]
fn cut_apexes_are_kept_or_named() {
    let cone = Solid::cone(1.0, 0.0..2.0);
    let third = 2.0 * PI / 3.0;
    let nappe = Solid::cone(0.75, 0.0..1.0);
    let double = &nappe | nappe.rotate_x(PI).translate([0.0, 0.0, 2.0]);
    let nappe_volume = 0.75f64.powi(2) * PI / 3.0;
    let halves = Solid::half_space([1.0, 0.3, 0.0], 0.0);
    let slit = Solid::cuboid([4.0, 4.0, 2e-3]).translate([0.0, 0.0, 1.0]);
    let taken = 2.0 * nappe_volume * 1e-9;
    let above = Solid::half_space([0.0, 0.0, 1.0], 2.0 - 1e-3);
    let cases = [
        Case::new("half a cone", &cone & &halves, 0.5 * third, 1, 0),
        Case::new(
            "cone without its tip",
            &cone & above,
            third * (1.0 - 0.125e-9),
            1,
            0,
        ),
        Case::new("double cone", double.clone(), 2.0 * nappe_volume, 2, 0),
        Case::new("half a double cone", &double & &halves, nappe_volume, 2, 0),
        Case::new(
            "double cone cut apart",
            &double - slit,
            2.0 * nappe_volume - taken,
            2,
            0,
        ),
    ];
    assert_kept_or_named(&cases, &[1e-2, 1e-3, 1e-4], 30);
}

#[test]
fn surfaces_that_touch_are_kept_or_named() {
    let drum = Solid::cylinder(1.0, 0.0..1.0);
    let bore = Solid::cylinder(0.5, -1.0..2.0).translate([0.5, 0.0, 0.0]);
    let ball = 4.0 / 3.0 * PI;
    let small = Solid::sphere(0.5).translate([0.5, 0.0, 0.0]);
    let plate = Solid::cuboid([3.0, 3.0, 0.5]).translate([0.0, 0.0, -1.25]);
    let cases = [
        Case::new("tangent bore", &drum - bore, 0.75 * PI, 1, 0),
        Case::new(
            "ball in a box",
            Solid::cube(2.0) - Solid::sphere(1.0),
            8.0 - ball,
            2,
            0,
        ),
        Case::new(
            "ball in a ball",
            Solid::sphere(1.0) - small,
            0.875 * ball,
            2,
            0,
        ),
        Case::new(
            "ball on a plate",
            Solid::sphere(1.0) | plate,
            ball + 4.5,
            2,
            0,
        ),
        Case::new(
            "capsule",
            Solid::cylinder(0.5, 0.0..1.0)
                | Solid::sphere(0.5)
                | Solid::sphere(0.5).translate([0.0, 0.0, 1.0]),
            PI * (0.25 + 1.0 / 6.0),
            1,
            0,
        ),
    ];
    assert_kept_or_named(&cases, &[1e-3], 9);
}

/// What is smaller than what is looked for is in the mesh or in the report, at
/// its place; it does not vanish without a word.
#[test]
fn what_is_smaller_than_the_smallest_feature_is_reported() {
    let place = dvec3(0.217, 0.131, 0.553);
    let block = Solid::cube(1.0);
    let speck = Solid::sphere(0.004);
    let features = [
        (
            "speck",
            &block | speck.translate([0.0, 0.0, 0.8]),
            [0.0, 0.0, 0.8],
        ),
        (
            "bubble",
            &block - speck.translate(place - 0.2),
            (place - 0.2).into(),
        ),
        (
            "bubble in a ball",
            Solid::sphere(1.0) - speck.translate(place),
            place.into(),
        ),
        (
            "dent",
            &block - speck.translate([0.217, 0.131, 0.5]),
            [0.217, 0.131, 0.5],
        ),
        (
            "pin hole",
            &block - Solid::cylinder(0.002, -1.0..1.0).translate([0.217, 0.131, 0.0]),
            [0.217, 0.131, -0.5],
        ),
    ];
    for (name, solid, place) in features {
        let place = DVec3::from(place);
        let program = Program::lower(&solid).expect("a valid solid");
        for smallest in [0.02, 0.1] {
            let mesher = Mesher::new().smallest_feature(smallest);
            for mesher in [mesher.clone(), mesher.tolerance(smallest)] {
                let Meshed { mesh, report, .. } = mesher.mesh(&program).expect("a mesh");
                let mut vertices = mesh.positions.iter();
                let is_meshed = vertices.any(|p| p.distance(place) < 0.02);
                let mut places = report.fallbacks.iter().flat_map(|f| &f.places);
                let is_reported = places.any(|p| p.distance(place) < 2.0 * smallest);
                assert!(
                    is_meshed || is_reported,
                    "{name} at {smallest}: {:?}",
                    report.fallbacks
                );
            }
        }
    }
}

/// A ball that touches a spheroid all around is tried in several ways.
#[test]
fn stages_take_the_whole_time_with_tries_that_fail() {
    let lens = Solid::ellipsoid([1.0, 1.0, 2.0]) - Solid::sphere(1.0);
    let program = Program::lower(&lens.rotate_xyz(0.3, 0.5, 0.7)).expect("a valid solid");
    let start = Instant::now();
    let report = Mesher::new().mesh(&program).expect("a mesh").report;
    let whole = start.elapsed().as_secs_f64();
    let told: f64 = report.stages.iter().map(|stage| stage.1).sum();
    assert!(told <= whole && told >= 0.9 * whole, "{told} of {whole}");
}
