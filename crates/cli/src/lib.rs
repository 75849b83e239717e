//! The `csg` command line, also for a model of your own.
//!
//! [`main`] is the `csg` command: it meshes, draws and measures files.
//! [`run`] gives a model written in Rust the same subcommands, without the
//! input file:
//!
//! ```no_run
//! use csg::Solid;
//!
//! fn main() -> std::process::ExitCode {
//!     cli::run(|| Solid::cube(2.0) - Solid::sphere(1.2))
//! }
//! ```
//!
//! so that `cargo run -- mesh -o part.glb` and `cargo run -- render -o
//! part.png` work for it. [`run_with`] adds arguments of the model's own.

#![warn(clippy::print_stderr)]

#[macro_use]
mod say;

mod commands;
mod failure;
mod input;
mod interrupt;
mod mesher;
mod nothing;
mod openscad;
mod output;
mod progress;
mod run;
mod shard;

pub use clap;
pub use failure::exit_codes;
pub use run::{main, run, run_with};
