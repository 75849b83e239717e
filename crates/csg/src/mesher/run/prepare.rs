//! Moves surfaces before a boundary is evaluated.

use glam::DVec3;

use super::Run;
use crate::error::Error;
use crate::mesher::options::DEFAULT_TOLERANCE;
use crate::numeric::tolerance::UNSEEN;
use crate::program::Bounds;
use crate::report::Report;
use crate::settling::{Prepared, Settling};

impl Run<'_> {
    /// The program with its surfaces moved in one of the ways, and what that did to them
    /// noted; none if it was tried as it is. `places` are those that made trouble so far.
    pub(super) fn settle(
        &self,
        bounds: &Bounds,
        settling: Settling,
        places: &[DVec3],
        report: &mut Report,
    ) -> Result<Option<Prepared>, Error> {
        let tolerance = self.goal.as_ref().map(|goal| goal.tolerance);
        let longest = bounds.size().max_element();
        let unseen = UNSEEN * tolerance.unwrap_or(DEFAULT_TOLERANCE * longest);
        let prepared = Prepared::new(self.program, bounds, settling, unseen, places)?;
        report.moved = prepared.as_ref().and_then(|prepared| prepared.told(bounds));
        Ok(prepared)
    }
}
