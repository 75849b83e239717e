//! What fuzz targets do: see `targets.rs`.

pub use {csg, io, raster};

pub mod targets;
