//! A hollow sphere with a wall of a given thickness:
//! `cargo run --release --example shell -- 0.1 measure`.

use std::process::ExitCode;

use cli::clap;
use stereotomy::scenes;

#[derive(clap::Args)]
struct Arguments {
    /// Thickness of the wall, between 0 and 1
    #[arg(default_value_t = 0.1, value_parser = thickness)]
    thickness: f64,
}

fn main() -> ExitCode {
    cli::run_with(|arguments: Arguments| scenes::shell(arguments.thickness))
}

fn thickness(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(thickness) if 0.0 < thickness && thickness < 1.0 => Ok(thickness),
        _ => Err("give a number between 0 and 1".into()),
    }
}
