//! A hexagon bolt with an ISO metric thread, its nut beside it:
//! `cargo run --release --example bolt_and_nut -- --size 10 render -o bolt.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::csg::{Color, Screw, Solid};

#[derive(Clone, Copy, clap::Args)]
struct Arguments {
    /// Nominal diameter: 8 for M8
    #[arg(long, default_value = "8", value_parser = metric)]
    size: Metric,
    /// Turns of the thread on the bolt
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=20))]
    turns: u32,
}

/// A screw of the coarse series.
#[derive(Clone, Copy)]
struct Metric(Screw);

fn metric(text: &str) -> Result<Metric, String> {
    let screw = text.parse().ok().and_then(Screw::metric);
    screw
        .map(|screw| Metric(Screw { steps: 12, ..screw }))
        .ok_or_else(|| "give a diameter of ISO 261, such as 5, 6, 8 or 10".to_owned())
}

/// A hexagon of a width across flats, its corners cut off by a cone of 30°.
fn hexagon(across_flats: f64, height: f64) -> Solid {
    let prism = Solid::nut_trap(across_flats, height).translate_xyz(0.0, 0.0, height);
    // As wide as the flats at the top.
    let slope = 30f64.to_radians().tan();
    let wide = 0.5 * across_flats + height / slope;
    prism & Solid::frustum(wide, 0.5 * across_flats, 0.0..height)
}

fn bolt_and_nut(arguments: Arguments) -> Solid {
    let Metric(screw) = arguments.size;
    let Screw {
        diameter, pitch, ..
    } = screw;
    let (flats, head) = (1.6 * diameter, 0.65 * diameter);
    let thread = Solid::threaded_rod(screw, pitch * f64::from(arguments.turns));
    let shank = Solid::cylinder(0.5 * diameter, -0.5 * diameter..0.0);
    let head =
        hexagon(flats, head)
            .rotate_x_degrees(180.0)
            .translate_xyz(0.0, 0.0, -0.5 * diameter);
    let bolt = head.named("head") | shank.named("shank") | thread.named("thread");

    // The nut's thread has a little play.
    let inner = Screw {
        diameter: diameter + 0.2,
        ..screw
    };
    let (turns, height) = (3.0, 3.0 * pitch);
    let nut = hexagon(flats, height).named("nut")
        - Solid::threaded_rod(inner, (turns + 1.0) * pitch)
            .translate_xyz(0.0, 0.0, -0.5 * pitch)
            .named("inner thread");
    let steel = Color::from_srgb([0.72, 0.74, 0.78]);
    (bolt | nut.translate_xyz(2.2 * diameter, 0.0, -diameter)).colored(steel)
}

fn main() -> ExitCode {
    cli::run_with(bolt_and_nut)
}
