//! Newton's method onto one, two, three or more surfaces at once.
//!
//! The step is the shortest vector that satisfies all linearised constraints
//! (Gauss–Newton with the pseudo-inverse where constraints are dependent), so
//! that on one surface it runs along the gradient, on two it stays in their
//! common normal plane, and on three it is Newton's method proper.

use glam::{DMat3, DVec3};
use pulp::Simd;

use super::Surface;
use crate::numeric::lanes::{self, Reals};
use crate::numeric::tolerance::{DEPENDENT_IN_STEP, SAME_VALUE, TOUCHING};

/// How the search for a common point ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solution {
    pub point: DVec3,
    /// The largest distance to any of the surfaces, to first order.
    pub residual: f64,
}

/// f/|∇f| and the unit gradient.
#[inline]
fn distance(surface: &Surface, point: DVec3) -> (f64, DVec3) {
    by_value(surface, point, surface.value(point))
}

/// The same without the rounding of f.
fn precise_distance(surface: &Surface, point: DVec3) -> (f64, DVec3) {
    by_value(surface, point, surface.precise_value(point))
}

#[inline]
fn by_value(surface: &Surface, point: DVec3, value: f64) -> (f64, DVec3) {
    if surface.is_plane() {
        return (value, surface.linear);
    }
    let gradient = surface.gradient(point);
    let length = gradient.length();
    if length > 0.0 {
        (value / length, gradient / length)
    } else {
        // An apex: there is no direction to go.
        (value.abs().sqrt(), DVec3::ZERO)
    }
}

/// The distance of `point` to the farthest of the surfaces, to first order.
pub(crate) fn residual<'a>(surfaces: impl Iterator<Item = &'a Surface>, point: DVec3) -> f64 {
    surfaces
        .map(|surface| distance(surface, point).0.abs())
        .fold(0.0, f64::max)
}

/// How far off rounding lets a point of a surface seem.
#[inline]
pub(crate) fn blur(surface: &Surface, point: DVec3) -> f64 {
    surface.rounding_of_value(point) / surface.gradient(point).length()
}

/// From how far a surface is not told to be off a curve of two others at a point of that: what that
/// point is off its own surfaces, and rounding lets it seem to be off any of the three.
pub(crate) fn known_to(own: [&Surface; 2], third: &Surface, point: DVec3) -> f64 {
    let blurred = own.iter().chain([&third]).map(|s| blur(s, point));
    blurred.fold(residual(own.into_iter(), point), f64::max)
}

/// The same as [`common_point`], and where rounding moves one of the surfaces by more
/// than `blur` nearer to them all than that.
pub(crate) fn sharp_common_point(
    surfaces: &[&Surface],
    start: DVec3,
    reach: f64,
    blur: f64,
) -> Solution {
    /// Each takes off more than half of the digits that the one before left.
    const STEPS: usize = 3;
    let mut found = common_point(surfaces, start, reach);
    let is_sharp = |surface: &&Surface| {
        let blurred = self::blur(surface, found.point);
        blurred.is_nan() || blurred <= blur
    };
    if surfaces.iter().all(is_sharp) {
        return found;
    }
    for _ in 0..STEPS {
        let (step, residual) = step_by(surfaces, found.point, precise_distance);
        found.residual = residual;
        // Nothing, or too far to be what rounding did.
        let square = step.length_squared();
        if square == 0.0 || square.is_nan() || square > reach * reach {
            break;
        }
        found.point += step;
    }
    let distances = surfaces.iter().map(|s| precise_distance(s, found.point).0);
    found.residual = distances.fold(0.0, |most, off| most.max(off.abs()));
    found
}

/// Looks for a point on all of the surfaces near `start`, never taking a step
/// longer than `reach`. Convergence is quadratic where the surfaces cross,
/// linear where they touch.
pub(crate) fn common_point(surfaces: &[&Surface], start: DVec3, reach: f64) -> Solution {
    const MOST_STEPS: usize = 60;
    /// A step whose square is nothing beside `reach` is the last.
    const LAST: f64 = 1e-8;
    let mut point = start;
    let mut best = Solution {
        point,
        residual: f64::INFINITY,
    };
    let mut stalled = 0;
    for _ in 0..MOST_STEPS {
        let (step, residual) = step(surfaces, point);
        let square = step.length_squared();
        if residual < best.residual {
            // Less than a halving in a step: near the end, or not converging.
            stalled = if residual > 0.5 * best.residual {
                stalled + 1
            } else {
                0
            };
            best = Solution { point, residual };
        } else {
            stalled += 1;
        }
        if !square.is_finite() {
            break;
        }
        if square <= (LAST * reach) * (LAST * reach) {
            let point = point + step;
            let after = || self::residual(surfaces.iter().copied(), point);
            let small = residual <= LAST * LAST * reach;
            let residual = if small { residual } else { after() };
            return if residual <= best.residual {
                Solution { point, residual }
            } else {
                best
            };
        }
        if stalled > 3 {
            break;
        }
        let limited = if square > reach * reach {
            step * (reach / square.sqrt())
        } else {
            step
        };
        let next = point + limited;
        if next == point {
            break;
        }
        point = next;
    }
    best
}

