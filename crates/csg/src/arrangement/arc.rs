//! A curve on its way through a block: its points, directions around it, and its
//! chords.

use glam::DVec3;

use super::ball::Ball;
use super::block::Block;
use super::chords::Chord;
use super::contacts::Contact;
use super::curve::{Curve, Meets};
use super::faces::Faces;
use super::ids::Position;
use super::lines::{Along, side_of_edge};
use super::piece::{CurveId, Piece};
use super::roots::Roots;
use super::scene::Scene;
use super::sectors::{HalfPlane, Place, Wedges, emit};
use super::triple::Triple;
use crate::numeric::tolerance::CROSSING;
use crate::program::{Ends as EdgeEnds, Surface, SurfaceId};

/// What ends a stretch of a curve.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ends {
    /// A surface of the cell.
    Surface(Position),
    /// A side of the block, or a seam or divider, where faces end but the solid
    /// does not: one of the tracer's planes.
    Plane(usize),
    /// The curve comes near a surface of the cell, and may touch it; or it ends
    /// itself.
    Touch,
    /// Another curve of the same surfaces passes through it, or itself again.
    Node,
}

/// A curve on its way through a block.
pub(super) struct Arc<'a> {
    pub scene: &'a Scene<'a>,
    /// With only what matters on the first of the pair.
    pub block: &'a Block,
    /// All of the whole block.
    pub faces: &'a Faces,
    /// The name of the curve.
    pub id: CurveId,
    /// The two that meet in it, one of which may be a seam.
    pub surfaces: [&'a Surface; 2],
    pub curve: &'a Curve,
    pub nodes: &'a [f64],
    /// The given edge that the curve runs along, and the stretch of it.
    pub edge: Option<(EdgeEnds, [f64; 2])>,
}

