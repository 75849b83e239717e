//! The largest distance from one mesh to another (Hausdorff's, one way), with bounds.
//!
//! The distance from a point to a mesh changes by no more than the point is moved, and the
//! distance to a single triangle, which is convex, is largest at a corner. So a triangle is
//! nowhere farther from the other mesh than its middle is plus what lies around that, and no
//! farther than its farthest corner is from a triangle. What lies over many triangles of the other mesh is
//! told by the height above them ([`shadow`]). Where all that leaves
//! too much open the triangle is cut, the most open one first: along the sides of the nearest
//! triangle, as what is above that is told by its corners alone, and in four where it is much larger
//! or those sides do not lead through it.

mod shadow;

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;
use rayon::prelude::*;

use smallvec::SmallVec;

use super::box_tree::BoxTree;
use super::nearest::to_triangle;
use super::twins::twins;
use crate::mesh::Mesh;
use crate::numeric::tolerance::ON_REFINED;

/// The largest distance from points of one mesh to another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshDistance {
    /// It is at least this: the point is as far away.
    pub lower: f64,
    /// And at most this.
    pub upper: f64,
    /// A point of the one mesh that is as far from the other one as `lower` says.
    pub place: DVec3,
}

/// A part of a triangle, and how far it may be from the other mesh.
struct Open {
    upper: f64,
    corners: [DVec3; 3],
    /// The triangle of the other mesh that is nearest to its middle.
    nearest: u32,
    /// Whether its height above the other mesh was asked for.
    is_measured: bool,
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        let corners = |open: &Self| open.corners.map(|corner| corner.to_array());
        let order = self.upper.total_cmp(&other.upper);
        order.then_with(|| {
            let (one, other) = (corners(self), corners(other));
            one.partial_cmp(&other).unwrap_or(Ordering::Equal)
        })
    }
}

impl Mesh {
    /// The largest distance from a point of this mesh's triangles to those of another one, in
    /// model units, until its bounds are no farther apart than `precision` or a thousandth
    /// of it, or too many triangles were cut for it; None if one of them has no triangles. The distance between both is the larger
    /// one of both ways.
    ///
    /// About n log n for n triangles, in parallel; the same for any number of threads.
    ///
    /// ```
    /// use csg::{Mesher, Program, Solid};
    ///
    /// let mesh = |solid: Solid| Mesher::new().mesh(&Program::lower(&solid)?).map(|m| m.mesh);
    /// let cube = mesh(Solid::cube(2.0))?;
    /// let moved = mesh(Solid::cube(2.0).translate([0.25, 0.0, 0.0]))?;
    /// let distance = cube.distance_to(&moved, 1e-6).expect("triangles");
    /// assert!(distance.lower <= 0.25 && 0.25 <= distance.upper);
    /// assert!(distance.upper - distance.lower < 0.001);
    /// # Ok::<(), csg::Error>(())
    /// ```
    #[must_use]
    pub fn distance_to(&self, other: &Self, precision: f64) -> Option<MeshDistance> {
        /// No more triangles are cut, whatever is left open: meshes of one curved face that are
        /// nowhere farther apart than they are near would want millions.
        const MOST_CUTS: u32 = 200_000;
        if self.triangles.is_empty() || other.triangles.is_empty() {
            return None;
        }
        let far = farthest(&self.positions).max(farthest(&other.positions));
        let target = Target::new(other, ON_REFINED * far);
        let mut is_used = vec![false; self.positions.len()];
        for &vertex in self.triangles.as_flattened() {
            is_used[vertex as usize] = true;
        }
        let places = self.positions.par_iter().zip(&is_used);
        let near: Vec<Near> = places
            .map(|(&place, is_used)| {
                if *is_used {
                    target.near(place, None)
                } else {
                    Near::UNUSED
                }
            })
            .collect();
        let mut search = Search {
            open: BinaryHeap::new(),
            lower: 0.0,
            place: self.corners(0)[0],
            precision,
            rounding: target.rounding,
        };
        for (near, &place) in near.iter().zip(&self.positions) {
            search.find(near.distance, place);
        }
        let enough = search.enough();
        let triangles = self.triangles.par_iter();
        let looks: Vec<Option<Look>> = triangles
            .map(|triangle| {
                let known = triangle.map(|vertex| near[vertex as usize].triangle);
                let corners = triangle.map(|vertex| self.positions[vertex as usize]);
                target.look(corners, &known, enough)
            })
            .collect();
        looks
            .into_iter()
            .flatten()
            .for_each(|look| search.add(look));
        let mut cuts = 0;
        let upper = loop {
            let Some(mut widest) = search.open.pop() else {
                break search.lower;
            };
            let enough = search.enough();
            if widest.upper <= enough || cuts == MOST_CUTS {
                break widest.upper.max(search.lower);
            }
            if !widest.is_measured {
                widest.is_measured = true;
                if let Some((height, place)) = target.height_of(widest.corners, widest.nearest) {
                    search.find_about(target.near(place, Some(widest.nearest)).distance, place);
                    widest.upper = widest.upper.min(height);
                }
                search.open.push(widest);
                continue;
            }
            cuts += 1;
            for part in target.parts(&widest) {
                // Corners are those of the whole, or on its sides.
                for corner in part {
                    let known = Some(widest.nearest);
                    if distance(corner, target.corners(widest.nearest)) > search.lower {
                        search.find_about(target.near(corner, known).distance, corner);
                    }
                }
                if let Some(mut look) = target.look(part, &[widest.nearest], search.enough()) {
                    // A part is no farther than the whole.
                    look.open.upper = look.open.upper.min(widest.upper);
                    search.add(look);
                }
            }
        };
        Some(MeshDistance {
            lower: search.lower,
            upper,
            place: search.place,
        })
    }
}

