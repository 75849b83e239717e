//! All integration tests of the crate, as one program: many would be linked many times.

mod annotations;
mod clipping;
mod common;
mod coverage;
mod default_look;
mod degenerate;
#[path = "../../../tests/manifold3d/python.rs"]
mod environment;
#[path = "../../../tests/every_file.rs"]
mod every_file;
mod far_parts;
mod features;
mod golden;
mod levels;
mod mesa;
mod mistakes;
mod one_view;
mod picture;
mod precision;
mod projection;
mod reference;
mod scene;
mod sections;
mod series;
mod silhouettes;
mod stats;
#[path = "textbook/main.rs"]
mod textbook;
mod transform;

#[test]
fn every_file_is_a_module() {
    every_file::is_a_module(env!("CARGO_MANIFEST_DIR"), include_str!("main.rs"));
}
