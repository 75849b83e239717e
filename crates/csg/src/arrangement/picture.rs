//! The triangles of a face as seen from one side, to be flipped and split.

use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

use super::piece::Side;
use super::scene::Scene;

/// The triangles of a face; the half-edge 3 t + k leads from corner k of
/// triangle t to the next one.
pub(super) struct Picture<'a> {
    scene: &'a Scene<'a>,
    side: &'a Side,
    pub triangles: Vec<[u32; 3]>,
    /// Of each half-edge the other one of its edge, or [`NONE`].
    pub twins: Vec<u32>,
    /// Half-edges whose edges may not be Delaunay.
    stack: Vec<u32>,
}

pub(super) const NONE: u32 = u32::MAX;

const fn next(half: u32) -> u32 {
    if half % 3 == 2 { half - 2 } else { half + 1 }
}

/// Whether a point is clearly within the circle through three others, which are
/// counter-clockwise: the determinant of Guibas and Stolfi (*Primitives for the
/// Manipulation of General Subdivisions*, 1985), with Shewchuk's bound of its
/// rounding (*Adaptive Precision Floating-Point Arithmetic*, 1997). On the circle is
/// not in it, so that it takes no exact arithmetic for strips of alike quads.
fn is_in_circle(circle: [DVec2; 3], point: DVec2) -> bool {
    const BOUND: f64 = 6.0 * f64::EPSILON;
    let [a, b, c] = circle.map(|corner| corner - point);
    let (mut determinant, mut permanent) = (0.0, 0.0);
    for (p, q, r) in [(a, b, c), (b, c, a), (c, a, b)] {
        let (plus, minus) = (q.x * r.y, q.y * r.x);
        determinant += p.length_squared() * (plus - minus);
        permanent += p.length_squared() * (plus.abs() + minus.abs());
    }
    determinant > BOUND * permanent
}

/// Edges with one face on both sides, along which others touch it: both ways, by
/// their vertices.
pub(super) type Slits = FxHashSet<[u32; 2]>;

impl<'a> Picture<'a> {
    /// Slits are not flipped, nor split.
    pub fn new(
        scene: &'a Scene<'a>,
        side: &'a Side,
        triangles: Vec<[u32; 3]>,
        slits: &Slits,
    ) -> Self {
        let mut of_edge: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
        of_edge.extend(triangles.iter().flat_map(sides).zip(0u32..));
        let twin = |[a, b]: [u32; 2]| {
            let twin = of_edge.get(&[b, a]).filter(|_| !slits.contains(&[a, b]));
            twin.copied().unwrap_or(NONE)
        };
        Self {
            scene,
            side,
            twins: triangles.iter().flat_map(sides).map(twin).collect(),
            triangles,
            stack: Vec::new(),
        }
    }

    fn origin(&self, half: u32) -> u32 {
        self.triangles[half as usize / 3][half as usize % 3]
    }

    /// The ends of an edge.
    pub fn ends(&self, half: u32) -> [u32; 2] {
        [half, next(half)].map(|half| self.origin(half))
    }

    /// The corners on both sides of an edge, counter-clockwise from the origin of
    /// a half-edge: its own end comes third.
    fn quad(&self, half: u32, twin: u32) -> [u32; 4] {
        let apex = |half: u32| self.origin(next(next(half)));
        [self.origin(half), apex(twin), self.origin(twin), apex(half)]
    }

    fn seen(&self, vertex: u32, positions: &[DVec3]) -> DVec2 {
        self.scene.flatten(self.side, positions[vertex as usize])
    }

    /// Whether a triangle has its corners counter-clockwise.
    pub fn is_seen(&self, triangle: u32, positions: &[DVec3]) -> bool {
        let corners = self.triangles[triangle as usize];
        let [a, b, c] = corners.map(|corner| self.seen(corner, positions));
        (b - a).perp_dot(c - a) > 0.0
    }

    /// Puts a triangle where another one was.
    fn put(&mut self, triangle: u32, corners: [u32; 3], twins: [u32; 3]) {
        self.triangles[triangle as usize] = corners;
        for (half, twin) in (3 * triangle..).zip(twins) {
            self.twins[half as usize] = twin;
            if twin != NONE {
                self.twins[twin as usize] = half;
            }
        }
    }

    /// The half-edges beyond the four sides of a quad.
    fn rim(&self, half: u32, twin: u32) -> [u32; 4] {
        let sides = [next(twin), next(next(twin)), next(half), next(next(half))];
        sides.map(|side| self.twins[side as usize])
    }

    /// Flips edges until the triangulation is Delaunay.
    pub fn make_delaunay(&mut self, positions: &[DVec3]) {
        self.stack.extend(0..self.twins.len() as u32);
        self.flip(positions);
    }

