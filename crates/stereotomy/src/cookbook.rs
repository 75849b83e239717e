//! Recipes, each whole: from a box with rounded corners to a thousand variants on a cluster.
//!
//! The code is that of `examples/cookbook`, and the pictures are made of it by
//! `cargo run --release --example cookbook`. Lengths are in millimetres.
//!
#![doc = include_str!(concat!(env!("OUT_DIR"), "/cookbook.md"))]
