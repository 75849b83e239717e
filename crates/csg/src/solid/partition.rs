//! Space cut by the planes of a polyhedron's own faces.

use glam::DVec3;
use smallvec::SmallVec;

use super::primitive::Plane;
use super::tree::Solid;
use crate::mesh::shells::turns;
use crate::numeric::tolerance::COVERED;

/// So many planes are tried for each cut: tunes speed and the number of cuts only.
const CANDIDATES: usize = 12;

/// Whether a point in a plane is inside a polyhedron, or how facets that are not on that plane have
/// it: asked where those that are cancel.
pub(crate) type IsInside<'a> = &'a dyn Fn(&Plane, DVec3) -> bool;

/// A face, or a convex part of one.
#[derive(Clone, Debug)]
pub(crate) struct Facet {
    /// The same for all on one plane.
    pub face: u32,
    /// With a unit normal.
    pub plane: Plane,
    pub corners: SmallVec<[DVec3; 3]>,
}

impl Facet {
    /// Triangles that make it up, some of them turned round if it is not convex.
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> {
        fan(&self.corners)
    }

    /// Whether a corner is farther from a plane than what is on it.
    pub fn is_off(&self, plane: &Plane, slack: f64) -> bool {
        let mut corners = self.corners.iter();
        corners.any(|&corner| distance(plane, corner).abs() > slack)
    }
}

/// Triangles between the first corner of a polygon and its sides.
fn fan(corners: &[DVec3]) -> impl Iterator<Item = [DVec3; 3]> {
    let sides = corners.windows(2).skip(1);
    sides.map(|side| [corners[0], side[0], side[1]])
}

/// What cuts have left of a facet.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub facet: u32,
    /// Its corners; none if it is all of it.
    left: Option<Box<[DVec3]>>,
}

impl Part {
    pub const fn all_of(facet: u32) -> Self {
        Self { facet, left: None }
    }

    /// What of it another cut leaves.
    pub fn cut(&self, left: &[DVec3]) -> Self {
        Self {
            facet: self.facet,
            left: Some(left.into()),
        }
    }

    pub const fn is_whole(&self) -> bool {
        self.left.is_none()
    }

    pub fn corners<'a>(&'a self, facets: &'a [Facet]) -> &'a [DVec3] {
        match &self.left {
            None => &facets[self.facet as usize].corners,
            Some(left) => left,
        }
    }

    /// The same of another facet, its corners elsewhere.
    pub fn moved(&self, facet: u32, by: DVec3) -> Self {
        let moved = |left: &[DVec3]| left.iter().map(|&p| p + by).collect();
        Self {
            facet,
            left: self.left.as_deref().map(moved),
        }
    }
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
    /// The tree of the faces of a closed polyhedron; points nearer to a plane than `slack`
    /// are on it.
    pub(crate) fn of(facets: &[Facet], slack: f64) -> Self {
        let all = (0..facets.len() as u32).map(Part::all_of);
        let is_inside = |plane: &Plane, point: DVec3| {
            let others = facets.iter().filter(|facet| facet.is_off(plane, slack));
            let triangles = others.flat_map(Facet::triangles);
            triangles.map(|corners| turns(&corners, point)).sum::<f64>() > 0.5
        };
        Self::of_parts(facets, all.collect(), slack, &is_inside)
    }

