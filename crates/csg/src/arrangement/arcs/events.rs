//! What ends stretches of a curve in a block, in order: other surfaces, sides and seams, and where
//! it is touched.

use glam::DVec3;
use smallvec::SmallVec;

use super::ArcTracer;
use super::event::{Cutting, Event};
use crate::arrangement::arc::{Arc, Ends};
use crate::arrangement::ball::Touching;
use crate::arrangement::curve::Meets;
use crate::arrangement::frame::Frame;
use crate::arrangement::ids::Position;
use crate::arrangement::triple::crossing_blur;
use crate::program::{Side, Surface, SurfaceId};
use crate::surface::solve::known_to;
use crate::undecided::{Stop, Why};

/// Whether a given edge that begins on a surface but for rounding begins inside of it: by the
/// place farthest from where it was found to cross it, as it may have been found to do so at its
/// beginning or not.
fn starts_inside(arc: &Arc<'_>, surface: &Surface, range: [f64; 2], events: &[Event]) -> bool {
    let crossings = events.iter().filter(|event| event.crossed().is_some());
    let mut places: SmallVec<[f64; 6]> = crossings.map(|event| event.at).collect();
    places.extend(range);
    places.sort_unstable_by(f64::total_cmp);
    let gaps = places.windows(2).map(|ends| ends[1] - ends[0]);
    let widest = gaps.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    let (crossed, _) = widest.unwrap_or_default();
    let middle = 0.5 * (places[crossed] + places[crossed + 1]);
    let is_inside = surface.value(arc.curve.at(middle)) <= 0.0;
    is_inside == (crossed % 2 == 0)
}

