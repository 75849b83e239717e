//! The contours of faces of polyhedra that nothing comes near, beside those of the rest.
//!
//! These faces are as they were given: vertices and edges are those of the polyhedron, not found again
//! from planes, which neighbours of a fine polyhedron hardly differ in.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::slits;
use crate::arrangement::{
    self, Arrangement, Curve, CurveId, FaceId, HalfEdge, HalfEdgeId, Other, Side, VertexId,
};
use crate::numeric::Welder;
use crate::program::{Origin, Surface, SurfaceId, Uncut};

/// Uncut faces, and on which surfaces they and the rest are.
pub(super) struct Joining<'a> {
    pub uncut: &'a Uncut,
    /// Of the whole solid, and behind them those of the rest, about one point.
    pub surfaces: &'a [Surface],
    pub origins: &'a [Origin],
    /// That point.
    pub origin: DVec3,
}

impl Joining<'_> {
    /// What is meant of the rest, and the uncut faces; none if they do not fit.
    pub fn with(&self, rest: Arrangement) -> Option<Arrangement> {
        let mut joined = Joined {
            whole: Arrangement {
                frames: vec![None; self.surfaces.len()],
                rounding: rest.rounding.max(self.off()),
                ..Arrangement::default()
            },
            ..Joined::default()
        };
        let open = self.add_rest(&mut joined, rest);
        self.add_uncut(&mut joined, &open)?;
        let mut whole = joined.whole;
        slits::number_vertices(&mut whole);
        whole.fit_places();
        Some(whole)
    }

    /// The largest distance of a vertex of an uncut face from its plane.
    fn off(&self) -> f64 {
        let faces = self.uncut.triangles.iter().zip(&self.uncut.faces);
        let off = faces.flat_map(|(corners, &(surface, _))| {
            corners.map(|vertex| {
                self.surfaces[surface as usize]
                    .value(self.point(vertex))
                    .abs()
            })
        });
        off.fold(0.0, f64::max)
    }

    fn point(&self, vertex: u32) -> DVec3 {
        self.uncut.vertices[vertex as usize] - self.origin
    }

    /// Adds the half-edges of the rest whose faces are meant, and returns those among them without a
    /// twin: the others' faces are in their place.
    fn add_rest(&self, to: &mut Joined, rest: Arrangement) -> Vec<HalfEdgeId> {
        // The rest's surfaces are the last ones.
        let first = self.surfaces.len() - self.uncut.meant.len();
        let surface = |id: SurfaceId| {
            let meant = self.uncut.meant[id.index()];
            SurfaceId(meant.unwrap_or(id.0 + first as u32))
        };
        let is_meant = |half: HalfEdgeId| self.uncut.meant[rest.side(half).plane.index()].is_some();
        let mut kept = 0;
        let numbers = rest.halves().map(|half| {
            let number = HalfEdgeId(kept);
            kept += u32::from(is_meant(half));
            number
        });
        let numbers: Vec<HalfEdgeId> = numbers.collect();
        for (id, frame) in rest.frames.iter().enumerate() {
            to.whole.frames[surface(SurfaceId(id as u32)).index()] = frame.clone();
        }
        let curve = |id: &CurveId| CurveId {
            first: surface(id.first),
            other: match id.other {
                Other::Surface(second) => Other::Surface(surface(second)),
                seam @ Other::Seam(_) => seam,
            },
            branch: id.branch,
        };
        to.whole.curves = rest
            .curves
            .iter()
            .map(|(id, known)| (curve(id), known.clone()))
            .collect();
        let mut open = Vec::new();
        for half in rest.halves().filter(|&half| is_meant(half)) {
            let half_edge = rest.at(half);
            let side = rest.side(half);
            let side = Side {
                plane: surface(side.plane),
                ..*side
            };
            if !is_meant(half_edge.twin) {
                open.push(numbers[half.index()]);
                to.ends.push(rest.at(half_edge.twin).from);
            }
            let face = to.face(side);
            to.whole.half_edges.push(HalfEdge {
                twin: numbers[half_edge.twin.index()],
                next: numbers[half_edge.next.index()],
                face,
                curve: curve(&half_edge.curve),
                ..*half_edge
            });
        }
        to.whole.points = rest.points;
        open
    }

    /// Adds the uncut faces, up to the open ends of the rest; none if these do not fit.
    fn add_uncut(&self, to: &mut Joined, open: &[HalfEdgeId]) -> Option<()> {
        let first = VertexId(to.whole.points.len() as u32);
        let number = |vertex: u32| VertexId(first.0 + vertex);
        let vertices = 0..self.uncut.vertices.len() as u32;
        to.whole
            .points
            .extend(vertices.map(|vertex| self.point(vertex)));
        let sides = self.sides();
        let along: FxHashMap<[u32; 2], usize> = self.along()?;
        let twin = |side: usize| {
            let [from, to] = self.ends(side);
            along.get(&[to, from]).copied()
        };
        let is_edge =
            |side: usize| twin(side).is_none_or(|twin| sides[twin / 3] != sides[side / 3]);
        // The half-edges by sides of triangles.
        let mut half_of = vec![HalfEdgeId(u32::MAX); 3 * sides.len()];
        let mut edges = Vec::new();
        for side in (0..half_of.len()).filter(|&side| is_edge(side)) {
            half_of[side] = HalfEdgeId((to.whole.half_edges.len() + edges.len()) as u32);
            edges.push(side);
        }
        let mut rims = Rims::new(&to.whole, open, &to.ends, self.uncut.margin)?;
        for &side in &edges {
            let half = half_of[side];
            let [from, until] = self.ends(side);
            let rim = self.uncut.rims[side / 3][side % 3];
            let beyond = match twin(side).filter(|_| !rim) {
                Some(twin) => half_of[twin],
                None => {
                    let known = rims.remove([until, from].map(|vertex| self.point(vertex)))?;
                    let twin = &mut to.whole.half_edges[known.index()];
                    twin.twin = half;
                    to.whole.points[twin.from.index()] = self.point(until);
                    known
                }
            };
            let mut next = side;
            loop {
                next = next - next % 3 + (next + 1) % 3;
                if is_edge(next) {
                    break;
                }
                next = twin(next)?;
            }
            let face = to.face(sides[side / 3]);
            to.whole.half_edges.push(HalfEdge {
                from: number(from),
                twin: beyond,
                next: half_of[next],
                face,
                curve: CurveId::first_of([sides[side / 3].plane; 2]),
                is_line: true,
                places: [0.0; 2],
            });
        }
        if !rims.open.is_empty() {
            return None;
        }
        for &side in &edges {
            let half = half_of[side];
            to.put_on_line(half, self.ends(side).map(|vertex| self.point(vertex)))?;
        }
        Some(())
    }

    /// Of each triangle the face's side.
    fn sides(&self) -> Vec<Side> {
        let looks = arrangement::looks(self.origins);
        let faces = self.uncut.triangles.iter().zip(&self.uncut.faces);
        faces
            .map(|(corners, &(surface, primitive))| {
                let [a, b, c] = corners.map(|vertex| self.point(vertex));
                let normal = (b - a).cross(c - a);
                let plane = SurfaceId(surface);
                Side {
                    plane,
                    look: looks[primitive as usize],
                    along_normal: normal.dot(self.surfaces[plane.index()].linear) > 0.0,
                    patch: 0,
                }
            })
            .collect()
    }

    /// The side of a triangle, `3 * triangle + corner`, from each vertex to another one; none if two
    /// lead along one way.
    fn along(&self) -> Option<FxHashMap<[u32; 2], usize>> {
        let mut along = FxHashMap::default();
        for side in 0..3 * self.uncut.triangles.len() {
            if along.insert(self.ends(side), side).is_some() {
                return None;
            }
        }
        Some(along)
    }

    /// The vertices from and to which a side leads.
    fn ends(&self, side: usize) -> [u32; 2] {
        let corners = self.uncut.triangles[side / 3];
        [corners[side % 3], corners[(side + 1) % 3]]
    }
}

