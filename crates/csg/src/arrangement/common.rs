//! What surfaces of a scene have in common, as it is asked for.

use std::sync::Arc;

use glam::DVec3;
use smallvec::SmallVec;

use super::ball::Touching;
use super::curve::{Branch, Curve, Meets};
use super::intersection::Unknown;
use super::pairs::curves;
use super::piece::{CurveId, Other};
use super::relations::{Common, Meeting};
use super::roots::{Known, Roots};
use super::scene::Scene;
use super::triple::{contacts, crossings};
use crate::program::{Surface, SurfaceId};
use crate::surface::solve;

impl Scene<'_> {
    /// The curves common to two surfaces, or to one and a seam of it, by any of them.
    pub fn common(&self, id: CurveId) -> Common {
        let decide = || {
            let other = match id.other {
                Other::Surface(second) => Some(self.surface(second)),
                Other::Seam(seam) => {
                    let frame = self.frame(id.first);
                    frame.and_then(|frame| frame.seams.get(usize::from(seam)))
                }
            };
            let other = other.ok_or_else(|| Arc::new(Unknown::NoForm))?;
            let one = self.surface(id.first);
            let common = curves(one, other, self.nearness()).map_err(Arc::new)?;
            Ok(common.into_iter().collect())
        };
        let first = CurveId { branch: 0, ..id };
        self.relations.pairs.get(first, decide)
    }

    /// A curve by its name; none would be a mistake.
    pub fn curve(&self, id: CurveId) -> Option<Curve> {
        let common = self.common(id).ok()?;
        let branch = common.get(usize::from(id.branch))?;
        Some(branch.curve.clone())
    }

    /// The nodes of each two of some surfaces, ascending.
    pub fn nodes(&self, ids: &[SurfaceId]) -> SmallVec<[DVec3; 4]> {
        let mut nodes = SmallVec::new();
        for (k, &first) in ids.iter().enumerate() {
            for &second in &ids[k + 1..] {
                if [first, second]
                    .iter()
                    .all(|&id| self.surface(id).is_plane())
                {
                    continue;
                }
                let common = self.common(CurveId::first_of([first, second]));
                for branch in common.iter().flat_map(|branches| branches.iter()) {
                    nodes.extend(branch.nodes.iter().map(|&at| branch.curve.at(at)));
                }
            }
        }
        nodes
    }

    /// How near to a surface a curve of two others runs along it between two places, and how near
    /// it touches it: for [`Curve::meet`]. From what the curve is off its own surfaces, of which
    /// there may be much where the numbers of one are large, no third one is told.
    pub fn tolerances_beside(
        &self,
        third: &Surface,
        (curve, own): (&Curve, [&Surface; 2]),
        [start, end]: [f64; 2],
    ) -> [f64; 2] {
        const SHARES: [f64; 5] = [0.0, 0.2, 0.4, 0.6, 0.8];
        /// As much again between these.
        const MOST: f64 = 2.0;
        let [on, touch] = self.tolerances();
        let at = |share: f64| curve.at(start + share * (end - start));
        let is_near = |at: DVec3| third.value(at).abs() <= self.near * third.gradient(at).length();
        if !SHARES.iter().all(|&share| is_near(at(share))) {
            return [on, touch];
        }
        let off = SHARES.map(|share| solve::known_to(own, third, at(share)));
        let off = MOST * off.into_iter().fold(0.0, f64::max);
        [on + off.min(self.near), touch]
    }

    /// Where a surface meets a curve between two places, as [`Curve::meet_on`] finds it on a part: where
    /// that takes long, it is found once for all of the curve in the scene.
    pub fn meet(
        &self,
        (id, curve, own): (CurveId, &Curve, [&Surface; 2]),
        third: SurfaceId,
        ranges @ [range, part]: [[f64; 2]; 2],
        roots: &mut Roots,
    ) -> Meets {
        let surface = self.surface(third);
        let meet = |ranges: [[f64; 2]; 2], roots: &mut Roots| {
            let tolerances = self.tolerances_beside(surface, (curve, own), ranges[0]);
            let known = || id.pair().and_then(|pair| self.on_conics(pair, third));
            curve.meet_on(surface, ranges, tolerances, roots, known)
        };
        if curve.is_polynomial() || matches!(curve, Curve::Ellipse { .. }) {
            return meet(ranges, roots);
        }
        let meeting = self.relations.meetings.get((id, third), || {
            let mut roots = Roots::default();
            let whole = curve.range(DVec3::ZERO, self.reach).unwrap_or(range);
            let meets = meet([whole; 2], &mut roots);
            Arc::new(Meeting { meets, roots })
        });
        roots.clone_from(&meeting.roots);
        roots.keep_within(part);
        meeting.meets
    }

    /// The points of a third surface that the curves of two may have in common with it, by the lines
    /// and conics in which one of the two meets the third one; none if there are other curves, or some
    /// touch the other one.
    fn on_conics(&self, pair: [SurfaceId; 2], third: SurfaceId) -> Option<Known> {
        /// So that none next to the end of the reach is missed.
        const FARTHER: f64 = 2.0;
        let [a, b] = pair;
        [[a, b], [b, a]].into_iter().find_map(|[one, other]| {
            let mut both = [one, third];
            both.sort_unstable();
            let common = self.common(CurveId::first_of(both)).ok()?;
            let mut known = Known {
                points: SmallVec::new(),
                reach: self.reach,
            };
            for Branch { curve, .. } in &*common {
                let mut roots = Roots::default();
                let Some(range) = curve.range(DVec3::ZERO, FARTHER * self.reach) else {
                    continue;
                };
                let is_simple = !matches!(curve, Curve::Rulings(_));
                let meets = is_simple
                    .then(|| curve.meet(self.surface(other), range, self.tolerances(), &mut roots));
                // Where it touches, the place is known to fewer digits.
                let is_sharp = !roots.is_lost && roots.touching.is_empty();
                if meets != Some(Meets::Points) || !is_sharp {
                    return None;
                }
                let points = roots.simple.iter().map(|&t| curve.at(t));
                known.points.extend(points);
            }
            Some(known)
        })
    }

    /// The sine of the angle between a curve of two of three surfaces and the third, times that of
    /// the two.
    pub fn sine(&self, surfaces: [&Surface; 3], at: DVec3) -> f64 {
        let [p, q, r] = surfaces.map(|s| s.gradient(at).normalize_or_zero());
        p.cross(q).dot(r).abs()
    }

    /// Below which sine rounding moves a point common to three surfaces farther than to where
    /// they are still told to meet.
    pub fn slanting(&self) -> f64 {
        self.rounding / self.on_plane
    }

    pub fn is_slanting(&self, surfaces: [&Surface; 3], at: DVec3) -> bool {
        self.sine(surfaces, at) < self.slanting()
    }

    /// Where the curves of two surfaces cross a seam of one of them.
    pub fn on_seam(&self, mut ids: [SurfaceId; 2], seam: &Surface) -> SmallVec<[DVec3; 4]> {
        ids.sort_unstable();
        let common = self.common(CurveId::first_of(ids));
        let curves = common.iter().flat_map(|branches| branches.iter());
        let cross = |Branch { curve, .. }: &Branch| -> SmallVec<[DVec3; 4]> {
            let mut roots = Roots::default();
            if let Some(range) = curve.range(DVec3::ZERO, self.reach) {
                curve.meet(seam, range, self.tolerances(), &mut roots);
            }
            roots.simple.iter().map(|&root| curve.at(root)).collect()
        };
        curves.flat_map(cross).collect()
    }

    /// Where three surfaces touch. The same in whatever order they are named.
    pub fn contacts(&self, mut ids: [SurfaceId; 3]) -> Arc<[Touching]> {
        ids.sort_unstable();
        let decide = || contacts(self, ids).into_iter().collect();
        self.relations.triples.get(ids, decide)
    }

    /// The points in which three surfaces cross. Where they do at small sines, rounding finds
    /// another one along each of their curves: these are the same in whatever order they are
    /// named.
    pub fn crossings(&self, mut ids: [SurfaceId; 3]) -> Arc<[DVec3]> {
        ids.sort_unstable();
        let decide = || crossings(self, ids).into_iter().collect();
        self.relations.crossings.get(ids, decide)
    }
}
