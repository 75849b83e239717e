//! The `csg` command.
fn main() {}
