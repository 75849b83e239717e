//! A flange with hub, bore, bolt holes and keyway: `cargo run --release --example flange -- render -o flange.png`.

use std::process::ExitCode;

use stereotomy::scenes;

fn main() -> ExitCode {
    cli::run(scenes::flange)
}