/// The triangle that is nearest to a point, and how far it is.
#[derive(Clone, Copy)]
struct Near {
    triangle: u32,
    distance: f64,
}

impl Near {
    /// Of a vertex without triangles, which is no point of its mesh.
    const UNUSED: Self = Self {
        triangle: 0,
        distance: 0.0,
    };
}

/// What is known of a triangle: how far it may be, and how far its middle is.
struct Look {
    open: Open,
    middle: DVec3,
    distance: f64,
}

/// Parts that may be farther than what was found.
struct Search {
    open: BinaryHeap<Open>,
    lower: f64,
    place: DVec3,
    precision: f64,
    /// How far points that were computed may be off their triangles.
    rounding: f64,
}

impl Search {
    /// What is no farther need not be looked at.
    fn enough(&self) -> f64 {
        self.lower + self.precision.max(1e-3 * self.lower)
    }

    /// A point is this far.
    fn find(&mut self, distance: f64, place: DVec3) {
        if distance > self.lower {
            (self.lower, self.place) = (distance, place);
        }
    }

    /// A point that was computed is this far.
    fn find_about(&mut self, distance: f64, place: DVec3) {
        self.find(distance - self.rounding, place);
    }

    fn add(&mut self, look: Look) {
        self.find_about(look.distance, look.middle);
        if look.open.upper > self.lower {
            self.open.push(look.open);
        }
    }
}

/// The largest coordinate.
fn farthest(points: &[DVec3]) -> f64 {
    let all = points.iter().map(|point| point.abs().max_element());
    all.fold(0.0, f64::max)
}

fn longest([a, b, c]: [DVec3; 3]) -> f64 {
    let sides = [a.distance(b), b.distance(c), c.distance(a)];
    sides.into_iter().fold(0.0, f64::max)
}

fn quarters([a, b, c]: [DVec3; 3]) -> [[DVec3; 3]; 4] {
    let [p, q, r] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
    [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
}

/// A point of a plane and its normal, of unit length.
type Plane = (DVec3, DVec3);

/// What of a convex polygon is behind a plane, and before it. What reaches across by no more than a
/// slack is on the side of the rest.
fn cut(polygon: &[DVec3], (point, normal): Plane, slack: f64) -> [SmallVec<[DVec3; 8]>; 2] {
    let height = |corner: &DVec3| (*corner - point).dot(normal);
    let heights: SmallVec<[f64; 8]> = polygon.iter().map(height).collect();
    let most = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let mut sides: [SmallVec<[DVec3; 8]>; 2] = Default::default();
    if most <= slack || least >= -slack {
        sides[usize::from(most > slack)].extend_from_slice(polygon);
        return sides;
    }
    for (k, &corner) in polygon.iter().enumerate() {
        let next = (k + 1) % polygon.len();
        let [here, there] = [heights[k], heights[next]];
        if here <= 0.0 {
            sides[0].push(corner);
        }
        if here >= 0.0 {
            sides[1].push(corner);
        }
        if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
            let on = corner.lerp(polygon[next], here / (here - there));
            sides.iter_mut().for_each(|side| side.push(on));
        }
    }
    sides
}

/// Adds the triangles of a convex polygon.
fn fan(polygon: &[DVec3], triangles: &mut SmallVec<[[DVec3; 3]; 8]>) {
    let pairs = polygon.windows(2).skip(1);
    triangles.extend(pairs.map(|pair| [polygon[0], pair[0], pair[1]]));
}

/// The mesh that distances are taken to.
struct Target<'a> {
    mesh: &'a Mesh,
    tree: BoxTree,
    /// Of each triangle's sides those of its neighbours, as [`twins`] has them.
    twins: Vec<u32>,
    /// How far points of both meshes may be off by rounding.
    rounding: f64,
}

/// How far a point is from a triangle.
fn distance(point: DVec3, corners: [DVec3; 3]) -> f64 {
    to_triangle(point, corners).0
}

impl<'a> Target<'a> {
    fn new(mesh: &'a Mesh, rounding: f64) -> Self {
        Self {
            mesh,
            tree: mesh.triangle_tree(),
            twins: twins(&mesh.triangles, |triangle| {
                let [a, b, c] = mesh.triangles[triangle];
                a != b && b != c && c != a
            }),
            rounding,
        }
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.mesh.corners(triangle as usize)
    }

