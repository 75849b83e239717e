//! The pipeline as it is taught: every formula with its source.

pub mod clip;
pub mod cohen_sutherland;
pub(crate) mod euler;
pub mod fixed;
pub mod hidden_surface;
pub mod polygon_model;
pub mod projection;
pub(crate) mod reference;
pub mod scanline;
pub mod shade;
pub mod transform;
pub mod view_reference;
pub mod viewport;