/// The shortest step onto all linearised surfaces, and the largest distance
/// before it.
pub(crate) fn step(surfaces: &[&Surface], point: DVec3) -> (DVec3, f64) {
    step_by(surfaces, point, distance)
}

#[inline(always)]
fn step_by(
    surfaces: &[&Surface],
    point: DVec3,
    distance: impl Fn(&Surface, DVec3) -> (f64, DVec3),
) -> (DVec3, f64) {
    match surfaces {
        [] => (DVec3::ZERO, 0.0),
        [surface] => {
            let (r, n) = distance(surface, point);
            (-r * n, r.abs())
        }
        [first, second] => {
            let (r1, n1) = distance(first, point);
            let (r2, n2) = distance(second, point);
            let residual = r1.abs().max(r2.abs());
            // In the plane of the normals: along n1, and along what of n2 is
            // across it.
            let across = n2 - n1 * n1.dot(n2);
            let square = across.length_squared();
            if square < DEPENDENT_IN_STEP * DEPENDENT_IN_STEP {
                return (-0.5 * (r1 * n1 + r2 * n2), residual);
            }
            let along_across = (-r2 + r1 * n1.dot(n2)) / square;
            (-r1 * n1 + along_across * across, residual)
        }
        [first, second, third] => {
            let (r1, n1) = distance(first, point);
            let (r2, n2) = distance(second, point);
            let (r3, n3) = distance(third, point);
            let residual = r1.abs().max(r2.abs()).max(r3.abs());
            let (c23, c31, c12) = (n2.cross(n3), n3.cross(n1), n1.cross(n2));
            let determinant = n1.dot(c23);
            if determinant.abs() < TOUCHING {
                let pairs = [(r1, n1), (r2, n2), (r3, n3)];
                return (least_squares_step(&pairs), residual);
            }
            (-(r1 * c23 + r2 * c31 + r3 * c12) / determinant, residual)
        }
        _ => {
            let pairs: Vec<(f64, DVec3)> = surfaces.iter().map(|s| distance(s, point)).collect();
            let residual = pairs.iter().fold(0.0f64, |m, (r, _)| m.max(r.abs()));
            (least_squares_step(&pairs), residual)
        }
    }
}

/// The shortest least-squares solution of n_i · step = -r_i through the
/// eigenvectors of Σ n nᵀ; directions in which no constraint has a say are
/// left alone.
fn least_squares_step(pairs: &[(f64, DVec3)]) -> DVec3 {
    let mut normal_matrix = DMat3::ZERO;
    let mut right = DVec3::ZERO;
    for &(r, n) in pairs {
        normal_matrix += DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        right -= r * n;
    }
    let m = normal_matrix;
    let (values, vectors) = crate::numeric::eigen_symmetric([
        m.x_axis.x,
        m.y_axis.y,
        m.z_axis.z,
        2.0 * m.x_axis.y,
        2.0 * m.y_axis.z,
        2.0 * m.z_axis.x,
    ]);
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let axes = [vectors.x_axis, vectors.y_axis, vectors.z_axis];
    let mut step = DVec3::ZERO;
    for (value, axis) in values.into_iter().zip(axes) {
        if value > SAME_VALUE * largest {
            step += right.dot(axis) / value * axis;
        }
    }
    step
}

/// Points are handled in lanes: so many at once, or a share of it. Tunes speed only.
pub(crate) const LANES: usize = 8;

/// Moves many points onto one surface, along its gradient: Newton's method in
/// lanes, until no point moves by more than `reach`, a length whose square is
/// nothing. None if that does not come about in a few steps, else a length
/// that no point has moved by more than. The same operations in the same order
/// for every point, whatever the machine's vector width. Points beyond the
/// last multiple of [`LANES`] may stay where they are.
#[inline(always)]
pub(crate) fn project_all<S: Simd>(
    simd: S,
    surface: &Surface,
    reach: f64,
    [x, y, z]: [&mut [f64]; 3],
) -> Option<f64> {
    let anchor = surface.anchor();
    // About the anchor until it is over.
    let shift = |values: &mut [f64], by: f64| values.iter_mut().for_each(|v| *v += by);
    shift(x, -anchor.x);
    shift(y, -anchor.y);
    shift(z, -anchor.z);
    let has_cross_terms = surface.quadratic[3..] != [0.0; 3];
    let mut converged = None;
    let mut way = 0.0;
    for _ in 0..5 {
        let points = [&mut *x, &mut *y, &mut *z].map(|values| S::as_mut_simd_f64s(values).0);
        let square = if surface.is_plane() {
            plane_step(simd, surface, points)
        } else if has_cross_terms {
            newton_step::<true, S>(simd, surface, points)
        } else {
            newton_step::<false, S>(simd, surface, points)
        };
        way += square.sqrt();
        if square <= reach * reach {
            converged = Some(way);
            break;
        }
    }
    shift(x, anchor.x);
    shift(y, anchor.y);
    shift(z, anchor.z);
    converged
}

