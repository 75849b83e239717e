//! Convex hulls of points.
//!
//! Quickhull (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, "The quickhull algorithm
//! for convex hulls", 1996): the furthest point outside a face replaces all
//! faces it sees by a fan. Faces that contain the point within rounding count
//! as seen, so that flat sides are fanned anew and no face degenerates; each point is
//! taken once at most, so that rounding cannot go round in circles. The
//! triangles of a flat side then become one plane.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::primitive::Plane;
use super::tree::Solid;
use crate::error::{NodeFault, ProfileFault};
use crate::numeric::tolerance::{OFF_HULL, ON_FACE, SAME_FACE};

impl Solid {
    /// The least convex polyhedron around points. Time is about n log n for n
    /// points. Lowering rejects points that lie in one plane.
    #[must_use]
    pub fn hull<P: Into<DVec3>>(points: impl IntoIterator<Item = P>) -> Self {
        let points: Vec<DVec3> = points.into_iter().map(Into::into).collect();
        let planes = hull_planes(&points);
        let made = planes.map(|planes| (Self::convex_polyhedron(planes), points));
        Self::made_of_points("hull", made)
    }
}

fn extent(points: &[DVec3]) -> (DVec3, DVec3) {
    let first = points.first().copied().unwrap_or_default();
    points.iter().fold((first, first), |(min, max), &point| {
        (min.min(point), max.max(point))
    })
}

/// The planes of the hull's faces.
pub(super) fn hull_planes(points: &[DVec3]) -> Result<Vec<Plane>, NodeFault> {
    if !points.iter().all(|point| point.is_finite()) {
        return Err(ProfileFault::NotFinite {
            what: "every point",
        }
        .into());
    }
    let (min, max) = extent(points);
    let size = (max - min).max_element();
    let mut hull = Hull::start(points, ON_FACE * size).ok_or(NodeFault::Flat)?;
    hull.grow();
    let planes = hull.planes(SAME_FACE * size);
    let worst = planes
        .iter()
        .flat_map(|plane| points.iter().map(|&p| plane.normal.dot(p) - plane.offset))
        .fold(0.0, f64::max);
    if worst > OFF_HULL * size || planes.len() < 4 {
        return Err(NodeFault::Flat);
    }
    Ok(planes)
}

struct Face {
    corners: [usize; 3],
    normal: DVec3,
    area: f64,
    /// Points seen by no face before this one.
    outside: Vec<usize>,
    alive: bool,
}

struct Hull<'a> {
    points: &'a [DVec3],
    /// Which of them have been a corner: each becomes one once at most, even if rounding
    /// takes it out again, so that the hull ends.
    taken: Vec<bool>,
    faces: Vec<Face>,
    /// The face to the left of each directed edge.
    edges: FxHashMap<(usize, usize), usize>,
    slack: f64,
}

impl<'a> Hull<'a> {
    /// A tetrahedron of points far from each other.
    fn start(points: &'a [DVec3], slack: f64) -> Option<Self> {
        let furthest = |distance: &dyn Fn(DVec3) -> f64| {
            let indices = 0..points.len();
            indices.max_by(|&i, &j| distance(points[i]).total_cmp(&distance(points[j])))
        };
        let first = furthest(&|p| -p.x - 1e-3 * p.y - 1e-6 * p.z)?;
        let base = points[first];
        let second = furthest(&|p| p.distance_squared(base))?;
        let along = (points[second] - base).try_normalize()?;
        let third = furthest(&|p| (p - base).reject_from_normalized(along).length_squared())?;
        let across = along.cross(points[third] - base).try_normalize()?;
        let fourth = furthest(&|p| (p - base).dot(across).abs())?;
        let height = (points[fourth] - base).dot(across);
        let width = (points[third] - base)
            .reject_from_normalized(along)
            .length();
        if height.abs() <= 100.0 * slack || width <= 100.0 * slack {
            return None;
        }
        let corners = if height > 0.0 {
            [first, third, second, fourth]
        } else {
            [first, second, third, fourth]
        };
        let mut hull = Self {
            points,
            taken: vec![false; points.len()],
            faces: Vec::new(),
            edges: FxHashMap::default(),
            slack,
        };
        let [a, b, c, d] = corners;
        for corner in corners {
            hull.taken[corner] = true;
        }
        let mut faces = Vec::new();
        for corners in [[a, b, c], [b, a, d], [c, b, d], [a, c, d]] {
            faces.push(hull.add(corners));
        }
        hull.share(0..points.len(), &faces);
        Some(hull)
    }

