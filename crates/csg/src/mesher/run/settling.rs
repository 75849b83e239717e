//! Which surfaces are moved before a boundary is evaluated, so that it can be.

use super::Run;
use crate::error::Error;
use crate::evaluation::{self, Evaluated};
use crate::mesher::DEFAULT_TOLERANCE;
use crate::program::{Bounds, Program, Settled};
use crate::report::{Moved, Report};

/// How far surfaces may be moved, of the tolerance: so little that what is left of it
/// takes half a percent more triangles.
const UNSEEN: f64 = 0.01;

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
pub(super) struct Prepared(Option<Settled>);

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

impl Run<'_> {
    /// The program with its surfaces moved in one of the ways, and what that did to them
    /// noted; none if it was tried as it is.
    pub(super) fn settle(
        &self,
        bounds: &Bounds,
        settling: Settling,
        report: &mut Report,
    ) -> Result<Option<Prepared>, Error> {
        let size = bounds.size();
        let tolerance = self.goal.as_ref().map(|goal| goal.tolerance);
        let unseen = UNSEEN * tolerance.unwrap_or(DEFAULT_TOLERANCE * size.max_element());
        let unresolved = evaluation::unresolved(self.program) * size.max_element();
        let ball = (bounds.center(), 0.5 * size.length());
        let merged = || self.program.merged(ball, unresolved.min(unseen), unseen);
        let settled = match settling {
            Settling::Merged => merged()?,
            Settling::Rounded => match self.program.rounded(ball, unseen)? {
                None => return Ok(None),
                rounded => rounded,
            },
            Settling::Perturbed => {
                let merged = merged()?;
                let program = merged.as_ref().map_or(self.program, |m| &m.program);
                let perturbed = program.perturbed(ball, unseen)?;
                perturbed.map(|perturbed| match merged {
                    Some(merged) => Settled {
                        merged: merged.merged,
                        moved: merged.moved + perturbed.moved,
                        ..perturbed
                    },
                    None => perturbed,
                })
            }
        };
        report.moved = settled.as_ref().map(|settled| Moved {
            merged: settled.merged,
            distance: settled.moved,
            place: settled.place,
        });
        Ok(Some(Prepared(settled)))
    }
}
