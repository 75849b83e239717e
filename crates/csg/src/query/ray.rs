//! Where a ray goes through a solid's boundary: the roots of its surfaces along it, and the
//! formula between them.
//!
//! Of a surface that a ray does not cross the side is known all along it, and most of the formula
//! with that. Roots that rounding may exchange, as at an edge, are one event: there is a hit
//! if the solid is not the same before and after all of them.

use glam::DVec3;
use smallvec::SmallVec;

use crate::error::Error;
use crate::mesh::MeshSurface;
use crate::numeric::tolerance::VALUE;
use crate::program::{Cell, Formula, Narrower, Program, Side, Surface, SurfaceId, line_roots};
use crate::task::mesh_surface;

/// Where a ray goes through the boundary of a solid ([`Program::ray`]).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RayHit {
    /// The hit is at origin + `t` direction; at least 0.
    pub t: f64,
    /// About how far `t` may be off by rounding.
    pub error: f64,
    /// Where it is, in model units.
    pub point: DVec3,
    /// The boundary's normal there, of unit length, out of the solid. At an edge it is that of one
    /// of its faces; at a cone's apex it is along the ray.
    pub normal: DVec3,
    /// Whether the ray goes into the solid, or out of it.
    pub enters: bool,
    /// The face that is hit: its surface, and the primitive's number, name and colour. Where
    /// faces of several primitives coincide it is the one that a mesh's triangles name.
    pub face: MeshSurface,
}

impl Program {
    /// Where a ray goes through the solid's boundary, in the order along it, entering and leaving in
    /// turn; no hit where it only touches. Exact but for rounding, which [`RayHit::error`] tells: some
    /// 1e-14 of the coordinates over the sine of the angle between ray and face, and its square root
    /// where that is 0. What is thinner than that is not seen. A ray that starts on the boundary
    /// hits it at 0; one that runs within a face may be taken for inside or outside.
    ///
    /// The direction may have any length, which `t` is in units of. The solid may have no end. One pass
    /// over the formula and the surfaces that are not told apart by it, and one over what the ray
    /// crosses for each crossing; large polyhedra are put on half-spaces by the first ray.
    ///
    /// ```
    /// use csg::{Program, Solid};
    ///
    /// let part = Solid::cube(4.0).named("block") - Solid::sphere(1.0).named("hollow");
    /// let hits = Program::lower(&part)?.ray([-5.0, 0.0, 0.0], [1.0, 0.0, 0.0])?;
    /// let places: Vec<f64> = hits.iter().map(|hit| hit.point.x).collect();
    /// assert_eq!(places, [-2.0, -1.0, 1.0, 2.0]);
    /// assert_eq!(hits[1].face.name.as_deref(), Some("hollow"));
    /// assert!(!hits[1].enters && hits[1].normal.x == 1.0);
    /// # Ok::<(), csg::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for an origin or direction that is not finite, a direction without
    /// length, coordinates beyond what can be computed with.
    pub fn ray(
        &self,
        origin: impl Into<DVec3>,
        direction: impl Into<DVec3>,
    ) -> Result<Vec<RayHit>, Error> {
        let (origin, given) = (origin.into(), direction.into());
        let longest = given.abs().max_element();
        if !origin.is_finite() || !given.is_finite() || longest == 0.0 {
            return Err(Error::InvalidOption(format!(
                "a ray from {origin} along {given}: give finite numbers, and a direction that is not zero"
            )));
        }
        let scaled = given / longest;
        let length = longest * scaled.length();
        let ray = Line {
            origin,
            along: scaled.normalize(),
        };
        let surfaces = self.surfaces();
        let mut cell = Cell::default();
        let side = |surface: u32| ray.meet(&surfaces[surface as usize]).side();
        Narrower::default().prune(self.formula(), side, &mut cell);
        let mut walk = Walk::new(self, &ray, &cell);
        let hits = walk.hits()?;
        Ok(hits
            .into_iter()
            .map(|hit| hit.in_units_of(length))
            .collect())
    }
}