    fn add(&mut self, corners: [usize; 3]) -> usize {
        let [a, b, c] = corners.map(|i| self.points[i]);
        let doubled = (b - a).cross(c - a);
        let index = self.faces.len();
        self.faces.push(Face {
            corners,
            normal: doubled.normalize_or_zero(),
            area: doubled.length(),
            outside: Vec::new(),
            alive: true,
        });
        let [a, b, c] = corners;
        for edge in [(a, b), (b, c), (c, a)] {
            self.edges.insert(edge, index);
        }
        index
    }

    /// How far a point is outside a face.
    fn distance(&self, face: usize, point: usize) -> f64 {
        let face = &self.faces[face];
        face.normal
            .dot(self.points[point] - self.points[face.corners[0]])
    }

    /// Gives each point to a face that it is outside of.
    fn share(&mut self, points: impl IntoIterator<Item = usize>, faces: &[usize]) {
        for point in points {
            if self.taken[point] {
                continue;
            }
            let seen = faces
                .iter()
                .find(|&&face| self.distance(face, point) > self.slack);
            if let Some(&face) = seen {
                self.faces[face].outside.push(point);
            }
        }
    }

    fn grow(&mut self) {
        let mut pending: Vec<usize> = (0..self.faces.len()).collect();
        while let Some(face) = pending.pop() {
            if !self.faces[face].alive || self.faces[face].outside.is_empty() {
                continue;
            }
            let outside = self.faces[face].outside.iter();
            let by_distance =
                |&i: &usize, &j: &usize| self.distance(face, i).total_cmp(&self.distance(face, j));
            let Some(furthest) = outside.copied().max_by(by_distance) else {
                continue;
            };
            let first = self.faces.len();
            self.replace(face, furthest);
            pending.extend(first..self.faces.len());
        }
    }

    /// Replaces the faces that a point sees by a fan of faces around it.
    fn replace(&mut self, start: usize, point: usize) {
        let mut seen = vec![start];
        let mut horizon = Vec::new();
        let mut orphans = Vec::new();
        self.faces[start].alive = false;
        self.taken[point] = true;
        let mut next = 0;
        while let Some(&face) = seen.get(next) {
            next += 1;
            orphans.append(&mut self.faces[face].outside);
            let [a, b, c] = self.faces[face].corners;
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let Some(&other) = self.edges.get(&(to, from)) else {
                    continue;
                };
                if !self.faces[other].alive {
                    continue;
                }
                let holds = self.faces[other].corners.contains(&point);
                if !holds && self.distance(other, point) > -self.slack {
                    self.faces[other].alive = false;
                    seen.push(other);
                } else {
                    horizon.push((from, to, other));
                }
            }
        }
        let faces: Vec<usize> = horizon
            .into_iter()
            // Neighbours that were seen later leave no edge.
            .filter(|&(.., other)| self.faces[other].alive)
            .map(|(from, to, _)| (from, to))
            .collect::<Vec<_>>()
            .into_iter()
            .map(|(from, to)| self.add([from, to, point]))
            .collect();
        self.share(orphans, &faces);
    }

    /// One plane for all triangles of a flat side, from the largest of them.
    fn planes(&self, flat: f64) -> Vec<Plane> {
        let mut order: Vec<usize> = (0..self.faces.len())
            .filter(|&face| self.faces[face].alive)
            .collect();
        order.sort_by(|&a, &b| {
            self.faces[b]
                .area
                .total_cmp(&self.faces[a].area)
                .then(a.cmp(&b))
        });
        let mut taken = vec![false; self.faces.len()];
        let mut planes = Vec::new();
        for face in order {
            if std::mem::replace(&mut taken[face], true) {
                continue;
            }
            let plane = Plane::through(
                self.points[self.faces[face].corners[0]],
                self.faces[face].normal,
            );
            let on_plane = |corners: [usize; 3]| {
                corners
                    .iter()
                    .all(|&i| (plane.normal.dot(self.points[i]) - plane.offset).abs() <= flat)
            };
            let mut pending = vec![face];
            while let Some(face) = pending.pop() {
                let [a, b, c] = self.faces[face].corners;
                for edge in [(b, a), (c, b), (a, c)] {
                    if let Some(&other) = self.edges.get(&edge)
                        && !taken[other]
                        && on_plane(self.faces[other].corners)
                    {
                        taken[other] = true;
                        pending.push(other);
                    }
                }
            }
            planes.push(plane);
        }
        planes
    }
}
