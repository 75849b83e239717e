//! The subcommands, one per file.

pub(crate) mod account;
mod annotate;
mod exact;
mod figure;
mod lighting;
mod looks;
pub(crate) mod measure;
pub(crate) mod mesh;
mod parse;
pub(crate) mod render;
#[cfg(feature = "view")]
pub(crate) mod view;
mod view_reference;
mod viewing;
