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

impl Scene<'_> {
    /// The curves common to two surfaces, by number, or, if the second is
    /// [`super::piece::NOTHING`], to the first and one of its seams.
    pub fn common(&self, [first, second]: [u32; 2], seam: u16) -> Common {
        let decide = || {
            let one = &self.surfaces[first as usize];
            let other = self.surfaces.get(second as usize).or_else(|| {
                let frame = self.frames[first as usize].as_ref()?;
                frame.seams.get(seam as usize)
            });
            let other = other.ok_or_else(|| Arc::new(Unknown::NoForm))?;
            let common = curves(one, other, self.near).map_err(Arc::new)?;
            Ok(common.into_iter().collect())
        };
        let key = [first, second, u32::from(seam)];
        self.relations.pairs.get(key, decide)
    }

    /// A curve by its name; none would be a mistake.
    pub fn curve(&self, id: CurveId) -> Option<Curve> {
        let common = self.common(id.surfaces, id.seam).ok()?;
        let branch = common.get(id.branch as usize)?;
        Some(branch.curve.clone())
    }

    /// Where three surfaces touch: in each ball is one point of all three, its centre. The
    /// same in whatever order they are named.
    pub fn contacts(&self, mut ids: [u32; 3]) -> Arc<[Ball]> {
        ids.sort_unstable();
        let decide = || contacts(self, ids).into_iter().collect();
        self.relations.triples.get(ids, decide)
    }
}
