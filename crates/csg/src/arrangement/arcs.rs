//! The edges of a solid with curved surfaces, as chains of chords: the curves in
//! which two surfaces meet, and the seams along which faces are cut into
//! patches.

mod beside;
mod event;
mod events;

use crate::elementary;
use std::f64::consts::TAU;
use std::mem::take;
use std::ops::Range;

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use self::beside::Beside;
use self::event::{Cutting, Event};
use super::arc::{Arc, Ends};
use super::block::Block;
use super::chords::Chord;
use super::contacts::Contact;
use super::curve::Branch;
use super::edges::along;
use super::faces::Faces;
use super::ids::Position;
use super::intersection::Unknown;
use super::lines::Tracer;
use super::piece::{CurveId, Other};
use super::roots::Roots;
use super::scene::Scene;
use super::sectors::{HalfPlane, Sectors, Wedges};
use super::traced::Traced;
use crate::numeric::tolerance::{SAME_ANGLE, SAME_DIRECTION};
use crate::program::{Surface, SurfaceId};
use crate::undecided::{Stop, Why};

/// Finds the edges in blocks. Holds scratch memory.
#[derive(Default)]
pub(super) struct ArcTracer {
    faces: Faces,
    lines: Tracer,
    sectors: Sectors,
    beside: Beside,
    events: Vec<Event>,
    /// The planes of these that are no surfaces of the solid.
    planes: Vec<(Surface, Cutting)>,
    /// The points of the curve at all events.
    places: Vec<DVec3>,
    roots: Roots,
    /// All surfaces of the cell through the curve.
    through: SmallVec<[Position; 4]>,
    /// Per position of the cell whether the stretch is inside, by what was crossed before.
    signs: Vec<bool>,
    /// For each stretch whether the solid may change around the curve.
    changes: Vec<bool>,
}

/// What touches the apex of a cone, if that is in a block.
fn at_apex(scene: &Scene<'_>, block: &Block, cone: &Surface) -> Option<Contact> {
    let at = cone.apex().filter(|&apex| block.contains(apex))?;
    let touches = |&id: &SurfaceId| {
        let other = scene.surface(id);
        other.value(at).abs() <= scene.near * other.gradient(at).length()
    };
    Some(Contact {
        at,
        surfaces: block.cell.ids().filter(touches).collect(),
    })
}

impl ArcTracer {
    /// Appends all pieces of edges in a block, curves as chords, and contacts. Undecided where curves
    /// are not known in closed form, or so near to other surfaces that it cannot be told what meets along them.
    pub fn trace(
        &mut self,
        scene: &Scene<'_>,
        block: &Block,
        chord: Chord,
        traced: &mut Traced,
    ) -> Result<(), Stop> {
        let mut ids = block.cell.ids();
        if scene.given.is_some() && ids.all(|id| scene.surface(id).is_plane()) {
            return self.lines.trace(scene, block, &mut traced.pieces);
        }
        // Given back below.
        let mut faces = take(&mut self.faces);
        faces.enter(scene, block);
        for (first, face) in faces.iter() {
            let one = scene.surface(first);
            let frame = scene.frame(first);
            if !one.is_plane() && frame.is_none() {
                return Err(Stop::undecided(Why::Chart, one.anchor()));
            }
            traced.contacts.extend(at_apex(scene, face, one));
            self.sectors.enter(scene, face);
            let others = faces
                .beside(first)
                .map(|second| (Other::Surface(second), scene.surface(second)));
            let seams = frame.into_iter().flat_map(|frame| &frame.seams);
            let seams = (0u16..).map(Other::Seam).zip(seams);
            for (other, second) in others.chain(seams) {
                let id = CurveId {
                    first,
                    other,
                    branch: 0,
                };
                if let Some(edges) = id.pair().and_then(|pair| scene.only_edges(pair)) {
                    let lines = edges.iter().filter_map(|&ends| {
                        let (line, stretch) = along(scene.given?, ends)?;
                        Some((line, (ends, stretch)))
                    });
                    for (line, edge) in lines {
                        let arc = Arc {
                            scene,
                            block: face,
                            faces: &faces,
                            id,
                            surfaces: [one, second],
                            curve: &line,
                            nodes: &[],
                            edge: Some(edge),
                        };
                        self.trace_arc(&arc, chord, traced)?;
                    }
                    continue;
                }
                // (Many surfaces may meet in one place, and be in one block.)
                scene.go_on()?;
                let common = match scene.common(id) {
                    Ok(common) => common,
                    Err(unknown) => match &*unknown {
                        // In a single point there is no edge.
                        Unknown::Touch(contacts) => {
                            let inside = contacts.iter().filter(|&&at| block.contains(at));
                            traced.contacts.extend(inside.map(|&at| Contact {
                                at,
                                surfaces: id.surfaces().collect(),
                            }));
                            continue;
                        }
                        Unknown::NoForm => {
                            return Err(Stop::undecided(Why::Curve, block.center()));
                        }
                    },
                };
                for (branch, Branch { curve, nodes }) in (0u16..).zip(&*common) {
                    let arc = Arc {
                        scene,
                        block: face,
                        faces: &faces,
                        id: CurveId { branch, ..id },
                        surfaces: [one, second],
                        curve,
                        nodes,
                        edge: None,
                    };
                    self.trace_arc(&arc, chord, traced)?;
                }
            }
        }
        self.faces = faces;
        Ok(())
    }

