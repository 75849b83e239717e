//! Shells, faces, loops, edges and vertices.

use csg::LengthUnit;
use csg::brep::{Coedge, Edge, Face, Shell};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::chart::{Chart, Written};
use super::curves::{Course, Stray};
use super::telling::{self, Telling};
use super::text::{Entities, Flag, Id, List, Quoted};
use super::{cap, image, spheroid, surfaces, zone};
use crate::Error;

/// What was written of a boundary so far.
#[derive(Debug, Default)]
pub(super) struct Topology {
    /// By the number of the edge or face; the parts of an edge in its order.
    edges: FxHashMap<usize, Vec<Id>>,
    pub faces: FxHashMap<usize, Id>,
    /// Of the shell that is being written the surfaces of faces on which edges have images.
    charts: FxHashMap<usize, (Id, Chart)>,
    /// Of the shell that is being written those at each place: where it touches itself there are
    /// several in one.
    vertices: FxHashMap<[u64; 3], Id>,
    /// Of that shell the edge that is written first, if another program is to find a point of it.
    telling: Option<Telling>,
    /// The face that it is written first of.
    first_face: Option<Id>,
    /// A millimetre in the model's unit.
    millimetre: f64,
}

/// Faces that are one in the file.
struct Part<'a> {
    faces: Vec<Face<'a>>,
    surface: Id,
    is_outward: bool,
    loops: Vec<Vec<Coedge<'a>>>,
}

impl Topology {
    pub fn new(unit: LengthUnit) -> Self {
        Self {
            millimetre: LengthUnit::Millimetre.in_metres() / unit.in_metres(),
            ..Self::default()
        }
    }

    /// The body within an outer shell and those of its voids.
    pub fn body(
        &mut self,
        to: &mut Entities,
        (name, shells): (&str, &[Shell<'_>]),
        stray: Stray,
    ) -> Result<Id, Error> {
        let mut written = Vec::new();
        for (index, shell) in shells.iter().enumerate() {
            let mut faces = Vec::new();
            if let Some(id) = spheroid::write(to, shell) {
                let all = shell.faces().map(|face| (face.id().index(), id));
                self.faces.extend(all);
                let id = to.add(format_args!("CLOSED_SHELL('',({id}))"));
                written.push(id);
                continue;
            }
            self.vertices.clear();
            self.charts.clear();
            let is_void = index > 0;
            self.telling = is_void.then(|| telling::edge(shell, &shells[0])).flatten();
            self.first_face = None;
            for part in self.parts(to, shell)? {
                let id = self.face(to, &part, stray)?;
                let all = part.faces.iter().map(|face| (face.id().index(), id));
                self.faces.extend(all);
                faces.push(id);
            }
            if let Some(first) = self.first_face {
                // (Stable: the others stay in their order.)
                faces.sort_by_key(|&face| face != first);
            }
            written.push(to.add(format_args!("CLOSED_SHELL('',{})", List(&faces))));
        }
        let (name, outer) = (Quoted(name), written[0]);
        if written.len() == 1 {
            return Ok(to.add(format_args!("MANIFOLD_SOLID_BREP({name},{outer})")));
        }
        let voids: Vec<Id> = written[1..]
            .iter()
            .map(|shell| to.add(format_args!("ORIENTED_CLOSED_SHELL('',*,{shell},.T.)")))
            .collect();
        let voids = List(&voids);
        Ok(to.add(format_args!("BREP_WITH_VOIDS({name},{outer},{voids})")))
    }

    /// The faces of a shell as they are in the file, and their surfaces: those on both sides of
    /// an edge are known before it is written.
    fn parts<'a>(&mut self, to: &mut Entities, shell: &Shell<'a>) -> Result<Vec<Part<'a>>, Error> {
        let mut parts = Vec::new();
        for cap in cap::caps(shell, self.millimetre) {
            let surface = surfaces::write_cap(to, &cap.faces, cap.meridian);
            parts.push(self.part(cap.faces, surface, cap.loops)?);
        }
        for zone in zone::zones(shell, self.millimetre) {
            let surface = surfaces::write_zone(to, &zone.faces[0], zone.axis);
            parts.push(self.part(zone.faces, surface, zone.loops)?);
        }
        let known = parts.iter().flat_map(|part| &part.faces);
        let known: FxHashSet<usize> = known.map(|face| face.id().index()).collect();
        for face in shell.faces() {
            if !known.contains(&face.id().index()) {
                let surface = surfaces::write(to, &face);
                let loops = face.loops().map(|around| around.coedges().collect());
                parts.push(self.part(vec![face], surface, loops.collect())?);
            }
        }
        Ok(parts)
    }

