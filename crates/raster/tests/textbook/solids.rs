//! Planes, quadrics and primitives as half-spaces f(x, y, z) <= 0.

use csg::{Program, Solid};
use glam::DVec3;

/// Surfaces of several solids together: those with the same equation are one.
fn surfaces(solids: &[Solid]) -> usize {
    let all = solids.iter().skip(1).fold(solids[0].clone(), |all, solid| {
        all | solid.translate([0.0; 3])
    });
    Program::lower(&all).unwrap().surfaces().len()
}

/// (x - a)^2 + (y - b)^2 + (z - c)^2 - r^2 = 0 is a x^2 + b y^2 + c z^2 + d xy + e yz +
/// f zx + p x + q y + r z + s = 0, and ax + by + cz + d = 0 one of these, too.
#[test]
fn equations_are_the_primitives() {
    let (centre, r) = (DVec3::new(0.5, -0.25, 2.0), 1.5);
    let c = centre * -2.0;
    let rest = centre.length_squared() - r * r;
    let sphere = Solid::sphere(r).translate(centre);
    let quadric = Solid::quadric([1.0, 1.0, 1.0, 0.0, 0.0, 0.0, c.x, c.y, c.z, rest]);
    assert_eq!(surfaces(&[sphere, quadric]), 1);
    // 2x - y + 2z - 6 = 0 is 2 from the origin.
    let plane = Solid::quadric([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, -1.0, 2.0, -6.0]);
    assert_eq!(
        surfaces(&[Solid::half_space([2.0, -1.0, 2.0], 2.0), plane]),
        1
    );
}

/// P_cyl = (x^2 + y^2 - r^2 <= 0) and (z - h <= 0) and (-z <= 0).
#[test]
fn a_cylinder_is_three_half_spaces() {
    let (r, h) = (0.75, 2.0);
    let f = |linear: [f64; 4], square: f64| {
        let [x, y, z, constant] = linear;
        Solid::quadric([square, square, 0.0, 0.0, 0.0, 0.0, x, y, z, constant])
    };
    let printed = f([0.0, 0.0, 0.0, -r * r], 1.0)
        & f([0.0, 0.0, 1.0, -h], 0.0)
        & f([0.0, 0.0, -1.0, 0.0], 0.0);
    let cylinder = Solid::cylinder(r, 0.0..h);
    assert_eq!(surfaces(&[printed.clone(), cylinder]), 3);
    let program = Program::lower(&printed).unwrap();
    for (point, inside) in [
        (DVec3::new(0.7, 0.2, 1.0), true),
        (DVec3::new(0.7, 0.3, 1.0), false),
        (DVec3::new(0.0, 0.0, 1.9), true),
        (DVec3::new(0.0, 0.0, 2.1), false),
        (DVec3::new(0.0, 0.0, -0.1), false),
    ] {
        assert_eq!(program.contains(point), inside, "{point}");
    }
}
