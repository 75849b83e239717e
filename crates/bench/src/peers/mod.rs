//! Programs to be compared with. Each makes a [`csg::Mesh`] from a
//! [`crate::field::Field`].

pub mod fidget;
pub mod manifold;
pub mod surface_nets;