impl RayHit {
    fn in_units_of(self, length: f64) -> Self {
        Self {
            t: self.t / length,
            error: self.error / length,
            ..self
        }
    }
}

/// A ray by its origin and a unit vector.
struct Line {
    origin: DVec3,
    along: DVec3,
}

/// How a ray and a surface meet.
struct Meeting {
    /// Whether the ray starts, before all roots, where f <= 0.
    is_inside: bool,
    /// Where f changes its sign from there on, and how far that may be off.
    roots: SmallVec<[[f64; 2]; 2]>,
}

impl Meeting {
    fn side(&self) -> Side {
        match (self.roots.is_empty(), self.is_inside) {
            (false, _) => Side::Crossing,
            (true, true) => Side::Inside,
            (true, false) => Side::Outside,
        }
    }
}

impl Line {
    fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.along
    }

    /// f along the line is a t² + b t + c about the point nearest to the anchor, where no digits
    /// are lost.
    fn meet(&self, surface: &Surface) -> Meeting {
        let about = (surface.anchor() - self.origin).dot(self.along);
        let at = self.at(about);
        let gradient = surface.gradient(at);
        let [mut a, mut b] = [
            0.5 * surface.curvature_along(self.along),
            gradient.dot(self.along),
        ];
        let c = surface.value(at);
        // Of quadratic terms of at most 1, and the terms that make up the slope: what is less is
        // rounding, and the line parallel to the surface.
        if a.abs() <= VALUE {
            a = 0.0;
            let terms = 6.0 * (at - surface.anchor()).length() + surface.linear.length();
            if b.abs() <= VALUE * terms {
                b = 0.0;
            }
        }
        let far = if a == 0.0 { -b } else { a };
        let mut meeting = Meeting {
            is_inside: far < 0.0 || (far == 0.0 && c <= surface.rounding_of_value(at)),
            roots: SmallVec::new(),
        };
        for root in line_roots(a, b, c).into_iter().flatten() {
            let t = about + root;
            if root.is_infinite() {
                continue;
            }
            let point = self.at(t);
            // Four times the usual rounding is a bound of it, by which [`VALUE`] is derived.
            let off = 4.0 * surface.rounding_of_value(point);
            let slope = (2.0 * a * root + b).abs();
            let blur = (2.0 * off / slope).min((off / a.abs()).sqrt());
            let coordinates = self.origin.abs().max(point.abs()).max_element() + t.abs();
            let error = blur + 2.0 * f64::EPSILON * coordinates;
            if t + error < 0.0 {
                meeting.is_inside = !meeting.is_inside;
            } else {
                meeting.roots.push([t, error]);
            }
        }
        meeting
    }
}

/// A sign that changes.
struct Event {
    at: f64,
    error: f64,
    /// Of which surface of the cell.
    position: usize,
}

/// A walk along a ray, from event to event.
struct Walk<'a> {
    program: &'a Program,
    ray: &'a Line,
    cell: &'a Cell,
    /// Of each surface of the cell whether f <= 0.
    inside: Vec<bool>,
    events: Vec<Event>,
    gates: Vec<bool>,
}

impl<'a> Walk<'a> {
    fn new(program: &'a Program, ray: &'a Line, cell: &'a Cell) -> Self {
        let mut events = Vec::new();
        let mut inside = Vec::with_capacity(cell.surfaces.len());
        for (position, &surface) in cell.surfaces.iter().enumerate() {
            let meeting = ray.meet(&program.surfaces()[surface as usize]);
            inside.push(meeting.is_inside);
            events.extend(meeting.roots.iter().map(|&[at, error]| Event {
                at,
                error,
                position,
            }));
        }
        events.sort_unstable_by(|one, other| {
            one.at
                .total_cmp(&other.at)
                .then(one.position.cmp(&other.position))
        });
        Self {
            program,
            ray,
            cell,
            inside,
            events,
            gates: Vec::new(),
        }
    }

