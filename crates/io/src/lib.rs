//! Files: meshes, scenes and flat shapes, in and out.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod assemble;
mod atomic;
mod bodies;
mod contents;
pub mod drawing;
mod error;
mod format;
pub mod gltf;
mod mesh_file;
pub mod obj;
pub mod off;
mod parts;
pub mod ply;
pub mod profile;
mod repeats;
mod rows;
pub mod scene;
pub mod shard;
mod shared;
mod solid;
mod spline;
pub mod step;
pub mod stl;
pub mod threemf;
mod tree;
mod units;
mod weld;

pub use atomic::{AtomicFile, bytes_written};
pub use error::Error;
pub use format::{
    MeshFormat, ReadOptions, WriteOptions, read_mesh, read_mesh_file, read_mesh_with, write_mesh,
};
pub use mesh_file::MeshFile;
pub use profile::{ProfileOptions, ReadProfile, read_profile, read_profile_with};
pub use shared::share_triangles;
pub use solid::{SolidOptions, read_solid, read_solid_with};
pub use units::unit_ratio;