    fn trace_arc(&mut self, arc: &Arc<'_>, chord: Chord, traced: &mut Traced) -> Result<(), Stop> {
        let Arc { scene, curve, .. } = *arc;
        let Some(range) = arc.range() else {
            return Ok(());
        };
        let sectors = &self.sectors;
        let has_looks = |position| sectors.has_looks(position);
        let Some([start, end]) = self.beside.look(arc, range, has_looks) else {
            return Ok(());
        };
        if !self.find_events(arc, range, [start, end])?
            || !self.find_changes(arc, [start, end])
            || self.is_of_earlier(arc, range)
        {
            return Ok(());
        }
        self.places.clear();
        let place = |event: &Event| event.point.unwrap_or_else(|| curve.at(event.at));
        let places = self.events.iter().map(place);
        self.places.extend(places);
        let begin = || arc.point(curve.at(start), None);
        self.signs.clone_from(&self.sectors.inside);
        let mut open = Wedges::new();
        let mut from = ((start, DVec3::NAN), false);
        for stretch in 0..=self.events.len() {
            let before = stretch.checked_sub(1).map(|k| self.events[k]);
            if let Some(crossed) = before.and_then(|event| event.crossed()) {
                self.signs[crossed.index()] ^= true;
            }
            let [low, high] = self.ends(stretch, [start, end]);
            let wedges = if self.is_one_place(arc, stretch, [low, high]) {
                open.clone()
            } else if self.changes[stretch] {
                let middle = 0.5 * (low + high);
                let wedges = self.wedges(arc, middle, stretch);
                wedges.map_err(|why| Stop::undecided(why, curve.at(middle)))?
            } else {
                Wedges::new()
            };
            let Some(event) = before else {
                open = wedges;
                if !open.is_empty() {
                    from.0.1 = begin();
                }
                continue;
            };
            if open.is_empty() && wedges.is_empty() {
                continue;
            }
            let same = self.at_same_place(scene.weld, stretch - 1);
            if wedges != open || event.touches() || same.len() > 1 {
                let here = (event.at, self.point(arc, stretch - 1));
                let goes_on = same.len() == 1 && self.goes_on(arc, &event, chord.stray);
                arc.emit(&open, [from, (here, goes_on)], chord, &mut traced.pieces);
                let others = self.surfaces_of(same);
                if event.touched.is_some() || others.len() > 1 {
                    traced.contacts.push(arc.contact(&others, here.1));
                }
                (open, from) = (wedges, (here, goes_on));
            }
        }
        if !open.is_empty() {
            let last = if curve.is_closed() {
                begin()
            } else {
                arc.point(curve.at(end), None)
            };
            arc.emit(
                &open,
                [from, ((end, last), false)],
                chord,
                &mut traced.pieces,
            );
        }
        Ok(())
    }

