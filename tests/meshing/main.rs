//! The exact mesher held against programs, closed forms and itself.
#![allow(missing_docs, reason = "a test")]

mod adaptive;
mod boundary;
mod defects;
mod hard_models;
mod limits;
mod measures;
mod moved_solids;
mod polyhedral;
mod promises;
mod random;
mod random_solids;
mod reference_scenes;
mod thin;
mod tolerance;
mod twins;
