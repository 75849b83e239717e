//! Projections against their defining properties, closed forms and glam.

use glam::{DMat4, DVec3, DVec4};
use proptest::prelude::*;
use raster::projection::{self, Window};

fn close(a: DVec3, b: DVec3) -> bool {
    (a - b).abs().max_element() < 1e-12 * (1.0 + b.abs().max_element())
}

fn close_matrix(a: DMat4, b: DMat4) -> bool {
    let scale = b
        .to_cols_array()
        .iter()
        .fold(1.0_f64, |m, v| m.max(v.abs()));
    a.to_cols_array()
        .iter()
        .zip(b.to_cols_array())
        .all(|(a, b)| (a - b).abs() < 1e-12 * scale)
}

#[test]
fn ninety_degrees_at_400_to_320() {
    let m = projection::perspective(90f64.to_radians(), 400.0 / 320.0, 2.0, 7.0);
    let scale = [m.x_axis.x, m.y_axis.y, m.z_axis.z, m.w_axis.z];
    for (got, expected) in scale.into_iter().zip([0.8, 1.0, -1.8, -5.6]) {
        assert!((got - expected).abs() < 1e-12, "{scale:?}");
    }
    assert_eq!(m.z_axis.w, -1.0);
}

fn window() -> impl Strategy<Value = Window> {
    (
        -5.0..5.0f64,
        0.1..5.0f64,
        -5.0..5.0f64,
        0.1..5.0f64,
        0.1..3.0f64,
        0.5..100.0f64,
    )
        .prop_map(|(left, width, bottom, height, near, depth)| Window {
            left,
            right: left + width,
            bottom,
            top: bottom + height,
            near,
            far: near + depth,
        })
}

/// The eight corners of the clip cube, and what fraction of the way from low
/// to high, near to far each is.
fn corners() -> impl Iterator<Item = (DVec3, [f64; 3])> {
    (0..8).map(|i| {
        let f = [i & 1, i >> 1 & 1, i >> 2 & 1].map(f64::from);
        (DVec3::from_array(f) * 2.0 - DVec3::ONE, f)
    })
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

proptest! {
    #[test]
    fn orthographic_box_fills_the_clip_cube(w in window()) {
        for (ndc, [x, y, z]) in corners() {
            let p = DVec3::new(mix(w.left, w.right, x), mix(w.bottom, w.top, y), -mix(w.near, w.far, z));
            prop_assert!(close(projection::orthographic(&w).project_point3(p), ndc));
        }
    }

    #[test]
    fn frustum_fills_the_clip_cube(w in window()) {
        for (ndc, [x, y, z]) in corners() {
            let d = mix(w.near, w.far, z);
            let s = d / w.near;
            let p = DVec3::new(mix(w.left, w.right, x) * s, mix(w.bottom, w.top, y) * s, -d);
            prop_assert!((projection::frustum(&w).project_point3(p) - ndc).length() < 1e-10);
        }
    }

    #[test]
    fn frustum_is_scaling_perspective_shear(w in window()) {
        let product = projection::scale_to_canonical(&w)
            * projection::normalised_perspective(w.near, w.far)
            * projection::shear_to_axis(&w);
        prop_assert!(close_matrix(product, projection::frustum(&w)));
    }

    #[test]
    fn glam_agrees(w in window(), fov in 0.1..3.0f64, aspect in 0.2..4.0f64) {
        use glam::dcamera::rh::proj::opengl;
        let Window { left, right, bottom, top, near, far } = w;
        prop_assert!(close_matrix(
            projection::frustum(&w),
            opengl::frustum(left, right, bottom, top, near, far)
        ));
        prop_assert!(close_matrix(
            projection::orthographic(&w),
            opengl::orthographic(left, right, bottom, top, near, far)
        ));
        prop_assert!(close_matrix(
            projection::perspective(fov, aspect, near, far),
            opengl::perspective(fov, aspect, near, far)
        ));
    }

    #[test]
    fn perspective_is_the_symmetric_frustum(fov in 0.1..3.0f64, aspect in 0.2..4.0f64, near in 0.1..2.0f64, depth in 0.1..9.0f64) {
        let height = 2.0 * near * (fov / 2.0).tan();
        prop_assert!(close_matrix(
            projection::perspective(fov, aspect, near, near + depth),
            projection::symmetric_frustum(height * aspect, height, near, near + depth)
        ));
    }

    #[test]
    fn infinite_is_the_limit_of_a_far_plane(fov in 0.1..3.0f64, near in 0.1..2.0f64) {
        let far = projection::perspective(fov, 1.5, near, 1e12);
        let infinite = projection::infinite_perspective(fov, 1.5, near);
        prop_assert!((far - infinite).to_cols_array().iter().all(|d| d.abs() < 1e-10));
    }

    #[test]
    fn reversed_depth_runs_from_one_to_zero(w in window(), t in 0.0..1.0f64) {
        let forward = projection::frustum(&w);
        let reversed = projection::reversed_z(forward);
        let p = DVec3::new(0.3, -0.2, -mix(w.near, w.far, t));
        let (f, r) = (forward.project_point3(p), reversed.project_point3(p));
        prop_assert!((r.z - (1.0 - f.z) / 2.0).abs() < 1e-12);
        prop_assert_eq!((r.x, r.y), (f.x, f.y));
    }

    #[test]
    fn oblique_projects_along_its_direction(w in window(), dx in -2.0..2.0f64, dy in -2.0..2.0f64, t in -3.0..3.0f64) {
        let direction = DVec3::new(dx, dy, 1.0);
        let m = projection::oblique(&w, direction);
        let p = DVec3::new(0.4, 0.1, -1.3);
        let (a, b) = (m.project_point3(p), m.project_point3(p + direction * t));
        prop_assert!((a.truncate() - b.truncate()).length() < 1e-9 * (1.0 + a.length()));
        // Depth is that of the orthographic projection.
        prop_assert!((a.z - projection::orthographic(&w).project_point3(p).z).abs() < 1e-12);
    }

    #[test]
    fn one_point_perspective(h in 0.5..9.0f64, x in -3.0..3.0f64, y in -3.0..3.0f64, z in 0.0..9.0f64) {
        let p = projection::one_point(h).project_point3(DVec3::new(x, y, z));
        prop_assert!(close(p, DVec3::new(h * x / (z + h), h * y / (z + h), z / (z + h))));
    }
}

#[test]
fn cavalier_keeps_and_cabinet_halves_depth() {
    let w = Window::centred(2.0, 2.0, -1.0, 1.0);
    for (m, length) in [
        (projection::cavalier(&w, 0.7), 1.0),
        (projection::cabinet(&w, 0.7), 0.5),
    ] {
        let p = m.project_point3(DVec3::NEG_Z);
        assert!((p.truncate().length() - length).abs() < 1e-12);
        assert!((p.y.atan2(p.x) - 0.7).abs() < 1e-12);
    }
}

#[test]
fn near_goes_to_minus_one_and_far_to_one() {
    let m = projection::perspective(1.0, 1.0, 2.0, 7.0);
    assert!((m.project_point3(DVec3::new(0.0, 0.0, -2.0)).z + 1.0).abs() < 1e-12);
    assert!((m.project_point3(DVec3::new(0.0, 0.0, -7.0)).z - 1.0).abs() < 1e-12);
    let infinite = projection::infinite_perspective(1.0, 1.0, 2.0);
    let at_infinity = infinite * DVec4::new(0.0, 0.0, -1.0, 0.0);
    assert_eq!(at_infinity.z / at_infinity.w, 1.0);
}
