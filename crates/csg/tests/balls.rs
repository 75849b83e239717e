//! Balls, of which most meet nothing: whole faces that need not be looked for.

use csg::{BoundaryOptions, Mesher, Program, Solid};
use glam::DVec3;

use crate::random::Random;
use crate::sweeps::one_in;

/// United and subtracted balls in and around a cube, nested, apart, touching or crossing each other, of
/// one size or of many, sometimes mapped to what only rounding knows to be balls.
fn solid(random: &mut Random) -> Solid {
    let count = 1 + random.below(90);
    let place = |random: &mut Random| {
        let [x, y, z] = [(); 3].map(|()| 2.4 * random.unit() - 1.2);
        DVec3::new(x, y, z)
    };
    let is_even = random.below(3) == 0;
    let mut parts: Vec<(bool, Solid)> = Vec::new();
    let mut last = (DVec3::ZERO, 0.1);
    for _ in 0..count {
        let (mut center, mut radius) = (place(random), 0.02 + 0.15 * random.unit());
        if is_even {
            radius = 0.06;
        }
        match random.below(8) {
            // Around the last one, within it, beside it, and as large.
            0 => (center, radius) = (last.0, 1.3 * last.1),
            1 => (center, radius) = (last.0, 0.7 * last.1),
            2 => center = last.0 + (last.1 + radius) * DVec3::Z,
            3 => radius = last.1,
            _ => {}
        }
        last = (center, radius);
        let ball = match random.below(6) {
            0 => Solid::sphere(1.0)
                .scale(radius)
                .rotate_x(random.unit())
                .rotate_z(random.unit()),
            _ => Solid::sphere(radius),
        };
        let ball = match random.below(4) {
            0 => ball.named(["red", "green"][random.below(2)]),
            _ => ball,
        };
        parts.push((random.below(2) == 0, ball.translate(center)));
    }
    let mut solid = match random.below(4) {
        0 => Solid::sphere(1.0),
        1 => Solid::sphere(0.001).translate([5.0, 0.0, 0.0]),
        2 => Solid::cylinder(1.0, -1.0..0.8),
        _ => Solid::cube(2.0),
    };
    for (is_added, ball) in parts {
        solid = if is_added { solid | ball } else { solid - ball };
    }
    solid
}

/// The mesh has as many bodies and handles, and what is on it, as the exact boundary, which is found
/// in another way.
#[test]
fn whole_ones_are_where_the_boundary_has_them() {
    let step = one_in(7);
    let mut whole = 0;
    for seed in (0..60).step_by(step) {
        let mut random = Random(seed);
        let solid = solid(&mut random);
        let program = Program::lower(&solid).expect("valid");
        let brep = program.boundary(&BoundaryOptions::new()).expect("decided");
        let meshed = Mesher::new()
            .tolerance(0.01)
            .mesh(&program)
            .expect("a mesh");
        let (mesh, report) = (&meshed.mesh, &meshed.report);
        assert!(
            report.check.is_closed() && report.is_proven(),
            "{seed}: {report:?}"
        );
        assert_eq!(mesh.components().count, brep.shells().len(), "{seed}");
        let genus: usize = brep.shells().map(|shell| shell.genus()).sum();
        let euler = 2 * (brep.shells().len() as i64 - genus as i64);
        assert_eq!(mesh.check().euler_characteristic(), euler, "{seed}");
        let (found, truth) = (mesh.measure(), brep.measure());
        let off = (found.volume - truth.volume.value).abs();
        let most = 0.01 * truth.area.value * 1.1;
        assert!(off <= most, "{seed}: {} for {}", found.volume, truth.volume);
        let names = |names: &mut dyn Iterator<Item = Option<String>>| {
            names.collect::<std::collections::BTreeSet<_>>()
        };
        let of_mesh = names(
            &mut mesh
                .surfaces
                .iter()
                .map(|s| s.name.as_deref().map(str::to_owned)),
        );
        let of_brep = names(
            &mut brep
                .faces()
                .map(|f| f.origin().name.as_deref().map(str::to_owned)),
        );
        assert_eq!(of_mesh, of_brep, "{seed}");
        whole += brep
            .faces()
            .filter(|face| face.edges().next().is_none())
            .count();
    }
    assert!(whole * step > 250, "{whole}");
}
