//! What surfaces of a scene have in common, as it is asked for.

use std::sync::Arc;

use super::ball::Ball;
use super::curve::Curve;
use super::intersection::Unknown;
use super::pairs::curves;
use super::piece::CurveId;
use super::relations::Common;
use super::scene::Scene;
use super::triple::contacts;
use crate::program::SurfaceId;

impl Scene<'_> {
    /// The curves common to two surfaces, or to one and a seam of it, by any of them.
    pub fn common(&self, id: CurveId) -> Common {
        let decide = || {
            let surfaces = match id {
                CurveId::Common { surfaces, .. } => Some(surfaces.map(|id| self.surface(id))),
                CurveId::Seam { surface, seam, .. } => {
                    let seams = self.frame(surface).map(|frame| &frame.seams);
                    let seam = seams.and_then(|seams| seams.get(usize::from(seam)));
                    seam.map(|seam| [self.surface(surface), seam])
                }
            };
            let [one, other] = surfaces.ok_or_else(|| Arc::new(Unknown::NoForm))?;
            let common = curves(one, other, self.near).map_err(Arc::new)?;
            Ok(common.into_iter().collect())
        };
        self.relations.pairs.get(id.with_branch(0), decide)
    }

    /// A curve by its name; none would be a mistake.
    pub fn curve(&self, id: CurveId) -> Option<Curve> {
        let common = self.common(id).ok()?;
        let branch = common.get(usize::from(id.branch()))?;
        Some(branch.curve.clone())
    }

    /// Where three surfaces touch: in each ball is one point of all three, its centre. The
    /// same in whatever order they are named.
    pub fn contacts(&self, mut ids: [SurfaceId; 3]) -> Arc<[Ball]> {
        ids.sort_unstable();
        let decide = || contacts(self, ids).into_iter().collect();
        self.relations.triples.get(ids, decide)
    }
}
