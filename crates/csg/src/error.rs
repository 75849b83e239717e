//! What can be wrong, where it is, and how to mend it.

mod polyhedron;
mod profile;

use std::fmt;

pub use self::polyhedron::PolyhedronFault;
pub use self::profile::ProfileFault;
use crate::limits::LimitReached;
use crate::undecided::Undecided;

/// Why a solid could not be lowered, measured or meshed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A node of the tree has bad arguments.
    #[error("{fault} (at {path})")]
    InvalidNode {
        /// Where the node is.
        path: NodePath,
        /// What is wrong with it.
        fault: NodeFault,
    },
    /// A bounded solid is needed, but this one reaches infinitely far.
    #[error(
        "the solid is unbounded towards about ({:.3}, {:.3}, {:.3}): intersect it with something finite, or use the finite form of the primitive",
        .direction[0], .direction[1], .direction[2]
    )]
    Unbounded {
        /// A direction in which the solid goes on, as far as could be told.
        direction: [f64; 3],
    },
    /// The options of an operation are out of range.
    #[error("{0}")]
    InvalidOption(String),
    /// More surfaces, primitives or cells than an index can count.
    #[error("{what}: more than {limit}; split the model into parts")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// The limit.
        limit: u64,
    },
    /// The mesh would cost more than [`crate::Limits`] allow; [`crate::Limits::partial`] asks for what
    /// fits.
    #[error(
        "{0}: raise the limit, ask for larger cells or a larger tolerance, or for what fits, if anything does"
    )]
    LimitReached(LimitReached),
    /// The exact boundary could not be told somewhere.
    #[error(
        "the exact boundary could not be told: {0}; move or turn one of the parts there a little, or make do with a mesh"
    )]
    Undecided(Undecided),
    /// A slab of a mesh cannot be put together with the others.
    #[error("{slab}: {problem}")]
    Slab {
        /// Which one; of a file its name.
        slab: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// What is wrong with one node.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NodeFault {
    /// A number is NaN or infinite.
    #[error("{what} must be finite: give ordinary numbers")]
    NotFinite {
        /// Which number.
        what: &'static str,
    },
    /// A length is zero, negative, NaN or infinite.
    #[error("{what} is {value}: it must be positive and finite")]
    NotPositive {
        /// Which length.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A direction has no length.
    #[error("{what} is zero: give it a direction")]
    ZeroDirection {
        /// Which direction.
        what: &'static str,
    },
    /// The map flattens space, or is so near to it that no digit is left.
    #[error(
        "the map is singular (determinant {determinant:e}): a solid cannot be flattened; scale by something other than zero"
    )]
    SingularMap {
        /// Its determinant.
        determinant: f64,
    },
    /// A shear along its own axis is a scaling.
    #[error("a shear needs two different axes: use scale_xyz to stretch along one")]
    ShearAlongItself,
    /// f has one sign everywhere, or vanishes identically.
    #[error(
        "the quadric's zero set is no surface: f must be negative somewhere and positive elsewhere"
    )]
    QuadricWithoutSurface,
    /// f is the product of two linear functions.
    #[error(
        "the quadric is a pair of crossing planes: combine two half-spaces with `&`, `|` or `-` instead"
    )]
    QuadricOfCrossingPlanes,
    /// Nothing to combine.
    #[error("{operation} of nothing: give at least one operand (Solid::empty() for no solid)")]
    NoOperands {
        /// union, intersection or difference.
        operation: &'static str,
    },
    /// A polygon with fewer than three corners, without area, or not convex.
    #[error(
        "the polygon must be convex with at least three corners that span an area: {problem}; unite convex parts for other shapes"
    )]
    PolygonNotConvex {
        /// What exactly is wrong.
        problem: &'static str,
    },
    /// A profile that cannot be made into a solid.
    #[error("the profile: {0}")]
    Profile(#[from] ProfileFault),
    /// Faces that bound no solid.
    #[error("{0}")]
    Polyhedron(Box<PolyhedronFault>),
    /// Points that span no volume.
    #[error("the points lie in one plane, or are too few: their hull has no volume")]
    Flat,
    /// An angle of revolution that is zero or more than a turn.
    #[error(
        "the angle is {value}: it must be in radians, not 0 and at most a turn (2 pi) either way"
    )]
    AngleOutOfRange {
        /// The angle.
        value: f64,
    },
    /// An angle of more than two turns in radians.
    #[error(
        "the angle is {value} radians, more than two turns: if degrees are meant, use the function whose name ends in _degrees (rotate_z_degrees(90.0)), else take whole turns off"
    )]
    AngleInDegrees {
        /// The angle.
        value: f64,
    },
    /// Too few steps to go around.
    #[error("{steps} steps: a turn takes at least three, and each less than half a turn")]
    TooFewSteps {
        /// How many there are.
        steps: usize,
    },
    /// A length that must not exceed another does.
    #[error("{what} is {value}: it must be less than {limit}")]
    TooLarge {
        /// Which length.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be less than.
        limit: f64,
    },
    /// Fewer of something than it takes.
    #[error("{count} {what}: it takes at least {least}")]
    TooFew {
        /// Of what.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many it takes.
        least: usize,
    },
    /// A number whose square or product leaves the range of f64.
    #[error("{what} is out of range: keep lengths between 1e-100 and 1e100")]
    OutOfRange {
        /// Which number.
        what: &'static str,
    },
}

/// The way from the root of a solid's tree to one of its nodes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NodePath {
    /// From the root down: which operand was taken to arrive at this node (0
    /// for the root), its kind, and its name where it is a `named` node.
    pub steps: Vec<PathStep>,
}

/// One step of a [`NodePath`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PathStep {
    /// Index among the operands of the node above.
    pub operand: usize,
    /// The node's kind.
    pub kind: &'static str,
    /// The name that a `named` node gives.
    pub name: Option<std::sync::Arc<str>>,
}

/// Prints the way down; of a long one the names and the last few nodes.
impl fmt::Display for NodePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 12;
        let hidden = self.steps.len().saturating_sub(SHOWN);
        let mut separator = "";
        if hidden > 0 {
            write!(f, "{hidden} levels down")?;
            let names: Vec<&str> = self.steps[..hidden]
                .iter()
                .filter_map(|step| step.name.as_deref())
                .collect();
            for name in names.iter().rev().take(3).rev() {
                write!(f, " in {name:?}")?;
            }
            separator = " / ";
        }
        for (i, step) in self.steps[hidden..].iter().enumerate() {
            f.write_str(separator)?;
            separator = " / ";
            match &step.name {
                Some(name) => write!(f, "{name:?}")?,
                None => f.write_str(step.kind)?,
            }
            if hidden + i > 0 && step.operand > 0 {
                write!(f, " (operand {})", step.operand + 1)?;
            }
        }
        Ok(())
    }
}
