//! Volume, area, centroid and second moments of the solid inside a mesh.
//!
//! By the divergence theorem, as sums over the signed tetrahedra between each
//! triangle and a point (Mirtich, *Fast and Accurate Computation of Polyhedral
//! Mass Properties*, 1996, gives the same integrals face by face). The point
//! is the centre of the bounds, so that a mesh far from the origin loses
//! nothing; the sums are compensated, so that many triangles lose nothing.

use glam::{DMat3, DVec3, Vec3Swizzles};
use rayon::prelude::*;

use super::star::in_range;
use crate::mesh::Mesh;

/// Triangles per partial sum: fixed, so that the order of additions does not
/// depend on the number of threads.
const CHUNK: usize = 1 << 14;

/// The measures of a mesh, in its own unit. All but the area mean something
/// only for a closed, oriented mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeshMeasure {
    /// The enclosed volume, positive if triangles are counter-clockwise seen
    /// from outside.
    pub volume: f64,
    /// A bound on what rounding does to that, the corners being as they are; how near the mesh is to
    /// a solid is another matter. Some 1e-15 of the area times the size, more of needles.
    pub volume_rounding: f64,
    /// The area of all triangles.
    pub area: f64,
    /// The centroid of the enclosed volume; `None` where that is zero or not
    /// finite.
    pub centroid: Option<DVec3>,
    /// The second moments about the centroid: the integral of (x - c)(x - c)ᵀ
    /// over the volume; zero without a centroid.
    pub second_moments: DMat3,
}

impl MeshMeasure {
    /// The inertia tensor about the centroid at density 1:
    /// trace(M) I - M of the second moments M.
    #[must_use]
    pub fn inertia(&self) -> DMat3 {
        let m = self.second_moments;
        let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
        DMat3::from_diagonal(DVec3::splat(trace)) - m
    }
}

impl Mesh {
    /// Measures volume, area, centroid and second moments in one pass.
    /// Triangles with vertices out of range count nothing
    /// ([`Mesh::check`] reports them).
    #[must_use]
    pub fn measure(&self) -> MeshMeasure {
        let (low, high) = self.bounds().unwrap_or_default();
        let centre = low.midpoint(high);
        let reach = (high - centre).max(centre - low).max_element();
        let parts: Vec<Sums> = self
            .triangles
            .par_chunks(CHUNK)
            .map(|triangles| {
                let mut sums = Sums::default();
                for triangle in triangles {
                    if in_range(triangle, self.positions.len()) {
                        sums.add(triangle.map(|v| self.positions[v as usize] - centre));
                    }
                }
                sums
            })
            .collect();
        let mut sums = Sums::default();
        for part in &parts {
            sums.merge(part);
        }
        sums.measure(centre, reach)
    }

    /// The enclosed volume; see [`Mesh::measure`].
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.measure().volume
    }

    /// The area of all triangles.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.measure().area
    }
}

/// The integrals so far, each times its own constant factor.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// 2 x area.
    area: Compensated,
    /// 6 x volume.
    volume: Compensated,
    /// Products of the largest coordinates of two sides, which rounding is counted by.
    sides: f64,
    /// 24 x first moments.
    first: [Compensated; 3],
    /// 120 x second moments: xx, yy, zz, xy, yz, zx.
    second: [Compensated; 6],
}

impl Sums {
    /// Adds the tetrahedron between a triangle and the origin.
    fn add(&mut self, [a, b, c]: [DVec3; 3]) {
        let (u, v) = (b - a, c - a);
        let normal = u.cross(v);
        self.sides += u.abs().max_element() * v.abs().max_element();
        // 6 x volume, as a·n: the small factor n keeps the error near the
        // triangle's own size, which a·(b x c) would not.
        let volume = a.dot(normal);
        let sum = a + b + c;
        self.area.add(normal.length());
        self.volume.add(volume);
        for (total, value) in self.first.iter_mut().zip((sum * volume).to_array()) {
            total.add(value);
        }
        // Over a tetrahedron with vertices v_i (one the origin) the integral
        // of x xᵀ is volume / 20 (sum v_i v_iᵀ + s sᵀ), s their sum.
        let squares = a * a + b * b + c * c + sum * sum;
        let (ar, br, cr, sr) = (a.yzx(), b.yzx(), c.yzx(), sum.yzx());
        let products = a * ar + b * br + c * cr + sum * sr;
        let values = [squares, products].map(|v| (v * volume).to_array());
        for (total, value) in self.second.iter_mut().zip(values.as_flattened()) {
            total.add(*value);
        }
    }

    fn merge(&mut self, other: &Self) {
        self.area.merge(other.area);
        self.volume.merge(other.volume);
        self.sides += other.sides;
        for (mine, its) in self.first.iter_mut().zip(other.first) {
            mine.merge(its);
        }
        for (mine, its) in self.second.iter_mut().zip(other.second) {
            mine.merge(its);
        }
    }

    /// About the centre of the bounds, from which no coordinate is farther than `reach`.
    fn measure(&self, centre: DVec3, reach: f64) -> MeshMeasure {
        /// With m the product of the largest coordinates of two sides, a component of their cross
        /// product is at most 2 m, and off by 8 m ε / 2: of the sides, a product and a difference each
        /// rounds once. The dot product with a rounds three times more, 42 m |a| ε / 2 in all. Moving
        /// corners by |a| ε / 2, as taking the centre off does, changes a closed mesh's volume by the areas
        /// beside them times that: 3 * 2 √3 m √3 |a| ε / 2. Together 30 m |a| ε, and a bit for the sum of
        /// m itself and what compensation leaves of many terms.
        const ROUNDINGS: f64 = 33.0 * f64::EPSILON;
        let volume = self.volume.value() / 6.0;
        let volume_rounding = ROUNDINGS * reach * self.sides / 6.0 + f64::EPSILON * volume.abs();
        let area = self.area.value() / 2.0;
        let arm = DVec3::from_array(self.first.map(Compensated::value)) / 24.0 / volume;
        if !arm.is_finite() || volume == 0.0 {
            return MeshMeasure {
                volume,
                volume_rounding,
                area,
                centroid: None,
                second_moments: DMat3::ZERO,
            };
        }
        let [xx, yy, zz, xy, yz, zx] = self.second.map(|sum| sum.value() / 120.0);
        let about_centre = DMat3::from_cols(
            DVec3::new(xx, xy, zx),
            DVec3::new(xy, yy, yz),
            DVec3::new(zx, yz, zz),
        );
        // Parallel axes: M about c = M about the origin - volume c cᵀ.
        let shift = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z) * volume;
        MeshMeasure {
            volume,
            volume_rounding,
            area,
            centroid: Some(centre + arm),
            second_moments: about_centre - shift,
        }
    }
}

/// A compensated sum (Neumaier 1974): the error does not grow with the number
/// of terms.
#[derive(Clone, Copy, Default)]
struct Compensated {
    sum: f64,
    error: f64,
}

impl Compensated {
    fn add(&mut self, term: f64) {
        // Knuth's two-sum: exact for any order of magnitudes, without branches.
        let sum = self.sum + term;
        let part = sum - self.sum;
        self.error += (self.sum - (sum - part)) + (term - part);
        self.sum = sum;
    }

    fn merge(&mut self, other: Self) {
        self.add(other.sum);
        self.error += other.error;
    }

    fn value(self) -> f64 {
        self.sum + self.error
    }
}
