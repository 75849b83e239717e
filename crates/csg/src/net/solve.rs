//! Newton's method onto one, two, three or more surfaces at once.
//!
//! The step is the shortest vector that satisfies all linearised constraints
//! (Gauss–Newton with the pseudo-inverse where constraints are dependent), so
//! that on one surface it runs along the gradient, on two it stays in their
//! common normal plane, and on three it is Newton's method proper.

use glam::{DMat3, DVec3};

use crate::program::Surface;

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
    let value = surface.value(point);
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
pub(super) fn step(surfaces: &[&Surface], point: DVec3) -> (DVec3, f64) {
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
            if square < NEARLY_DEPENDENT {
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
            if determinant.abs() < 1e-6 {
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

/// Squared sine of the angle between two normals below which they count as
/// parallel: Newton's step would leave the neighbourhood.
const NEARLY_DEPENDENT: f64 = 1e-16;

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
    let (values, vectors) = crate::program::eigen_symmetric([
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
        if value > 1e-10 * largest {
            step += right.dot(axis) / value * axis;
        }
    }
    step
}

/// Moves many points onto one surface, along its gradient: Newton's method in
/// lanes, until no point moves by more than `reach`, a length whose square is
/// nothing. None if that does not come about in a few steps, else a length
/// that no point has moved by more than. The same operations in the same order
/// for every point, whatever the machine's vector width.
#[inline(always)]
pub(super) fn project_all(
    surface: &Surface,
    reach: f64,
    x: &mut [f64],
    y: &mut [f64],
    z: &mut [f64],
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
        let square = if surface.is_plane() {
            plane_step(surface, x, y, z)
        } else if has_cross_terms {
            newton_step::<true>(surface, x, y, z)
        } else {
            newton_step::<false>(surface, x, y, z)
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

/// Longest ways kept apart, so that none waits for another.
const LANES: usize = 8;

/// One step of [`project_all`] onto a plane; the square of the longest way.
#[inline(always)]
fn plane_step(surface: &Surface, x: &mut [f64], y: &mut [f64], z: &mut [f64]) -> f64 {
    let g = surface.linear;
    let mut farthest = [0.0f64; LANES];
    let xs = x.chunks_mut(LANES);
    for ((x, y), z) in xs.zip(y.chunks_mut(LANES)).zip(z.chunks_mut(LANES)) {
        for (((x, y), z), farthest) in x.iter_mut().zip(y).zip(z).zip(&mut farthest) {
            let f = g.x * *x + g.y * *y + g.z * *z;
            *x -= f * g.x;
            *y -= f * g.y;
            *z -= f * g.z;
            let moved = f * f;
            *farthest = if moved > *farthest { moved } else { *farthest };
        }
    }
    farthest.into_iter().fold(0.0, f64::max)
}

/// One step of [`project_all`]; the square of the longest way.
#[inline(always)]
fn newton_step<const CROSS: bool>(
    surface: &Surface,
    x: &mut [f64],
    y: &mut [f64],
    z: &mut [f64],
) -> f64 {
    let [xx, yy, zz, xy, yz, zx] = surface.quadratic;
    let (xy, yz, zx) = (0.5 * xy, 0.5 * yz, 0.5 * zx);
    let (g, c) = (surface.linear, surface.constant);
    let mut farthest = [0.0f64; LANES];
    let xs = x.chunks_mut(LANES);
    for ((x, y), z) in xs.zip(y.chunks_mut(LANES)).zip(z.chunks_mut(LANES)) {
        for (((x, y), z), farthest) in x.iter_mut().zip(y).zip(z).zip(&mut farthest) {
            let (dx, dy, dz) = (*x, *y, *z);
            // Half the gradient of the quadratic part, so that f needs no
            // more terms.
            let (mut hx, mut hy, mut hz) = (xx * dx, yy * dy, zz * dz);
            if CROSS {
                hx += xy * dy + zx * dz;
                hy += yz * dz + xy * dx;
                hz += zx * dx + yz * dy;
            }
            let f = (hx + g.x) * dx + (hy + g.y) * dy + (hz + g.z) * dz + c;
            let (gx, gy, gz) = (2.0 * hx + g.x, 2.0 * hy + g.y, 2.0 * hz + g.z);
            let square = gx * gx + gy * gy + gz * gz;
            let t = f / (square + f64::MIN_POSITIVE);
            *x = dx - t * gx;
            *y = dy - t * gy;
            *z = dz - t * gz;
            let moved = t * t * square;
            *farthest = if moved > *farthest { moved } else { *farthest };
        }
    }
    farthest.into_iter().fold(0.0, f64::max)
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
                let [x, y, z] = &mut lanes;
                let way = project_all(surface, 1e-8, x, y, z).expect("near the surface");
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
