//! glTF 2.0, as one binary file (`.glb`) or as JSON with its data beside it
//! (`.gltf` and `.bin`).
//!
//! glTF's lengths are metres and its Y axis points up; models here have a
//! unit of their own and Z up. The file keeps the model's numbers: one root
//! node carries the scale and the turn as a matrix with exact entries, and
//! `asset.extras` names the unit, so that reading returns the same numbers.
//!
//! Positions are single precision by the standard. All mesh nodes share one
//! translation near the middle of the model, and positions are relative to
//! it: a part of 10 mm at an offset of 1 km keeps its 7 digits. The
//! translation is a multiple of a power of two about as large as the model,
//! which keeps it exact in single precision up to 2^24 times the model's size.
//!
//! On request bodies that are the same but for a rotation and a translation are
//! written once, with the places where they are
//! ([`WriteOptions::instances`](crate::WriteOptions::instances)).

mod accessors;
#[cfg(feature = "compress")]
mod compress;
mod document;
mod instances;
mod merged;
mod read;
mod write;

#[cfg(feature = "compress")]
pub use compress::write_glb_compressed;
pub(crate) use merged::MergedGlb;
pub use merged::{CHUNK, CHUNKS_PER_FILE};
pub use read::{read_glb, read_gltf};
pub(crate) use read::{read_glb_with, read_gltf_with};
pub use write::{write_glb, write_glb_with, write_gltf, write_gltf_with};

/// From model coordinates (Z up) to glTF's (Y up): x stays, z becomes y, y
/// becomes -z. Columns, without the scale.
const Z_UP_TO_Y_UP: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];
