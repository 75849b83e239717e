//! Space cut by the planes of a polyhedron's own faces.

use glam::DVec3;

use super::primitive::Plane;
use super::tree::Solid;
use crate::numeric::tolerance::SAME_FACE;

/// So many planes are tried for each cut: tunes speed and the number of cuts only.
const CANDIDATES: usize = 12;

/// A face, or what cuts have left of it.
pub(super) struct Facet {
    /// With a unit normal.
    pub plane: Plane,
    pub points: Vec<DVec3>,
}

/// A node, and whether what is before its plane is meant.
type Place = (usize, bool);

/// What is on one side of a cut.
#[derive(Clone, Copy)]
enum Child {
    Inside,
    Outside,
    Node(usize),
}

struct Node {
    plane: Plane,
    front: Child,
    back: Child,
}

/// A binary space partition; every node comes before its children.
pub(super) struct Tree {
    nodes: Vec<Node>,
}

impl Tree {
    /// The tree of the faces of a closed polyhedron.
    pub(super) fn of(facets: Vec<Facet>, size: f64) -> Self {
        let slack = SAME_FACE * size;
        let mut nodes: Vec<Node> = Vec::new();
        // What is left to cut, and whose front or back it is.
        let mut pending: Vec<(Vec<Facet>, Option<Place>)> = vec![(facets, None)];
        while let Some((facets, above)) = pending.pop() {
            let plane = best(&facets, slack);
            if let Some((parent, is_front)) = above {
                let child = match plane {
                    Some(_) => Child::Node(nodes.len()),
                    None if is_front => Child::Outside,
                    None => Child::Inside,
                };
                let node = &mut nodes[parent];
                *(if is_front {
                    &mut node.front
                } else {
                    &mut node.back
                }) = child;
            }
            let Some(plane) = plane else {
                continue;
            };
            let (front, back) = cut(facets, &plane, slack);
            let index = nodes.len();
            nodes.push(Node {
                plane,
                front: Child::Outside,
                back: Child::Inside,
            });
            pending.push((front, Some((index, true))));
            pending.push((back, Some((index, false))));
        }
        Self { nodes }
    }

    /// The tree as a formula: behind the plane and in what is behind it, or
    /// before the plane and in what is before it.
    pub(super) fn solid(&self) -> Solid {
        let mut solids: Vec<Solid> = vec![Solid::empty(); self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate().rev() {
            let Plane { normal, offset } = node.plane;
            let behind = Solid::half_space_through(normal * offset, normal);
            let solid = |child: Child| match child {
                Child::Node(index) => solids[index].clone(),
                Child::Inside => Solid::space(),
                Child::Outside => Solid::empty(),
            };
            solids[index] = match (node.front, node.back) {
                (Child::Outside, Child::Inside) => behind,
                (Child::Inside, Child::Outside) => !behind,
                (Child::Outside, back) => behind & solid(back),
                (front, Child::Inside) => behind | solid(front),
                (Child::Inside, back) => !behind | solid(back),
                (front, Child::Outside) => !behind & solid(front),
                (front, back) => (&behind & solid(back)) | (solid(front) - behind),
            };
        }
        solids.first().cloned().unwrap_or_else(Solid::empty)
    }

    /// The cells that lie inside, as their planes.
    pub(super) fn cells(&self) -> Vec<Vec<Plane>> {
        let mut cells = Vec::new();
        let mut pending = vec![(Child::Node(0), Vec::new())];
        if self.nodes.is_empty() {
            return cells;
        }
        while let Some((child, planes)) = pending.pop() {
            match child {
                Child::Outside => {}
                Child::Inside => cells.push(planes),
                Child::Node(index) => {
                    let node = &self.nodes[index];
                    let mut before = planes.clone();
                    before.push(Plane {
                        normal: -node.plane.normal,
                        offset: -node.plane.offset,
                    });
                    pending.push((node.front, before));
                    let mut behind = planes;
                    behind.push(node.plane);
                    pending.push((node.back, behind));
                }
            }
        }
        cells
    }
}

fn distance(plane: &Plane, point: DVec3) -> f64 {
    plane.normal.dot(point) - plane.offset
}

/// Whether a facet has points before and behind a plane.
fn sides(facet: &Facet, plane: &Plane, slack: f64) -> (bool, bool) {
    facet
        .points
        .iter()
        .fold((false, false), |(front, back), &p| {
            let d = distance(plane, p);
            (front || d > slack, back || d < -slack)
        })
}

/// The plane that cuts fewest facets and, of several such, has most on one
/// side: a plane of the convex hull first.
fn best(facets: &[Facet], slack: f64) -> Option<Plane> {
    let step = facets.len().div_ceil(CANDIDATES).max(1);
    let cost = |plane: &Plane| {
        let (mut front, mut back, mut both) = (0, 0, 0);
        for facet in facets {
            match sides(facet, plane, slack) {
                (true, true) => both += 1,
                (true, false) => front += 1,
                (false, true) => back += 1,
                (false, false) => {}
            }
        }
        8 * both + front.min(back)
    };
    let candidates = facets.iter().step_by(step).map(|facet| facet.plane);
    candidates.min_by_key(cost)
}

/// The facets before and behind a plane; those on it are done with.
fn cut(facets: Vec<Facet>, plane: &Plane, slack: f64) -> (Vec<Facet>, Vec<Facet>) {
    let (mut front, mut back) = (Vec::new(), Vec::new());
    for facet in facets {
        match sides(&facet, plane, slack) {
            (true, true) => {
                for (list, sign) in [(&mut front, 1.0), (&mut back, -1.0)] {
                    let points = clipped(&facet.points, plane, sign, slack);
                    if points.len() >= 3 {
                        let plane = facet.plane;
                        list.push(Facet { plane, points });
                    }
                }
            }
            (true, false) => front.push(facet),
            (false, true) => back.push(facet),
            (false, false) => {}
        }
    }
    (front, back)
}

/// The part of a polygon on one side of a plane (I. E. Sutherland, G. W.
/// Hodgman, "Reentrant polygon clipping", 1974).
fn clipped(points: &[DVec3], plane: &Plane, sign: f64, slack: f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(points.len() + 2);
    for (&a, &b) in points.iter().zip(points.iter().cycle().skip(1)) {
        let [da, db] = [a, b].map(|p| sign * distance(plane, p));
        if da >= -slack {
            kept.push(a);
        }
        if da > slack && db < -slack || da < -slack && db > slack {
            kept.push(a.lerp(b, da / (da - db)));
        }
    }
    kept
}
