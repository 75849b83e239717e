//! Where two surfaces touch: their gradients are parallel at a common point.
//!
//! With ∇f2 = λ ∇f1 at a common point p of two quadrics, h = f2 - λ f1 has
//! neither value nor gradient there, so everywhere h(x) = ½ (x - p)ᵀ M (x - p)
//! with M = ∇²f2 - λ ∇²f1. What M is decides how the surfaces touch, in all of
//! space: a semidefinite M means that h never changes its sign, so of the four
//! combinations of sides one is impossible and the surfaces do not cross.

use glam::{DMat3, DVec3};

use crate::numeric::eigen_symmetric;
use crate::numeric::tolerance::{CANCELLED, SAME_VALUE};
use crate::program::Surface;
use crate::surface::solve;

/// How two surfaces touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Touch {
    /// They never cross: along a curve or in a point they share a tangent.
    Nested,
    /// Their two branches of intersection cross at this point.
    Node(DVec3),
}

/// How the two surfaces touch near `start`, if they do and it can be told.
pub(super) fn touch(
    first: &Surface,
    second: &Surface,
    start: DVec3,
    reach: f64,
    tolerance: f64,
) -> Option<Touch> {
    let (point, factor) = tangency(first, second, start, reach, tolerance)?;
    let matrix: [f64; 6] =
        std::array::from_fn(|i| second.quadratic[i] - factor * first.quadratic[i]);
    let (values, _) = eigen_symmetric(matrix);
    let scale = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let positive = values.iter().any(|&v| v > SAME_VALUE * scale);
    let negative = values.iter().any(|&v| v < -SAME_VALUE * scale);
    if !(positive && negative) {
        return Some(Touch::Nested);
    }
    // On the common tangent plane the form decides: both signs make two
    // branches that cross.
    let normal = first.gradient(point).normalize();
    let u = normal.any_orthonormal_vector();
    let v = normal.cross(u);
    let [xx, yy, zz, xy, yz, zx] = matrix;
    let m = DMat3::from_cols(
        DVec3::new(xx, 0.5 * xy, 0.5 * zx),
        DVec3::new(0.5 * xy, yy, 0.5 * yz),
        DVec3::new(0.5 * zx, 0.5 * yz, zz),
    );
    let (uu, uv, vv) = (u.dot(m * u), u.dot(m * v), v.dot(m * v));
    let determinant = uu * vv - uv * uv;
    (determinant < -SAME_VALUE * scale * scale).then_some(Touch::Node(point))
}

/// A common point with parallel gradients, and their ratio: Gauss and
/// Newton's method on f1 = f2 = 0, ∇f2 = λ ∇f1 in the unknowns p and λ.
fn tangency(
    first: &Surface,
    second: &Surface,
    start: DVec3,
    reach: f64,
    tolerance: f64,
) -> Option<(DVec3, f64)> {
    const STEPS: usize = 20;
    let mut point = solve::common_point(&[first, second], start, reach).point;
    // Both with unit gradients there, and gradients as angles over the reach.
    let (g1, g2) = (first.gradient(point), second.gradient(point));
    let (s1, s2) = (g1.length().recip(), g2.length().recip());
    if !(s1.is_finite() && s2.is_finite()) {
        return None;
    }
    let mut factor = (g1 * s1).dot(g2 * s2).signum();
    let hessian = |q: [f64; 6]| {
        let [xx, yy, zz, xy, yz, zx] = q;
        [
            DVec3::new(2.0 * xx, xy, zx),
            DVec3::new(xy, 2.0 * yy, yz),
            DVec3::new(zx, yz, 2.0 * zz),
        ]
    };
    let (h1, h2) = (hessian(first.quadratic), hessian(second.quadratic));
    for _ in 0..STEPS {
        let (g1, g2) = (first.gradient(point) * s1, second.gradient(point) * s2);
        let (f1, f2) = (first.value(point) * s1, second.value(point) * s2);
        let turn = (g2 - factor * g1) * reach;
        if (point - start).length() > 4.0 * reach {
            return None;
        }
        if f1.abs() <= tolerance && f2.abs() <= tolerance && turn.length() <= CANCELLED * reach {
            return Some((point, factor * s1 / s2));
        }
        let mut rows = [
            (g1, 0.0, -f1),
            (g2, 0.0, -f2),
            (DVec3::ZERO, 0.0, 0.0),
            (DVec3::ZERO, 0.0, 0.0),
            (DVec3::ZERO, 0.0, 0.0),
        ];
        for k in 0..3 {
            rows[2 + k] = (
                (h2[k] * s2 - factor * h1[k] * s1) * reach,
                -g1[k] * reach,
                -turn[k],
            );
        }
        let [x, y, z, l] = least_squares(&rows)?;
        let step = DVec3::new(x, y, z);
        let limit = (reach / step.length()).min(1.0);
        point += limit * step;
        factor += limit * l;
    }
    None
}