    /// Finds the stretches on which the solid may change around the curve; false
    /// if there are none. Around most it is the same whatever the signs of both
    /// surfaces, and so in all sectors in any order.
    fn find_changes(&mut self, arc: &Arc<'_>, range: [f64; 2]) -> bool {
        let stretches = self.events.len() + 1;
        self.changes.clear();
        let around: &[HalfPlane] = match self.through[..] {
            [a] => &HalfPlane::both(a),
            [a, b] => &HalfPlane::of_pair([a, b]),
            _ => {
                self.sectors.order_is(&[]);
                self.changes.resize(stretches, true);
                return true;
            }
        };
        self.sectors.order_is(around);
        let all = (1 << around.len()) - 1;
        for stretch in 0..stretches {
            let (values, place) = self.sectors.values(arc.block, stretch);
            let here = values >> (place * around.len()) & all;
            self.changes.push(here != 0 && here != all);
        }
        let Some(first) = self.changes.iter().position(|&changes| changes) else {
            return false;
        };
        if let &[a, b, c, d] = around {
            let [low, high] = self.ends(first, range);
            let has_nodes = self.events.iter().any(|e| matches!(e.ends, Ends::Node));
            let turn = match has_nodes {
                true => 0.0,
                false => arc.turn([a, b], 0.5 * (low + high)),
            };
            if turn.abs() <= SAME_ANGLE && arc.edge.is_none() {
                self.sectors.order_is(&[]);
            } else if turn < 0.0 {
                self.sectors.order_is(&[a, d, c, b]);
            }
        }
        true
    }

    /// Whether nothing but a side of the block is at an event, past which a chord may go on.
    fn goes_on(&self, arc: &Arc<'_>, event: &Event, stray: f64) -> bool {
        match event.ends {
            Ends::Plane(index) => match self.planes[index].1 {
                Cutting::Side(span) => arc.goes_on(event.at, span, stray),
                Cutting::Seam(_) => false,
            },
            _ => false,
        }
    }

    /// Where an event is.
    fn point(&self, arc: &Arc<'_>, event: usize) -> DVec3 {
        self.point_of(arc, &self.events[event], self.places[event])
    }

    /// Where an event is, from next to it.
    fn point_of(&self, arc: &Arc<'_>, event: &Event, place: DVec3) -> DVec3 {
        if let Some(point) = event.point {
            return point;
        }
        match event.ends {
            Ends::Surface(position) => arc.crossing(place, arc.block.id(position)),
            Ends::Plane(index) => match self.planes[index] {
                (plane, Cutting::Seam(owner)) => arc.cut(place, &plane, owner),
                (plane, Cutting::Side(_)) => arc.point(place, Some(&plane)),
            },
            Ends::Touch => arc.point(place, None),
            Ends::Node => arc.node(place),
        }
    }

    /// Where a stretch begins and ends.
    fn ends(&self, stretch: usize, [start, end]: [f64; 2]) -> [f64; 2] {
        let before = stretch.checked_sub(1).map(|k| self.events[k]);
        let after = self.events.get(stretch);
        [
            before.map_or(start, |event| event.at),
            after.map_or(end, |event| event.at),
        ]
    }

    /// Whether a stretch is one place: rounding tells which of the events at its ends comes first,
    /// and what would be between them.
    fn is_one_place(&self, arc: &Arc<'_>, stretch: usize, [low, high]: [f64; 2]) -> bool {
        let ends = stretch.checked_sub(1).zip(self.places.get(stretch));
        let is_near = |(before, &after): (usize, &DVec3)| {
            self.places[before].distance(after) <= arc.scene.weld
        };
        low >= high || ends.is_some_and(is_near) && arc.is_short([low, high])
    }

