//! Steinmetz's tricylinder, common to three cylinders: `cargo run --release --example tricylinder -- measure`.

use std::process::ExitCode;

use stereotomy::scenes;

fn main() -> ExitCode {
    cli::run(scenes::tricylinder)
}