/// The least-squares solution of Σ (a · x + b l - r)² with a little weight on
/// small steps, which picks one where many are as good: Cholesky on the normal
/// equations.
fn least_squares(rows: &[(DVec3, f64, f64)]) -> Option<[f64; 4]> {
    let mut matrix = [[0.0; 4]; 4];
    let mut right = [0.0; 4];
    for &(a, b, r) in rows {
        let row = [a.x, a.y, a.z, b];
        for i in 0..4 {
            right[i] += row[i] * r;
            for j in 0..4 {
                matrix[i][j] += row[i] * row[j];
            }
        }
    }
    let trace: f64 = (0..4).map(|i| matrix[i][i]).sum();
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] += 1e-13 * trace;
    }
    for i in 0..4 {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            let rest = matrix[i][j] - sum;
            if i == j {
                if rest.is_nan() || rest <= 0.0 {
                    return None;
                }
                matrix[i][i] = rest.sqrt();
            } else {
                matrix[i][j] = rest / matrix[j][j];
            }
        }
    }
    for i in 0..4 {
        let sum: f64 = (0..i).map(|k| matrix[i][k] * right[k]).sum();
        right[i] = (right[i] - sum) / matrix[i][i];
    }
    for i in (0..4).rev() {
        let sum: f64 = (i + 1..4).map(|k| matrix[k][i] * right[k]).sum();
        right[i] = (right[i] - sum) / matrix[i][i];
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Program;
    use crate::solid::Solid;

    fn surfaces(solid: &Solid) -> Vec<Surface> {
        let turned = solid.clone().rotate_x(0.3).rotate_y(0.5).rotate_z(0.7);
        Program::lower(&turned).expect("valid").surfaces().to_vec()
    }

    #[test]
    fn touching_surfaces_are_told_apart() {
        let start = |p: [f64; 3]| {
            let turn = DMat3::from_rotation_z(0.7)
                * DMat3::from_rotation_y(0.5)
                * DMat3::from_rotation_x(0.3);
            turn * DVec3::from(p)
        };
        // A ball in a tube of its radius, along a circle.
        let tube = Solid::infinite_cylinder(1.0);
        let all = surfaces(&(tube.clone() | Solid::sphere(1.0).translate([0.0, 0.0, 0.3])));
        let found = touch(&all[0], &all[1], start([0.9, 0.1, 0.4]), 0.3, 1e-12);
        assert_eq!(found, Some(Touch::Nested));
        // A plane on the tube.
        let plane = Solid::half_space([1.0, 0.0, 0.0], 1.0);
        let all = surfaces(&(tube.clone() & plane));
        let found = touch(&all[0], &all[1], start([0.9, 0.1, 0.4]), 0.3, 1e-12);
        assert_eq!(found, Some(Touch::Nested));
        // Balls side by side.
        let all = surfaces(&(Solid::sphere(1.0) | Solid::sphere(0.5).translate([1.5, 0.0, 0.0])));
        let found = touch(&all[0], &all[1], start([0.95, 0.1, 0.05]), 0.3, 1e-12);
        assert_eq!(found, Some(Touch::Nested));
        // Tubes of one radius through each other.
        let all = surfaces(&(tube.clone() | tube.clone().rotate_x(std::f64::consts::FRAC_PI_2)));
        let found = touch(&all[0], &all[1], start([0.95, 0.1, 0.05]), 0.3, 1e-12);
        let Some(Touch::Node(point)) = found else {
            panic!("{found:?}");
        };
        assert!((point - start([1.0, 0.0, 0.0])).length() < 1e-11, "{point}");
        // Tubes that cross at an angle, and a ball that misses a plane.
        let all = surfaces(&(tube | Solid::sphere(1.2)));
        assert_eq!(
            touch(&all[0], &all[1], start([0.9, 0.1, 0.6]), 0.3, 1e-12),
            None
        );
        let plane = Solid::half_space([1.0, 0.0, 0.0], 1.1);
        let all = surfaces(&(Solid::sphere(1.0) & plane));
        assert_eq!(
            touch(&all[0], &all[1], start([1.0, 0.1, 0.0]), 0.3, 1e-12),
            None
        );
    }
}
