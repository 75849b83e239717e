//! A knob with a knurled grip and a trap for a nut:
//! `cargo run --release --example knurled_knob -- --radius 18 render -o knob.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::csg::{Profile, Solid};

#[derive(Clone, Copy, clap::Args)]
struct Arguments {
    /// Radius of the grip in millimetres
    #[arg(long, default_value_t = 16.0)]
    radius: f64,
    /// How many notches
    #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u32).range(8..=120))]
    notches: u32,
}

fn knob(arguments: Arguments) -> Solid {
    let radius = arguments.radius;
    let grip = Profile::knurled(radius, arguments.notches as usize);
    // Both rims are bevelled by the same double cone.
    let bevel = Solid::chamfered_cylinder(radius + 0.2, 0.0..14.0, 2.0);
    let grip = Solid::extrude(&grip, 0.0..14.0) & bevel;
    let hub = Solid::frustum(0.62 * radius, 0.5 * radius, -8.0..0.5);
    let dish = Solid::sphere(2.0 * radius).translate_xyz(0.0, 0.0, 12.0 + 2.0 * radius);
    let nut = Solid::nut_trap(13.0, 5.5)
        .rotate_x_degrees(180.0)
        .translate_xyz(0.0, 0.0, -8.0);
    let bore = Solid::cylinder(4.2, -9.0..15.0);
    (grip.named("grip") | hub.named("hub")) - dish.named("dish") - nut.named("nut") - bore
}

fn main() -> ExitCode {
    cli::run_with(knob)
}