    /// The nearest triangle to a point; faster if one is known that is not far.
    fn near(&self, point: DVec3, known: Option<u32>) -> Near {
        let measure = |triangle| distance(point, self.corners(triangle));
        let (triangle, distance) = self
            .tree
            .nearest(point, known, measure)
            .unwrap_or((0, f64::INFINITY));
        Near { triangle, distance }
    }

    /// What a triangle is cut into.
    fn parts(&self, open: &Open) -> SmallVec<[[DVec3; 3]; 8]> {
        let [a, b, c] = self.corners(open.nearest);
        if longest(open.corners) > 2.0 * longest([a, b, c]) {
            return SmallVec::from_slice(&quarters(open.corners));
        }
        let normal = (b - a).cross(c - a);
        let mut parts = SmallVec::new();
        let mut rest: SmallVec<[DVec3; 8]> = SmallVec::from_slice(&open.corners);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let out = (to - from).cross(normal).normalize_or_zero();
            let [inner, outer] = cut(&rest, (from, out), self.rounding);
            fan(&outer, &mut parts);
            rest = inner;
        }
        if parts.is_empty() || rest.is_empty() {
            return SmallVec::from_slice(&quarters(open.corners));
        }
        fan(&rest, &mut parts);
        parts
    }

    /// How far a triangle may be; nothing if no farther than is enough. Triangles are known that are
    /// near it.
    fn look(&self, corners: [DVec3; 3], known: &[u32], enough: f64) -> Option<Look> {
        let above = |triangle: u32| {
            let nearest = self.corners(triangle);
            let distances = corners.map(|corner| distance(corner, nearest));
            distances.into_iter().fold(0.0, f64::max)
        };
        let mut upper = f64::INFINITY;
        for &triangle in known {
            upper = upper.min(above(triangle));
            if upper <= enough {
                return None;
            }
        }
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let Near { triangle, distance } = self.near(middle, known.first().copied());
        let around = corners.map(|corner| corner.distance(middle));
        let around = around.into_iter().fold(0.0, f64::max);
        let upper = upper.min(above(triangle)).min(distance + around);
        Some(Look {
            open: Open {
                upper: upper.max(distance),
                corners,
                nearest: triangle,
                is_measured: false,
            },
            middle,
            distance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::shadow::tests::sheet;
    use super::*;
    use crate::elementary;

    /// A square as a fan around a point of it, so that long triangles of two lie across each
    /// other, and at another height around its middle.
    fn square(around: [f64; 2], count: u32, dent: f64) -> Mesh {
        let mut mesh = Mesh::default();
        let [x, y] = around;
        mesh.positions.push(DVec3::new(x, y, dent));
        for k in 0..4 * count {
            let share = f64::from(k % count) / f64::from(count);
            let [x, y] = match k / count {
                0 => [share, 0.0],
                1 => [1.0, share],
                2 => [1.0 - share, 1.0],
                _ => [0.0, 1.0 - share],
            };
            mesh.positions.push(DVec3::new(x, y, 0.0));
            let next = (k + 1) % (4 * count);
            mesh.triangles.push([0, k + 1, next + 1]);
        }
        mesh
    }

    /// Chords of an arc of radius 1 from z = 0 to 1, along which it is cut so often, too.
    fn barrel(chords: u32, rows: u32) -> Mesh {
        sheet([chords, rows], |around, y| {
            elementary::direction(around).extend(y)
        })
    }

    /// Each large triangle is nearly as far from many small ones as the farthest is.
    #[test]
    fn a_coarse_mesh_is_as_far_from_a_fine_one_as_its_chords_stray() {
        let (coarse, fine) = (barrel(16, 16), barrel(256, 256));
        let sagitta = |chords: f64| 2.0 * elementary::sin(0.25 / chords).powi(2);
        // Of coordinates of 1.
        let rounding = 1e-15;
        let (most, least) = (sagitta(16.0), sagitta(16.0) - sagitta(256.0));
        for (one, other) in [(&coarse, &fine), (&fine, &coarse)] {
            let distance = one.distance_to(other, 1e-7).expect("triangles");
            assert!(
                least - rounding <= distance.upper && distance.lower <= most + rounding,
                "{distance:?} for {least} to {most}"
            );
            assert!(
                distance.upper - distance.lower <= 1e-3 * most,
                "{distance:?}"
            );
        }
    }

    #[test]
    fn meshes_of_one_face_are_as_near_as_they_are() {
        let one = square([0.3, 0.4], 60, 0.0);
        let other = square([0.8, 0.7], 50, 0.0);
        let distance = one.distance_to(&other, 1e-9).expect("triangles");
        assert!(distance.upper <= 1e-9, "{distance:?}");
        for height in [1e-2, 1e-4, 1e-6] {
            let dented = square([0.8, 0.7], 50, height);
            let distance = dented.distance_to(&one, 1e-3 * height).expect("triangles");
            let off = distance.upper - height;
            assert!(
                distance.lower <= height && (-1e-15..2e-3 * height).contains(&off),
                "{height:e}: {distance:?}"
            );
        }
    }
}
