//! A model in the browser: it turns, is measured, and is made again when its file changes.
//!
//! [`view`] serves a page on this machine's own address. A [`Source`] makes the model, [`stages`]
//! what is shown of it: at once a coarse mesh, then a fine one with the exact boundary
//! ([`csg::Brep`]), from which everything is told that the page says of faces, edges and
//! vertices, and of distances and angles between them.
//!
//! The page (`web/`) is three.js and code of our own, made into one script by esbuild; the
//! script is part of the repository, so that Node is needed only by who changes it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod account;
mod dimension;
mod distance;
mod export;
mod faces;
#[cfg(feature = "server")]
mod guard;
mod packing;
mod pick;
#[cfg(feature = "server")]
mod picture;
#[cfg(feature = "server")]
mod server;
mod shown;
mod source;
#[cfg(feature = "server")]
mod view;
#[cfg(feature = "server")]
mod watch;

pub use account::Account;
pub use dimension::Dimension;
pub use export::FORMATS;
pub use pick::{Pick, PickKind, Row};
pub use shown::{Settings, Shown, stages};
pub use source::{Loaded, Parameter, ParameterKind, Problem, Source, Subject, TextPlace};
#[cfg(feature = "server")]
pub use view::{ViewError, ViewOptions, view};
