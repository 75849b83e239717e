//! The reference scenes side by side, in colours:
//! `cargo run --release --example gallery -- render -o gallery.png --size 1280x800
//! --background ffffff --camera -0.25,1,-0.75`.

use std::process::ExitCode;

use stereotomy::csg::{Color, Solid};
use stereotomy::scenes;

/// From left to right, the front row first.
fn gallery() -> Solid {
    let solids = [
        (scenes::drilled(), [0.85, 0.35, 0.20]),
        (
            scenes::flange().translate([0.0, 0.0, -0.3]),
            [0.45, 0.55, 0.65],
        ),
        (scenes::tricylinder().scale(0.8), [0.90, 0.70, 0.25]),
        (cut_shell(), [0.30, 0.60, 0.45]),
        (scenes::menger(3).scale(0.75), [0.55, 0.45, 0.75]),
        (scenes::cheese(100).scale(0.75), [0.95, 0.85, 0.45]),
    ];
    Solid::union(solids.into_iter().enumerate().map(|(i, (solid, rgb))| {
        let (row, column) = (i / 3, i % 3);
        let place = [2.4 * column as f64, 2.8 * row as f64, 0.0];
        solid.colored(Color::from_srgb(rgb)).translate(place)
    }))
}

/// A hollow sphere, opened to show its wall.
fn cut_shell() -> Solid {
    scenes::shell(0.1) - Solid::cuboid_between([0.0, -2.0, 0.0], [2.0, 0.0, 2.0])
}

fn main() -> ExitCode {
    cli::run(gallery)
}
