//! The `csg` command.

fn main() -> std::process::ExitCode {
    cli::main()
}
