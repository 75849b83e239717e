//! Common points of one, two or three surfaces each, many at a time.
//!
//! The same steps as [`common_point`](crate::surface::solve::common_point)'s, without its care for
//! surfaces that touch: what does not get there in a few steps is left to
//! that. The same operations in the same order for every point, whatever the
//! machine's vector width.

use std::array;

use glam::DVec3;

use crate::numeric::tolerance::TOUCHING;
use crate::program::Surface;

/// Points handled together. Tunes speed only.
pub(super) const LANES: usize = 8;

type Lanes = [f64; LANES];

/// A vector of one lane.
type Vector = [f64; 3];

/// Surfaces, one a lane, coefficient by coefficient.
#[derive(Clone, Copy)]
struct Coefficients {
    anchor: [Lanes; 3],
    quadratic: [Lanes; 6],
    linear: [Lanes; 3],
    constant: Lanes,
}

/// Up to [`LANES`] points, each to be moved onto `N` surfaces of its own.
pub(super) struct Batch<const N: usize> {
    surfaces: [Coefficients; N],
    point: [Lanes; 3],
    are_planes: bool,
    count: usize,
}

impl<const N: usize> Batch<N> {
    /// An empty batch.
    #[inline(always)]
    pub fn new() -> Self {
        const ZEROES: Lanes = [0.0; LANES];
        let none = Coefficients {
            anchor: [ZEROES; 3],
            quadratic: [ZEROES; 6],
            linear: [ZEROES; 3],
            constant: ZEROES,
        };
        Self {
            surfaces: [none; N],
            point: [ZEROES; 3],
            are_planes: true,
            count: 0,
        }
    }

    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count == LANES
    }

    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
        self.are_planes = true;
    }

    /// Adds a point that is to be on the given surfaces; there must be room.
    #[inline(always)]
    pub fn push(&mut self, start: DVec3, surfaces: [&Surface; N]) {
        let lane = self.count % LANES;
        for (lanes, value) in self.point.iter_mut().zip(start.to_array()) {
            lanes[lane] = value;
        }
        for (own, surface) in self.surfaces.iter_mut().zip(surfaces) {
            let (anchor, linear) = (surface.anchor().to_array(), surface.linear.to_array());
            for axis in 0..3 {
                own.anchor[axis][lane] = anchor[axis];
                own.linear[axis][lane] = linear[axis];
            }
            for (lanes, value) in own.quadratic.iter_mut().zip(surface.quadratic) {
                lanes[lane] = value;
            }
            own.constant[lane] = surface.constant;
            self.are_planes &= surface.is_plane();
        }
        self.count += 1;
    }

    /// Moves all points onto their surfaces by steps no longer than `reach`;
    /// those that came within `tolerance` of them, the others none.
    #[inline(always)]
    pub fn solve(
        &mut self,
        reach: f64,
        tolerance: f64,
    ) -> impl Iterator<Item = Option<DVec3>> + use<N> {
        let arrived = if self.are_planes {
            self.solve_on::<false>(reach, tolerance)
        } else {
            self.solve_on::<true>(reach, tolerance)
        };
        let point = self.point;
        (0..self.count).map(move |lane| {
            let [x, y, z] = array::from_fn(|axis| point[axis][lane]);
            arrived[lane].then_some(DVec3::new(x, y, z))
        })
    }

    #[inline(always)]
    fn solve_on<const CURVED: bool>(&mut self, reach: f64, tolerance: f64) -> [bool; LANES] {
        const MOST_STEPS: usize = 8;
        /// A step whose square is nothing beside `reach` is the last.
        const LAST: f64 = 1e-8;
        for _ in 0..MOST_STEPS {
            let mut squares = [0.0; LANES];
            for (lane, last) in squares.iter_mut().enumerate() {
                let point = [
                    self.point[0][lane],
                    self.point[1][lane],
                    self.point[2][lane],
                ];
                let [x, y, z] = shortest_step(self.values::<CURVED>(lane, point));
                let square = x * x + y * y + z * z;
                let limit = if square > reach * reach {
                    reach / square.sqrt()
                } else {
                    1.0
                };
                self.point[0][lane] = point[0] + limit * x;
                self.point[1][lane] = point[1] + limit * y;
                self.point[2][lane] = point[2] + limit * z;
                *last = square;
            }
            // Lanes that are not numbers any more are no reason to go on.
            let is_near = |square: f64| square <= (LAST * reach) * (LAST * reach);
            if squares.iter().all(|&s| is_near(s) || s.is_nan()) {
                break;
            }
        }
        let mut arrived = [false; LANES];
        for (lane, arrived) in arrived.iter_mut().enumerate() {
            let point = [
                self.point[0][lane],
                self.point[1][lane],
                self.point[2][lane],
            ];
            *arrived = true;
            for (f, g) in self.values::<CURVED>(lane, point) {
                *arrived &= f * f <= tolerance * tolerance * dot(g, g);
            }
        }
        arrived
    }

    /// f and its gradient of every surface of a lane.
    #[inline(always)]
    fn values<const CURVED: bool>(&self, lane: usize, point: Vector) -> [(f64, Vector); N] {
        // A loop: calls of closures by library functions are not compiled for
        // the vectors at hand.
        let mut values = [(0.0, [0.0; 3]); N];
        for (value, surface) in values.iter_mut().zip(&self.surfaces) {
            *value = surface.value::<CURVED>(lane, point);
        }
        values
    }
}

