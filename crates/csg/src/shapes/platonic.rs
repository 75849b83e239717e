//! The Platonic solids, by the radius of the sphere through their corners.

use glam::DVec3;

use super::positive;
use crate::solid::Solid;

/// (1 + √5) / 2.
const GOLDEN: f64 = 1.618_033_988_749_895;

/// The solids whose faces are equal regular polygons, centred at the origin.
impl Solid {
    fn platonic(function: &'static str, radius: f64, corners: &[DVec3]) -> Self {
        let made = positive("the circumradius", radius).map(|radius| {
            let corners = corners.iter().map(|corner| corner.normalize() * radius);
            Self::hull(corners)
        });
        Self::shaped(function, made)
    }

    /// Four triangles; corners along (1, 1, 1), (1, -1, -1), (-1, 1, -1) and
    /// (-1, -1, 1).
    #[must_use]
    pub fn tetrahedron(circumradius: f64) -> Self {
        let corners = [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]];
        Self::platonic("tetrahedron", circumradius, &corners.map(DVec3::from_array))
    }

    /// Eight triangles; corners on the axes.
    #[must_use]
    pub fn octahedron(circumradius: f64) -> Self {
        let corners = DVec3::AXES.map(|axis| [axis, -axis]);
        Self::platonic("octahedron", circumradius, corners.as_flattened())
    }

    /// Twelve pentagons; eight of the corners are those of a cube along the axes.
    #[must_use]
    pub fn dodecahedron(circumradius: f64) -> Self {
        let mut corners = cyclic(1.0 / GOLDEN, GOLDEN);
        for k in 0..8 {
            let sign = |bit: usize| if k & bit == 0 { -1.0 } else { 1.0 };
            corners.push(DVec3::new(sign(1), sign(2), sign(4)));
        }
        Self::platonic("dodecahedron", circumradius, &corners)
    }

    /// Twenty triangles; corners are those of three golden rectangles in the
    /// coordinate planes.
    #[must_use]
    pub fn icosahedron(circumradius: f64) -> Self {
        Self::platonic("icosahedron", circumradius, &cyclic(1.0, GOLDEN))
    }
}

/// (0, ±a, ±b) and its cyclic permutations.
fn cyclic(a: f64, b: f64) -> Vec<DVec3> {
    let mut corners = Vec::with_capacity(12);
    for (a, b) in [(a, b), (-a, b), (a, -b), (-a, -b)] {
        corners.extend([
            DVec3::new(0.0, a, b),
            DVec3::new(a, b, 0.0),
            DVec3::new(b, 0.0, a),
        ]);
    }
    corners
}
