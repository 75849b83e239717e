//! The formulas of textbooks with the numbers that they print: the table of
//! the crate's page names the test of each row.

mod common;

use csg::Mesh;
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4, Vec3};
use raster::cohen_sutherland::{Decision, Rectangle, decide};
use raster::hidden_surface::{DepthBuffer, Painter, ScanLine};
use raster::polygon_model::PolygonModel;
use raster::projection::{self, Window};
use raster::scanline::scan_convert;
use raster::shade::{Finish, Incident, Material, phong};
use raster::transform::{self, EulerOrder, GimbalLock, Shear};
use raster::view_reference::{ProjectionType, ViewReference};
use raster::viewport::{depth_in_range, integer_depth};
use raster::{
    Camera, Frame, Image, Lens, Prepared, RenderOptions, Renderer, View, Viewport, YAxis, look_at,
    render, render_reference, wireframe_reference,
};

/// A matrix as it is printed, row by row.
fn rows(rows: [[f64; 4]; 4]) -> DMat4 {
    DMat4::from_cols_array_2d(&rows).transpose()
}

fn close(a: DMat4, b: DMat4) -> bool {
    a.abs_diff_eq(b, 1e-12)
}

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

#[test]
fn row_vectors_take_transposes() {
    let (sin, cos) = 0.7f64.sin_cos();
    let t = DVec3::new(4.0, 3.0, -2.0);
    let printed = [
        (
            transform::translation(t),
            rows([
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
                [4.0, 3.0, -2.0, 1.0],
            ]),
        ),
        (
            transform::rotation(DVec3::Z, 0.7),
            rows([
                [cos, sin, 0.0, 0.0],
                [-sin, cos, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]),
        ),
        (
            transform::rotation(DVec3::X, 0.7),
            rows([
                [1.0, 0.0, 0.0, 0.0],
                [0.0, cos, sin, 0.0],
                [0.0, -sin, cos, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]),
        ),
        (
            transform::rotation(DVec3::Y, 0.7),
            rows([
                [cos, 0.0, -sin, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [sin, 0.0, cos, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]),
        ),
    ];
    let row_times = |v: DVec4, m: DMat4| {
        let columns = [m.x_axis, m.y_axis, m.z_axis, m.w_axis];
        DVec4::from_array(columns.map(|column| v.dot(column)))
    };
    let v = DVec4::new(1.0, 2.0, 3.0, 1.0);
    let (mut by_columns, mut by_rows) = (v, v);
    for (columns, printed) in printed {
        assert!(close(transform::for_row_vectors(columns), printed));
        by_columns = columns * by_columns;
        by_rows = row_times(by_rows, printed);
    }
    assert!(by_columns.abs_diff_eq(by_rows, 1e-12));
}

/// A = T R of the viewing transform: C to the origin, N to z, U to x, V to y;
/// left-handed.
#[test]
fn viewing_from_c_along_n() {
    let (c, d, up) = (
        DVec3::new(1.0, -4.0, 2.0),
        DVec3::new(0.0, 1.0, 0.5),
        DVec3::Z,
    );
    let n = (d - c).normalize();
    let v = (up - n * up.dot(n)).normalize();
    let u = n.cross(v);
    let frame = Frame::left_handed(d - c, up);
    assert!(frame.n.abs_diff_eq(n, 1e-12) && frame.v.abs_diff_eq(v, 1e-12));
    assert!(frame.u.abs_diff_eq(u, 1e-12), "{} {u}", frame.u);
    let a = frame.world_to_eye(c);
    let t = transform::translation(-c);
    let r = DMat4::from_mat3(DMat3::from_cols(u, v, n).transpose());
    assert!(close(a, r * t));
    for (from, to) in [
        (c, DVec3::ZERO),
        (c + n, DVec3::Z),
        (c + u, DVec3::X),
        (c + v, DVec3::Y),
    ] {
        assert!(a.transform_point3(from).abs_diff_eq(to, 1e-12));
    }
}

/// The same picture through a left-handed frame.
#[test]
fn left_handed_frames_give_the_same_picture() {
    let mesh = common::icosphere(DVec3::ZERO, 1.0, 2);
    let (eye, target) = (DVec3::new(3.0, -2.0, 1.5), DVec3::ZERO);
    let lens = projection::perspective(0.8, 1.0, 1.0, 9.0);
    let right = View::new(look_at(eye, target, DVec3::Z), lens).unwrap();
    let frame = Frame::left_handed(target - eye, DVec3::Z);
    let left = View::new(frame.world_to_eye(eye), projection::left_handed(lens)).unwrap();
    let [a, b] = [right, left].map(|view| {
        let mut options = RenderOptions::default();
        options
            .lights
            .retain(|light| !matches!(light, raster::Light::Camera { .. }));
        options.lights.push(raster::Light::Head {
            intensity: Vec3::ONE,
        });
        render(&mesh, &view, 80, 80, &options).unwrap()
    });
    assert_eq!(a, b);
    // Depth grows with z in a left-handed frame.
    let near = projection::left_handed(lens).project_point3(DVec3::new(0.0, 0.0, 1.0));
    assert!((near.z + 1.0).abs() < 1e-12);
}

#[test]
fn look_at_has_the_printed_rows() {
    let (e, t, u) = (
        DVec3::new(3.0, 4.0, 5.0),
        DVec3::new(0.5, 1.0, -1.0),
        DVec3::Y,
    );
    let z = (e - t) / (e - t).length();
    let x = u.cross(z) / u.cross(z).length();
    let y = z.cross(x);
    let printed = rows([
        [x.x, x.y, x.z, -e.dot(x)],
        [y.x, y.y, y.z, -e.dot(y)],
        [z.x, z.y, z.z, -e.dot(z)],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    assert!(close(look_at(e, t, u), printed));
}

#[test]
fn viewport_is_a_matrix() {
    let viewport = Viewport {
        x: 30.0,
        y: 20.0,
        width: 400.0,
        height: 320.0,
        y_axis: YAxis::Up,
    };
    let z_max = f64::from(u32::MAX);
    let printed = rows([
        [200.0, 0.0, 0.0, 200.0 + 30.0],
        [0.0, 160.0, 0.0, 160.0 + 20.0],
        [0.0, 0.0, z_max / 2.0, z_max / 2.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    assert_eq!(viewport.matrix(z_max), printed);
    for y_axis in [YAxis::Up, YAxis::Down] {
        let viewport = Viewport { y_axis, ..viewport };
        let ndc = DVec3::new(-0.3, 0.6, 0.2);
        let found = viewport.matrix(1.0).transform_point3(ndc);
        assert!(found.abs_diff_eq(viewport.from_ndc(ndc), 1e-12));
    }
    assert_eq!(depth_in_range(-1.0, 2.0, 7.0), 2.0);
    assert_eq!(depth_in_range(1.0, 2.0, 7.0), 7.0);
}

/// Integers up to z_max in a buffer: those of the depths that the planes have.
#[test]
fn depths_are_integers_up_to_z_max() {
    let mesh = common::cuboid(DVec3::new(-0.5, -0.5, -0.5), DVec3::new(0.5, 0.5, 0.5));
    let camera = Camera::looking_at(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO)
        .lens(Lens::Orthographic { height: 2.0 })
        .depths(0.5, 4.5);
    let view = camera.view(32, 32).unwrap();
    let mut renderer = Renderer::default();
    let (prepared, options) = (Prepared::new(&mesh), RenderOptions::default());
    renderer
        .draw(&prepared, &view, 32, 32, &options, &mut Image::default())
        .unwrap();
    for bits in [1, 8, 16, 24, 32] {
        let depths = renderer.integer_depth_buffer(bits);
        let z_max = u32::MAX >> (32 - bits);
        // The top at distance 2.5 is in the middle of 0.5..4.5.
        assert_eq!(depths.get(16, 16), Some(integer_depth(0.5, bits)));
        assert_eq!(depths.get(16, 16), Some(z_max.div_ceil(2)));
        assert_eq!(depths.get(0, 0), Some(z_max));
        let file = raster::integer_depth_png(&depths, bits).unwrap();
        let decoder = png::Decoder::new(std::io::Cursor::new(file));
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        let wide = bytes.len() / (32 * 32);
        let number = bytes[..wide]
            .iter()
            .fold(0u32, |n, &b| n << 8 | u32::from(b));
        assert_eq!(number, z_max >> bits.saturating_sub(16), "{bits}");
    }
}

#[test]
fn outcodes_a_to_e() {
    let r = Rectangle {
        low: DVec2::ZERO,
        high: DVec2::ONE,
    };
    let at = |x: f64, y: f64| DVec2::new(x, y);
    // The texts' table: codes of both ends, and, or, what is done.
    let table = [
        ("A", 0b1001, 0b1000, 0b1000, 0b1001, Decision::Reject),
        ("B", 0b0000, 0b0000, 0b0000, 0b0000, Decision::Accept),
        ("C", 0b0001, 0b0000, 0b0000, 0b0001, Decision::Cut),
        ("D", 0b0100, 0b0010, 0b0000, 0b0110, Decision::Cut),
        ("D'", 0b0000, 0b0010, 0b0000, 0b0010, Decision::Cut),
        ("E", 0b0100, 0b0010, 0b0000, 0b0110, Decision::Cut),
        ("E'", 0b0110, 0b0010, 0b0010, 0b0110, Decision::Reject),
    ];
    for (name, a, b, and, or, decision) in table {
        assert_eq!((a & b, a | b, decide(a, b)), (and, or, decision), "{name}");
    }
    // Segments like the drawing's.
    let [a, b, c, d, e] = [
        [at(-0.5, 1.8), at(0.4, 1.2)],
        [at(0.2, 0.7), at(0.6, 0.9)],
        [at(-0.6, 0.5), at(0.4, 0.4)],
        [at(0.5, -0.4), at(1.4, 0.5)],
        [at(0.7, -0.8), at(1.9, 0.4)],
    ];
    let codes = |s: [DVec2; 2]| s.map(|p| r.outcode(p));
    assert_eq!(codes(a), [0b1001, 0b1000]);
    assert_eq!(codes(b), [0, 0]);
    assert_eq!(codes(c), [0b0001, 0]);
    assert_eq!(codes(d), [0b0100, 0b0010]);
    assert_eq!(codes(e), [0b0100, 0b0010]);
    let clip = |[p, q]: [DVec2; 2]| r.clip(p, q);
    assert_eq!(clip(a), None);
    assert_eq!(clip(b), Some((b[0], b[1])));
    let (from, to) = clip(c).unwrap();
    assert!(from.abs_diff_eq(at(0.0, 0.44), 1e-12) && to == c[1]);
    let (from, to) = clip(d).unwrap();
    assert!(from.abs_diff_eq(at(0.9, 0.0), 1e-12) && to.abs_diff_eq(at(1.0, 0.1), 1e-12));
    assert_eq!(clip(e), None);
    // E': its end cut off at the lower line is right of the rectangle.
    assert_eq!(r.outcode(at(1.5, 0.0) - at(0.0, 1e-9)), 0b0110);
}

#[test]
fn homogeneous_coordinates() {
    let (p, q) = (
        DVec4::new(2.0, 4.0, 6.0, 2.0),
        DVec4::new(9.0, 3.0, 0.0, 3.0),
    );
    for factor in [1.0, -2.0, 0.1] {
        let same = transform::cartesian(p * factor).unwrap();
        assert!(same.abs_diff_eq(DVec3::new(1.0, 2.0, 3.0), 1e-12));
    }
    assert_eq!(transform::cartesian(DVec4::new(1.0, 2.0, 3.0, 0.0)), None);
    // w0 P1 - w1 P0 = w0 w1 (p1 - p0), a direction.
    let difference = transform::homogeneous_difference(q, p);
    assert_eq!(difference, DVec4::new(12.0, -6.0, -18.0, 0.0));
    // Scaling by a is dividing w by a.
    let (a, v) = (4.0, DVec4::new(1.0, 2.0, 3.0, 1.0));
    let scaled = transform::cartesian(transform::scaling(DVec3::splat(a)) * v);
    assert_eq!(
        scaled,
        transform::cartesian(DVec4::new(1.0, 2.0, 3.0, 1.0 / a))
    );
    // T(0,3,0) T(4,0,0) = T(4,3,0); positions move, directions do not.
    let t = transform::translation(DVec3::Y * 3.0) * transform::translation(DVec3::X * 4.0);
    assert_eq!(t, transform::translation(DVec3::new(4.0, 3.0, 0.0)));
    assert_eq!(
        t * transform::point(DVec3::ONE),
        DVec4::new(5.0, 4.0, 1.0, 1.0)
    );
    assert_eq!(
        t * transform::direction(DVec3::ONE),
        DVec4::new(1.0, 1.0, 1.0, 0.0)
    );
}

#[test]
fn shears_and_their_inverses() {
    let s = 0.3;
    let printed = |row: usize, column: usize| {
        let mut m = DMat4::IDENTITY.to_cols_array_2d();
        m[column][row] = s;
        DMat4::from_cols_array_2d(&m)
    };
    for (shear, row, column) in [
        (Shear::XByY, 0, 1),
        (Shear::YByX, 1, 0),
        (Shear::XByZ, 0, 2),
        (Shear::ZByX, 2, 0),
        (Shear::YByZ, 1, 2),
        (Shear::ZByY, 2, 1),
    ] {
        assert_eq!(transform::shear(shear, s), printed(row, column));
        let both = transform::shear(shear, s) * transform::shear(shear, -s);
        assert_eq!(both, DMat4::IDENTITY);
    }
}

#[test]
fn rotation_about_l_m_n() {
    let (axis, angle) = (DVec3::new(2.0, -1.0, 2.0) / 3.0, 0.8f64);
    let DVec3 { x: l, y: m, z: n } = axis;
    let (sin, cos) = angle.sin_cos();
    let v = 1.0 - cos;
    let printed = rows([
        [
            l * l + (1.0 - l * l) * cos,
            l * m * v - n * sin,
            l * n * v + m * sin,
            0.0,
        ],
        [
            l * m * v + n * sin,
            m * m + (1.0 - m * m) * cos,
            m * n * v - l * sin,
            0.0,
        ],
        [
            l * n * v - m * sin,
            m * n * v + l * sin,
            n * n + (1.0 - n * n) * cos,
            0.0,
        ],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    let found = transform::rotation(axis, angle);
    assert!(close(found, printed));
    assert!(close(found.transpose(), transform::rotation(axis, -angle)));
    // About any point: T(p) R T(-p).
    let p = DVec3::new(1.0, 2.0, 3.0);
    let about = transform::translation(p) * found * transform::translation(-p);
    assert!(about.transform_point3(p).abs_diff_eq(p, 1e-12));
}

/// M = M_v M_u^T with the frames (u n l) and (v n m).
#[test]
fn rotation_from_u_to_v_and_changes_of_basis() {
    let (u, v) = (
        DVec3::new(1.0, 2.0, -1.0).normalize(),
        DVec3::new(0.3, -0.5, 0.9).normalize(),
    );
    let n = u.cross(v).normalize();
    let frame = |a: DVec3| DMat3::from_cols(a, n, a.cross(u.cross(v)).normalize());
    let m = frame(v) * frame(u).transpose();
    let found = transform::rotation_between(u, v);
    assert!(close(found, DMat4::from_mat3(m)));
    // Scalar products of the axes of two frames.
    let (from, to) = (frame(u), frame(v));
    let change = transform::change_of_basis(from, to);
    for row in 0..3 {
        for column in 0..3 {
            let product = to.col(row).dot(from.col(column));
            assert!((change.col(column)[row] - product).abs() < 1e-12);
        }
    }
    let p = DVec3::new(0.5, -2.0, 1.0);
    assert!((to * (change * p)).abs_diff_eq(from * p, 1e-12));
    // F S F^T scales along the axes of a frame.
    let factors = DVec3::new(2.0, 0.5, 3.0);
    let scaling = transform::scaling_in_frame(from, factors);
    for k in 0..3 {
        let scaled = scaling.transform_vector3(from.col(k));
        assert!(scaled.abs_diff_eq(from.col(k) * factors[k], 1e-12));
    }
}

#[test]
fn euler_transform_has_the_printed_elements() {
    let (h, p, r) = (0.4f64, -0.7f64, 1.9f64);
    let ((sh, ch), (sp, cp), (sr, cr)) = (h.sin_cos(), p.sin_cos(), r.sin_cos());
    let printed = rows([
        [sh * sp * sr + ch * cr, sh * sp * cr - ch * sr, sh * cp, 0.0],
        [cp * sr, cp * cr, -sp, 0.0],
        [ch * sp * sr - sh * cr, ch * sp * cr + sh * sr, ch * cp, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    let e = transform::Euler {
        heading: h,
        pitch: p,
        roll: r,
    };
    assert!(close(DMat4::from_mat3(e.to_matrix()), printed));
    assert!(close(
        DMat4::from_mat3(e.to_matrix().transpose()) * printed,
        DMat4::IDENTITY
    ));
    // At p = pi/2 only h - r is left.
    let half = std::f64::consts::FRAC_PI_2;
    let locked = EulerOrder::Yxz.to_matrix([h, half, r]);
    let (s, c) = (h - r).sin_cos();
    let wanted = rows([
        [c, s, 0.0, 0.0],
        [0.0, 0.0, -1.0, 0.0],
        [-s, c, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    assert!(close(DMat4::from_mat3(locked), wanted));
    let first = EulerOrder::Yxz.from_matrix(locked, GimbalLock::FirstIsZero);
    assert!(
        first[0] == 0.0 && (first[2] - (r - h)).abs() < 1e-7,
        "{first:?}"
    );
    let last = EulerOrder::Yxz.from_matrix(locked, GimbalLock::LastIsZero);
    assert!(
        last[2] == 0.0 && (last[0] - (h - r)).abs() < 1e-7,
        "{last:?}"
    );
}

/// Every order gives its rotation back, locked or not, with either convention.
#[test]
fn euler_angles_in_every_order() {
    let steps = [-3.0, -1.2, 0.0, 0.5, 2.9f64];
    let half = std::f64::consts::FRAC_PI_2;
    for order in EulerOrder::ALL {
        for a in steps {
            for c in steps {
                for b in [-half, -1.0, 0.0, 0.3, 1.5, half, 2.0 * half] {
                    let m = order.to_matrix([a, b, c]);
                    for lock in [GimbalLock::LastIsZero, GimbalLock::FirstIsZero] {
                        let angles = order.from_matrix(m, lock);
                        let again = order.to_matrix(angles);
                        assert!(m.abs_diff_eq(again, 1e-8), "{order:?} {a} {b} {c} {lock:?}");
                    }
                }
            }
        }
    }
}

/// A camera turned by Euler angles is `look_at` along its -Z, Y upwards.
#[test]
fn cameras_turn_by_euler_angles() {
    let eye = DVec3::new(1.0, 2.0, 3.0);
    let e = transform::Euler {
        heading: 0.7,
        pitch: -0.3,
        roll: 0.2,
    }
    .to_matrix();
    let camera = Camera::turned(eye, e, 5.0);
    let inverse = transform::from_frame(e, eye);
    assert!(close(camera.world_to_eye() * inverse, DMat4::IDENTITY));
    assert!(camera.view(64, 48).is_ok());
}

/// y' rotated by r, then moved by d: the array of the exercise.
#[test]
fn opengl_takes_columns() {
    let (r, d) = (0.6f64, 2.5);
    let (s, c) = r.sin_cos();
    let m = transform::translation(DVec3::Y * d) * transform::rotation(DVec3::Y, r);
    let wanted = [
        c, 0.0, -s, 0.0, //
        0.0, 1.0, 0.0, 0.0, //
        s, 0.0, c, 0.0, //
        0.0, d, 0.0, 1.0,
    ];
    for (found, wanted) in transform::opengl_array(m).into_iter().zip(wanted) {
        assert!((found - wanted).abs() < 1e-12);
    }
}

/// Halved along x, a slanted face's normal is not halved with it.
#[test]
fn normals_take_the_adjugate() {
    let m = DMat3::from_diagonal(DVec3::new(0.5, 1.0, 1.0));
    let (along, normal) = (DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0));
    assert!((m * along).dot(m * normal).abs() > 0.5);
    let g = transform::normal_matrix(m);
    assert_eq!((m * along).dot(g * normal), 0.0);
    // The adjugate transposed is the inverse transposed times the determinant.
    let m = DMat3::from_cols(
        DVec3::new(1.0, 2.0, 0.5),
        DVec3::new(0.0, 1.0, 3.0),
        DVec3::new(2.0, 0.1, 1.0),
    );
    let wanted = m.inverse().transpose() * m.determinant();
    assert!(transform::normal_matrix(m).abs_diff_eq(wanted, 1e-12));
}

/// M_c = M_p M_v M_m puts local points where the three do one after another.
#[test]
fn matrices_compose() {
    let model = transform::translation(DVec3::X) * transform::rotation(DVec3::Z, 0.3);
    let camera = Camera::looking_at(DVec3::new(3.0, -5.0, 2.0), DVec3::ZERO).depths(1.0, 20.0);
    let view = camera.view(400, 320).unwrap();
    let p = DVec4::new(0.2, 0.4, -0.3, 1.0);
    let at_once = (view.eye_to_clip() * view.world_to_eye() * model) * p;
    let one_by_one = view.eye_to_clip() * (view.world_to_eye() * (model * p));
    assert!(at_once.abs_diff_eq(one_by_one, 1e-12));
}

/// project, then unproject(x, y, z_object): the point with that z in its own
/// coordinates.
#[test]
fn unprojecting_to_a_plane_of_the_object() {
    let model =
        transform::translation(DVec3::new(0.5, -0.2, 0.1)) * transform::rotation(DVec3::X, 0.4);
    for lens in [Lens::DEFAULT, Lens::Orthographic { height: 4.0 }] {
        let camera = Camera::looking_at(DVec3::new(3.0, -5.0, 2.0), DVec3::ZERO)
            .lens(lens)
            .depths(1.0, 20.0);
        let view = camera.view(400, 320).unwrap();
        let viewport = Viewport::of_image(400, 320);
        for local in [DVec3::new(0.3, 0.4, 0.7), DVec3::new(-1.0, 0.2, -0.6)] {
            let at = viewport
                .project(&view, model.transform_point3(local))
                .unwrap();
            let found = viewport
                .unproject_at_z(&view, model, at.truncate(), local.z)
                .unwrap();
            assert!(found.abs_diff_eq(local, 1e-9), "{found} {local}");
        }
    }
    // In the eye's plane, w = 0: seen nowhere.
    let camera = Camera::looking_at(DVec3::Z * 3.0, DVec3::ZERO);
    let view = camera.view(10, 10).unwrap();
    let viewport = Viewport::of_image(10, 10);
    assert_eq!(viewport.project(&view, DVec3::new(1.0, 0.0, 3.0)), None);
}

/// VRP, VPN, VUP, window, PRP and DOP make the picture that a camera makes.
#[test]
fn view_references_make_pictures() {
    let mesh = common::merge(
        common::icosphere(DVec3::ZERO, 0.8, 3),
        &common::cuboid(DVec3::splat(0.1), DVec3::ONE),
    );
    let (direction, up) = (DVec3::new(-1.0, 1.5, -0.8).normalize(), DVec3::Z);
    let draw = |view: &View| render(&mesh, view, 96, 96, &RenderOptions::default()).unwrap();
    for projection in [ProjectionType::Perspective, ProjectionType::Parallel] {
        let reference = ViewReference {
            vrp: DVec3::ZERO,
            vpn: -direction * 2.0,
            vup: up,
            prp: DVec3::new(0.0, 0.0, 6.0),
            window_low: DVec2::splat(-1.6),
            window_high: DVec2::splat(1.6),
            front: 3.0,
            back: -3.0,
            projection,
        };
        assert_eq!(
            reference.direction_of_projection(),
            DVec3::new(0.0, 0.0, -6.0)
        );
        let lens = match projection {
            ProjectionType::Perspective => Lens::Perspective {
                fov_y: 2.0 * (1.6f64 / 6.0).atan(),
            },
            ProjectionType::Parallel => Lens::Orthographic { height: 3.2 },
        };
        let camera = Camera::looking_at(-direction * 6.0, DVec3::ZERO)
            .lens(lens)
            .depths(3.0, 9.0);
        let [a, b] = [reference.view().unwrap(), camera.view(96, 96).unwrap()].map(|v| draw(&v));
        let pairs = a.pixels.iter().zip(&b.pixels);
        let off = pairs
            .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 2))
            .count();
        assert!(off < 4, "{projection:?}: {off}");
    }
}

/// I = Ka Iamb + Kd Iin (L N) + Ks Iin (R V)^n with the pictures' numbers.
#[test]
fn phong_with_the_printed_coefficients() {
    let color = csg::Color::from_linear([150.0 / 255.0, 1.0, 100.0 / 255.0]);
    let theta = 0.5f32;
    let normal = Vec3::Z;
    let towards = Vec3::new(theta.sin(), 0.0, theta.cos());
    for (ka, kd, ks, n) in [(0.5, 0.5, 0.8, 4.0), (0.5, 0.5, 0.6, 10.0)] {
        let material = Material::new(color, Finish::new(ka, kd, ks, n));
        for alpha in [0.0f32, 0.3, 1.0] {
            let viewer = Vec3::new(-(theta + alpha).sin(), 0.0, (theta + alpha).cos());
            let lights = [
                Incident {
                    towards: Vec3::ZERO,
                    intensity: Vec3::splat(0.4),
                },
                Incident {
                    towards,
                    intensity: Vec3::splat(0.9),
                },
            ];
            let found = phong(&material, &lights, normal, viewer);
            for k in 0..3 {
                let diffuse = color.rgb[k] * (ka * 0.4 + kd * 0.9 * theta.cos());
                let wanted = diffuse + ks * 0.9 * alpha.cos().powf(n);
                assert!((found[k] - wanted).abs() < 1e-5, "{found} {wanted}");
            }
        }
    }
}

/// Values at (60, 60, 0), (60, 60, 0) and (255, 255, 0), and depths, along the
/// edges and then along the row.
#[test]
fn scan_lines_interpolate_linearly() {
    let corner = |x: i32, y: i32| [x * 256, y * 256];
    let corners = [corner(20, 0), corner(0, 40), corner(40, 40)];
    let values = [[255.0, 1.0], [60.0, 3.0], [60.0, 7.0]];
    let mut rows = 0;
    scan_convert(corners, values, 64, 64, |span| {
        let y = f64::from(span.y) + 0.5;
        let edge = |from: f64, to: f64| (to - from) * y / 40.0 + from;
        let (xa, xb) = (edge(20.0, 0.0), edge(20.0, 40.0));
        let (za, zb) = (edge(1.0, 3.0), edge(1.0, 7.0));
        for x in span.start..span.end {
            let centre = f64::from(x) + 0.5;
            let z = (zb - za) * (centre - xa) / (xb - xa) + za;
            let at = |k: usize| span.values[k] + span.step[k] * f64::from(x - span.start);
            assert!((at(0) - edge(255.0, 60.0)).abs() < 1e-9 && (at(1) - z).abs() < 1e-9);
        }
        rows += 1;
    });
    // (The first row's sample is beside the tip.)
    assert_eq!(rows, 39);
}

/// The box of the printed tables.
fn printed_box() -> PolygonModel {
    let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    PolygonModel {
        // v1..v4 above, v5..v8 below, so that f1 = v1 v5 v8 v4 looks along +x.
        vertices: vec![
            v(1.0, 0.0, 1.0),
            v(0.0, 0.0, 1.0),
            v(0.0, 1.0, 1.0),
            v(1.0, 1.0, 1.0),
            v(1.0, 0.0, 0.0),
            v(0.0, 0.0, 0.0),
            v(0.0, 1.0, 0.0),
            v(1.0, 1.0, 0.0),
        ],
        faces: [
            [1, 5, 8, 4],
            [2, 3, 7, 6],
            [1, 2, 6, 5],
            [4, 8, 7, 3],
            [1, 4, 3, 2],
            [5, 6, 7, 8],
        ]
        .iter()
        .map(|face| face.iter().map(|v| v - 1).collect())
        .collect(),
    }
}

#[test]
fn polygon_tables() {
    let model = printed_box();
    assert_eq!(model.edges().len(), 12);
    assert!(model.is_closed());
    // V - E + F = 2.
    assert_eq!(
        model.vertices.len() + model.faces.len(),
        model.edges().len() + 2
    );
    let axes = [
        DVec3::X,
        DVec3::NEG_X,
        DVec3::NEG_Y,
        DVec3::Y,
        DVec3::Z,
        DVec3::NEG_Z,
    ];
    for (face, axis) in axes.into_iter().enumerate() {
        assert!(model.vector_area(face).abs_diff_eq(axis, 1e-12), "{face}");
        // Back-face removal, exact for a convex model.
        let eye = DVec3::new(5.0, -4.0, 0.5);
        let wanted = matches!(face, 0 | 2);
        assert_eq!(model.faces_viewer(face, eye), wanted, "{face}");
    }
    let mesh = model.to_mesh();
    assert_eq!(mesh.triangles.len(), 12);
    assert!((mesh.volume() - 1.0).abs() < 1e-12);
    // Turned round, the face's outside is its inside.
    let mut turned = model.clone();
    turned.faces[0].reverse();
    assert!(!turned.is_closed());
    assert!(turned.vector_area(0).abs_diff_eq(DVec3::NEG_X, 1e-12));
}

/// A prism over a star of ten corners: concave faces are cut into triangles
/// whose areas add up to theirs.
#[test]
fn concave_polygons_become_triangles() {
    let corner = |k: u32, z: f64| {
        let radius = if k.is_multiple_of(2) { 1.0 } else { 0.4 };
        (DVec2::from_angle(f64::from(k) * 0.2 * std::f64::consts::PI) * radius).extend(z)
    };
    let mut model = PolygonModel::default();
    for z in [0.0, 0.5] {
        model.vertices.extend((0..10).map(|k| corner(k, z)));
    }
    model.faces.push((10..20).collect());
    model.faces.push((0..10).rev().collect());
    for k in 0..10 {
        let next = (k + 1) % 10;
        model.faces.push(vec![k, next, next + 10, k + 10]);
    }
    assert!(model.is_closed());
    let mesh = model.to_mesh();
    assert_eq!(mesh.triangles.len(), 2 * 8 + 10 * 2);
    // Ten triangles between neighbours at angle pi/5.
    let area = 10.0 * 0.5 * 0.4 * (0.2 * std::f64::consts::PI).sin();
    assert!((mesh.volume() - 0.5 * area).abs() < 1e-12);
    for face in 0..2 {
        let own = (0..mesh.triangles.len()).filter(|&t| mesh.triangle_surfaces[t] == face);
        let sum: f64 = own
            .map(|t| {
                let [a, b, c] = mesh.corners(t);
                let area = (b - a).cross(c - a).z / 2.0;
                assert!(area * if face == 0 { 1.0 } else { -1.0 } > 0.0);
                area.abs()
            })
            .sum();
        assert!((sum - area).abs() < 1e-12);
    }
}

/// Two plates through each other.
fn crossing_plates() -> (Mesh, View) {
    let plate = |slope: f64| {
        let corner = |x: f64, y: f64| DVec3::new(x, y, slope * x);
        let corners = vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])
    };
    let mesh = common::merge(
        common::colored(plate(0.5), [1.0, 0.0, 0.0]),
        &common::colored(plate(-0.5), [0.0, 1.0, 0.0]),
    );
    let camera = Camera::looking_at(DVec3::Z * 6.0, DVec3::ZERO)
        .lens(Lens::Orthographic { height: 2.2 })
        .depths(1.0, 12.0);
    (mesh, camera.view(64, 64).unwrap())
}

/// Where parts cut each other the painter fails; depth buffers do not, of the
/// whole picture or of a row.
#[test]
fn the_painter_fails_and_depth_buffers_do_not() {
    let (mesh, view) = crossing_plates();
    let options = RenderOptions::default();
    let red_right = |image: &Image| image.get(48, 40).unwrap()[0] > image.get(48, 40).unwrap()[1];
    let green_left = |image: &Image| image.get(16, 40).unwrap()[1] > image.get(16, 40).unwrap()[0];
    let buffered = render_reference(
        &mesh,
        &view,
        64,
        64,
        &options,
        &mut DepthBuffer::new(64 * 64),
    )
    .unwrap();
    let by_rows = render_reference(&mesh, &view, 64, 64, &options, &mut ScanLine::new(64)).unwrap();
    let painted = render_reference(&mesh, &view, 64, 64, &options, &mut Painter).unwrap();
    assert!(red_right(&buffered) && green_left(&buffered));
    assert_eq!(buffered, by_rows);
    assert_ne!(painted, buffered);
}

#[test]
fn scan_line_buffers_draw_what_depth_buffers_draw() {
    let mesh = common::merge(
        common::icosphere(DVec3::new(0.2, 0.0, 0.0), 0.9, 3),
        &common::cuboid(DVec3::splat(-0.7), DVec3::splat(0.5)),
    );
    let camera = Camera::looking_at(DVec3::new(2.0, -3.0, 1.4), DVec3::ZERO);
    let (width, height) = (90, 70);
    let view = camera.view(width, height).unwrap();
    let options = RenderOptions::default();
    let pixels = (width * height) as usize;
    let whole = render_reference(
        &mesh,
        &view,
        width,
        height,
        &options,
        &mut DepthBuffer::new(pixels),
    );
    let rows = render_reference(
        &mesh,
        &view,
        width,
        height,
        &options,
        &mut ScanLine::new(width),
    );
    assert_eq!(whole.unwrap(), rows.unwrap());
}

/// Every pixel that an edge goes through is drawn, nothing elsewhere; edges
/// leave the window and pass behind the eye.
#[test]
fn wireframes_are_clipped() {
    let mesh = common::cuboid(DVec3::splat(-1.0), DVec3::ONE);
    let (ink, paper) = (
        csg::Color::from_srgb([0.0; 3]),
        csg::Color::from_srgb([1.0; 3]),
    );
    for eye in [
        DVec3::new(3.0, -4.0, 2.0),
        DVec3::new(0.5, -1.2, 0.3),
        DVec3::new(0.2, 0.1, 0.3),
    ] {
        let camera = Camera::looking_at(eye, DVec3::new(0.9, 0.9, 0.1)).depths(0.1, 20.0);
        let view = camera.view(64, 48).unwrap();
        let image = wireframe_reference(&mesh, &view, 64, 48, ink, paper).unwrap();
        let viewport = Viewport::of_image(64, 48);
        let mut near = vec![false; 64 * 48];
        for [a, b, c] in &mesh.triangles {
            for (i, j) in [(a, b), (b, c), (c, a)] {
                let [from, to] = [i, j].map(|&v| mesh.positions[v as usize]);
                for k in 0..=40_000 {
                    let p = from.lerp(to, f64::from(k) / 40_000.0);
                    let Some(at) = viewport.project(&view, p).filter(|p| p.z >= 0.0) else {
                        continue;
                    };
                    for (dx, dy) in (0..9).map(|k| (k % 3 - 1, k / 3 - 1)) {
                        let (x, y) = (at.x.floor() as i64 + dx, at.y.floor() as i64 + dy);
                        if (0..64).contains(&x) && (0..48).contains(&y) {
                            near[(y * 64 + x) as usize] = true;
                        }
                    }
                }
            }
        }
        let drawn: Vec<bool> = image.pixels.iter().map(|p| p[0] == 0).collect();
        assert!(drawn.iter().filter(|d| **d).count() > 20, "{eye}");
        assert!(
            drawn
                .iter()
                .zip(&near)
                .all(|(&drawn, &near)| !drawn || near),
            "{eye}"
        );
    }
}
