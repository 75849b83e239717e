//! Transforms, the view-reference model and clipping against what defines
//! them.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};
use proptest::prelude::*;
use raster::clip::{self, PLANES};
use raster::cohen_sutherland::{Decision, Rectangle, decide};
use raster::transform::{self, Euler, Shear};
use raster::view_reference::{ProjectionType, ViewReference};
use raster::{Camera, Frame, Lens, Viewport, YAxis, look_at};

fn vector(range: f64) -> impl Strategy<Value = DVec3> {
    (-range..range, -range..range, -range..range).prop_map(DVec3::from)
}

fn unit() -> impl Strategy<Value = DVec3> {
    vector(1.0)
        .prop_filter("long enough", |v| v.length() > 0.1)
        .prop_map(DVec3::normalize)
}

fn frame() -> impl Strategy<Value = DMat3> {
    (unit(), 0.0..6.0f64).prop_map(|(axis, angle)| DMat3::from_axis_angle(axis, angle))
}

fn identity(m: DMat4) -> bool {
    (m - DMat4::IDENTITY)
        .to_cols_array()
        .iter()
        .all(|v| v.abs() < 1e-9)
}

proptest! {
    #[test]
    fn rodrigues_is_glams_rotation(axis in unit(), angle in -7.0..7.0f64) {
        let difference = transform::rotation(axis, angle) - DMat4::from_axis_angle(axis, angle);
        prop_assert!(difference.to_cols_array().iter().all(|v| v.abs() < 1e-12));
    }

    #[test]
    fn rotation_between_directions(from in unit(), to in unit(), length in 0.1..9.0f64) {
        let m = transform::rotation_between(from * length, to);
        prop_assert!((m.transform_vector3(from) - to).length() < 1e-9);
        prop_assert!(identity(m * m.transpose()));
        prop_assert!((m.determinant() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn rotation_between_nearly_opposite_directions(from in unit(), tilt in vector(1.0), size in -12.0..-2.0f64) {
        let to = (-from + tilt * 10f64.powf(size)).normalize();
        let m = transform::rotation_between(from, to);
        prop_assert!((m.transform_vector3(from) - to).length() < 1e-9);
        prop_assert!(identity(m * m.transpose()));
        prop_assert!((m.determinant() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn cheap_inverses(offset in vector(9.0), k in -3.0..3.0f64, axes in frame(), factors in vector(3.0)) {
        prop_assume!(factors.abs().min_element() > 0.05);
        prop_assert!(identity(transform::translation(offset) * transform::translation(-offset)));
        for shear in Shear::ALL {
            prop_assert!(identity(transform::shear(shear, k) * transform::shear(shear, -k)));
        }
        prop_assert!(identity(
            transform::scaling_in_frame(axes, factors) * transform::scaling_in_frame(axes, factors.recip())
        ));
        prop_assert!(identity(
            transform::from_frame(axes, offset) * transform::to_frame(axes, offset)
        ));
        let about = transform::scaling_about(offset, factors);
        prop_assert!((about.transform_point3(offset) - offset).length() < 1e-12);
    }

    #[test]
    fn scaling_in_a_frame_scales_its_axes(axes in frame(), factors in vector(3.0)) {
        let m = transform::scaling_in_frame(axes, factors);
        for k in 0..3 {
            let axis = axes.col(k);
            prop_assert!((m.transform_vector3(axis) - axis * factors[k]).length() < 1e-12);
        }
    }

    #[test]
    fn points_move_and_directions_do_not(offset in vector(9.0), p in vector(9.0)) {
        let m = transform::translation(offset);
        prop_assert_eq!(m * transform::point(p), (p + offset).extend(1.0));
        prop_assert_eq!(m * transform::direction(p), p.extend(0.0));
    }

    #[test]
    fn euler_angles_round_trip(heading in -3.1..3.1f64, pitch in -1.57..1.57f64, roll in -3.1..3.1f64) {
        let euler = Euler { heading, pitch, roll };
        let back = Euler::from_matrix(euler.to_matrix());
        prop_assert!((back.heading - heading).abs() < 1e-9 && (back.pitch - pitch).abs() < 1e-9 && (back.roll - roll).abs() < 1e-9, "{back:?}");
    }

    #[test]
    fn gimbal_lock_still_gives_the_rotation(heading in -3.1..3.1f64, roll in -3.1..3.1f64, up in any::<bool>()) {
        let pitch = if up { FRAC_PI_2 } else { -FRAC_PI_2 };
        let m = Euler { heading, pitch, roll }.to_matrix();
        let back = Euler::from_matrix(m);
        prop_assert_eq!(back.roll, 0.0);
        let difference = back.to_matrix() - m;
        prop_assert!(difference.to_cols_array().iter().all(|v| v.abs() < 1e-9));
    }

    /// A normal stays at right angles to the surface, and on its outside.
    #[test]
    fn normal_matrix_keeps_outward_normals_outward(a in vector(2.0), b in vector(2.0), c in vector(2.0)) {
        let m = DMat3::from_cols(a, b, c);
        prop_assume!(m.determinant().abs() > 1e-3);
        let n = transform::normal_matrix(m) * DVec3::Z;
        prop_assert!((m * DVec3::X).dot(n).abs() < 1e-9 && (m * DVec3::Y).dot(n).abs() < 1e-9);
        prop_assert!((m * DVec3::Z).dot(n) > 0.0);
    }

    #[test]
    fn look_at_is_glams(eye in vector(9.0), target in vector(9.0), up in unit()) {
        let view = target - eye;
        prop_assume!(view.length() > 0.1 && view.normalize().cross(up).length() > 0.1);
        let difference = look_at(eye, target, up) - glam::dcamera::rh::view::look_at_mat4(eye, target, up);
        prop_assert!(difference.to_cols_array().iter().all(|v| v.abs() < 1e-9));
        let left = Frame::left_handed(view, up);
        prop_assert!((left.u.cross(left.v) + left.n).length() < 1e-9);
        prop_assert!((left.n - view.normalize()).length() < 1e-9);
    }

    /// A perspective view reference with its window in the view plane shows
    /// the window's corners in the picture's corners.
    #[test]
    fn view_reference_window_fills_the_picture(
        vrp in vector(5.0), vpn in unit(), vup in unit(), prp in vector(1.0), low in -2.0..-0.5f64, high in 0.5..2.0f64, parallel in any::<bool>(),
    ) {
        prop_assume!(vpn.cross(vup).length() > 0.1);
        let reference = ViewReference {
            vrp, vpn, vup,
            prp: DVec3::new(prp.x, prp.y, 4.0),
            window_low: DVec2::new(low, low * 0.5),
            window_high: DVec2::new(high, high * 0.7),
            front: 1.0,
            back: -3.0,
            projection: if parallel { ProjectionType::Parallel } else { ProjectionType::Perspective },
        };
        let view = reference.view().unwrap();
        let frame = Frame::right_handed(-vpn, vup);
        let world = |u: f64, v: f64, n: f64| vrp + frame.u * u + frame.v * v + frame.n * n;
        for (corner, ndc) in [
            (reference.window_low, DVec2::NEG_ONE),
            (reference.window_high, DVec2::ONE),
        ] {
            let clip = view.world_to_clip().project_point3(world(corner.x, corner.y, 0.0));
            prop_assert!((clip.truncate() - ndc).length() < 1e-9);
        }
        // Points along the direction of projection fall together.
        let (p, q) = if parallel {
            let d = reference.direction_of_projection();
            (world(0.1, 0.2, 0.3), world(0.1 + d.x, 0.2 + d.y, 0.3 + d.z))
        } else {
            let (p, e) = (DVec3::new(0.1, 0.2, 0.3), reference.prp);
            let q = p + (p - e) * 0.5;
            (world(p.x, p.y, p.z), world(q.x, q.y, q.z))
        };
        let (p, q) = (view.world_to_clip().project_point3(p), view.world_to_clip().project_point3(q));
        prop_assert!((p.truncate() - q.truncate()).length() < 1e-9);
        // The planes that bound depth.
        let z = |n: f64| view.world_to_clip().project_point3(world(0.0, 0.0, n)).z;
        prop_assert!((z(1.0) + 1.0).abs() < 1e-9 && (z(-3.0) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn unproject_inverts_project(p in vector(1.0), up_axis in any::<bool>(), parallel in any::<bool>()) {
        let lens = if parallel { Lens::Orthographic { height: 3.0 } } else { Lens::DEFAULT };
        let camera = Camera {
            eye: DVec3::new(3.0, -4.0, 2.0), target: DVec3::ZERO, up: DVec3::Z, lens, near: 0.5, far: 20.0,
        };
        let view = camera.view(640, 480).unwrap();
        let mut viewport = Viewport::of_image(640, 480);
        viewport.y_axis = if up_axis { YAxis::Up } else { YAxis::Down };
        let window = viewport.project(&view, p).unwrap();
        prop_assert!((viewport.unproject(&view, window).unwrap() - p).length() < 1e-12);
        let other = Viewport { y_axis: if up_axis { YAxis::Down } else { YAxis::Up }, ..viewport };
        prop_assert!((other.project(&view, p).unwrap().y + window.y - 480.0).abs() < 1e-9);
        let (near, far) = viewport.ray(&view, window.truncate()).unwrap();
        prop_assert!((p - near).cross(far - near).length() < 1e-9);
    }

    /// Against the definition: points of the segment that are inside.
    #[test]
    fn cohen_sutherland_keeps_what_is_inside(
        a in (-3.0..3.0f64, -3.0..3.0f64), b in (-3.0..3.0f64, -3.0..3.0f64),
    ) {
        let (a, b) = (DVec2::from(a), DVec2::from(b));
        let rectangle = Rectangle { low: DVec2::NEG_ONE, high: DVec2::new(1.0, 1.5) };
        let inside = |t: f64| {
            let p = a.lerp(b, t);
            p.cmpge(rectangle.low - 1e-9).all() && p.cmple(rectangle.high + 1e-9).all()
        };
        let parameters: Vec<f64> = (0..=1000).map(|k| f64::from(k) / 1000.0).filter(|&t| inside(t)).collect();
        match rectangle.clip(a, b) {
            None => prop_assert!(parameters.len() <= 2),
            Some((p, q)) => {
                let length = a.distance(b);
                let expected = parameters.last().zip(parameters.first()).map_or(0.0, |(l, f)| l - f);
                prop_assert!((p.distance(q) - expected * length).abs() < 0.003 * length + 1e-9);
                for end in [p, q] {
                    prop_assert_eq!(rectangle.outcode(end), 0);
                    prop_assert!((end - a).perp_dot(b - a).abs() < 1e-9);
                }
            }
        }
    }

    /// Against the definition: sample the triangle, in homogeneous
    /// coordinates and before any division.
    #[test]
    fn clipped_triangles_keep_exactly_what_is_inside(
        corners in proptest::array::uniform3((vector(2.0), -1.0..2.0f64)), u in 0.0..1.0f64, v in 0.0..1.0f64,
    ) {
        let triangle = corners.map(|(p, w)| p.extend(w));
        let (mut polygon, mut scratch) = (Vec::new(), Vec::new());
        clip::clip_triangle(triangle, &mut polygon, &mut scratch);
        prop_assert!(polygon.len() <= 9);
        for vertex in &polygon {
            for plane in PLANES {
                prop_assert!(plane.dot(vertex.position) > -1e-9);
            }
            // The weights say where it came from.
            let w = vertex.weights;
            let from = triangle[0] * w[0] + triangle[1] * w[1] + triangle[2] * w[2];
            prop_assert!((from - vertex.position).abs().max_element() < 1e-9);
        }
        // A sample of the triangle is inside the volume if and only if it is
        // inside the polygon, in the plane of the weights.
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let p: DVec4 = triangle[0] * (1.0 - u - v) + triangle[1] * u + triangle[2] * v;
        let margin = PLANES.iter().map(|plane| plane.dot(p)).fold(f64::INFINITY, f64::min);
        prop_assume!(margin.abs() > 1e-6);
        let at = DVec2::new(u, v);
        let flat: Vec<DVec2> = polygon.iter().map(|c| DVec2::new(c.weights[1], c.weights[2])).collect();
        let within = flat.len() > 2 && (0..flat.len()).all(|k| {
            let (a, b) = (flat[k], flat[(k + 1) % flat.len()]);
            (b - a).perp_dot(at - a) >= -1e-12
        });
        prop_assert_eq!(within, margin > 0.0);
    }
}

#[test]
fn opposite_directions_turn_by_half_a_turn() {
    for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE.normalize()] {
        let m = transform::rotation_between(axis, -axis);
        assert!((m.transform_vector3(axis) + axis).length() < 1e-12);
        assert!((m.determinant() - 1.0).abs() < 1e-12);
        assert!(identity(transform::rotation_between(axis, axis * 5.0)));
    }
    assert!(identity(transform::rotation_between(DVec3::ZERO, DVec3::X)));
    assert!(identity(
        transform::rotation(DVec3::Z, PI) * transform::rotation(DVec3::Z, PI)
    ));
}

#[test]
fn decision_table() {
    let cases = [
        (0b0000, 0b0000, Decision::Accept),
        (0b0001, 0b0101, Decision::Reject),
        (0b1001, 0b1010, Decision::Reject),
        (0b0001, 0b0010, Decision::Cut),
        (0b0101, 0b1010, Decision::Cut),
        (0b0000, 0b1000, Decision::Cut),
    ];
    for (a, b, decision) in cases {
        assert_eq!((decide(a, b), decide(b, a)), (decision, decision));
    }
    let unit = Rectangle {
        low: DVec2::ZERO,
        high: DVec2::ONE,
    };
    // Past a corner: cut twice, then rejected.
    assert_eq!(unit.clip(DVec2::new(-1.0, 0.5), DVec2::new(0.5, 2.5)), None);
    assert_eq!(unit.clip(DVec2::new(f64::NAN, 0.5), DVec2::ONE), None);
    let diagonal = unit.clip(DVec2::new(-1.0, -1.0), DVec2::new(2.0, 2.0));
    assert_eq!(diagonal, Some((DVec2::ZERO, DVec2::ONE)));
}

#[test]
fn integer_depths() {
    use raster::viewport::integer_depth;
    for (bits, z_max) in [(16, 65_535), (24, 16_777_215), (32, u32::MAX)] {
        assert_eq!(integer_depth(0.0, bits), 0);
        assert_eq!(integer_depth(1.0, bits), z_max);
        assert_eq!(integer_depth(7.0, bits), z_max);
        assert_eq!(integer_depth(f64::NAN, bits), z_max);
        assert!(integer_depth(0.5, bits).abs_diff(z_max / 2) <= 1);
    }
}
