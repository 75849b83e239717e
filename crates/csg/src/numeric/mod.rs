//! Numbers alone: what knows of no surface and no solid.

mod eigen;
pub(crate) mod exact;
mod groups;
pub(crate) mod lanes;
mod stretch;
pub(crate) mod tolerance;
mod welder;

pub(crate) use self::eigen::{eigen_symmetric, jacobi};
pub(crate) use self::groups::Groups;
pub use self::stretch::stretch;
pub(crate) use self::welder::Welder;
