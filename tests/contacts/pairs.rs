//! Two solids in every kind of contact.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use csg::Solid;
use stereotomy::csg;

/// Their names, and the two.
pub fn pairs() -> Vec<(String, [Solid; 2])> {
    let mut pairs = Vec::new();
    let mut add = |name: &str, a: Solid, b: Solid| pairs.push((name.to_owned(), [a, b]));
    let cube = || Solid::cube(1.0);
    let ball = || Solid::sphere(0.5);
    let rod = |radius: f64| Solid::cylinder(radius, -0.75..0.75);
    let at = |solid: Solid, x: f64, y: f64, z: f64| solid.translate([x, y, z]);
    // On a corner.
    let corner = || {
        let tilt = std::f64::consts::SQRT_2.recip().atan();
        cube().rotate_x(FRAC_PI_4).rotate_y(tilt)
    };

    add(
        "boxes sharing a part of a face",
        cube(),
        at(cube(), 1.0, 0.25, 0.5),
    );
    for (name, gap) in [
        ("1e-6", 1e-6),
        ("1e-9", 1e-9),
        ("1e-12", 1e-12),
        ("1e-15", 1e-15),
    ] {
        let name = |how: &str| format!("boxes face to face but for {name}, {how}");
        let (apart, over) = (
            at(cube(), 1.0 + gap, 0.0, 0.25),
            at(cube(), 1.0 - gap, 0.0, 0.25),
        );
        add(&name("apart"), cube(), apart);
        add(&name("overlapping"), cube(), over);
    }
    let tilted = |angle: f64| at(at(cube(), 0.5, 0.0, 0.0).rotate_z(angle), 0.5, 0.0, 0.25);
    add(
        "boxes face to face but for 1e-10 radian",
        cube(),
        tilted(1e-10),
    );
    add("boxes edge on edge", cube(), at(cube(), 1.0, 1.0, 0.25));
    add(
        "edge on face",
        cube(),
        at(cube().rotate_z(FRAC_PI_4), 0.5 + 0.5f64.sqrt(), 0.0, 0.0),
    );
    add(
        "corner on face",
        cube(),
        at(corner(), 0.5 + 0.75f64.sqrt(), 0.0, 0.0),
    );
    add(
        "corner on edge",
        cube(),
        at(corner(), 0.5 + 0.75f64.sqrt(), 0.5, 0.0),
    );
    add("corner on corner", cube(), at(cube(), 1.0, 1.0, 1.0));
    add("balls side by side", ball(), at(ball(), 1.0, 0.0, 0.0));
    add(
        "ball in a ball, touching",
        ball(),
        at(Solid::sphere(0.25), 0.25, 0.0, 0.0),
    );
    add("ball on a box", cube(), at(ball(), 0.0, 0.0, 1.0));
    add("ball in a box, touching all faces", cube(), ball());
    add(
        "ball through the edges of a box",
        cube(),
        Solid::sphere(0.5f64.sqrt()),
    );
    add(
        "rods side by side",
        rod(0.5),
        at(rod(0.25), 0.75, 0.0, 0.25),
    );
    add(
        "rod in a rod, touching",
        rod(0.5),
        at(rod(0.25), 0.25, 0.0, 0.25),
    );
    add(
        "rods crossing, touching",
        rod(0.5),
        at(rod(0.25).rotate_x(FRAC_PI_2), 0.75, 0.0, 0.0),
    );
    add(
        "rods of one radius crossing",
        rod(0.5),
        rod(0.5).rotate_x(FRAC_PI_2),
    );
    add("rod in a box, touching four faces", cube(), rod(0.5));
    add(
        "rods of one axis and radius",
        rod(0.5),
        at(rod(0.5), 0.0, 0.0, 0.5),
    );
    for (name, off) in [("1e-6", 1e-6), ("1e-10", 1e-10), ("1e-13", 1e-13)] {
        let other = at(rod(0.5 + off), 0.0, 0.0, 0.5);
        add(
            &format!("rods of one axis, radii off by {name}"),
            rod(0.5),
            other,
        );
    }
    add(
        "nearly coaxial rods",
        rod(0.5),
        at(rod(0.5), 1e-10, 0.0, 0.5),
    );
    let cone = || Solid::frustum(0.5, 0.0, -1.0..0.0);
    add("apex on a face", at(cube(), 0.0, 0.0, 0.5), cone());
    add("apex on a rim", at(rod(0.5), 0.5, 0.0, 0.75), cone());
    add(
        "apex on a rod",
        at(rod(0.5).rotate_x(FRAC_PI_2), 0.0, 0.0, 0.5),
        cone(),
    );
    add("apex on apex", cone(), cone().rotate_x(2.0 * FRAC_PI_2));
    add("cones along a ruling", cone(), at(cone(), -0.25, 0.0, -0.5));
    let half = 0.5f64.atan();
    add(
        "cones of one apex along a ruling",
        cone(),
        cone().rotate_y(2.0 * half),
    );
    add(
        "cone in a rod with its rim",
        rod(0.5),
        at(cone(), 0.0, 0.0, 0.25),
    );
    let touching = Solid::cylinder(0.75, -1.25..1.25).rotate_x(FRAC_PI_2);
    let touching = at(touching, -0.75, 0.0, -0.75);
    let post = at(Solid::cylinder(1.0, -1.5..0.75), 0.0, 1.0, 0.0);
    let block = at(Solid::cuboid([1.5, 1.0, 1.5]), 0.0, -0.5, -0.5);
    add(
        "rod and post touching a block in a line",
        touching | post,
        block,
    );
    add(
        "ellipsoid touching a ball in a circle",
        ball(),
        Solid::ellipsoid([0.5, 0.5, 0.75]),
    );
    add("ball in a box", cube(), Solid::sphere(0.25));
    add(
        "the same box twice",
        cube(),
        cube().rotate_x(0.3).rotate_x(-0.3),
    );
    add(
        "the same ball twice",
        ball(),
        at(at(ball(), 10.0, 0.3, 0.1), -10.0, -0.3, -0.1),
    );
    add(
        "balls that differ by 1e-12",
        ball(),
        Solid::sphere(0.5 - 1e-12),
    );
    add(
        "ball and what is left of a box about it",
        cube() - Solid::sphere(0.25),
        Solid::sphere(0.25),
    );
    add(
        "boxes overlapping by 1e-4",
        cube(),
        at(cube(), 0.9999, 0.2, 0.1),
    );
    add(
        "wedge of 1e-3 radian",
        cube(),
        at(cube().rotate_z(1e-3), 0.0, 1.0, 0.0),
    );
    let needle = Solid::cuboid([1e3, 1e-3, 1e-3]);
    add(
        "needle a million times as long as thick",
        cube(),
        at(needle, 0.0, 0.1, 0.2),
    );
    let cubes = (0..27).map(|i| {
        let place = [i % 3, i / 3 % 3, i / 9].map(|k| f64::from(k) - 1.0);
        cube().translate(place)
    });
    let turned = |solid: Solid| solid.rotate_x(0.4).rotate_z(1.1);
    add(
        "27 cubes turned together",
        turned(Solid::union(cubes)),
        turned(at(cube(), 2.0, 0.0, 0.0)),
    );
    pairs
}
