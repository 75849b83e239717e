//! Hulls of balls of one radius: a convex polyhedron and all around it.

use glam::{DMat3, DVec3};

use super::hull::hull_planes;
use super::profile::Profile;
use super::tree::Solid;
use crate::numeric::tolerance::OFF_HULL;

impl Solid {
    /// The least convex solid around balls of the same radius: all points
    /// within `radius` of the hull of their centres. It is made of planes,
    /// cylinders around the hull's edges and balls around its corners. Of one
    /// centre it is a ball, of two a capsule; `None` if more lie in one plane.
    #[must_use]
    pub fn hull_of_balls(centers: &[DVec3], radius: f64) -> Option<Self> {
        let ball = |center: DVec3| Self::sphere(radius).translate(center);
        let mut distinct: Vec<DVec3> = Vec::new();
        for &center in centers {
            if !distinct.contains(&center) {
                distinct.push(center);
            }
        }
        match distinct[..] {
            [] => Some(Self::empty()),
            [only] => Some(ball(only)),
            [a, b] => Some(Self::union([rod(a, b, radius), ball(a), ball(b)])),
            _ => {
                let planes = hull_planes(&distinct).ok()?;
                let slack = OFF_HULL * planes.iter().map(|p| p.offset.abs()).fold(radius, f64::max);
                let mut parts = vec![Self::convex_polyhedron(planes.iter().copied())];
                let mut edges: Vec<[usize; 2]> = Vec::new();
                for plane in &planes {
                    let on =
                        |&k: &usize| (plane.normal.dot(distinct[k]) - plane.offset).abs() <= slack;
                    let corners: Vec<usize> = (0..distinct.len()).filter(on).collect();
                    let (x, y) = plane.normal.any_orthonormal_pair();
                    let x = if x.cross(y).dot(plane.normal) > 0.0 {
                        x
                    } else {
                        -x
                    };
                    let flat = |k: &usize| [distinct[*k].dot(x), distinct[*k].dot(y)];
                    let outline = Profile::hull_of(corners.iter().map(flat));
                    let ring = outline.contours(1.0).ok()?.into_iter().next()?;
                    let corner_at = |point: glam::DVec2| {
                        let found = corners.iter().find(|k| glam::DVec2::from(flat(k)) == point);
                        found.copied()
                    };
                    let ring: Option<Vec<usize>> = ring.into_iter().map(corner_at).collect();
                    let ring = ring?;
                    for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                        edges.push([a.min(b), a.max(b)]);
                    }
                    let map = glam::DAffine3 {
                        matrix3: DMat3::from_cols(x, y, plane.normal),
                        translation: plane.normal * plane.offset,
                    };
                    parts.push(Self::extrude(&outline, 0.0..radius).affine(map));
                }
                edges.sort_unstable();
                edges.dedup();
                let mut ends: Vec<usize> = edges.concat();
                ends.sort_unstable();
                ends.dedup();
                parts.extend(
                    edges
                        .iter()
                        .map(|[a, b]| rod(distinct[*a], distinct[*b], radius)),
                );
                parts.extend(ends.into_iter().map(|k| ball(distinct[k])));
                Some(Self::union(parts))
            }
        }
    }
}

/// A cylinder from one point to another.
fn rod(from: DVec3, to: DVec3, radius: f64) -> Solid {
    let along = to - from;
    Solid::cylinder(radius, 0.0..along.length())
        .rotate_from_to(DVec3::Z, along)
        .translate(from)
}
