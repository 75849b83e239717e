//! Hulls of balls of one radius: a convex polyhedron and all around it.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::hull::hull_planes;
use super::primitive::Plane;
use super::profile::Profile;
use super::tree::Solid;
use crate::numeric::tolerance::OFF_HULL;

impl Solid {
    /// The least convex solid around balls of the same radius: all points
    /// within `radius` of the hull of their centres. It is made of planes,
    /// cylinders around the hull's edges and balls around its corners. Of one
    /// centre it is a ball, of some in line a capsule, of some in a plane a plate with a round
    /// rim; `None` if that cannot be told for rounding.
    #[must_use]
    pub fn hull_of_balls(centers: &[DVec3], radius: f64) -> Option<Self> {
        let mut distinct: Vec<DVec3> = Vec::new();
        for &center in centers {
            if !distinct.contains(&center) {
                distinct.push(center);
            }
        }
        let &first = match &distinct[..] {
            [] => return Some(Self::empty()),
            [first, ..] => first,
        };
        let far_from = |from: DVec3| {
            let away = |p: &&DVec3| p.distance_squared(from);
            let farthest = distinct.iter().max_by(|a, b| away(a).total_cmp(&away(b)));
            farthest.copied().unwrap_or(from)
        };
        let start = far_from(first);
        let end = far_from(start);
        let slack = OFF_HULL * start.length().max(end.length()).max(radius);
        let along = (end - start).normalize_or_zero();
        let aside = |p: &DVec3| (p - start).reject_from_normalized(along);
        let by_length = |a: &DVec3, b: &DVec3| a.length_squared().total_cmp(&b.length_squared());
        let aside = distinct.iter().map(aside).max_by(by_length)?;
        let mut round = Round::new(&distinct);
        let index = |point: DVec3| (0..distinct.len()).find(|&k| distinct[k] == point);
        if start == end {
            round.corners.push(0);
        } else if aside.length() <= slack {
            round.edges.push([index(start)?, index(end)?]);
        } else {
            let normal = along.cross(aside).normalize();
            let offset = normal.dot(start);
            let flat = Plane { normal, offset };
            if round.on(&flat, slack).len() == distinct.len() {
                round.add_face(&flat, slack, [-radius, radius])?;
            } else {
                let planes = hull_planes(&distinct).ok()?;
                round
                    .parts
                    .push(Self::convex_polyhedron(planes.iter().copied()));
                let slack = OFF_HULL * planes.iter().map(|p| p.offset.abs()).fold(radius, f64::max);
                for plane in &planes {
                    round.add_face(plane, slack, [0.0, radius])?;
                }
            }
        }
        Some(round.solid(radius))
    }
}

/// What a hull of balls is made of.
struct Round<'a> {
    centers: &'a [DVec3],
    parts: Vec<Solid>,
    /// Between two of the centres; these are corners, too.
    edges: Vec<[usize; 2]>,
    corners: Vec<usize>,
}

impl<'a> Round<'a> {
    const fn new(centers: &'a [DVec3]) -> Self {
        Self {
            centers,
            parts: Vec::new(),
            edges: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// The centres on a plane.
    fn on(&self, plane: &Plane, slack: f64) -> Vec<usize> {
        let off = |k: usize| (plane.normal.dot(self.centers[k]) - plane.offset).abs();
        let all = 0..self.centers.len();
        all.filter(|&k| off(k) <= slack).collect()
    }

    /// Adds the face of the centres on a plane, from one height above that to another; none if
    /// rounding has made it another one.
    fn add_face(&mut self, plane: &Plane, slack: f64, [from, to]: [f64; 2]) -> Option<()> {
        let on = self.on(plane, slack);
        let (x, y) = plane.normal.any_orthonormal_pair();
        let is_right_handed = x.cross(y).dot(plane.normal) > 0.0;
        let x = if is_right_handed { x } else { -x };
        let flat = |&k: &usize| DVec2::new(self.centers[k].dot(x), self.centers[k].dot(y));
        let outline = Profile::hull_of(on.iter().map(flat));
        let ring = outline.contours(1.0).ok()?.into_iter().next()?;
        let corner_at = |point: DVec2| on.iter().find(|k| flat(k) == point).copied();
        let ring: Vec<usize> = ring.into_iter().map(corner_at).collect::<Option<_>>()?;
        let next = ring.iter().cycle().skip(1);
        self.edges
            .extend(ring.iter().zip(next).map(|(&a, &b)| [a.min(b), a.max(b)]));
        let map = DAffine3 {
            matrix3: DMat3::from_cols(x, y, plane.normal),
            translation: plane.normal * plane.offset,
        };
        self.parts
            .push(Solid::extrude(&outline, from..to).affine(map));
        Some(())
    }

    fn solid(mut self, radius: f64) -> Solid {
        self.edges.sort_unstable();
        self.edges.dedup();
        self.corners.extend(self.edges.iter().flatten());
        self.corners.sort_unstable();
        self.corners.dedup();
        let at = |k: usize| self.centers[k];
        let rods = self.edges.iter().map(|&[a, b]| rod(at(a), at(b), radius));
        let balls = self
            .corners
            .iter()
            .map(|&k| Solid::sphere(radius).translate(at(k)));
        Solid::union(self.parts.into_iter().chain(rods).chain(balls))
    }
}

/// A cylinder from one point to another.
fn rod(from: DVec3, to: DVec3, radius: f64) -> Solid {
    let along = to - from;
    Solid::cylinder(radius, 0.0..along.length())
        .rotate_from_to(DVec3::Z, along)
        .translate(from)
}
