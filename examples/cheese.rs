//! A cube without small spheres, as many as asked for:
//! `cargo run --release --example cheese -- 1000 render -o cheese.png`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::scenes;

#[derive(clap::Args)]
struct Arguments {
    /// How many spheres
    #[arg(default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..))]
    spheres: u32,
}

fn main() -> ExitCode {
    cli::run_with(|arguments: Arguments| scenes::cheese(arguments.spheres))
}
