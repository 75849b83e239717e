//! The subcommands, one per file.

pub(crate) mod account;
mod annotate;
pub(crate) mod compare;
pub(crate) mod convert;
pub(crate) mod drawing;
mod exact;
pub(crate) mod figure;
pub(crate) mod info;
mod lighting;
mod looks;
pub(crate) mod manual;
pub(crate) mod measure;
pub(crate) mod merge;
pub(crate) mod mesh;
pub(crate) mod parse;
pub(crate) mod render;
#[cfg(test)]
mod schema_tests;
pub(crate) mod section;
mod sheet;
pub(crate) mod sweep;
mod table;
#[cfg(feature = "view")]
pub(crate) mod view;
mod view_reference;
mod viewing;