impl ArcTracer {
    /// Finds what ends stretches of a curve, in order. False if the curve is
    /// another pair's to trace: it is the first's of all surfaces through it that may
    /// carry faces, and the next one's through it that matters there. Undecided if it runs
    /// along a surface so closely that it cannot be told where it crosses.
    ///
    /// Those on a part of the range are found, beyond which there are no edges.
    pub(super) fn find_events(
        &mut self,
        arc: &Arc<'_>,
        range: [f64; 2],
        part: [f64; 2],
    ) -> Result<bool, Stop> {
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
        let at_start = curve.at(part[0]);
        for (position, id) in block.surfaces() {
            let surface = scene.surface(id);
            let beside = match self.beside.sides[position.index()] {
                Side::Inside => Some(true),
                Side::Outside => Some(false),
                Side::Crossing => arc.side_of_edge(id),
            };
            if let Some(side) = beside {
                self.sectors.inside.push(side);
                continue;
            }
            self.roots.clear();
            let is_own = arc.id.surfaces().any(|own| own == id);
            // (Along the same range whatever part is looked at: whether it is through the curve is told
            // alike then.)
            let is_through = is_own || arc.meet(id, [range, part], &mut self.roots) == Meets::Curve;
            if is_through {
                // Of both of its own, or of the first, if it comes between them.
                let own = if id < first { 2 } else { 1 };
                let is_beside = |own| arc.faces.are_beside(id, own);
                let is_earlier = id < first || second.is_none_or(|second| id < second);
                if in_order && !is_own && is_earlier && arc.id.surfaces().take(own).any(is_beside) {
                    return Ok(false);
                }
                self.through.push(position);
            }
            if self.roots.is_lost {
                return Err(Stop::undecided(Why::Crossing, block.center()));
            }
            let before = self.events.len();
            self.add_crossings(arc, position, range[1] - range[0]);
            let value = surface.value(at_start);
            // Given edges end where others begin, in planes that other solids may have, too.
            let is_on = arc.edge.is_some()
                && value.abs() <= scene.near * surface.gradient(at_start).length();
            self.sectors.inside.push(if is_on && !is_through {
                starts_inside(arc, surface, range, &self.events[before..])
            } else {
                value <= 0.0
            });
        }
        if !self.is_own(arc) {
            return Ok(false);
        }
        let bounds = curve.bounds(part);
        for (side, span) in block.sides() {
            let axis = side.linear.max_position();
            let at = side.anchor[axis];
            if bounds.min[axis] <= at + scene.near && bounds.max[axis] >= at - scene.near {
                self.cut(arc, (&side, Cutting::Side(span)), part);
            }
        }
        for k in 0..self.through.len() {
            let owner = block.id(self.through[k]);
            let frame = scene.frame(owner);
            for plane in frame.into_iter().flat_map(Frame::planes) {
                self.cut(arc, (plane, Cutting::Seam(owner)), part);
            }
        }
        self.add_nodes(arc, part);
        self.gather(arc);
        self.events.sort_by(|a, b| a.at.total_cmp(&b.at));
        self.sectors.crossings.clear();
        let crossings = self.events.iter().map(|event| (event.at, event.crossed()));
        self.sectors.crossings.extend(crossings);
        Ok(true)
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
        let are_beside = |a, b| arc.faces.are_beside(a, b);
        let first = arc.scene.first_of_through(&through, are_beside);
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
            let here = arc.curve.at(at);
            if let Some(contact) = arc.contact_at(here, id) {
                let is_nearer =
                    |&at: &f64| arc.curve.at(at).distance(contact) <= here.distance(contact);
                let place = arc.curve.place(contact).filter(is_nearer);
                return Event {
                    point: Some(contact),
                    ..event(place.unwrap_or(at), true)
                };
            }
            let slanting = arc.slanting_crossing(here, id);
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
            let contacts = arc.id.pair().map(|[a, b]| scene.contacts([a, b, id]));
            let contact = contacts.as_ref().and_then(|contacts| {
                let surfaces = [one, other, triple.third];
                let here = triple.around(cluster, at);
                let is_here = |found: &&Touching| found.ball.is_same(scene, &surfaces, &here);
                contacts.iter().find(is_here)
            });
            if contact.is_none() && !cluster.is_contact {
                let roots = cluster.roots.iter();
                self.events.extend(roots.map(|&at| crossing(at)));
                continue;
            }
            let point = match contact {
                Some(contact) => Some(contact.ball.center),
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
    /// they may as well be there; and touches of which this curve alone tells, if the surface
    /// that is touched is there.
    fn gather(&mut self, arc: &Arc<'_>) {
        let Arc { scene, curve, .. } = *arc;
        let off = |third: &Surface, here: DVec3| {
            let off = known_to(arc.surfaces, third, here);
            scene.rounding.max(off)
        };
        // How far from where it was found an event may as well be.
        let blur = |event: &Event| match event.ends {
            Ends::Surface(position) if event.touched.is_none() => {
                let third = scene.surface(arc.block.id(position));
                let here = curve.at(event.at);
                let normal = third.gradient(here).normalize_or_zero();
                let along = curve.direction(event.at).normalize_or_zero();
                crossing_blur(off(third, here), normal.dot(along))
            }
            Ends::Node => 0.0,
            _ => f64::INFINITY,
        };
        let blurs: SmallVec<[f64; 16]> = self.events.iter().map(blur).collect();
        let touched = |event: &Event| match event.ends {
            Ends::Touch if event.point.is_none() => event.touched,
            _ => None,
        };
        for k in 0..blurs.len() {
            let Event { at: from, .. } = self.events[k];
            let touched = touched(&self.events[k]);
            let is_blurred = blurs[k].is_finite() && blurs[k] > scene.weld;
            if !is_blurred && touched.is_none() {
                continue;
            }
            let here = curve.at(from);
            let reach = blurs[k].min(scene.touching_reach());
            // Also on the way there: a curve may pass through a point twice.
            let is_near = |at: f64| {
                let between = [0.5 * (from + at), at].map(|at| curve.at(at).distance(here));
                between[0].max(between[1]) <= reach
            };
            let is_touched = |at: f64| {
                touched.is_none_or(|position| {
                    let third = scene.surface(arc.block.id(position));
                    arc.with(third).distance(at).abs() <= off(third, curve.at(at))
                })
            };
            let sharper = (0..blurs.len()).filter(|&other| {
                let at = self.events[other].at;
                blurs[other] < 0.5 * reach && is_near(at) && is_touched(at)
            });
            if let Some(best) = sharper.min_by(|&a, &b| blurs[a].total_cmp(&blurs[b])) {
                let Event { at, point, .. } = self.events[best];
                let known =
                    point.unwrap_or_else(|| self.point_of(arc, &self.events[best], curve.at(at)));
                self.events[k].at = at;
                self.events[k].point = Some(known);
            }
        }
    }

    /// Whether a curve is an earlier surface's to trace than the arc's first one: it lies in that,
    /// which may carry faces, and in another one that is beside that. They need not matter on the
    /// first.
    pub(super) fn is_of_earlier(&mut self, arc: &Arc<'_>, range: [f64; 2]) -> bool {
        let scene = arc.scene;
        let start = arc.curve.at(range[0]);
        // Surfaces farther off are not through it for sure.
        let clearly = 1e3 * scene.near;
        let known = std::mem::take(&mut self.through);
        let mut is_through = |id: SurfaceId| {
            if let Some(position) = arc.block.position_of(id) {
                return known.contains(&position);
            }
            let surface = scene.surface(id);
            let slope = surface.gradient(start).length();
            if surface.value(start).abs() > clearly * (slope + clearly) {
                return false;
            }
            arc.meet(id, [range; 2], &mut self.roots) == Meets::Curve
        };
        let earlier = arc.faces.carriers().iter().copied();
        let mut earlier = earlier.take_while(|&id| id < arc.id.first);
        let is_of_edges = |one, other| scene.only_edges([one, other]).is_some();
        let found = earlier.any(|one| {
            is_through(one) && {
                let mut beside = arc.faces.beside(one);
                beside.any(|other| !is_of_edges(one, other) && is_through(other))
            }
        });
        self.through = known;
        found
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
}