impl Coefficients {
    /// f and its gradient in one lane.
    #[inline(always)]
    fn value<const CURVED: bool>(&self, lane: usize, point: Vector) -> (f64, Vector) {
        let x = point[0] - self.anchor[0][lane];
        let y = point[1] - self.anchor[1][lane];
        let z = point[2] - self.anchor[2][lane];
        let gx = self.linear[0][lane];
        let gy = self.linear[1][lane];
        let gz = self.linear[2][lane];
        if !CURVED {
            return (gx * x + gy * y + gz * z, [gx, gy, gz]);
        }
        let xx = self.quadratic[0][lane];
        let yy = self.quadratic[1][lane];
        let zz = self.quadratic[2][lane];
        let xy = 0.5 * self.quadratic[3][lane];
        let yz = 0.5 * self.quadratic[4][lane];
        let zx = 0.5 * self.quadratic[5][lane];
        // Half the gradient of the quadratic part.
        let hx = xx * x + (xy * y + zx * z);
        let hy = yy * y + (yz * z + xy * x);
        let hz = zz * z + (zx * x + yz * y);
        let f = (hx + gx) * x + (hy + gy) * y + (hz + gz) * z + self.constant[lane];
        (f, [2.0 * hx + gx, 2.0 * hy + gy, 2.0 * hz + gz])
    }
}

#[inline(always)]
fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The shortest vector to where all of f + g·d come to zero; not a number
/// where gradients are nearly dependent.
#[inline(always)]
fn shortest_step<const N: usize>(values: [(f64, Vector); N]) -> Vector {
    let determined = |square: f64, scale: f64| {
        if square > TOUCHING * TOUCHING * scale {
            1.0
        } else {
            f64::NAN
        }
    };
    match values[..] {
        [(f, g)] => {
            let t = -f / dot(g, g);
            g.map(|g| t * g)
        }
        [(f1, g1), (f2, g2)] => {
            // In the plane of the gradients: across the common tangent c.
            let c = cross(g1, g2);
            let square = dot(c, c);
            let t = -determined(square, dot(g1, g1) * dot(g2, g2)) / square;
            let (a, b) = (cross(g2, c), cross(c, g1));
            array::from_fn(|axis| t * (f1 * a[axis] + f2 * b[axis]))
        }
        [(f1, g1), (f2, g2), (f3, g3)] => {
            let (c23, c31, c12) = (cross(g2, g3), cross(g3, g1), cross(g1, g2));
            let determinant = dot(g1, c23);
            let scale = dot(g1, g1) * dot(g2, g2) * dot(g3, g3);
            let t = -determined(determinant * determinant, scale) / determinant;
            array::from_fn(|axis| t * (f1 * c23[axis] + f2 * c31[axis] + f3 * c12[axis]))
        }
        _ => [f64::NAN; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Program;
    use crate::random::Random;
    use crate::solid::Solid;
    use crate::surface::solve;

    /// A sphere, oblique cylinders and planes about the origin.
    fn surfaces(random: &mut Random) -> Vec<Surface> {
        let mut turn = |solid: Solid| {
            let mut angle = || 6.0 * random.unit();
            solid.rotate_xyz(angle(), angle(), angle())
        };
        let solid = turn(Solid::cube(1.2))
            & Solid::sphere(1.0)
            & turn(Solid::infinite_cylinder(0.7))
            & turn(Solid::infinite_cylinder(0.8));
        Program::lower(&solid).expect("valid").surfaces().to_vec()
    }

    /// Points that arrive are where the plain search ends, and most do.
    fn agrees_with_the_plain_search<const N: usize>() {
        let mut random = Random(N as u64);
        let (mut arrived, mut tried) = (0, 0);
        for _ in 0..800 {
            let all = surfaces(&mut random);
            let mut batch = Batch::<N>::new();
            let mut plain = Vec::new();
            for _ in 0..LANES {
                let first = random.below(all.len() - N + 1);
                let own: [&Surface; N] = array::from_fn(|k| &all[first + k]);
                let far = DVec3::from_array([(); 3].map(|()| 2.0 * random.unit() - 1.0));
                let near = solve::common_point(&own, far, 0.1);
                if near.residual > 1e-12 {
                    continue;
                }
                let off = DVec3::from_array([(); 3].map(|()| random.unit() - 0.5));
                let start = near.point + 0.02 * off;
                batch.push(start, own);
                plain.push(solve::common_point(&own, start, 0.1));
            }
            tried += plain.len();
            for (found, plain) in batch.solve(0.1, 1e-13).zip(plain) {
                let Some(point) = found else { continue };
                arrived += 1;
                let apart = point.distance(plain.point);
                assert!(apart < 1e-9, "{N} surfaces: {apart:e} apart");
            }
        }
        assert!(tried > 100, "{N} surfaces: {tried} tried");
        assert!(arrived * 20 > tried * 19, "{N}: {arrived} of {tried}");
    }

    #[test]
    fn points_are_where_the_plain_search_finds_them() {
        agrees_with_the_plain_search::<1>();
        agrees_with_the_plain_search::<2>();
        agrees_with_the_plain_search::<3>();
    }

    #[test]
    fn parallel_planes_have_no_common_point() {
        let program = Program::lower(&Solid::cube(1.0)).expect("valid");
        let all = program.surfaces();
        let opposite = |surface: &&Surface| surface.linear.abs() == all[0].linear.abs();
        let pair: Vec<&Surface> = all.iter().filter(opposite).collect();
        let mut batch = Batch::<2>::new();
        batch.push(DVec3::ZERO, [pair[0], pair[1]]);
        assert_eq!(batch.solve(0.1, 1e-13).next(), Some(None));
    }
}
