//! The edges of a solid with curved surfaces, as chains of chords: the curves in
//! which two surfaces meet, and the seams along which faces are cut into
//! patches.

use crate::elementary;
use std::f64::consts::TAU;
use std::mem::take;
use std::ops::Range;

use glam::DVec3;
use smallvec::SmallVec;

use super::arc::{Arc, Ends};
use super::block::Block;
use super::chords::Chord;
use super::contacts::Contact;
use super::curve::{Branch, Meets};
use super::edges::along;
use super::faces::Faces;
use super::frame::Frame;
use super::ids::Position;
use super::intersection::Unknown;
use super::lines::Tracer;
use super::piece::{CurveId, Other};
use super::roots::Roots;
use super::scene::Scene;
use super::sectors::{HalfPlane, Sectors, Wedges};
use super::traced::Traced;
use super::triple::crossing_blur;
use crate::numeric::tolerance::{SAME_ANGLE, SAME_DIRECTION};
use crate::program::{Surface, SurfaceId};
use crate::surface::solve::known_to;
use crate::undecided::{Stop, Why};

/// What a plane is that is no surface of the solid.
#[derive(Clone, Copy, Debug)]
enum Cutting {
    /// A side of the block, with its span.
    Side(f64),
    /// A seam or the divider of a surface.
    Seam(SurfaceId),
}

#[derive(Clone, Copy, Debug)]
struct Event {
    at: f64,
    ends: Ends,
    /// The surface of the cell that the curve touches here.
    touched: Option<Position>,
    /// Where that is, if all surfaces there agree on it.
    point: Option<DVec3>,
}

impl Event {
    /// Whether edges may end here though the solid does not change along the
    /// curve.
    fn touches(&self) -> bool {
        self.touched.is_some() || matches!(self.ends, Ends::Node)
    }

    /// The surface of the cell that the curve crosses here.
    fn crossed(&self) -> Option<Position> {
        match self.ends {
            Ends::Surface(position) => Some(position),
            _ => None,
        }
    }
}

