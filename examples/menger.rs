//! Menger's sponge of a given level:
//! `cargo run --release --example menger -- 3 render -o menger.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::scenes;

#[derive(clap::Args)]
struct Arguments {
    /// How often the cube is divided by three
    #[arg(default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=6))]
    level: u32,
}

fn main() -> ExitCode {
    cli::run_with(|arguments: Arguments| scenes::menger(arguments.level))
}
