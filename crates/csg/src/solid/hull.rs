//! Convex hulls of points.
//!
//! Quickhull (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, "The quickhull algorithm
//! for convex hulls", 1996): the furthest point outside a face replaces all
//! faces it sees by a fan. Whether it sees one is decided exactly, so that the faces that it sees
//! are one piece and no new one degenerates, however nearly flat a side is. The
//! triangles of a flat side then become one plane.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::primitive::{Plane, Polyhedron};
use super::tree::Solid;
use crate::error::{NodeFault, ProfileFault};
use crate::mesh::predicates::side;
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

/// The corners of the hull of finite points; none of points in one plane.
pub(super) fn corners_of_hull(points: &[DVec3]) -> Option<Vec<DVec3>> {
    let (min, max) = extent(points);
    let mut hull = Hull::start(points, ON_FACE * (max - min).max_element())?;
    hull.grow();
    Some(hull.corners())
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
    // All other points are behind its faces.
    let corners = hull.corners();
    let off = |plane: &Plane| {
        let beyond = corners.iter().map(|&p| plane.normal.dot(p) - plane.offset);
        beyond.fold(0.0, f64::max)
    };
    let worst = planes.iter().map(off).fold(0.0, f64::max);
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
    faces: Vec<Face>,
    /// The face to the left of each directed edge.
    edges: FxHashMap<(usize, usize), usize>,
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
            faces: Vec::new(),
            edges: FxHashMap::default(),
        };
        let [a, b, c, d] = corners;
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

    /// Whether a point is outside a face.
    fn sees(&self, point: usize, face: usize) -> bool {
        let corners = self.faces[face].corners.map(|i| self.points[i]);
        side(corners, self.points[point]) > 0
    }

    /// Gives each point to a face that it is outside of.
    fn share(&mut self, points: impl IntoIterator<Item = usize>, faces: &[usize]) {
        for point in points {
            if let Some(&face) = faces.iter().find(|&&face| self.sees(point, face)) {
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
                if self.sees(point, other) {
                    self.faces[other].alive = false;
                    seen.push(other);
                } else {
                    horizon.push((from, to));
                }
            }
        }
        let horizon = horizon.into_iter();
        let faces: Vec<usize> = horizon
            .map(|(from, to)| self.add([from, to, point]))
            .collect();
        self.share(orphans, &faces);
    }

    /// One plane for all triangles of a flat side, from the largest of them.
    fn planes(&self, flat: f64) -> Vec<Plane> {
        let (largest, _) = self.sides(flat);
        largest.into_iter().map(|face| self.plane(face)).collect()
    }

    fn corners(&self) -> Vec<DVec3> {
        let alive = self.faces.iter().filter(|face| face.alive);
        let mut corners: Vec<usize> = alive.flat_map(|face| face.corners).collect();
        corners.sort_unstable();
        corners.dedup();
        corners
            .into_iter()
            .map(|corner| self.points[corner])
            .collect()
    }

    fn plane(&self, face: usize) -> Plane {
        let face = &self.faces[face];
        Plane::through(self.points[face.corners[0]], face.normal)
    }

    /// The largest triangle of each flat side, and of each triangle the number of its side.
    fn sides(&self, flat: f64) -> (Vec<usize>, Vec<Option<usize>>) {
        let mut order: Vec<usize> = (0..self.faces.len())
            .filter(|&face| self.faces[face].alive)
            .collect();
        order.sort_by(|&a, &b| {
            self.faces[b]
                .area
                .total_cmp(&self.faces[a].area)
                .then(a.cmp(&b))
        });
        let mut side_of = vec![None; self.faces.len()];
        let mut largest = Vec::new();
        for face in order {
            if side_of[face].is_some() {
                continue;
            }
            let side = Some(largest.len());
            side_of[face] = side;
            let plane = self.plane(face);
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
                        && side_of[other].is_none()
                        && on_plane(self.faces[other].corners)
                    {
                        side_of[other] = side;
                        pending.push(other);
                    }
                }
            }
            largest.push(face);
        }
        (largest, side_of)
    }
}

