//! A chess pawn, turned, with a ball on top:
//! `cargo run --release --example chess_pawn -- --height 50 render -o pawn.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::csg::{Path, Solid};

#[derive(Clone, Copy, clap::Args)]
struct Arguments {
    /// Height in millimetres
    #[arg(long, default_value_t = 50.0)]
    height: f64,
}

fn pawn(arguments: Arguments) -> Solid {
    // Half of it from the axis, of a height of 50.
    let outline = [
        [15.0, 0.0],
        [15.0, 4.0],
        [13.0, 5.5],
        [13.0, 7.5],
        [10.5, 10.0],
        [7.0, 15.0],
        [5.4, 21.0],
        [4.8, 29.0],
        [8.6, 31.5],
        [8.6, 33.0],
        [4.0, 35.0],
        [0.0, 35.0],
    ];
    let outline = outline
        .into_iter()
        .fold(Path::from([0.0, 0.0]), Path::line_to);
    let head = Solid::sphere(8.6).translate_xyz(0.0, 0.0, 41.4);
    let body = Solid::revolve(&outline.close()).named("body") | head.named("head");
    body.scale(arguments.height / 50.0)
}

fn main() -> ExitCode {
    cli::run_with(pawn)
}
