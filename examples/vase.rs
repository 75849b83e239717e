//! A vase turned from its outline, straight or with flutes:
//! `cargo run --release --example vase -- render -o vase.png`.

use std::process::ExitCode;

use stereotomy::csg::{Path, Solid};

fn vase() -> Solid {
    // Once up the outside, over the lip and down the inside.
    let outline = Path::from([0.0, 0.0])
        .line_to([18.0, 0.0])
        .arc_to([20.0, 2.0], std::f64::consts::FRAC_PI_2)
        .line_to([34.0, 40.0])
        .line_to([15.0, 75.0])
        .line_to([22.0, 95.0])
        .arc_to([20.0, 96.0], std::f64::consts::PI)
        .line_to([12.5, 75.0])
        .line_to([31.0, 40.0])
        .line_to([18.0, 4.0])
        .line_to([0.0, 4.0])
        .close();
    Solid::revolve(&outline).named("vase")
}

fn main() -> ExitCode {
    cli::run(vase)
}
