//! Clipping in homogeneous clip space, before the division by w, so that it
//! is right for vertices behind the eye (w <= 0).
//!
//! The view volume is -w <= x, y, z <= w. A vertex has a six-bit [`Outcode`],
//! one bit for each plane it is outside of; a polygon whose vertices share a
//! bit is rejected, one whose vertices have none is accepted as it is, and
//! anything else goes through Sutherland–Hodgman (Sutherland, Hodgman,
//! *Reentrant polygon clipping*, CACM 17(1), 1974), plane by plane.

use glam::DVec4;

/// One bit for each plane of the view volume that a point is outside of:
/// left 1, right 2, bottom 4, top 8, near 16, far 32.
pub type Outcode = u8;

/// The six planes as coefficients (a, b, c, d) of a x + b y + c z + d w >= 0,
/// in the order of the [`Outcode`] bits.
pub const PLANES: [DVec4; 6] = [
    DVec4::new(1.0, 0.0, 0.0, 1.0),
    DVec4::new(-1.0, 0.0, 0.0, 1.0),
    DVec4::new(0.0, 1.0, 0.0, 1.0),
    DVec4::new(0.0, -1.0, 0.0, 1.0),
    DVec4::new(0.0, 0.0, 1.0, 1.0),
    DVec4::new(0.0, 0.0, -1.0, 1.0),
];

/// The planes a clip-space point is outside of. NaN is outside.
#[must_use]
pub fn outcode(p: DVec4) -> Outcode {
    PLANES.iter().enumerate().fold(0, |code, (bit, plane)| {
        let inside = plane.dot(p) >= 0.0;
        code | Outcode::from(!inside) << bit
    })
}

/// A vertex of a polygon being clipped: its clip coordinates, and its
/// barycentric coordinates in the triangle it came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipVertex {
    /// Clip coordinates.
    pub position: DVec4,
    /// Weights of the three original vertices.
    pub weights: [f64; 3],
}

impl ClipVertex {
    /// The point at `t` on the way to `other`.
    fn lerp(self, other: Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Self {
            position: self.position + (other.position - self.position) * t,
            weights: [
                mix(self.weights[0], other.weights[0]),
                mix(self.weights[1], other.weights[1]),
                mix(self.weights[2], other.weights[2]),
            ],
        }
    }
}

/// Clips a triangle against the six planes and leaves the (convex) polygon,
/// of at most nine vertices, in `polygon`; empty if nothing is inside or a
/// coordinate is not finite. `scratch` is working space.
pub fn clip_triangle(
    triangle: [DVec4; 3],
    polygon: &mut Vec<ClipVertex>,
    scratch: &mut Vec<ClipVertex>,
) {
    polygon.clear();
    if !triangle.iter().all(|p| p.is_finite()) {
        return;
    }
    let codes = triangle.map(outcode);
    if codes[0] & codes[1] & codes[2] != 0 {
        return;
    }
    for (i, position) in triangle.into_iter().enumerate() {
        let mut weights = [0.0; 3];
        weights[i] = 1.0;
        polygon.push(ClipVertex { position, weights });
    }
    let crossed = codes[0] | codes[1] | codes[2];
    for (bit, &plane) in PLANES.iter().enumerate() {
        if crossed & 1 << bit != 0 {
            clip_polygon(polygon, plane, scratch);
            std::mem::swap(polygon, scratch);
        }
    }
}

/// One step of Sutherland–Hodgman: the part of a polygon with
/// `plane` · p >= 0.
pub fn clip_polygon(polygon: &[ClipVertex], plane: DVec4, clipped: &mut Vec<ClipVertex>) {
    clipped.clear();
    let Some(&last) = polygon.last() else { return };
    let mut previous = last;
    let mut d_previous = plane.dot(previous.position);
    for &vertex in polygon {
        let d = plane.dot(vertex.position);
        if (d >= 0.0) != (d_previous >= 0.0) {
            // From the inside to the outside vertex whatever the direction of
            // travel: two triangles that share the edge get the same point.
            let crossing = if d >= 0.0 {
                vertex.lerp(previous, d / (d - d_previous))
            } else {
                previous.lerp(vertex, d_previous / (d_previous - d))
            };
            clipped.push(crossing);
        }
        if d >= 0.0 {
            clipped.push(vertex);
        }
        previous = vertex;
        d_previous = d;
    }
}

/// Clips a segment against the six planes (Liang–Barsky's parametric form in
/// homogeneous coordinates) and returns the parameters of the part inside, or
/// `None` if there is none.
#[must_use]
pub fn clip_segment(a: DVec4, b: DVec4) -> Option<(f64, f64)> {
    if !(a.is_finite() && b.is_finite()) || outcode(a) & outcode(b) != 0 {
        return None;
    }
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for plane in PLANES {
        let (da, db) = (plane.dot(a), plane.dot(b));
        if da < 0.0 {
            if db < 0.0 {
                return None;
            }
            enter = enter.max(da / (da - db));
        } else if db < 0.0 {
            leave = leave.min(da / (da - db));
        }
    }
    (enter <= leave).then_some((enter, leave))
}