    /// Flips the edges on the stack that are not Delaunay, and what comes of it.
    fn flip(&mut self, positions: &[DVec3]) {
        // Never needed but for a mistake.
        let mut left = 100 * self.twins.len();
        while let Some(half) = self.stack.pop() {
            let twin = self.twins[half as usize];
            if twin == NONE || left == 0 {
                continue;
            }
            let [a, d, b, c] = self.quad(half, twin);
            let [at_a, at_d, at_b, at_c] = [a, d, b, c].map(|v| self.seen(v, positions));
            // Of a face that is folded, being thinner than its edges' chords stray, flips would
            // make more and more folds.
            let is_seen = |[p, q, r]: [DVec2; 3]| (q - p).perp_dot(r - p) > 0.0;
            let is_better = is_in_circle([at_a, at_b, at_c], at_d)
                && is_seen([at_a, at_d, at_c])
                && is_seen([at_d, at_b, at_c]);
            if !is_better {
                continue;
            }
            left -= 1;
            let [ad, db, bc, ca] = self.rim(half, twin);
            let (first, second) = (half / 3, twin / 3);
            self.put(first, [a, d, c], [ad, 3 * second + 2, ca]);
            self.put(second, [d, b, c], [db, bc, 3 * first + 1]);
            self.stack
                .extend([ad, db, bc, ca].into_iter().filter(|&h| h != NONE));
        }
    }

    /// Splits an inner edge at a new vertex.
    pub fn split_edge(&mut self, half: u32, vertex: u32, positions: &[DVec3]) {
        let twin = self.twins[half as usize];
        let [a, d, b, c] = self.quad(half, twin);
        let [ad, db, bc, ca] = self.rim(half, twin);
        let (first, second) = (half / 3, twin / 3);
        let third = self.add();
        let fourth = self.add();
        self.put(first, [a, vertex, c], [3 * second + 1, 3 * third + 2, ca]);
        self.put(second, [d, vertex, a], [3 * fourth + 2, 3 * first, ad]);
        self.put(third, [vertex, b, c], [3 * fourth + 1, bc, 3 * first + 1]);
        self.put(fourth, [d, b, vertex], [db, 3 * third, 3 * second]);
        let rim = [ad, db, bc, ca].into_iter();
        self.stack.extend(rim.filter(|&half| half != NONE));
        self.flip(positions);
    }

    /// Splits a triangle at a new vertex inside.
    pub fn split_triangle(&mut self, first: u32, vertex: u32, positions: &[DVec3]) {
        let [a, b, c] = self.triangles[first as usize];
        let [ab, bc, ca] = [0, 1, 2].map(|k| self.twins[3 * first as usize + k]);
        let second = self.add();
        let third = self.add();
        self.put(first, [a, b, vertex], [ab, 3 * second + 2, 3 * third + 1]);
        self.put(second, [b, c, vertex], [bc, 3 * third + 2, 3 * first + 1]);
        self.put(third, [c, a, vertex], [ca, 3 * first + 2, 3 * second + 1]);
        let rim = [ab, bc, ca].into_iter();
        self.stack.extend(rim.filter(|&half| half != NONE));
        self.flip(positions);
    }

    fn add(&mut self) -> u32 {
        self.triangles.push([0; 3]);
        self.twins.extend([NONE; 3]);
        self.triangles.len() as u32 - 1
    }

    /// Makes a vertex of a point, if it lies inside the face and not at its rim.
    pub fn insert(&mut self, point: DVec3, positions: &mut Vec<DVec3>) {
        let at = self.scene.flatten(self.side, point);
        for triangle in 0..self.triangles.len() as u32 {
            let corners = self.triangles[triangle as usize];
            let corners = corners.map(|corner| self.seen(corner, positions));
            // How far it is from the sides, to the inside.
            let off = [0, 1, 2].map(|k| {
                let (p, q) = (corners[k], corners[(k + 1) % 3]);
                (q - p).perp_dot(at - p) / (q - p).length()
            });
            let weld = self.scene.weld;
            if off.iter().any(|&off| off < -weld) {
                continue;
            }
            if corners.iter().any(|corner| corner.distance(at) <= weld) {
                return;
            }
            let vertex = positions.len() as u32;
            let on = (3 * triangle..).zip(off).find(|(_, off)| off.abs() <= weld);
            match on {
                Some((half, _)) if self.twins[half as usize] == NONE => return,
                Some((half, _)) => {
                    positions.push(point);
                    self.split_edge(half, vertex, positions);
                }
                None => {
                    positions.push(point);
                    self.split_triangle(triangle, vertex, positions);
                }
            }
            return;
        }
    }
}
