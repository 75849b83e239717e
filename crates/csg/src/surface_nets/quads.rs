//! How quads are cut into triangles: along the diagonal that is nearer to the
//! surface, many quads at a time.

use glam::DVec3;
use pulp::Simd;

use crate::numeric::lanes::{Reals, Vectors, cross, dot, minus, plus, times};
use crate::program::Surface;

/// Quads handled together: so many that what is written coordinate by
/// coordinate has left the store buffer when it is read in whole vectors. Tunes speed only.
pub(super) const LANES: usize = 32;
/// A diagonal whose smaller triangle, seen along the normal, is no more than
/// this share of the other's is not taken.
const THIN: f64 = 0.125;
/// A vertex and where it lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub point: DVec3,
    pub vertex: u32,
}

/// A side of a surface.
#[derive(Clone, Copy)]
pub(super) struct SurfaceSide<'a> {
    pub surface: &'a Surface,
    /// Whether the surface's gradient points into the solid.
    pub reversed: bool,
}

/// The corners of many quads, coordinate by coordinate, and what was found
/// out about them.
pub(super) struct Quads {
    /// Vertices by corner and lane.
    vertices: [[u32; LANES]; 4],
    /// Corner, coordinate, lane.
    corners: [[[f64; LANES]; 3]; 4],
    /// 1 for every quad to be cut along its odd diagonal (1, 3), else 0.
    odd: [u64; LANES],
    /// 1 for every quad that has a bad triangle all the same, else 0.
    pub bad: [u64; LANES],
}

impl Default for Quads {
    fn default() -> Self {
        Self {
            vertices: [[0; LANES]; 4],
            corners: [[[0.0; LANES]; 3]; 4],
            odd: [0; LANES],
            bad: [0; LANES],
        }
    }
}

impl Quads {
    #[inline(always)]
    pub fn set(&mut self, lane: usize, corners: [&Corner; 4]) {
        for ((lanes, vertices), corner) in
            self.corners.iter_mut().zip(&mut self.vertices).zip(corners)
        {
            vertices[lane] = corner.vertex;
            lanes[0][lane] = corner.point.x;
            lanes[1][lane] = corner.point.y;
            lanes[2][lane] = corner.point.z;
        }
    }

    /// Decides for the first `count` quads, whose corners lie on one side of a
    /// surface, along which diagonal to cut them, and whether a triangle of
    /// theirs is bad: folded over, or smaller than `least_area`. Whether any is.
    ///
    /// The diagonal whose midpoint is nearer to the surface wins, unless it
    /// leaves a fold or a sliver that the other does not; on a plane the one
    /// whose smaller triangle is larger.
    #[inline(always)]
    pub fn judge<S: Simd>(
        &mut self,
        simd: S,
        side: SurfaceSide<'_>,
        least_area: f64,
        count: usize,
    ) -> bool {
        let vectors = count.div_ceil(S::F64_LANES).min(LANES / S::F64_LANES);
        if side.surface.is_plane() {
            self.judge_on::<true, S>(simd, side, least_area, vectors);
        } else {
            self.judge_on::<false, S>(simd, side, least_area, vectors);
        }
        self.bad[..count].iter().fold(0, |any, bad| any | bad) != 0
    }

