//! Measurements: one binary for each question asked, and what they share.

#[path = "peers/euc.rs"]
pub mod euc_peer;
#[path = "peers/llvmpipe.rs"]
pub mod llvmpipe;
pub mod meshes;