    /// Faces that are one, on a surface if there is a way to write it, within loops.
    fn part<'a>(
        &mut self,
        faces: Vec<Face<'a>>,
        surface: Option<Written>,
        loops: Vec<Vec<Coedge<'a>>>,
    ) -> Result<Part<'a>, Error> {
        let face = faces[0];
        let Written {
            surface,
            is_outward,
            chart,
        } = surface.ok_or_else(|| Error::NotInStep {
            problem: format!(
                "no way to write the surface {} is known; it comes from {}",
                face.surface(),
                face.origin().kind
            ),
        })?;
        if let Some(chart) = chart {
            self.charts.insert(face.id().index(), (surface, chart));
        }
        Ok(Part {
            faces,
            surface,
            is_outward,
            loops,
        })
    }

    /// A face on a surface, within loops.
    fn face(&mut self, to: &mut Entities, part: &Part<'_>, stray: Stray) -> Result<Id, Error> {
        let (face, loops) = (&part.faces[0], &part.loops);
        let tells = |side: &Coedge<'_>| {
            let edge = side.edge().id().index();
            self.telling.is_some_and(|telling| telling.edge == edge)
        };
        let start = loops.first().and_then(|outer| outer.iter().position(tells));
        let is_first = start.is_some() && self.first_face.is_none();
        let start = start.filter(|_| is_first).unwrap_or(0);
        let mut bounds = Vec::new();
        for (index, around) in loops.iter().enumerate() {
            let mut sides = Vec::new();
            let (after, before) = around.split_at(if index == 0 { start } else { 0 });
            for coedge in before.iter().chain(after) {
                let mut parts = self.edge(to, coedge, stray)?;
                if !coedge.is_forward() {
                    parts.reverse();
                }
                let along = Flag(coedge.is_forward());
                let oriented = |part| to.add(format_args!("ORIENTED_EDGE('',*,*,{part},{along})"));
                sides.extend(parts.into_iter().map(oriented));
            }
            let around = to.add(format_args!("EDGE_LOOP('',{})", List(&sides)));
            let kind = if index == 0 {
                "FACE_OUTER_BOUND"
            } else {
                "FACE_BOUND"
            };
            bounds.push(to.add(format_args!("{kind}('',{around},.T.)")));
        }
        let name = Quoted(face.origin().name.as_deref().unwrap_or_default()).to_string();
        let (bounds, surface, same) = (List(&bounds), part.surface, Flag(part.is_outward));
        let id = to.add(format_args!(
            "ADVANCED_FACE({name},{bounds},{surface},{same})"
        ));
        if is_first {
            self.first_face = Some(id);
        }
        Ok(id)
    }

    fn edge(
        &mut self,
        to: &mut Entities,
        side: &Coedge<'_>,
        stray: Stray,
    ) -> Result<Vec<Id>, Error> {
        let edge = side.edge();
        if let Some(parts) = self.edges.get(&edge.id().index()) {
            return Ok(parts.clone());
        }
        let [from, until] = edge.range();
        let middle = edge.at(0.5 * (from + until));
        let course = Course::of(&edge, stray).ok_or_else(|| Error::NotInStep {
            problem: format!(
                "no B-spline within {} of the edge around {middle} was found: allow a larger \
                 tolerance, or move what nearly touches there",
                stray.most
            ),
        })?;
        let [from, until] = match edge.vertices() {
            Some(ends) => ends.map(|end| self.vertex(to, end.point())),
            None => {
                let point = to.point(edge.at(from));
                [to.add(format_args!("VERTEX_POINT('',{point})")); 2]
            }
        };
        let mut ends: Vec<Id> = vec![from, until];
        let index = edge.id().index();
        // (Of a part of the edge others may begin to count elsewhere.)
        let is_parted = self.telling.is_some_and(|t| t.edge == index && t.is_parted);
        let curve = if is_parted {
            course.write(to)
        } else {
            image::write(to, &course, &self.charts(&edge), stray.usual)
        };
        if is_parted {
            ends.insert(1, self.vertex(to, middle));
        }
        let part = |ends: &[Id]| {
            let [from, until] = [ends[0], ends[1]];
            to.add(format_args!("EDGE_CURVE('',{from},{until},{curve},.T.)"))
        };
        let parts: Vec<Id> = ends.windows(2).map(part).collect();
        self.edges.insert(edge.id().index(), parts.clone());
        Ok(parts)
    }

    /// The surfaces on both sides of an edge that images are written on: none that are one, on which
    /// others could not tell them apart.
    fn charts(&self, edge: &Edge<'_>) -> Vec<(Id, &Chart)> {
        let charts = edge.faces().map(|face| self.charts.get(&face.id().index()));
        if let [Some((one, _)), Some((other, _))] = charts
            && one == other
        {
            return Vec::new();
        }
        let known = charts.into_iter().flatten();
        known.map(|(surface, chart)| (*surface, chart)).collect()
    }

    fn vertex(&mut self, to: &mut Entities, at: DVec3) -> Id {
        // (Zeros differ in their signs.)
        let place = at.to_array().map(|x| (x + 0.0).to_bits());
        *self.vertices.entry(place).or_insert_with(|| {
            let point = to.point(at);
            to.add(format_args!("VERTEX_POINT('',{point})"))
        })
    }
}
