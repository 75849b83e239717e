//! A ball bearing, its balls in grooves of 45°:
//! `cargo run --release --example ball_bearing -- --balls 9 render -o bearing.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::csg::{Color, Path, Solid};

#[derive(Clone, Copy, clap::Args)]
struct Arguments {
    /// How many balls
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(3..=12))]
    balls: u32,
    /// Radius of the shaft in millimetres
    #[arg(long, default_value_t = 10.0)]
    shaft: f64,
}

/// The radius of a ball.
const BALL: f64 = 4.0;
/// How far the grooves' edges keep from the balls' equator.
const GAP: f64 = 1.2;

/// A ring between two radii, a groove of 45° on the side of the balls.
fn ring(middle: f64, side: f64, far: f64) -> Solid {
    let (half, bottom) = (0.8 * BALL, middle + side * BALL * std::f64::consts::SQRT_2);
    let edge = middle + side * GAP;
    let depth = (bottom - edge).abs();
    let outline = Path::from([far, -1.6 * half])
        .line_to([edge, -1.6 * half])
        .line_to([edge, -depth])
        .line_to([bottom, 0.0])
        .line_to([edge, depth])
        .line_to([edge, 1.6 * half])
        .line_to([far, 1.6 * half])
        .close();
    Solid::revolve(&outline)
}

fn bearing(arguments: Arguments) -> Solid {
    let middle = arguments.shaft + 3.0 + BALL * std::f64::consts::SQRT_2;
    let outer = middle + 3.0 + BALL * std::f64::consts::SQRT_2;
    // A hair smaller than what it rolls in: parts do not touch.
    let ball = Solid::sphere(0.995 * BALL).translate([middle, 0.0, 0.0]);
    let steel = Color::from_srgb([0.75, 0.77, 0.80]);
    let rings = ring(middle, -1.0, arguments.shaft).named("inner ring")
        | ring(middle, 1.0, outer).named("outer ring");
    let balls = ball.polar_pattern(arguments.balls as usize).named("balls");
    rings.colored(steel) | balls.colored(Color::from_srgb([0.85, 0.65, 0.25]))
}

fn main() -> ExitCode {
    cli::run_with(bearing)
}