/// What is put together.
#[derive(Default)]
struct Joined {
    whole: Arrangement,
    face_of: FxHashMap<Side, FaceId>,
    /// How many lines there are of each two surfaces.
    lines: FxHashMap<[SurfaceId; 2], u16>,
    /// Where open half-edges of the rest end.
    ends: Vec<VertexId>,
}

impl Joined {
    fn face(&mut self, side: Side) -> FaceId {
        *self.face_of.entry(side).or_insert_with(|| {
            self.whole.faces.push(side);
            FaceId(self.whole.faces.len() as u32 - 1)
        })
    }

    /// Puts an edge on the line through its ends: one that is there, of the same surfaces, or a new one.
    fn put_on_line(&mut self, half: HalfEdgeId, [from, to]: [DVec3; 2]) -> Option<()> {
        /// Of those that are there so many are tried. Tunes speed only.
        const FEW: usize = 8;
        let twin = self.whole.at(half).twin;
        let mut planes = [half, twin].map(|half| self.whole.side(half).plane);
        planes.sort_unstable();
        let rounding = self.whole.rounding;
        let count = self.lines.entry(planes).or_default();
        let id = |branch: u16| CurveId {
            branch,
            ..CurveId::first_of(planes)
        };
        let is_on = |&branch: &u16| {
            self.whole.curves.get(&id(branch)).is_some_and(|line| {
                let off = |point: DVec3| line.place(point).map(|at| line.at(at).distance(point));
                [from, to]
                    .iter()
                    .all(|&end| off(end).is_some_and(|off| off <= rounding))
            })
        };
        let branch = match (0..*count).rev().take(FEW).find(is_on) {
            Some(branch) => branch,
            None => {
                let direction = (to - from).try_normalize()?;
                let branch = *count;
                *count = count.checked_add(1)?;
                let line = Curve::Line {
                    point: from,
                    direction,
                };
                self.whole.curves.insert(id(branch), line);
                branch
            }
        };
        for half in [half, twin] {
            self.whole.half_edges[half.index()].curve = id(branch);
        }
        Some(())
    }
}

