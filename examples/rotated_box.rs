//! A box in general position: `cargo run --release --example rotated_box -- mesh -o box.stl`.

use std::process::ExitCode;

use stereotomy::scenes;

fn main() -> ExitCode {
    cli::run(scenes::rotated_box)
}
