//! Ready-made solids and profiles: each made of the core's primitives, extrusions
//! and Booleans by a formula that fits on a page, and held to its volume in closed
//! form.

mod bodies;
mod fastening;
mod gear;
mod patterns;
mod platonic;

pub use self::fastening::Screw;
pub use self::gear::Gear;

use crate::error::NodeFault;

/// A length above zero.
fn positive(what: &'static str, value: f64) -> Result<f64, NodeFault> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(NodeFault::NotPositive { what, value })
    }
}

/// A length above zero and below another.
fn below(what: &'static str, value: f64, limit: f64) -> Result<f64, NodeFault> {
    if positive(what, value)? < limit {
        Ok(value)
    } else {
        Err(NodeFault::TooLarge { what, value, limit })
    }
}
