//! How quads are cut into triangles: along the diagonal that is nearer to the
//! surface, many quads at a time.

use glam::DVec3;

use crate::program::Surface;

/// Quads handled together: so many that what is written coordinate by
/// coordinate has left the store buffer when it is read in whole vectors.
pub(super) const LANES: usize = 32;
/// A diagonal whose smaller triangle, seen along the normal, is no more than
/// this share of the other's is not taken.
const THIN: f64 = 0.125;
/// A whole number of vectors of whatever width.
const WHOLE: usize = 8;

/// A vertex and where it lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub point: DVec3,
    pub vertex: u32,
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

    /// Decides for the first `count` quads, whose corners lie on `surface`,
    /// along which diagonal to cut them, and whether a triangle of theirs is
    /// bad: folded over, or smaller than `least_area`. Whether any is.
    ///
    /// The diagonal whose midpoint is nearer to the surface wins, unless it
    /// leaves a fold or a sliver that the other does not; on a plane the one whose smaller triangle is
    /// larger. `reversed` says that the surface's gradient points into the
    /// solid.
    #[inline(always)]
    pub fn judge(
        &mut self,
        surface: &Surface,
        reversed: bool,
        least_area: f64,
        count: usize,
    ) -> bool {
        let sign = if reversed { -1.0 } else { 1.0 };
        let lanes = count.next_multiple_of(WHOLE).min(LANES);
        if surface.is_plane() {
            self.judge_on::<true>(surface, sign, least_area, lanes);
        } else {
            self.judge_on::<false>(surface, sign, least_area, lanes);
        }
        self.bad[..count].iter().fold(0, |any, bad| any | bad) != 0
    }

    #[inline(always)]
    fn judge_on<const PLANE: bool>(
        &mut self,
        surface: &Surface,
        sign: f64,
        least_area: f64,
        lanes: usize,
    ) {
        let anchor = surface.anchor();
        let [xx, yy, zz, xy, yz, zx] = surface.quadratic;
        let (xy, yz, zx) = (0.5 * xy, 0.5 * yz, 0.5 * zx);
        let g = sign * surface.linear;
        // Twice the matrix of the quadratic form, times a vector.
        let twice = |x: f64, y: f64, z: f64| {
            (
                xx * x + (xy * y + zx * z),
                yy * y + (yz * z + xy * x),
                zz * z + (zx * x + yz * y),
            )
        };
        // Areas are taken doubled, and carry the gradient's length.
        let limit = 4.0 * least_area * least_area;
        for lane in 0..lanes {
            let [p, q, r, s] = [0, 1, 2, 3].map(|corner| {
                let [x, y, z] = &self.corners[corner];
                (x[lane], y[lane], z[lane])
            });
            let minus = |a: (f64, f64, f64), b: (f64, f64, f64)| (a.0 - b.0, a.1 - b.1, a.2 - b.2);
            let dot = |a: (f64, f64, f64), b: (f64, f64, f64)| a.0 * b.0 + a.1 * b.1 + a.2 * b.2;
            let cross = |a: (f64, f64, f64), b: (f64, f64, f64)| {
                (
                    a.1 * b.2 - a.2 * b.1,
                    a.2 * b.0 - a.0 * b.2,
                    a.0 * b.1 - a.1 * b.0,
                )
            };
            let (even, odd, side) = (minus(r, p), minus(s, q), minus(q, p));
            // The outward gradient in the middle of the quad, and how far
            // f is from zero in the middle of each diagonal: its ends lie
            // on the surface, so that is a quarter of the quadratic form
            // along it.
            let (normal, even_miss, odd_miss) = if PLANE {
                ((g.x, g.y, g.z), 0.0, 0.0)
            } else {
                let middle = |p: f64, q: f64, r: f64, s: f64, anchor: f64| {
                    0.5 * ((p + r) + (q + s)) - 2.0 * anchor
                };
                let (hx, hy, hz) = twice(
                    middle(p.0, q.0, r.0, s.0, anchor.x),
                    middle(p.1, q.1, r.1, s.1, anchor.y),
                    middle(p.2, q.2, r.2, s.2, anchor.z),
                );
                (
                    (sign * hx + g.x, sign * hy + g.y, sign * hz + g.z),
                    dot(twice(even.0, even.1, even.2), even).abs(),
                    dot(twice(odd.0, odd.1, odd.2), odd).abs(),
                )
            };
            // Doubled signed areas, seen from outside, on both sides of
            // the diagonals: of p q r, p r s; of q r s, q s p.
            let diagonals = dot(cross(even, odd), normal);
            let pqr = dot(cross(side, even), normal);
            let qsp = dot(cross(side, odd), normal);
            let (prs, qrs) = (diagonals - pqr, diagonals - qsp);
            let least_even = if pqr < prs { pqr } else { prs };
            let least_odd = if qrs < qsp { qrs } else { qsp };
            let odd_is_better = if PLANE {
                least_even < least_odd
            } else {
                odd_miss < even_miss
            };
            // A fold, or an ear: three vertices of an edge that bends, whose
            // triangle stands across the surface.
            let even_is_thin = least_even <= THIN * least_odd;
            let odd_is_thin = least_odd <= THIN * least_even;
            // Not short-circuited: that would be a branch in every lane.
            let is_odd = (odd_is_better | even_is_thin) & !odd_is_thin;
            let least = if is_odd { least_odd } else { least_even };
            let is_bad = (least <= 0.0) | (least * least <= limit * dot(normal, normal));
            self.odd[lane] = u64::from(is_odd);
            self.bad[lane] = u64::from(is_bad);
        }
    }

    /// The triangles of as many quads as there is room for, two each.
    #[inline(always)]
    pub fn cut(&mut self, triangles: &mut [[u32; 3]]) {
        let [a, b, c, d] = &mut self.vertices;
        // A quad to be cut along b-d starts with b instead of a. Without a
        // branch: which it is follows no pattern.
        for lane in 0..LANES {
            let odd = (self.odd[lane] as u32).wrapping_neg();
            let next = |first: u32, second: u32| first ^ (first ^ second) & odd;
            let quad = [a[lane], b[lane], c[lane], d[lane]];
            a[lane] = next(quad[0], quad[1]);
            b[lane] = next(quad[1], quad[2]);
            c[lane] = next(quad[2], quad[3]);
            d[lane] = next(quad[3], quad[0]);
        }
        for (lane, pair) in triangles.chunks_exact_mut(2).enumerate().take(LANES) {
            let (a, b, c, d) = (a[lane], b[lane], c[lane], d[lane]);
            pair[0] = [a, b, c];
            pair[1] = [a, c, d];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::net::solve;
    use crate::program::Program;
    use crate::random::Random;
    use crate::solid::Solid;

    /// Whether a quad is to be cut along its odd diagonal, and whether that
    /// leaves a bad triangle; `None` where rounding may decide.
    fn plain(
        corners: [DVec3; 4],
        surface: &Surface,
        sign: f64,
        least_area: f64,
    ) -> Option<(bool, bool)> {
        let [p, q, r, s] = corners;
        let normal = sign * surface.gradient(0.25 * (p + q + r + s));
        let area = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).dot(normal);
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
                quads.judge(surface, reversed, least_area, LANES);
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
