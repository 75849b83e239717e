//! Triangles that are clearly apart, told without exact arithmetic, which is slow just
//! where it is needed most often: between neighbours.

use glam::{DVec2, DVec3, Vec3Swizzles};

use super::predicates::{Triangle, flattened};

/// A triangle of a mesh with area.
pub(super) struct Face {
    pub corners: Triangle,
    pub vertices: [u32; 3],
}

/// True only if it is certain that two triangles have no more in common than a vertex or
/// an edge of both.
pub(super) fn clearly_apart(one: &Face, other: &Face) -> bool {
    let shared = one.shared_with(other);
    let one_plane = Plane::of(&one.corners);
    if one_plane.keeps_off(&other.corners, shared[0] | shared[1] | shared[2]) {
        return true;
    }
    let other_shared = other.shared_with(one);
    let other_plane = Plane::of(&other.corners);
    if other_plane.keeps_off(
        &one.corners,
        other_shared[0] | other_shared[1] | other_shared[2],
    ) {
        return true;
    }
    for axis in [one_plane.axis(), other_plane.axis()] {
        let flat = flattened(one.corners, axis);
        let other_flat = flattened(other.corners, axis);
        if is_split_off(&flat, one_plane.turn(axis), &other_flat, shared)
            || is_split_off(&other_flat, other_plane.turn(axis), &flat, other_shared)
        {
            return true;
        }
    }
    false
}

impl Face {
    /// For each corner which of the other's corners is the same: a bit for each.
    #[inline(always)]
    fn shared_with(&self, other: &Self) -> [u8; 3] {
        let [a, b, c] = self.vertices;
        let [p, q, r] = other.vertices;
        let same = |v: u32| u8::from(v == p) | u8::from(v == q) << 1 | u8::from(v == r) << 2;
        [same(a), same(b), same(c)]
    }
}

/// The plane of a triangle.
struct Plane {
    at: DVec3,
    normal: DVec3,
    /// A bound of all rounding in the height of a point, by its distances along the axes.
    slack: DVec3,
}

impl Plane {
    #[inline(always)]
    fn of(&[a, b, c]: &Triangle) -> Self {
        // For three differences, two products and three sums half of it is enough.
        const BOUND: f64 = 8.0 * f64::EPSILON;
        let (u, v) = (b - a, c - a);
        let (plus, minus) = (u.yzx() * v.zxy(), u.zxy() * v.yzx());
        Self {
            at: a,
            normal: plus - minus,
            slack: BOUND * (plus.abs() + minus.abs()),
        }
    }

    /// Whether a triangle is on one side, but for a corner in the plane or the shared ones.
    #[inline(always)]
    fn keeps_off(&self, corners: &Triangle, shared: u8) -> bool {
        let (mut above, mut below, mut on) = (0, 0, shared);
        for (k, &corner) in corners.iter().enumerate() {
            let d = corner - self.at;
            let height = self.normal.dot(d);
            let slack = self.slack.dot(d.abs());
            above |= u8::from(height > slack) << k;
            below |= u8::from(height < -slack) << k;
            // (All products are zero: the plane is across an axis.)
            on |= u8::from(slack == 0.0) << k;
        }
        let touches = on == shared || on.count_ones() == 1;
        touches && on != 7 && (above | on == 7 || below | on == 7)
    }

    /// The axis that it faces most.
    #[inline(always)]
    fn axis(&self) -> usize {
        let n = self.normal.abs();
        if n.x > n.y && n.x > n.z {
            0
        } else if n.y > n.z {
            1
        } else {
            2
        }
    }

    /// Whether it is counter-clockwise (1) or clockwise (-1) along an axis; 0 if that is
    /// not certain.
    #[inline(always)]
    fn turn(&self, axis: usize) -> f64 {
        let (n, slack) = (self.normal.to_array()[axis], self.slack.to_array()[axis]);
        f64::from(i8::from(n > slack) - i8::from(n < -slack))
    }
}

/// Whether one of the triangle's sides has the other triangle on its outer side, but for
/// at most two corners in line with it: what they share is then a part of an edge of both.
#[inline(always)]
fn is_split_off(triangle: &[DVec2; 3], turn: f64, other: &[DVec2; 3], shared: [u8; 3]) -> bool {
    const BOUND: f64 = 4.0 * f64::EPSILON;
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        let along = triangle[to] - triangle[from];
        let (mut outside, mut on) = (0, shared[from] | shared[to]);
        for (k, &corner) in other.iter().enumerate() {
            let d = corner - triangle[from];
            let (plus, minus) = (along.y * d.x, along.x * d.y);
            let slack = BOUND * (plus.abs() + minus.abs());
            outside |= u8::from((plus - minus) * turn > slack) << k;
            // (Both products are zero: the line is along an axis.)
            on |= u8::from(slack == 0.0) << k;
        }
        if outside | on == 7 && on != 7 {
            return true;
        }
    }
    false
}
