//! What is drawn over, under and into a finished picture.

pub(crate) mod blend;
pub(crate) mod color_map;
pub(crate) mod deviation;
pub(crate) mod dimension;
pub(crate) mod edges;
pub(crate) mod explode;
pub(crate) mod ground;
pub(crate) mod lettering;
pub(crate) mod line;
pub(crate) mod occlusion;
pub(crate) mod refine;
pub(crate) mod silhouette;
pub(crate) mod thickness;
pub(crate) mod triad;
pub(crate) mod visible;
