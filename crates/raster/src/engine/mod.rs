//! The fast pipeline: from a prepared scene to shaded pixels.

pub(crate) mod caps;
pub(crate) mod cluster;
pub(crate) mod corners;
pub(crate) mod cull;
pub(crate) mod deferred;
pub(crate) mod fill;
pub(crate) mod frame;
pub(crate) mod geometry;
pub(crate) mod hatch;
pub(crate) mod interpolate;
pub(crate) mod light;
pub(crate) mod look;
pub(crate) mod normals;
pub(crate) mod pipeline;
pub(crate) mod prepared;
pub(crate) mod resolve;
pub(crate) mod section;
pub(crate) mod set_up;
pub(crate) mod shading;
pub(crate) mod simd;
pub(crate) mod smooth;
pub(crate) mod stats;
pub(crate) mod surface_texture;
pub(crate) mod texture;
pub(crate) mod tile;
pub(crate) mod transparent;
