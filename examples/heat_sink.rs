//! A heat sink: a finned profile extruded, with slots across and screw holes:
//! `cargo run --release --example heat_sink -- render -o heat_sink.png`.

use std::process::ExitCode;

use stereotomy::csg::{Profile, Solid};

const FINS: u32 = 11;

fn heat_sink() -> Solid {
    let base = Profile::rectangle_between([-33.0, 0.0], [33.0, 6.0]);
    let fin = Profile::slot(22.0, 1.0).rotate(90f64.to_radians());
    let fins = (0..FINS).map(|k| {
        let x = -30.0 + 6.0 * f64::from(k);
        fin.translate([x, 16.0])
    });
    let section = Profile::union(std::iter::once(base).chain(fins));
    let body = Solid::extrude(&section, -30.0..30.0).rotate_x(90f64.to_radians());
    let across = Solid::cuboid_between([-40.0, -1.5, 8.0], [40.0, 1.5, 40.0]);
    let slots = Solid::union([-10.0, 10.0].map(|y| across.translate([0.0, y, 0.0])));
    let hole = Solid::cylinder(1.6, -1.0..8.0) | Solid::frustum(1.6, 3.2, 4.4..6.01);
    let holes = [[-24.0, -20.0], [24.0, -20.0], [-24.0, 20.0], [24.0, 20.0]];
    let holes = Solid::union(holes.map(|[x, y]| hole.translate([x, y, 0.0])));
    body.named("body") - slots.named("slots") - holes.named("holes")
}

fn main() -> ExitCode {
    cli::run(heat_sink)
}