/// Finds the edges in blocks. Holds scratch memory.
#[derive(Default)]
pub(super) struct ArcTracer {
    faces: Faces,
    lines: Tracer,
    sectors: Sectors,
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
            let others = face.cell.ids().filter(|&second| second > first);
            let others = others.map(|second| (Other::Surface(second), scene.surface(second)));
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
                        let (line, length) = along(scene.given?, ends)?;
                        Some((line, (ends, length)))
                    });
                    for (line, edge) in lines {
                        let arc = Arc {
                            scene,
                            block: face,
                            carriers: faces.carriers(),
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
                        carriers: faces.carriers(),
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
        let Some([start, end]) = arc.range() else {
            return Ok(());
        };
        if !self.find_events(arc, [start, end])?
            || !self.find_changes(arc, [start, end])
            || self.is_of_lesser(arc, [start, end])
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

    /// Finds what ends stretches of a curve, in order. False if the curve is
    /// another pair's to trace: it is the first's of all surfaces through it that may
    /// carry faces, and the next one's through it that matters there. Undecided if it runs
    /// along a surface so closely that it cannot be told where it crosses.
    fn find_events(&mut self, arc: &Arc<'_>, range: [f64; 2]) -> Result<bool, Stop> {
        let Arc {
            scene,
            block,
            id,
            curve,
            ..
        } = *arc;
        let (first, second) = (id.first, id.second());
        let in_order = scene.given.is_none() || id.is_seam();
        self.events.clear();
        self.planes.clear();
        self.through.clear();
        self.sectors.inside.clear();
        let at_start = curve.at(range[0]);
        if self.is_decided(arc, range, at_start) {
            return Ok(false);
        }
        for (position, id) in block.surfaces() {
            let surface = scene.surface(id);
            if let Some(side) = arc.side_of_edge(id) {
                self.sectors.inside.push(side);
                continue;
            }
            self.roots.clear();
            let is_through = id == first
                || Some(id) == second
                || arc.meet(id, range, &mut self.roots) == Meets::Curve;
            if is_through {
                let is_between = first < id && second.is_none_or(|second| id < second);
                let is_before = || id < first && arc.carriers.binary_search(&id).is_ok();
                if in_order && (is_between || is_before()) {
                    return Ok(false);
                }
                self.through.push(position);
            }
            if self.roots.is_lost {
                return Err(Stop::undecided(Why::Crossing, block.center()));
            }
            self.add_crossings(arc, position, range[1] - range[0]);
            self.sectors.inside.push(surface.value(at_start) <= 0.0);
        }
        if !self.is_own(arc) {
            return Ok(false);
        }
        let bounds = curve.bounds(range);
        for (side, span) in block.sides() {
            let axis = side.linear.max_position();
            let at = side.anchor[axis];
            if bounds.min[axis] <= at + scene.near && bounds.max[axis] >= at - scene.near {
                self.cut(arc, (&side, Cutting::Side(span)), range);
            }
        }
        for k in 0..self.through.len() {
            let owner = block.id(self.through[k]);
            let frame = scene.frame(owner);
            for plane in frame.into_iter().flat_map(Frame::planes) {
                self.cut(arc, (plane, Cutting::Seam(owner)), range);
            }
        }
        self.add_nodes(arc, range);
        self.gather(arc);
        self.events.sort_by(|a, b| a.at.total_cmp(&b.at));
        self.sectors.crossings.clear();
        let crossings = self.events.iter().map(|event| (event.at, event.crossed()));
        self.sectors.crossings.extend(crossings);
        Ok(true)
    }

    /// Whether the solid is constant around a curve as all of it is on one side of one other
    /// surface. Tunes speed only: the same comes of looking at all surfaces.
    fn is_decided(&mut self, arc: &Arc<'_>, range: [f64; 2], at_start: DVec3) -> bool {
        if arc.edge.is_some() {
            return false;
        }
        let scene = arc.scene;
        let mut farthest: Option<(f64, SurfaceId)> = None;
        for (&decides, (_, id)) in self.sectors.decides.iter().zip(arc.block.surfaces()) {
            if decides.is_none() || id == arc.id.first || Some(id) == arc.id.second() {
                continue;
            }
            let surface = scene.surface(id);
            let value = surface.value(at_start);
            let is_farther = farthest.is_none_or(|(known, _)| known < value.abs());
            if decides == Some(value <= 0.0) && is_farther {
                farthest = Some((value.abs(), id));
            }
        }
        let Some((_, id)) = farthest else {
            return false;
        };
        self.roots.clear();
        let meets = arc.meet(id, range, &mut self.roots);
        meets == Meets::Points && self.roots.is_empty()
    }

    /// Whether a curve beside polyhedra is the arc's pair's to trace.
    fn is_own(&self, arc: &Arc<'_>) -> bool {
        let Some(own) = arc.id.pair() else {
            return true;
        };
        if arc.scene.given.is_none() || self.through.len() == 2 {
            return true;
        }
        let through = self.through.iter().map(|&position| arc.block.id(position));
        let through: SmallVec<[SurfaceId; 8]> = through.collect();
        let carries = |id| arc.carriers.binary_search(&id).is_ok();
        let first = arc.scene.first_of_through(&through, carries);
        first.map_or(arc.edge.is_some(), |first| first == own)
    }

    /// Adds where the curve crosses and touches a surface of the cell, by the roots found.
    fn add_crossings(&mut self, arc: &Arc<'_>, position: Position, range: f64) {
        if self.roots.is_empty() {
            return;
        }
        let scene = arc.scene;
        let id = arc.block.id(position);
        let triple = arc.with(scene.surface(id));
        let event = |at: f64, crosses: bool| Event {
            at,
            ends: if crosses {
                Ends::Surface(position)
            } else {
                Ends::Touch
            },
            touched: None,
            point: None,
        };
        let [one, other] = arc.surfaces;
        let on_edges = match arc.id.pair().filter(|_| arc.edge.is_none()) {
            Some([own, _]) if one.is_plane() => scene.on_edges([own, id], other),
            Some([_, own]) if other.is_plane() => scene.on_edges([own, id], one),
            _ => SmallVec::new(),
        };
        let reach = scene.touching_reach();
        let known = |at: f64| {
            let here = arc.curve.at(at);
            let distance = |p: &DVec3| p.distance(here);
            let nearest = on_edges.iter().copied();
            let nearest = nearest.min_by(|a, b| distance(a).total_cmp(&distance(b)));
            nearest.filter(|point| distance(point) <= reach)
        };
        let event = |at: f64, crosses: bool| Event {
            point: known(at),
            ..event(at, crosses)
        };
        // Along the curve it is where it is best known, too: other surfaces may cross there.
        let crossing = |at: f64| {
            let slanting = arc.slanting_crossing(arc.curve.at(at), id);
            let place = slanting.and_then(|point| arc.curve.place(point));
            event(place.unwrap_or(at), true)
        };
        if let ([at], [], []) = (&self.roots.simple[..], &self.roots.touching[..], arc.nodes) {
            self.events.push(crossing(*at));
            return;
        }
        let clusters = triple.clusters(&mut self.roots, scene.rounding);
        for cluster in &clusters {
            if cluster.is_single_root() {
                self.events.push(crossing(cluster.from));
                continue;
            }
            let at = triple.place(cluster, range);
            if cluster.crosses_at_node() {
                let node = arc.node(arc.curve.at(at));
                self.events.push(Event {
                    point: Some(node),
                    ..event(at, true)
                });
                continue;
            }
            // Seams are no surfaces of the solid.
            let contact = arc.id.pair().and_then(|[first, second]| {
                let surfaces = [one, other, triple.third];
                let here = triple.around(cluster, at);
                let contacts = scene.contacts([first, second, id]);
                let mut contacts = contacts.iter().copied();
                contacts.find(|contact| contact.is_same(scene, &surfaces, &here))
            });
            if contact.is_none() && !cluster.is_contact {
                let roots = cluster.roots.iter();
                self.events.extend(roots.map(|&at| crossing(at)));
                continue;
            }
            let point = match contact {
                Some(contact) => Some(contact.center),
                None => arc.touched_on_seam(arc.curve.at(at), id),
            };
            let known = point.and_then(|point| arc.curve.place(point));
            let is_within = |at: &f64| (cluster.from..=cluster.to).contains(at);
            self.events.push(Event {
                touched: Some(position),
                point,
                ..event(known.filter(is_within).unwrap_or(at), cluster.crosses())
            });
        }
    }

    /// Adds where the pair's curves pass through each other, and the nodes of others, and the
    /// apexes, of all surfaces through the curve: there these turn over.
    fn add_nodes(&mut self, arc: &Arc<'_>, [start, end]: [f64; 2]) {
        let Arc {
            scene,
            curve,
            nodes,
            ..
        } = *arc;
        let is_near = |at: f64, point: DVec3| curve.at(at).distance(point) <= scene.near;
        let through = self.through.iter().map(|&position| arc.block.id(position));
        let through: SmallVec<[SurfaceId; 8]> = through.collect();
        let mut points: SmallVec<[DVec3; 4]> = SmallVec::new();
        points.extend(through.iter().filter_map(|&id| scene.surface(id).apex()));
        if through.len() > 2 {
            points.extend(scene.nodes(&through));
        }
        let nodes = nodes.iter().copied();
        let mut places: SmallVec<[f64; 4]> =
            nodes.filter(|at| (start..=end).contains(at)).collect();
        for point in points {
            let at = curve.place(point).filter(|at| start < *at && *at < end);
            let is_known = || places.iter().any(|&place| is_near(place, point));
            if let Some(at) = at.filter(|&at| is_near(at, point) && !is_known()) {
                places.push(at);
            }
        }
        self.events.extend(places.into_iter().map(|at| Event {
            at,
            ends: Ends::Node,
            touched: None,
            point: None,
        }));
    }

    /// Moves crossings at sines so small that rounding moves them by more than what is one
    /// point to where the curve has an apex, or crosses another surface at a greater sine, if
    /// they may as well be there.
    fn gather(&mut self, arc: &Arc<'_>) {
        let Arc { scene, curve, .. } = *arc;
        // How far from where it was found an event may as well be.
        let blur = |event: &Event| match event.ends {
            Ends::Surface(position) if event.touched.is_none() => {
                let third = scene.surface(arc.block.id(position));
                let here = curve.at(event.at);
                let normal = third.gradient(here).normalize_or_zero();
                let along = curve.direction(event.at).normalize_or_zero();
                let off = known_to(arc.surfaces, third, here);
                crossing_blur(scene.rounding.max(off), normal.dot(along))
            }
            Ends::Node => 0.0,
            _ => f64::INFINITY,
        };
        let blurs: SmallVec<[f64; 16]> = self.events.iter().map(blur).collect();
        let is_blurred = |blur: f64| blur.is_finite() && blur > scene.weld;
        for k in (0..blurs.len()).filter(|&k| is_blurred(blurs[k])) {
            let from = self.events[k].at;
            let here = curve.at(from);
            let reach = blurs[k].min(scene.touching_reach());
            // Also on the way there: a curve may pass through a point twice.
            let is_near = |at: f64| {
                let between = [0.5 * (from + at), at].map(|at| curve.at(at).distance(here));
                between[0].max(between[1]) <= reach
            };
            let sharper = (0..blurs.len())
                .filter(|&other| blurs[other] < 0.5 * reach && is_near(self.events[other].at));
            if let Some(best) = sharper.min_by(|&a, &b| blurs[a].total_cmp(&blurs[b])) {
                let Event { at, point, .. } = self.events[best];
                let known =
                    point.unwrap_or_else(|| self.point_of(arc, &self.events[best], curve.at(at)));
                self.events[k].at = at;
                self.events[k].point = Some(known);
            }
        }
    }

    /// Whether a curve lies in a surface that comes before the arc's first one, and
    /// does not matter on that, but may carry faces: then it is that one's to trace.
    fn is_of_lesser(&mut self, arc: &Arc<'_>, range: [f64; 2]) -> bool {
        let scene = arc.scene;
        let first = arc.id.first;
        let lesser = arc.carriers.iter().take_while(|&&id| id < first);
        let mut others = lesser.filter(|&&id| arc.block.position_of(id).is_none());
        let start = arc.curve.at(range[0]);
        // Surfaces farther off are not through it for sure.
        let clearly = 1e3 * scene.near;
        others.any(|&id| {
            let surface = scene.surface(id);
            let slope = surface.gradient(start).length();
            if surface.value(start).abs() > clearly * (slope + clearly) {
                return false;
            }
            self.roots.clear();
            arc.meet(id, range, &mut self.roots) == Meets::Curve
        })
    }

    /// Adds where a curve crosses a plane that is no surface of the solid.
    fn cut(&mut self, arc: &Arc<'_>, (plane, cutting): (&Surface, Cutting), range: [f64; 2]) {
        self.roots.clear();
        let tolerances = arc.scene.tolerances();
        let meets = arc.curve.meet(plane, range, tolerances, &mut self.roots);
        if meets == Meets::Points && !self.roots.simple.is_empty() {
            let ends = Ends::Plane(self.planes.len());
            self.planes.push((*plane, cutting));
            let places = self.roots.simple.iter();
            self.events.extend(places.map(|&at| Event {
                at,
                ends,
                touched: None,
                point: None,
            }));
        }
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
        // How far a surface bends from there, counter-clockwise.
        let bend = |half_plane: HalfPlane| {
            let surface = scene.surface(id(half_plane));
            let (gradient, towards) = (surface.gradient(at), towards(half_plane));
            let off = -0.5 * surface.curvature_along(towards) / gradient.length_squared();
            off * gradient.dot(direction.cross(towards))
        };
        let is_clear = self.sectors.is_in_order()
            || self.sort_around(towards, bend, direction, scene.same_bend());
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
        bend: impl Fn(HalfPlane) -> f64,
        direction: DVec3,
        same_bend: f64,
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
        let mut is_clear = true;
        for same in half_planes.chunk_by_mut(|a, b| b.0 - a.0 <= SAME_DIRECTION) {
            if same.len() > 1 {
                for (key, half_plane) in same.iter_mut() {
                    *key = bend(*half_plane);
                }
                same.sort_unstable_by(in_order);
                is_clear &= same.windows(2).all(|w| w[1].0 - w[0].0 > same_bend);
            }
        }
        let around = half_planes.into_iter().map(|(_, half_plane)| half_plane);
        self.sectors.around.clear();
        self.sectors.around.extend(around);
        is_clear
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
