//! Moves surfaces before a boundary is evaluated.

use super::Run;
use super::settling::{Prepared, Settling};
use crate::error::Error;
use crate::evaluation;
use crate::mesher::options::DEFAULT_TOLERANCE;
use crate::program::{Bounds, Settled};
use crate::report::{Moved, Report};

/// How far surfaces may be moved, of the tolerance: so little that what is left of it
/// takes half a percent more triangles.
const UNSEEN: f64 = 0.01;

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
        // What was moved by less than rounding moves it is where it was.
        let rounding = evaluation::rounding(bounds.center(), size.max_element());
        let moved = settled.as_ref().filter(|s| s.moved > rounding);
        report.moved = moved.map(|settled| Moved {
            merged: settled.merged,
            distance: settled.moved,
            place: settled.place,
        });
        Ok(Some(Prepared(settled)))
    }
}
