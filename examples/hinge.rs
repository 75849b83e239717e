//! A hinge of two leaves with countersunk holes, and its pin:
//! `cargo run --release --example hinge -- --angle-degrees 120 render -o hinge.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::csg::{Color, Solid};

#[derive(Clone, Copy, clap::Args)]
struct Arguments {
    /// How far it is opened, flat at 180
    #[arg(long, default_value_t = 130.0, value_parser = in_range)]
    angle_degrees: f64,
    /// Knuckles along the pin, an odd number
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(3..=11))]
    knuckles: u32,
}

fn in_range(text: &str) -> Result<f64, String> {
    let angle = text.parse::<f64>().ok();
    angle
        .filter(|angle| (20.0..=180.0).contains(angle))
        .ok_or_else(|| "give degrees from 20 to 180".to_owned())
}

const LENGTH: f64 = 60.0;
const WIDTH: f64 = 28.0;
const THICK: f64 = 3.0;
const PIN: f64 = 2.5;
/// Radius of a knuckle; a leaf is flush with its top.
const KNUCKLE: f64 = 5.0;
const PLAY: f64 = 0.3;

/// A leaf along +x with every second knuckle, beginning with the given one.
fn leaf(knuckles: u32, first: u32) -> Solid {
    let step = LENGTH / f64::from(knuckles);
    let slots = |from: u32, radius: f64, play: f64| {
        let slots = (from..knuckles).step_by(2).map(|k| {
            let z = step * f64::from(k);
            Solid::cylinder(radius, z - play..z + step + play)
        });
        Solid::union(slots)
    };
    let top = KNUCKLE - THICK;
    let plate = Solid::cuboid_between([0.0, top, 0.0], [KNUCKLE + WIDTH, KNUCKLE, LENGTH]);
    let screw = Solid::countersink(2.1, 2.0 * THICK, 4.0).rotate_x_degrees(-90.0);
    let screws = [[12.0, 12.0], [12.0, LENGTH - 12.0], [22.0, 0.5 * LENGTH]];
    let screws = screws.map(|[x, z]| screw.translate_xyz(KNUCKLE + x, KNUCKLE, z));
    let others = slots(1 - first, KNUCKLE + 0.5, PLAY);
    let bore = Solid::cylinder(PIN + PLAY, -1.0..LENGTH + 1.0);
    ((plate - others) | slots(first, KNUCKLE, -PLAY)) - bore - Solid::union(screws).named("screws")
}

fn hinge(arguments: Arguments) -> Solid {
    let still = leaf(arguments.knuckles, 0).named("left leaf");
    // The other one is its mirror image, turned about the pin.
    let moved = leaf(arguments.knuckles, 1)
        .mirror([0.0; 3], [1.0, 0.0, 0.0])
        .rotate_z_degrees(180.0 - arguments.angle_degrees)
        .named("right leaf");
    let pin = Solid::cylinder(PIN, -2.0..LENGTH + 2.0).named("pin");
    let leaves = still.colored(Color::from_srgb([0.55, 0.60, 0.68]))
        | moved.colored(Color::from_srgb([0.70, 0.66, 0.58]));
    leaves | pin.colored(Color::from_srgb([0.85, 0.65, 0.25]))
}

fn main() -> ExitCode {
    cli::run_with(hinge)
}
