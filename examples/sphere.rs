//! The unit sphere: `cargo run --release --example sphere -- measure`.

use std::process::ExitCode;

use stereotomy::scenes;

fn main() -> ExitCode {
    cli::run(scenes::sphere)
}
