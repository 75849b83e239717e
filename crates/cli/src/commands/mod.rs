//! The subcommands, one per file.

pub(crate) mod account;
mod looks;
pub(crate) mod measure;
pub(crate) mod mesh;
pub(crate) mod render;