    #[inline(always)]
    fn judge_on<const PLANE: bool, S: Simd>(
        &mut self,
        simd: S,
        side: SurfaceSide<'_>,
        least_area: f64,
        vectors: usize,
    ) {
        let surface = side.surface;
        let all = |value: f64| Reals::all(simd, value);
        let sign = if side.reversed { -1.0 } else { 1.0 };
        let twice_anchor = (2.0 * surface.anchor()).to_array().map(all);
        let [xx, yy, zz, xy, yz, zx] = surface.quadratic;
        let form = Form {
            squares: [all(xx), all(yy), all(zz)],
            mixed: [all(0.5 * xy), all(0.5 * yz), all(0.5 * zx)],
        };
        let g = (sign * surface.linear).to_array().map(all);
        // Areas are taken doubled, and carry the gradient's length.
        let limit = all(4.0 * least_area * least_area);
        let (third, sign, half) = (all(sign / 3.0), all(sign), all(0.5));
        let (thin, zero) = (all(THIN), all(0.0));
        let odd_out = S::as_mut_simd_u64s(&mut self.odd).0.iter_mut();
        let bad_out = S::as_mut_simd_u64s(&mut self.bad).0.iter_mut();
        for (i, (odd_out, bad_out)) in odd_out.zip(bad_out).enumerate().take(vectors) {
            let mut corners = [[zero; 3]; 4];
            for (corner, lanes) in corners.iter_mut().zip(&self.corners) {
                for (coordinate, lanes) in corner.iter_mut().zip(lanes) {
                    *coordinate = Reals::new(simd, S::as_simd_f64s(lanes).0[i]);
                }
            }
            let [p, q, r, s] = corners;
            let (even, odd, side) = (minus(r, p), minus(s, q), minus(q, p));
            // The vectors of the doubled areas on both sides of the diagonals.
            let (pqr, qsp, both) = (cross(side, even), cross(side, odd), cross(even, odd));
            let (prs, qrs) = (minus(both, pqr), minus(both, qsp));
            // The outward gradient in the middle of the quad, the areas seen along
            // those in the middles of the triangles, and how far f is from zero in
            // the middle of each diagonal: its ends lie on the surface, so that is
            // a quarter of the quadratic form along it.
            let (normal, [pqr, prs, qrs, qsp], [even_miss, odd_miss]) = if PLANE {
                (g, [pqr, prs, qrs, qsp].map(|area| dot(area, g)), [zero; 2])
            } else {
                let (mut middle, mut apart) = ([zero; 3], [zero; 3]);
                for axis in 0..3 {
                    let (pr, qs) = (p[axis] + r[axis], q[axis] + s[axis]);
                    middle[axis] = half * (pr + qs) - twice_anchor[axis];
                    apart[axis] = half * (pr - qs);
                }
                let normal = plus(g, times(sign, form.times(middle)));
                // The gradient is linear: from the middle of the quad to that of
                // p q r, say, it changes by a third of the form times the middle of
                // p r less that of q s less s - q.
                let (even_bend, odd_bend) = (form.times(even), form.times(odd));
                let [apart, even_part, odd_part] =
                    [form.times(apart), even_bend, odd_bend].map(|bend| times(third, bend));
                let (at_even, at_odd) = (plus(normal, apart), minus(normal, apart));
                let areas = [
                    dot(pqr, minus(at_even, odd_part)),
                    dot(prs, plus(at_even, odd_part)),
                    dot(qrs, plus(at_odd, even_part)),
                    dot(qsp, minus(at_odd, even_part)),
                ];
                let misses = [dot(even_bend, even).abs(), dot(odd_bend, odd).abs()];
                (normal, areas, misses)
            };
            let (least_even, least_odd) = (pqr.or_less(prs), qrs.or_less(qsp));
            let odd_is_better = if PLANE {
                least_even.is_below(least_odd)
            } else {
                odd_miss.is_below(even_miss)
            };
            // A fold, or an ear: three vertices of an edge that bends, whose
            // triangle stands across the surface.
            let even_is_thin = least_even.is_at_most(thin * least_odd);
            let odd_is_thin = least_odd.is_at_most(thin * least_even);
            let is_odd = (odd_is_better | even_is_thin) & !odd_is_thin;
            let least = is_odd.select(least_odd, least_even);
            let is_small = (least * least).is_at_most(limit * dot(normal, normal));
            *odd_out = is_odd.ones();
            *bad_out = (least.is_at_most(zero) | is_small).ones();
        }
    }

    /// Turns the quads to be cut along b-d, so that they start with b instead
    /// of a: all are to be cut along their first diagonal.
    #[inline(always)]
    pub fn turn(&mut self) {
        let [a, b, c, d] = &mut self.vertices;
        // Without a branch: which they are follows no pattern.
        for lane in 0..LANES {
            let odd = (self.odd[lane] as u32).wrapping_neg();
            let next = |first: u32, second: u32| first ^ (first ^ second) & odd;
            let quad = [a[lane], b[lane], c[lane], d[lane]];
            a[lane] = next(quad[0], quad[1]);
            b[lane] = next(quad[1], quad[2]);
            c[lane] = next(quad[2], quad[3]);
            d[lane] = next(quad[3], quad[0]);
        }
    }

    /// The triangles of a quad that was turned.
    #[inline(always)]
    pub fn triangles(&self, lane: usize) -> [[u32; 3]; 2] {
        let [a, b, c, d] = &self.vertices;
        let (a, b, c, d) = (a[lane], b[lane], c[lane], d[lane]);
        [[a, b, c], [a, c, d]]
    }
}

/// A quadratic form in every lane.
#[derive(Clone, Copy)]
struct Form<S: Simd> {
    /// The coefficients of x², y², z²,
    squares: Vectors<S>,
    /// and half of those of xy, yz, zx.
    mixed: Vectors<S>,
}

