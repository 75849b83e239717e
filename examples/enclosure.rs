//! An enclosure with screw bosses, and its lid beside it:
//! `cargo run --release --example enclosure -- --length 90 render -o enclosure.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::csg::{Profile, Solid};

#[derive(Clone, Copy, clap::Args)]
struct Arguments {
    /// Inner length in millimetres
    #[arg(long, default_value_t = 80.0)]
    length: f64,
    /// Inner width
    #[arg(long, default_value_t = 50.0)]
    width: f64,
    /// Inner height
    #[arg(long, default_value_t = 25.0)]
    height: f64,
}

const WALL: f64 = 2.0;
const CORNER: f64 = 4.0;

fn enclosure(arguments: Arguments) -> Solid {
    let Arguments {
        length,
        width,
        height,
    } = arguments;
    let inside = Profile::rounded_rectangle([length, width], CORNER);
    let outer = [length + 2.0 * WALL, width + 2.0 * WALL];
    let outside = Profile::rounded_rectangle(outer, CORNER + WALL);
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let at_corners = |solid: &Solid| {
        let (x, y) = (0.5 * length - 5.0, 0.5 * width - 5.0);
        let places = corners.map(|[i, j]| solid.translate_xyz(i * x, j * y, 0.0));
        Solid::union(places)
    };
    let boss = Solid::cylinder(3.5, -0.5 * WALL..height - 2.0);
    let pilot = Solid::cylinder(1.25, 4.0..height + 1.0);
    let vents = Solid::cuboid([1.6, 3.0 * WALL, 0.5 * height])
        .linear_pattern(8, [4.0, 0.0, 0.0])
        .translate_xyz(-14.0, -0.5 * width - 0.5 * WALL, 0.5 * height);
    let body = (Solid::extrude(&outside, -WALL..height)
        - Solid::extrude(&inside, 0.0..height + 1.0))
        | at_corners(&boss);
    let body = body.named("body") - at_corners(&pilot).named("pilots") - vents.named("vents");

    let screw = Solid::countersink(1.6, 10.0, 3.0).translate_xyz(0.0, 0.0, WALL);
    let lip = Profile::rounded_rectangle([length - 0.4, width - 0.4], CORNER - 0.2);
    let plate = Solid::extrude(&outside, 0.0..WALL) | Solid::extrude(&lip, -1.5..0.5 * WALL);
    let lid = plate.named("lid") - at_corners(&screw).named("screws");
    // Upside up, on the table.
    body | lid.translate_xyz(0.0, width + 6.0 * WALL, 1.5 - WALL)
}

fn main() -> ExitCode {
    cli::run_with(enclosure)
}