    fn hits(&mut self) -> Result<Vec<RayHit>, Error> {
        let mut hits = Vec::new();
        let mut is_in = self.evaluate();
        let events = std::mem::take(&mut self.events);
        if let Some(wild) = events
            .iter()
            .find(|event| !(event.at + event.error).is_finite())
        {
            return Err(Error::InvalidOption(format!(
                "a ray from {}: surface {} is too far away to be computed with; start nearer to the solid",
                self.ray.origin, self.cell.surfaces[wild.position]
            )));
        }
        let mut rest = events.as_slice();
        while let Some(first) = rest.first() {
            let mut end = first.at + first.error;
            let mut count = 1;
            while let Some(next) = rest.get(count).filter(|next| next.at - next.error <= end) {
                end = end.max(next.at + next.error);
                count += 1;
            }
            let (together, others) = rest.split_at(count);
            rest = others;
            // A surface that changes twice has not changed.
            let mut changed: SmallVec<[&Event; 4]> = SmallVec::new();
            for event in together {
                let same = changed
                    .iter()
                    .position(|other| other.position == event.position);
                match same {
                    Some(place) => drop(changed.remove(place)),
                    None => changed.push(event),
                }
            }
            let before = is_in;
            let mut decisive = None;
            for &event in &changed {
                let was_in = is_in;
                let was = self.inside[event.position];
                self.inside[event.position] = !was;
                is_in = self.evaluate();
                if is_in != was_in {
                    decisive = Some((event, self.literal_of(event.position)));
                }
            }
            if let Some((event, primitive)) = decisive.filter(|_| is_in != before) {
                // Some surfaces only part space, and meet the ray at a polyhedron's edge.
                let carriers = self.program.carriers().len() as u32;
                let is_carrier = |event: &Event| self.cell.surfaces[event.position] < carriers;
                let carrier = changed.iter().copied().find(|&other| is_carrier(other));
                let (event, primitive) = match carrier {
                    Some(carrier) if !is_carrier(event) => {
                        (carrier, self.literal_of(carrier.position))
                    }
                    _ => (event, primitive),
                };
                let off = together
                    .iter()
                    .map(|other| (other.at - event.at).abs() + other.error);
                hits.push(self.hit(event, primitive, off.fold(0.0, f64::max), is_in));
            }
        }
        Ok(hits)
    }

    fn evaluate(&mut self) -> bool {
        self.cell
            .formula
            .evaluate_into(&self.inside, &mut self.gates)
    }

    /// The primitive of the literal on a surface that decides, the others of it being as they are:
    /// from the last on it is that with which the solid changes, as in meshes.
    fn literal_of(&self, position: usize) -> u32 {
        let formula: &Formula = &self.cell.formula;
        let own = || {
            (0u32..)
                .zip(formula.literals())
                .filter(|(_, l)| l.surface as usize == position)
        };
        let mut gates = Vec::new();
        let mut value = |from: u32| {
            let bits = formula.evaluate_words(&mut gates, |literal, surface| {
                let surface = surface as usize;
                // About the inner side of the surface.
                let inside = self.inside[surface] || surface == position;
                u64::from(inside && !(surface == position && literal >= from))
            });
            bits & 1
        };
        let none = value(u32::MAX);
        let mut last_first: SmallVec<[(u32, u32); 4]> = own().map(|(i, l)| (i, l.origin)).collect();
        last_first.reverse();
        let decisive = last_first
            .iter()
            .find(|&&(literal, _)| value(literal) != none);
        decisive
            .or(last_first.first())
            .map_or(0, |&(_, origin)| origin)
    }

    fn hit(&self, event: &Event, primitive: u32, error: f64, enters: bool) -> RayHit {
        let surface = self.cell.surfaces[event.position];
        let t = event.at.max(0.0);
        let point = self.ray.at(t);
        let along = self.ray.along;
        let gradient = self.program.surfaces()[surface as usize].gradient(point);
        let gradient = gradient.try_normalize().unwrap_or(along);
        let normal = if (gradient.dot(along) < 0.0) == enters {
            gradient
        } else {
            -gradient
        };
        RayHit {
            t,
            error,
            point,
            normal,
            enters,
            face: mesh_surface(self.program, SurfaceId(surface), primitive),
        }
    }
}
