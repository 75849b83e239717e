//! Projections: parallel, perspective, off axis, from a pinhole.

use super::{close, rows};
use glam::{DVec3, DVec4};
use raster::projection::{self, Window};
use raster::transform;

fn window() -> Window {
    Window {
        left: -1.0,
        right: 3.0,
        bottom: -2.0,
        top: 1.0,
        near: 2.0,
        far: 7.0,
    }
}

#[test]
fn orthographic_is_scaling_times_translation() {
    let w = window();
    let translation = rows([
        [1.0, 0.0, 0.0, -(3.0 + -1.0) / 2.0],
        [0.0, 1.0, 0.0, -(1.0 + -2.0) / 2.0],
        [0.0, 0.0, 1.0, (7.0 + 2.0) / 2.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    let scaling = rows([
        [2.0 / 4.0, 0.0, 0.0, 0.0],
        [0.0, 2.0 / 3.0, 0.0, 0.0],
        [0.0, 0.0, -2.0 / 5.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    assert!(close(projection::orthographic_translation(&w), translation));
    assert!(close(projection::box_scaling(&w), scaling));
    let product = rows([
        [0.5, 0.0, 0.0, -0.5],
        [0.0, 2.0 / 3.0, 0.0, 1.0 / 3.0],
        [0.0, 0.0, -0.4, -9.0 / 5.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    assert!(close(scaling * translation, product));
    assert!(close(projection::orthographic(&w), product));
}

#[test]
fn frustum_is_scaling_perspective_shear() {
    let w = window();
    let shear = rows([
        [1.0, 0.0, 2.0 / (2.0 * 2.0), 0.0],
        [0.0, 1.0, -1.0 / (2.0 * 2.0), 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    let perspective = rows([
        [2.0, 0.0, 0.0, 0.0],
        [0.0, 2.0, 0.0, 0.0],
        [0.0, 0.0, 9.0 / 2.0, 14.0],
        [0.0, 0.0, -1.0, 0.0],
    ]);
    let whole = rows([
        [2.0 * 2.0 / 4.0, 0.0, 2.0 / 4.0, 0.0],
        [0.0, 2.0 * 2.0 / 3.0, -1.0 / 3.0, 0.0],
        [0.0, 0.0, -9.0 / 5.0, -2.0 * 14.0 / 5.0],
        [0.0, 0.0, -1.0, 0.0],
    ]);
    assert!(close(projection::shear_to_axis(&w), shear));
    assert!(close(projection::frustum_to_box(2.0, 7.0), perspective));
    assert!(close(
        projection::box_scaling(&w) * perspective * shear,
        whole
    ));
    assert!(close(projection::frustum(&w), whole));
    // x* = -near x / z, y* = -near y / z, z* = -(far + near) / 2 - far near / z.
    for z in [-2.0, -3.5, -7.0] {
        let p = perspective.project_point3(DVec3::new(1.5, -0.5, z));
        let wanted = DVec3::new(-2.0 * 1.5 / z, 2.0 * 0.5 / z, -4.5 - 14.0 / z);
        assert!(p.abs_diff_eq(wanted, 1e-12), "{p}");
    }
    // Column 3, row 1 as some devices have it wrong: m[8] = (l + r) / (r - l).
    assert_eq!(transform::opengl_array(whole)[8], 0.5);
}

#[test]
fn symmetric_frustum_has_simple_rows() {
    let (n, f, r, t) = (2.0, 7.0, 1.25, 1.0);
    let printed = rows([
        [n / r, 0.0, 0.0, 0.0],
        [0.0, n / t, 0.0, 0.0],
        [0.0, 0.0, -(f + n) / (f - n), -2.0 * f * n / (f - n)],
        [0.0, 0.0, -1.0, 0.0],
    ]);
    let symmetric = Window {
        left: -r,
        right: r,
        bottom: -t,
        top: t,
        near: n,
        far: f,
    };
    assert!(close(projection::frustum(&symmetric), printed));
    assert!(close(
        projection::symmetric_frustum(2.0 * r, 2.0 * t, n, f),
        printed
    ));
    // From the field of view: top = near tan(fov / 2).
    let fov = 2.0 * (t / n).atan();
    assert!(close(projection::perspective(fov, r / t, n, f), printed));
}

#[test]
fn ninety_degrees_on_400_by_320() {
    let m = projection::perspective(90f64.to_radians(), 400.0 / 320.0, 2.0, 7.0);
    let printed = rows([
        [0.8, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, -1.8, -5.6],
        [0.0, 0.0, -1.0, 0.0],
    ]);
    assert!(close(m, printed), "{m}");
}

#[test]
fn perspective_with_h() {
    let h = 3.0;
    for p in [
        DVec3::new(1.0, 2.0, 0.0),
        DVec3::new(-2.0, 0.5, 4.0),
        DVec3::new(1.0, 1.0, 1e9),
    ] {
        let (x, y) = (h / (p.z + h) * p.x, h / (p.z + h) * p.y);
        for (matrix, z) in [
            (projection::one_point(h), p.z / (p.z + h)),
            (projection::perspective_depth(h), h * p.z / (p.z + h)),
            (
                projection::normalised_perspective_depth(h),
                (p.z - h) / (p.z + h),
            ),
        ] {
            let found = matrix.project_point3(p);
            assert!(found.abs_diff_eq(DVec3::new(x, y, z), 1e-9), "{found}");
        }
    }
    let printed = rows([
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0 / h, 1.0],
    ]);
    assert_eq!(projection::perspective_depth(h), printed);
    // x', y', z/h - 1, z/h + 1.
    let moved = projection::normalised_perspective_depth(h) * DVec4::new(1.0, 2.0, 6.0, 1.0);
    assert!(
        moved.abs_diff_eq(DVec4::new(1.0, 2.0, 1.0, 3.0), 1e-12),
        "{moved}"
    );
}

#[test]
fn pinhole_with_d() {
    let (d, p) = (2.0, DVec3::new(3.0, -1.5, 6.0));
    let moved = projection::pinhole(d) * p.extend(1.0);
    assert_eq!(moved.w, p.z / d);
    let seen = transform::cartesian(moved).unwrap();
    assert!(seen.abs_diff_eq(DVec3::new(d * 3.0 / 6.0, d * -1.5 / 6.0, d), 1e-12));
    // As row vectors: [x y z 1] times the printed matrix, w' = z.
    let printed = rows([
        [d, 0.0, 0.0, 0.0],
        [0.0, d, 0.0, 0.0],
        [0.0, 0.0, d, 1.0],
        [0.0, 0.0, 0.0, 0.0],
    ]);
    let as_rows = transform::for_row_vectors(projection::pinhole(d)) * d;
    assert_eq!(as_rows, printed);
    // A screen behind the pinhole turns the picture round.
    let behind = projection::pinhole(-d).project_point3(p);
    assert!(behind.abs_diff_eq(-DVec3::new(1.0, -0.5, d), 1e-12));
}