    /// The faces that meet in the block on the stretch of a curve around its
    /// middle, or why that cannot be told.
    fn wedges(&mut self, arc: &Arc<'_>, middle: f64, stretch: usize) -> Result<Wedges, Why> {
        let Arc { scene, block, .. } = *arc;
        let at = arc.curve.at(middle);
        if !block.contains(at) {
            return Ok(Wedges::new());
        }
        // If not, a crossing was missed, or is none.
        let is_as_crossed = block
            .surfaces()
            .zip(&self.signs)
            .all(|((position, id), &sign)| {
                !arc.is_beyond(at, id, sign) || self.through.contains(&position)
            });
        if !is_as_crossed {
            return Err(Why::Crossing);
        }
        let direction = arc.curve.direction(middle).normalize_or_zero();
        let id = |half_plane: HalfPlane| block.id(half_plane.position);
        let towards = |half_plane: HalfPlane| arc.towards(half_plane, at, direction);
        // How a surface bends from there, counter-clockwise.
        let bends = |half_plane: HalfPlane| {
            let towards = towards(half_plane);
            let surface = scene.surface(id(half_plane));
            surface.bends(at, towards, direction.cross(towards))
        };
        let is_clear = self.sectors.is_in_order()
            || self.sort_around(towards, bends, direction, scene.same_bends());
        if self.sectors.around.len() > 64 {
            return Err(Why::Order);
        }
        let (values, place) = self.sectors.values(block, stretch);
        let patch = |half_plane: HalfPlane| {
            let frame = scene.frame(id(half_plane));
            frame.map_or(0, |f| f.patch(at, towards(half_plane), scene.on_plane))
        };
        let wedges = self.sectors.wedges(block, scene, values, place, patch);
        if is_clear || wedges.is_empty() {
            Ok(wedges)
        } else {
            Err(Why::Order)
        }
    }

    /// Sorts the half-planes of the surfaces through a curve, those in the same
    /// direction by how they bend from it; false if two of them cannot be told
    /// apart.
    fn sort_around(
        &mut self,
        towards: impl Fn(HalfPlane) -> DVec3,
        bends: impl Fn(HalfPlane) -> [f64; 3],
        direction: DVec3,
        same_bends: [f64; 3],
    ) -> bool {
        let [first, _] = HalfPlane::both(self.through[0]);
        let x = towards(first);
        let y = direction.cross(x);
        let mut half_planes: SmallVec<[(f64, HalfPlane); 8]> = SmallVec::new();
        for half_plane in self.through.iter().copied().flat_map(HalfPlane::both) {
            let towards = towards(half_plane);
            // From just before the first, so that nothing is cut there.
            let angle = elementary::atan2(towards.dot(y), towards.dot(x));
            let turns = if angle < -SAME_DIRECTION { TAU } else { 0.0 };
            half_planes.push((angle + turns, half_plane));
        }
        let in_order =
            |a: &(f64, HalfPlane), b: &(f64, HalfPlane)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        half_planes.sort_unstable_by(in_order);
        // Those that agree to one power of the distance from the curve by the next one.
        let mut same: SmallVec<[Range<usize>; 2]> = smallvec![0..half_planes.len()];
        let mut least = SAME_DIRECTION;
        for power in 0..=same_bends.len() {
            let is_told = |a: &(f64, HalfPlane), b: &(f64, HalfPlane)| b.0 - a.0 > least;
            let mut still_same = SmallVec::new();
            for range in same {
                let mut start = range.start;
                for chunk in half_planes[range].chunk_by(|a, b| !is_told(a, b)) {
                    if chunk.len() > 1 {
                        still_same.push(start..start + chunk.len());
                    }
                    start += chunk.len();
                }
            }
            same = still_same;
            let Some(&next) = same_bends.get(power) else {
                break;
            };
            least = next;
            for range in &same {
                let same = &mut half_planes[range.clone()];
                for (key, half_plane) in same.iter_mut() {
                    *key = bends(*half_plane)[power];
                }
                same.sort_unstable_by(in_order);
            }
        }
        let around = half_planes.into_iter().map(|(_, half_plane)| half_plane);
        self.sectors.around.clear();
        self.sectors.around.extend(around);
        same.is_empty()
    }

    /// The events at the same place as one: other edges may touch the curve there
    /// though none ends.
    fn at_same_place(&self, weld: f64, event: usize) -> Range<usize> {
        let (before, rest) = self.places.split_at(event);
        let (here, after) = (rest[0], &rest[1..]);
        let is_near = |other: &&DVec3| other.distance(here) <= weld;
        let before = before.iter().rev().take_while(is_near).count();
        let after = after.iter().take_while(is_near).count();
        event - before..event + 1 + after
    }

    /// The surfaces of the cell that a curve crosses or touches at some events.
    fn surfaces_of(&self, events: Range<usize>) -> SmallVec<[Position; 4]> {
        let mut surfaces = SmallVec::new();
        for event in &self.events[events] {
            for position in [event.crossed(), event.touched].into_iter().flatten() {
                if !surfaces.contains(&position) {
                    surfaces.push(position);
                }
            }
        }
        surfaces
    }
}