    /// The same of what is left of faces in a box.
    pub(crate) fn of_parts(
        facets: &[Facet],
        parts: Vec<Part>,
        slack: f64,
        is_inside: IsInside<'_>,
    ) -> Self {
        let mut nodes: Vec<Node> = Vec::new();
        // What is left to cut, and whose front or back it is.
        let mut pending: Vec<(Vec<Part>, Option<Place>)> = vec![(parts, None)];
        while let Some((parts, above)) = pending.pop() {
            // Without any, the node above knows already.
            let Some((face, plane)) = best(facets, &parts, slack) else {
                continue;
            };
            let index = nodes.len();
            if let Some((parent, is_front)) = above {
                let node = &mut nodes[parent];
                *(if is_front {
                    &mut node.front
                } else {
                    &mut node.back
                }) = Child::Node(index);
            }
            let [front, back, on] = cut(facets, parts, (face, &plane), slack);
            let [before, behind] = beside(facets, &on, &plane, is_inside);
            nodes.push(Node {
                face,
                plane,
                front: before,
                back: behind,
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
                (Child::Outside, Child::Outside) => Solid::empty(),
                (Child::Inside, Child::Inside) => Solid::space(),
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

/// Whether what is left of a facet has points before and behind a plane: by the corners of
/// all of it where these tell, as what is left may be smaller than rounding. It is on the
/// plane only as a whole.
fn sides(facets: &[Facet], part: &Part, (face, plane): (u32, &Plane), slack: f64) -> (bool, bool) {
    let facet = &facets[part.facet as usize];
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
    let whole = flags(range(&facet.corners));
    if whole != (true, true) {
        return whole;
    }
    let (low, high) = range(part.corners(facets));
    match flags((low, high)) {
        (false, false) => (high > -low, high <= -low),
        sides => sides,
    }
}

/// The plane that cuts fewest facets and, of several such, has most on one
/// side: a plane of the convex hull first.
fn best(facets: &[Facet], parts: &[Part], slack: f64) -> Option<(u32, Plane)> {
    let step = parts.len().div_ceil(CANDIDATES).max(1);
    let cost = |(face, plane): &(u32, Plane)| {
        let (mut front, mut back, mut both) = (0, 0, 0);
        for part in parts {
            match sides(facets, part, (*face, plane), slack) {
                (true, true) => both += 1,
                (true, false) => front += 1,
                (false, true) => back += 1,
                (false, false) => {}
            }
        }
        8 * both + front.min(back)
    };
    let candidates = parts.iter().step_by(step).map(|part| {
        let facet = &facets[part.facet as usize];
        (facet.face, facet.plane)
    });
    candidates.min_by_key(cost)
}

/// What is left of facets before a plane, behind it, and on it.
fn cut(facets: &[Facet], parts: Vec<Part>, by: (u32, &Plane), slack: f64) -> [Vec<Part>; 3] {
    let [mut front, mut back, mut on] = [const { Vec::new() }; 3];
    for part in parts {
        match sides(facets, &part, by, slack) {
            (true, true) => {
                for (list, sign) in [(&mut front, 1.0), (&mut back, -1.0)] {
                    let left = clipped(part.corners(facets), by.1, sign, slack);
                    if left.len() >= 3 {
                        list.push(part.cut(&left));
                    }
                }
            }
            (true, false) => front.push(part),
            (false, true) => back.push(part),
            (false, false) => on.push(part),
        }
    }
    [front, back, on]
}

/// What is right before and right behind a plane, on sides without facets, by the facets on it.
///
/// Where some look one way and some the other, as those of two parts of a polyhedron that are
/// apart by less than can be told, the larger area decides: of a side that is inside or outside
/// all over, facets that are not covered by others all look the same way. If nothing is left
/// uncovered the plane bounds nothing, and it is asked what it runs through.
fn beside(facets: &[Facet], on: &[Part], plane: &Plane, is_inside: IsInside<'_>) -> [Child; 2] {
    let looks = |part: &Part| {
        let normal = facets[part.facet as usize].plane.normal;
        normal.dot(plane.normal).signum()
    };
    let as_seen = [Child::Outside, Child::Inside];
    if on.iter().all(|part| looks(part) > 0.0) {
        return as_seen;
    }
    let (mut difference, mut all, mut largest) = (0.0, 0.0, None);
    for part in on {
        let corners = part.corners(facets);
        let own = area(corners);
        difference += looks(part) * own;
        all += own;
        if largest.is_none_or(|(area, _)| own > area) {
            largest = Some((own, corners));
        }
    }
    match largest {
        Some((_, corners)) if difference.abs() <= COVERED * all => {
            let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
            let middle = middle - distance(plane, middle) * plane.normal;
            let both = if is_inside(plane, middle) {
                Child::Inside
            } else {
                Child::Outside
            };
            [both; 2]
        }
        Some(_) if difference < 0.0 => [Child::Inside, Child::Outside],
        _ => as_seen,
    }
}

fn area(corners: &[DVec3]) -> f64 {
    let doubled: DVec3 = fan(corners).map(|[a, b, c]| (b - a).cross(c - a)).sum();
    0.5 * doubled.length()
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
