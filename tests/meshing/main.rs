//! The exact mesher held against programs, closed forms and itself.

mod adaptive;
mod boundary;
mod defects;
mod hard_models;
mod limits;
mod measures;
mod moved_solids;
mod polyhedral;
mod promises;
mod random_solids;
mod reference_scenes;
mod thin;
mod tolerance;
mod twins;
