//! Stereotomy, the art of cutting solids exactly: solids are Boolean
//! combinations of half-spaces ([`csg`]), lettering included ([`text`]), turned
//! into pictures ([`raster`]) and files ([`io`]).
//!
//! This crate is the facade: it re-exports the four libraries under one name, and has a
//! [`cookbook`] of thirty recipes.

pub use {csg, io, raster, text};

pub mod cookbook;
pub mod scenes;

/// The code of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
