//! Numbers alone: what knows of no surface and no solid.

mod eigen;
mod groups;
pub(crate) mod lanes;
pub(crate) mod tolerance;
mod welder;

pub(crate) use self::eigen::{eigen_symmetric, jacobi};
pub(crate) use self::groups::Groups;
pub(crate) use self::welder::Welder;