impl<S: Simd> Form<S> {
    /// Its matrix times a vector. Not a closure: those are not compiled for the
    /// vectors at hand.
    #[inline(always)]
    fn times(&self, [x, y, z]: Vectors<S>) -> Vectors<S> {
        let [xx, yy, zz] = self.squares;
        let [xy, yz, zx] = self.mixed;
        [
            xx * x + (xy * y + zx * z),
            yy * y + (yz * z + xy * x),
            zz * z + (zx * x + yz * y),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Program;
    use crate::random::Random;
    use crate::solid::Solid;
    use crate::surface::solve;

    /// Whether a quad is to be cut along its odd diagonal, and whether that
    /// leaves a bad triangle; `None` where rounding may decide.
    fn plain(
        corners: [DVec3; 4],
        surface: &Surface,
        sign: f64,
        least_area: f64,
    ) -> Option<(bool, bool)> {
        let [p, q, r, s] = corners;
        let normal = surface.gradient(0.25 * (p + q + r + s));
        let area = |a: DVec3, b: DVec3, c: DVec3| {
            let outward = sign * surface.gradient((a + b + c) / 3.0);
            (b - a).cross(c - a).dot(outward)
        };
        let even = area(p, q, r).min(area(p, r, s));
        let odd = area(q, r, s).min(area(q, s, p));
        let (even_miss, odd_miss) = (
            surface.value(0.5 * (p + r)).abs(),
            surface.value(0.5 * (q + s)).abs(),
        );
        let odd_is_better = if surface.is_plane() {
            even < odd
        } else {
            odd_miss < even_miss
        };
        let is_odd = (odd_is_better || even <= THIN * odd) && odd > THIN * even;
        let least = if is_odd { odd } else { even };
        let limit = 2.0 * least_area * normal.length();
        let scale = (r - p).length() * (s - q).length() * normal.length();
        let ties = [
            even - odd,
            even - THIN * odd,
            odd - THIN * even,
            least,
            least - limit,
        ];
        let near = |tie: &f64| tie.abs() < 1e-9 * scale;
        let alike = (even_miss - odd_miss).abs() < 1e-9 * (even_miss + odd_miss);
        let unclear = ties.iter().any(near) || (alike && !surface.is_plane());
        (!unclear).then_some((is_odd, least <= limit))
    }

    #[test]
    fn many_quads_are_judged_as_each_would_be() {
        let solid = Solid::sphere(1.0)
            & Solid::ellipsoid([0.8, 1.2, 1.0]).rotate_xyz(0.3, 0.5, 0.7)
            & Solid::infinite_cylinder(0.9).rotate_x(0.4)
            & Solid::half_space([0.3, -0.2, 1.0], 0.1);
        let program = Program::lower(&solid).expect("valid");
        let mut random = Random(3);
        let (mut odd, mut bad, mut clear) = (0, 0, 0);
        for surface in program.surfaces() {
            for round in 0..200 {
                let reversed = round % 2 == 1;
                let sign = if reversed { -1.0 } else { 1.0 };
                let mut point = || DVec3::from_array([(); 3].map(|()| 2.0 * random.unit() - 1.0));
                let mut positions = Vec::new();
                let mut quads = Quads::default();
                let onto = |start| solve::common_point(&[surface], start, 1.0).point;
                for lane in 0..LANES {
                    let middle = onto(point());
                    let (u, v) = surface.gradient(middle).normalize().any_orthonormal_pair();
                    // Counterclockwise from outside, moved about so far that
                    // some fold over.
                    for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                        let off = 0.05 * (a * u + sign * b * v) + 0.05 * point();
                        positions.push(onto(middle + off));
                    }
                    let corner = |i: usize| Corner {
                        point: positions[4 * lane + i],
                        vertex: (4 * lane + i) as u32,
                    };
                    let corners = [0, 1, 2, 3].map(corner);
                    quads.set(lane, corners.each_ref());
                }
                let least_area = 1e-4;
                quads.judge(
                    pulp::Scalar,
                    SurfaceSide { surface, reversed },
                    least_area,
                    LANES,
                );
                for lane in 0..LANES {
                    let corners = [0, 1, 2, 3].map(|i| positions[4 * lane + i]);
                    let Some(expected) = plain(corners, surface, sign, least_area) else {
                        continue;
                    };
                    let found = (quads.odd[lane] == 1, quads.bad[lane] == 1);
                    assert_eq!(found, expected, "{corners:?} on {surface}");
                    clear += 1;
                    odd += usize::from(found.0);
                    bad += usize::from(found.1);
                }
            }
        }
        assert!(clear > 20_000, "{clear}");
        assert!(odd > 5000 && bad > 100, "{odd} odd, {bad} bad of {clear}");
    }
}