/// One step of [`project_all`] onto a plane; the square of the longest way.
#[inline(always)]
fn plane_step<S: Simd>(simd: S, surface: &Surface, [x, y, z]: [&mut [S::f64s]; 3]) -> f64 {
    let g = surface.linear.to_array().map(|g| Reals::all(simd, g));
    let mut farthest = Reals::all(simd, 0.0);
    for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
        let point = [*x, *y, *z].map(|lanes| Reals::new(simd, lanes));
        let f = lanes::dot(g, point);
        *x = (point[0] - f * g[0]).lanes;
        *y = (point[1] - f * g[1]).lanes;
        *z = (point[2] - f * g[2]).lanes;
        farthest = farthest.or_more(f * f);
    }
    farthest.greatest()
}

/// One step of [`project_all`]; the square of the longest way.
#[inline(always)]
fn newton_step<const CROSS: bool, S: Simd>(
    simd: S,
    surface: &Surface,
    [x, y, z]: [&mut [S::f64s]; 3],
) -> f64 {
    let [xx, yy, zz, xy, yz, zx] = surface.quadratic;
    let squares = [xx, yy, zz].map(|q| Reals::all(simd, q));
    let [xy, yz, zx] = [xy, yz, zx].map(|q| Reals::all(simd, 0.5 * q));
    let g = surface.linear.to_array().map(|g| Reals::all(simd, g));
    let constant = Reals::all(simd, surface.constant);
    let two = Reals::all(simd, 2.0);
    let least = Reals::all(simd, f64::MIN_POSITIVE);
    let mut farthest = Reals::all(simd, 0.0);
    for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
        let d = [*x, *y, *z].map(|lanes| Reals::new(simd, lanes));
        // Half the gradient of the quadratic part, so that f needs no more
        // terms.
        let mut h = [squares[0] * d[0], squares[1] * d[1], squares[2] * d[2]];
        if CROSS {
            h[0] = h[0] + (xy * d[1] + zx * d[2]);
            h[1] = h[1] + (yz * d[2] + xy * d[0]);
            h[2] = h[2] + (zx * d[0] + yz * d[1]);
        }
        let f = lanes::dot([h[0] + g[0], h[1] + g[1], h[2] + g[2]], d) + constant;
        let gradient = [two * h[0] + g[0], two * h[1] + g[1], two * h[2] + g[2]];
        let square = lanes::dot(gradient, gradient);
        let t = f / (square + least);
        *x = (d[0] - t * gradient[0]).lanes;
        *y = (d[1] - t * gradient[1]).lanes;
        *z = (d[2] - t * gradient[2]).lanes;
        farthest = farthest.or_more(t * t * square);
    }
    farthest.greatest()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Program;
    use crate::random::Random;
    use crate::solid::Solid;

    #[test]
    fn many_points_go_where_each_would() {
        let mut random = Random(7);
        let mut moved = 0;
        for _ in 0..100 {
            let mut number = || 2.0 * random.unit() - 1.0;
            let solid = Solid::cuboid([0.9, 1.1, 1.3])
                & Solid::sphere(0.7)
                & Solid::ellipsoid([0.5, 0.8, 1.0])
                & Solid::infinite_cylinder(0.6);
            let placed = solid
                .rotate_xyz(3.0 * number(), 3.0 * number(), 3.0 * number())
                .translate([number(), number(), number()]);
            let program = Program::lower(&placed).expect("valid");
            for surface in program.surfaces() {
                let mut point = || DVec3::from_array([(); 3].map(|()| 2.0 * random.unit() - 1.0));
                // Within a cell of the surface, as crossings are.
                let mut starts = [(); 8].map(|()| {
                    let on_it = common_point(&[surface], point(), 1.0).point;
                    on_it + 0.05 * point()
                });
                starts[7] = starts[0];
                let mut lanes = [0, 1, 2].map(|axis| starts.map(|start| start[axis]));
                let points = lanes.each_mut().map(|values| &mut values[..]);
                let way = project_all(pulp::Scalar, surface, 1e-8, points);
                let way = way.expect("near the surface");
                for (lane, start) in starts.into_iter().enumerate() {
                    let end = DVec3::new(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
                    let alone = common_point(&[surface], start, 0.1).point;
                    assert!(end.distance(alone) < 1e-12, "{end}, alone {alone}");
                    assert!(
                        end.distance(start) <= way + 1e-12,
                        "{way} from {start} to {end}"
                    );
                    moved += usize::from(end.distance(start) > 1e-3);
                }
            }
        }
        assert!(moved > 1000, "{moved} moved");
    }
}