impl Polyhedron {
    /// The convex polyhedron within some planes, with its vertices; none where these
    /// cannot be found for sure, or there is no inside.
    ///
    /// By duality (F. P. Preparata, D. E. Muller, "Finding the intersection of n
    /// half-spaces in time O(n log n)", 1979): planes seen from a point inside are points,
    /// whose hull has a triangle for each three planes that meet in a vertex.
    pub(crate) fn within(planes: &[Plane]) -> Option<Self> {
        let unit = |plane: &Plane| {
            let length = plane.normal.length();
            Plane {
                normal: plane.normal / length,
                offset: plane.offset / length,
            }
        };
        let planes: Vec<Plane> = planes.iter().map(unit).collect();
        let center = inside(&planes)?;
        let dual = |plane: &Plane| plane.normal / (plane.offset - plane.normal.dot(center));
        let points: Vec<DVec3> = planes.iter().map(dual).collect();
        let (min, max) = extent(&points);
        let size = (max - min).max_element();
        let mut hull = Hull::start(&points, ON_FACE * size)?;
        hull.grow();
        let (largest, side_of) = hull.sides(SAME_FACE * size);
        let vertex = |&face: &usize| {
            let [p, q, r] = hull.faces[face].corners.map(|k| planes[k]);
            let offset = |plane: Plane| plane.offset - plane.normal.dot(center);
            let cross = q.normal.cross(r.normal);
            let sum = offset(p) * cross
                + offset(q) * r.normal.cross(p.normal)
                + offset(r) * p.normal.cross(q.normal);
            center + sum / p.normal.dot(cross)
        };
        let vertices: Vec<DVec3> = largest.iter().map(vertex).collect();
        // All are on planes of theirs and behind all others, but for rounding.
        let reach = vertices
            .iter()
            .map(|v| v.distance(center))
            .fold(0.0, f64::max);
        let slack = OFF_HULL * (reach + center.length());
        for (face, side) in hull.faces.iter().zip(&side_of) {
            let Some(side) = *side else { continue };
            let off = |k: usize| planes[k].normal.dot(vertices[side]) - planes[k].offset;
            if !face.corners.iter().all(|&k| off(k).abs() <= slack) {
                return None;
            }
        }
        // Around each plane, by the triangles around its point.
        let mut around: Vec<FxHashMap<usize, (usize, usize)>> =
            vec![FxHashMap::default(); planes.len()];
        for (face, side) in hull.faces.iter().zip(&side_of) {
            let Some(side) = *side else { continue };
            let [a, b, c] = face.corners;
            for (at, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
                around[at].insert(from, (to, side));
            }
        }
        let mut polygons = Vec::with_capacity(planes.len());
        let mut kept = Vec::with_capacity(planes.len());
        for (plane, next) in planes.iter().zip(&around) {
            let Some(&start) = next.keys().min() else {
                continue;
            };
            let mut polygon: Vec<u32> = Vec::with_capacity(next.len());
            let mut at = start;
            for _ in 0..next.len() {
                let &(to, side) = next.get(&at)?;
                polygon.push(side as u32);
                at = to;
            }
            if at != start {
                return None;
            }
            polygon.dedup();
            if polygon.len() > 1 && polygon.first() == polygon.last() {
                polygon.pop();
            }
            if polygon.len() > 2 {
                polygons.push(polygon);
                kept.push(*plane);
            }
        }
        Self::of_convex_faces(vertices, &polygons, kept)
    }

    /// A polyhedron of convex faces on given planes; none where faces do not pair up
    /// along their edges.
    pub(crate) fn of_convex_faces(
        vertices: Vec<DVec3>,
        polygons: &[Vec<u32>],
        planes: Vec<Plane>,
    ) -> Option<Self> {
        let mut triangles = Vec::new();
        let mut faces = Vec::new();
        let mut sides: FxHashMap<[u32; 2], i32> = FxHashMap::default();
        for (face, polygon) in (0..).zip(polygons) {
            for (&a, &b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
                *sides.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
            // Every second corner is cut off, again and again: no triangle is longer than
            // it must be.
            let mut polygon = polygon.clone();
            while polygon.len() > 2 {
                let mut rest = Vec::with_capacity(polygon.len() / 2 + 1);
                let mut k = 0;
                while k < polygon.len() {
                    rest.push(polygon[k]);
                    if k + 2 <= polygon.len() && polygon.len() > 2 {
                        let ends = [polygon[k], polygon[k + 1], polygon[(k + 2) % polygon.len()]];
                        if ends[2] != ends[0] {
                            triangles.push(ends);
                            faces.push(face);
                        }
                    }
                    k += 2;
                }
                polygon = rest;
            }
        }
        sides.values().all(|&sum| sum == 0).then_some(Self {
            vertices,
            triangles,
            faces,
            planes,
        })
    }
}

/// A point behind all planes, not near any of them: from the mean of their feet by steps
/// away from the one that it is farthest beyond, or least behind.
fn inside(planes: &[Plane]) -> Option<DVec3> {
    const STEPS: u32 = 400;
    let feet = planes.iter().map(|plane| plane.offset * plane.normal);
    let mut at = feet.clone().sum::<DVec3>() / planes.len() as f64;
    let reach = feet.map(|foot| foot.distance(at)).fold(0.0, f64::max);
    let mut best = (0.0, None);
    for step in 1..=STEPS {
        let value = |plane: &Plane| plane.normal.dot(at) - plane.offset;
        let nearest = planes.iter().max_by(|a, b| value(a).total_cmp(&value(b)))?;
        let most = value(nearest);
        if most < best.0 {
            best = (most, Some(at));
        }
        if most < -0.1 * reach {
            break;
        }
        at -= (most.max(0.0) + reach / f64::from(step + 1)) * nearest.normal;
    }
    best.1.filter(|_| best.0 < -1e-3 * reach)
}
