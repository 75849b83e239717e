//! 3MF, the format of 3D printing: a ZIP archive with an XML model inside
//! (core specification 1.3, and the colour groups of the materials extension).

mod read;
mod write;

pub use self::read::read_3mf;
pub(crate) use self::read::read_3mf_objects;
pub use self::write::write_3mf;