impl Arc<'_> {
    /// The part of the curve on which it is to be traced in its block.
    pub fn range(&self) -> Option<[f64; 2]> {
        let Block { low, high, .. } = *self.block;
        let reach = 0.5 * (high - low).length();
        let [start, end] = self.curve.range(self.block.center(), reach)?;
        let Some((_, stretch)) = self.edge else {
            return Some([start, end]);
        };
        let [start, end] = [start.max(stretch[0]), end.min(stretch[1])];
        (start < end).then_some([start, end])
    }

    /// Where another surface meets the curve between two places, and on a part of it.
    pub fn meet(&self, third: SurfaceId, ranges: [[f64; 2]; 2], roots: &mut Roots) -> Meets {
        let own = (self.id, self.curve, self.surfaces);
        roots.clear();
        self.scene.meet(own, third, ranges, roots)
    }

    /// On which side of a surface all of the given edge is that the curve runs along, if
    /// that is known.
    pub fn side_of_edge(&self, id: SurfaceId) -> Option<bool> {
        let ((edge, _), given) = self.edge.zip(self.scene.given)?;
        let is_own = given.are_of_one(self.id.first, id);
        match is_own.then(|| side_of_edge(self.scene, given, edge, id))? {
            Along::Beside(is_inside) => Some(is_inside),
            Along::Across | Along::Through => None,
        }
    }

    /// The sine of the angle from one half-plane to another one, counter-clockwise
    /// about the curve, whose sign is the same all along it; 0 where that is not
    /// known. Conics without nodes, on which this is to be asked, are nowhere singular,
    /// and there alone surfaces have a tangent plane in common.
    pub fn turn(&self, half_planes: [HalfPlane; 2], at: f64) -> f64 {
        if matches!(self.curve, Curve::Rulings(_)) {
            return 0.0;
        }
        let point = self.curve.at(at);
        let direction = self.curve.direction(at).normalize_or_zero();
        let [a, b] = half_planes.map(|half_plane| self.towards(half_plane, point, direction));
        direction.dot(a.cross(b))
    }

    /// Whether a place is farther than near on the other side of a surface, as far as that
    /// is not known by the given edge.
    pub fn is_beyond(&self, at: DVec3, id: SurfaceId, is_inside: bool) -> bool {
        let surface = self.scene.surface(id);
        let value = surface.value(at);
        if (value <= 0.0) == is_inside {
            return false;
        }
        let slope = surface.gradient(at).length();
        value.abs() > self.scene.near * slope && self.side_of_edge(id).is_none()
    }

    /// Whether a stretch of the curve is one point but for rounding.
    pub fn is_short(&self, [start, end]: [f64; 2]) -> bool {
        let middle = self.curve.at(0.5 * (start + end));
        let is_here = |t: f64| self.curve.at(t).distance(middle) <= self.scene.weld;
        is_here(start) && is_here(end)
    }

    /// The direction in which half of a tangent plane extends from a point.
    pub fn towards(&self, half_plane: HalfPlane, at: DVec3, direction: DVec3) -> DVec3 {
        let id = self.block.id(half_plane.position);
        let gradient = self.scene.surface(id).gradient(at);
        let outer = gradient.cross(direction).normalize_or_zero();
        if half_plane.is_inner { -outer } else { outer }
    }

    /// A point of the curve from next to it, and of a third surface that it meets
    /// there.
    pub fn point(&self, start: DVec3, third: Option<&Surface>) -> DVec3 {
        let scene = self.scene;
        if self.edge.is_some() {
            return start;
        }
        if let Some(apex) = self.apex_at(start) {
            return apex;
        }
        let [a, b] = self.surfaces;
        match third {
            Some(third) => scene.common_to(&[a, b, third], start),
            None => scene.common_to(&[a, b], start),
        }
    }

    /// The point where the curve crosses a third surface, from next to it.
    pub fn crossing(&self, start: DVec3, third: SurfaceId) -> DVec3 {
        let slanting = self.slanting_crossing(start, third);
        slanting.unwrap_or_else(|| self.point(start, Some(self.scene.surface(third))))
    }

    /// The same where the sine of the angle is so small that rounding finds others on the
    /// other two curves: the one that is known best.
    pub fn slanting_crossing(&self, start: DVec3, third: SurfaceId) -> Option<DVec3> {
        let scene = self.scene;
        let [a, b] = self.surfaces;
        if self.edge.is_some() {
            return None;
        }
        match self.id.pair() {
            Some([first, second]) => {
                let all = [a, b, scene.surface(third)];
                let known = scene
                    .is_slanting(all, start)
                    .then(|| scene.crossings([first, second, third]));
                self.nearest(start, &known?)
            }
            None => self.slanting_on_seam(start, [self.id.first, third], b),
        }
    }

    /// The contact that a crossing of a third surface at a small sine is part of, as another curve
    /// of the three does not tell it from others.
    pub fn contact_at(&self, crossing: DVec3, third: SurfaceId) -> Option<DVec3> {
        let scene = self.scene;
        let [first, second] = self.id.pair().filter(|_| self.edge.is_none())?;
        let [a, b] = self.surfaces;
        if scene.sine([a, b, scene.surface(third)], crossing) > CROSSING {
            return None;
        }
        let contacts = scene.contacts([first, second, third]);
        let is_here = |known: &Ball| known.center.distance(crossing) <= known.radius + scene.weld;
        let mut contacts = contacts.iter();
        let contact = contacts.find(|contact| contact.crossings.iter().any(is_here))?;
        Some(contact.ball.center)
    }

    /// The point where the curve crosses a seam of one of its surfaces.
    pub fn cut(&self, start: DVec3, seam: &Surface, owner: SurfaceId) -> DVec3 {
        let other = self.id.surfaces().find(|&id| id != owner);
        let slanting = other.and_then(|other| self.slanting_on_seam(start, [owner, other], seam));
        slanting.unwrap_or_else(|| self.point(start, Some(seam)))
    }

    /// Where the curves of a surface and another one cross a seam of the first, if that is
    /// where the point common to all three is known best.
    fn slanting_on_seam(
        &self,
        start: DVec3,
        pair: [SurfaceId; 2],
        seam: &Surface,
    ) -> Option<DVec3> {
        /// In sines: the points themselves tell for sure.
        const PERHAPS: f64 = 100.0;
        let scene = self.scene;
        let [own, other] = pair.map(|id| scene.surface(id));
        if scene.sine([own, other, seam], start) > PERHAPS * scene.slanting() {
            return None;
        }
        let mut known = scene.on_seam(pair, seam);
        known.retain(|at| {
            scene.is_slanting([own, other, seam], *at)
                && sine([own, other], *at) < sine([own, seam], *at)
        });
        self.nearest(start, &known)
    }

    /// Where a third surface touches the curve, which is a seam: on the curve along which it
    /// touches the surface, if it does so along one.
    pub fn touched_on_seam(&self, start: DVec3, third: SurfaceId) -> Option<DVec3> {
        let is_seam = self.id.pair().is_none();
        let known = is_seam.then(|| self.scene.on_seam([self.id.first, third], self.surfaces[1]));
        self.nearest(start, &known?)
    }

    fn nearest(&self, start: DVec3, known: &[DVec3]) -> Option<DVec3> {
        let distance = |known: &DVec3| known.distance(start);
        let nearest = known.iter().copied();
        let nearest = nearest.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.filter(|known| distance(known) <= self.scene.touching_reach())
    }

    /// The point where another branch passes through the curve, from next to it.
    pub fn node(&self, start: DVec3) -> DVec3 {
        self.apex_at(start).unwrap_or(start)
    }

    /// Apexes are exact, where there is no gradient to improve them by.
    fn apex_at(&self, start: DVec3) -> Option<DVec3> {
        let is_apex = |apex: &DVec3| apex.distance(start) <= self.scene.near;
        let mut apexes = self.surfaces.iter().filter_map(|s| s.apex());
        apexes.find(is_apex)
    }

    /// The curve, and a third surface.
    pub fn with<'b>(&'b self, third: &'b Surface) -> Triple<'b> {
        Triple {
            curve: self.curve,
            nodes: self.nodes,
            pair: self.surfaces,
            third,
        }
    }

    /// The place at which the curve meets other surfaces of the cell.
    pub fn contact(&self, others: &[Position], at: DVec3) -> Contact {
        let others = others.iter().map(|&position| self.block.id(position));
        Contact {
            at,
            surfaces: self.id.surfaces().chain(others).collect(),
        }
    }

    /// Whether a chord may go on past a side of the block: it would from one to the other of the
    /// nearest sides of larger blocks, `span` apart, whether there are such or not. So curves side
    /// by side are cut by the same planes, as they were before, and keep their order.
    pub fn goes_on(&self, at: f64, span: f64, stray: f64) -> bool {
        /// Of the angle between its halves. Tunes counts only.
        const LEAST_COSINE: f64 = 0.95;
        /// In which places grow where the curve's speed is found.
        const STEP: f64 = 1e-6;
        if stray == 0.0 || self.curve.is_line() {
            return false;
        }
        let speed = self.curve.at(at - STEP).distance(self.curve.at(at + STEP)) / (2.0 * STEP);
        let step = 0.5 * span / speed;
        let [before, here, after] = [at - step, at, at + step].map(|at| self.curve.at(at));
        let (back, on) = (here - before, after - here);
        let chord = after - before;
        let sag = back.cross(chord).length() / chord.length();
        sag <= stray && back.dot(on) >= LEAST_COSINE * back.length() * on.length()
    }

    /// Adds the chords of a stretch.
    pub fn emit(
        &self,
        wedges: &Wedges,
        [(from, goes_back), (to, goes_on)]: [(Place, bool); 2],
        chord: Chord,
        pieces: &mut Vec<Piece>,
    ) {
        if wedges.is_empty() {
            return;
        }
        let size = 0.5 * (self.block.high - self.block.low).max_element();
        let chords = self.curve.chords(from.0, to.0, chord.turn, size);
        let mut before = from;
        for k in 1..=chords {
            let here = if k == chords {
                to
            } else {
                let share = f64::from(k) / f64::from(chords);
                let t = from.0 + share * (to.0 - from.0);
                (t, self.point(self.curve.at(t), None))
            };
            let goes_on = [k == 1 && goes_back, k == chords && goes_on];
            emit(wedges, self.id, [before, here], goes_on, pieces);
            before = here;
        }
    }
}

/// Of the angle at which two surfaces meet.
fn sine(pair: [&Surface; 2], at: DVec3) -> f64 {
    let [p, q] = pair.map(|surface| surface.gradient(at).normalize_or_zero());
    p.cross(q).length()
}