/// The open half-edges of the rest, by their ends.
struct Rims {
    welder: Welder,
    open: FxHashMap<[u32; 2], HalfEdgeId>,
}

impl Rims {
    /// None if several are between the same ends.
    fn new(
        whole: &Arrangement,
        open: &[HalfEdgeId],
        ends: &[VertexId],
        margin: f64,
    ) -> Option<Self> {
        let mut welder = Welder::new(margin);
        let mut by_ends = FxHashMap::default();
        for (&half, &end) in open.iter().zip(ends) {
            let ends = [whole.at(half).from, end];
            let ends = ends.map(|end| welder.number(whole.points[end.index()]));
            if by_ends.insert(ends, half).is_some() {
                return None;
            }
        }
        Some(Self {
            welder,
            open: by_ends,
        })
    }

    /// The one from a point to another.
    fn remove(&mut self, ends: [DVec3; 2]) -> Option<HalfEdgeId> {
        let ends = ends.map(|end| self.welder.number(end));
        self.open.remove(&ends)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glam::DVec2;

    use crate::random::Random;
    use crate::sweeps::one_in;
    use crate::{BoundaryOptions, Profile, Program, Solid, Twist};

    /// Shells, their handles, bodies, faces and edges.
    fn counts(brep: &crate::Brep) -> [usize; 5] {
        let handles = brep.shells().map(|shell| shell.genus()).sum();
        let (shells, bodies) = (brep.shells().len(), brep.bodies().len());
        [
            shells,
            handles,
            bodies,
            brep.faces().len(),
            brep.edges().len(),
        ]
    }

    /// Twisted bars with bores, balls on them and bars through them have the boundary that half-spaces
    /// alone give.
    #[test]
    fn uncut_faces_and_the_rest_are_one_boundary() {
        let mut random = Random(7);
        let mut joined = 0;
        for case in 0..24 / one_in(2) {
            let mut number = |from: f64, to: f64| from + (to - from) * random.unit();
            let mut bar = |turns: f64| {
                let corners = 3 + (number(0.0, 3.0) as usize);
                let profile = Profile::regular_polygon(corners, number(0.8, 1.2));
                let twist = Twist {
                    radians: turns * TAU,
                    steps: 12,
                    scale: DVec2::splat(number(0.4, 1.5)),
                };
                Solid::extrude_in_steps(&profile, 0.0..3.0, twist)
                    .rotate_x(number(0.0, 1.0))
                    .translate([number(-0.3, 0.3), number(-0.3, 0.3), number(-0.3, 0.3)])
            };
            let (one, other) = (bar(0.05), bar(-0.04));
            let bore = Solid::cylinder(0.3, -9.0..9.0).rotate_x(number(0.0, 1.0));
            let ball = Solid::sphere(number(0.5, 1.0)).translate([0.0, number(0.0, 1.0), 1.5]);
            let solid = match case % 4 {
                0 => one,
                1 => one - bore,
                2 => (one | ball) - bore,
                _ => one - other,
            };
            let program = Program::lower(&solid).expect("valid");
            joined += usize::from(program.apart().is_some());
            let options = BoundaryOptions::new();
            let brep = program.boundary(&options).expect("a boundary");
            let expected = program.expanded().boundary(&options).expect("a boundary");
            assert_eq!(counts(&brep), counts(&expected), "{case}");
            let [one, other] = [&brep, &expected].map(crate::Brep::measure);
            let off = (one.volume.value - other.volume.value).abs();
            assert!(
                off <= one.volume.error + other.volume.error,
                "{case}: {off}"
            );
            let off = (one.area.value - other.area.value).abs();
            assert!(off <= one.area.error + other.area.error, "{case}: {off}");
        }
        assert!(joined * 2 > 24 / one_in(2), "{joined}");
    }
}
