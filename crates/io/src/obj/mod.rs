//! Wavefront OBJ (`.obj`) with its material library (`.mtl`).
//!
//! Numbers are written in the shortest form that reads back to the same bits,
//! and vertices keep their identity, so a mesh returns as it was. OBJ has
//! neither unit nor up axis: the numbers are the model's own, a comment
//! names the unit.
//!
//! (The reader is our own, not tobj, because vertices that coincide on
//! purpose, where a solid touches itself, must stay apart also between groups.)

mod read;
mod write;

pub use read::read_obj;
pub(crate) use read::read_obj_objects;
pub use write::{write_mtl, write_obj};
