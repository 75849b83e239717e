//! A building brick with studs and tubes: `cargo run --release --example brick --
//! --across 2 --along 4 render -o brick.png`, from below with `--camera 0.5,1,-0.8`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::csg::{Color, Solid};

#[derive(Clone, Copy, clap::Args)]
struct Arguments {
    /// Studs across
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=8))]
    across: u32,
    /// Studs along
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=16))]
    along: u32,
}

/// The distance of studs, and the height of a brick, in millimetres.
const PITCH: f64 = 8.0;
const HEIGHT: f64 = 9.6;
const WALL: f64 = 1.5;
const PLAY: f64 = 0.1;

fn brick(arguments: Arguments) -> Solid {
    let counts = [arguments.along as usize, arguments.across as usize, 1];
    let size = [arguments.along, arguments.across].map(|n| PITCH * f64::from(n));
    let [x, y] = size;
    let shell = Solid::cuboid_between([PLAY, PLAY, 0.0], [x - PLAY, y - PLAY, HEIGHT])
        - Solid::cuboid_between([WALL, WALL, -1.0], [x - WALL, y - WALL, HEIGHT - 1.0]);
    let steps = [PITCH, PITCH, 0.0];
    let stud = Solid::cylinder(2.4, HEIGHT - 0.5..HEIGHT + 1.8);
    let half = 0.5 * PITCH;
    let studs = stud
        .grid_pattern(counts, steps)
        .translate_xyz(half, half, 0.0);
    let body = shell.named("shell") | studs.named("studs");
    let body = match counts {
        // Between four studs each.
        [along, across, _] if along > 1 && across > 1 => {
            let tube = Solid::tube(3.25, 2.4, 0.0..HEIGHT - 0.5);
            let tubes = tube.grid_pattern([along - 1, across - 1, 1], steps);
            body | tubes.translate_xyz(PITCH, PITCH, 0.0).named("tubes")
        }
        _ => body,
    };
    body.colored(Color::from_srgb([0.78, 0.16, 0.13]))
}

fn main() -> ExitCode {
    cli::run_with(brick)
}
