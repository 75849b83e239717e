//! The ways to move surfaces before a boundary is evaluated, so that it can be.

use crate::evaluation::{self, Evaluated};
use crate::program::{Program, Settled};
use crate::report::Report;

/// What is done to surfaces, in the order in which it is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Settling {
    /// Those that cannot be told apart where boundaries are evaluated are made one.
    Merged,
    /// All are rounded to as many decimals as are a small share of the tolerance.
    Rounded,
    /// The same as first, and then each is moved on its own by such a share.
    Perturbed,
}

impl Settling {
    pub const ALL: [Self; 3] = [Self::Merged, Self::Rounded, Self::Perturbed];

    /// Whether nothing is left of the solid because surfaces were moved: walls thinner
    /// than that are better meshed in another way than lost.
    pub fn has_lost(self, evaluated: &Evaluated) -> bool {
        self != Self::Merged && evaluated.mesh.triangles.is_empty()
    }

    /// The series of chords that are tried.
    pub fn chords(self) -> &'static [&'static [f64]] {
        const ALL: [&[f64]; 3] = [
            &evaluation::LONG_CHORDS,
            &evaluation::SHORT_CHORDS,
            &evaluation::SHORTEST_CHORDS,
        ];
        match self {
            Self::Merged => &ALL,
            Self::Rounded | Self::Perturbed => &ALL[..1],
        }
    }
}

/// A program to be evaluated.
pub(super) struct Prepared(pub Option<Settled>);

impl Prepared {
    /// What it was made, if that is another one.
    pub fn moved(&self) -> Option<&Settled> {
        self.0.as_ref()
    }

    pub fn program<'a>(&'a self, original: &'a Program) -> &'a Program {
        self.moved().map_or(original, |settled| &settled.program)
    }

    /// Bound on how far any surface was moved.
    pub fn distance(&self) -> f64 {
        self.moved().map_or(0.0, |settled| settled.moved)
    }

    /// Counts how far surfaces were moved as deviation.
    pub fn add_to(&self, report: &mut Report) {
        if let Some(deviation) = &mut report.deviation {
            *deviation += self.distance();
        }
    }
}
