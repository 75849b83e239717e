//! Space cut by the planes of a polyhedron's own faces.

use glam::DVec3;
use smallvec::SmallVec;

use super::primitive::Plane;
use super::tree::Solid;

/// So many planes are tried for each cut: tunes speed and the number of cuts only.
const CANDIDATES: usize = 12;

/// A face, or what cuts have left of it.
#[derive(Clone, Debug)]
pub(crate) struct Facet {
    /// The same for all on one plane.
    pub face: u32,
    /// With a unit normal.
    pub plane: Plane,
    pub points: SmallVec<[DVec3; 6]>,
    /// Its corners before any cut.
    pub whole: SmallVec<[DVec3; 3]>,
}

/// A node, and whether what is before its plane is meant.
type Place = (usize, bool);

/// What is on one side of a cut.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Child {
    Inside,
    Outside,
    Node(usize),
}

#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// The face whose plane it is.
    pub face: u32,
    plane: Plane,
    pub front: Child,
    pub back: Child,
}

/// A binary space partition; every node comes before its children.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub nodes: Vec<Node>,
}

impl Tree {
    /// The tree of the faces of a closed polyhedron, or of those in a box; points
    /// nearer to a plane than `slack` are on it.
    pub(crate) fn of(facets: Vec<Facet>, slack: f64) -> Self {
        let mut nodes: Vec<Node> = Vec::new();
        // What is left to cut, and whose front or back it is.
        let mut pending: Vec<(Vec<Facet>, Option<Place>)> = vec![(facets, None)];
        while let Some((facets, above)) = pending.pop() {
            let cut_by = best(&facets, slack);
            if let Some((parent, is_front)) = above {
                let child = match cut_by {
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
            let Some((face, plane)) = cut_by else {
                continue;
            };
            let (front, back) = cut(facets, (face, &plane), slack);
            let index = nodes.len();
            nodes.push(Node {
                face,
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

/// Whether a facet has points before and behind a plane: by its corners before any cut
/// where these tell, as what is left of it may be smaller than rounding. It is on the plane
/// only as a whole.
fn sides(facet: &Facet, (face, plane): (u32, &Plane), slack: f64) -> (bool, bool) {
    if facet.face == face {
        return (false, false);
    }
    let range = |points: &[DVec3]| {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        points.iter().fold(none, |(low, high), &p| {
            let d = distance(plane, p);
            (low.min(d), high.max(d))
        })
    };
    let flags = |(low, high): (f64, f64)| (high > slack, low < -slack);
    let whole = flags(range(&facet.whole));
    if whole != (true, true) {
        return whole;
    }
    let (low, high) = range(&facet.points);
    match flags((low, high)) {
        (false, false) => (high > -low, high <= -low),
        sides => sides,
    }
}

/// The plane that cuts fewest facets and, of several such, has most on one
/// side: a plane of the convex hull first.
fn best(facets: &[Facet], slack: f64) -> Option<(u32, Plane)> {
    let step = facets.len().div_ceil(CANDIDATES).max(1);
    let cost = |(face, plane): &(u32, Plane)| {
        let (mut front, mut back, mut both) = (0, 0, 0);
        for facet in facets {
            match sides(facet, (*face, plane), slack) {
                (true, true) => both += 1,
                (true, false) => front += 1,
                (false, true) => back += 1,
                (false, false) => {}
            }
        }
        8 * both + front.min(back)
    };
    let candidates = facets
        .iter()
        .step_by(step)
        .map(|facet| (facet.face, facet.plane));
    candidates.min_by_key(cost)
}

/// The facets before and behind a plane; those on it are done with.
fn cut(facets: Vec<Facet>, by: (u32, &Plane), slack: f64) -> (Vec<Facet>, Vec<Facet>) {
    let (mut front, mut back) = (Vec::new(), Vec::new());
    for facet in facets {
        match sides(&facet, by, slack) {
            (true, true) => {
                for (list, sign) in [(&mut front, 1.0), (&mut back, -1.0)] {
                    let points = clipped(&facet.points, by.1, sign, slack);
                    if points.len() >= 3 {
                        list.push(Facet {
                            points,
                            whole: facet.whole.clone(),
                            ..facet
                        });
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
fn clipped(points: &[DVec3], plane: &Plane, sign: f64, slack: f64) -> SmallVec<[DVec3; 6]> {
    let mut kept = SmallVec::new();
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
