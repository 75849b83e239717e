//! Hulls of balls of different radii: planes that touch three of them, cones that touch two, and
//! the balls.
//!
//! A plane that touches three balls from outside, with all others behind it, holds a triangle of the
//! hull's boundary (the balls' supporting planes: J.-D. Boissonnat, A. Cérézo, O. Devillers,
//! J. Duquesne, M. Yvinec, "An algorithm for constructing the convex hull of a set of spheres in
//! dimension d", 1996); two balls in two of these planes are joined by a cone.

use glam::DVec3;

use super::hull::hull_planes;
use super::tree::Solid;
use crate::numeric::tolerance::{OFF_HULL, SAME_ANGLE};

/// All triples of balls are held against all others.
const MOST: usize = 24;

impl Solid {
    /// The least convex solid around balls, each a centre and a radius: of planes, cones and
    /// balls. `None` of more than 24 balls of which none is within another, or if it cannot be told
    /// for rounding what it is made of.
    #[must_use]
    pub fn hull_of_unequal_balls(balls: &[(DVec3, f64)]) -> Option<Self> {
        let outer = outer(balls);
        if outer.len() > MOST {
            return None;
        }
        let reach = |&(center, radius): &(DVec3, f64)| center.length() + radius;
        let slack = OFF_HULL * outer.iter().map(reach).fold(0.0, f64::max);
        // Whether all are behind the plane with a normal that touches one.
        let supports = |normal: DVec3, ball: usize| {
            let height = |&(center, radius): &(DVec3, f64)| normal.dot(center) + radius;
            let most = height(&outer[ball]) + slack;
            outer.iter().all(|other| height(other) <= most)
        };
        let mut touched: Vec<DVec3> = Vec::new();
        // The normals of the planes at each pair.
        let mut normals: Vec<Vec<DVec3>> = vec![Vec::new(); outer.len() * outer.len()];
        for k in 0..outer.len() {
            for j in 0..k {
                for i in 0..j {
                    let planes = touching([i, j, k].map(|ball| outer[ball]));
                    let planes = planes.into_iter().flatten();
                    for normal in planes.filter(|&normal| supports(normal, i)) {
                        for [a, b] in [[i, j], [i, k], [j, k]] {
                            normals[a * outer.len() + b].push(normal);
                        }
                        touched
                            .extend([i, j, k].map(|ball| outer[ball].0 + outer[ball].1 * normal));
                    }
                }
            }
        }
        let mut parts: Vec<Self> = Vec::new();
        if !touched.is_empty() {
            parts.push(Self::convex_polyhedron(hull_planes(&touched).ok()?));
        }
        let mut is_seen = vec![outer.len() == 1; outer.len()];
        for k in 0..outer.len() {
            for j in 0..k {
                let cone = Cone::around(outer[j], outer[k])?;
                let is_edge = match &normals[j * outer.len() + k][..] {
                    // All around, or nowhere.
                    [] => supports(cone.normal(), j),
                    // On one plane alone it is within the hull.
                    [first, others @ ..] => others.iter().any(|n| n.distance(*first) > SAME_ANGLE),
                };
                if is_edge {
                    parts.push(cone.solid());
                    is_seen[j] = true;
                    is_seen[k] = true;
                }
            }
        }
        let seen = outer.iter().zip(is_seen).filter(|&(_, is_seen)| is_seen);
        parts.extend(seen.map(|(&(center, radius), _)| Self::sphere(radius).translate(center)));
        Some(Self::union(parts))
    }
}

/// The balls that are not within others.
fn outer(balls: &[(DVec3, f64)]) -> Vec<(DVec3, f64)> {
    let mut outer: Vec<(DVec3, f64)> = Vec::new();
    let mut balls = balls.to_vec();
    balls.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (center, radius) in balls {
        let holds = |&(other, size): &(DVec3, f64)| other.distance(center) + radius <= size;
        if !outer.iter().any(holds) {
            outer.push((center, radius));
        }
    }
    outer
}

/// The normals of the two planes that touch three balls with all three behind them.
fn touching([a, b, c]: [(DVec3, f64); 3]) -> Option<[DVec3; 2]> {
    let [u, v] = [b.0 - a.0, c.0 - a.0];
    let across = u.cross(v);
    let square = across.length_squared();
    if square <= SAME_ANGLE * SAME_ANGLE * u.length_squared() * v.length_squared() {
        return None;
    }
    let within = ((a.1 - b.1) * v.cross(across) + (a.1 - c.1) * across.cross(u)) / square;
    let rest = 1.0 - within.length_squared();
    let out = rest.max(0.0).sqrt() * across.normalize();
    (rest > 0.0).then_some([within + out, within - out])
}

/// The cone that touches two balls, neither of which is within the other, from outside.
struct Cone {
    balls: [(DVec3, f64); 2],
    along: DVec3,
    /// Of the angle between its rulings and its axis.
    sine: f64,
    cosine: f64,
}

impl Cone {
    fn around(one: (DVec3, f64), other: (DVec3, f64)) -> Option<Self> {
        let along = other.0 - one.0;
        let sine = (one.1 - other.1) / along.length();
        (sine.abs() < 1.0).then(|| Self {
            balls: [one, other],
            along,
            sine,
            cosine: (1.0 - sine * sine).sqrt(),
        })
    }

    /// Of one of the planes that touch it.
    fn normal(&self) -> DVec3 {
        let axis = self.along.normalize();
        self.sine * axis + self.cosine * axis.any_orthonormal_vector()
    }

    /// What is between the circles in which it touches the balls.
    fn solid(&self) -> Solid {
        let [(from, one), (_, other)] = self.balls;
        let z = one * self.sine..self.along.length() + other * self.sine;
        let solid = if one == other {
            Solid::cylinder(one, z)
        } else {
            Solid::frustum(one * self.cosine, other * self.cosine, z)
        };
        solid.rotate_from_to(DVec3::Z, self.along).translate(from)
    }
}
