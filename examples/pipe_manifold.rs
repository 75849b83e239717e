//! A manifold: pipes with flanges off one main pipe, all hollow:
//! `cargo run --release --example pipe_manifold -- --outlets 4 render -o manifold.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::csg::Solid;

#[derive(Clone, Copy, clap::Args)]
struct Arguments {
    /// How many outlets
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=8))]
    outlets: u32,
    /// Inner radius of the outlets in millimetres, less than that of the main pipe (14)
    #[arg(long, default_value_t = 9.0)]
    bore: f64,
}

const MAIN: f64 = 14.0;
const WALL: f64 = 3.0;
const APART: f64 = 48.0;

/// A pipe up the z axis with a flange at its end, and its bore.
fn pipe(radius: f64, height: f64) -> (Solid, Solid) {
    let flange = Solid::cylinder(radius + WALL + 9.0, height - 5.0..height);
    let hole = Solid::cylinder(2.2, height - 6.0..height + 1.0);
    let holes = hole
        .translate_xyz(radius + WALL + 4.5, 0.0, 0.0)
        .polar_pattern(4);
    let outside = Solid::cylinder(radius + WALL, 0.0..height) | (flange - holes.named("bolts"));
    (outside, Solid::cylinder(radius, 0.0..height + 1.0))
}

fn manifold(arguments: Arguments) -> Solid {
    let count = arguments.outlets as usize;
    let length = APART * f64::from(arguments.outlets);
    let (outlet, bore) = pipe(arguments.bore, 45.0);
    let row = |solid: &Solid| solid.linear_pattern(count, [APART, 0.0, 0.0]);
    let along = |solid: &Solid, x: f64| solid.rotate_y_degrees(90.0).translate_xyz(x, 0.0, 0.0);
    let (inlet, main_bore) = pipe(MAIN, length - 0.5 * APART + 12.0);
    let start = -0.5 * APART;
    let body = along(&Solid::cylinder(MAIN + WALL, 0.0..10.0), start)
        | along(&inlet, start)
        | row(&outlet);
    let hollow = along(&main_bore, start + WALL) | row(&bore);
    body.named("pipes") - hollow.named("bores")
}

fn main() -> ExitCode {
    cli::run_with(manifold)
}
