//! Measurements: one binary for each question asked, and what they share.

pub mod meshes;
